//! How records look at the scene: the capture passes, one interface.

use super::Ground;
use crate::math::adjacency;
use crate::math::capture::Projection;
use crate::math::slices::Grid;
use crate::passes::capture::{Capture, CaptureDesc, FramesBy, pays_to_cull};
use crate::passes::capture_compute::{CaptureCompute, Far, Looks};
use crate::passes::cluster_tree::TreeSize;
use crate::passes::counter::Counter;
use crate::passes::gathered::{Gathered, Kinds};
use crate::passes::geometry::Geometry;
use crate::passes::integrate::{Captured, CapturedBy};
use crate::passes::slices::Slices;
use crate::passes::views::Views;
use crate::scene::Scene;
use crate::vk::pass::{Recorder, Recording};
use crate::vk::{Buffer, Device, Result};
use glam::Vec3;
use std::sync::Arc;

/// Usual aperture of a plane, in degrees: its half width is 2 at distance 1.
pub const PLANE_APERTURE: f64 = 126.87;
/// How far a capture stands off its surface, relative to the size of what is near (`math::core`): a few units in the last place
/// of positions.
pub const LIFT: f32 = 4e-6;
/// Near distance of captures, relative to the scene's size. Reversed depth near/distance keeps its relative precision
/// wherever the near plane is: at 2⁻⁴⁰, far below the last place of any position, no corner of a wall beside a record is
/// cut off.
pub const NEAR: f32 = 1.0 / (1_u64 << 40) as f32;

/// Edge of the cubes of space in which captures have one turn each, relative to the radius of the scene's core: far above the rounding
/// of positions, far below the distance of records.
pub const GRAIN: f32 = 1.0 / (1 << 17) as f32;

/// Memory of a batch's texels.
const BATCH_BYTES: u64 = 64 << 20;

/// How records look at the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum CaptureMode {
    /// Hemicubes: in compute where that fits, else by render passes. CPU devices have one core for vertices, and data-centre GPUs
    /// few units for graphics.
    #[default]
    Auto,
    /// Hemicubes by multi-view render passes.
    Hemicube,
    /// One perspective view along the normal.
    Plane {
        /// Full angle that it sees along each axis, in degrees.
        aperture: f64,
        /// Whether the texels at its border stand for what it does not see.
        compensated: bool,
    },
    /// One view, projected onto the disc below the hemisphere in the vertex stage. Sides of triangles, which are curves
    /// there, are drawn straight: it wants a scene that is cut small ([`Scene::tessellated`]).
    Hemisphere,
    /// Hemicubes in compute where that fits, whatever the device.
    Compute,
    /// The hemisphere's projection in compute where that fits, by the texels' directions: sides of triangles are as they are,
    /// and none are cut.
    ComputeHemisphere,
    /// Hemicubes in compute, of what is near; what is far is seen as slices of voxels (Fournier and Péroche 2005).
    Slices {
        /// Voxels along the scene's longest side.
        across: u32,
        /// How many voxels away triangles are drawn as they are.
        near: f32,
    },
}

/// Usual [`CaptureMode::Slices::across`].
pub const SLICES: u32 = 32;
/// Usual [`CaptureMode::Slices::near`].
pub const SLICES_NEAR: f32 = 8.0;

/// Slices that the scene or the device cannot have.
#[derive(Debug, thiserror::Error)]
#[error("--capture slices: {0}; choose --capture auto, or fewer slices (--slices)")]
pub struct NoSlices(String);

impl CaptureMode {
    /// How directions become texels.
    pub fn projection(self) -> Projection {
        match self {
            Self::Auto | Self::Hemicube | Self::Compute | Self::Slices { .. } => Projection::Hemicube,
            Self::Plane { aperture, compensated } => {
                Projection::Plane { half_width: (aperture / 2.0).to_radians().tan(), compensated }
            }
            Self::Hemisphere | Self::ComputeHemisphere => Projection::Hemisphere,
        }
    }

    /// Why captures of `scene` at `size` texels a side do not run in compute; none if they are to and can.
    pub fn against_compute(self, device: &Device, scene: &Scene, size: u32) -> Option<String> {
        self.against_any_compute(device, scene, size).or_else(|| TreeSize::exact(scene.triangles.len()).misfit(device))
    }

    /// The same, whether or not the device holds the scene's triangles.
    pub fn against_any_compute(self, device: &Device, scene: &Scene, size: u32) -> Option<String> {
        match self {
            Self::Hemicube => Some("hemicubes by render passes are asked for".into()),
            Self::Plane { .. } => Some("planes are captured by render passes".into()),
            Self::Hemisphere => Some("hemispheres are captured by render passes".into()),
            _ => CaptureCompute::misfit(device, scene, self.projection(), size)
                .or_else(|| Slices::misfit(device, &self.far(scene.bounds().into())?.grid)),
        }
    }

    /// Whether it asks for compute whatever the scene's size: then one that the device cannot hold is refused.
    pub fn wants_compute(self) -> bool {
        matches!(self, Self::Compute | Self::ComputeHemisphere)
    }

