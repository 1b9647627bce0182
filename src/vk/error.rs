//! What can go wrong between us and the driver.

use ash::vk;

/// Result of a Vulkan operation.
pub type Result<T> = std::result::Result<T, Error>;

/// A failure of the Vulkan side, naming the object and the operation.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There is no Vulkan loader on this machine.
    #[error("no Vulkan loader found ({0}); install libvulkan1 and a driver such as mesa-vulkan-drivers (lavapipe)")]
    NoLoader(String),
    /// The loader lists no device.
    #[error("no Vulkan device found; install a driver such as mesa-vulkan-drivers (lavapipe runs on any CPU)")]
    NoDevice,
    /// `--device` names nothing that is there.
    #[error("no Vulkan device is named or numbered \"{wanted}\"; there are: {available}")]
    UnknownDevice {
        /// What was asked for.
        wanted: String,
        /// What there is.
        available: String,
    },
    /// The device lacks something that has no fallback.
    #[error("device \"{device}\" lacks {feature}, which {purpose}; choose another with --device")]
    MissingFeature {
        /// Device name.
        device: String,
        /// Feature, extension or format as Vulkan names it.
        feature: String,
        /// What it is needed for.
        purpose: &'static str,
    },
    /// Validation was asked for and its layer is absent.
    #[error("--validate needs VK_LAYER_KHRONOS_validation; install vulkan-validationlayers")]
    NoValidationLayer,
    /// A size that the device cannot hold.
    #[error("{object} needs {needed}, above this device's limit of {limit}")]
    Limit {
        /// What is too large.
        object: String,
        /// How large it is.
        needed: String,
        /// The device's limit.
        limit: String,
    },
    /// The device ended a shader's loops before they were done.
    #[error(
        "the device ends loops of captures in compute before all that they see is drawn (llvmpipe: after 65,535 rounds a view); \
         render passes draw it: --capture hemicube"
    )]
    LoopsEnded {
        /// Whether whole workgroups shared each view already.
        shared: bool,
    },
    /// The memory allocator failed.
    #[error("allocating {name} ({bytes} bytes) on the device failed: {reason}")]
    Allocation {
        /// Debug name of the resource.
        name: String,
        /// Its size.
        bytes: u64,
        /// The allocator's reason.
        reason: String,
    },
    /// The driver reset the device, or it went away.
    #[error(
        "the device was lost during {content}: its driver has reset it (a pass that ran too long, or a fault); a smaller image, \
         fewer triangles or another --device may run through"
    )]
    DeviceLost {
        /// The pass, or the passes of the submission.
        content: String,
    },
    /// A submission took longer than the device is waited for.
    #[error("the device did not finish {content} within {seconds} s; choose another with --device")]
    TimedOut {
        /// The pass, or the passes of the submission.
        content: String,
        /// Seconds that it was waited for.
        seconds: f64,
    },
    /// A forced capability is not one, or the device cannot be made to have it.
    #[error("{FORCED}: \"{entry}\" {reason}", FORCED = super::forced::VARIABLE)]
    Forced {
        /// The entry.
        entry: String,
        /// What is wrong with it.
        reason: String,
    },
    /// A call returned an error code.
    #[error("{operation} failed: {result}")]
    Call {
        /// The operation and its object.
        operation: &'static str,
        /// Vulkan's code.
        result: vk::Result,
    },
}

/// Attaches the operation's name to a Vulkan result.
pub(super) trait Context<T> {
    /// Names the operation that failed.
    fn during(self, operation: &'static str) -> Result<T>;
}

impl<T> Context<T> for std::result::Result<T, vk::Result> {
    fn during(self, operation: &'static str) -> Result<T> {
        self.map_err(|result| Error::Call { operation, result })
    }
}
