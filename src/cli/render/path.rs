//! The camera's way through a sequence of frames.

use crate::cli::common::SceneArgs;
use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use glam::{DMat4, DVec3};
use hemicube::scene::{Camera, Scene, build};
use serde::Deserialize;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Most frames of a run.
const MOST_FRAMES: u32 = 1_000_000;

/// Frames of a sequence, and where the camera is in each.
#[derive(Args, Clone, Debug)]
pub struct PathArgs {
    /// Render frames A to B, a file each
    ///
    /// Frame n shows the file's animation at n / fps seconds, unless --orbit or --walk moves the camera. Records are kept from frame to
    /// frame, as long as nothing but cameras moves. OUT may hold %04d for the frame's number; else it goes before the extension.
    #[arg(long, value_name = "A-B", value_parser = frames, help_heading = "Scene")]
    pub frames: Option<RangeInclusive<u32>>,
    /// Frames a second
    #[arg(
        long,
        value_name = "F",
        default_value_t = 24.0,
        requires = "frames",
        help_heading = "Scene",
        hide_short_help = true
    )]
    pub fps: f64,
    /// Turn the camera by so many degrees in all, over frames A to B, about the vertical axis through the middle of the scene;
    /// 360 is a closed loop
    #[arg(
        long,
        value_name = "DEG",
        requires = "frames",
        conflicts_with = "walk",
        allow_negative_numbers = true,
        help_heading = "Scene",
        hide_short_help = true
    )]
    pub orbit: Option<f64>,
    /// Move the camera along the keys of a JSON file, as in the example below: times in seconds, eye and target in world space,
    /// straight lines between keys, +Y up; the lens stays
    #[arg(long, value_name = "FILE.json", requires = "frames", help_heading = "Scene", hide_short_help = true)]
    pub walk: Option<PathBuf>,
    /// Write the frames to the standard output too, tone-mapped, as YUV4MPEG2, which encoders read; -o may be left out then, and what
    /// is said goes to the standard error output
    #[arg(long, requires = "frames", help_heading = "Scene", hide_short_help = true)]
    pub y4m: bool,
    /// Leave out frames whose file is there already, so that a job that was stopped goes on; with --cache its frames are those of
    /// an unbroken one
    #[arg(long, requires = "frames", conflicts_with = "y4m", help_heading = "Scene", hide_short_help = true)]
    pub resume: bool,
}

/// A range of frames, `A-B` or one number.
fn frames(text: &str) -> Result<RangeInclusive<u32>, String> {
    let number = |text: &str| text.parse::<u32>().map_err(|_| format!("\"{text}\" is not a frame's number"));
    let (first, last) = text.split_once('-').unwrap_or((text, text));
    let (first, last) = (number(first)?, number(last)?);
    if first > last {
        return Err(format!("frame {first} comes after frame {last}: write the smaller one first"));
    }
    if last - first >= MOST_FRAMES {
        return Err(format!("more than {MOST_FRAMES} frames"));
    }
    Ok(first..=last)
}

/// Where the camera is at any frame.
#[derive(Debug)]
pub struct CameraPath {
    /// Frames of the sequence.
    pub frames: RangeInclusive<u32>,
    /// Frames a second.
    pub fps: f64,
    way: Way,
    /// The file's cameras at rest, in the world.
    rest: Vec<Camera>,
}

#[derive(Debug)]
enum Way {
    /// The file's animation.
    Animation,
    /// Degrees about the scene's middle, in all.
    Orbit(f64),
    /// Keys, in the order of their times.
    Walk(Vec<Key>),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Walk {
    keys: Vec<Key>,
}

#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Key {
    time: f64,
    eye: [f64; 3],
    target: [f64; 3],
}

impl CameraPath {
    /// The path that the flags ask for, if they ask for a sequence.
    pub fn new(args: &PathArgs, scene: &SceneArgs) -> Result<Option<Self>> {
        let Some(frames) = args.frames.clone() else { return Ok(None) };
        let fps = args.fps;
        ensure!(fps.is_finite() && fps > 0.0, "--fps {fps} is not a positive number");
        let way = match (args.orbit, &args.walk) {
            (Some(degrees), _) => {
                ensure!(degrees.is_finite(), "--orbit {degrees} is not finite");
                Way::Orbit(degrees)
            }
            (None, Some(file)) => Way::Walk(keys(file)?),
            (None, None) => {
                ensure!(scene.scene_time.is_none(), "--frames sets the moment itself; leave --time out");
                Way::Animation
            }
        };
        Ok(Some(Self { frames, fps, way, rest: Vec::new() }))
    }

    /// The scene as the first frame shows it.
    pub fn load(&mut self, args: &SceneArgs) -> Result<Scene> {
        if !matches!(self.way, Way::Animation) {
            return args.load();
        }
        let nothing = "the scene has no animation to follow: --orbit DEG or --walk FILE.json moves the camera";
        ensure!(args.scene.is_some(), nothing);
        let rest = args.load()?;
        ensure!(!rest.animations.is_empty(), nothing);
        self.rest = moved(rest.cameras, rest.origin);
        Ok(self.at_rest(self.moment(args, *self.frames.start())?))
    }

    /// The same scene with the file's cameras where they rest: surfaces are lit more finely near these, and a frame's light shall not
    /// depend on which one comes first.
    pub fn at_rest(&self, moment: Scene) -> Scene {
        Scene { cameras: moved(self.rest.clone(), -moment.origin), ..moment }
    }