    /// What is seen as slices in a scene of these bounds, if something is.
    pub fn far(self, bounds: [Vec3; 2]) -> Option<Far> {
        let Self::Slices { across, near } = self else { return None };
        let grid = Grid::of(bounds, across);
        Some(Far { grid, near: near * grid.voxel.max_element() })
    }

    /// Refuses slices that do not fit: nothing else stands for what was asked for.
    pub fn check(self, device: &Device, scene: &Scene, size: u32) -> std::result::Result<(), NoSlices> {
        let Self::Slices { .. } = self else { return Ok(()) };
        self.against_compute(device, scene, size).map_or(Ok(()), |why| Err(NoSlices(why)))
    }
}

/// How captures are made.
#[derive(Clone, Copy, Debug)]
pub struct CaptureSettings {
    /// How they see.
    pub mode: CaptureMode,
    /// Texels a side.
    pub size: u32,
    /// Most that coarse triangles in compute may be wrong by, in texels.
    pub lod_error: f32,
    /// Whether whole workgroups share each view in compute.
    pub shared: bool,
}

/// How captures are made, by any projection.
#[derive(Clone, Copy, Debug)]
pub struct CapturesDesc {
    /// How directions become texels.
    pub projection: Projection,
    /// What is seen as slices of voxels, if something is.
    pub far: Option<Far>,
    /// Texels a side.
    pub size: u32,
    /// Most that coarse triangles in compute may be wrong by, in texels.
    pub lod_error: f32,
    /// Whether whole workgroups share each view in compute.
    pub shared: bool,
    /// Whether the captures are integrated by the cosine ([`crate::passes::integrate`]): some do a part of that by themselves, and
    /// do not keep what every texel sees then. [`crate::passes::project`] wants them to keep it.
    pub may_sum: bool,
}

/// The captures of a batch of records.
pub struct Captures {
    by: By,
    /// What their texels see.
    pub gathered: Gathered,
    /// How directions become texels.
    pub projection: Projection,
    /// Texels a side.
    pub size: u32,
    /// Texels of a record.
    pub texels: u32,
    /// Triangles times views that are drawn of each record without culling; 0 where they are culled, and counted.
    pub drawn_whole: u32,
    /// Records of a batch.
    pub capacity: u32,
    /// Whether outlines are followed over the triangles' edges ([`crate::math::outline`]).
    pub follows_outlines: bool,
}

/// The pass that captures, boxed for their sizes differ.
enum By {
    /// With what outlines are followed by.
    Render(Box<Capture>, Option<Buffer>),
    Compute(Box<CaptureCompute>, Option<Box<Slices>>),
}

impl Captures {
    /// Builds captures; `in_compute` as the plan says. They see the `sky`, if there is one, and keep `planes` for the translation
    /// gradient. What they draw after culling adds to `drawn`, in triangles times views.
    pub fn new(
        device: &Arc<Device>,
        ground: &Ground<'_>,
        in_compute: bool,
        settings: CaptureSettings,
        (sky, planes): (Option<&Buffer>, bool),
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let CaptureSettings { mode, size, lod_error, shared } = settings;
        let far = mode.far(ground.geometry.bounds);
        let desc = CapturesDesc { projection: mode.projection(), far, size, lod_error, shared, may_sum: true };
        Self::of(device, ground, in_compute, desc, (sky, planes), drawn)
    }

    /// The same by any projection.
    pub fn of(
        device: &Arc<Device>,
        ground: &Ground<'_>,
        in_compute: bool,
        desc: CapturesDesc,
        (sky, planes): (Option<&Buffer>, bool),
        drawn: Option<&Counter>,
    ) -> Result<Self> {
        let CapturesDesc { projection, far, size, lod_error, shared, may_sum } = desc;
        let geometry = ground.geometry;
        let views = views(projection);
        let capacity = batch_size(size, views);
        let kinds = Kinds { sky: sky.is_some(), planes };
        if in_compute {
            let tree = geometry.tree.as_ref().expect("geometry was made for captures in compute");
            let looks = Looks::new(projection, size, lod_error).with_slices(far).shared_by_workgroups(shared);
            let looks = if may_sum { looks } else { looks.without_sums() };
            let new_slices = |far: Far| Slices::new(device, (geometry, tree), far.grid);
            let slices = far.map(new_slices).transpose()?;
            let sums = CaptureCompute::sums(device, (geometry, tree), &looks);
            let texels = u64::from(looks.texels());
            let most = match sums {
                Some(sums) => Gathered::most_summed(device, sums, kinds),
                None => Gathered::most_viewed(device, kinds) / texels,
            };
            let capacity = u64::from(capacity).min(most).max(1) as u32;
            let gathered = match sums {
                Some(sums) => Gathered::summed(device, capacity, sums, kinds)?,
                None => Gathered::viewed(device, texels * u64::from(capacity), kinds)?,
            };
            let on = (geometry, tree, slices.as_ref());
            let follows = may_sum && far.is_none() && pays_to_follow(geometry, projection, kinds, looks.texels());
            let across = || adjacency::neighbours(&geometry.triangles, &ground.scene.positions);
            let neighbours = follows.then(|| tree.neighbours(device, &across())).transpose()?;
            let capture = CaptureCompute::new(device, on, neighbours, (&gathered, sky), &looks, capacity, drawn)?;
            return Ok(Self {
                by: By::Compute(Box::new(capture), slices.map(Box::new)),
                gathered,
                projection,
                size,
                texels: looks.texels(),
                drawn_whole: 0,
                capacity,
                follows_outlines: follows,
            });
        }
        let texels = projection.table(size).texels.len() as u32;
        let most = Gathered::most_plain(device, texels, kinds);
        let desc = CaptureDesc {
            name: "capture",
            views,
            size,
            capacity: u64::from(capacity).min(most).max(1) as u32,
            keeps_depth: false,
            culled: pays_to_cull(device, geometry.triangle_count),
            frames: FramesBy::on(device),
        };
        let capture = Capture::counted(device, ground.scene, geometry, ground.textures, desc, drawn)?;
        let capacity = capture.desc.capacity;
        let gathered = Gathered::plain(device, u64::from(texels) * u64::from(capacity), kinds)?;
        let follows = may_sum && pays_to_follow(geometry, projection, kinds, texels);
        let neighbours = follows.then(|| geometry.neighbours(device, &ground.scene.positions)).transpose()?;
        let drawn_whole = if capture.is_culled() { 0 } else { geometry.triangle_count * views.count() };
        Ok(Self {
            by: By::Render(Box::new(capture), neighbours),
            gathered,
            projection,
            size,
            texels,
            drawn_whole,
            capacity,
            follows_outlines: follows,
        })
    }

