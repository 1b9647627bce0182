//! The barriers that the passes use.

use super::commands::Commands;
use super::image::Image;
use ash::vk;

const ANY: vk::PipelineStageFlags = vk::PipelineStageFlags::ALL_COMMANDS;

/// All before, with its writes, before all after. Between passes, where the timer needs the order anyway.
pub fn full(commands: &Commands) {
    let barrier = vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE | vk::AccessFlags::MEMORY_READ)
        .dst_access_mask(vk::AccessFlags::MEMORY_WRITE | vk::AccessFlags::MEMORY_READ);
    between(commands, [ANY, ANY], &[barrier], &[]);
}

/// Storage writes of one dispatch before the reads and writes of the next in the same pass.
pub fn dispatches(commands: &Commands) {
    let barrier = vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::SHADER_WRITE | vk::AccessFlags::TRANSFER_WRITE)
        .dst_access_mask(vk::AccessFlags::SHADER_READ | vk::AccessFlags::SHADER_WRITE);
    let stages = vk::PipelineStageFlags::COMPUTE_SHADER | vk::PipelineStageFlags::TRANSFER;
    between(commands, [stages, vk::PipelineStageFlags::COMPUTE_SHADER], &[barrier], &[]);
}

/// Device writes before reads by the CPU once the submission has been waited for: a fence alone orders, but makes nothing
/// visible to the host (Vulkan 1.3, 7.3).
pub(super) fn to_host(commands: &Commands) {
    let barrier = vk::MemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::HOST_READ);
    between(commands, [ANY, vk::PipelineStageFlags::HOST], &[barrier], &[]);
}

/// Moves all of an image from one layout to another, ordered with everything around it.
pub fn image_layout(commands: &Commands, image: &Image, from: vk::ImageLayout, to: vk::ImageLayout) {
    let barrier = vk::ImageMemoryBarrier::default()
        .src_access_mask(vk::AccessFlags::MEMORY_WRITE)
        .dst_access_mask(vk::AccessFlags::MEMORY_READ | vk::AccessFlags::MEMORY_WRITE)
        .old_layout(from)
        .new_layout(to)
        .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
        .image(image.raw)
        .subresource_range(image.all_layers());
    between(commands, [ANY, ANY], &[], &[barrier]);
}

fn between(
    commands: &Commands,
    [before, after]: [vk::PipelineStageFlags; 2],
    memory: &[vk::MemoryBarrier<'_>],
    images: &[vk::ImageMemoryBarrier<'_>],
) {
    let flags = vk::DependencyFlags::empty();
    // SAFETY: recorded outside a render pass; images outlive the submission.
    unsafe { commands.device.raw.cmd_pipeline_barrier(commands.raw, before, after, flags, memory, &[], images) };
}
