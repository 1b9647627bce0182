//! What does not fit into the device's memory is refused before any of it is allocated.

use super::Settings;
use super::plan::{Part, Plan};
use crate::methods::captures::CaptureMode;
use crate::methods::casters::CoarseSurface;
use crate::methods::sky_bytes;
use crate::passes::geometry::{Arrangement, Need, SurfaceSize, needs};
use crate::passes::resolve::BAND;
use crate::passes::slices::Slices;
use crate::scene::Scene;
use crate::vk::Device;

/// Bytes of batches, shadow maps and staging that every scene takes, about.
const FRAME: u64 = 200 << 20;

/// A scene is too large for the device.
#[derive(Debug, thiserror::Error, PartialEq, Eq)]
pub enum TooLarge {
    /// One buffer or image is.
    #[error(
        "the scene's {triangles} triangles need {} for {used_for}, above the {} that this device allows one buffer; cut them \
         to fewer triangles{remedy}",
        size(*.bytes),
        size(*.allowed)
    )]
    One {
        /// Triangles of the scene.
        triangles: usize,
        /// What the buffer is used for.
        used_for: &'static str,
        /// Its size.
        bytes: u64,
        /// The most that the device allows.
        allowed: u64,
        /// What else helps.
        remedy: &'static str,
    },
    /// All together are.
    #[error(
        "the scene's {triangles} triangles and the image need about {} of device memory ({list}), above the {} that this \
         device has; cut them to fewer triangles, or choose a smaller image{remedy}",
        size(*.bytes),
        size(*.has)
    )]
    All {
        /// Triangles of the scene.
        triangles: usize,
        /// Bytes needed, about.
        bytes: u64,
        /// The largest uses.
        list: String,
        /// Bytes of the device.
        has: u64,
        /// What else helps.
        remedy: &'static str,
    },
}

/// Device memory that a frame will take, by use, the largest first: of geometry that was arranged to that `size`, or about
/// ([`SurfaceSize::about`]).
pub fn memory_needs(device: &Device, scene: &Scene, size: &SurfaceSize, plan: &Plan, settings: &Settings) -> Vec<Need> {
    let mut all = needs(device, scene, size, plan.lights());
    if let Some(far) = settings.cache.capture.far(scene.bounds().into()).filter(|_| plan.compute()) {
        let allowed = Slices::most_bytes(device);
        let need = |used_for, bytes| Need { used_for, bytes, largest: bytes, allowed };
        all.extend(Slices::needs(&far.grid).map(|(used_for, bytes)| need(used_for, bytes)));
    }
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let layers: u64 = settings.planes.iter().map(|plane| u64::from(plane.channels())).sum();
    let image = pixels * pixel(plan) + 2 * BAND.min(4 * layers * pixels);
    let textures: u64 = scene.textures.iter().map(|t| t.rgba.len() as u64 * 4 * 4 / 3).sum();
    let casters = if plan.runs(Part::CoarseCasters) { CoarseSurface::most_bytes(scene) } else { 0 };
    let rest = [
        ("textures", textures),
        ("background", sky_bytes(&scene.background)),
        ("the image", image),
        ("coarse casters", casters),
        ("batches", FRAME),
    ];
    // These are many, none of them large beside the device's limits.
    all.extend(rest.map(|(used_for, bytes)| Need { used_for, bytes, largest: 0, allowed: u64::MAX }));
    all.retain(|need| need.bytes > 0);
    all.sort_by_key(|need| std::cmp::Reverse(need.bytes));
    all
}

/// Bytes of a pixel in what has the image's size: position, normals, albedo, depth and emission, direct light and sums of splats.
/// The layers go by way of bands ([`BAND`]).
fn pixel(plan: &Plan) -> u64 {
    let runs = |part| u64::from(plan.runs(part));
    let sums = runs(Part::Splat) + runs(Part::Sky) + (runs(Part::Contrast) | runs(Part::RecordCounts));
    36 + 16 * (runs(Part::Emission) + u64::from(plan.lights()) + sums)
}

/// Checks that what `plan` makes of `scene` fits, its surface of that `size`.
pub fn check(
    device: &Device,
    scene: &Scene,
    size: &SurfaceSize,
    plan: &Plan,
    settings: &Settings,
) -> Result<(), TooLarge> {
    let needs = memory_needs(device, scene, size, plan, settings);
    let triangles = scene.triangles.len();
    let wants_compute = settings.cache.capture.wants_compute();
    let by_passes = if wants_compute { ", or have render passes capture (--capture hemicube)" } else { "" };
    let has_levels = size.tree.is_some_and(|tree| tree.coarse_triangles > 0);
    let leave_out = if has_levels { ", or leave their levels of detail out (--lod-error 0)" } else { by_passes };
    let allowed = |need: &Need| need.allowed.min(device.capabilities.max_allocation);
    if let Some(need) = needs.iter().find(|need| need.largest > allowed(need)) {
        let remedy = match need.used_for {
            "surface radiance" | "surface cells" => ", or their surface to fewer cells (--surface-cells)",
            "capture corners" | "cluster bounds" | "coarse cells" => leave_out,
            "alpha masks" => by_passes,
            _ => "",
        };
        let (used_for, bytes, allowed) = (need.used_for, need.largest, allowed(need));
        return Err(TooLarge::One { triangles, used_for, bytes, allowed, remedy });
    }
    let bytes = needs.iter().map(|need| need.bytes).sum();
    let has = device.capabilities.device_memory;
    if bytes <= has {
        return Ok(());
    }
    Err(TooLarge::All { triangles, bytes, list: largest_of(&needs), has, remedy: leave_out })
}

/// Arranges the surface of `scene` as `plan` says. Where its levels of detail turn out not to fit and nobody asked for compute,
/// without them, which captures in compute still draw sooner than render passes do: the plan says so then, and a warning.
pub(super) fn arrange(
    device: &Device,
    scene: &Scene,
    plan: Plan,
    settings: &Settings,
) -> Result<(Arrangement, Plan, Option<String>), TooLarge> {
    let fits = |size: &SurfaceSize, plan: &Plan| check(device, scene, size, plan, settings);
    fits(&SurfaceSize::least(scene, &plan.surface_cells, plan.detail()), &plan)?;
    let arranged = |plan: &Plan| {
        let arrangement = Arrangement::new(scene, &plan.surface_cells, plan.detail());
        fits(&arrangement.size(), plan).map(|()| arrangement)
    };
    match arranged(&plan) {
        Err(error) if plan.runs(Part::Levels) && settings.cache.capture == CaptureMode::Auto => {
            let why = format!("levels of detail do not fit: {error}");
            let plan = plan.without_levels(&why);
            Ok((arranged(&plan)?, plan, Some(format!("{why}, and captures in compute drew all triangles as they are"))))
        }
        arrangement => Ok((arrangement?, plan, None)),
    }
}

/// The four largest of them in words.
pub fn largest_of(needs: &[Need]) -> String {
    let list: Vec<_> = needs.iter().take(4).map(|need| format!("{} {}", need.used_for, size(need.bytes))).collect();
    list.join(", ")
}

fn size(bytes: u64) -> String {
    if bytes < 10_000_000 { format!("{} kB", bytes / 1000) } else { format!("{} MB", bytes / 1_000_000) }
}
