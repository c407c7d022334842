//! `chaincell cosim --view`: the page that shows the session.

use std::path::Path;
use std::time::{Duration, Instant};

use chaincell_kernel::Model;

use super::browser::{self, BrowserArgs, Served};
use super::view::live_config;
use crate::error::{Error, Result};
use crate::session::ipc::services::Domain;
use crate::terminal;
use crate::view::bridge::Bridge;
use crate::view::live::Subject;
use crate::view::server::Site;

/// Longest wait for the page before the session begins.
const OPEN: Duration = Duration::from_secs(60);
/// Time without a page after which the last one is closed: a page that is loaded again comes back before.
const CLOSED: Duration = Duration::from_secs(2);

/// Options of the page of a session.
#[derive(Debug, Clone, clap::Args)]
pub struct ViewArgs {
    /// Show the session in a browser: it begins when the page is open, and its last state stays until the page
    /// is closed, or Ctrl-C
    #[arg(long)]
    view: bool,
    #[command(flatten)]
    browser: BrowserArgs,
}

/// The body of a session as its page shows it.
pub struct Shown<'a> {
    /// Model file, given or made of a tissue by name; `None` for the default organ.
    pub path: Option<&'a Path>,
    /// Its image.
    pub image: &'a [u8],
    /// The model in it.
    pub model: &'a Model<'a>,
    /// The tools by their parts, none where cells are held.
    pub tools: Vec<String>,
    /// The scene.
    pub scene: Option<&'a str>,
}

/// The page of a session, until this is dropped.
#[derive(Debug)]
pub struct SessionPage {
    bridge: Bridge,
    _served: Served,
}

impl ViewArgs {
    /// Returns true if a page is to show the session.
    pub fn is_wanted(&self) -> bool {
        self.view
    }

    /// Serves the page of a session if it was asked for, and waits until it is open.
    ///
    /// # Errors
    /// An option of a page without --view, a port that is taken.
    pub fn open(&self, shown: Shown<'_>) -> Result<Option<SessionPage>> {
        if !self.view {
            return match self.browser.given() {
                Some(option) => Err(Error::input(format!(
                    "{option}: there is no page to open; give --view, or leave it out"
                ))),
                None => Ok(None),
            };
        }
        let subject = Subject::new(shown.model, shown.tools.len())?;
        let bridge = Bridge::start(shown.scene, &Domain::default(), subject, false)?;
        let config = live_config(shown.path, shown.model, shown.tools, false);
        let site = Site { live: Some(bridge.live()), ..browser::site(&config, shown.image)? };
        let served = self.browser.serve(site, |address| {
            terminal::note(format_args!("{address}\nthe session begins when this page is open"));
            Ok(())
        })?;
        let start = Instant::now();
        browser::wait_until(|| bridge.pages() > 0 || start.elapsed() > OPEN);
        Ok(Some(SessionPage { bridge, _served: served }))
    }
}

impl SessionPage {
    /// Shows the last state and how the session ended, until the page is closed or Ctrl-C.
    pub fn stay(mut self, ended: &str) {
        self.bridge.end(ended);
        if self.bridge.pages() > 0 {
            terminal::note("the page shows the last state until it is closed, or Ctrl-C");
        }
        let mut seen = Instant::now();
        browser::wait_until(|| {
            if self.bridge.pages() > 0 {
                seen = Instant::now();
            }
            seen.elapsed() > CLOSED
        });
    }
}
