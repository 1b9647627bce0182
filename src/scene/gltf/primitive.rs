//! Mesh primitives as triangle lists over the vertices that they use, in the mesh's own space.

use super::accessor::Reader;
use super::buffers::Buffers;
use super::document::Document;
use super::draco;
use super::error::{Fault, Kind, Result, Within};
use super::{Notes, materials};
use gltf::json;
use json::mesh::{Mode, Semantic};
use json::validation::Checked;

/// A primitive in its mesh's space. Streams have an entry a vertex, or none where the file has none.
#[derive(Clone)]
pub struct Primitive {
    /// Index into the document's materials.
    pub material: Option<usize>,
    /// Accessor of the positions, for messages.
    pub position_accessor: usize,
    pub positions: Vec<[f32; 3]>,
    pub normals: Vec<[f32; 3]>,
    pub tangents: Vec<[f32; 4]>,
    pub uvs: [Vec<[f32; 2]>; 2],
    pub colors: Vec<[f32; 4]>,
    pub triangles: Vec<[u32; 3]>,
    /// The file's vertex that each one is, where joints or morph targets may move it; else empty.
    pub used: Vec<u32>,
}

/// Corners that may still be read, over all primitives.
pub struct Budget(pub u64);

/// Reads a primitive; `None` for points and lines, which are noted.
pub fn read(
    document: &Document,
    buffers: &Buffers<'_>,
    primitive: &json::mesh::Primitive,
    budget: &mut Budget,
    notes: &mut Notes,
) -> Result<Option<Primitive>> {
    let Checked::Valid(mode) = primitive.mode else {
        return Err(Fault::invalid("mode is none that glTF knows"));
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        notes.add("primitives of points or lines are left out");
        return Ok(None);
    }
    // Draco's code holds lists, whatever the mode says.
    let mode = if draco::decode(document, buffers, primitive)? { Mode::Triangles } else { mode };
    let source = Source { document, buffers, primitive };
    let Some((position_accessor, positions)) = source.attribute(&Semantic::Positions, 3..=3, "POSITION")? else {
        notes.add("primitives without positions are left out");
        return Ok(None);
    };
    let corners = if positions.count > 0 { source.corners(positions.count, budget)? } else { Vec::new() };
    if corners.is_empty() {
        notes.add("primitives without vertices are left out");
        return Ok(None);
    }
    let mut triangles = triangles(&corners, mode);
    if triangles.len() * 3 < corners.len() && mode == Mode::Triangles {
        notes.add("primitives whose vertex count is no multiple of three lose the rest");
    }
    let used = compact(&mut triangles, positions.count);
    let material = primitive.material.and_then(|m| document.materials.get(m.value()));
    let [first, second] = material.map_or([0, 1], materials::coordinate_sets);
    let set = |n: u32| source.stream(&Semantic::TexCoords(n), 2..=2, &format!("TEXCOORD_{n}"), &used, positions.count);
    let uvs = [set(first)?, set(second)?];
    Ok(Some(Primitive {
        material: primitive.material.map(|m| m.value()),
        position_accessor,
        positions: used.iter().map(|i| positions.get(*i as usize)).collect(),
        normals: source.stream(&Semantic::Normals, 3..=3, "NORMAL", &used, positions.count)?,
        tangents: source.stream(&Semantic::Tangents, 4..=4, "TANGENT", &used, positions.count)?,
        uvs,
        colors: source.colors(&used, positions.count)?,
        triangles,
        used: if moves(primitive) { used } else { Vec::new() },
    }))
}

/// Whether joints or morph targets may move the vertices.
fn moves(primitive: &json::mesh::Primitive) -> bool {
    primitive.targets.is_some() || primitive.attributes.contains_key(&Checked::Valid(Semantic::Joints(0)))
}

struct Source<'a, 'b> {
    document: &'a Document,
    buffers: &'a Buffers<'b>,
    primitive: &'a json::mesh::Primitive,
}

