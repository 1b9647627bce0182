//! What does not fit into the device's memory is refused before any of it is allocated.

use super::Settings;
use super::plan::Plan;
use crate::passes::geometry::{Need, needs};
use crate::scene::Scene;
use crate::vk::Device;

/// Bytes that a pixel takes in all images and buffers of its size, about: G-buffer, sums, layers and their read-back.
const PIXEL: u64 = 256;
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

/// Checks that what `plan` makes of `scene` fits.
pub fn check(device: &Device, scene: &Scene, plan: &Plan, settings: &Settings) -> Result<(), TooLarge> {
    fits(needs(device, scene, plan.surface_cells, plan.detail(), plan.lights), scene, device, settings)
}

fn fits(mut needs: Vec<Need>, scene: &Scene, device: &Device, settings: &Settings) -> Result<(), TooLarge> {
    let triangles = scene.triangles.len();
    let has_levels = needs.iter().any(|need| need.used_for == "coarse cells");
    let remedy = if has_levels { ", or leave their levels of detail out (--lod-error 0)" } else { "" };
    let allowed = |need: &Need| need.allowed.min(device.capabilities.max_allocation);
    if let Some(need) = needs.iter().find(|need| need.largest > allowed(need)) {
        // Cells have a say of their own, as long as there is more than one a triangle.
        let remedy = match need.used_for {
            "surface radiance" | "surface cells" => ", or their surface to fewer cells (--surface-cells)",
            "capture corners" | "cluster bounds" | "coarse cells" => remedy,
            _ => "",
        };
        let (used_for, bytes, allowed) = (need.used_for, need.largest, allowed(need));
        return Err(TooLarge::One { triangles, used_for, bytes, allowed, remedy });
    }
    let pixels = u64::from(settings.width) * u64::from(settings.height);
    let textures: u64 = scene.textures.iter().map(|t| t.rgba.len() as u64 * 4 * 4 / 3).sum();
    let rest = [("textures", textures), ("the image", pixels * PIXEL), ("batches", FRAME)];
    let rest = rest.map(|(used_for, bytes)| Need { used_for, bytes, largest: bytes, allowed: bytes });
    needs.extend(rest);
    let bytes = needs.iter().map(|need| need.bytes).sum();
    let has = device.capabilities.device_memory;
    if bytes <= has {
        return Ok(());
    }
    needs.sort_by_key(|need| std::cmp::Reverse(need.bytes));
    let list: Vec<_> = needs.iter().take(4).map(|need| format!("{} {}", need.used_for, size(need.bytes))).collect();
    Err(TooLarge::All { triangles, bytes, list: list.join(", "), has, remedy })
}

fn size(bytes: u64) -> String {
    if bytes < 10_000_000 { format!("{} kB", bytes / 1000) } else { format!("{} MB", bytes / 1_000_000) }
}
