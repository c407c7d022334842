//! Building an image, and what its file says.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use chaincell_kernel::{Choice, cut_words, term_states};
use chaincell_scenes::Tier;
use object::elf::SHF_ALLOC;
use object::{Object, ObjectSection, ObjectSymbol, SectionFlags, SectionKind};

use crate::case::{Ready, STATES, Shape, Tool};
use crate::target::{FOLDERS, Target};
use crate::trace::Traces;

/// Names of an allocator's functions, inside whatever mangling.
const ALLOCATOR: [&str; 5] =
    ["__rust_alloc", "__rust_realloc", "__rdl_alloc", "__rg_alloc", "GlobalAlloc"];

/// Package of the board that stands by.
const STAND_BY: &str = "chaincell-stand-by";

/// Initial values that an image may have in RAM \[bytes\]: the kernel has none, so a body of any size
/// lies in `.bss`.
const DATA_BYTES_MAX: u64 = 64;

/// A feature of the image, and the traces that it needs.
#[derive(Clone, Copy)]
pub struct With<'t> {
    pub feature: &'static str,
    pub traces: Option<&'t Traces>,
}

/// Which program compiles images, from the environment that `tests/firmware/run` sets.
pub struct Workshop {
    /// The workspace of the image.
    pub workspace: PathBuf,
    /// With the packages' compiler: its path and its libraries; `core` is built from source.
    packages: Option<(String, String)>,
    /// The linker where the packages' compiler has none of its own.
    linker: Option<String>,
    /// The compiler's version.
    pub compiler: String,
}

impl Workshop {
    pub fn new(workspace: PathBuf) -> Result<Self> {
        let variable = |name: &str| std::env::var(name).ok();
        let packages = variable("CHAINCELL_IMAGE_RUSTC").zip(variable("CHAINCELL_IMAGE_LIBRARIES"));
        let mut rustc = Command::new(packages.as_ref().map_or("rustc", |(rustc, _)| rustc));
        if let Some((_, libraries)) = &packages {
            rustc.env("LD_LIBRARY_PATH", libraries);
        }
        let said = rustc.arg("--version").output().context("rustc")?;
        let compiler = String::from_utf8(said.stdout)?.trim().to_owned();
        let linker = variable("CHAINCELL_IMAGE_LINKER");
        Ok(Self { workspace, packages, linker, compiler })
    }

    /// Cargo for the image of a scene.
    fn cargo(&self, what: &str, target: &Target, ready: &Ready, tier: Tier) -> Command {
        let mut cargo = self.cargo_of(what, "chaincell-firmware", target);
        cargo.envs(environment(ready, tier));
        cargo
    }

    /// Cargo for a package of images.
    fn cargo_of(&self, what: &str, package: &str, target: &Target) -> Command {
        let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
        cargo.current_dir(&self.workspace).args([what, "--locked", "--profile=image"]);
        cargo.args(["--package", package, "--target", target.triple]);
        cargo.arg("--target-dir").arg(self.folder(target));
        let mut flags = format!("-Ctarget-cpu={}", target.cpu);
        if let Some((rustc, libraries)) = &self.packages {
            cargo.arg("-Zbuild-std=core").env("RUSTC", rustc).env("RUSTC_BOOTSTRAP", "1");
            cargo.env("LD_LIBRARY_PATH", libraries);
        }
        if let Some(linker) = &self.linker {
            flags += &format!(" -Clinker={linker}");
        }
        let triple = target.triple.to_uppercase().replace('-', "_");
        cargo.env(format!("CARGO_TARGET_{triple}_RUSTFLAGS"), flags);
        cargo.env_remove("RUSTFLAGS").env_remove("CARGO_ENCODED_RUSTFLAGS");
        cargo
    }

    /// Where a target's images and what comes of them go.
    pub fn folder(&self, target: &Target) -> PathBuf {
        self.workspace.join("target").join(FOLDERS[target.folder])
    }

