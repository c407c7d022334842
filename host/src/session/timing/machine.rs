//! The machine that a report was measured on, as far as the system describes it.

use std::fs::read_to_string;

use serde::Serialize;

/// Processor, system and load.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Number of cores that this process may use.
    pub cores: usize,
    /// Operating system, release of its kernel, and instruction set.
    pub system: String,
    /// True if AVX2 is available for the kernel's vector path.
    pub avx2: bool,
    /// Load averages over 1, 5 and 15 minutes when this was read.
    pub load: String,
    /// True if the program was built with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// Reads the description of this machine; unknown parts are empty.
    #[must_use]
    pub fn read() -> Self {
        let read = |path: &str| read_to_string(path).unwrap_or_default();
        let words =
            |text: &str, count| text.split_whitespace().take(count).collect::<Vec<_>>().join(" ");
        let cpu = read("/proc/cpuinfo");
        let processor =
            cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": "));
        let release = words(&read("/proc/sys/kernel/osrelease"), 1);
        Self {
            processor: processor.map_or_else(String::new, |(_, name)| name.to_owned()),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {release} {}", std::env::consts::OS, std::env::consts::ARCH),
            avx2: chaincell_kernel::VectorUnit::find().is_some(),
            load: words(&read("/proc/loadavg"), 3),
            optimised: !cfg!(debug_assertions),
        }
    }
}
