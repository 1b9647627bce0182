//! Light gathered at frames: captures of the lit scene, and their projection onto a basis. One composition for whoever
//! wants coefficients: probes in space, vertices, texels.

use super::Ground;
use super::captures::{Captures, CapturesDesc};
use crate::math::capture::{Basis, Projection};
use crate::passes::distances::{Distances, DistancesPass};
use crate::passes::look_up::LookUp;
use crate::passes::project::{Project, Projected};
use crate::vk::gpu_types::Frame;
use crate::vk::pass::{Recorder, Recording};
use crate::vk::{Buffer, Device, Result};
use std::sync::Arc;

/// What is gathered, and how.
#[derive(Clone, Copy, Debug)]
pub struct GatherDesc {
    /// How directions become texels.
    pub projection: Projection,
    /// What radiance is projected onto.
    pub basis: Basis,
    /// Texels a side of a capture: even.
    pub size: u32,
    /// Whether gradients are computed.
    pub gradients: bool,
    /// Whether captures are rasterised in compute.
    pub in_compute: bool,
    /// The farthest distance that counts, where distances by direction are wanted: of captures of the whole sphere.
    pub distances: Option<f32>,
}

/// Captures, and the passes that project them.
pub struct Gather {
    captures: Captures,
    look_up: Option<LookUp>,
    project: Project,
    distances: Option<DistancesPass>,
}

/// What was gathered at a frame.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Gathering {
    /// In the basis.
    pub projected: Projected,
    /// Distances by direction; empty if not asked for.
    pub distances: Vec<Distances>,
}

impl Gather {
    /// Builds what gathers on `ground`, under the `sky` if there is one.
    pub fn new(device: &Arc<Device>, ground: &Ground<'_>, sky: Option<&Buffer>, desc: GatherDesc) -> Result<Self> {
        let GatherDesc { projection, basis, size, gradients, in_compute, distances } = desc;
        let captured = CapturesDesc { projection, far: None, size, lod_error: 0.0, shared: false, may_sum: false };
        let planes = gradients || distances.is_some();
        let captures = Captures::of(device, ground, in_compute, captured, (sky, planes), None)?;
        let table = projection.table(size);
        let gathered = &captures.gathered;
        let look_up = captures
            .by_render()
            .map(|capture| LookUp::new(device, ground.geometry, capture, (projection, &table), gathered, sky))
            .transpose()?;
        let seen = (projection, size, &table);
        let project = Project::new(device, gathered, seen, (basis, gradients), captures.capacity)?;
        let distances = distances
            .map(|farthest| DistancesPass::new(device, gathered, &table, farthest, captures.capacity))
            .transpose()?;
        Ok(Self { captures, look_up, project, distances })
    }

    /// Frames of a batch, at most.
    pub fn capacity(&self) -> usize {
        self.captures.capacity as usize
    }

    /// Gathers at `frames`, [`Self::capacity`] of them at most.
    pub fn run(&self, recorder: &mut Recorder, ground: &Ground<'_>, frames: &[Frame]) -> Result<Vec<Gathering>> {
        self.captures.frames().upload(frames)?;
        recorder.submit(|recording| self.record(recording, ground, frames.len() as u32))?;
        self.captures.check(recorder)?;
        let projected = self.project.read(frames.len());
        let distances = self.distances.as_ref().map(|pass| pass.read(frames.len()));
        let mut distances = distances.unwrap_or_else(|| vec![vec![]; frames.len()]).into_iter();
        let gathering = |projected| Gathering { projected, distances: distances.next().unwrap_or_default() };
        Ok(projected.into_iter().map(gathering).collect())
    }

    fn record(&self, recording: &mut Recording<'_>, ground: &Ground<'_>, count: u32) -> Result<()> {
        self.captures.record(recording, ground, count)?;
        if let Some(look_up) = &self.look_up {
            recording.pass("look_up", |c| {
                look_up.record(c, count);
                Ok(())
            })?;
        }
        recording.pass("project", |c| {
            self.project.record(c, count);
            Ok(())
        })?;
        if let Some(distances) = &self.distances {
            recording.pass("distances", |c| {
                distances.record(c, count);
                Ok(())
            })?;
        }
        recording.pass("readback", |c| {
            self.project.record_readback(c);
            if let Some(distances) = &self.distances {
                distances.record_readback(c);
            }
            Ok(())
        })
    }
}
