//! Culling: which clusters each view of each frame sees, as lists of indirect draws.
//!
//! Three dispatches a draw range, whatever the number of frames: bits of the clusters that are seen, counts of their runs, then the
//! draws, one a run. A list holds the draws of one view of as many frames as one indirect draw may make, so that a batch of
//! captures takes one call a view and range where the device allows it.

use super::counter::Counter;
use super::geometry::{CLUSTER, DrawRange, Geometry};
use super::views::Views;
use crate::vk::{
    Binding, Buffer, Commands, ComputePipeline, DescriptorSet, Device, Memory, PipelineLayout, Result, SetLayout,
    Specialisation, barrier, spirv,
};
use bytemuck::{Pod, Zeroable};
use std::sync::Arc;

const DRAW_BYTES: u64 = 20;
/// Clusters of a word of bits.
const WORD: u32 = 32;
/// Words that a workgroup of the lists goes through, where one frame has not more.
const PIECE_WORDS: u32 = 1024;
/// Invocations of a workgroup of `see.comp`.
const THREADS: u32 = 64;
/// Draws of one call on CPU devices: llvmpipe (Mesa 22.3.6) draws nothing of 2¹⁶ and more.
const MOST_DRAWS_ON_CPU: u32 = 1 << 15;

/// A draw range's part of the buffers: `glsl/cull/push.glsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Push {
    frame_count: u32,
    capacity: u32,
    first_cluster: u32,
    clusters: u32,
    words: u32,
    first_word: u32,
    first_triangle: u32,
    end_triangle: u32,
    first_draw: u32,
    draws: u32,
    list_frames: u32,
    piece_frames: u32,
    pieces_of_list: u32,
    first_piece: u32,
    pieces: u32,
    first_list: u32,
    lists: u32,
}

const _: () = assert!(size_of::<Push>() == 68);

/// Words, draws, pieces and lists of all ranges.
#[derive(Clone, Copy, Default)]
struct Sizes {
    words: u32,
    draws: u32,
    pieces: u32,
    lists: u32,
}

/// Indirect draws of one call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct List {
    /// Byte offset of its draws in [`Cull::draws`].
    pub draws: u64,
    /// Byte offset of their number in [`Cull::counts`].
    pub count: u64,
    /// Draws that there is room for.
    pub most: u32,
}

/// The pass.
pub struct Cull {
    see: (ComputePipeline, DescriptorSet),
    count: ComputePipeline,
    write: ComputePipeline,
    lists: DescriptorSet,
    views: u32,
    ranges: Vec<Push>,
    /// Indirect draws, by range, view, frame and cluster.
    pub draws: Buffer,
    /// Number of draws, by range, view and list.
    pub counts: Buffer,
    _buffers: [Buffer; 2],
    _layouts: [SetLayout; 2],
}

/// Runs of clusters that do not touch, at most.
fn most_runs(range: &DrawRange) -> u32 {
    (range.clusters.len() as u32).div_ceil(2)
}

impl Cull {
    /// Bytes of draws that one frame needs.
    pub fn bytes_per_frame(geometry: &Geometry, views: Views) -> u64 {
        let draws: u64 = geometry.ranges.iter().map(|range| u64::from(most_runs(range))).sum();
        u64::from(views.count()) * draws * DRAW_BYTES
    }

    /// Culls for up to `capacity` of `frames`, of which a list holds `list_frames` at most; each triangle that is seen is drawn as `fan` of them, and adds to `drawn`.
    ///
    /// # Errors
    /// Those of the device, as it makes buffers and pipelines.
    pub fn new(
        device: &Arc<Device>,
        geometry: &Geometry,
        frames: &Buffer,
        (views, fan): (Views, u32),
        (capacity, list_frames): (u32, u32),
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let (ranges, sizes) = arrange(device, geometry, views.count(), (capacity, list_frames));
        let buffer = |words: u32| Buffer::new(device, "culled clusters", u64::from(words.max(1)) * 4, Memory::Device);
        let [seen, pieces, counts] = [buffer(sizes.words)?, buffer(sizes.pieces)?, buffer(sizes.lists)?];
        let draws = Buffer::new(device, "indirect draws", u64::from(sizes.draws) * DRAW_BYTES, Memory::Device)?;
        let of_see = [Binding::Storage(frames), Binding::Storage(&geometry.clusters), Binding::Storage(&seen)];
        let of_lists = [
            Binding::Storage(&seen),
            Binding::Storage(&pieces),
            Binding::Storage(&draws),
            Binding::Storage(&counts),
            // Not used where nothing is counted.
            Binding::Storage(drawn.map_or(&seen, Counter::buffer)),
        ];
        let layouts = [SetLayout::of(device, &of_see)?, SetLayout::of(device, &of_lists)?];
        let push = size_of::<Push>() as u32;
        let see_layout = PipelineLayout::new(device, &[&layouts[0]], push)?;
        let list_layout = PipelineLayout::new(device, &[&layouts[1]], push)?;
        let seen_by = Specialisation(vec![views.code()]);
        let clears = u32::from(!device.capabilities.draw_indirect_count);
        let list = |writes: u32| {
            let constants = Specialisation(vec![writes, clears, fan, CLUSTER, u32::from(drawn.is_some())]);
            ComputePipeline::new("cull", &list_layout, spirv!("cull", "list.comp"), &constants)
        };
        Ok(Self {
            see: (
                ComputePipeline::new("cull", &see_layout, spirv!("cull", "see.comp"), &seen_by)?,
                DescriptorSet::new(&layouts[0], &of_see)?,
            ),
            count: list(0)?,
            write: list(1)?,
            lists: DescriptorSet::new(&layouts[1], &of_lists)?,
            views: views.count(),
            ranges,
            draws,
            counts,
            _buffers: [seen, pieces],
            _layouts: layouts,
        })
    }

