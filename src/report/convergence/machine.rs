//! The machine that times were measured on.

use std::fs;

/// What a machine is, as far as the system tells.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Threads that run at once.
    pub threads: usize,
    /// Memory in GB, rounded.
    pub memory_gb: Option<u64>,
    /// Operating system and processor family.
    pub system: String,
}

impl Machine {
    /// This machine.
    pub fn this() -> Self {
        let cpus = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
        let release = fs::read_to_string("/etc/os-release").unwrap_or_default();
        let processor = field(&cpus, "model name", ':').unwrap_or_else(|| "unknown processor".into());
        let system = field(&release, "PRETTY_NAME", '=').unwrap_or_else(|| std::env::consts::OS.into());
        let memory = fs::read_to_string("/proc/meminfo").ok().and_then(|text| kilobytes(&text, "MemTotal"));
        Self {
            processor,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            memory_gb: memory.map(|kb| (kb + (1 << 19)) >> 20),
            system: format!("{}, {}", system.trim_matches('"'), std::env::consts::ARCH),
        }
    }

    /// Processes that want to run, over the last minute: with more than a fraction, times are too long.
    pub fn load() -> Option<f64> {
        fs::read_to_string("/proc/loadavg").ok()?.split_whitespace().next()?.parse().ok()
    }
}

impl std::fmt::Display for Machine {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let memory = self.memory_gb.map_or_else(String::new, |gb| format!(", {gb} GB"));
        write!(out, "{}, {} threads{memory}, {}", self.processor, self.threads, self.system)
    }
}

/// Makes [`peak_memory`] count from now on, where the system can (Linux, proc(5): `clear_refs`).
pub fn reset_peak_memory() {
    // Where this fails the peak is that of the whole process: larger, and still a bound.
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// Most bytes of memory that this process had at once.
pub fn peak_memory() -> Option<u64> {
    Some(kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM")? << 10)
}

fn field(text: &str, name: &str, separator: char) -> Option<String> {
    let mut pairs = text.lines().filter_map(|line| line.split_once(separator));
    pairs.find(|(key, _)| key.trim() == name).map(|(_, value)| value.trim().to_owned())
}

fn kilobytes(text: &str, name: &str) -> Option<u64> {
    field(text, name, ':')?.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_machine_has_a_name_and_threads() {
        let machine = Machine::this();
        assert!(machine.threads > 0 && !machine.to_string().is_empty());
        assert_eq!(field("a\t: b c\nmodel name : x", "model name", ':').as_deref(), Some("x"));
        assert_eq!(kilobytes("VmHWM:\t  2048 kB\n", "VmHWM"), Some(2048));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn peaks_are_counted_anew() {
        let held = std::hint::black_box(vec![1_u8; 64 << 20]);
        assert!(peak_memory().unwrap() > std::hint::black_box(&held).len() as u64);
        drop(held);
        reset_peak_memory();
        assert!(peak_memory().is_some());
    }
}
