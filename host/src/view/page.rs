//! The page's text: the sources in `host/view`, one after the other, and the configuration that they read. The
//! kernel is `kernel.wasm.gz`, which `host/view/build` makes.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use chaincell_kernel::Flags;
use miniz_oxide::deflate::compress_to_vec;
use serde::Serialize;

use crate::checksum::CRC_32;
use crate::error::{Error, Result};
use crate::picture::palette::MAGMA;

/// The kernel's C interface as WebAssembly, packed by gzip.
pub const KERNEL: &[u8] = include_bytes!("../../view/kernel.wasm.gz");

/// Level of the compression, at most 10.
const GZIP_LEVEL: u8 = 9;

const TEMPLATE: &str = include_str!("../../view/page.html");
/// What the page may load and run, by the rules of Content-Security-Policy.
pub const POLICY: &str = include_str!("../../view/policy.txt").trim_ascii_end();
const STYLE: &str = include_str!("../../view/style.css");
/// Sources of the worker, each after those that it imports.
const WORKER: &[&str] = &[
    include_str!("../../view/pace.mjs"),
    include_str!("../../view/limits.mjs"),
    include_str!("../../view/kernel.mjs"),
    include_str!("../../view/stresses.mjs"),
    include_str!("../../view/cuts.mjs"),
    include_str!("../../view/depth.mjs"),
    include_str!("../../view/recording.mjs"),
    include_str!("../../view/player.mjs"),
    include_str!("../../view/session_loop.mjs"),
    include_str!("../../view/worker.mjs"),
];
/// Sources of the page, each after those that it imports.
const PAGE: &[&str] = &[
    include_str!("../../view/vectors.mjs"),
    include_str!("../../view/image.mjs"),
    include_str!("../../view/parts.mjs"),
    include_str!("../../view/colours.mjs"),
    include_str!("../../view/camera.mjs"),
    include_str!("../../view/shapes.mjs"),
    include_str!("../../view/surface.mjs"),
    include_str!("../../view/gl.mjs"),
    include_str!("../../view/chainmail.mjs"),
    include_str!("../../view/figure.mjs"),
    include_str!("../../view/wound.mjs"),
    include_str!("../../view/scene.mjs"),
    include_str!("../../view/hand.mjs"),
    include_str!("../../view/charts.mjs"),
    include_str!("../../view/limits.mjs"),
    include_str!("../../view/save.mjs"),
    include_str!("../../view/own.mjs"),
    include_str!("../../view/pace.mjs"),
    include_str!("../../view/contacts.mjs"),
    include_str!("../../view/depth.mjs"),
    include_str!("../../view/live.mjs"),
    include_str!("../../view/session.mjs"),
    include_str!("../../view/panel.mjs"),
    include_str!("../../view/timeline.mjs"),
    include_str!("../../view/main.mjs"),
];

/// Source of the states that a page shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Mode {
    /// The kernel in the page.
    Own,
    /// A running `serve`.
    Live,
    /// A recorded session.
    Session,
}

/// Bytes packed by gzip, for the page.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Packed {
    /// In the page itself, as base64.
    Inline(String),
    /// From the server, at this path.
    Url(String),
}

impl Packed {
    /// Puts packed bytes into the page.
    #[must_use]
    pub fn inline(packed: &[u8]) -> Self {
        Self::Inline(STANDARD.encode(packed))
    }
}

/// Material of a body that the server can bake anew.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Material {
    /// Young's modulus \[Pa\].
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

/// Configuration of a page. It holds no secret: whoever reads the page may read it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// Source of the states.
    pub mode: Mode,
    /// Name of the body, as it is shown.
    pub name: String,
    /// Checksum of the model, 8 hexadecimal digits.
    pub checksum: String,
    /// The model's image.
    pub model: Packed,
    /// The kernel.
    pub kernel: Packed,
    /// A recorded session.
    pub session: Option<Packed>,
    /// Each tool by its parts, as `--tool` has it; none where cells are held.
    pub tools: Vec<String>,
    /// Input ids of the cells that are held without a tool.
    pub contact_nodes: Vec<u32>,
    /// Sweeps of a tick.
    pub sweeps: u16,
    /// Material of the body, if it is one everywhere.
    pub material: Option<Material>,
    /// True if the server bakes the body of another material.
    pub can_bake: bool,
    /// True if the page may command a running `serve`.
    pub commands: bool,
}

/// A flag of the kernel in words.
#[derive(Serialize)]
struct FlagText {
    bit: u32,
    name: String,
    meaning: String,
}

/// What the page reads.
#[derive(Serialize)]
struct Shown<'a> {
    #[serde(flatten)]
    config: &'a Config,
    flags: Vec<FlagText>,
    /// Colours from the least to the largest number, sRGB: those of pictures without a browser.
    ramp: &'static [[u8; 3]],
}

/// Packs bytes by gzip, RFC 1952: the same bytes in, the same bytes out.
#[must_use]
pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    // Deflated; no name, no time; the best compression; an unknown system.
    let mut packed = vec![0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 2, 255];
    packed.extend(compress_to_vec(bytes, GZIP_LEVEL));
    packed.extend(CRC_32.checksum(bytes).to_le_bytes());
    packed.extend((bytes.len() as u32).to_le_bytes());
    packed
}

