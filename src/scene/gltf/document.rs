//! The JSON of a file, read piece by piece so that an error names its object and what is not needed cannot fail.
//!
//! Types are the `gltf` crate's, except nodes: transforms are kept in double precision.

use super::error::{Fault, Kind, Result, label};
use gltf::json;
use json::extensions::scene::khr_lights_punctual as punctual;
use serde::{Deserialize, de::DeserializeOwned};
use serde_json::{Map, Value};

/// 2⁵³: beyond it, doubles are no longer exact integers.
const LARGEST_WHOLE: f64 = 9_007_199_254_740_992.0;

/// A glTF document whose indices are still unchecked.
#[derive(Debug, Default)]
pub struct Document {
    pub extensions_used: Vec<String>,
    pub extensions_required: Vec<String>,
    pub accessors: Vec<json::Accessor>,
    pub buffers: Vec<json::Buffer>,
    pub views: Vec<json::buffer::View>,
    pub cameras: Vec<json::Camera>,
    pub images: Vec<json::Image>,
    pub lights: Vec<punctual::Light>,
    pub materials: Vec<json::Material>,
    pub meshes: Vec<json::Mesh>,
    pub nodes: Vec<Node>,
    pub samplers: Vec<json::texture::Sampler>,
    pub textures: Vec<json::Texture>,
    /// Root nodes of each scene.
    pub scenes: Vec<SceneRoots>,
    pub scene: Option<usize>,
    /// As in the file: read where a pose needs them.
    pub animations: Vec<Value>,
    pub skins: Vec<Value>,
}

/// A node: what it carries and where it stands in its parent.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct Node {
    pub name: Option<String>,
    pub camera: Option<usize>,
    pub mesh: Option<usize>,
    pub skin: Option<usize>,
    pub children: Vec<usize>,
    pub matrix: Option<[f64; 16]>,
    pub translation: Option<[f64; 3]>,
    pub rotation: Option<[f64; 4]>,
    pub scale: Option<[f64; 3]>,
    /// Weights of the mesh's morph targets, as in the file.
    pub weights: Value,
    pub extensions: NodeExtensions,
}

/// Node extensions that place something.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<LightUse>,
    #[serde(rename = "KHR_node_visibility")]
    pub visibility: Option<Visibility>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Instancing>,
}

/// KHR_node_visibility on a node.
#[derive(Debug, Deserialize)]
pub struct Visibility {
    #[serde(default = "visible")]
    pub visible: bool,
}

fn visible() -> bool {
    true
}

/// KHR_lights_punctual on a node.
#[derive(Debug, Deserialize)]
pub struct LightUse {
    pub light: usize,
}

/// EXT_mesh_gpu_instancing on a node: accessors of a transform an instance.
#[derive(Debug, Default, Deserialize)]
pub struct Instancing {
    pub attributes: InstanceAttributes,
}

/// Accessor indices.
#[derive(Debug, Default, Deserialize)]
#[serde(default, rename_all = "UPPERCASE")]
pub struct InstanceAttributes {
    pub translation: Option<usize>,
    pub rotation: Option<usize>,
    pub scale: Option<usize>,
}

/// A scene's root nodes.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
pub struct SceneRoots {
    pub nodes: Vec<usize>,
}

impl Document {
    /// Reads the JSON text and checks the version.
    pub fn parse(text: &[u8]) -> Result<Self> {
        let root = serde_json::from_slice(text).map_err(|e| Fault::new(Kind::NotGltf, format!("JSON: {e}")))?;
        let root = whole_numbers(root);
        let Value::Object(mut root) = root else {
            return Err(Fault::new(Kind::NotGltf, "the JSON is not an object"));
        };
        check_version(&root)?;
        let lights = root.get_mut("extensions").and_then(|e| e.get_mut("KHR_lights_punctual"));
        let lights = lights.and_then(|e| e.get_mut("lights")).map(Value::take);
        let document = Self {
            extensions_used: list(root.remove("extensionsUsed"), "extensionsUsed")?,
            extensions_required: list(root.remove("extensionsRequired"), "extensionsRequired")?,
            accessors: list(root.remove("accessors"), "accessor")?,
            buffers: list(root.remove("buffers"), "buffer")?,
            views: list(root.remove("bufferViews"), "bufferView")?,
            cameras: list(root.remove("cameras"), "camera")?,
            images: list(root.remove("images"), "image")?,
            lights: list(lights, "light")?,
            materials: list(root.remove("materials"), "material")?,
            meshes: list(root.remove("meshes"), "mesh")?,
            nodes: list(root.remove("nodes"), "node")?,
            samplers: list(root.remove("samplers"), "sampler")?,
            textures: list(root.remove("textures"), "texture")?,
            scenes: list(root.remove("scenes"), "scene")?,
            scene: root.remove("scene").map(|v| parse_one(v, "scene")).transpose()?,
            animations: raw(root.remove("animations")),
            skins: raw(root.remove("skins")),
        };
        Ok(document.with_meshes_in_place())
    }

