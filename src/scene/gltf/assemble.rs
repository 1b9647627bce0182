//! From primitives and transforms to the flat scene: places vertices, drops triangles without area, fills streams.

use super::error::{Fault, Kind, Result};
use super::primitive::Primitive;
use super::{Notes, tangents};
use crate::scene::{Material, Part, Scene};
use glam::{DMat3, DMat4, DVec3, Vec2, Vec3, Vec4};

/// A primitive to be placed.
#[derive(Clone, Copy)]
pub struct Draw<'a> {
    pub primitive: &'a Primitive,
    pub to_world: DMat4,
    /// Index into the scene's materials.
    pub material: u32,
    /// Mesh and primitive, for messages.
    pub mesh: usize,
    pub index: usize,
}

/// Streams that some material reads.
#[derive(Default, Clone, Copy)]
pub struct Needs {
    pub tangents: bool,
    pub uvs: [bool; 2],
    pub colors: bool,
}

/// Largest ratio of the distance from zero to half the size at which positions stay relative to zero.
const FAR: f64 = 16.0;

/// The point that positions should be relative to: the centre of the bounding box where that lies far from zero, else
/// zero. Scaling the world by a power of two scales it exactly.
pub fn origin(draws: &[Draw<'_>]) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for draw in draws {
        for p in &draw.primitive.positions {
            let p = place(draw, p);
            (low, high) = (low.min(p), high.max(p));
        }
    }
    far_centre(low, high)
}

/// The centre of a box that lies far from zero compared with its size, else zero.
pub fn far_centre(low: DVec3, high: DVec3) -> DVec3 {
    let (centre, half) = (0.5 * low + 0.5 * high, 0.5 * high - 0.5 * low);
    let far = centre.is_finite() && centre.abs().max_element() > FAR * half.max_element();
    if far { centre } else { DVec3::ZERO }
}

fn place(draw: &Draw<'_>, position: &[f32; 3]) -> DVec3 {
    draw.to_world.transform_point3(DVec3::from(position.map(f64::from)))
}

/// Appends a primitive's triangles to the scene.
pub fn append(scene: &mut Scene, draw: &Draw<'_>, needs: Needs, notes: &mut Notes) -> Result<()> {
    let mut piece = Piece::new(draw, scene, notes)?;
    let material = &scene.materials[draw.material as usize];
    if piece.triangles.is_empty() {
        return Ok(());
    }
    piece.fill(draw, material, needs, notes);
    if scene.positions.len() + piece.positions.len() > u32::MAX as usize {
        return Err(Fault::new(Kind::TooLarge, "the scene has more than 2³² vertices"));
    }
    push(scene, draw.material, piece);
    Ok(())
}

/// A primitive in the world, before it joins the others.
#[derive(Default)]
pub struct Piece {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    pub tangents: Vec<Vec4>,
    pub uvs: [Vec<Vec2>; 2],
    pub colors: Vec<Vec4>,
    pub triangles: Vec<[u32; 3]>,
    /// For each vertex the primitive's vertex that it comes from.
    source: Vec<u32>,
}

impl Piece {
    /// Positions, normals and the triangles that have area, front sides kept.
    fn new(draw: &Draw<'_>, scene: &Scene, notes: &mut Notes) -> Result<Self> {
        let p = draw.primitive;
        let mut piece = Self { source: (0..p.positions.len() as u32).collect(), ..Self::default() };
        for position in &p.positions {
            let position = (place(draw, position) - scene.origin).as_vec3();
            if !position.is_finite() {
                return Err(Fault::invalid("its place in the world is beyond single precision"));
            }
            piece.positions.push(position);
        }
        let linear = linear(draw.to_world);
        let mirrored = linear.determinant() < 0.0;
        let flip = |t: &[u32; 3]| if mirrored { [t[0], t[2], t[1]] } else { *t };
        piece.triangles = p.triangles.iter().map(flip).filter(|t| normal(&piece.positions, t).is_some()).collect();
        notes.add_times_if("triangles without area are left out", p.triangles.len() - piece.triangles.len());
        if p.normals.is_empty() {
            piece.flatten();
        } else {
            piece.transform_normals(&p.normals, linear, notes);
        }
        Ok(piece)
    }

    /// Gives each triangle its own three vertices and its own normal.
    fn flatten(&mut self) {
        let corners: Vec<u32> = self.triangles.as_flattened().to_vec();
        let face = |t: &[u32; 3]| [normal(&self.positions, t).unwrap_or(DVec3::Z).as_vec3(); 3];
        self.normals = self.triangles.iter().flat_map(face).collect();
        self.positions = corners.iter().map(|v| self.positions[*v as usize]).collect();
        self.triangles = (0..corners.len() as u32 / 3).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        self.source = corners;
    }

