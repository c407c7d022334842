//! Tells the linker where code and data go. The emulated board has more of both.

use std::error::Error;
use std::path::PathBuf;

const MEMORY: &str = "MEMORY {
 FLASH : ORIGIN = 0x00000000, LENGTH = 1M
 RAM : ORIGIN = 0x20000000, LENGTH = 256K
}";

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("memory.x"), MEMORY)?;
    println!("cargo:rustc-link-search={}", out.display());
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=build.rs");
    Ok(())
}
