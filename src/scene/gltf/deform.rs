//! Morph targets and skins: the vertices that a node's mesh has in its pose.

use super::Notes;
use super::accessor::Reader;
use super::animation::Poses;
use super::assemble::{cofactors, linear, unit};
use super::buffers::Buffers;
use super::document::{Document, item};
use super::error::{Fault, Kind, Result, Within};
use super::nodes::Placed;
use super::primitive::Primitive;
use glam::{DMat3, DMat4, DVec3};
use gltf::json;
use json::mesh::Semantic;
use json::validation::Checked;
use serde::Deserialize;
use std::cell::Cell;
use std::collections::BTreeMap;

/// Sets of four joints that a vertex may have.
const MOST_SETS: u32 = 16;

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Skin {
    joints: Vec<usize>,
    inverse_bind_matrices: Option<usize>,
}

/// What the deformation of all meshes reads.
pub struct Deformer<'a, 'b> {
    pub document: &'a Document,
    pub buffers: &'a Buffers<'b>,
    pub poses: &'a Poses,
    /// World transform of every node.
    pub worlds: &'a [DMat4],
    /// Vertices that may still be moved, over all targets, joints and nodes.
    pub budget: Cell<u64>,
}

/// A mesh in its pose, and where it stands.
pub struct Posed {
    pub to_world: DMat4,
    pub primitives: Vec<(usize, Primitive)>,
}

/// A matrix a joint: from the mesh's space to the world.
type Joints = Vec<DMat4>;

impl Deformer<'_, '_> {
    /// The node's mesh in its pose; `None` where that is the mesh as it stands.
    pub fn pose(&self, placed: &Placed, mesh: &[(usize, Primitive)], notes: &mut Notes) -> Result<Option<Posed>> {
        let node = &self.document.nodes[placed.node];
        let Some(source) = node.mesh.and_then(|m| self.document.meshes.get(m)) else { return Ok(None) };
        let weights = self.weights(placed.node, source)?;
        let joints = node.skin.map(|skin| self.joints(skin).within(|| format!("skin {skin}"))).transpose()?;
        let morphs = weights.iter().any(|w| *w != 0.0);
        if joints.is_none() && !morphs {
            return Ok(None);
        }
        let mut posed = Posed { to_world: placed.to_world, primitives: mesh.to_vec() };
        for (index, primitive) in &mut posed.primitives {
            let source = &source.primitives[*index];
            let at = || format!("{} primitive {index}", self.document.mesh_label(node.mesh.unwrap_or(0)));
            self.morph(primitive, source, &weights).within(at)?;
        }
        if let Some(joints) = &joints {
            self.skin(&mut posed, source, joints, notes)?;
        }
        Ok(Some(posed))
    }

    /// Weights of the mesh's targets: the animation's, else the node's, else the mesh's.
    fn weights(&self, node: usize, mesh: &json::Mesh) -> Result<Vec<f64>> {
        if let Some(weights) = self.poses.get(&node).and_then(|p| p.weights.clone()) {
            return Ok(weights);
        }
        let own = &self.document.nodes[node].weights;
        let own: Option<Vec<f64>> =
            Option::deserialize(own).map_err(|e| Fault::invalid(format!("morph weights: {e}")))?;
        let of_mesh = || mesh.weights.iter().flatten().map(|w| f64::from(*w)).collect();
        let weights: Vec<f64> = own.unwrap_or_else(of_mesh);
        match weights.iter().all(|w| w.is_finite()) {
            true => Ok(weights),
            false => Err(Fault::invalid("its morph weights are not finite")),
        }
    }

    fn spend(&self, vertices: usize) -> Result<()> {
        let left = self.budget.get().checked_sub(vertices as u64);
        let left = left.ok_or_else(|| Fault::new(Kind::TooLarge, "skins and morph targets move too many vertices"))?;
        self.budget.set(left);
        Ok(())
    }

    /// Adds the targets' displacements, each times its weight.
    fn morph(&self, p: &mut Primitive, source: &json::mesh::Primitive, weights: &[f64]) -> Result<()> {
        let targets = source.targets.iter().flatten().zip(weights).enumerate();
        for (index, (target, weight)) in targets.filter(|(_, (_, weight))| **weight != 0.0) {
            let index_of = |a: &Option<json::Index<json::Accessor>>| a.as_ref().map(|a| a.value());
            let mut move_all = || {
                self.displace(&mut p.positions, &p.used, index_of(&target.positions), *weight)?;
                self.displace(&mut p.normals, &p.used, index_of(&target.normals), *weight)?;
                self.displace(&mut p.tangents, &p.used, index_of(&target.tangents), *weight)
            };
            move_all().within(|| format!("morph target {index}"))?;
        }
        Ok(())
    }

