//! The emulated microcontrollers.

/// A core with its board.
#[derive(Debug, Clone, Copy)]
pub struct Target {
    /// Name in tables, budgets and `--only`.
    pub name: &'static str,
    /// What it is.
    pub core: &'static str,
    /// The compiler's target.
    pub triple: &'static str,
    /// The compiler's `target-cpu`.
    pub cpu: &'static str,
    /// QEMU's program and machine.
    pub emulator: [&'static str; 2],
    /// Where statics lie: the first address of RAM.
    pub ram: u64,
    /// Whether the core has an FPU.
    pub fpu: bool,
    /// Where its images are built: place in [`FOLDERS`].
    pub folder: usize,
}

/// Cargo builds one image at a time in a folder; each of these builds about half of all images.
pub const FOLDERS: [&str; 2] = ["images", "images-2"];

/// All of them. `target-cpu=cortex-m7` takes 2.5 % fewer instructions than the plain target.
pub const TARGETS: [Target; 4] = [
    Target {
        name: "m7",
        core: "Cortex-M7, FPU",
        triple: "thumbv7em-none-eabihf",
        cpu: "cortex-m7",
        emulator: ["qemu-system-arm", "mps2-an500"],
        ram: 0x2000_0000,
        fpu: true,
        folder: 0,
    },
    Target {
        name: "m4",
        core: "Cortex-M4, FPU",
        triple: "thumbv7em-none-eabihf",
        cpu: "cortex-m4",
        emulator: ["qemu-system-arm", "mps2-an386"],
        ram: 0x2000_0000,
        fpu: true,
        folder: 1,
    },
    Target {
        name: "m3",
        core: "Cortex-M3, no FPU",
        triple: "thumbv7m-none-eabi",
        cpu: "cortex-m3",
        emulator: ["qemu-system-arm", "mps2-an385"],
        ram: 0x2000_0000,
        fpu: false,
        folder: 0,
    },
    Target {
        name: "rv32",
        core: "RISC-V 32, F",
        triple: "riscv32imafc-unknown-none-elf",
        cpu: "generic-rv32",
        emulator: ["qemu-system-riscv32", "virt"],
        ram: 0x8040_0000,
        fpu: true,
        folder: 1,
    },
];
