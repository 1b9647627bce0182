//! The logical device, its one queue and its memory.

use super::capabilities::Capabilities;
use super::error::{Context, Error, Result};
use super::forced::Forced;
use super::instance::{Instance, PhysicalDevice};
use super::pipeline_cache::{self, PipelineCache};
use ash::{ext, khr, vk};
use gpu_allocator::vulkan::{Allocation, Allocator, AllocatorCreateDesc};
use std::collections::BTreeMap;
use std::ffi::CString;
use std::mem::ManuallyDrop;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard};
use std::time::{Duration, Instant};

/// Which device to run on.
#[derive(Clone, Debug, Default)]
pub enum DeviceChoice {
    /// Discrete before integrated before virtual before CPU.
    #[default]
    Best,
    /// Index in the loader's order, or a part of the name, whatever its case.
    Named(String),
}

/// Which device to open, and how.
#[derive(Clone, Debug, Default)]
pub struct DeviceOptions {
    /// Which one.
    pub choice: DeviceChoice,
    /// Capabilities that it is to have or to lack.
    pub forced: Forced,
    /// The longest that a submission is waited for. `None`: five minutes, on a CPU an hour.
    pub time_limit: Option<Duration>,
    /// Where compiled pipelines are kept between runs; `None`: nowhere.
    pub cache_directory: Option<PathBuf>,
}

impl DeviceOptions {
    /// `choice`, with the capabilities that the environment forces (`HEMICUBE_FORCE`) and the cache directory that it names
    /// (`HEMICUBE_CACHE_DIR`, else the platform's).
    ///
    /// # Errors
    /// [`Error::Forced`] where the environment variable cannot be read.
    pub fn from_environment(choice: DeviceChoice) -> Result<Self> {
        Ok(Self {
            choice,
            forced: Forced::from_environment()?,
            time_limit: None,
            cache_directory: pipeline_cache::directory(),
        })
    }
}

/// Bytes of device memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryUse {
    /// Bytes in use now.
    pub now: u64,
    /// Most bytes in use at once.
    pub peak: u64,
    /// Peak bytes by the use that the resource names.
    pub by_use: BTreeMap<&'static str, u64>,
    now_by_use: BTreeMap<&'static str, u64>,
}

/// A logical device with one queue that does graphics and compute. Any number of threads may record and submit at once.
pub struct Device {
    pub(super) raw: ash::Device,
    queue: Mutex<vk::Queue>,
    /// Command pools that no [`super::Commands`] uses now.
    command_pools: Mutex<Vec<vk::CommandPool>>,
    pub(super) pipeline_cache: PipelineCache,
    /// A submission was given up and may still run: nothing that it uses can be destroyed any more.
    abandoned: AtomicBool,
    debug_utils: Option<ext::debug_utils::Device>,
    allocator: ManuallyDrop<Mutex<Allocator>>,
    memory: Mutex<MemoryUse>,
    /// The longest that a submission is waited for.
    pub time_limit: Duration,
    /// Zero of the clock of all reports.
    pub opened: Instant,
    /// What it can do.
    pub capabilities: Capabilities,
    /// Which device it is.
    pub physical: PhysicalDevice,
    /// The instance it comes from; goes last.
    pub instance: Arc<Instance>,
}

impl Device {
    /// Opens the device that `choice` names, with the capabilities that the environment forces ([`DeviceOptions`]).
    ///
    /// # Errors
    /// [`Error::NoDevice`], [`Error::UnknownDevice`], [`Error::MissingFeature`] and [`Error::Forced`].
    pub fn new(instance: Arc<Instance>, choice: &DeviceChoice) -> Result<Arc<Self>> {
        Self::open(instance, &DeviceOptions::from_environment(choice.clone())?)
    }

    /// Opens a device by `options`.
    ///
    /// # Errors
    /// As [`Device::new`].
    pub fn open(instance: Arc<Instance>, options: &DeviceOptions) -> Result<Arc<Self>> {
        let opened = Instant::now();
        let physical = choose(instance.physical_devices()?, &options.choice)?;
        let capabilities = Capabilities::query(&instance, &physical, &options.forced)?;
        let raw = create_device(&instance, &physical, &capabilities)?;
        // SAFETY: the queue family was given to the device with one queue.
        let queue = unsafe { raw.get_device_queue(capabilities.queue_family, 0) };
        let pipeline_cache = PipelineCache::load(&instance, &physical, &raw, options.cache_directory.as_deref())?;
        let debug_utils = instance.has_debug_utils.then(|| ext::debug_utils::Device::new(&instance.raw, &raw));
        let allocator = create_allocator(&instance, &raw, physical.raw)?;
        Ok(Arc::new(Self {
            raw,
            queue: Mutex::new(queue),
            command_pools: Mutex::default(),
            pipeline_cache,
            abandoned: AtomicBool::new(false),
            debug_utils,
            allocator: ManuallyDrop::new(Mutex::new(allocator)),
            memory: Mutex::default(),
            time_limit: options.time_limit.unwrap_or_else(|| time_limit(&physical)),
            opened,
            capabilities,
            physical,
            instance,
        }))
    }

