//! Flags that several subcommands share, and their checks.

use anyhow::{Context, Result, ensure};
use clap::Args;
use glam::Vec3;
use hemicube::scene::{self, Background, Camera, Options, Pose, Scene};
use hemicube::vk::{Device, DeviceChoice, Instance};
use std::path::PathBuf;
use std::sync::Arc;

/// The scene and what surrounds it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// Scene to load, .gltf or .glb; without it the built-in Cornell box
    pub scene: Option<PathBuf>,
    /// Radiance from outside the scene: R,G,B (W·sr⁻¹·m⁻²) or an equirectangular map, .exr or .hdr
    ///
    /// FILE.exr#LAYER takes one layer of several. The map's first row is at +Y, its middle is seen along -Z, its right half
    /// towards +X.
    #[arg(long, value_name = "R,G,B|FILE", help_heading = "Scene")]
    pub background: Option<String>,
    /// Turns the background about +Y by so many degrees, counter-clockwise seen from above
    ///
    /// Example: -90 shows the map's middle along +X, as three.js and Blender do.
    #[arg(
        long,
        value_name = "DEG",
        default_value_t = 0.0,
        hide_default_value = true,
        allow_negative_numbers = true,
        help_heading = "Scene"
    )]
    pub background_rotation: f32,
    /// Factor of the background's radiance
    #[arg(long, value_name = "S", default_value_t = 1.0, hide_default_value = true, help_heading = "Scene")]
    pub background_strength: f32,
    /// Light a scene that has no light by a uniform white sky of radiance 1; other scenes stay as they are
    #[arg(long, conflicts_with = "background", help_heading = "Scene")]
    pub default_light: bool,
    /// Camera by name or index; default: the file's first, or one that frames the scene
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Scene")]
    pub camera: Option<String>,
    /// Show the file's animation at this moment, -1e6 to 1e6 s; default: the rest pose, or 0 with --animation
    #[arg(long = "time", alias = "scene-time", value_name = "SECONDS", allow_negative_numbers = true,
        value_parser = moment, help_heading = "Scene")]
    pub scene_time: Option<f64>,
    /// Animation by name or index; default with --time: the file's first
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Scene")]
    pub animation: Option<String>,
}

/// A moment of an animation, in seconds.
fn moment(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds.abs() <= 1e6 => Ok(seconds),
        Ok(_) => Err("a moment of an animation lies within -1e6 to 1e6 seconds".into()),
        Err(_) => Err("not a number of seconds".into()),
    }
}

/// How long to work, in seconds: a billion are 32 years, and a [`std::time::Duration`] holds them.
pub fn parse_seconds(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(seconds) if seconds > 0.0 && seconds <= 1e9 => Ok(seconds),
        Ok(_) => Err("must be above 0, at most 1e9 seconds".into()),
        Err(_) => Err("not a number of seconds".into()),
    }
}

impl SceneArgs {
    /// Loads the scene and its background.
    pub fn load(&self) -> Result<Scene> {
        let mut scene = match &self.scene {
            Some(path) => scene::load_with(path, Options { pose: self.pose(), ..Options::default() })?,
            None => {
                ensure!(
                    self.pose().is_rest(),
                    "the built-in scene has no animations; leave --time and --animation out"
                );
                scene::cornell()
            }
        };
        if let Some(background) = &self.background {
            let (degrees, strength) = (self.background_rotation, self.background_strength);
            anyhow::ensure!(degrees.is_finite(), "--background-rotation {degrees} is not finite");
            let valid = strength.is_finite() && strength >= 0.0;
            anyhow::ensure!(valid, "--background-strength {strength} is negative or not finite");
            scene.background = Background::parse_noting(background, &mut scene.notes)?.adjusted(degrees, strength);
        }
        if self.default_light {
            if scene.is_dark() {
                scene.background = Background::Constant(Vec3::ONE);
                scene.notes.push("the file has no light: lit by a white sky (--default-light)".into());
            } else {
                scene.notes.push("--default-light does nothing: the scene has light".into());
            }
        }
        Ok(scene)
    }

    fn pose(&self) -> Pose {
        Pose { animation: self.animation.clone(), seconds: self.scene_time }
    }

    /// The camera asked for, and a note where one had to be made up.
    pub fn camera(&self, scene: &Scene) -> Result<(Camera, Option<String>)> {
        Ok(scene.camera(self.camera.as_deref())?)
    }
}

/// Size of the image.
#[derive(Args, Clone, Debug)]
pub struct ImageArgs {
    /// Width in pixels; default: from --height and the camera's shape, which alone fits into 1280 × 720
    #[arg(long, value_name = "PIXELS", help_heading = "Image")]
    pub width: Option<u32>,
    /// Height in pixels; default: from --width and the camera's shape
    #[arg(long, value_name = "PIXELS", help_heading = "Image")]
    pub height: Option<u32>,
}

/// The Vulkan device.
#[derive(Args, Clone, Debug)]
pub struct DeviceArgs {
    /// Device by index or a part of its name (see `hemicube info`); default: a discrete GPU before an integrated one before
    /// a CPU
    #[arg(long, value_name = "INDEX|NAME", help_heading = "Device")]
    pub device: Option<String>,
    /// Check every Vulkan call, also synchronisation, and count the messages
    ///
    /// Messages go to the standard error output.
    #[arg(long, help_heading = "Device")]
    pub validate: bool,
}

impl DeviceArgs {
    /// Opens the device.
    pub fn open(&self) -> Result<Arc<Device>> {
        let choice = self.device.clone().map_or(DeviceChoice::Best, DeviceChoice::Named);
        let instance = Instance::new(self.validate)?;
        Ok(Device::new(instance, &choice)?)
    }
}

/// How much is said.
#[derive(Args, Clone, Copy, Debug)]
pub struct TalkArgs {
    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages", conflicts_with = "verbose")]
    pub quiet: bool,
    /// Say more: the plan, what is left out of it and why, all notes on the scene
    #[arg(short, long, help_heading = "Messages")]
    pub verbose: bool,
}

/// Fails before any work if `path` cannot be written: its folder is missing or is not a folder.
pub fn check_output(path: &std::path::Path) -> Result<()> {
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| std::path::Path::new("."));
    let meta = std::fs::metadata(folder).with_context(|| format!("cannot write {}: its folder", path.display()))?;
    anyhow::ensure!(meta.is_dir(), "cannot write {}: {} is not a folder", path.display(), folder.display());
    anyhow::ensure!(!path.is_dir(), "cannot write {}: it is a folder", path.display());
    Ok(())
}
