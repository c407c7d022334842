//! `chaincell view`: shows a body in a browser.

use std::path::{Path, PathBuf};

use chaincell_kernel::Model;
use serde::Deserialize;

use super::browser::{self, BrowserArgs};
use super::model_file;
use super::recorded::RecordedArgs;
use super::tool::ToolSpec;
use crate::bake::{
    ImageBytes, ORGAN_POISSON, ORGAN_SIZE, ORGAN_TISSUE, ORGAN_YOUNG_PA, organ, organ_of,
};
use crate::engine::contact::contact_cells;
use crate::engine::staged::check_tick;
use crate::error::{Error, Result};
use crate::files::whole::{keep_input, write_whole};
use crate::interrupt;
use crate::session::ipc::services::Domain;
use crate::terminal;
use crate::view::bridge::Bridge;
use crate::view::live::Subject;
use crate::view::page::{self, Config, KERNEL, Material, Mode, Packed};
use crate::view::server::{Answer, Site};
use crate::view::session;

/// Radius of the ball on the default body \[m\].
const RADIUS_M: f32 = 0.012;
/// Radius of the ball on any other body in mean link lengths.
const RADIUS_LINKS: f32 = 0.85;

/// Why a body is not baked anew.
const NOT_BAKED: &str = "this body is a baked file: bake its mesh with another material by chaincell bake, and \
    start chaincell view with the new file";

/// Show a body in a browser, where a tool can be dragged into it, a running scene or a recorded session.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  chaincell view\n  chaincell view liver.chaincell --scene left\n  \
    chaincell view session --html session.html\n  \
    chaincell view liver.chaincell --tool capsule:0.03,0.004 --html liver.html\n\n\
    Serves the page on 127.0.0.1 until Ctrl-C, for this user: all but the page needs the token in its\n\
    address. A file of --html holds the body and the kernel, and needs nothing else: open it from the\n\
    disk. What is pressed comes to the same state hash as chaincell run."
)]
pub struct Args {
    #[arg(help = format!(
        "Model file from `chaincell bake`, or a recorded session: a trace or the folder of a run [default: organ:{ORGAN_SIZE} of the tissue {ORGAN_TISSUE}, \
         {} kPa, Poisson's ratio {ORGAN_POISSON}]", 1e-3 * ORGAN_YOUNG_PA
    ))]
    model: Option<PathBuf>,
    /// Write the page into one file, which works from the disk
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// A tool by its parts, as in `run`, once for each; of a running scene its tools, none where it holds cells
    /// [default: a ball of 12 mm, on other bodies than the default one of 0.85 mean link lengths]
    #[arg(long, value_name = "PART[+PART...]")]
    tool: Vec<ToolSpec>,
    /// Model file that a session was recorded with [default: model.chaincell beside the trace]
    #[arg(long = "model", value_name = "MODEL", conflicts_with_all = ["tool", "scene"])]
    session_model: Option<PathBuf>,
    /// Show the running scene of `serve`, by its name; the unnamed one without NAME
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "",
        conflicts_with = "html")]
    scene: Option<String>,
    /// Let the page pause, reset and set the running scene
    #[arg(long, requires = "scene")]
    commands: bool,
    #[command(flatten)]
    browser: BrowserArgs,
    /// Sweeps of a tick
    #[arg(long, default_value_t = 2, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=16))]
    sweeps: u16,
}

pub fn execute(args: &Args) -> Result<()> {
    if let Some(scene) = &args.scene {
        return show_scene(args, scene);
    }
    let shown = Shown::of(args)?;
    match &args.html {
        Some(file) => write(args, file, shown),
        None => show(args, shown),
    }
}

/// The content of a page: its configuration, and what that refers to.
struct Shown {
    /// As if all came from a server.
    config: Config,
    image: ImageBytes,
    /// A recorded session, packed by gzip.
    session: Option<Vec<u8>>,
}