    /// What happened to the file of compiled pipelines, in words.
    pub fn pipeline_cache_note(&self) -> &str {
        &self.pipeline_cache.note
    }

    /// Device memory in use, now and at its peak.
    pub fn memory(&self) -> MemoryUse {
        lock(&self.memory).clone()
    }

    /// Whether the device is a CPU: lavapipe or SwiftShader.
    pub fn is_cpu(&self) -> bool {
        self.physical.kind == vk::PhysicalDeviceType::CPU
    }

    /// The queue, for one call.
    pub(super) fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        lock(&self.queue)
    }

    /// A command pool that nothing else uses, until [`Self::return_command_pool`].
    pub(super) fn borrow_command_pool(&self) -> Result<vk::CommandPool> {
        if let Some(pool) = lock(&self.command_pools).pop() {
            return Ok(pool);
        }
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(self.capabilities.queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive.
        unsafe { self.raw.create_command_pool(&info, None) }.during("creating a command pool")
    }

    /// Frees what was recorded from `pool` and keeps it for others. No submission from it runs any more, unless it was
    /// abandoned.
    pub(super) fn return_command_pool(&self, pool: vk::CommandPool) {
        if self.is_abandoned() {
            return;
        }
        let release = vk::CommandPoolResetFlags::RELEASE_RESOURCES;
        // SAFETY: the pool was lent to one owner, who gives it back after its submission has been waited for.
        match unsafe { self.raw.reset_command_pool(pool, release) } {
            Ok(()) => lock(&self.command_pools).push(pool),
            // SAFETY: as above; the pool's owner is gone.
            Err(_) => unsafe { self.raw.destroy_command_pool(pool, None) },
        }
    }

    /// Gives up a submission that may still run: from here on nothing is destroyed, for it may be in use.
    pub(super) fn abandon(&self) {
        self.abandoned.store(true, Ordering::Release);
    }

    fn is_abandoned(&self) -> bool {
        self.abandoned.load(Ordering::Acquire)
    }

    /// Destroys an object of this device, unless a submission that may use it was abandoned.
    pub(super) fn destroy(&self, destroy: impl FnOnce(&ash::Device)) {
        if !self.is_abandoned() {
            destroy(&self.raw);
        }
    }

    pub(super) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        lock(&self.allocator)
    }

    pub(super) fn count_allocation(&self, used_for: &'static str, bytes: u64) {
        let mut guard = lock(&self.memory);
        let memory = &mut *guard;
        memory.now += bytes;
        memory.peak = memory.peak.max(memory.now);
        let now = memory.now_by_use.entry(used_for).or_default();
        *now += bytes;
        let peak = memory.by_use.entry(used_for).or_default();
        *peak = (*peak).max(*now);
    }

    pub(super) fn free(&self, used_for: &'static str, allocation: Allocation, bytes: u64) {
        let mut guard = lock(&self.memory);
        let memory = &mut *guard;
        memory.now -= bytes;
        if let Some(now) = memory.now_by_use.get_mut(used_for) {
            *now -= bytes;
        }
        drop(guard);
        if self.is_abandoned() {
            return std::mem::forget(allocation);
        }
        // Freeing fails only for an allocation that is not the allocator's.
        let _ = self.allocator().free(allocation);
    }

    /// Gives `object` a name that validation and capture tools show.
    pub(super) fn name<H: vk::Handle>(&self, object: H, name: &str) {
        let Some(utils) = &self.debug_utils else { return };
        let Ok(name) = CString::new(name) else { return };
        let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
        // SAFETY: the object belongs to this device and is alive. A failure loses a name, nothing else.
        let _ = unsafe { utils.set_debug_utils_object_name(&info) };
    }

    pub(super) fn begin_label(&self, commands: vk::CommandBuffer, label: &str) {
        let Some(utils) = &self.debug_utils else { return };
        let Ok(label) = CString::new(label) else { return };
        let info = vk::DebugUtilsLabelEXT::default().label_name(&label);
        // SAFETY: the command buffer is being recorded.
        unsafe { utils.cmd_begin_debug_utils_label(commands, &info) };
    }

    pub(super) fn end_label(&self, commands: vk::CommandBuffer) {
        if let Some(utils) = &self.debug_utils {
            // SAFETY: a label was begun in this command buffer.
            unsafe { utils.cmd_end_debug_utils_label(commands) };
        }
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        let left = lock(&self.memory)
            .now_by_use
            .iter()
            .filter(|(_, bytes)| **bytes > 0)
            .map(|(name, _)| *name)
            .collect::<Vec<_>>();
        debug_assert!(left.is_empty(), "device resources leaked: {left:?}");
        if self.is_abandoned() {
            // Its objects stay, and so must the instance.
            return std::mem::forget(self.instance.clone());
        }
        // SAFETY: all that was made from the device held an Arc of it, so it is gone and the queue is idle.
        unsafe {
            let _ = self.raw.device_wait_idle();
            self.pipeline_cache.save(&self.raw);
            self.raw.destroy_pipeline_cache(self.pipeline_cache.raw, None);
            ManuallyDrop::drop(&mut self.allocator);
            for pool in lock(&self.command_pools).drain(..) {
                self.raw.destroy_command_pool(pool, None);
            }
            self.raw.destroy_device(None);
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn choose(devices: Vec<PhysicalDevice>, choice: &DeviceChoice) -> Result<PhysicalDevice> {
    if devices.is_empty() {
        return Err(Error::NoDevice);
    }
    let found = match choice {
        DeviceChoice::Best => devices.iter().min_by_key(|device| rank(device.kind)),
        DeviceChoice::Named(wanted) => match wanted.parse::<usize>() {
            Ok(index) => devices.get(index),
            Err(_) => devices.iter().find(|d| d.name.to_lowercase().contains(&wanted.to_lowercase())),
        },
    };
    found.cloned().ok_or_else(|| Error::UnknownDevice {
        wanted: match choice {
            DeviceChoice::Named(wanted) => wanted.clone(),
            DeviceChoice::Best => String::new(),
        },
        available: devices
            .iter()
            .enumerate()
            .map(|(i, d)| format!("{i} \"{}\"", d.name))
            .collect::<Vec<_>>()
            .join(", "),
    })
}

fn rank(kind: vk::PhysicalDeviceType) -> u32 {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => 0,
        vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
        vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
        vk::PhysicalDeviceType::CPU => 3,
        _ => 4,
    }
}

/// A driver resets a GPU after seconds, so that minutes are enough for what does run; a CPU takes its time.
fn time_limit(physical: &PhysicalDevice) -> Duration {
    Duration::from_secs(if physical.kind == vk::PhysicalDeviceType::CPU { 3600 } else { 300 })
}

fn create_device(instance: &Instance, physical: &PhysicalDevice, has: &Capabilities) -> Result<ash::Device> {
    let priorities = [1.0];
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(has.queue_family).queue_priorities(&priorities)];
    let features = vk::PhysicalDeviceFeatures::default()
        .draw_indirect_first_instance(true)
        .shader_clip_distance(true)
        .multi_draw_indirect(has.multi_draw_indirect)
        .geometry_shader(has.primitive_id)
        .logic_op(has.logic_op)
        .full_draw_index_uint32(has.index_uint32);
    let mut features_1_1 = vk::PhysicalDeviceVulkan11Features::default().multiview(true);
    let mut features_1_2 = vk::PhysicalDeviceVulkan12Features::default().draw_indirect_count(has.draw_indirect_count);
    let mut subgroups = vk::PhysicalDeviceSubgroupSizeControlFeatures::default()
        .subgroup_size_control(true)
        .compute_full_subgroups(true);
    let extensions: Vec<_> = [
        (has.portability_subset, khr::portability_subset::NAME),
        (has.full_subgroups, ext::subgroup_size_control::NAME),
    ]
    .into_iter()
    .filter_map(|(wanted, name)| wanted.then_some(name.as_ptr()))
    .collect();
    let mut info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&extensions)
        .enabled_features(&features)
        .push_next(&mut features_1_1)
        .push_next(&mut features_1_2);
    if has.full_subgroups {
        info = info.push_next(&mut subgroups);
    }
    // SAFETY: all pointers in `info` live through the call; every feature enabled was reported.
    unsafe { instance.raw.create_device(physical.raw, &info, None) }.during("creating the Vulkan device")
}

fn create_allocator(instance: &Instance, device: &ash::Device, physical: vk::PhysicalDevice) -> Result<Allocator> {
    // Blocks grow from 4 MB as the scene asks for more: the allocator's own start of 256 MB is most of a small run.
    let sizes = gpu_allocator::AllocationSizes::new(4 << 20, 4 << 20)
        .with_max_device_memblock_size(256 << 20)
        .with_max_host_memblock_size(256 << 20);
    Allocator::new(&AllocatorCreateDesc {
        instance: instance.raw.clone(),
        device: device.clone(),
        physical_device: physical,
        debug_settings: Default::default(),
        buffer_device_address: false,
        allocation_sizes: sizes,
    })
    .map_err(|e| Error::Allocation { name: "the allocator".into(), bytes: 0, reason: e.to_string() })
}
