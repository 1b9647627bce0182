//! Shaders from the build: SPIR-V with what its text declares, and specialisation constants by name.

use super::device::Device;
use super::error::{Context, Result};
use ash::vk;
use std::sync::Arc;

/// A compiled shader and what its text declares, made by the build script.
#[derive(Debug)]
pub struct Shader {
    /// Pass and file.
    pub name: &'static str,
    /// Its code.
    pub spirv: &'static [u8],
    /// Its resources by set and binding.
    pub bindings: &'static [Slot],
    /// Bytes of its push constants; 0 without.
    pub push_bytes: u32,
    /// Its specialisation constants and their numbers.
    pub constants: &'static [(&'static str, u32)],
}

/// A resource that a shader declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Slot {
    /// Set.
    pub set: u32,
    /// Binding.
    pub binding: u32,
    /// Name of the variable, of a block without one that of the block.
    pub name: &'static str,
    /// Kind.
    pub kind: vk::DescriptorType,
}

/// A shader's variants: each subset of some `#define`s.
#[derive(Debug)]
pub struct Variants {
    /// Names of the `#define`s.
    pub names: &'static [&'static str],
    /// A shader for each subset; bit i of its index is the i-th name.
    pub shaders: &'static [Shader],
}

impl Variants {
    /// The shader in which the names that are paired with `true` are defined. Every name of the shader must be given.
    pub fn choose(&self, chosen: &[(&str, bool)]) -> &'static Shader {
        let bit = |(index, name): (usize, &&str)| {
            let given = chosen.iter().find(|(given, _)| given == name);
            usize::from(given.unwrap_or_else(|| panic!("the variant {name} of {:?} is not chosen", self.names)).1)
                << index
        };
        assert_eq!(chosen.len(), self.names.len(), "variants are {:?}", self.names);
        &self.shaders[self.names.iter().enumerate().map(bit).sum::<usize>()]
    }
}

/// The shader `glsl/<pass>/<file>`, compiled by the build script.
macro_rules! spirv {
    ($pass:literal, $file:literal) => {{
        static SHADER: &$crate::vk::shader::Shader = include!(concat!(env!("OUT_DIR"), "/", $pass, ".", $file, ".rs"));
        SHADER
    }};
}
pub(crate) use spirv;

/// The variants of the shader `glsl/<pass>/<file>`, compiled by the build script.
macro_rules! variants {
    ($pass:literal, $file:literal) => {{
        static VARIANTS: &$crate::vk::shader::Variants =
            include!(concat!(env!("OUT_DIR"), "/", $pass, ".", $file, ".rs"));
        VARIANTS
    }};
}
pub(crate) use variants;

/// Values of specialisation constants by name. A pipeline's constants are those of its shaders: a name that none of them
/// declares, or one that is not given, is a fault of the program and panics.
#[derive(Clone, Debug, Default)]
pub struct Constants(Vec<(&'static str, u32)>);

/// Values of the specialisation constants 0, 1, 2, …
#[derive(Clone, Debug, Default)]
pub struct Specialisation(pub Vec<u32>);

/// Values of specialisation constants, by name or by number.
#[derive(Clone, Debug)]
pub enum Values {
    /// By name; checked.
    Named(Constants),
    /// By number.
    Numbered(Specialisation),
}

impl<const N: usize> From<[(&'static str, u32); N]> for Constants {
    fn from(values: [(&'static str, u32); N]) -> Self {
        Self(values.to_vec())
    }
}

impl From<Vec<(&'static str, u32)>> for Constants {
    fn from(values: Vec<(&'static str, u32)>) -> Self {
        Self(values)
    }
}

impl Default for Values {
    fn default() -> Self {
        Self::Named(Constants::default())
    }
}

impl<T: Into<Constants>> From<T> for Values {
    fn from(values: T) -> Self {
        Self::Named(values.into())
    }
}

impl From<&Specialisation> for Values {
    fn from(values: &Specialisation) -> Self {
        Self::Numbered(values.clone())
    }
}

impl From<Specialisation> for Values {
    fn from(values: Specialisation) -> Self {
        Self::Numbered(values)
    }
}

impl Values {
    /// Each constant of `shader` with its number. `all`: the shaders of the pipeline.
    pub(super) fn of(&self, shader: &Shader, all: &[&Shader]) -> Vec<(u32, u32)> {
        let Constants(named) = match self {
            Self::Numbered(values) => return (0..).zip(values.0.iter().copied()).collect(),
            Self::Named(named) => named,
        };
        for (name, _) in named {
            let known = all.iter().any(|shader| shader.constants.iter().any(|(known, _)| known == name));
            assert!(known, "{} has no specialisation constant {name}", shader.name);
        }
        let value = |(name, number): &(&'static str, u32)| {
            let given = named.iter().find(|(given, _)| given == name);
            (*number, given.unwrap_or_else(|| panic!("the constant {name} of {} is not given", shader.name)).1)
        };
        shader.constants.iter().map(value).collect()
    }
}

/// Constants in the form that Vulkan takes.
pub(super) struct Entries {
    entries: Vec<vk::SpecializationMapEntry>,
    data: Vec<u32>,
}

impl Entries {
    pub(super) fn new(values: &[(u32, u32)]) -> Self {
        let entry = |(index, (id, _)): (usize, &(u32, u32))| vk::SpecializationMapEntry {
            constant_id: *id,
            offset: index as u32 * 4,
            size: 4,
        };
        Self {
            entries: values.iter().enumerate().map(entry).collect(),
            data: values.iter().map(|(_, value)| *value).collect(),
        }
    }

    pub(super) fn info(&self) -> vk::SpecializationInfo<'_> {
        vk::SpecializationInfo::default().map_entries(&self.entries).data(bytemuck::cast_slice(&self.data))
    }
}

/// A shader module, needed only while its pipeline is made.
pub(super) struct ShaderModule {
    pub(super) raw: vk::ShaderModule,
    device: Arc<Device>,
}

impl ShaderModule {
    pub(super) fn new(device: &Arc<Device>, shader: &Shader) -> Result<Self> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(shader.spirv);
        let info = vk::ShaderModuleCreateInfo::default().code(&words);
        // SAFETY: the code comes from shaderc.
        let raw = unsafe { device.raw.create_shader_module(&info, None) }.during("creating a shader module")?;
        Ok(Self { raw, device: device.clone() })
    }
}

impl Drop for ShaderModule {
    fn drop(&mut self) {
        // SAFETY: pipelines do not need their modules once made.
        unsafe { self.device.raw.destroy_shader_module(self.raw, None) };
    }
}
