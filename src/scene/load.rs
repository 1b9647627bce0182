//! The loader: one glTF file, the files it names, one [`Scene`].
//!
//! # What is read
//! Triangles (lists, strips, fans; indexed or not) of the default scene, else of the first scene, else of all nodes,
//! else (a library of meshes) of every mesh as it stands;
//! base colour, normal map, emission, alpha mask, samplers, vertex colours, texture coordinates (two sets a material); cameras;
//! the extensions KHR_lights_punctual, KHR_materials_emissive_strength, KHR_materials_pbrSpecularGlossiness (its diffuse
//! part), KHR_mesh_quantization, KHR_node_visibility, KHR_draco_mesh_compression, KHR_texture_transform, EXT_mesh_gpu_instancing, EXT_meshopt_compression,
//! KHR_meshopt_compression, EXT_texture_webp.
//!
//! Skins and morph targets give meshes their pose: at rest, or at a moment of one of the file's animations ([`Pose`]; all
//! interpolations; nodes' places, turns, sizes and morph weights, also by KHR_animation_pointer). A skinned mesh stands
//! where its joints are, whatever its node's transform.
//!
//! # What is not
//! Every surface is Lambertian: its albedo is the base colour, metallic and roughness are ignored. A light's `range` is
//! ignored. Blended surfaces are cut off at alpha 0.5.
//! Each of these says so in [`Scene::notes`] where it changes the picture.
//!
//! # Files that break the format
//! Errors wherever the meaning is unclear or something is missing that is used: broken JSON or GLB, wrong types,
//! references to nothing, data past its buffer's end, positions that are not finite, node cycles, nodes with two
//! parents, unknown required extensions. Tolerated, because the picture is clear all the same:
//!
//! | broken | what happens |
//! |---|---|
//! | anything in what nothing drawn uses: animations, skins, unused accessors, images, materials | not looked at |
//! | accessor `min`/`max` wrong or missing, alignment of offsets and strides, buffer view `target` | not needed |
//! | component types that core glTF does not allow for an attribute | read as KHR_mesh_quantization says |
//! | empty lists, properties that glTF does not know, undeclared extensions | ignored |
//! | normals, tangents of a wrong length | brought to length 1; zero or NaN: taken from the triangles |
//! | rotations of a wrong length | brought to length 1; zero: none |
//! | texture coordinates that are not finite | 0 |
//! | base colour and vertex colour outside [0, 1] | clamped |
//! | a node with both `matrix` and translation, rotation or scale | the matrix counts |
//! | a vertex count that is no multiple of three | the rest is left out |
//! | triangles without area | left out, even if that is all of them |
//! | a buffer without URI in a .gltf, up to 64 KiB | zeros |
//! | GLB: more chunks, bytes after the end, lengths that are no multiple of four | the first chunk of each kind counts |
//! | textures that name no image | left out |
//! | pictures that are missing or broken | grey as base colour, a smooth surface, no emission |
//! | JSON with a byte order mark, as UTF-16, padded with zeros | read as UTF-8 |
//! | data URIs in other spellings; back slashes or a bare % in file names | read as they are meant |
//! | a scene's root that is listed twice, or has a parent | drawn once |
//! | primitives and accessors without elements | left out |
//! | images whose `mimeType` or extension lies | told by their bytes |
//! | camera clip planes | not used |

use super::error::{Fault, Kind, Result, SceneError, Within};
use super::gltf::animation::{self, Poses};
use super::gltf::assemble::{self, Draw, Needs};
use super::gltf::buffers::Buffers;
pub use super::gltf::container::Resolver;
use super::gltf::deform::{self, Deformer, Posed};
use super::gltf::document::{Document, item};
use super::gltf::nodes::{self, Placed};
use super::gltf::primitive::{self, Budget, Primitive};
use super::gltf::textures::TextureStore;
use super::gltf::{Notes, container, extensions, lights, materials};
use super::{Animation, Material, Scene};
use std::collections::{BTreeMap, btree_map::Entry};
use std::io::{self, Read};
use std::path::Path;

/// How large a scene may get. Sizes are checked before memory is taken.
#[derive(Debug, Clone, Copy)]
pub struct Limits {
    /// Triangles after all instances are placed; within it, a file may make at most 2²⁰ + 64 for each of its bytes.
    pub triangles: u64,
    /// Texels of all textures together.
    pub texels: u64,
}

