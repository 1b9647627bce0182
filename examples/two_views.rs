//! Two views of a scene that stays on the device: `cargo run --release --example two_views -- SCENE.gltf`
//!
//! The second view, from a camera a step to the side, uploads nothing and takes the surface as the first one lit it.

use hemicube::renderer::{Renderer, Settings};
use hemicube::scene::{self, Scene};
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = match std::env::args().nth(1) {
        Some(path) => scene::load(Path::new(&path))?,
        None => scene::cornell(),
    };
    let device = Device::new(Instance::new(false)?, &DeviceChoice::Best)?;
    let settings = Settings { width: 256, height: 256, ..Settings::default() };
    let (mut camera, _) = scene.camera(None)?;
    let started = Instant::now();
    let mut renderer = Renderer::open(&device, &scene, &settings, &mut |_stage, _done, _all| {})?;
    println!("open         {:6.2} s", started.elapsed().as_secs_f64());
    for name in ["first view ", "second view"] {
        let started = Instant::now();
        let rendered = renderer.render(&camera, &settings.view(), &mut |_stage, _done, _all| {})?;
        let (records, passes) = (rendered.cache.records, rendered.passes.len());
        println!("{name}  {:6.2} s, {records} records, {passes} passes", started.elapsed().as_secs_f64());
        camera.camera_to_world.w_axis += camera.camera_to_world.x_axis * step(&scene);
    }
    Ok(())
}

/// A hundredth of the scene's diagonal.
fn step(scene: &Scene) -> f64 {
    let (low, high) = scene.bounds();
    f64::from((high - low).length()) / 100.0
}