    /// A library of meshes, without any node: each mesh gets a node of its own.
    fn with_meshes_in_place(mut self) -> Self {
        if self.nodes.is_empty() && self.scenes.is_empty() {
            let node = |mesh| Node { mesh: Some(mesh), ..Node::default() };
            self.nodes = (0..self.meshes.len()).map(node).collect();
        }
        self
    }

    /// `node 3 "name"`.
    pub fn node_label(&self, index: usize) -> String {
        label("node", index, self.nodes.get(index).and_then(|n| n.name.as_deref()))
    }

    /// `mesh 3 "name"`.
    pub fn mesh_label(&self, index: usize) -> String {
        label("mesh", index, self.meshes.get(index).and_then(|m| m.name.as_deref()))
    }

    /// `material 3 "name"`.
    pub fn material_label(&self, index: usize) -> String {
        label("material", index, self.materials.get(index).and_then(|m| m.name.as_deref()))
    }
}

/// `items[index]`, or a fault that says how many there are.
pub fn item<'a, T>(items: &'a [T], kind: &str, index: usize) -> Result<&'a T> {
    items
        .get(index)
        .ok_or_else(|| Fault::invalid(format!("{kind} {index} does not exist (the file has {})", items.len())))
}

/// The same JSON with whole numbers written as integers: `1.0` is one, also where an index is wanted.
fn whole_numbers(value: Value) -> Value {
    match value {
        Value::Number(n) => match n.as_f64() {
            Some(x) if n.is_f64() && x >= 0.0 && x.fract() == 0.0 && x < LARGEST_WHOLE => Value::from(x as u64),
            _ => Value::Number(n),
        },
        Value::Array(items) => Value::Array(items.into_iter().map(whole_numbers).collect()),
        Value::Object(fields) => Value::Object(fields.into_iter().map(|(k, v)| (k, whole_numbers(v))).collect()),
        other => other,
    }
}

fn check_version(root: &Map<String, Value>) -> Result<()> {
    let of = |key: &str| root.get("asset").and_then(|a| a.get(key)).and_then(Value::as_str);
    let Some(version) = of("version") else {
        return Err(Fault::new(
            Kind::NotGltf,
            "asset.version is missing; a glTF 2.0 file has \"asset\": {\"version\": \"2.0\"}",
        ));
    };
    let needed = of("minVersion").unwrap_or(version);
    let major = |v: &str| v.split('.').next().and_then(|n| n.parse::<u32>().ok());
    let minor = |v: &str| v.split('.').nth(1).and_then(|n| n.parse::<u32>().ok());
    let readable =
        major(version) == Some(2) && (needed == version || (major(needed), minor(needed)) == (Some(2), Some(0)));
    if readable {
        return Ok(());
    }
    Err(Fault::new(Kind::NotGltf, format!("it is version {needed}; convert it to glTF 2.0")))
}

fn list<T: DeserializeOwned>(value: Option<Value>, kind: &str) -> Result<Vec<T>> {
    let items = match value {
        None => return Ok(Vec::new()),
        Some(Value::Array(items)) => items,
        Some(_) => return Err(Fault::invalid(format!("the list of {kind}s is not an array"))),
    };
    let numbered = items.into_iter().enumerate();
    numbered
        .map(|(i, item)| {
            let name = item.get("name").and_then(Value::as_str).map(str::to_owned);
            parse_one(item, kind)
                .map_err(|f| Fault::invalid(format!("{}{}", label(kind, i, name.as_deref()), &f.what[kind.len()..])))
        })
        .collect()
}

/// A list whose items are looked at later, if at all.
fn raw(value: Option<Value>) -> Vec<Value> {
    match value {
        Some(Value::Array(items)) => items,
        _ => Vec::new(),
    }
}

fn parse_one<T: DeserializeOwned>(value: Value, kind: &str) -> Result<T> {
    serde_json::from_value(value).map_err(|e| Fault::invalid(format!("{kind}: {e}")))
}