    /// Writes the draws of the first `frame_count` frames.
    pub fn record(&self, commands: &Commands, frame_count: u32) {
        let (see, seen) = &self.see;
        self.dispatch(commands, (see, seen), frame_count, |range| (frame_count * range.words).div_ceil(THREADS));
        for lists in [&self.count, &self.write] {
            barrier::dispatches(commands);
            let groups = |range: &Push| frame_count.div_ceil(range.list_frames) * range.pieces_of_list;
            self.dispatch(commands, (lists, &self.lists), frame_count, groups);
        }
    }

    /// One dispatch a range, of so many workgroups a view.
    fn dispatch(
        &self,
        commands: &Commands,
        (pipeline, set): (&ComputePipeline, &DescriptorSet),
        frame_count: u32,
        groups: impl Fn(&Push) -> u32,
    ) {
        pipeline.bind(commands, &[set]);
        for range in &self.ranges {
            pipeline.layout.push(commands, &Push { frame_count, ..*range });
            pipeline.dispatch(commands, [groups(range), self.views, 1]);
        }
    }

    /// The lists of a view of a range that hold the draws of the first `frame_count` frames.
    pub fn lists(&self, view: u32, range: u32, frame_count: u32) -> impl Iterator<Item = List> + '_ {
        let range = &self.ranges[range as usize];
        (0..frame_count.div_ceil(range.list_frames)).map(move |list| {
            let frame = list * range.list_frames;
            let first = range.first_draw + (view * range.capacity + frame) * range.draws;
            List {
                draws: u64::from(first) * DRAW_BYTES,
                count: u64::from(range.first_list + view * range.lists + list) * 4,
                most: range.list_frames.min(frame_count - frame) * range.draws,
            }
        })
    }
}

/// Where each range's part of the buffers lies, and how large all parts are.
fn arrange(
    device: &Device,
    geometry: &Geometry,
    views: u32,
    (capacity, list_frames): (u32, u32),
) -> (Vec<Push>, Sizes) {
    let on_device = if device.is_cpu() { MOST_DRAWS_ON_CPU } else { u32::MAX };
    let most = device.capabilities.limits.max_draw_indirect_count.min(on_device);
    let mut sizes = Sizes::default();
    let of = |range: &DrawRange| {
        let words = (range.clusters.len() as u32).div_ceil(WORD);
        let list_frames = (most / most_runs(range)).min(list_frames).clamp(1, capacity);
        let piece_frames = (PIECE_WORDS / words).clamp(1, list_frames);
        let pieces_of_list = list_frames.div_ceil(piece_frames);
        let lists = capacity.div_ceil(list_frames);
        let push = Push {
            frame_count: 0,
            capacity,
            first_cluster: range.clusters.start,
            clusters: range.clusters.len() as u32,
            words,
            first_word: sizes.words,
            first_triangle: range.triangles.start,
            end_triangle: range.triangles.end,
            first_draw: sizes.draws,
            draws: most_runs(range),
            list_frames,
            piece_frames,
            pieces_of_list,
            first_piece: sizes.pieces,
            pieces: lists * pieces_of_list,
            first_list: sizes.lists,
            lists,
        };
        sizes.words += views * capacity * words;
        sizes.draws += views * capacity * push.draws;
        sizes.pieces += views * push.pieces;
        sizes.lists += views * lists;
        push
    };
    (geometry.ranges.iter().map(of).collect(), sizes)
}
