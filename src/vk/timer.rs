//! Timestamp queries: growing pools of pairs, read after the submission.

use super::commands::Commands;
use super::device::Device;
use super::error::{Context, Result};
use ash::vk;
use std::sync::Arc;

const QUERIES: u32 = 512;

/// Begin and end of one timed span, in milliseconds on the clock of [`Device::opened`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Begin.
    pub begin_ms: f64,
    /// End.
    pub end_ms: f64,
}

/// Writes timestamps and reads them back. Does nothing on queues without timestamps.
///
/// The clock of the queue is set by that of the CPU, as late as is needed for no timestamp to lie before its submission.
pub(super) struct Timer {
    pools: Vec<vk::QueryPool>,
    used: u32,
    /// Ticks of the first timestamp, and its milliseconds on the clock of the device.
    epoch: Option<(u64, f64)>,
    submitted_ms: f64,
    device: Arc<Device>,
}

impl Timer {
    pub(super) fn new(device: &Arc<Device>) -> Self {
        Self { pools: Vec::new(), used: 0, epoch: None, submitted_ms: 0.0, device: device.clone() }
    }

    pub(super) fn available(&self) -> bool {
        self.device.capabilities.timestamp_bits > 0
    }

    /// Writes a timestamp once all before it is done, and before all after it starts; the caller puts the barriers.
    pub(super) fn stamp(&mut self, commands: &Commands) -> Result<u32> {
        let (pool, query) = ((self.used / QUERIES) as usize, self.used % QUERIES);
        if pool == self.pools.len() {
            self.pools.push(self.create_pool()?);
        }
        let device = &self.device.raw;
        // SAFETY: outside a render pass; the query lies in the pool and outlives the submission.
        unsafe {
            device.cmd_reset_query_pool(commands.raw, self.pools[pool], query, 1);
            device.cmd_write_timestamp(commands.raw, vk::PipelineStageFlags::BOTTOM_OF_PIPE, self.pools[pool], query);
        }
        self.used += 1;
        Ok(self.used - 1)
    }

    /// The timestamps written so far are about to be submitted.
    pub(super) fn submitted(&mut self) {
        self.submitted_ms = self.device.opened.elapsed().as_secs_f64() * 1e3;
    }

    /// Drops the timestamps since the last reading: their submission failed.
    pub(super) fn forget(&mut self) {
        self.used = 0;
    }

    /// Which timestamps of a submission that failed were written; as many as the device still answers for.
    pub(super) fn written(&self) -> Vec<bool> {
        const WRITTEN: usize = 1;
        let mut states = vec![[0_u64; 2]; self.used as usize];
        for (pool, states) in self.pools.iter().zip(states.chunks_mut(QUERIES as usize)) {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WITH_AVAILABILITY;
            // SAFETY: the queries belong to the pool; without WAIT the call does not block. NOT_READY leaves what is known.
            match unsafe { self.device.raw.get_query_pool_results(*pool, 0, states, flags) } {
                Ok(()) | Err(vk::Result::NOT_READY) => {}
                Err(_) => return Vec::new(),
            }
        }
        states.iter().map(|state| state[WRITTEN] != 0).collect()
    }

    /// All timestamps since the last reading, in milliseconds since [`Device::opened`]; the submission has been waited for.
    pub(super) fn read(&mut self) -> Result<Vec<f64>> {
        let mut ticks = vec![0_u64; self.used as usize];
        for (pool, ticks) in self.pools.iter().zip(ticks.chunks_mut(QUERIES as usize)) {
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: the queries were written by a submission that is complete.
            unsafe { self.device.raw.get_query_pool_results(*pool, 0, ticks, flags) }.during("reading timestamps")?;
        }
        self.used = 0;
        let bits = self.device.capabilities.timestamp_bits;
        let mask = if bits >= 64 { u64::MAX } else { (1 << bits) - 1 };
        let period = self.device.capabilities.timestamp_period * 1e-6;
        let first = ticks.first().copied().unwrap_or(0) & mask;
        let (epoch, zero_ms) = self.epoch.get_or_insert((first, self.submitted_ms));
        let since = |tick: u64| (tick.wrapping_sub(*epoch) & mask) as f64 * period;
        *zero_ms = zero_ms.max(self.submitted_ms - since(first));
        Ok(ticks.iter().map(|tick| *zero_ms + since(*tick)).collect())
    }

    fn create_pool(&self) -> Result<vk::QueryPool> {
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(QUERIES);
        // SAFETY: the device is alive.
        unsafe { self.device.raw.create_query_pool(&info, None) }.during("creating a query pool")
    }
}

impl Drop for Timer {
    fn drop(&mut self) {
        for pool in &self.pools {
            // SAFETY: every submission that used the pool has been waited for.
            self.device.destroy(|raw| unsafe { raw.destroy_query_pool(*pool, None) });
        }
    }
}
