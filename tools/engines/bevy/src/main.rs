//! Renders white balls in an irradiance volume of `hemicube bake volume --for bevy`, with Bevy and without a window, and compares every
//! pixel with the value that the file asks for. Called by run.sh.
//!
//!   volume-in-bevy VOLUME.ktx2 [PICTURE.png]

mod volume;

use bevy::app::ScheduleRunnerPlugin;
use bevy::asset::UnapprovedPathMode;
use bevy::camera::{Exposure, Hdr, RenderTarget, ScalingMode};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use bevy::render::render_resource::{TextureFormat, TextureUsages};
use bevy::window::ExitCondition;
use std::path::PathBuf;
use volume::Volume;

/// Pixels a side of the picture.
const SIDE: u32 = 512;
/// Largest difference of a pixel, as a share of the mean, that the shared exponents and half floats of the picture may make.
const ALLOWED: f32 = 0.02;

/// What is rendered.
#[derive(Resource)]
struct Job {
    volume: Volume,
    path: PathBuf,
    balls: Vec<Vec3>,
    radius: f32,
    /// Height of what the picture shows.
    extent: f32,
    /// The last pictures from both sides.
    last: [Vec<u8>; 2],
    settled: [bool; 2],
}

/// From which side a picture is taken: 0 or 1.
#[derive(Component)]
struct Side(usize);

fn main() {
    let path = PathBuf::from(std::env::args().nth(1).expect("usage: volume-in-bevy VOLUME.ktx2"));
    let path = path.canonicalize().unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let volume = Volume::read(&path.display().to_string());
    let spacing = volume.scale / volume.counts.as_vec3();
    let radius = 0.4 * spacing.min_element();
    // In the eight parts of the box and in its middle, at samples and between them.
    let parts = (0..8).map(|i| Vec3::new((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2 & 1) as f32) - 0.5);
    let place = |part: Vec3| volume.translation + 0.55 * part * (volume.scale - spacing);
    let balls = parts.map(place).chain([volume.translation]).collect();
    let extent = 1.1 * volume.scale.length();
    let job = Job { volume, path, balls, radius, extent, last: Default::default(), settled: [false; 2] };
    App::new()
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight { brightness: 0.0, ..default() })
        .insert_resource(job)
        .add_plugins(
            DefaultPlugins
                .set(AssetPlugin { unapproved_path_mode: UnapprovedPathMode::Allow, ..default() })
                .set(WindowPlugin { primary_window: None, exit_condition: ExitCondition::DontExit, ..default() }),
        )
        .add_plugins(ScheduleRunnerPlugin::run_loop(std::time::Duration::from_millis(10)))
        .add_systems(Startup, set_up)
        .add_systems(Update, finish)
        .run();
}

/// Direction of sight.
fn sight(side: usize) -> Vec3 {
    Vec3::new(-0.5, -0.6, -0.7).normalize() * if side == 0 { 1.0 } else { -1.0 }
}

fn camera(job: &Job, side: usize) -> Transform {
    let middle = job.volume.translation;
    Transform::from_translation(middle - 2.0 * job.extent * sight(side)).looking_at(middle, Vec3::Y)
}

fn set_up(
    mut commands: Commands,
    job: Res<Job>,
    assets: Res<AssetServer>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut images: ResMut<Assets<Image>>,
) {
    let transform = Transform { translation: job.volume.translation, scale: job.volume.scale, ..default() };
    commands.spawn((
        LightProbe::default(),
        transform,
        IrradianceVolume { voxels: assets.load(job.path.clone()), intensity: 1.0, ..default() },
    ));
    let mesh = meshes.add(Sphere::new(job.radius).mesh().ico(60).expect("few triangles"));
    let white = StandardMaterial { base_color: Color::WHITE, perceptual_roughness: 1.0, reflectance: 0.0, ..default() };
    let material = materials.add(white);
    for ball in &job.balls {
        commands.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), Transform::from_translation(*ball)));
    }
    for side in 0..2 {
        let mut target = Image::new_target_texture(SIDE, SIDE, TextureFormat::Rgba16Float, None);
        target.texture_descriptor.usage |= TextureUsages::COPY_SRC;
        let target = images.add(target);
        let projection = OrthographicProjection {
            scaling_mode: ScalingMode::FixedVertical { viewport_height: job.extent },
            far: 4.0 * job.extent,
            ..OrthographicProjection::default_3d()
        };
        commands.spawn((
            Camera3d::default(),
            Camera { order: side as isize, ..default() },
            RenderTarget::Image(target.clone().into()),
            Projection::Orthographic(projection),
            Hdr,
            Msaa::Off,
            Tonemapping::None,
            // An exposure of 1.
            Exposure { ev100: -(1.2_f32.log2()) },
            camera(&job, side),
        ));
        commands.spawn((Readback::texture(target), Side(side))).observe(keep);
    }
}

