//! The camera as the passes need it.

use crate::methods::captures;
use crate::methods::irradiance_cache::{CacheSettings, Viewpoint};
use crate::passes::clamp_records::Footprint;
use crate::passes::geometry::Geometry;
use crate::passes::place_records::Placement;
use crate::passes::splat::View as SplatView;
use crate::scene::{Camera, Lens, Scene};
use glam::{Mat4, Vec2, Vec3, Vec4};

/// Nearest visible distance relative to the scene's size: as near as depth can be, which is reversed and so loses nothing by it.
const NEAR: f32 = 1.0 / (1_u64 << 40) as f32;

/// Matrices and axes of a view.
pub(super) struct View {
    /// World to Vulkan clip space, reversed depth.
    pub world_to_clip: Mat4,
    /// Eye and 1, or the direction to the viewer and 0.
    pub eye: Vec4,
    /// Direction of sight for (ndc, 1, 1).
    pub clip_to_world_direction: Mat4,
    /// Camera axis and −(axis · eye).
    pub axis: [f32; 4],
    world_to_view: Mat4,
    scale: Vec2,
    perspective: bool,
    size: [u32; 2],
}

impl View {
    pub(super) fn new(scene: &Scene, camera: &Camera, size: [u32; 2]) -> Self {
        let to_world = camera.camera_to_world.as_mat4();
        let world_to_view = camera.camera_to_world.inverse().as_mat4();
        let (right, up, back) = (to_world.x_axis.truncate(), to_world.y_axis.truncate(), to_world.z_axis.truncate());
        let eye = to_world.w_axis.truncate();
        let aspect = size[0] as f32 / size[1] as f32;
        let (perspective, half) = match camera.lens {
            Lens::Perspective { yfov, .. } => (true, (yfov * 0.5).tan() as f32),
            Lens::Orthographic { ymag, .. } => (false, ymag as f32),
        };
        // Vulkan's clip space points down.
        let scale = Vec2::new(1.0 / (half * aspect), -1.0 / half);
        let (low, high) = scene.bounds();
        let radius = (high - low).length() * 0.5;
        let view_to_clip = if perspective {
            reversed_perspective(scale, radius * NEAR)
        } else {
            reversed_parallel(scale, eye.distance((low + high) * 0.5) + radius)
        };
        let rays = if perspective { [right / scale.x, up / scale.y] } else { [Vec3::ZERO; 2] };
        Self {
            world_to_clip: view_to_clip * world_to_view,
            eye: if perspective { eye.extend(1.0) } else { back.extend(0.0) },
            clip_to_world_direction: Mat4::from_cols(
                rays[0].extend(0.0),
                rays[1].extend(0.0),
                (-back).extend(0.0),
                Vec4::ZERO,
            ),
            axis: (-back).extend(back.dot(eye)).to_array(),
            world_to_view,
            scale,
            perspective,
            size,
        }
    }

    /// The view for placing and splatting records.
    pub(super) fn viewpoint(&self, settings: &CacheSettings, geometry: &Geometry) -> Viewpoint {
        let footprint = 2.0 / (self.scale.y.abs() * self.size[1] as f32);
        let forward = Vec3::from_slice(&self.axis[..3]);
        let placement = Placement {
            first: 0,
            count: 0,
            width: self.size[0],
            seed: settings.seed,
            near: geometry.radius * captures::NEAR,
            lift: captures::LIFT,
            scale: 1.0,
            grain: geometry.core.radius * captures::GRAIN,
            core: geometry.core.to_array(),
        };
        let view = SplatView {
            world_to_view: self.world_to_view.to_cols_array(),
            scale: [self.scale.x, self.scale.y, 0.0, f32::from(u8::from(self.perspective))],
            accuracy: settings.accuracy,
            normal_limit: settings.normal_limit,
            share: 1.0,
        };
        let footprint = Footprint {
            eye: if self.perspective { self.eye.to_array() } else { [0.0; 4] },
            forward: forward.extend(footprint).to_array(),
        };
        Viewpoint { placement, view, footprint }
    }
}

/// Depth near/distance: 1 at the near plane, 0 at infinity.
fn reversed_perspective(scale: Vec2, near: f32) -> Mat4 {
    Mat4::from_cols(
        Vec4::new(scale.x, 0.0, 0.0, 0.0),
        Vec4::new(0.0, scale.y, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 0.0, -1.0),
        Vec4::new(0.0, 0.0, near, 0.0),
    )
}

/// Depth 1 at the camera's plane, 0 at `far`.
fn reversed_parallel(scale: Vec2, far: f32) -> Mat4 {
    Mat4::from_cols(
        Vec4::new(scale.x, 0.0, 0.0, 0.0),
        Vec4::new(0.0, scale.y, 0.0, 0.0),
        Vec4::new(0.0, 0.0, 1.0 / far, 0.0),
        Vec4::new(0.0, 0.0, 1.0, 1.0),
    )
}
