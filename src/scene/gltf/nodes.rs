//! The node hierarchy, flattened to world transforms in double precision.

use super::Notes;
use super::accessor::Reader;
use super::animation::{NodePose, Poses};
use super::buffers::Buffers;
use super::document::{Document, Instancing, Node, item};
use super::error::{Fault, Result, Within};
use glam::{DMat4, DQuat, DVec3};

/// A node of the scene, and where it stands in the world.
pub struct Placed {
    pub node: usize,
    pub to_world: DMat4,
    /// KHR_node_visibility hides it or one above it: neither its mesh nor its light counts.
    pub hidden: bool,
}

/// All nodes under the default scene, parents before children.
pub fn flatten(document: &Document, poses: &Poses, notes: &mut Notes) -> Result<Vec<Placed>> {
    let parents = parents(document)?;
    let mut stack = Vec::new();
    for root in roots(document, &parents, notes)?.into_iter().rev() {
        stack.push((root, DMat4::IDENTITY, false));
    }
    let mut placed = Vec::with_capacity(document.nodes.len());
    while let Some((index, parent, hidden)) = stack.pop() {
        let node = &document.nodes[index];
        let to_world = parent * local(node, poses.get(&index), notes).within(|| document.node_label(index))?;
        if !to_world.is_finite() {
            return Err(Fault::invalid("its world transform is not finite").within(document.node_label(index)));
        }
        let hidden = hidden || node.extensions.visibility.as_ref().is_some_and(|v| !v.visible);
        stack.extend(node.children.iter().rev().map(|child| (*child, to_world, hidden)));
        placed.push(Placed { node: index, to_world, hidden });
    }
    Ok(placed)
}

/// Each node's parent, after checking that nodes form trees: in range, one parent at most, no cycle.
fn parents(document: &Document) -> Result<Vec<Option<usize>>> {
    let mut parents = vec![None; document.nodes.len()];
    for (index, node) in document.nodes.iter().enumerate() {
        for &child in &node.children {
            item(&document.nodes, "child node", child).within(|| document.node_label(index))?;
            if let Some(other) = parents[child].replace(index) {
                let what = format!(
                    "has two parents, {} and {}; give each its own copy",
                    document.node_label(other),
                    document.node_label(index)
                );
                return Err(Fault::invalid(what).within(document.node_label(child)));
            }
        }
    }
    let mut reached = 0;
    let mut stack: Vec<usize> = (0..parents.len()).filter(|i| parents[*i].is_none()).collect();
    let mut seen = vec![false; parents.len()];
    while let Some(index) = stack.pop() {
        (seen[index], reached) = (true, reached + 1);
        stack.extend(&document.nodes[index].children);
    }
    if reached < parents.len() {
        let index = seen.iter().position(|s| !s).unwrap_or(0);
        return Err(Fault::invalid("is its own ancestor").within(document.node_label(index)));
    }
    Ok(parents)
}

/// Roots of the default scene, else of the first, else all nodes without a parent.
fn roots(document: &Document, parents: &[Option<usize>], notes: &mut Notes) -> Result<Vec<usize>> {
    let index = document.scene.unwrap_or(0);
    let scene = match document.scenes.get(index) {
        Some(scene) => scene,
        None if document.scene.is_none() => return Ok((0..parents.len()).filter(|i| parents[*i].is_none()).collect()),
        None => return item(&document.scenes, "scene", index).map(|_| Vec::new()),
    };
    let mut listed = vec![false; parents.len()];
    let mut roots = Vec::new();
    for &root in &scene.nodes {
        item(&document.nodes, "node", root).within(|| format!("scene {index}"))?;
        if std::mem::replace(&mut listed[root], true) {
            notes.add("nodes that the scene lists twice are drawn once");
        } else {
            roots.push(root);
        }
    }
    let under_another = below(document, &listed);
    roots.retain(|root| !under_another[*root]);
    notes.add_times_if("nodes that the scene lists and that stand below another of its nodes are drawn there", {
        listed.iter().zip(&under_another).filter(|(listed, below)| **listed && **below).count()
    });
    let children = roots.iter().filter(|root| parents[**root].is_some()).count();
    notes
        .add_times_if("nodes that the scene lists and whose parent it does not are drawn without the parent", children);
    Ok(roots)
}

/// Which nodes have one of those `listed` above them.
fn below(document: &Document, listed: &[bool]) -> Vec<bool> {
    let mut below = vec![false; listed.len()];
    let mut stack: Vec<usize> = (0..listed.len()).filter(|i| listed[*i]).collect();
    while let Some(index) = stack.pop() {
        for &child in &document.nodes[index].children {
            if !std::mem::replace(&mut below[child], true) && !listed[child] {
                stack.push(child);
            }
        }
    }
    below
}