impl Default for Limits {
    /// 2²⁶ triangles, 2²⁸ texels.
    fn default() -> Self {
        Self { triangles: 1 << 26, texels: 1 << 28 }
    }
}

/// The moment of a file's animations that is loaded; by default the rest pose, which no animation changes.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pose {
    /// The animation, by name or else by index; with a time alone, the file's first.
    pub animation: Option<String>,
    /// Seconds since its start; with an animation alone, 0. Beyond its keys, the first and the last key hold.
    pub seconds: Option<f64>,
}

impl Pose {
    /// Whether no animation is applied.
    pub fn is_rest(&self) -> bool {
        self.animation.is_none() && self.seconds.is_none()
    }
}

/// How a file is loaded.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// How large the scene may get.
    pub limits: Limits,
    /// The moment that is shown.
    pub pose: Pose,
}

impl From<Limits> for Options {
    fn from(limits: Limits) -> Self {
        Self { limits, ..Self::default() }
    }
}

/// Loads a `.gltf` or `.glb` file and the files that it names, in its rest pose.
pub fn load(path: &Path) -> std::result::Result<Scene, SceneError> {
    load_with(path, Options::default())
}

/// Loads a `.gltf` or `.glb` file and the files that it names.
pub fn load_with(path: &Path, options: impl Into<Options>) -> std::result::Result<Scene, SceneError> {
    let file = path.display().to_string();
    let bytes = read_file(path).map_err(|e| Fault::new(Kind::Read, format!("cannot read: {e}")).in_file(&file))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    load_from_slice(&file, &bytes, &|name| read_file(&folder.join(name)), options)
}

/// Loads a scene from bytes. `file` names it in messages and, by its stem, the scene; `resolve` finds what it names.
pub fn load_from_slice(
    file: &str,
    bytes: &[u8],
    resolve: &Resolver<'_>,
    options: impl Into<Options>,
) -> std::result::Result<Scene, SceneError> {
    let scene = load_bytes(bytes, resolve, &options.into()).map_err(|fault| fault.in_file(file))?;
    let name = Path::new(file).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    Ok(Scene { name, ..scene })
}

/// All bytes of a regular file: devices and pipes could go on for ever.
fn read_file(path: &Path) -> io::Result<Vec<u8>> {
    let metadata = std::fs::metadata(path)?;
    if !metadata.is_file() {
        return Err(io::Error::other("not a regular file"));
    }
    let mut bytes = Vec::with_capacity(metadata.len() as usize);
    std::fs::File::open(path)?.take(metadata.len()).read_to_end(&mut bytes)?;
    Ok(bytes)
}

fn load_bytes(bytes: &[u8], resolve: &Resolver<'_>, options: &Options) -> Result<Scene> {
    let limits = options.limits;
    let mut notes = Notes::default();
    let container = container::open(bytes, &mut notes)?;
    let document = Document::parse(&container.json)?;
    extensions::check(&document, &mut notes)?;
    let buffers = Buffers::new(&document, &container, resolve);
    let poses = animation::poses(&document, &buffers, &options.pose, &mut notes)?;
    let placed = nodes::flatten(&document, &poses, &mut notes)?;
    let meshes = read_meshes(&document, &buffers, &placed, limits, &mut notes)?;
    let mut drawn =
        Drawn { document: &document, buffers: &buffers, placed: &placed, meshes: &meshes, posed: BTreeMap::new() };
    let allowed = limits.triangles.min((1 << 20) + 64 * (bytes.len() as u64 + buffers.fetched_bytes()));
    drawn.check_count(allowed)?;
    drawn.posed = pose(&drawn, &poses, allowed, &mut notes)?;
    let draws = drawn.list(&mut notes)?;
    let mut scene = drawn.build(draws, limits, &mut notes)?;
    scene.lights = lights::lights(&document, &placed, scene.origin, &mut notes)?;
    scene.cameras = lights::cameras(&document, &placed, scene.origin, &mut notes)?;
    scene.animations = animations(&document, &buffers);
    notes.add_if("animations are not played: --time SECONDS shows a moment of them", {
        options.pose.is_rest() && !scene.animations.is_empty()
    });
    notes.append(buffers.take_notes());
    scene.notes = notes.into_lines();
    Ok(scene)
}

