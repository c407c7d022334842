//! The scenes that images play: bodies, held cells, settings, motions.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};
use chaincell_kernel::{Choice, Model, Settings, ToolPart, Unloading};
use chaincell_scenes::{SCENES, Scene, Tier, Tools};

/// Most cells that the tool of a scene without a golden holds.
const HELD_MAX: usize = 7;

/// A scene and how its model is baked.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    /// Name in tables, budgets and `--only`.
    pub name: &'static str,
    /// Arguments of `chaincell bake`.
    pub bake: &'static [&'static str],
    pub scheme: &'static str,
    /// What meets the surface in place of held cells.
    pub tool: Option<Tool>,
    /// A golden scene on the same body, whose motion, held cells and settings this one takes.
    pub golden: Option<&'static str>,
    /// Sweeps a tick where there is no golden.
    pub sweeps: u16,
    /// Most ticks that are played.
    pub ticks_max: u32,
    /// Too slow in software floating point.
    pub needs_fpu: bool,
    /// A question of size, asked of the Cortex-M7; of other cores with `--slow` or `--only`.
    pub of_size: bool,
}

/// A tool, and how many triangles and samples have slots.
#[derive(Debug, Clone, Copy)]
pub struct Tool {
    pub shape: Shape,
    pub near: usize,
    pub anchors: usize,
}

/// The shape of a tool.
#[derive(Debug, Clone, Copy)]
pub enum Shape {
    /// A sphere with friction.
    Sphere { radius_m: f32, friction: f32 },
    /// That of the golden scene.
    Golden,
}

/// A case that every core plays to its end, four sweeps a tick.
const PLAIN: Case = Case {
    name: "",
    bake: &[],
    scheme: "track",
    tool: None,
    golden: None,
    sweeps: 4,
    ticks_max: u32::MAX,
    needs_fpu: false,
    of_size: false,
};
/// A question of size, a sweep a tick.
const OF_SIZE: Case = Case { sweeps: 1, of_size: true, ..PLAIN };

/// Scales of the rest shape that an image ticks from: the first two bring every link out of its band, the last
/// is for a tool.
pub const STATES: [(&str, f32); 3] = [("LONG", 1.5), ("SHORT", 0.5), ("REST", 1.0)];

/// All of them.
pub const CASES: [Case; 13] = [
    Case {
        name: "plane8_track",
        bake: &["plane:21x21x0.01", "--diagonals", "--alpha=0.02", "--coarse=none", "--lean"],
        golden: Some("plane8_track"),
        ..PLAIN
    },
    Case {
        name: "plane8_euler",
        bake: &["plane:21x21x0.01", "--diagonals", "--alpha=0.02", "--coarse=none", "--lean"],
        scheme: "euler",
        ..PLAIN
    },
    Case {
        name: "organ500_track",
        bake: &["organ:500", "--coarse=3.5", "--lean"],
        golden: Some("organ500_track"),
        ..PLAIN
    },
    Case {
        name: "organ500_predict",
        bake: &["organ:500", "--coarse=3.5", "--lean"],
        scheme: "predict",
        golden: Some("organ500_predict"),
        needs_fpu: true,
        ..PLAIN
    },
    Case {
        name: "organ500_nodal",
        bake: &["organ:500", "--young-pa=5000", "--poisson=0.45", "--contact-surface=no"],
        needs_fpu: true,
        ..PLAIN
    },
    Case {
        name: "organ500_touch",
        bake: &["organ:500", "--young-pa=5000", "--poisson=0.45"],
        tool: Some(Tool {
            shape: Shape::Sphere { radius_m: 0.012, friction: 0.3 },
            near: 24,
            anchors: 96,
        }),
        needs_fpu: true,
        ..PLAIN
    },
    Case {
        name: "blade5_track",
        bake: &[
            "box:5x5x4x0.01",
            "--young-pa=5000",
            "--poisson=0.4",
            "--coarse=2.5",
            "--contact-surface=yes",
            "--cuttable",
            "--cut-spare=0.3",
            "--toughness-j-per-m2=10",
        ],
        tool: Some(Tool { shape: Shape::Golden, near: 128, anchors: 64 }),
        golden: Some("blade5_track"),
        needs_fpu: true,
        ..PLAIN
    },
    Case {
        name: "relax6_track",
        bake: &[
            "box:6x6x4x0.01",
            "--young-pa=5000",
            "--poisson=0.4",
            "--coarse=2.5",
            "--contact-surface=yes",
            "--branch=1,0.02",
            "--branch=0.5,12",
        ],
        tool: Some(Tool { shape: Shape::Golden, near: 256, anchors: 256 }),
        golden: Some("relax6_track"),
        needs_fpu: true,
        ..PLAIN
    },
    Case {
        name: "organ500_bandless",
        bake: &["organ:500", "--young-pa=5000", "--stretch-min=none", "--contact-surface=no"],
        scheme: "predict",
        needs_fpu: true,
        ..PLAIN
    },
    Case {
        name: "organ1000_predict",
        bake: &["organ:1010", "--coarse=none", "--lean"],
        scheme: "predict",
        needs_fpu: true,
        ..OF_SIZE
    },
    Case { name: "organ1000_track", bake: &["organ:1010", "--coarse=4.5", "--lean"], ..OF_SIZE },
    Case {
        name: "organ1000_bare",
        bake: &["organ:1010", "--coarse=none", "--lean"],
        needs_fpu: true,
        ..OF_SIZE
    },
    // As many cells as fit into 1 MB of RAM.
    Case {
        name: "organ16000_track",
        bake: &["organ:16000", "--coarse=none", "--lean"],
        ticks_max: 10,
        needs_fpu: true,
        ..OF_SIZE
    },
];

