//! Lays the model, the scheme and the memory of the target into the image.
//!
//! From the environment, all of them set by `tests/firmware/runner`:
//!
//! - `CHAINCELL_MODEL`: path of a model image; what it says of itself: `CHAINCELL_CELLS`,
//!   `CHAINCELL_COARSE_FUNCTIONS`, `CHAINCELL_TERM_STATES`, `CHAINCELL_NODAL` (`true` or `false`)
//! - `CHAINCELL_LONG`, `CHAINCELL_SHORT`, with a sphere also `CHAINCELL_REST`, else empty: paths of states
//! - `CHAINCELL_SCHEME`, `CHAINCELL_TIER`: scheme and number type
//! - `CHAINCELL_HELD`: input ids of the held cells, with commas
//! - `CHAINCELL_TOOL`: a tool that meets the body's surface in place of held cells, empty for
//!   none. A sphere: radius, friction, x, y, z where it begins (bits of `f32`, \[m\]), slots for triangles
//!   and for samples that friction holds, with commas. Or the tool of a golden scene: its name, and the slots
//! - `CHAINCELL_WORDS`, with the feature `words`: words of memory for cuts or strain
//! - `CHAINCELL_SWEEPS`, `CHAINCELL_UNLOADING` (a variant's name), `CHAINCELL_MAX_FORCE_BITS`:
//!   settings
//! - `CHAINCELL_TRACE`, `CHAINCELL_ALTERED`, with the feature `checks`: paths of a trace of the scene
//!   and of one with an altered record; `CHAINCELL_TRACE_TICKS`: ticks of both
//! - `CHAINCELL_TICKS`, `CHAINCELL_REACH_BITS`: the motion's ticks and its reach \[m\]
//!
//! Numbers whose name ends in BITS are the bits of an `f32`.

use std::error::Error;
use std::fmt::Write;
use std::path::PathBuf;
use std::{env, fs};

/// Flash and RAM that the linker has [bytes]; the measurement's own states lie beyond that flash.
const FLASH_BYTES: u32 = 2 << 20;
const RAM_BYTES: u32 = 1 << 20;
/// States that the image ticks from.
const STATES: [&str; 3] = ["LONG", "SHORT", "REST"];

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(env::var("OUT_DIR")?);
    let (scene, states_bytes) = scene()?;
    fs::write(out.join("scene.rs"), scene)?;
    let arm = env::var("CARGO_CFG_TARGET_ARCH")? == "arm";
    fs::write(out.join("memory.x"), memory(arm, FLASH_BYTES + states_bytes))?;
    println!("cargo:rustc-link-search={}", out.display());
    if !arm {
        println!("cargo:rustc-link-arg=-Tmemory.x");
    }
    println!("cargo:rustc-link-arg=-Tlink.x");
    println!("cargo:rerun-if-changed=build.rs");
    Ok(())
}

/// A variable of the environment, whose change builds the image anew.
fn variable(name: &str) -> Result<String, String> {
    println!("cargo:rerun-if-env-changed={name}");
    env::var(name).map_err(|_| format!("{name} is not set: build the image by tests/firmware/run"))
}

/// The scheme's type: the one place where scheme and number type are chosen.
fn scheme(held: usize) -> Result<String, String> {
    let (scheme, tier) = (variable("CHAINCELL_SCHEME")?, variable("CHAINCELL_TIER")?);
    let coarse_functions = variable("CHAINCELL_COARSE_FUNCTIONS")?;
    let room = match variable("CHAINCELL_NODAL")?.as_str() {
        "true" => format!("{{ elastic_room({coarse_functions}) }}"),
        _ => format!("{{ coarse_room({coarse_functions}, {held}) }}"),
    };
    match (scheme.as_str(), tier.as_str()) {
        ("track", "f32") => Ok(format!("Track<{room}>")),
        ("predict", "f32") => Ok(format!("Predict<{room}>")),
        ("euler", "f32") => Ok("Euler".into()),
        ("track", "fixed") => Ok("Track<0, fixed::types::I8F24>".into()),
        ("euler", "fixed") => Ok("Euler<fixed::types::I8F24>".into()),
        ("rkl2", "f32") => Ok("Rkl2".into()),
        _ => Err(format!("no scheme {scheme} in {tier}")),
    }
}

/// The path in a variable; a file that changes builds the image anew.
fn file(name: &str) -> Result<String, String> {
    let path = variable(name)?;
    println!("cargo:rerun-if-changed={path}");
    Ok(path)
}