/// Keeps a picture; one that comes twice alike and is not black is settled.
fn keep(picture: On<ReadbackComplete>, sides: Query<&Side>, mut job: ResMut<Job>) {
    let Ok(Side(side)) = sides.get(picture.entity) else { return };
    let colour = |pixel: &[u8]| pixel[..6].iter().any(|byte| *byte != 0);
    job.settled[*side] = job.last[*side] == picture.data && picture.data.chunks_exact(8).any(colour);
    job.last[*side] = picture.data.clone();
}

fn finish(job: Res<Job>, mut exits: MessageWriter<AppExit>, mut frames: Local<u32>) {
    *frames += 1;
    if *frames > 3000 {
        eprintln!("no picture after {} frames", *frames);
        exits.write(AppExit::error());
    } else if job.settled == [true; 2] && *frames > 30 {
        let good = (0..2).map(|side| compare(&job, side)).fold(true, |all, good| all && good);
        exits.write(if good { AppExit::Success } else { AppExit::error() });
    }
}

/// Compares a picture with the file, pixel by pixel where a ball is seen, its rim aside.
fn compare(job: &Job, side: usize) -> bool {
    let pose = camera(job, side);
    let (mut worst, mut off, mut sum, mut count) = (0.0_f32, 0.0, 0.0, 0);
    for pixel in 0..(SIDE * SIDE) as usize {
        let at = Vec2::new((pixel as u32 % SIDE) as f32, (pixel as u32 / SIDE) as f32) + 0.5;
        let at = (at / SIDE as f32 - 0.5) * Vec2::new(job.extent, -job.extent);
        let origin = pose.transform_point(at.extend(0.0));
        let Some((position, n)) = nearest(job, origin, sight(side)) else { continue };
        if n.dot(sight(side)) > -0.4 {
            continue;
        }
        let expected = job.volume.radiance(position, n);
        let got = Vec3::from([0, 1, 2].map(|channel| {
            half(u16::from_le_bytes([job.last[side][8 * pixel + 2 * channel], job.last[side][8 * pixel + 2 * channel + 1]]))
        }));
        worst = worst.max((got - expected).abs().max_element());
        off += (got - expected).abs().element_sum();
        sum += expected.element_sum();
        count += 1;
    }
    let mean = sum / (3 * count) as f32;
    println!(
        "side {side}: {count} pixels on balls, mean {mean:.4}; difference {:.2} % in the mean, {:.2} % of the mean at most",
        1e2 * off / sum,
        1e2 * worst / mean
    );
    count > 1000 && off / sum < ALLOWED && worst / mean < 4.0 * ALLOWED
}

/// Position and normal of the nearest ball along a ray.
fn nearest(job: &Job, origin: Vec3, direction: Vec3) -> Option<(Vec3, Vec3)> {
    let hit = |ball: &Vec3| {
        let offset = *ball - origin;
        let along = offset.dot(direction);
        let beside = (offset - along * direction).length_squared();
        (beside < job.radius * job.radius).then(|| (along - (job.radius * job.radius - beside).sqrt(), *ball))
    };
    let (distance, ball) = job.balls.iter().filter_map(hit).min_by(|a, b| a.0.total_cmp(&b.0))?;
    let position = origin + distance * direction;
    Some((position, (position - ball) / job.radius))
}

/// A half float.
fn half(bits: u16) -> f32 {
    let (exponent, mantissa) = (bits >> 10 & 31, f32::from(bits & 1023));
    let sign = if bits >> 15 == 1 { -1.0 } else { 1.0 };
    match exponent {
        0 => sign * mantissa * (-24_f32).exp2(),
        _ => sign * (1.0 + mantissa / 1024.0) * (f32::from(exponent) - 15.0).exp2(),
    }
}
