use super::*;
use crate::passes::geometry::CellBudget;
use crate::vk::{Commands, DeviceChoice, Instance, barrier};

/// A frame at the middle of the built-in Cornell box, looking up, turned a little.
fn frame() -> Frame {
    let (s, c) = 0.3_f32.sin_cos();
    let origin = [0.27, 0.2, 0.25];
    Frame {
        origin: [origin[0], origin[1], origin[2], 1e-6],
        tangent: [c, 0.0, -s, 1.0],
        bitangent: [-s, 0.0, -c, 1.0],
        normal: [0.0, 1.0, 0.0, 1.0],
        horizon: [0.0, 1.0, 0.0, -origin[1]],
    }
}

fn identities(device: &Arc<Device>, geometry: &Geometry, scene: &Scene, culled: bool) -> Vec<u32> {
    identities_by(device, geometry, scene, culled, FramesBy::on(device))
}

fn identities_by(device: &Arc<Device>, geometry: &Geometry, scene: &Scene, culled: bool, frames: FramesBy) -> Vec<u32> {
    let desc = CaptureDesc {
        name: "capture",
        views: Views::Hemicube,
        size: 16,
        capacity: 4,
        keeps_depth: false,
        culled,
        frames,
    };
    let capture = Capture::new(device, scene, geometry, None, desc).unwrap();
    capture.frames.upload(&[frame(); 3]).unwrap();
    let image = &capture.identity;
    let texels = 32 * 32 * 5;
    let readback = Buffer::new(device, "read-back", texels * 4, Memory::Readback).unwrap();
    let commands = Commands::begin(device).unwrap();
    capture.record_cull(&commands, 3);
    barrier::full(&commands);
    capture.record(&commands, geometry, None, 3);
    commands.copy_image(image, vk::ImageLayout::SHADER_READ_ONLY_OPTIMAL, &readback);
    commands.finish().unwrap();
    readback.read(texels as usize)
}

#[test]
fn multi_view_draws_and_culled_views_see_the_same() {
    let device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    let scene = crate::scene::cornell();
    let geometry = Geometry::new(&device, &scene, &CellBudget::even(1000), None).unwrap();
    let whole = identities(&device, &geometry, &scene, false);
    let culled = identities(&device, &geometry, &scene, true);
    for layer in 0..5 {
        let of = |all: &[u32]| all[layer * 1024..(layer + 1) * 1024].to_vec();
        let seen = |all: &[u32]| of(all).iter().filter(|i| **i != 0).count();
        assert!(layer == 3 || seen(&culled) > 3 * 80, "face {layer} sees the box");
    }
    assert!(whole == culled);
    assert_eq!(device.instance.validation_messages(), 0);
}

/// Walls and floor go on behind the eye: every view cuts some. A corner that is made where a side is cut is rounded, so
/// that a texel whose centre is as near to an edge may fall to its other side.
#[test]
fn triangles_cut_to_the_view_look_the_same() {
    let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    let mut scene = crate::scene::cornell();
    for masked in [false, true] {
        scene.materials.iter_mut().for_each(|material| material.alpha_cutoff = masked.then_some(0.5));
        for culled in [false, true] {
            let [whole, fans] = [true, false].map(|clips| {
                Arc::get_mut(&mut device).unwrap().capabilities.clips_before_setup = clips;
                let geometry = Geometry::new(&device, &scene, &CellBudget::even(1000), None).unwrap();
                identities(&device, &geometry, &scene, culled)
            });
            let differ = whole.iter().zip(&fans).filter(|(a, b)| a != b).count();
            assert!(whole.iter().filter(|i| **i != 0).count() > 1000);
            assert!(differ <= 2, "{differ} texels differ; masked: {masked}, culled: {culled}");
        }
    }
    assert_eq!(device.instance.validation_messages(), 0);
}

