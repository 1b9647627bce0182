//! Flags that several subcommands share, and their checks.
#![allow(dead_code)] // removed with the first subcommand

use clap::Args;
use std::path::PathBuf;

/// The scene and what surrounds it.
#[derive(Args, Clone, Debug)]
pub struct SceneArgs {
    /// Scene to load, .gltf or .glb; without it the built-in Cornell box
    pub scene: Option<PathBuf>,
    /// Radiance from outside the scene: R,G,B (W·sr⁻¹·m⁻²) or an equirectangular .exr
    #[arg(long, value_name = "R,G,B|FILE.exr", help_heading = "Scene")]
    pub background: Option<String>,
    /// Camera by name or index; default: the file's first, or one that frames the scene
    #[arg(long, value_name = "NAME|INDEX", help_heading = "Scene")]
    pub camera: Option<String>,
}

/// Size of the image.
#[derive(Args, Clone, Debug)]
pub struct ImageArgs {
    /// Width in pixels; default 1280, or from --height and the camera's shape
    #[arg(long, value_name = "PIXELS", help_heading = "Image")]
    pub width: Option<u32>,
    /// Height in pixels; default 720, or from --width and the camera's shape
    #[arg(long, value_name = "PIXELS", help_heading = "Image")]
    pub height: Option<u32>,
}