    /// Normals by the inverse transpose, up to a positive factor; missing ones from the triangles around.
    fn transform_normals(&mut self, normals: &[[f32; 3]], linear: DMat3, notes: &mut Notes) {
        let cofactors = cofactors(linear);
        let to_world = |n: &[f32; 3]| unit(cofactors * unit(DVec3::from(n.map(f64::from)))?);
        let mapped: Vec<Option<DVec3>> = normals.iter().map(to_world).collect();
        let missing = mapped.iter().filter(|n| n.is_none()).count();
        notes.add_times_if("normals that are zero or not finite are replaced by the triangles'", missing);
        let mut around = vec![DVec3::ZERO; if missing > 0 { mapped.len() } else { 0 }];
        if missing > 0 {
            for t in &self.triangles {
                let n = normal(&self.positions, t).unwrap_or(DVec3::ZERO);
                t.iter().for_each(|v| around[*v as usize] += n);
            }
        }
        let either = |(i, n): (usize, &Option<DVec3>)| n.or_else(|| unit(around[i])).unwrap_or(DVec3::Z).as_vec3();
        self.normals = mapped.iter().enumerate().map(either).collect();
    }

    /// Fills the streams that the scene needs.
    fn fill(&mut self, draw: &Draw<'_>, material: &Material, needs: Needs, notes: &mut Notes) {
        let p = draw.primitive;
        for set in 0..2 {
            if needs.uvs[set] {
                self.uvs[set] =
                    self.stream(&p.uvs[set], [0.0; 2], |uv| uv.map(|x| if x.is_finite() { x } else { 0.0 }));
                notes.add_if("texture coordinates that are not finite are taken as 0", !finite(&p.uvs[set]));
            }
        }
        for texture in [material.base_texture, material.normal_texture, material.emission_texture].iter().flatten() {
            let missing = p.uvs[texture.set as usize].is_empty();
            notes.add_if("textured primitives without texture coordinates show one texel", missing);
        }
        if needs.colors {
            let clean = |c: [f32; 4]| c.map(|x| if x.is_nan() { 1.0 } else { x.clamp(0.0, 1.0) });
            self.colors = self.stream(&p.colors, [1.0; 4], clean);
            notes.add_if("vertex colours outside [0, 1] are clamped", p.colors.iter().any(|c| clean(*c) != *c));
        }
        if needs.tangents {
            tangents::fill(self, draw, material);
        }
    }

    /// A stream of the primitive at this piece's vertices; `missing` where the primitive has none.
    pub fn stream<const N: usize, T: From<[f32; N]>>(
        &self,
        stream: &[[f32; N]],
        missing: [f32; N],
        clean: impl Fn([f32; N]) -> [f32; N],
    ) -> Vec<T> {
        let value = |v: &u32| T::from(clean(stream.get(*v as usize).copied().unwrap_or(missing)));
        self.source.iter().map(value).collect()
    }

    /// Adds a copy of a vertex, without its tangent, and returns its index.
    pub fn duplicate(&mut self, vertex: u32) -> u32 {
        let v = vertex as usize;
        self.positions.push(self.positions[v]);
        self.normals.push(self.normals[v]);
        self.source.push(self.source[v]);
        for uvs in self.uvs.iter_mut().filter(|uvs| !uvs.is_empty()) {
            uvs.push(uvs[v]);
        }
        if !self.colors.is_empty() {
            self.colors.push(self.colors[v]);
        }
        self.positions.len() as u32 - 1
    }
}

fn push(scene: &mut Scene, material: u32, piece: Piece) {
    let base = scene.positions.len() as u32;
    let first_triangle = scene.triangles.len() as u32;
    let triangle_count = piece.triangles.len() as u32;
    scene.positions.extend(piece.positions);
    scene.normals.extend(piece.normals);
    scene.tangents.extend(piece.tangents);
    for (all, new) in scene.uvs.iter_mut().zip(piece.uvs) {
        all.extend(new);
    }
    scene.colors.extend(piece.colors);
    scene.triangles.extend(piece.triangles.iter().map(|t| t.map(|v| v + base)));
    match scene.parts.last_mut() {
        Some(part) if part.material == material => part.triangle_count += triangle_count,
        _ => scene.parts.push(Part { material, first_triangle, triangle_count }),
    }
}

/// Unit geometric normal, in double precision; `None` for a triangle without area.
fn normal(positions: &[Vec3], t: &[u32; 3]) -> Option<DVec3> {
    let [a, b, c] = t.map(|v| positions[v as usize].as_dvec3());
    unit((b - a).cross(c - a))
}

/// Linear part of a transform up to a positive factor, so that products of its elements stay in range.
pub fn linear(transform: DMat4) -> DMat3 {
    let linear = DMat3::from_mat4(transform);
    let largest = linear.to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
    let scale = |v: DVec3| if largest > 0.0 { v / largest } else { v };
    DMat3::from_cols(scale(linear.x_axis), scale(linear.y_axis), scale(linear.z_axis))
}

/// Inverse transpose up to a positive factor; also right for a transform that flattens one direction.
pub fn cofactors(l: DMat3) -> DMat3 {
    let cofactors = DMat3::from_cols(l.y_axis.cross(l.z_axis), l.z_axis.cross(l.x_axis), l.x_axis.cross(l.y_axis));
    if l.determinant() < 0.0 { cofactors * -1.0 } else { cofactors }
}

/// `v` with length 1, whatever its size; `None` where it has no direction.
pub fn unit(v: DVec3) -> Option<DVec3> {
    (v / v.abs().max_element()).try_normalize()
}

fn finite<const N: usize>(stream: &[[f32; N]]) -> bool {
    stream.iter().flatten().all(|x| x.is_finite())
}
