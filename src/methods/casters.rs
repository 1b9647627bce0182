//! What casts shadows: the surface itself; for the sky, where a scene has many triangles, a coarser one.
//!
//! The sky is many parallel lights, whose maps show all of the scene each. Surface cells alone read them, and a cell holds one
//! radiance: what moves the surface by less than half a cell, or half a texel of a map, is hardly seen in them. Receivers stand off
//! their surface by a little more ([`Casters::lift`]), so that it casts no shadow on itself; nothing else is lit or dark for it than
//! what lies as near to another surface.

use super::Ground;
use super::sky::SKY_SHADOW_SIZE;
use crate::math::simplify::simplified;
use crate::passes::geometry::{CellBudget, Geometry};
use crate::scene::{Part, Scene};
use crate::vk::{Device, Image, Result};
use std::sync::Arc;

/// Opaque triangles from which a coarser surface is made. Of fewer, the texels of the maps take the time.
pub const FEWEST_TO_SIMPLIFY: u32 = 1 << 17;
/// Largest error of a coarser surface, in texels of a map of the sky and in widths of a cell.
const ERROR: f32 = 0.5;
/// A coarser surface is taken if it has no more than this share of the triangles.
const WORTH: f32 = 0.5;

/// What casts shadows.
pub struct Casters {
    /// What stands for the surface; none where that casts its own.
    coarse: Option<CoarseSurface>,
    /// Their corners, each with the triangle across the edge opposite to it.
    pub triangles: Image,
    /// How far they are off the surface that receives; 0: they are that surface.
    pub error: f32,
}

impl Casters {
    /// The surface itself.
    pub fn exact(device: &Arc<Device>, ground: &Ground<'_>) -> Result<Self> {
        let triangles = ground.geometry.linked_triangles(device, &ground.scene.positions)?;
        Ok(Self { coarse: None, triangles, error: 0.0 })
    }

    /// What stands for it.
    pub fn coarse(device: &Arc<Device>, coarse: CoarseSurface) -> Result<Self> {
        let triangles = coarse.geometry.linked_triangles(device, &coarse.scene.positions)?;
        Ok(Self { error: coarse.error, coarse: Some(coarse), triangles })
    }

    /// The surface that casts shadows on `own`.
    pub fn surface<'a>(&'a self, own: &Ground<'a>) -> Ground<'a> {
        match &self.coarse {
            Some(CoarseSurface { scene, geometry, .. }) => Ground { scene, geometry, textures: own.textures },
            None => *own,
        }
    }

    /// How far receivers stand off their surface. Places are off by more than quadrics say, which are means: by the error once,
    /// hills under a sky are 1 % too dark, by 1.5 times that 1 % too bright.
    pub fn lift(&self) -> f32 {
        1.25 * self.error
    }
}

/// A surface that is coarser than the scene's but for what has alpha masks.
pub struct CoarseSurface {
    scene: Scene,
    geometry: Geometry,
    error: f32,
}

impl CoarseSurface {
    /// That of `ground`, if it has few enough triangles to be worth it, and no core: by what lies far away its error would be too large
    /// there.
    pub fn new(device: &Arc<Device>, ground: &Ground<'_>) -> Result<Option<Self>> {
        if ground.geometry.core.is_apart {
            return Ok(None);
        }
        let error = error(ground);
        let scene = coarse(ground.scene, error);
        if scene.triangles.len() as f32 > WORTH * ground.scene.triangles.len() as f32 {
            return Ok(None);
        }
        let geometry = Geometry::new(device, &scene, &CellBudget::even(1), None)?;
        Ok(Some(Self { scene, geometry, error }))
    }

    /// Bytes of the device that one of `scene` takes, at most.
    pub fn most_bytes(scene: &Scene) -> u64 {
        // A triangle's indices, cells and corners with their links; a vertex has some two triangles.
        (scene.triangles.len() as f32 * WORTH) as u64 * (12 + 32 + 48 + 6)
    }
}

fn error(ground: &Ground<'_>) -> f32 {
    let Ground { scene, geometry, .. } = ground;
    let area: f64 = (0..scene.triangles.len() as u32).map(|t| f64::from(scene.area(t))).sum();
    let cell = (area / f64::from(geometry.cell_count)).sqrt() as f32;
    let texel = 2.0 * geometry.radius / SKY_SHADOW_SIZE as f32;
    ERROR * cell.min(texel)
}

/// The opaque triangles of `scene`, simplified, and its masked ones; with no more vertices than these have.
fn coarse(scene: &Scene, error: f32) -> Scene {
    let (masked, opaque): (Vec<&Part>, Vec<&Part>) = scene.parts.iter().partition(|part| scene.is_masked(part));
    let all: Vec<_> = opaque.iter().flat_map(|part| scene.triangles_of(part)).copied().collect();
    let mut triangles = simplified(&scene.positions, &all, error);
    let mut parts: Vec<Part> = Vec::new();
    // Whatever they are made of.
    let material = opaque.first().map_or(0, |part| part.material);
    parts.push(Part { material, first_triangle: 0, triangle_count: triangles.len() as u32 });
    for part in &masked {
        parts.push(Part { first_triangle: triangles.len() as u32, ..**part });
        triangles.extend(scene.triangles_of(part));
    }
    let mut used = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    let mut place = vec![0; scene.positions.len()];
    (0..).zip(&used).for_each(|(at, vertex)| place[*vertex as usize] = at);
    triangles.as_flattened_mut().iter_mut().for_each(|vertex| *vertex = place[*vertex as usize]);
    Scene {
        positions: kept(&scene.positions, &used),
        uvs: scene.uvs.each_ref().map(|set| kept(set, &used)),
        colors: kept(&scene.colors, &used),
        triangles,
        parts,
        materials: scene.materials.clone(),
        ..Scene::default()
    }
}

/// Those entries of a vertex stream; none of one that the scene does not have.
fn kept<T: Copy>(stream: &[T], used: &[u32]) -> Vec<T> {
    if stream.is_empty() { Vec::new() } else { used.iter().map(|vertex| stream[*vertex as usize]).collect() }
}
