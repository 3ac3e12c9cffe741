//! What a measurement has to say about the machine, as far as Linux tells.

use std::fs;

use telamon::measure::bench::MemoryProbe;

/// The commit that the program was built from, where the build knew it.
pub(super) const COMMIT: Option<&str> = option_env!("TELAMON_COMMIT");

/// Name of the processor.
pub(super) fn processor() -> String {
    let text = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let named = text.lines().find_map(|line| line.strip_prefix("model name")?.split_once(':'));
    named.map_or("unknown processor", |(_, name)| name.trim()).to_owned()
}

/// Threads that run at once.
pub(super) fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Memory of this process, from `/proc`.
#[derive(Debug)]
pub(super) struct ProcessMemory;

impl MemoryProbe for ProcessMemory {
    fn reset(&self) {
        // proc(5): 5 resets the peak. Where that is not allowed, the peak is that since the start.
        let _ = fs::write("/proc/self/clear_refs", "5");
    }

    fn peak(&self) -> Option<u64> {
        let text = fs::read_to_string("/proc/self/status").ok()?;
        kibibytes(&text, "VmHWM:")
    }
}

/// A line of one of `/proc`'s files in bytes.
pub(super) fn kibibytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 64 MiB that are written to are in the peak.
    #[cfg(target_os = "linux")]
    #[test]
    fn the_peak_is_that_of_the_process() {
        ProcessMemory.reset();
        let before = ProcessMemory.peak().expect("Linux tells");
        let memory = std::hint::black_box(vec![1_u8; 64 << 20]);
        let peak = ProcessMemory.peak().expect("Linux tells");
        // Other tests run beside this one, and may free some of theirs.
        assert!(peak > before.saturating_add(32 << 20), "{before} {peak}");
        drop(memory);
        assert!(!processor().is_empty() && threads() > 0);
    }
}
