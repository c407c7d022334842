//! A page on a server of its own: its address, the browser, and the end.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use tempfile::TempDir;

use super::session;
use crate::error::Result;
use crate::files::whole::write_whole;
use crate::interrupt;
use crate::view::page::{self, Config, KERNEL};
use crate::view::server::{Server, Site};

/// Period of looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(20);

/// How a page is served.
#[derive(Debug, Clone, clap::Args)]
pub struct BrowserArgs {
    /// Port of the page on 127.0.0.1 [default: a free one]
    #[arg(
        long,
        value_name = "PORT",
        default_value_t = 0,
        hide_default_value = true,
        allow_negative_numbers = true
    )]
    port: u16,
    /// Print the address of the page, and open no browser
    #[arg(long)]
    no_open: bool,
}

/// The page of a configuration, and the model and kernel that it asks for.
///
/// # Errors
/// Never in memory.
pub fn site(config: &Config, image: &[u8]) -> Result<Site> {
    Ok(Site {
        page: page::html(config)?.into_bytes(),
        files: vec![("/model", page::gzip(image)?), ("/kernel.wasm.gz", KERNEL.to_vec())],
        ..Site::default()
    })
}

/// A page on its server, until this is dropped.
#[derive(Debug)]
pub struct Served {
    _server: Server,
    _forward: Option<TempDir>,
}

impl BrowserArgs {
    /// An option that was given.
    #[must_use]
    pub fn given(&self) -> Option<&'static str> {
        if self.port != 0 { Some("--port") } else { self.no_open.then_some("--no-open") }
    }

    /// Serves a site, tells its address with `tell`, and opens the browser if there is one.
    ///
    /// # Errors
    /// A port that is taken.
    pub fn serve(&self, site: Site, tell: impl FnOnce(&str) -> Result<()>) -> Result<Served> {
        let server = Server::start(self.port, site)?;
        let address = server.address();
        tell(&address)?;
        let forward = if self.no_open { None } else { open(&address)? };
        Ok(Served { _server: server, _forward: forward })
    }
}

/// Opens the user's browser where there is a display. A command line can be read by other users, so that the
/// browser gets a file of this user's alone, which forwards it to the address.
fn open(address: &str) -> Result<Option<TempDir>> {
    let has_display =
        ["DISPLAY", "WAYLAND_DISPLAY"].iter().any(|name| std::env::var_os(name).is_some());
    if !has_display {
        return Ok(None);
    }
    let folder = session::scratch()?;
    let file = folder.path().join("chaincell.html");
    let html = format!(
        "<!doctype html><meta charset=\"utf-8\"><title>chaincell</title>\
         <meta http-equiv=\"refresh\" content=\"0; url={address}\"><a href=\"{address}\">chaincell</a>\n"
    );
    write_whole(&file, html.as_bytes())?;
    start(&file);
    Ok(Some(folder))
}

/// Starts the desktop's program for a file; without one the printed address remains.
fn start(file: &Path) {
    let mut command = Command::new("xdg-open");
    command.arg(file).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let _ = command.spawn();
}

/// Waits until Ctrl-C or `is_over`.
pub fn wait_until(mut is_over: impl FnMut() -> bool) {
    while !interrupt::asked() && !is_over() {
        sleep(LOOK);
    }
}
