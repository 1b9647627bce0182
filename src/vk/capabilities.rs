//! What a device can do, asked once; every choice between a feature and its fallback reads it here.

use super::error::{Error, Result};
use super::forced::Forced;
use super::instance::{Instance, PhysicalDevice};
use ash::{ext, khr, vk};
use std::ffi::CStr;

/// Limits and optional features that the passes depend on.
#[derive(Clone, Debug)]
pub struct Capabilities {
    /// Vulkan's own limits.
    pub limits: vk::PhysicalDeviceLimits,
    /// Largest number of views of one multi-view render pass.
    pub max_views: u32,
    /// Largest single allocation in bytes.
    pub max_allocation: u64,
    /// Sum of the device-local heaps in bytes. Of a CPU, whose heap is nominal (llvmpipe: 2 GiB, seen in Mesa 22.3.6), the
    /// machine's memory, where that is known. It does not depend on what else runs, so that no choice does.
    pub device_memory: u64,
    /// Bytes of the device-local heaps that the driver expects this process to get now (VK_EXT_memory_budget), where it says
    /// so. For reports alone: it differs from run to run.
    pub memory_budget: Option<u64>,
    /// Indirect draws take their count from a buffer; without it, draws left over are drawn with zero instances.
    pub draw_indirect_count: bool,
    /// More than one draw per indirect call; without it, one call per draw.
    pub multi_draw_indirect: bool,
    /// `gl_PrimitiveID` in fragment shaders; without it, triangles are drawn unindexed.
    pub primitive_id: bool,
    /// One draw may go to several views. llvmpipe (seen in Mesa 22.3.6) puts triangles that it clips into the wrong view
    /// then: there, every view is a subpass of its own, with a one-bit view mask.
    pub multiview_draws: bool,
    /// Triangles are clipped before they are set up. SwiftShader takes winding and depth from corners before they are
    /// clipped, rounded to 1/16 of a texel, and loses what goes on far behind the eye: there, the vertex stage clips.
    pub clips_before_setup: bool,
    /// Integer attachments can be combined bit by bit.
    pub logic_op: bool,
    /// Indices of vertices may have all 32 bits; without it, no more than `limits.max_draw_indexed_index_value`.
    pub index_uint32: bool,
    /// The device comes by way of another API (VK_KHR_portability_subset), as on macOS.
    pub portability_subset: bool,
    /// Valid bits of a timestamp on the queue; 0 means no timestamps.
    pub timestamp_bits: u32,
    /// Nanoseconds a timestamp tick.
    pub timestamp_period: f64,
    /// Invocations of a subgroup, where compute shaders may ballot in one.
    pub subgroup: Option<u32>,
    /// Least and largest subgroup that a compute shader may ask for; both are the device's own without
    /// VK_EXT_subgroup_size_control.
    pub subgroup_sizes: [u32; 2],
    /// A compute shader can ask for a subgroup size, and for subgroups without idle invocations.
    pub full_subgroups: bool,
    /// Queue family with graphics and compute.
    pub queue_family: u32,
}

/// One line of `hemicube info`: a feature and what lacking it costs.
pub struct Requirement {
    /// Feature as Vulkan names it.
    pub name: &'static str,
    /// What it serves, or what its absence costs.
    pub cost: &'static str,
    /// Whether the device has it.
    pub has: fn(&Capabilities) -> bool,
}

/// The optional features that a plan reads.
pub const REQUIREMENTS: &[Requirement] = &[
    Requirement {
        name: "drawIndirectCount",
        cost: "without it every cluster is an indirect draw, culled ones with zero instances",
        has: |c| c.draw_indirect_count,
    },
    Requirement {
        name: "multiDrawIndirect",
        cost: "without it scenes are captured without culling",
        has: |c| c.multi_draw_indirect,
    },
    Requirement {
        name: "geometryShader (gl_PrimitiveID)",
        cost: "without it captures draw unindexed triangles, three vertices each",
        has: |c| c.primitive_id,
    },
    Requirement {
        name: "multi-view draws (not llvmpipe)",
        cost: "without them small scenes are drawn once a view",
        has: |c| c.multiview_draws,
    },
    Requirement {
        name: "clipping before set-up (not SwiftShader)",
        cost: "without it captures cut triangles to the view themselves and draw each as five",
        has: |c| c.clips_before_setup,
    },
    Requirement {
        name: "fullDrawIndexUint32",
        cost: "without it scenes have no more vertices than maxDrawIndexedIndexValue",
        has: |c| c.index_uint32,
    },
    Requirement { name: "timestamps", cost: "without them GPU times are not reported", has: |c| c.timestamp_bits > 0 },
];

