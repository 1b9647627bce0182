//! One file a GPU pass; its shaders lie in `glsl/<same name>/`, and its row in the report has the same name.
//!
//! Each pass has one shape: `new` makes pipelines and what only the pass itself needs, `record` writes its commands.
//! Passes are ordered and timed by [`crate::vk::pass::Recording::pass`].

pub mod capture;
pub mod capture_compute;
pub mod clamp_records;
pub mod cluster_tree;
pub mod counter;
pub mod cull;
pub mod distances;
pub mod find_uncovered;
pub mod gathered;
pub mod gbuffer;
pub mod geometry;
pub mod index_records;
pub mod integrate;
pub mod keep_records;
pub mod look_up;
pub mod material;
pub mod pixel_light;
pub mod place_records;
pub mod project;
pub mod read_volume;
pub mod resolve;
pub mod shadow;
pub mod slices;
pub mod splat;
pub mod surface_light;
pub mod views;

use crate::vk::Device;

/// Workgroups that every device takes, at least, along one dimension of a dispatch.
const MOST_GROUPS: u32 = 65535;

/// Workgroups of `size` that cover `count` invocations: a row, or as many rows as are needed (`glsl/inc/invocation.glsl`).
pub(crate) fn groups(count: u32, size: u32) -> [u32; 3] {
    let groups = count.div_ceil(size).max(1);
    [groups.min(MOST_GROUPS), groups.div_ceil(MOST_GROUPS), 1]
}

/// Triangles that one is drawn as in perspective on `device`: more where the vertex stage has to cut it to the view
/// (`FAN` in `glsl/inc/fan.glsl`).
fn fan_on(device: &Device) -> u32 {
    if device.capabilities.clips_before_setup { 1 } else { 5 }
}