impl Shown {
    /// Reads the model, or the session with its model and plays it.
    ///
    /// # Errors
    /// Files that are not there or do not fit together; a session that does not come to its states.
    fn of(args: &Args) -> Result<Self> {
        match &args.model {
            Some(path) if RecordedArgs::is_session(path) => Self::session(args, path),
            // One that cannot be read is said to be so.
            Some(path) if !path.exists() => Self::model(args),
            _ if args.session_model.is_some() => {
                Err(Error::input("--model: it goes with a recorded session, name the model alone"))
            }
            _ => Self::model(args),
        }
    }

    fn model(args: &Args) -> Result<Self> {
        let image = args.model.as_deref().map_or_else(organ, model_file::read)?;
        let path = args.model.as_deref().unwrap_or(Path::new("organ"));
        let model = model_file::parse(&image, path)?;
        // The page ticks each millisecond.
        check_tick(&model, None)?;
        let config = config(args, &model)?;
        Ok(Self { config, image, session: None })
    }

    fn session(args: &Args, path: &Path) -> Result<Self> {
        if !args.tool.is_empty() {
            return Err(Error::input("--tool: a recorded session has its own tools, leave it out"));
        }
        // Play the session.
        interrupt::end_at_once()?;
        let recorded = RecordedArgs::of(path.to_owned(), args.session_model.clone()).read()?;
        let mut begun = recorded.begin(None)?;
        let numbers = (begun.scheme, begun.precision);
        let packed = session::packed(&begun.trace, &mut begun.tissue, numbers, begun.start);
        let (bytes, _) = packed.map_err(|why| Error::file("view", &recorded.path, why))?;
        // Name it, and refer to it.
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let config = Config {
            mode: Mode::Session,
            name: if name.is_empty() { "session".into() } else { name },
            session: Some(Packed::Url("/session".into())),
            sweeps: args.sweeps,
            ..base_config(Some(path), &begun.model)
        };
        let image = ImageBytes::copy(recorded.image().as_bytes());
        Ok(Self { config, image, session: Some(page::gzip(&bytes)) })
    }
}

/// Writes the page into a file.
fn write(args: &Args, file: &Path, shown: Shown) -> Result<()> {
    let config = Config {
        model: Packed::inline(&page::gzip(shown.image.as_bytes())),
        kernel: Packed::inline(KERNEL),
        session: shown.session.as_deref().map(Packed::inline),
        ..shown.config
    };
    if let Some(model) = &args.model {
        keep_input(&model.to_string_lossy(), file)?;
    }
    let html = page::html(&config)?;
    write_whole(file, html.as_bytes())?;
    terminal::say(format_args!("wrote {}, {} bytes", file.display(), html.len()))
}

/// Serves the page with a kernel of its own.
fn show(args: &Args, shown: Shown) -> Result<()> {
    let config = Config { can_bake: args.model.is_none(), ..shown.config };
    let answer: Answer = match args.model {
        None => Box::new(bake),
        Some(_) => Box::new(|_| Err(NOT_BAKED.to_owned())),
    };
    let mut site =
        Site { posts: vec![("/bake", answer)], ..browser::site(&config, shown.image.as_bytes())? };
    site.files.extend(shown.session.map(|session| ("/session", session)));
    let _served = args.browser.serve(site, tell)?;
    browser::wait_until(|| false);
    Ok(())
}

/// Serves the page on a running scene.
fn show_scene(args: &Args, scene: &str) -> Result<()> {
    let image = args.model.as_deref().map_or_else(organ, model_file::read)?;
    let path = args.model.as_deref().unwrap_or(Path::new("organ"));
    let model = &model_file::parse(&image, path)?;
    let tools: Vec<String> = args.tool.iter().map(|tool| tool.text.clone()).collect();
    let subject = Subject::new(model, tools.len())?;
    let scene = Some(scene).filter(|name| !name.is_empty());
    let bridge = Bridge::start(scene, &Domain::default(), subject, args.commands)?;
    let config = live_config(args.model.as_deref(), model, tools, args.commands);
    let site = Site { live: Some(bridge.live()), ..browser::site(&config, image.as_bytes())? };
    let _served = args.browser.serve(site, tell)?;
    browser::wait_until(|| false);
    Ok(())
}

fn tell(address: &str) -> Result<()> {
    terminal::say(format_args!("{address}\nCtrl-C ends it"))
}

/// A material that the page asks for.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Asked {
    young_pa: f64,
    poisson: f64,
}