/// Runs of clusters are listed as one invocation would that walks them in order: for each frame and view the ones that its sphere
/// test passes, whatever the number of frames and however the draws are split into calls.
#[test]
fn culled_draws_are_those_of_a_walk_in_order() {
    let device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    let scene = crate::scene::build::tessellated(&crate::scene::cornell(), 4);
    let geometry = Geometry::new(&device, &scene, &CellBudget::even(1000), None).unwrap();
    assert!(geometry.cluster_count > 64, "more words than one");
    let frames = Buffer::new(&device, "frames", 7 * size_of::<Frame>() as u64, Memory::Device).unwrap();
    frames.upload(&[frame(); 7]).unwrap();
    let cull = Cull::new(&device, &geometry, &frames, (Views::Hemicube, 1), (7, 7), None).unwrap();
    let readback = |buffer: &Buffer, bytes: u64| {
        let read = Buffer::new(&device, "read-back", bytes, Memory::Readback).unwrap();
        let commands = Commands::begin(&device).unwrap();
        cull.record(&commands, 7);
        barrier::full(&commands);
        commands.copy_buffer(buffer, &read, bytes);
        commands.finish().unwrap();
        read.read::<u32>((bytes / 4) as usize)
    };
    let bytes = 7 * Cull::bytes_per_frame(&geometry, Views::Hemicube);
    let (draws, counts) = (readback(&cull.draws, bytes), readback(&cull.counts, 4 * 5));
    let mut triangles = 0;
    for view in 0..5 {
        let lists: Vec<_> = cull.lists(view, 0, 7).collect();
        assert_eq!(lists.len(), 1);
        let (first, count) = (lists[0].draws as usize / 4, counts[lists[0].count as usize / 4] as usize);
        assert!(count > 0 && count % 7 == 0 && count <= lists[0].most as usize);
        let list: Vec<_> = draws[first..first + 5 * count].chunks(5).collect();
        for (i, draw) in list.iter().enumerate() {
            let (frame, cluster) = (draw[4] >> 16, draw[4] & 0xffff);
            assert_eq!((frame, draw[1], draw[2]), ((i / (count / 7)) as u32, 1, 3 * 64 * cluster));
            assert_eq!(draw[0], list[i % (count / 7)][0], "all frames are alike");
            let end = cluster + (draw[0] / 3).div_ceil(64);
            let next = list.get(i + 1).filter(|next| next[4] >> 16 == frame);
            assert!(next.is_none_or(|next| next[4] & 0xffff > end), "runs do not touch");
            triangles += draw[0] / 3;
        }
    }
    assert!(triangles > 0 && triangles < 7 * 5 * geometry.triangle_count);
    assert_eq!(device.instance.validation_messages(), 0);
}

/// What a device lacks changes no texel: no count in a buffer, no triangle's number, no draw to all views.
#[test]
fn forced_capabilities_see_the_same() {
    let mut device = Device::new(Instance::new(true).unwrap(), &DeviceChoice::Best).unwrap();
    let scene = crate::scene::build::tessellated(&crate::scene::cornell(), 2);
    let mut seen = |change: &dyn Fn(&mut crate::vk::Capabilities), culled, by| {
        let before = device.capabilities.clone();
        change(&mut Arc::get_mut(&mut device).unwrap().capabilities);
        let geometry = Geometry::new(&device, &scene, &CellBudget::even(1000), None).unwrap();
        let seen = identities_by(&device, &geometry, &scene, culled, by);
        drop(geometry);
        Arc::get_mut(&mut device).unwrap().capabilities = before;
        seen
    };
    let plain = seen(&|_| (), true, FramesBy::Viewports);
    assert!(plain.iter().filter(|i| **i != 0).count() > 1000);
    // A corner that a clip plane makes is rounded: a centre as near to an edge may fall to its other side.
    let same = |a: &[u32]| plain.iter().zip(a).filter(|(a, b)| a != b).count() <= 4;
    for by in [FramesBy::Viewports, FramesBy::Instances] {
        assert!(same(&seen(&|_| (), true, by)), "{by:?}");
        assert!(same(&seen(&|c| c.draw_indirect_count = false, true, by)), "{by:?}: no count in a buffer");
        assert!(same(&seen(&|c| c.limits.max_draw_indirect_count = 40, true, by)), "{by:?}: many calls");
        assert!(same(&seen(&|c| c.multiview_draws = false, false, by)), "{by:?}: a view at a time");
    }
    assert_eq!(device.instance.validation_messages(), 0);
}