/// Primitives of a mesh, each with its index in the file.
type Mesh = Vec<(usize, Primitive)>;

/// Reads every mesh that a node draws, once.
fn read_meshes(
    document: &Document,
    buffers: &Buffers<'_>,
    placed: &[Placed],
    limits: Limits,
    notes: &mut Notes,
) -> Result<BTreeMap<usize, Mesh>> {
    let mut meshes = BTreeMap::new();
    let mut budget = Budget(limits.triangles.saturating_mul(3).min(u64::from(u32::MAX)));
    for p in placed.iter().filter(|p| !p.hidden) {
        let Some(mesh) = document.nodes[p.node].mesh else { continue };
        if let Entry::Vacant(place) = meshes.entry(mesh) {
            item(&document.meshes, "mesh", mesh).within(|| document.node_label(p.node))?;
            place.insert(read_mesh(document, buffers, mesh, &mut budget, notes)?);
        }
    }
    Ok(meshes)
}

fn read_mesh(
    document: &Document,
    buffers: &Buffers<'_>,
    mesh: usize,
    budget: &mut Budget,
    notes: &mut Notes,
) -> Result<Mesh> {
    let mut primitives = Vec::new();
    for (index, primitive) in document.meshes[mesh].primitives.iter().enumerate() {
        let at = || format!("{} primitive {index}", document.mesh_label(mesh));
        if let Some(primitive) = primitive::read(document, buffers, primitive, budget, notes).within(at)? {
            check_positions(&primitive).within(at)?;
            primitives.push((index, primitive));
        }
    }
    Ok(primitives)
}

fn check_positions(primitive: &Primitive) -> Result<()> {
    match primitive.positions.iter().find(|p| p.iter().any(|x| !x.is_finite())) {
        Some(p) => {
            let what = format!("accessor {} POSITION: {p:?} is not finite", primitive.position_accessor);
            Err(Fault::invalid(what))
        }
        None => Ok(()),
    }
}

/// What the default scene draws.
struct Drawn<'a, 'b> {
    document: &'a Document,
    buffers: &'a Buffers<'b>,
    placed: &'a [Placed],
    meshes: &'a BTreeMap<usize, Mesh>,
    /// Meshes in a pose of their own, by the node's place in `placed`.
    posed: BTreeMap<usize, Posed>,
}

/// How often joints and morph targets may move a vertex, a triangle that is allowed.
const MOVES_A_TRIANGLE: u64 = 64;

impl Drawn<'_, '_> {
    /// Each primitive at each place, by the document's material (none: last) and then in node order.
    fn list(&self, notes: &mut Notes) -> Result<Vec<Draw<'_>>> {
        let mut draws = Vec::new();
        for (place, node, mesh, primitives) in self.drawn_meshes() {
            let (primitives, at) = match self.posed.get(&place) {
                Some(posed) => (&posed.primitives, posed.to_world),
                None => (primitives, node.to_world),
            };
            let instances = nodes::instances(self.document, self.buffers, &self.document.nodes[node.node], notes);
            for instance in instances.within(|| self.document.node_label(node.node))? {
                let to_world = at * instance;
                let draw = |(index, primitive)| Draw { primitive, to_world, material: 0, mesh, index };
                draws.extend(primitives.iter().map(|(index, primitive)| draw((*index, primitive))));
            }
        }
        draws.retain(|d| !d.primitive.triangles.is_empty());
        draws.sort_by_key(|d| (d.primitive.material.is_none(), d.primitive.material));
        Ok(draws)
    }

    /// Refuses more triangles than allowed before a single instance is made.
    fn check_count(&self, allowed: u64) -> Result<()> {
        let mut total = 0u64;
        for (_, node, _, primitives) in self.drawn_meshes() {
            let count = nodes::instance_count(self.document, self.buffers, &self.document.nodes[node.node]);
            let count = count.within(|| self.document.node_label(node.node))? as u64;
            let triangles = primitives.iter().map(|(_, p)| p.triangles.len() as u64).sum::<u64>();
            total = total.saturating_add(count.saturating_mul(triangles.max(1)));
        }
        if total > allowed {
            let what = format!("{total} triangles once every instance is placed; {allowed} are allowed");
            return Err(Fault::new(Kind::TooLarge, what));
        }
        Ok(())
    }

    /// Nodes that draw a mesh, each with its place among all.
    fn drawn_meshes(&self) -> impl Iterator<Item = (usize, &Placed, usize, &Mesh)> {
        self.placed.iter().enumerate().filter_map(|(place, p)| {
            let mesh = self.document.nodes[p.node].mesh.filter(|_| !p.hidden)?;
            Some((place, p, mesh, self.meshes.get(&mesh)?))
        })
    }

    /// Materials, textures and all triangles.
    fn build(&self, mut draws: Vec<Draw<'_>>, limits: Limits, notes: &mut Notes) -> Result<Scene> {
        let mut scene = Scene { origin: assemble::origin(&draws), ..Scene::default() };
        let mut store = TextureStore::new(self.document, self.buffers, limits.texels);
        let mut last = None;
        for draw in &mut draws {
            let wanted = draw.primitive.material;
            if last != Some(wanted) {
                let material = self.material(draw, &mut store, notes).within(|| self.label(draw))?;
                scene.materials.push(material);
                last = Some(wanted);
            }
            draw.material = scene.materials.len() as u32 - 1;
        }
        scene.textures = store.textures;
        let needs = needs(&scene.materials, &draws);
        for draw in &draws {
            assemble::append(&mut scene, draw, needs, notes).within(|| self.label(draw))?;
        }
        drop_unused_materials(&mut scene);
        if draws.is_empty() {
            return Err(Fault::new(Kind::Empty, ""));
        }
        notes.add_if("none of the triangles has an area: nothing is seen", scene.triangles.is_empty());
        Ok(scene)
    }

    fn material(&self, draw: &Draw<'_>, store: &mut TextureStore<'_, '_>, notes: &mut Notes) -> Result<Material> {
        match draw.primitive.material {
            Some(index) => materials::convert(self.document, index, store, notes),
            None => Ok(materials::default_material()),
        }
    }

    fn label(&self, draw: &Draw<'_>) -> String {
        format!("{} primitive {}", self.document.mesh_label(draw.mesh), draw.index)
    }
}