    fn moment(&self, args: &SceneArgs, frame: u32) -> Result<Scene> {
        SceneArgs { scene_time: Some(f64::from(frame) / self.fps), ..args.clone() }.load()
    }

    /// The scene at a frame, where it may differ from that of another one.
    pub fn scene(&self, args: &SceneArgs, frame: u32) -> Result<Option<Scene>> {
        matches!(self.way, Way::Animation).then(|| self.moment(args, frame)).transpose()
    }

    /// The camera of a frame of `scene`, given the scene's own.
    pub fn camera(&self, scene: &Scene, camera: &Camera, frame: u32) -> Result<Camera> {
        let camera_to_world = match &self.way {
            Way::Animation => camera.camera_to_world,
            Way::Orbit(degrees) => {
                let share = f64::from(frame - self.frames.start()) / self.frames.clone().count() as f64;
                turned(scene, camera.camera_to_world, degrees.to_radians() * share)
            }
            Way::Walk(keys) => {
                let [eye, target] = between(keys, f64::from(frame) / self.fps);
                let steep = (target - eye).cross(DVec3::Y).length() <= 1e-9 * (target - eye).length();
                ensure!(!steep, "the walk looks straight up or down, or nowhere, at frame {frame}: move its target");
                build::look(eye - scene.origin, target - scene.origin, 1.0).camera_to_world
            }
        };
        Ok(Camera { camera_to_world, ..camera.clone() })
    }
}

fn moved(mut cameras: Vec<Camera>, by: DVec3) -> Vec<Camera> {
    cameras.iter_mut().for_each(|camera| camera.camera_to_world.w_axis += by.extend(0.0));
    cameras
}

fn turned(scene: &Scene, camera_to_world: DMat4, angle: f64) -> DMat4 {
    let (low, high) = scene.bounds();
    let middle = low.as_dvec3().midpoint(high.as_dvec3());
    DMat4::from_translation(middle) * DMat4::from_rotation_y(angle) * DMat4::from_translation(-middle) * camera_to_world
}

/// Reads and checks the keys of a walk.
fn keys(file: &Path) -> Result<Vec<Key>> {
    let name = file.display();
    let text = std::fs::read_to_string(file).with_context(|| format!("cannot read the walk {name}"))?;
    let Walk { keys } =
        serde_json::from_str(&text).with_context(|| format!("the walk {name} is not as --help says"))?;
    ensure!(!keys.is_empty(), "the walk {name} has no keys");
    for (index, key) in keys.iter().enumerate() {
        let finite = [&[key.time], &key.eye[..], &key.target[..]].concat().iter().all(|x| x.is_finite());
        ensure!(finite, "the walk {name}: key {index} is not finite");
        if index > 0 && keys[index - 1].time >= key.time {
            bail!("the walk {name}: key {index} is not later than the one before");
        }
    }
    Ok(keys)
}

/// Eye and target at a time; before the first key and after the last those hold.
fn between(keys: &[Key], time: f64) -> [DVec3; 2] {
    let after = keys.partition_point(|key| key.time <= time);
    let (a, b) = (&keys[after.saturating_sub(1)], &keys[after.min(keys.len() - 1)]);
    let share = if b.time > a.time { (time - a.time) / (b.time - a.time) } else { 0.0 };
    let point = |a: [f64; 3], b: [f64; 3]| DVec3::from(a).lerp(b.into(), share);
    [point(a.eye, b.eye), point(a.target, b.target)]
}

/// The file of a frame: its number in place of `%d` or `%04d`, or else before the extension, with four digits.
pub fn file_of(output: &Path, frame: u32) -> PathBuf {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    let numbered = name.split_once('%').and_then(|(before, rest)| {
        let (width, after) = rest.split_once('d')?;
        let width = if width.is_empty() { 0 } else { width.parse::<usize>().ok().filter(|width| *width < 20)? };
        Some(format!("{before}{frame:0width$}{after}"))
    });
    output.with_file_name(numbered.unwrap_or_else(|| match name.rsplit_once('.') {
        Some((stem, extension)) => format!("{stem}.{frame:04}.{extension}"),
        None => format!("{name}.{frame:04}"),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_carry_the_number_of_their_frame() {
        let file = |name: &str| file_of(Path::new(name), 7).display().to_string();
        assert_eq!(file("a/b.exr"), "a/b.0007.exr");
        assert_eq!(file("a/b_%03d.png"), "a/b_007.png");
        assert_eq!(file("%d.png"), "7.png");
        assert_eq!(file("100%.png"), "100%.0007.png");
    }

    #[test]
    fn frames_are_a_range() {
        assert_eq!(frames("3-5"), Ok(3..=5));
        assert_eq!(frames("4"), Ok(4..=4));
        assert!(frames("5-3").is_err() && frames("a-b").is_err() && frames("0-4000000").is_err());
    }

    #[test]
    fn a_walk_goes_straight_between_keys_and_holds_beyond_them() {
        let key = |time, x| Key { time, eye: [x, 0.0, 0.0], target: [0.0, 0.0, 1.0] };
        let keys = [key(1.0, 0.0), key(3.0, 4.0)];
        let x = |time| between(&keys, time)[0].x;
        assert_eq!([x(0.0), x(1.0), x(2.0), x(3.0), x(9.0)], [0.0, 0.0, 2.0, 4.0, 4.0]);
    }
}