    /// Builds the image of a scene. The outer error is trouble, the inner one the compiler's
    /// refusal.
    pub fn build(
        &self,
        target: &Target,
        ready: &Ready,
        tier: Tier,
        with: Option<With<'_>>,
    ) -> Result<std::result::Result<Image, String>> {
        let mut cargo = self.cargo("build", target, ready, tier);
        let feature = with.map_or("", |with| with.feature);
        cargo.args(with.map(|with| format!("--features={}", with.feature)));
        cargo.args(match ready.case.tool {
            Some(_) if ready.is_cut() => Some("--features=cut"),
            Some(_) if ready.model.relaxes() => Some("--features=relax"),
            Some(_) => Some("--features=surface"),
            None => Some("--features=nodal").filter(|_| ready.model.is_nodal()),
        });
        if let Some(traces) = with.and_then(|with| with.traces) {
            cargo.envs(traces.environment());
        }
        let built = cargo.output().context("cargo")?;
        if !built.status.success() {
            return Ok(Err(String::from_utf8_lossy(&built.stderr).into_owned()));
        }
        let from = self.folder(target).join(target.triple).join("image/chaincell-firmware");
        let (core, scene, tier) = (target.name, ready.case.name, tier.name());
        let name = format!("{core}-{scene}-{tier}{feature}");
        let to = self.folder(target).join(name).with_extension("elf");
        std::fs::copy(&from, &to).with_context(|| format!("{}", from.display()))?;
        Ok(Ok(Image::read(&to, target, ready)?))
    }

    /// Builds the board that stands by, with a model; returns the path of its image.
    pub fn build_stand_by(&self, target: &Target, model: &Path) -> Result<PathBuf> {
        let mut cargo = self.cargo_of("build", STAND_BY, target);
        let built = cargo.env("CHAINCELL_MODEL", model).output().context("cargo")?;
        ensure!(built.status.success(), "{STAND_BY}: {}", String::from_utf8_lossy(&built.stderr));
        Ok(self.folder(target).join(target.triple).join("image").join(STAND_BY))
    }

    /// Holds its source against the lints; `false` where the compiler has none.
    pub fn lint_stand_by(&self, target: &Target, model: &Path) -> Result<bool> {
        if self.packages.is_some() {
            return Ok(false);
        }
        let mut cargo = self.cargo_of("clippy", STAND_BY, target);
        cargo.env("CHAINCELL_MODEL", model).args(["--", "-Dwarnings"]);
        ensure!(cargo.status().context("cargo")?.success(), "{STAND_BY}: lints");
        Ok(true)
    }

    /// Holds the image's source against the lints; `false` where the compiler has none.
    pub fn lint(&self, target: &Target, ready: &Ready, traces: &Traces) -> Result<bool> {
        if self.packages.is_some() {
            return Ok(false);
        }
        let mut cargo = self.cargo("clippy", target, ready, Tier::F32);
        cargo.envs(traces.environment());
        cargo.args(["--features=canary-panic,checks", "--", "-Dwarnings"]);
        ensure!(cargo.status().context("cargo")?.success(), "{}: lints", target.triple);
        Ok(true)
    }
}

/// What `image/build.rs` reads.
fn environment(ready: &Ready, tier: Tier) -> Vec<(String, String)> {
    let states = STATES.iter().map(|(name, _)| {
        let is_there = ready.states().iter().any(|(other, _)| other == name);
        let path = is_there.then(|| ready.state_path(name).display().to_string());
        (format!("CHAINCELL_{name}"), path.unwrap_or_default())
    });
    let all = constants(ready, tier).into_iter().map(|(name, value)| (name.to_owned(), value));
    all.chain(states).collect()
}

