//! What a run cost.

use super::tracer::Tracer;
use std::time::{Duration, Instant};

/// Time and rays of a run.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Time on the clock.
    pub wall: Duration,
    /// Processor time of all threads together, to 10 ms; where the system does not tell, the clock's × threads.
    pub cpu: Duration,
    /// Rays traced.
    pub rays: u64,
}

impl Cost {
    /// Rays per second of processor time.
    pub fn rays_per_cpu_second(&self) -> f64 {
        self.rays as f64 / self.cpu.as_secs_f64().max(1e-3)
    }
}

/// Measures from its making on.
pub struct Meter {
    begun: Instant,
    cpu: Option<Duration>,
    rays: u64,
}

impl Meter {
    /// Starts now.
    pub fn start(tracer: &Tracer) -> Self {
        Self { begun: Instant::now(), cpu: process_time(), rays: tracer.rays() }
    }

    /// Cost since the start.
    pub fn cost(&self, tracer: &Tracer) -> Cost {
        let wall = self.begun.elapsed();
        let guess = wall * rayon::current_num_threads() as u32;
        let cpu = self.cpu.zip(process_time()).map_or(guess, |(from, to)| to.saturating_sub(from));
        Cost { wall, cpu, rays: tracer.rays() - self.rays }
    }
}

/// User and system time of this process, where /proc tells (proc(5): fields 14 and 15, in ticks of 10 ms).
pub fn process_time() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name stands in parentheses and may hold spaces.
    let mut fields = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || fields.next()?.parse::<u64>().ok();
    Some(Duration::from_millis(10 * (ticks()? + ticks()?)))
}
