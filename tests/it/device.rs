//! A device shared by threads, its time limit, its errors and its forced capabilities.

use crate::common::{look, small};
use glam::DVec3;
use hemicube::passes::resolve::Plane;
use hemicube::renderer::{RenderError, Settings, render};
use hemicube::scene::cornell;
use hemicube::vk::forced::Forced;
use hemicube::vk::pass::Recorder;
use hemicube::vk::{Buffer, Device, DeviceOptions, Error, Instance, Memory, barrier};
use std::sync::Arc;
use std::time::Duration;

fn open(options: DeviceOptions) -> Arc<Device> {
    Device::open(Instance::new(true).expect("Vulkan and its validation"), &options).expect("a device")
}

fn forced(list: &str) -> DeviceOptions {
    DeviceOptions { forced: list.parse().expect("a list"), ..DeviceOptions::default() }
}

#[test]
fn two_threads_share_a_device_and_draw_the_same_bits() {
    let device = open(DeviceOptions::default());
    let scene = cornell();
    let draw = || render(&device, &scene, &scene.cameras[0], &small(32), &mut |_, _, _| {}).expect("a frame").picture;
    let [a, b] = std::thread::scope(|scope| [scope.spawn(draw), scope.spawn(draw)].map(|t| t.join().expect("a frame")));
    assert_eq!(device.instance.validation_messages(), 0);
    for ((name, a), (_, b)) in a.channels.iter().zip(&b.channels) {
        assert!(a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits()), "{name} differs");
    }
}

#[test]
fn a_wait_that_runs_out_names_the_pass_and_hangs_nowhere() {
    let device = open(DeviceOptions { time_limit: Some(Duration::from_nanos(1)), ..DeviceOptions::default() });
    let buffer = Buffer::new(&device, "much", 64 << 20, Memory::Device).expect("a buffer");
    let mut recorder = Recorder::new(&device);
    let error = recorder.submit(|recording| {
        recording.pass("fill much", |c| {
            for word in 0..64 {
                c.fill(&buffer, word);
                barrier::full(c);
            }
            Ok(())
        })
    });
    let Err(Error::TimedOut { content, .. }) = error else { panic!("{error:?}") };
    assert!(content.contains("fill much"), "{content}");
}

#[test]
fn after_an_error_in_a_recording_the_recorder_goes_on() {
    let device = open(DeviceOptions::default());
    let mut recorder = Recorder::new(&device);
    let failed = recorder.submit(|recording| {
        recording.pass("first", |_| Ok(()))?;
        recording.pass("second", |_| Err(Error::NoDevice))
    });
    assert!(matches!(failed, Err(Error::NoDevice)), "{failed:?}");
    recorder.submit(|recording| recording.pass("third", |_| Ok(()))).expect("a submission");
    let names: Vec<_> = recorder.passes.iter().map(|pass| pass.name).collect();
    assert_eq!(names, ["third"], "what failed did not run");
    assert_eq!(device.instance.validation_messages(), 0);
}

/// Passes on the device begin after they were recorded, on one clock with the stages of the CPU.
#[test]
fn all_times_are_of_one_clock() {
    let device = open(DeviceOptions::default());
    let scene = cornell();
    let rendered = render(&device, &scene, &scene.cameras[0], &small(32), &mut |_, _, _| {}).expect("a frame");
    let run = rendered.stages.iter().find(|(name, _)| name == "run passes").expect("a stage").1;
    for pass in &rendered.passes {
        let gpu = pass.gpu.expect("timestamps");
        assert!(gpu.begin_ms >= pass.cpu.begin_ms && gpu.begin_ms >= run.begin_ms, "{pass:?}, {run:?}");
        assert!(gpu.end_ms <= run.end_ms, "{pass:?}, {run:?}");
    }
}

#[test]
fn capabilities_are_forced_within_what_the_device_has() {
    let scene = cornell();
    for list in [
        "primitive_id=on",
        "primitive_id=off,multi_draw_indirect=off",
        "draw_indirect_count=off,logic_op=off,index_uint32=off",
        "subgroup=none,shared_memory=16384,invocations=128",
        "clips_before_setup=off,storage_range=134217728,texel_elements=65536",
    ] {
        let device = open(forced(list));
        let rendered = render(&device, &scene, &scene.cameras[0], &small(32), &mut |_, _, _| {});
        let rendered = rendered.unwrap_or_else(|error| panic!("{list}: {error}"));
        crate::common::check_complete(&rendered);
        assert_eq!(device.instance.validation_messages(), 0, "{list}");
    }
}

#[test]
fn what_cannot_be_forced_is_refused_by_name() {
    let instance = Instance::new(false).expect("Vulkan");
    for (list, word) in [
        ("flying=on", "flying=on"),
        ("primitive_id=maybe", "on or off"),
        ("shared_memory=4294967295", "must be a number up to"),
        ("subgroup=3", "none or a power of two"),
    ] {
        let error = Device::open(instance.clone(), &forced(list)).err().expect(list).to_string();
        assert!(error.contains(word), "{list}: {error}");
    }
    assert!("nothing".parse::<Forced>().is_err());
}

#[test]
fn too_few_storage_buffers_are_refused_by_name() {
    let device = open(forced("storage_buffers=2"));
    let scene = cornell();
    let error = render(&device, &scene, &look(DVec3::X, DVec3::ZERO, 60.0), &small(32), &mut |_, _, _| {});
    let Err(RenderError::Vulkan(Error::Limit { limit, .. })) = error else { panic!("not refused") };
    assert!(limit.contains("maxPerStageDescriptorStorageBuffers"), "{limit}");
}

/// An image of many layers is read band by band: the same bits as in one piece.
#[test]
fn no_limit_of_buffers_holds_for_the_image() {
    let scene = cornell();
    let settings = Settings { planes: Plane::ALL.to_vec(), ..small(96) };
    let draw = |list: &str| {
        let device = open(forced(list));
        let drawn = render(&device, &scene, &scene.cameras[0], &settings, &mut |_, _, _| {});
        let picture = drawn.unwrap_or_else(|error| panic!("{list}: {error}")).picture;
        assert_eq!(device.instance.validation_messages(), 0);
        picture
    };
    // 96 × 96 pixels of 30 values are 1,105,920 bytes; a piece of the kept records is 1,048,576.
    let (whole, bands) = (draw(""), draw("storage_range=1100000"));
    assert_eq!(whole.channels.len(), bands.channels.len());
    for ((name, a), (_, b)) in whole.channels.iter().zip(&bands.channels) {
        assert!(a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits()), "{name} differs");
    }
}

#[test]
fn compiled_pipelines_are_kept_and_torn_files_ignored() {
    let folder = tempfile::tempdir().expect("a folder");
    let options = DeviceOptions { cache_directory: Some(folder.path().into()), ..DeviceOptions::default() };
    let note = || open(options.clone()).pipeline_cache_note().to_owned();
    let first = note();
    assert!(first.contains(" yet"), "{first}");
    let files: Vec<_> =
        std::fs::read_dir(folder.path()).expect("a folder").map(|e| e.expect("a file").path()).collect();
    assert_eq!(files.len(), 1, "one file for the device, and no temporary one: {files:?}");
    assert!(note().contains("kB of"));
    std::fs::write(&files[0], b"torn").expect("written");
    let torn = note();
    assert!(torn.contains("ignored"), "{torn}");
    assert!(note().contains("kB of"), "it is written anew");
}