/// Constants and statics of the scene, as Rust; and the bytes of the states.
fn scene() -> Result<(String, u32), Box<dyn Error>> {
    let model = file("CHAINCELL_MODEL")?;
    let held = variable("CHAINCELL_HELD")?;
    let count = held.split(',').filter(|id| !id.is_empty()).count();
    let (mut text, mut states_bytes) = (String::new(), 0);
    for name in STATES {
        let variable = format!("CHAINCELL_{name}");
        if env::var(&variable).is_ok_and(|path| path.is_empty()) {
            continue;
        }
        let path = file(&variable)?;
        let bytes = fs::metadata(&path).map_err(|why| format!("{variable} {path}: {why}"))?.len();
        states_bytes += u32::try_from(bytes)?;
        let state = format!("chaincell_kernel::include_model!({path:?})");
        writeln!(text, "pub static {name}: &[u8] = {state};")?;
    }
    writeln!(text, "pub const CELLS: usize = {};", variable("CHAINCELL_CELLS")?)?;
    writeln!(text, "pub const STATES: usize = {};", variable("CHAINCELL_TERM_STATES")?)?;
    writeln!(text, "pub const HELD: [u32; {count}] = [{held}];")?;
    for (name, kind) in [
        ("SWEEPS", "u16"),
        ("TICKS", "u32"),
        ("UNLOADING", "Unloading"),
        ("REACH_BITS", "u32"),
        ("MAX_FORCE_BITS", "u32"),
    ] {
        let value = variable(&format!("CHAINCELL_{name}"))?;
        let path = if kind == "Unloading" { "Unloading::" } else { "" };
        writeln!(text, "pub const {name}: {kind} = {path}{value};")?;
    }
    writeln!(text, "{}", tool(&variable("CHAINCELL_TOOL")?)?)?;
    writeln!(text, "pub type Scheme = {};", scheme(count)?)?;
    writeln!(text, "pub static IMAGE: &[u8] = chaincell_kernel::include_model!({model:?});")?;
    if env::var_os("CARGO_FEATURE_WORDS").is_some() {
        writeln!(text, "pub const WORDS: usize = {};", variable("CHAINCELL_WORDS")?)?;
    }
    if env::var_os("CARGO_FEATURE_CHECKS").is_some() {
        for name in ["TRACE", "ALTERED"] {
            let path = file(&format!("CHAINCELL_{name}"))?;
            writeln!(text, "pub static {name}: &[u8] = include_bytes!({path:?});")?;
        }
        let ticks = variable("CHAINCELL_TRACE_TICKS")?;
        writeln!(text, "pub const TRACE_TICKS: u32 = {ticks};")?;
    }
    Ok((text, states_bytes))
}

/// The tool and its memory.
fn tool(said: &str) -> Result<String, String> {
    let numbers: Vec<&str> = said.split(',').collect();
    match numbers[..] {
        [""] => Ok("pub const TOOLS: Option<Tools> = None;".into()),
        [radius, friction, x, y, z, near, anchors] => {
            let [radius, friction, x, y, z] =
                [radius, friction, x, y, z].map(|bits| format!("f32::from_bits({bits})"));
            Ok(format!(
                "pub const NEAR: usize = {near};\npub const ANCHORS: usize = {anchors};\n\
                 pub const TOOLS: Option<Tools> = Some(Tools {{ \
                 parts: &[&[chaincell_kernel::ToolPart::sphere({radius})]], \
                 friction: {friction}, start_m: [[{x}, {y}, {z}]; 2], turn_m: 1.0 }});"
            ))
        }
        [scene, near, anchors] => Ok(format!(
            "pub const NEAR: usize = {near};\npub const ANCHORS: usize = {anchors};\n\
             pub const TOOLS: Option<Tools> = chaincell_scenes::{scene}::SCENE.tools;"
        )),
        _ => Err(format!("CHAINCELL_TOOL {said}: seven numbers, a scene and two, or none")),
    }
}

/// Where code and data go.
fn memory(arm: bool, flash_bytes: u32) -> String {
    let (flash, ram) = if arm { (0, 0x2000_0000_u32) } else { (0x8000_0000_u32, 0x8040_0000) };
    let regions = ["TEXT", "RODATA", "DATA", "BSS", "HEAP", "STACK"].map(|region| {
        let memory = if matches!(region, "TEXT" | "RODATA") { "FLASH" } else { "RAM" };
        format!("REGION_ALIAS(\"REGION_{region}\", {memory});\n")
    });
    format!(
        "MEMORY {{\n FLASH : ORIGIN = {flash:#x}, LENGTH = {flash_bytes}\n RAM : ORIGIN = {ram:#x}, \
         LENGTH = {RAM_BYTES}\n}}\n{}",
        if arm { String::new() } else { regions.concat() }
    )
}