/// Streams that the materials read.
fn needs(materials: &[Material], draws: &[Draw<'_>]) -> Needs {
    let textures = |m: &Material| [m.base_texture, m.normal_texture, m.emission_texture];
    let set = |set| materials.iter().flat_map(textures).flatten().any(|t| t.set == set);
    Needs {
        tangents: materials.iter().any(|m| m.normal_texture.is_some()),
        uvs: [set(0), set(1)],
        colors: draws.iter().any(|d| !d.primitive.colors.is_empty()),
    }
}

/// Forgets materials all of whose triangles were left out.
fn drop_unused_materials(scene: &mut Scene) {
    let used: Vec<u32> = scene.parts.iter().map(|p| p.material).collect();
    let mut old: Vec<Option<Material>> = std::mem::take(&mut scene.materials).into_iter().map(Some).collect();
    scene.materials = used.iter().filter_map(|m| old[*m as usize].take()).collect();
    for (part, material) in scene.parts.iter_mut().zip(0..) {
        part.material = material;
    }
}

fn animations(document: &Document, buffers: &Buffers<'_>) -> Vec<Animation> {
    let all = animation::names(document).into_iter().zip(animation::lengths(document, buffers));
    all.map(|(name, seconds)| Animation { name, seconds }).collect()
}

/// Meshes that skins or morph targets change, by the node's place among `drawn.placed`.
fn pose(drawn: &Drawn<'_, '_>, poses: &Poses, allowed: u64, notes: &mut Notes) -> Result<BTreeMap<usize, Posed>> {
    let worlds = deform::worlds(drawn.document, drawn.placed, poses);
    let budget = allowed.saturating_mul(MOVES_A_TRIANGLE).into();
    let deformer = Deformer { document: drawn.document, buffers: drawn.buffers, poses, worlds: &worlds, budget };
    let mut posed = BTreeMap::new();
    for (index, placed) in drawn.placed.iter().enumerate().filter(|(_, p)| !p.hidden) {
        let Some(mesh) = drawn.document.nodes[placed.node].mesh.and_then(|m| drawn.meshes.get(&m)) else { continue };
        let changed = deformer.pose(placed, mesh, notes).within(|| drawn.document.node_label(placed.node))?;
        posed.extend(changed.map(|changed| (index, changed)));
    }
    Ok(posed)
}

#[cfg(test)]
#[path = "load_tests/mod.rs"]
mod tests;