/// Bodies for `--fit`: schemes, sizes of the organ, spacings of its coarse level.
pub const FIT: [(&str, &[u32], &[&str]); 2] = [
    ("track", &[300, 500, 650, 700], &["3.5", "none"]),
    ("predict", &[500, 650, 720, 900], &["6", "none"]),
];

/// The organ of a size with a coarse level of a spacing, a sweep a tick.
pub fn fit(scheme: &'static str, cells: u32, spacing: &str) -> Case {
    let leak = |text: String| -> &'static str { Box::leak(text.into_boxed_str()) };
    let bake = [leak(format!("organ:{cells}")), leak(format!("--coarse={spacing}")), "--lean"];
    let name = leak(format!("{scheme}{cells}-{}", spacing.replace('.', "_")));
    Case { name, bake: Box::leak(Box::new(bake)), scheme, sweeps: 1, ticks_max: 10, ..PLAIN }
}

/// A case ready to be built: its model and its scene.
pub struct Ready {
    pub case: Case,
    pub model_path: PathBuf,
    pub model: Model<'static>,
    pub scene: &'static Scene,
    pub ticks: u32,
}

impl Ready {
    /// The settings in force.
    pub fn settings(&self) -> Settings {
        (self.scene.settings)(&self.model)
    }

    /// Returns true if the body can be cut.
    pub fn is_cut(&self) -> bool {
        self.model.tetrahedra_to_cut() > 0
    }

    /// States that the image has, by name.
    pub fn states(&self) -> &'static [(&'static str, f32)] {
        if self.case.tool.is_some() { &STATES } else { &STATES[..2] }
    }

    /// Where [`prepare`] has written a state.
    pub fn state_path(&self, name: &str) -> PathBuf {
        self.model_path.with_extension(name)
    }

    /// Writes the states: three `f32` a cell.
    fn write_states(&self) -> Result<()> {
        for (name, scale) in self.states() {
            let rest = (0..self.model.cells()).flat_map(|cell| self.model.rest_position(cell));
            let state: Vec<u8> = rest.flat_map(|x| (x * scale).to_le_bytes()).collect();
            std::fs::write(self.state_path(name), state)?;
        }
        Ok(())
    }
}