impl<'a> Source<'a, '_> {
    /// Accessor of an attribute, if the primitive has it.
    fn attribute(
        &self,
        semantic: &Semantic,
        components: std::ops::RangeInclusive<usize>,
        name: &str,
    ) -> Result<Option<(usize, Reader<'a>)>> {
        let accessor = self.primitive.attributes.get(&Checked::Valid(semantic.clone())).map(|a| a.value());
        let open = |index| {
            let reader = Reader::open(self.document, self.buffers, index, components);
            Ok((index, reader.within(|| format!("accessor {index} {name}"))?))
        };
        accessor.map(open).transpose()
    }

    /// An attribute's values at the vertices in `used`; empty if the primitive does not have it.
    fn stream<const N: usize>(
        &self,
        semantic: &Semantic,
        components: std::ops::RangeInclusive<usize>,
        name: &str,
        used: &[u32],
        count: usize,
    ) -> Result<Vec<[f32; N]>> {
        let Some((index, reader)) = self.attribute(semantic, components, name)? else { return Ok(Vec::new()) };
        if reader.count != count {
            let what =
                format!("accessor {index} {name}: has {} elements and there are {count} positions", reader.count);
            return Err(Fault::invalid(what));
        }
        Ok(used.iter().map(|i| reader.get(*i as usize)).collect())
    }

    /// COLOR_0 as RGBA; alpha is 1 where the file has RGB.
    fn colors(&self, used: &[u32], count: usize) -> Result<Vec<[f32; 4]>> {
        let name = "COLOR_0";
        let mut colors = self.stream::<4>(&Semantic::Colors(0), 3..=4, name, used, count)?;
        if self.attribute(&Semantic::Colors(0), 3..=4, name)?.is_some_and(|(_, reader)| reader.components() == 3) {
            colors.iter_mut().for_each(|c| c[3] = 1.0);
        }
        Ok(colors)
    }

    /// The vertex of each corner, in range.
    fn corners(&self, vertices: usize, budget: &mut Budget) -> Result<Vec<u32>> {
        let Some(index) = self.primitive.indices.map(|i| i.value()) else {
            take(budget, vertices)?;
            return Ok((0..vertices as u32).collect());
        };
        let mut read = || {
            let reader = Reader::open(self.document, self.buffers, index, 1..=1)?.require_unsigned("indices")?;
            take(budget, reader.count)?;
            let corners: Vec<u32> = (0..reader.count).map(|i| reader.get_index(i)).collect();
            match corners.iter().position(|v| *v as usize >= vertices) {
                Some(at) => {
                    Err(Fault::invalid(format!("index {} at {at}: there are {vertices} vertices", corners[at])))
                }
                None => Ok(corners),
            }
        };
        read().within(|| format!("accessor {index} indices"))
    }
}

fn take(budget: &mut Budget, corners: usize) -> Result<()> {
    let left = budget.0.checked_sub(corners as u64);
    budget.0 = left.ok_or_else(|| Fault::new(Kind::TooLarge, "the meshes have more triangles than are allowed"))?;
    Ok(())
}

/// Triangles of a list, strip or fan (glTF 2.0 §3.7.2.1), incomplete ones left out.
fn triangles(corners: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let flip = |(i, w): (usize, &[u32])| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[0], w[2], w[1]] };
            corners.windows(3).enumerate().map(flip).collect()
        }
        Mode::TriangleFan => corners.windows(2).skip(1).map(|w| [w[0], w[1], corners[0]]).collect(),
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

/// Renumbers the vertices to those in use, in their order in the file, and returns these.
///
/// Work is in proportion to the triangles, not to the vertices: many primitives may share one large accessor.
fn compact(triangles: &mut [[u32; 3]], vertices: usize) -> Vec<u32> {
    if vertices <= triangles.len().saturating_mul(8) {
        let mut place = vec![u32::MAX; vertices];
        triangles.iter().flatten().for_each(|v| place[*v as usize] = 0);
        let used: Vec<u32> = (0..vertices as u32).filter(|v| place[*v as usize] == 0).collect();
        used.iter().zip(0..).for_each(|(v, i)| place[*v as usize] = i);
        triangles.iter_mut().flatten().for_each(|v| *v = place[*v as usize]);
        return used;
    }
    let mut used = triangles.as_flattened().to_vec();
    used.sort_unstable();
    used.dedup();
    triangles.iter_mut().flatten().for_each(|v| *v = used.partition_point(|u| u < v) as u32);
    used
}