impl Capabilities {
    /// What `device` has once its driver's faults are set aside and `forced` is put in; an error names what is missing and has
    /// no fallback.
    pub(super) fn query(instance: &Instance, device: &PhysicalDevice, forced: &Forced) -> Result<Self> {
        let offered = Self::offered(instance, device)?;
        let mut has = offered.clone();
        let is_llvmpipe = device.driver_id == vk::DriverId::MESA_LLVMPIPE;
        has.primitive_id &= !is_llvmpipe;
        has.multiview_draws &= !is_llvmpipe;
        has.clips_before_setup &= device.driver_id != vk::DriverId::GOOGLE_SWIFTSHADER;
        forced.apply(&offered, &mut has)?;
        Ok(has)
    }

    /// What the driver says it can do.
    fn offered(instance: &Instance, device: &PhysicalDevice) -> Result<Self> {
        let missing = |feature: &str, purpose| Error::MissingFeature {
            device: device.name.clone(),
            feature: feature.to_owned(),
            purpose,
        };
        if device.api_version < vk::API_VERSION_1_2 {
            return Err(missing("Vulkan 1.2", "every pass is written for"));
        }
        let queue_family = queue_family(instance, device.raw)
            .ok_or_else(|| missing("a queue with graphics and compute", "runs every pass"))?;
        let extensions = instance.device_extensions(device.raw)?;
        let (features, features_1_1, features_1_2) = features(instance, device.raw);
        if features_1_1.multiview == vk::FALSE {
            return Err(missing("multiview", "draws the faces of a hemicube in one render pass"));
        }
        if features.draw_indirect_first_instance == vk::FALSE {
            return Err(missing("drawIndirectFirstInstance", "tells a culled cluster which triangles it holds"));
        }
        if features.shader_clip_distance == vk::FALSE {
            return Err(missing("shaderClipDistance", "cuts captures at the horizon"));
        }
        check_formats(instance, device, &missing)?;
        let (limits, properties_1_1) = properties(instance, device.raw);
        // SAFETY: the handle comes from this instance.
        let memory = unsafe { instance.raw.get_physical_device_memory_properties(device.raw) };
        let heaps = memory
            .memory_heaps_as_slice()
            .iter()
            .filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL))
            .map(|heap| heap.size)
            .sum();
        let machine = (device.kind == vk::PhysicalDeviceType::CPU).then(machine_memory).flatten();
        let has_extension = |name: &CStr| extensions.iter().any(|extension| extension.as_c_str() == name);
        let has_sizes = has_extension(ext::subgroup_size_control::NAME);
        let sizes = has_sizes.then(|| subgroup_sizes(instance, device.raw)).flatten();
        // SAFETY: as above.
        let family =
            unsafe { instance.raw.get_physical_device_queue_family_properties(device.raw) }[queue_family as usize];
        Ok(Self {
            limits,
            max_views: properties_1_1.max_multiview_view_count,
            max_allocation: properties_1_1.max_memory_allocation_size,
            subgroup: talking_subgroup(&properties_1_1),
            subgroup_sizes: sizes.unwrap_or([properties_1_1.subgroup_size; 2]),
            full_subgroups: sizes.is_some(),
            device_memory: machine.unwrap_or(heaps),
            memory_budget: has_extension(ext::memory_budget::NAME).then(|| memory_budget(instance, device.raw)),
            draw_indirect_count: features_1_2.draw_indirect_count == vk::TRUE,
            multi_draw_indirect: features.multi_draw_indirect == vk::TRUE,
            primitive_id: features.geometry_shader == vk::TRUE,
            multiview_draws: true,
            clips_before_setup: true,
            logic_op: features.logic_op == vk::TRUE,
            index_uint32: features.full_draw_index_uint32 == vk::TRUE,
            portability_subset: has_extension(khr::portability_subset::NAME),
            timestamp_bits: family.timestamp_valid_bits,
            timestamp_period: f64::from(limits.timestamp_period),
            queue_family,
        })
    }
}

/// Bytes of the machine's memory, where Linux says so.
fn machine_memory() -> Option<u64> {
    let all = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = all.lines().find_map(|line| line.strip_prefix("MemTotal:"))?;
    line.split_whitespace().next()?.parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

type Features = (
    vk::PhysicalDeviceFeatures,
    vk::PhysicalDeviceVulkan11Features<'static>,
    vk::PhysicalDeviceVulkan12Features<'static>,
);

fn features(instance: &Instance, device: vk::PhysicalDevice) -> Features {
    let mut v11 = vk::PhysicalDeviceVulkan11Features::default();
    let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
    let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut v11).push_next(&mut v12);
    // SAFETY: the chain's structs live through the call; the device implements 1.2, so both are known to it.
    unsafe { instance.raw.get_physical_device_features2(device, &mut all) };
    let base = all.features;
    v11.p_next = std::ptr::null_mut();
    v12.p_next = std::ptr::null_mut();
    (base, v11, v12)
}

