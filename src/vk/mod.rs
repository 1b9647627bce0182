//! Vulkan made plain: the objects a pass needs, each owned by a value that destroys it.
//!
//! Ownership: [`Device`] is shared by `Arc`; every buffer, image and pipeline keeps one and goes before it. A value may
//! be dropped only when the GPU is done with it: every submission here is waited for ([`Commands::finish`]), so the rule
//! holds wherever a value outlives the command recording that names it.
//!
//! Threads: a device may be shared; each [`Commands`] records from a command pool of its own, and the queue is locked during
//! a submission. Waits are finite ([`Device::time_limit`]); after one that ran out, nothing of that device is destroyed.
//!
//! Synchronisation: [`pass::Recording::pass`] stands between passes with a full memory barrier, so that each pass sees all
//! that went before; within a pass, render passes state their own dependencies and [`barrier`] has the rest.

pub mod barrier;
mod buffer;
mod capabilities;
mod commands;
mod descriptors;
mod device;
mod error;
pub mod forced;
pub mod gpu_types;
mod image;
mod instance;
pub mod pass;
mod pipeline;
mod pipeline_cache;
mod render_pass;
pub(crate) mod shader;
mod texel_buffer;
mod timer;

pub use buffer::{Buffer, Memory};
pub use capabilities::{Capabilities, REQUIREMENTS, Requirement};
pub use commands::Commands;
pub use descriptors::{Binding, DescriptorSet, SetLayout};
pub use device::{Device, DeviceChoice, DeviceOptions, MemoryUse};
pub use error::{Error, Result};
pub use image::{Image, ImageDesc, Sampler};
pub use instance::{Instance, PhysicalDevice};
pub use pipeline::{ComputePipeline, GraphicsDesc, GraphicsPipeline, PipelineLayout, VertexInput};
pub use render_pass::{Attachment, Framebuffer, Load, RenderPass, RenderPassDesc};
pub use shader::{Constants, Shader, Slot, Specialisation, Values, Variants};
pub(crate) use shader::{spirv, variants};
pub use texel_buffer::{BufferView, TexelBuffer};
pub use timer::Span;