/// A node's own transform; what the pose says of it goes before what the node says.
fn local(node: &Node, pose: Option<&NodePose>, notes: &mut Notes) -> Result<DMat4> {
    let own = || (node.translation.map(DVec3::from), node.rotation.map(DQuat::from_array), node.scale.map(DVec3::from));
    let moved = pose.filter(|p| p.translation.is_some() || p.rotation.is_some() || p.scale.is_some());
    let (translation, rotation, scale) = match (node.matrix, moved) {
        (Some(matrix), None) => return affine(matrix),
        (Some(matrix), Some(_)) => {
            let (scale, rotation, translation) = affine(matrix)?.to_scale_rotation_translation();
            (Some(translation), Some(rotation), Some(scale))
        }
        (None, _) => own(),
    };
    let translation = moved.and_then(|p| p.translation).map(DVec3::from).or(translation);
    let rotation = moved.and_then(|p| p.rotation).map(DQuat::from_array).or(rotation);
    trs(translation, rotation, moved.and_then(|p| p.scale).map(DVec3::from).or(scale), notes)
}

fn affine(matrix: [f64; 16]) -> Result<DMat4> {
    let matrix = DMat4::from_cols_array(&matrix);
    let affine = matrix.row(3).abs_diff_eq(glam::DVec4::W, 1e-6);
    if affine { Ok(matrix) } else { Err(Fault::invalid("its matrix is not affine")) }
}

/// A node's own transform; the identity for a node whose transform is broken.
pub fn local_or_identity(document: &Document, index: usize, poses: &Poses) -> DMat4 {
    local(&document.nodes[index], poses.get(&index), &mut Notes::default()).unwrap_or(DMat4::IDENTITY)
}

fn trs(translation: Option<DVec3>, rotation: Option<DQuat>, scale: Option<DVec3>, notes: &mut Notes) -> Result<DMat4> {
    let rotation = rotation.unwrap_or(DQuat::IDENTITY);
    let length = rotation.length();
    if !length.is_finite() {
        return Err(Fault::invalid("its rotation is not finite"));
    }
    notes.add_if("rotations that are 0 are taken as none", length == 0.0);
    let rotation = if length > 0.0 { rotation / length } else { DQuat::IDENTITY };
    let (scale, translation) = (scale.unwrap_or(DVec3::ONE), translation.unwrap_or(DVec3::ZERO));
    Ok(DMat4::from_scale_rotation_translation(scale, rotation, translation))
}

/// Transforms of a node's instances under the node (EXT_mesh_gpu_instancing); just the identity without the extension.
pub fn instances(document: &Document, buffers: &Buffers<'_>, node: &Node, notes: &mut Notes) -> Result<Vec<DMat4>> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(vec![DMat4::IDENTITY]) };
    let instances = Instances::open(document, buffers, instancing);
    let all =
        instances.and_then(|of| (0..of.count).map(|i| of.get(i, notes).within(|| format!("instance {i}"))).collect());
    all.within(|| "EXT_mesh_gpu_instancing")
}

/// Number of a node's instances.
pub fn instance_count(document: &Document, buffers: &Buffers<'_>, node: &Node) -> Result<usize> {
    let Some(instancing) = &node.extensions.instancing else { return Ok(1) };
    Instances::open(document, buffers, instancing).map(|i| i.count).within(|| "EXT_mesh_gpu_instancing")
}

/// Accessors of a transform an instance.
struct Instances<'a> {
    count: usize,
    translation: Option<Reader<'a>>,
    rotation: Option<Reader<'a>>,
    scale: Option<Reader<'a>>,
}

impl<'a> Instances<'a> {
    fn open(document: &'a Document, buffers: &'a Buffers<'_>, instancing: &Instancing) -> Result<Self> {
        let open = |accessor: Option<usize>, components: usize, name: &str| {
            let open = |index| {
                let reader = Reader::open(document, buffers, index, components..=components);
                reader.within(|| format!("accessor {index} {name}"))
            };
            accessor.map(open).transpose()
        };
        let of = &instancing.attributes;
        let translation = open(of.translation, 3, "TRANSLATION")?;
        let rotation = open(of.rotation, 4, "ROTATION")?;
        let scale = open(of.scale, 3, "SCALE")?;
        let counts = [&translation, &rotation, &scale].map(|r| r.as_ref().map(|r| r.count));
        let count = counts.into_iter().flatten().next().unwrap_or(0);
        if counts.into_iter().flatten().any(|other| other != count) {
            return Err(Fault::invalid("its accessors have different counts"));
        }
        Ok(Self { count, translation, rotation, scale })
    }

    fn get(&self, i: usize, notes: &mut Notes) -> Result<DMat4> {
        let vector = |r: &Option<Reader<'_>>| r.as_ref().map(|r| DVec3::from(r.get::<3>(i).map(f64::from)));
        let rotation = self.rotation.as_ref().map(|r| DQuat::from_array(r.get::<4>(i).map(f64::from)));
        trs(vector(&self.translation), rotation, vector(&self.scale), notes)
    }
}
