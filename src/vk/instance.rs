//! The Vulkan instance, the devices it lists and the validation messages it counts.

use super::error::{Context, Error, Result};
use ash::{Entry, ext, khr, vk};
use std::ffi::{CStr, CString, c_void};
use std::io::Write;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

const VALIDATION_LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// A Vulkan 1.2 instance without surfaces.
pub struct Instance {
    pub(super) entry: Entry,
    pub(super) raw: ash::Instance,
    /// Whether VK_EXT_debug_utils is there for names, labels and messages.
    pub(super) has_debug_utils: bool,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Arc<AtomicU32>,
}

/// A device as the instance lists it.
#[derive(Clone)]
pub struct PhysicalDevice {
    /// Vulkan's handle.
    pub raw: vk::PhysicalDevice,
    /// Name by the driver.
    pub name: String,
    /// Driver name and version in words.
    pub driver: String,
    /// Which driver it is.
    pub driver_id: vk::DriverId,
    /// Discrete, integrated, virtual, CPU.
    pub kind: vk::PhysicalDeviceType,
    /// Vulkan version it implements.
    pub api_version: u32,
}

impl Instance {
    /// Loads Vulkan; with `validate`, core and synchronisation validation report into the log and are counted.
    pub fn new(validate: bool) -> Result<Arc<Self>> {
        // SAFETY: loading the system's Vulkan loader runs its initialisers, which is what we ask for.
        let entry = unsafe { Entry::load() }.map_err(|e| Error::NoLoader(e.to_string()))?;
        if validate && !layer_exists(&entry, VALIDATION_LAYER) {
            return Err(Error::NoValidationLayer);
        }
        let has_debug_utils = extension_exists(&entry, ext::debug_utils::NAME);
        let raw = create_instance(&entry, validate, has_debug_utils)?;
        let messages = Arc::new(AtomicU32::new(0));
        let mut this = Self { entry, raw, has_debug_utils, messenger: None, messages };
        if validate {
            this.listen()?;
        }
        Ok(Arc::new(this))
    }

    /// Number of validation warnings and errors so far.
    pub fn validation_messages(&self) -> u32 {
        self.messages.load(Ordering::Relaxed)
    }

    /// Every device the loader lists, in its order.
    pub fn physical_devices(&self) -> Result<Vec<PhysicalDevice>> {
        // SAFETY: the instance is alive.
        let devices = unsafe { self.raw.enumerate_physical_devices() }.during("listing devices")?;
        Ok(devices.into_iter().map(|raw| self.describe(raw)).collect())
    }

    /// Names of the extensions that `device` has.
    pub(super) fn device_extensions(&self, device: vk::PhysicalDevice) -> Result<Vec<CString>> {
        // SAFETY: the handle comes from this instance.
        let extensions =
            unsafe { self.raw.enumerate_device_extension_properties(device) }.during("listing extensions")?;
        Ok(extensions.iter().filter_map(|e| e.extension_name_as_c_str().ok()).map(CStr::to_owned).collect())
    }

    fn describe(&self, raw: vk::PhysicalDevice) -> PhysicalDevice {
        let mut driver = vk::PhysicalDeviceDriverProperties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut driver);
        // SAFETY: `raw` comes from this instance; the chain's structs live through the call.
        unsafe { self.raw.get_physical_device_properties2(raw, &mut properties) };
        let base = properties.properties;
        let text = |s: std::result::Result<&CStr, _>| s.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        PhysicalDevice {
            raw,
            name: text(base.device_name_as_c_str()),
            driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
            driver_id: driver.driver_id,
            kind: base.device_type,
            api_version: base.api_version,
        }
    }

    fn listen(&mut self) -> Result<()> {
        let utils = ext::debug_utils::Instance::new(&self.entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(on_message))
            .user_data(Arc::as_ptr(&self.messages).cast_mut().cast());
        // SAFETY: the counter that `user_data` points to lives in `self`, which destroys the messenger first.
        let messenger =
            unsafe { utils.create_debug_utils_messenger(&info, None) }.during("creating the debug messenger")?;
        self.messenger = Some((utils, messenger));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        // SAFETY: every device holds an Arc of this instance, so all of them are gone.
        unsafe {
            if let Some((utils, messenger)) = self.messenger.take() {
                utils.destroy_debug_utils_messenger(messenger, None);
            }
            self.raw.destroy_instance(None);
        }
    }
}

fn create_instance(entry: &Entry, validate: bool, debug_utils: bool) -> Result<ash::Instance> {
    let application = vk::ApplicationInfo::default()
        .application_name(c"hemicube")
        .engine_name(c"hemicube")
        .api_version(vk::API_VERSION_1_2);
    let layers: Vec<_> = validate.then_some(VALIDATION_LAYER.as_ptr()).into_iter().collect();
    // Drivers on top of another API (MoltenVK) are listed only when they are asked for.
    let portability = extension_exists(entry, khr::portability_enumeration::NAME);
    let extensions: Vec<_> = [(debug_utils, ext::debug_utils::NAME), (portability, khr::portability_enumeration::NAME)]
        .into_iter()
        .filter_map(|(wanted, name)| wanted.then_some(name.as_ptr()))
        .collect();
    let flags =
        if portability { vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR } else { vk::InstanceCreateFlags::empty() };
    let enabled = [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&enabled);
    let mut info = vk::InstanceCreateInfo::default()
        .flags(flags)
        .application_info(&application)
        .enabled_layer_names(&layers)
        .enabled_extension_names(&extensions);
    if validate {
        info = info.push_next(&mut features);
    }
    // SAFETY: all pointers in `info` live through the call.
    match unsafe { entry.create_instance(&info, None) } {
        // The loader's word for finding no driver at all.
        Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => Err(Error::NoDevice),
        created => created.during("creating the Vulkan instance"),
    }
}

fn layer_exists(entry: &Entry, name: &CStr) -> bool {
    // SAFETY: no precondition beyond a loaded entry.
    let layers = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
    layers.iter().any(|layer| layer.layer_name_as_c_str() == Ok(name))
}

fn extension_exists(entry: &Entry, name: &CStr) -> bool {
    // SAFETY: no precondition beyond a loaded entry.
    let extensions = unsafe { entry.enumerate_instance_extension_properties(None) }.unwrap_or_default();
    extensions.iter().any(|extension| extension.extension_name_as_c_str() == Ok(name))
}

/// Counts a message and prints it: silence is what the tests require.
unsafe extern "system" fn on_message(
    _severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _types: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    counter: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: `counter` is the instance's AtomicU32 and `data` is valid during the callback, both by Vulkan's contract.
    unsafe {
        (*counter.cast::<AtomicU32>()).fetch_add(1, Ordering::Relaxed);
        if let Some(message) = (*data).message_as_c_str() {
            // Where nobody reads it, its number is still told.
            let _ = writeln!(std::io::stderr(), "validation: {}", message.to_string_lossy());
        }
    }
    vk::FALSE
}
