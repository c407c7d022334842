//! A recorded session: its trace and its model, read and put at the start.

use std::path::{Path, PathBuf};

use chaincell_kernel::Model;
use chaincell_kernel::trace::Reader;

use super::model_file;
use super::restore;
use crate::bake::ImageBytes;
use crate::engine::staged::Staged;
use crate::engine::{Arithmetic, Scheme};
use crate::error::{Error, Result};
use crate::files::recording::{self, Start};

/// Which session.
#[derive(Debug, Clone, clap::Args)]
pub struct RecordedArgs {
    /// Trace from `run`, `serve`, `cosim` or firmware, or the folder of such a run
    #[arg(value_name = "SESSION")]
    trace: PathBuf,
    /// Model file that the trace was recorded with [default: model.chaincell beside the trace]
    #[arg(long, value_name = "MODEL")]
    model: Option<PathBuf>,
}

/// The bytes of trace and model.
pub struct Recorded {
    /// The trace's file.
    pub path: PathBuf,
    bytes: Vec<u8>,
    model_path: PathBuf,
    image: ImageBytes,
}

/// A session at its start.
pub struct Begun<'a> {
    pub trace: Reader<'a>,
    pub model: Model<'a>,
    pub tissue: Staged<'a>,
    pub scheme: Scheme,
    pub precision: Arithmetic,
    pub start: Start,
}

impl RecordedArgs {
    /// The session of a trace or of the folder of a run.
    pub fn of(trace: PathBuf, model: Option<PathBuf>) -> Self {
        Self { trace, model }
    }

    /// Returns true if a path is a session rather than a model: a folder, or a file that begins like a trace.
    pub fn is_session(path: &Path) -> bool {
        path.is_dir() || recording::begins_like_a_trace(path)
    }

    /// Reads both files.
    ///
    /// # Errors
    /// A file that is not there or another one, with its path.
    pub fn read(&self) -> Result<Recorded> {
        let path = recording::trace_of(&self.trace);
        let bytes = recording::read(&path)?;
        // A trace that is none is named before a model that is missing.
        Reader::open(&bytes).map_err(|why| Error::file("replay", &path, why))?;
        let model_path = self.model_path(&path)?;
        let image = model_file::read(&model_path)?;
        Ok(Recorded { path, bytes, model_path, image })
    }

    /// The model that was named, else the one beside the trace.
    fn model_path(&self, trace: &Path) -> Result<PathBuf> {
        if let Some(model) = &self.model {
            return Ok(model.clone());
        }
        let beside = trace.with_file_name(recording::MODEL);
        if beside.exists() {
            return Ok(beside);
        }
        let why = format_args!(
            "there is no {} beside it: name the model of the recording with --model",
            recording::MODEL
        );
        Err(Error::file("replay", trace, why))
    }
}

impl Recorded {
    /// The image of the model.
    pub fn image(&self) -> &ImageBytes {
        &self.image
    }

    /// A tissue at the start of the session, or after the snapshot that was taken after the tick `from`.
    ///
    /// # Errors
    /// Files that do not fit together, with what to do.
    pub fn begin(&self, from: Option<u64>) -> Result<Begun<'_>> {
        let trace = Reader::open(&self.bytes);
        let trace = trace.map_err(|why| Error::file("replay", &self.path, why))?;
        let model = model_file::parse(&self.image, &self.model_path)?;
        let (mut tissue, scheme, precision) = recording::tissue(&trace, &self.path, model)?;
        let start = restore::start((&trace, &self.path), &self.bytes, from, &mut tissue)?;
        Ok(Begun { trace, model, tissue, scheme, precision, start })
    }

    /// The error of a command that the model does not admit.
    pub fn bad_command(&self, record: u32) -> Error {
        let why = format_args!(
            "the command of record {record} does not fit the model: take the model and the release \
             that it was recorded with"
        );
        Error::file("replay", &self.path, why)
    }
}