/// Its constants.
fn constants(ready: &Ready, tier: Tier) -> [(&'static str, String); 15] {
    let (settings, model) = (ready.settings(), &ready.model);
    let held: Vec<String> = ready.scene.held.iter().map(u32::to_string).collect();
    [
        ("CHAINCELL_MODEL", ready.model_path.display().to_string()),
        ("CHAINCELL_CELLS", model.cells().to_string()),
        ("CHAINCELL_COARSE_FUNCTIONS", model.coarse_functions().to_string()),
        ("CHAINCELL_TERM_STATES", term_states(model.kept_states()).to_string()),
        ("CHAINCELL_NODAL", model.is_nodal().to_string()),
        ("CHAINCELL_SCHEME", ready.scene.scheme.into()),
        ("CHAINCELL_TIER", tier.name().into()),
        ("CHAINCELL_HELD", held.join(",")),
        ("CHAINCELL_WORDS", cut_words(model).to_string()),
        ("CHAINCELL_TOOL", ready.case.tool.map_or_else(String::new, |its| tool(ready, its))),
        ("CHAINCELL_SWEEPS", settings.sweeps.to_string()),
        ("CHAINCELL_UNLOADING", format!("{:?}", settings.unloading)),
        ("CHAINCELL_MAX_FORCE_BITS", settings.max_force_n.to_bits().to_string()),
        ("CHAINCELL_TICKS", ready.ticks.to_string()),
        ("CHAINCELL_REACH_BITS", ready.scene.reach_m.to_bits().to_string()),
    ]
}

/// The tool, for `image/build.rs`.
fn tool(ready: &Ready, tool: Tool) -> String {
    let Tool { shape, near, anchors } = tool;
    let Shape::Sphere { radius_m, friction } = shape else {
        return format!("{},{near},{anchors}", ready.scene.name);
    };
    let [x, y, z] = ready.scene.tools.map_or([0.0; 3], |tools| tools.start_m[0]);
    let [r, f, x, y, z] = [radius_m, friction, x, y, z].map(f32::to_bits);
    format!("{r},{f},{x},{y},{z},{near},{anchors}")
}

/// A linked image.
pub struct Image {
    pub path: PathBuf,
    /// Code, constants, model and initial values, without the measurement's own worst states.
    pub flash_bytes: u64,
    /// Statics.
    pub ram_bytes: u64,
    /// Allocator functions in it.
    pub allocators: Vec<String>,
}

impl Image {
    fn read(path: &Path, target: &Target, ready: &Ready) -> Result<Self> {
        let bytes = std::fs::read(path)?;
        let file = object::File::parse(&*bytes)?;
        let (mut flash_bytes, mut ram_bytes, mut data_bytes) = (0, 0, 0);
        for section in file.sections() {
            let SectionFlags::Elf { sh_flags, .. } = section.flags() else { continue };
            // What is left for stack and heap takes up all the rest of the RAM.
            let left = matches!(section.name()?, ".stack" | ".heap");
            if (sh_flags & SHF_ALLOC).0 == 0 || left {
                continue;
            }
            let in_ram = section.address() >= target.ram;
            ram_bytes += if in_ram { section.size() } else { 0 };
            if in_ram && section.kind() != SectionKind::UninitializedData {
                data_bytes += section.size();
            }
            flash_bytes += section.file_range().map_or(0, |(_, size)| size);
        }
        let states = ready.states().len() as u64 * 12 * ready.model.cells() as u64;
        ensure!(flash_bytes > states, "{}: no code in it", path.display());
        ensure!(
            data_bytes <= DATA_BYTES_MAX,
            "{}: {data_bytes} bytes of initial values in RAM, at most {DATA_BYTES_MAX}",
            path.display()
        );
        let allocators = allocators(path)?;
        Ok(Self { path: path.into(), flash_bytes: flash_bytes - states, ram_bytes, allocators })
    }
}

/// Names of an allocator's functions among the symbols of a program.
pub fn allocators(path: &Path) -> Result<Vec<String>> {
    let bytes = std::fs::read(path)?;
    let file = object::File::parse(&*bytes)?;
    let names = file.symbols().filter_map(|symbol| symbol.name().ok().map(str::to_owned));
    Ok(names.filter(|name| ALLOCATOR.iter().any(|part| name.contains(part))).collect())
}
