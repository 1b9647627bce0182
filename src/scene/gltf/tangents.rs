//! Tangents: from the file, else from the texture coordinates that the normal map is read at.

use super::assemble::{Draw, Piece, linear, unit};
use crate::scene::Material;
use glam::{DVec3, Vec2, Vec3, Vec4};
use std::collections::HashMap;

/// Fills `piece.tangents`: unit, perpendicular to the normal, handedness in `w`.
pub fn fill(piece: &mut Piece, draw: &Draw<'_>, material: &Material) {
    let p = draw.primitive;
    match material.normal_texture {
        // glTF 2.0 §3.7.2.1: without normals in the file, its tangents are ignored.
        Some(_) if !p.tangents.is_empty() && !p.normals.is_empty() => from_file(piece, draw),
        Some(map) if !p.uvs[map.set as usize].is_empty() => {
            let at = |uv: &Vec2| map.transform.transform_point2(*uv);
            let uvs: Vec<Vec2> = piece.uvs[map.set as usize].iter().map(at).collect();
            from_uvs(piece, &uvs);
        }
        _ => piece.tangents = piece.normals.iter().map(|n| any_tangent(*n)).collect(),
    }
}

/// The file's tangents, transformed and made perpendicular to the normals.
fn from_file(piece: &mut Piece, draw: &Draw<'_>) {
    let linear = linear(draw.to_world);
    let mirror = if linear.determinant() < 0.0 { -1.0 } else { 1.0 };
    let stream: Vec<Vec4> = piece.stream(&draw.primitive.tangents, [0.0; 4], |t| t);
    let to_world = |(t, n): (&Vec4, &Vec3)| {
        let n = n.as_dvec3();
        let along = unit(t.truncate().as_dvec3()).map_or(DVec3::ZERO, |t| linear * t);
        let handedness = if t.w < 0.0 { -mirror } else { mirror };
        let tangent = unit(along - n * n.dot(along));
        tangent.map_or_else(|| any_tangent(n.as_vec3()), |t| t.as_vec3().extend(handedness as f32))
    };
    piece.tangents = stream.iter().zip(&piece.normals).map(to_world).collect();
}

/// MikkTSpace's weighting, by meshoptimizer; vertices whose corners differ in tangent are split.
fn from_uvs(piece: &mut Piece, uvs: &[Vec2]) {
    let arrays = |v: &[Vec3]| -> Vec<[f32; 3]> { v.iter().map(|v| v.to_array()).collect() };
    let uvs: Vec<[f32; 2]> = uvs.iter().map(|uv| if uv.is_finite() { uv.to_array() } else { [0.0; 2] }).collect();
    let largest = piece.positions.iter().fold(0.0f32, |m, p| m.max(p.abs().max_element()));
    // A power of two, so that squares stay in range and nothing is rounded.
    let scale = (-largest.log2().floor()).clamp(-126.0, 126.0).exp2();
    let positions: Vec<Vec3> = piece.positions.iter().map(|p| *p * scale).collect();
    let indices = piece.triangles.as_flattened();
    let corners = meshopt::generate_tangents(
        Some(indices),
        &arrays(&positions),
        &arrays(&piece.normals),
        &uvs,
        meshopt::TangentOptions::Compatible,
    );
    let mut tangents: Vec<Option<[f32; 4]>> = vec![None; piece.positions.len()];
    let mut splits: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (i, tangent) in corners.into_iter().enumerate() {
        let vertex = piece.triangles[i / 3][i % 3];
        let slot = &mut tangents[vertex as usize];
        if slot.get_or_insert(tangent).map(f32::to_bits) == tangent.map(f32::to_bits) {
            continue;
        }
        let split = splits.entry((vertex, tangent.map(f32::to_bits))).or_insert_with(|| {
            tangents.push(Some(tangent));
            piece.duplicate(vertex)
        });
        piece.triangles[i / 3][i % 3] = *split;
    }
    let checked = |(t, n): (&Option<[f32; 4]>, &Vec3)| usable(t.map(Vec4::from), *n);
    piece.tangents = tangents.iter().zip(&piece.normals).map(checked).collect();
}

/// `tangent` made exactly perpendicular, or any tangent where it has no direction.
fn usable(tangent: Option<Vec4>, n: Vec3) -> Vec4 {
    let Some(t) = tangent else { return any_tangent(n) };
    let (along, n64) = (t.truncate().as_dvec3(), n.as_dvec3());
    let handedness = if t.w < 0.0 { -1.0 } else { 1.0 };
    unit(along - n64 * n64.dot(along)).map_or_else(|| any_tangent(n), |t| t.as_vec3().extend(handedness))
}

/// Some unit tangent of a unit normal.
fn any_tangent(n: Vec3) -> Vec4 {
    n.any_orthonormal_vector().extend(1.0)
}