/// Bakes the default body of the material in the body of a request; the packed image.
fn bake(body: &[u8]) -> std::result::Result<Vec<u8>, String> {
    let asked: Asked = serde_json::from_slice(body)
        .map_err(|why| format!("{why}: send young_pa and poisson as JSON"))?;
    let image = organ_of(asked.young_pa, asked.poisson).map_err(|why| why.to_string())?;
    Ok(page::gzip(image.as_bytes()))
}

/// The configuration of a page on a running scene, whose server has these tools.
pub fn live_config(
    path: Option<&Path>,
    model: &Model<'_>,
    tools: Vec<String>,
    commands: bool,
) -> Config {
    Config { mode: Mode::Live, tools, commands, ..base_config(path, model) }
}

/// The configuration of a page with a kernel of its own, which asks a server for model and kernel.
fn config(args: &Args, model: &Model<'_>) -> Result<Config> {
    let tools = tools(args, model)?;
    Ok(Config {
        contact_nodes: if tools.is_empty() { held(model)? } else { Vec::new() },
        tools,
        sweeps: args.sweeps,
        ..base_config(args.model.as_deref(), model)
    })
}

fn base_config(path: Option<&Path>, model: &Model<'_>) -> Config {
    let name = path.and_then(Path::file_stem);
    let material = Material { young_pa: ORGAN_YOUNG_PA, poisson: ORGAN_POISSON };
    Config {
        mode: Mode::Own,
        name: name.map_or("organ".into(), |name| name.to_string_lossy().into_owned()),
        checksum: format!("{:08x}", model.checksum()),
        model: Packed::Url("/model".into()),
        kernel: Packed::Url("/kernel.wasm.gz".into()),
        session: None,
        contact_nodes: Vec::new(),
        tools: Vec::new(),
        sweeps: 1,
        material: path.is_none().then_some(material),
        can_bake: false,
        commands: false,
    }
}

/// The tools; none for a body without a contact surface, of which cells are held.
fn tools(args: &Args, model: &Model<'_>) -> Result<Vec<String>> {
    if !args.tool.is_empty() {
        super::tool::tools(&args.tool, None, model)?;
        return Ok(args.tool.iter().map(|tool| tool.text.clone()).collect());
    }
    if !model.has_contact_surface() {
        return Ok(Vec::new());
    }
    let radius_m = match &args.model {
        None => RADIUS_M,
        Some(_) => two_digits(RADIUS_LINKS * model.unit_m()),
    };
    Ok(vec![format!("sphere:{radius_m}")])
}

/// Input ids of the cells that `--contact auto` holds.
fn held(model: &Model<'_>) -> Result<Vec<u32>> {
    let cells = contact_cells("auto", model)?;
    Ok(cells.into_iter().map(|cell| model.input_id()[usize::from(cell)]).collect())
}

/// Rounds a length to two digits.
fn two_digits(length_m: f32) -> f32 {
    format!("{length_m:.1e}").parse().unwrap_or(length_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_material_is_baked_or_refused_in_words() {
        let soft = bake(br#"{"young_pa":2000,"poisson":0.3}"#).unwrap();
        assert_ne!(soft, page::gzip(organ().unwrap().as_bytes()));
        let same = format!(r#"{{"young_pa":{ORGAN_YOUNG_PA},"poisson":{ORGAN_POISSON}}}"#);
        let same = bake(same.as_bytes()).unwrap();
        assert_eq!(same, page::gzip(organ().unwrap().as_bytes()));
        for (body, part) in [
            ("", "young_pa and poisson"),
            (r#"{"young_pa":2000}"#, "missing field `poisson`"),
            (r#"{"young_pa":-1,"poisson":0.3}"#, "-1"),
            (r#"{"young_pa":2000,"poisson":0.6}"#, "0.6"),
        ] {
            let why = bake(body.as_bytes()).unwrap_err();
            assert!(why.contains(part), "{body}: {why}");
        }
    }

    #[test]
    fn radii_have_two_digits() {
        assert_eq!(two_digits(0.012_345), 0.012);
        assert_eq!(two_digits(1.26e-5), 1.3e-5);
    }
}