    /// Adds `weight` times the accessor's three components to those of each vertex.
    fn displace<const N: usize>(
        &self,
        stream: &mut [[f32; N]],
        used: &[u32],
        accessor: Option<usize>,
        weight: f64,
    ) -> Result<()> {
        let Some(accessor) = accessor.filter(|_| !stream.is_empty()) else { return Ok(()) };
        let reader = Reader::open(self.document, self.buffers, accessor, 3..=3);
        let reader = reader.within(|| format!("accessor {accessor}"))?;
        if used.last().is_some_and(|last| *last as usize >= reader.count) {
            return Err(Fault::invalid(format!("accessor {accessor}: has too few elements, {}", reader.count)));
        }
        self.spend(used.len())?;
        for (value, vertex) in stream.iter_mut().zip(used) {
            let by: [f32; 3] = reader.get(*vertex as usize);
            for (x, d) in value.iter_mut().zip(by) {
                *x = (f64::from(*x) + weight * f64::from(d)) as f32;
            }
        }
        Ok(())
    }

    /// World transform times inverse bind matrix of each joint.
    fn joints(&self, index: usize) -> Result<Joints> {
        let skin = Skin::deserialize(item(&self.document.skins, "skin", index)?).map_err(Fault::invalid)?;
        let bind = skin.inverse_bind_matrices.map(|accessor| {
            let reader = Reader::open(self.document, self.buffers, accessor, 16..=16);
            reader.within(|| format!("accessor {accessor} inverseBindMatrices"))
        });
        let bind = bind.transpose()?;
        if bind.as_ref().is_some_and(|bind| bind.count < skin.joints.len()) {
            return Err(Fault::invalid("has fewer inverse bind matrices than joints"));
        }
        self.spend(skin.joints.len())?;
        let joint = |(i, node): (usize, &usize)| {
            let world = *item(self.worlds, "joint node", *node)?;
            let bound = bind.as_ref().map_or([0.0; 16], |bind| bind.get::<16>(i)).map(f64::from);
            let bound = if bind.is_some() { DMat4::from_cols_array(&bound) } else { DMat4::IDENTITY };
            let joint = world * bound;
            if joint.is_finite() { Ok(joint) } else { Err(Fault::invalid(format!("joint {i} is not finite"))) }
        };
        skin.joints.iter().enumerate().map(joint).collect()
    }

    /// Moves every vertex by its joints. The mesh then stands in the world: its node's own transform does not count
    /// (glTF 2.0 §3.7.3.3).
    fn skin(&self, posed: &mut Posed, source: &json::Mesh, joints: &Joints, notes: &mut Notes) -> Result<()> {
        let mut all = Vec::new();
        for (index, primitive) in &posed.primitives {
            let blended = self.blend(primitive, &source.primitives[*index], joints, notes);
            all.push(blended.within(|| format!("primitive {index}"))?);
        }
        if all.iter().all(Option::is_none) {
            notes.add("meshes with a skin but without joints stand at their node");
            return Ok(());
        }
        let of_node = posed.to_world;
        let origin = far_centre(posed, &all);
        posed.to_world = DMat4::from_translation(origin);
        for ((_, primitive), transforms) in posed.primitives.iter_mut().zip(all) {
            let all = transforms.unwrap_or_else(|| vec![of_node; primitive.positions.len()]);
            transform(primitive, &all, origin);
        }
        Ok(())
    }

    /// Each vertex's transform, the mean of its joints' by weight; `None` for a primitive without joints.
    fn blend(
        &self,
        p: &Primitive,
        source: &json::mesh::Primitive,
        joints: &Joints,
        notes: &mut Notes,
    ) -> Result<Option<Vec<DMat4>>> {
        let mut sets = Vec::new();
        for set in 0..MOST_SETS {
            let open = |semantic, name: &str| self.attribute(p, source, &semantic, &format!("{name}_{set}"));
            let (indices, weights) = (open(Semantic::Joints(set), "JOINTS")?, open(Semantic::Weights(set), "WEIGHTS")?);
            let (Some(indices), Some(weights)) = (indices, weights) else { break };
            sets.push((indices.require_unsigned("joints")?, weights));
        }
        if sets.is_empty() {
            return Ok(None);
        }
        self.spend(p.used.len().saturating_mul(4 * sets.len()))?;
        let mut odd = 0;
        let blend = |vertex: &u32| {
            let of = |(indices, weights): &(Reader<'_>, Reader<'_>)| {
                let pair =
                    |i: usize| (indices.get_indices::<4>(*vertex as usize)[i], weights.get::<4>(*vertex as usize)[i]);
                [0, 1, 2, 3].map(pair)
            };
            mean(sets.iter().flat_map(of), joints, &mut odd)
        };
        let all = p.used.iter().map(blend).collect::<Result<Vec<_>>>()?;
        notes.add_times_if("joint weights whose sum is not 1 are scaled to it", odd);
        Ok(Some(all))
    }

