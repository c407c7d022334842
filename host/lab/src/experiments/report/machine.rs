//! The machine that a report was measured on, as far as the system tells.

use procfs::{CpuInfo, Current, LoadAverage};
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
        let cpu = CpuInfo::current().ok();
        let processor = cpu.as_ref().and_then(|cpu| cpu.model_name(0)).unwrap_or_default();
        let load = LoadAverage::current().ok();
        let load = load.map(|of| format!("{:.2} {:.2} {:.2}", of.one, of.five, of.fifteen));
        Self {
            processor: processor.to_owned(),
            cores: std::thread::available_parallelism().map_or(1, usize::from),
            system: format!("{} {}", std::env::consts::OS, std::env::consts::ARCH),
            avx2: chaincell_kernel::VectorUnit::find().is_some(),
            load: load.unwrap_or_default(),
            optimised: !cfg!(debug_assertions),
        }
    }
}