/// Returns the page as one HTML text.
///
/// # Errors
/// A configuration that is no JSON, which none is.
pub fn html(config: &Config) -> Result<String> {
    let flags = Flags::ALL.iter().map(|(flag, name, meaning)| FlagText {
        bit: flag.0,
        name: name.to_lowercase().replace('_', " "),
        meaning: meaning.split_whitespace().collect::<Vec<_>>().join(" "),
    });
    let shown = Shown { config, flags: flags.collect(), ramp: &MAGMA };
    let json = serde_json::to_string(&shown)
        .map_err(|why| Error::check(format!("cannot write the page: {why}")))?;
    let mut text = String::with_capacity(TEMPLATE.len() + json.len() + 100_000);
    // Each place of the template is filled once; what is put in is not looked at again.
    for piece in TEMPLATE.split("{{") {
        match piece.split_once("}}") {
            None => text.push_str(piece),
            Some((place, rest)) => {
                fill(&mut text, place, &json);
                text.push_str(rest);
            }
        }
    }
    Ok(text)
}

/// Writes what belongs at a place of the template.
fn fill(text: &mut String, place: &str, json: &str) {
    match place {
        "policy" => text.push_str(POLICY),
        "style" => text.push_str(STYLE),
        // No text of a user's ends the element that holds it.
        "config" => text.push_str(&json.replace('<', "\\u003c")),
        "worker" => joined(text, WORKER),
        "page" => joined(text, PAGE),
        other => debug_assert!(false, "the template has a place `{other}`"),
    }
}

/// Joins modules into one: in a page from a disk they cannot import each other.
fn joined(text: &mut String, modules: &[&str]) {
    for line in modules.iter().flat_map(|module| module.lines()) {
        if !line.starts_with("import ") {
            let _ = writeln!(text, "{}", line.strip_prefix("export ").unwrap_or(line));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read as _;

    use flate2::read::GzDecoder;

    use super::*;
    use crate::bake::organ;

    fn config(name: &str, model: Packed) -> Config {
        Config {
            mode: Mode::Own,
            name: name.into(),
            checksum: "00000000".into(),
            model,
            kernel: Packed::inline(KERNEL),
            session: None,
            tools: vec!["sphere:0.012".into()],
            contact_nodes: Vec::new(),
            sweeps: 2,
            material: None,
            can_bake: false,
            commands: false,
        }
    }

    fn json_of(html: &str) -> &str {
        let (_, rest) = html.split_once(r#"id="config">"#).unwrap();
        rest.split_once("</script>").unwrap().0
    }

    /// A decoder of others reads the same bytes, and packing twice gives the same.
    #[test]
    fn a_decoder_unpacks_the_same_bytes() {
        for bytes in [&b""[..], b"a", PAGE[0].as_bytes(), organ().unwrap().as_bytes()] {
            let packed = gzip(bytes);
            let mut unpacked = Vec::new();
            GzDecoder::new(&*packed).read_to_end(&mut unpacked).unwrap();
            assert!(unpacked == bytes && packed == gzip(bytes), "{} bytes", bytes.len());
        }
    }

    #[test]
    fn a_name_cannot_leave_its_element() {
        let name = "</script><script>alert(1)</script>{{page}}<!--";
        let html = html(&config(name, Packed::Url("/model".into()))).unwrap();
        assert!(!html.contains("alert(1)</script>"));
        let read: serde_json::Value = serde_json::from_str(json_of(&html)).unwrap();
        assert_eq!(read["name"], name);
        assert_eq!(read["model"]["url"], "/model");
        assert_eq!(html.matches("class View").count(), 1);
    }

    #[test]
    fn every_flag_has_words() {
        let html = html(&config("organ", Packed::Url("/model".into()))).unwrap();
        let read: serde_json::Value = serde_json::from_str(json_of(&html)).unwrap();
        let flags = read["flags"].as_array().unwrap();
        assert_eq!(flags.len(), Flags::ALL.len());
        assert_eq!((&flags[0]["bit"], &flags[0]["name"]), (&1.into(), &"motion clamped".into()));
        assert!(flags.iter().all(|flag| flag["meaning"].as_str().unwrap().ends_with('.')));
        // Colours are those of pictures without a browser.
        let end = |part| crate::picture::palette::srgb(part).to_vec();
        assert_eq!(read["ramp"].as_array().unwrap().len(), MAGMA.len());
        assert_eq!((&read["ramp"][0], &read["ramp"][16]), (&end(0.0).into(), &end(1.0).into()));
    }

    #[test]
    fn modules_stand_after_what_they_import() {
        for modules in [WORKER, PAGE] {
            for (place, module) in modules.iter().enumerate() {
                for line in module.lines().filter(|line| line.starts_with("import ")) {
                    let names = line.split(['{', '}']).nth(1).unwrap().split(',').map(str::trim);
                    for name in names {
                        let exported = ["const", "function", "async function", "class"]
                            .map(|kind| format!("export {kind} {name}"));
                        let is_before = modules[..place].iter().any(|other| {
                            exported.iter().any(|text| {
                                other.match_indices(text).any(|(at, _)| {
                                    !other[at + text.len()..].starts_with(char::is_alphanumeric)
                                })
                            })
                        });
                        assert!(is_before, "{name} of `{line}`");
                    }
                }
            }
        }
    }

    #[test]
    fn the_default_page_is_small_and_loads_nothing() {
        let image = organ().unwrap();
        let html = html(&config("organ", Packed::inline(&gzip(image.as_bytes())))).unwrap();
        assert!(html.len() <= 1_430_000, "{} bytes", html.len());
        // The policy admits no other place, and the page names none.
        assert!(html.contains("default-src 'none'"));
        let names_a_place = |attribute: &str| html.contains(&format!("{attribute}=\"http"));
        assert!(!names_a_place("src") && !names_a_place("href"));
    }
}