    fn attribute<'c>(
        &'c self,
        p: &Primitive,
        source: &json::mesh::Primitive,
        semantic: &Semantic,
        name: &str,
    ) -> Result<Option<Reader<'c>>> {
        let Some(accessor) = source.attributes.get(&Checked::Valid(semantic.clone())) else { return Ok(None) };
        let reader = Reader::open(self.document, self.buffers, accessor.value(), 4..=4);
        let reader = reader.within(|| format!("accessor {} {name}", accessor.value()))?;
        match p.used.last() {
            Some(last) if *last as usize >= reader.count => {
                Err(Fault::invalid(format!("{name} has too few elements, {}", reader.count)))
            }
            _ => Ok(Some(reader)),
        }
    }
}

/// The mean transform of weighted joints; without any weight the first joint's. `odd` counts sums that are not 1.
fn mean(pairs: impl Iterator<Item = (u32, f32)>, joints: &Joints, odd: &mut usize) -> Result<DMat4> {
    let (mut sum, mut total, mut first) = (DMat4::ZERO, 0.0, None);
    for (index, weight) in pairs {
        first = first.or(Some(index));
        let weight = f64::from(weight);
        if !(weight.is_finite() && weight > 0.0) {
            continue;
        }
        sum += *item(joints, "joint", index as usize)? * weight;
        total += weight;
    }
    *odd += usize::from((total - 1.0).abs() > 0.01);
    match first {
        Some(first) if total == 0.0 => Ok(*item(joints, "joint", first as usize)?),
        _ => Ok(sum * (1.0 / total)),
    }
}

/// The centre of the posed vertices where they lie far from zero compared with their size, so that single precision
/// keeps their detail; else zero.
fn far_centre(posed: &Posed, transforms: &[Option<Vec<DMat4>>]) -> DVec3 {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for ((_, p), transforms) in posed.primitives.iter().zip(transforms) {
        for (position, transform) in p.positions.iter().zip(transforms.iter().flatten()) {
            let at = transform.transform_point3(DVec3::from(position.map(f64::from)));
            (low, high) = (low.min(at), high.max(at));
        }
    }
    super::assemble::far_centre(low, high)
}

/// Brings a primitive's vertices to the world, relative to `origin`.
fn transform(p: &mut Primitive, transforms: &[DMat4], origin: DVec3) {
    let vector = |v: [f32; 3]| DVec3::from(v.map(f64::from));
    let linears: Vec<DMat3> = transforms.iter().map(|t| linear(*t)).collect();
    for (position, t) in p.positions.iter_mut().zip(transforms) {
        *position = (t.transform_point3(vector(*position)) - origin).as_vec3().to_array();
    }
    for (normal, l) in p.normals.iter_mut().zip(&linears) {
        let n = unit(vector(*normal)).and_then(|n| unit(cofactors(*l) * n));
        *normal = n.map_or([0.0; 3], |n| n.as_vec3().to_array());
    }
    for (tangent, l) in p.tangents.iter_mut().zip(&linears) {
        let [x, y, z, w] = *tangent;
        let along = unit(*l * vector([x, y, z])).unwrap_or(DVec3::ZERO).as_vec3();
        *tangent = along.extend(if l.determinant() < 0.0 { -w } else { w }).to_array();
    }
    for t in &mut p.triangles {
        if linears.get(t[0] as usize).is_some_and(|l| l.determinant() < 0.0) {
            t.swap(1, 2);
        }
    }
}

/// World transform of every node, for joints: those of `placed` as they are, others by their parents.
pub fn worlds(document: &Document, placed: &[Placed], poses: &Poses) -> Vec<DMat4> {
    let mut worlds = vec![DMat4::IDENTITY; document.nodes.len()];
    let mut known: BTreeMap<usize, DMat4> = placed.iter().map(|p| (p.node, p.to_world)).collect();
    let mut has_parent = vec![false; worlds.len()];
    document.nodes.iter().flat_map(|n| &n.children).for_each(|child| has_parent[*child] = true);
    let mut stack: Vec<(usize, DMat4)> =
        (0..worlds.len()).filter(|i| !has_parent[*i]).map(|i| (i, DMat4::IDENTITY)).collect();
    while let Some((index, parent)) = stack.pop() {
        let own = || parent * super::nodes::local_or_identity(document, index, poses);
        let world = known.remove(&index).unwrap_or_else(own);
        worlds[index] = world;
        stack.extend(document.nodes[index].children.iter().map(|child| (*child, world)));
    }
    worlds
}