/// Bakes the model into `folder` with the program `chaincell`, lays out the scene and writes the states.
pub fn prepare(case: Case, chaincell: &Path, folder: &Path, ticks: u32) -> Result<Ready> {
    std::fs::create_dir_all(folder)?;
    let model_path = folder.join(format!("{}.chaincell", case.name));
    let mut bake = Command::new(chaincell);
    bake.arg("bake").args(case.bake).arg("--json").arg("-o").arg(&model_path);
    let baked = bake.output().with_context(|| format!("{}", chaincell.display()))?;
    let why = String::from_utf8_lossy(&baked.stderr);
    ensure!(baked.status.success(), "{}: bake: {why}", case.name);
    let image = aligned(&std::fs::read(&model_path)?);
    let model = Model::from_bytes(image)?;
    let scene = match case.golden {
        Some(name) => {
            let golden = SCENES.into_iter().find(|scene| scene.name == name);
            let golden = golden.with_context(|| format!("no golden scene {name}"))?;
            Scene { image, ..*golden }
        }
        None => Scene {
            name: case.name,
            scheme: case.scheme,
            tiers: Tier::ALL,
            image,
            cells: model.cells(),
            held: match case.tool {
                None => Box::leak(held(&model)?.into_boxed_slice()),
                Some(_) => &[],
            },
            tools: case.tool.and_then(|tool| above(&model, tool.shape)),
            reach_m: 3.0 * model.unit_m(),
            settings: match case.sweeps {
                1 => |model| settings(model, 1),
                _ => |model| settings(model, 4),
            },
        },
    };
    let ticks = ticks.min(case.ticks_max);
    let ready = Ready { case, model_path, model, scene: Box::leak(Box::new(scene)), ticks };
    ready.write_states()?;
    Ok(ready)
}

fn settings(model: &Model<'_>, sweeps: u16) -> Settings {
    Settings { sweeps, unloading: Unloading::Release, ..Settings::for_model(model) }
}

/// A copy of the image where the kernel may read it, for as long as the program runs.
pub fn aligned(bytes: &[u8]) -> &'static [u8] {
    let words = Box::leak(vec![0_u128; bytes.len().div_ceil(16)].into_boxed_slice());
    let room: &'static mut [u8] = bytemuck::cast_slice_mut(words);
    let (room, _) = room.split_at_mut(bytes.len());
    room.copy_from_slice(bytes);
    room
}

/// The sphere on the highest cell; `None` for the tool of a golden scene.
fn above(model: &Model<'_>, shape: Shape) -> Option<Tools> {
    let Shape::Sphere { radius_m, friction } = shape else { return None };
    let cells = (0..model.cells()).map(|cell| model.rest_position(cell));
    let [x, y, z] = cells.max_by(|a, b| a[2].total_cmp(&b[2])).unwrap_or_default();
    let ([a, b, c], unit_m) = (model.centre_m(), model.unit_m());
    let start_m = [a + unit_m * x, b + unit_m * y, c + unit_m * z + radius_m];
    let part: &[ToolPart] = Box::leak(Box::new([ToolPart::sphere(radius_m)]));
    let parts = Box::leak(Box::new([part]));
    Some(Tools { parts, friction, start_m: [start_m; 2], turn_m: 1.0 })
}

/// Input ids of the free cell farthest from the fixed ones and of some free neighbours.
fn held(model: &Model<'_>) -> Result<Vec<u32>> {
    let away = |cell: usize| {
        let at = model.rest_position(cell);
        let squares = model.fixed().iter().map(|&fixed| {
            let other = model.rest_position(fixed.into());
            (0..3).map(|axis| (at[axis] - other[axis]).powi(2)).sum::<f32>()
        });
        squares.fold(f32::INFINITY, f32::min)
    };
    let free = |cell: &usize| !model.is_fixed(*cell as u16);
    let cells = (0..model.cells()).filter(free);
    let middle = cells.max_by(|&a, &b| away(a).total_cmp(&away(b)).then(b.cmp(&a)));
    let middle = middle.context("every cell is fixed")?;
    let neighbours = model.neighbours(middle).map(|(_, other)| other).filter(free);
    let cells = [middle].into_iter().chain(neighbours).take(HELD_MAX);
    Ok(cells.map(|cell| model.input_id()[cell]).collect())
}