fn properties(
    instance: &Instance,
    device: vk::PhysicalDevice,
) -> (vk::PhysicalDeviceLimits, vk::PhysicalDeviceVulkan11Properties<'static>) {
    let mut v11 = vk::PhysicalDeviceVulkan11Properties::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut v11);
    // SAFETY: the chain's structs live through the call.
    unsafe { instance.raw.get_physical_device_properties2(device, &mut all) };
    let limits = all.properties.limits;
    v11.p_next = std::ptr::null_mut();
    (limits, v11)
}

/// Least and largest subgroup of compute shaders, where they may ask for one.
fn subgroup_sizes(instance: &Instance, device: vk::PhysicalDevice) -> Option<[u32; 2]> {
    let mut control = vk::PhysicalDeviceSubgroupSizeControlFeatures::default();
    let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut control);
    // SAFETY: the chain's structs live through the call; the device has the extension.
    unsafe { instance.raw.get_physical_device_features2(device, &mut all) };
    let mut sizes = vk::PhysicalDeviceSubgroupSizeControlProperties::default();
    let mut all = vk::PhysicalDeviceProperties2::default().push_next(&mut sizes);
    // SAFETY: as above.
    unsafe { instance.raw.get_physical_device_properties2(device, &mut all) };
    let usable = control.subgroup_size_control == vk::TRUE
        && control.compute_full_subgroups == vk::TRUE
        && sizes.required_subgroup_size_stages.contains(vk::ShaderStageFlags::COMPUTE);
    usable.then_some([sizes.min_subgroup_size, sizes.max_subgroup_size])
}

/// Bytes of the device-local heaps that this process may expect to get.
fn memory_budget(instance: &Instance, device: vk::PhysicalDevice) -> u64 {
    let mut budget = vk::PhysicalDeviceMemoryBudgetPropertiesEXT::default();
    let mut all = vk::PhysicalDeviceMemoryProperties2::default().push_next(&mut budget);
    // SAFETY: the chain's structs live through the call; the device has the extension.
    unsafe { instance.raw.get_physical_device_memory_properties2(device, &mut all) };
    let heaps = all.memory_properties;
    let local = |heap: &vk::MemoryHeap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL);
    heaps.memory_heaps_as_slice().iter().zip(budget.heap_budget).filter(|(h, _)| local(h)).map(|(_, b)| b).sum()
}

fn talking_subgroup(properties: &vk::PhysicalDeviceVulkan11Properties<'_>) -> Option<u32> {
    let needed = vk::SubgroupFeatureFlags::BALLOT | vk::SubgroupFeatureFlags::SHUFFLE;
    let talks = properties.subgroup_supported_operations.contains(needed)
        && properties.subgroup_supported_stages.contains(vk::ShaderStageFlags::COMPUTE);
    talks.then_some(properties.subgroup_size)
}

fn queue_family(instance: &Instance, device: vk::PhysicalDevice) -> Option<u32> {
    let both = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    // SAFETY: the handle comes from this instance.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(device) };
    families.iter().position(|family| family.queue_flags.contains(both)).map(|index| index as u32)
}

/// Formats beyond the ones that Vulkan makes mandatory.
fn check_formats(
    instance: &Instance,
    device: &PhysicalDevice,
    missing: &dyn Fn(&str, &'static str) -> Error,
) -> Result<()> {
    let has = |format, needed| {
        // SAFETY: the handle comes from this instance.
        let properties = unsafe { instance.raw.get_physical_device_format_properties(device.raw, format) };
        properties.optimal_tiling_features.contains(needed)
    };
    let blend = vk::FormatFeatureFlags::COLOR_ATTACHMENT_BLEND;
    if !has(vk::Format::R32G32B32A32_SFLOAT, blend) {
        return Err(missing("blending on R32G32B32A32_SFLOAT", "sums the records' splats"));
    }
    let depth = vk::FormatFeatureFlags::DEPTH_STENCIL_ATTACHMENT | vk::FormatFeatureFlags::SAMPLED_IMAGE;
    if !has(vk::Format::D32_SFLOAT, depth) {
        return Err(missing("sampled D32_SFLOAT", "holds shadow and capture depths"));
    }
    Ok(())
}
