//! SPIR-V from the build, and specialisation constants.

use super::device::Device;
use super::error::{Context, Result};
use ash::vk;
use std::sync::Arc;

/// The SPIR-V of `glsl/<pass>/<file>`, compiled by the build script.
macro_rules! spirv {
    ($pass:literal, $file:literal) => {
        include_bytes!(concat!(env!("OUT_DIR"), "/", $pass, ".", $file, ".spv")).as_slice()
    };
}
pub(crate) use spirv;

/// Values of the specialisation constants 0, 1, 2, …
#[derive(Clone, Debug, Default)]
pub struct Specialisation(pub Vec<u32>);

impl Specialisation {
    pub(super) fn entries(&self) -> Vec<vk::SpecializationMapEntry> {
        (0..self.0.len() as u32)
            .map(|id| vk::SpecializationMapEntry { constant_id: id, offset: id * 4, size: 4 })
            .collect()
    }
}

/// A shader module, needed only while its pipeline is made.
pub(super) struct ShaderModule {
    pub(super) raw: vk::ShaderModule,
    device: Arc<Device>,
}

impl ShaderModule {
    pub(super) fn new(device: &Arc<Device>, spirv: &[u8]) -> Result<Self> {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(spirv);
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
