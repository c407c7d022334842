//! The machine that a report was measured on, as far as the system tells.

use serde::Serialize;

/// Processor, system and load.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Machine {
    /// Name of the processor.
    pub processor: String,
    /// Cores that this process may use.
    pub cores: usize,
    /// Operating system and instruction set.
    pub system: String,
    /// Whether AVX2 is there for the kernel's vector path.
    pub avx2: bool,
    /// Load averages over 1, 5 and 15 minutes at the start of the report.
    pub load: String,
    /// Whether the program was built with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// What this machine says of itself; unknown is empty.
    #[must_use]
    pub fn read() -> Self {
        let file = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
        let cpu = file("/proc/cpuinfo");
        let name = cpu.lines().find(|line| line.starts_with("model name"));
        let processor = name.and_then(|line| line.split_once(':')).map_or("", |(_, name)| name);
        let load: Vec<String> =
            file("/proc/loadavg").split_whitespace().take(3).map(str::to_owned).collect();
        Self {
            processor: processor.trim().to_owned(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            avx2: chaincell_kernel::VectorUnit::find().is_some(),
            load: load.join(" "),
            optimised: !cfg!(debug_assertions),
        }
    }
}
