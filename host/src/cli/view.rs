//! `chaincell view`: shows a body in a browser.

use std::path::{Path, PathBuf};

use chaincell_kernel::Model;

use super::model_file;
use super::recorded::RecordedArgs;
use super::tool::ToolSpec;
use crate::bake::{ImageBytes, ORGAN_POISSON, ORGAN_SIZE, ORGAN_YOUNG_PA, organ};
use crate::engine::contact::contact_cells;
use crate::error::{Error, Result};
use crate::files::whole::{keep_input, write_whole};
use crate::interrupt;
use crate::terminal;
use crate::view::page::{self, Config, KERNEL, Material, Mode, Packed};
use crate::view::session;

/// Radius of the ball on the default body \[m\].
const RADIUS_M: f32 = 0.012;
/// Radius of the ball on any other body in mean link lengths.
const RADIUS_LINKS: f32 = 0.85;

/// Show a body in a browser, where a tool can be dragged into it.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  chaincell view --html organ.html\n  \
    chaincell view session --html session.html\n  \
    chaincell view liver.chaincell --tool capsule:0.03,0.004 --html liver.html\n\n\
    The file holds the body and the kernel, and needs nothing else: open it from the disk. What is\n\
    pressed in it comes to the same state hash as chaincell run.")]
pub struct Args {
    #[arg(help = format!(
        "Model file from `chaincell bake`, or a recorded session: a trace or the folder of a run [default: organ:{ORGAN_SIZE}, {} kPa, Poisson's ratio \
         {ORGAN_POISSON}]", 1e-3 * ORGAN_YOUNG_PA
    ))]
    model: Option<PathBuf>,
    /// Write the page into one file, which works from the disk
    #[arg(long, value_name = "FILE")]
    html: Option<PathBuf>,
    /// The tool by its parts, as in `run` [default: a ball of 12 mm, on other bodies than the default one of
    /// 0.85 mean link lengths]
    #[arg(long, value_name = "PART[+PART...]")]
    tool: Option<ToolSpec>,
    /// Model file that a session was recorded with [default: model.chaincell beside the trace]
    #[arg(long = "model", value_name = "MODEL", conflicts_with = "tool")]
    session_model: Option<PathBuf>,
    /// Sweeps of a tick
    #[arg(long, default_value_t = 2, value_name = "N", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=16))]
    sweeps: u16,
}

pub fn execute(args: &Args) -> Result<()> {
    let Some(file) = &args.html else {
        return Err(Error::input("name the page's file with --html FILE"));
    };
    let shown = Shown::of(args)?;
    let config = Config {
        model: Packed::inline(&page::gzip(shown.image.as_bytes())?),
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

/// What a page shows: its configuration, and what that refers to.
pub struct Shown {
    /// As if all came from a server.
    pub config: Config,
    pub image: ImageBytes,
    /// A recorded session, packed by gzip.
    pub session: Option<Vec<u8>>,
}

impl Shown {
    /// Reads the model, or the session with its model and plays it.
    ///
    /// # Errors
    /// Files that are not there or do not fit together; a session that does not come to its states.
    pub fn of(args: &Args) -> Result<Self> {
        match &args.model {
            Some(path) if RecordedArgs::is_session(path) => Self::session(args, path),
            _ if args.session_model.is_some() => {
                Err(Error::input("--model: it goes with a recorded session, name the model alone"))
            }
            _ => Self::model(args),
        }
    }

    fn model(args: &Args) -> Result<Self> {
        let image = args.model.as_deref().map_or_else(organ, model_file::read)?;
        let path = args.model.as_deref().unwrap_or(Path::new("organ"));
        let config = config(args, &model_file::parse(&image, path)?)?;
        Ok(Self { config, image, session: None })
    }

    fn session(args: &Args, path: &Path) -> Result<Self> {
        if args.tool.is_some() {
            return Err(Error::input("--tool: a recorded session has its own tools, leave it out"));
        }
        interrupt::end_at_once()?;
        let recorded = RecordedArgs::of(path.to_owned(), args.session_model.clone()).read()?;
        let mut begun = recorded.begin(None)?;
        let numbers = (begun.scheme, begun.precision);
        let packed = session::packed(&begun.trace, &mut begun.tissue, numbers, begun.start);
        let (bytes, _) = packed.map_err(|why| Error::file("view", &recorded.path, why))?;
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let config = Config {
            mode: Mode::Session,
            name: if name.is_empty() { "session".into() } else { name },
            tool: None,
            contact_nodes: Vec::new(),
            session: Some(Packed::Url("/session".into())),
            material: None,
            ..config(args, &begun.model)?
        };
        let image = ImageBytes::copy(recorded.image().as_bytes());
        Ok(Self { config, image, session: Some(page::gzip(&bytes)?) })
    }
}

/// The configuration of a page that asks a server for model and kernel.
pub fn config(args: &Args, model: &Model<'_>) -> Result<Config> {
    let name = args.model.as_deref().and_then(Path::file_stem);
    let tool = tool(args, model)?;
    Ok(Config {
        mode: Mode::Own,
        name: name.map_or("organ".into(), |name| name.to_string_lossy().into_owned()),
        checksum: format!("{:08x}", model.checksum()),
        model: Packed::Url("/model".into()),
        kernel: Packed::Url("/kernel.wasm.gz".into()),
        session: None,
        contact_nodes: if tool.is_none() { held(model)? } else { Vec::new() },
        tool,
        sweeps: args.sweeps,
        material: args
            .model
            .is_none()
            .then_some(Material { young_pa: ORGAN_YOUNG_PA, poisson: ORGAN_POISSON }),
        can_bake: false,
        commands: false,
    })
}

/// The tool; none for a body without a contact surface, of which cells are held.
fn tool(args: &Args, model: &Model<'_>) -> Result<Option<String>> {
    if let Some(tool) = &args.tool {
        super::tool::tools(std::slice::from_ref(tool), None, model)?;
        return Ok(Some(tool.text.clone()));
    }
    if !model.has_contact_surface() {
        return Ok(None);
    }
    let radius_m = match &args.model {
        None => RADIUS_M,
        Some(_) => two_digits(RADIUS_LINKS * model.unit_m()),
    };
    Ok(Some(format!("sphere:{radius_m}")))
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
    fn radii_have_two_digits() {
        assert_eq!(two_digits(0.012_345), 0.012);
        assert_eq!(two_digits(1.26e-5), 1.3e-5);
    }
}