    /// Frames to look from.
    pub fn frames(&self) -> &Buffer {
        match &self.by {
            By::Render(capture, _) => &capture.frames,
            By::Compute(capture, _) => &capture.frames,
        }
    }

    /// Scale of a frame's axes: 1/half width of a plane.
    pub fn scale(&self) -> f32 {
        match self.projection {
            Projection::Plane { half_width, .. } => half_width.recip() as f32,
            _ => 1.0,
        }
    }

    /// The render passes that capture, if some do.
    pub fn by_render(&self) -> Option<&Capture> {
        match &self.by {
            By::Render(capture, _) => Some(capture),
            By::Compute(..) => None,
        }
    }

    /// What [`crate::passes::integrate`] reads.
    pub fn captured(&self) -> Captured<'_> {
        let by = match &self.by {
            By::Render(capture, neighbours) => CapturedBy::Render(capture, neighbours.as_ref()),
            By::Compute(capture, _) => CapturedBy::Compute(capture),
        };
        Captured { by, gathered: &self.gathered, projection: self.projection, size: self.size }
    }

    /// Makes sure that all that was captured so far is whole.
    pub fn check(&self, recorder: &mut Recorder) -> Result<()> {
        match &self.by {
            By::Compute(capture, _) => capture.check(recorder),
            By::Render(..) => Ok(()),
        }
    }

    /// Makes what captures look up, of the surfaces' light as it is by then. Before the first of them.
    pub fn prepare(&self, recording: &mut Recording<'_>) -> Result<()> {
        let By::Compute(_, Some(slices)) = &self.by else { return Ok(()) };
        recording.pass("slices", |c| {
            slices.record(c);
            Ok(())
        })
    }

    /// Captures the first `count` frames.
    pub fn record(&self, recording: &mut Recording<'_>, ground: &Ground<'_>, count: u32) -> Result<()> {
        match &self.by {
            By::Compute(capture, _) => recording.pass("capture_compute", |c| {
                capture.record(c, count);
                Ok(())
            }),
            By::Render(capture, _) => {
                if capture.is_culled() {
                    recording.pass("cull", |c| {
                        capture.record_cull(c, count);
                        Ok(())
                    })?;
                }
                recording.pass("capture", |c| {
                    capture.record(c, ground.geometry, ground.textures, count);
                    Ok(())
                })
            }
        }
    }
}

/// Whether outlines are followed over the triangles' edges: where these are larger than texels, in the mean. Of smaller ones few
/// are long and thin at once, and pictures show no difference. What errs of a plane is what it does not see; between texels of a
/// hemisphere edges are curves.
fn pays_to_follow(geometry: &Geometry, projection: Projection, kinds: Kinds, texels: u32) -> bool {
    kinds.planes && projection == Projection::Hemicube && geometry.triangle_count <= texels
}

fn views(projection: Projection) -> Views {
    match projection {
        Projection::Hemicube => Views::Hemicube,
        Projection::Plane { .. } => Views::Plane,
        Projection::Hemisphere => Views::Hemisphere,
        Projection::Cube => Views::Cube,
    }
}

/// Frames of a batch: about [`BATCH_BYTES`] of texels with all that goes with them.
fn batch_size(size: u32, views: Views) -> u32 {
    // Identity and depth a view, radiance, the sky's and the plane a texel above the horizon.
    let bytes = match views.count() {
        1 => 8 + 32,
        6 => 6 * (8 + 32),
        count => count * 8 + 3 * 32,
    };
    (BATCH_BYTES as u32 / (size * size * bytes)).clamp(1, 1024)
}
