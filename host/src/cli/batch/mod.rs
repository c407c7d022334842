//! `chaincell run --batch`: many paths and models in one process, on all processors.

mod job;
mod list;
mod models;
mod results;

use std::num::NonZero;
use std::path::PathBuf;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder};

use clap::{ArgMatches, Command, FromArgMatches, Id};
use serde::Serialize;

use self::job::Reader;
use self::list::{List, Listed};
use self::models::Models;
use self::results::Results;
use super::model_file;
use super::run::{self, Follower, RunSummary};
use crate::error::{Error, Result};
use crate::files::output::Job;
use crate::interrupt;
use crate::terminal::{self, Progress};
use crate::words::counted;

/// Stack of a job's thread, that of a main thread.
const STACK_BYTES: usize = 8 << 20;

/// The arguments of `run`: of one run, or of many.
#[derive(Debug)]
pub enum Args {
    One(Box<run::Args>),
    Many(BatchArgs),
}

/// A batch.
#[derive(Debug, clap::Args)]
pub struct BatchArgs {
    /// Many runs in one process: a file with one JSON object a line, each a job with `model`, `path` or
    /// `motion`, `out` if its files are wanted, `name`, and other options of `run` without their dashes;
    /// paths count from the file's folder; - reads standard input
    #[arg(long, value_name = "FILE", group = "Source")]
    batch: Option<PathBuf>,
    /// Jobs at the same time [default: one for each processor]
    #[arg(long, value_name = "N", requires = "batch", allow_negative_numbers = true,
        value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// File to which a line of JSON is appended for each job that has ended; those of an earlier run are not
    /// done again where their inputs are the same [default: standard output]
    #[arg(long, value_name = "FILE", requires = "batch")]
    results: Option<PathBuf>,
}

/// Both uses of the command.
const USAGE: &str = "chaincell run [OPTIONS] --out <DIR> <--path <PATH.csv>|--motion <MOTION>> <MODEL>\n       \
                     chaincell run --batch <FILE> [--jobs <N>] [--results <FILE>]";
/// The ids of these arguments.
const OWN: [&str; 3] = ["batch", "jobs", "results"];

impl clap::Args for Args {
    fn augment_args(command: Command) -> Command {
        let command = run::Args::augment_args(BatchArgs::augment_args(command));
        let ids = command.get_arguments().map(|option| option.get_id().clone());
        let others: Vec<Id> = ids.filter(|id| !OWN.contains(&id.as_str())).collect();
        // Required arguments are not asked for where one that excludes them is given.
        let command = OWN.iter().fold(command, |command, own| {
            command.mut_arg(own, |option| option.conflicts_with_all(others.clone()))
        });
        command.override_usage(USAGE)
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Args {
    fn from_arg_matches(matches: &ArgMatches) -> std::result::Result<Self, clap::Error> {
        if matches.contains_id("batch") {
            return BatchArgs::from_arg_matches(matches).map(Self::Many);
        }
        run::Args::from_arg_matches(matches).map(|args| Self::One(Box::new(args)))
    }

    fn update_from_arg_matches(
        &mut self,
        matches: &ArgMatches,
    ) -> std::result::Result<(), clap::Error> {
        Self::from_arg_matches(matches).map(|args| *self = args)
    }
}

pub fn execute(args: &Args) -> Result<()> {
    match args {
        Args::One(args) => run::execute(args),
        Args::Many(args) => args.execute(),
    }
}

/// A line of the results.
#[derive(Serialize)]
struct Line<'a> {
    job: u64,
    #[serde(skip_serializing_if = "Option::is_none")]
    name: Option<&'a str>,
    #[serde(flatten)]
    outcome: Outcome,
}

/// The outcome of a job.
#[derive(Serialize)]
#[serde(untagged)]
enum Outcome {
    Done {
        inputs_hash: String,
        notes: Vec<String>,
        #[serde(flatten)]
        summary: Box<RunSummary>,
    },
    Failed {
        error: String,
    },
    /// Done before.
    #[serde(skip)]
    Skipped,
    /// The user asked to stop.
    #[serde(skip)]
    Stopped,
}

/// A batch under way.
struct Batch {
    list: List,
    results: Results,
    models: Models,
    progress: Progress,
    next: AtomicUsize,
    tally: Tally,
    /// Why no further job begins.
    fatal: Mutex<Option<Error>>,
}

/// Numbers of jobs.
#[derive(Default)]
struct Tally {
    done: AtomicU64,
    skipped: AtomicU64,
    failed: AtomicU64,
    /// The first line that failed, and why.
    first: Mutex<Option<(u64, String)>>,
}

impl BatchArgs {
    fn execute(&self) -> Result<()> {
        let path = self.batch.as_deref().unwrap_or("-".as_ref());
        let list = interrupt::at_once(|| List::read(path))?;
        let results = Results::open(self.results.as_deref())?;
        let progress = Progress::new(list.jobs.len() as u64, "batch");
        let batch = Batch {
            list,
            results,
            models: Models::default(),
            progress,
            next: AtomicUsize::new(0),
            tally: Tally::default(),
            fatal: Mutex::new(None),
        };
        let processors = thread::available_parallelism().map_or(1, NonZero::get);
        let count = self.jobs.map_or(processors, usize::from).min(batch.list.jobs.len());
        thread::scope(|scope| {
            for _ in 1..count {
                // With fewer threads it takes longer.
                let _ = Builder::new().name("batch".into()).spawn_scoped(scope, || batch.work());
            }
            batch.work();
        });
        batch.end(self)
    }
}

impl Batch {
    /// Does jobs until none is left.
    fn work(&self) {
        let mut reader = Reader::new(&self.list.base);
        while !interrupt::asked() && self.fatal().is_none() {
            let Some(job) = self.list.jobs.get(self.next.fetch_add(1, Ordering::Relaxed)) else {
                return;
            };
            let outcome = self.apart(job, &mut reader).unwrap_or_else(|why| match why {
                Error::Interrupted => Outcome::Stopped,
                why => Outcome::Failed { error: format!("{}:{}: {why}", self.list.name, job.line) },
            });
            self.tally.add(job.line, &outcome);
            self.progress.step();
            if matches!(outcome, Outcome::Skipped | Outcome::Stopped) {
                continue;
            }
            let line = Line { job: job.line, name: job.name.as_deref(), outcome };
            if let Err(why) = self.results.add(&line) {
                self.fatal().get_or_insert(why);
            }
        }
    }

    fn fatal(&self) -> std::sync::MutexGuard<'_, Option<Error>> {
        self.fatal.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does a job in a thread of its own: one that shares its sweeps pins it, and a fault ends no other job.
    fn apart(&self, job: &Listed, reader: &mut Reader<'_>) -> Result<Outcome> {
        thread::scope(|scope| {
            let thread = Builder::new().name("job".into()).stack_size(STACK_BYTES);
            let thread =
                thread.spawn_scoped(scope, || self.outcome(job, reader)).map_err(|why| {
                    Error::check(format!("no thread for it: {why}; take fewer --jobs"))
                })?;
            let fault =
                || Error::check("a fault of this program, told on standard error: report it");
            thread.join().unwrap_or_else(|_| Err(fault()))
        })
    }

    fn outcome(&self, job: &Listed, reader: &mut Reader<'_>) -> Result<Outcome> {
        // Read the job.
        let options = job.options.as_ref().map_err(Error::input)?;
        let mut args = reader.read(options)?;
        let loaded = self.models.get(&args.model)?;
        let inputs_hash = reader.inputs_hash(options, &loaded.sha1)?;
        // Pass over it where it was done; a folder that it began to fill is its own.
        let begun = args.out.as_ref().and_then(|out| Job::of_folder(out));
        let is_begun = begun.is_some_and(|begun| begun.inputs_hash == inputs_hash);
        let is_filled =
            is_begun && args.out.as_ref().is_some_and(|out| out.join("summary.json").is_file());
        let earlier = self.results.earlier(job.line, job.name.as_deref());
        if earlier == Some(&inputs_hash) && (args.out.is_none() || is_filled) {
            return Ok(Outcome::Skipped);
        }
        // Run it.
        args.force |= is_begun;
        args.inputs_hash = Some(inputs_hash.clone());
        let mut notes = Vec::new();
        let model = model_file::parse(&loaded.image, &args.model)?;
        let ended = args.carry_out(&loaded.image, model, Follower::Batch(&mut notes));
        let ended = ended.map_err(|why| reader.named(why))?;
        if ended.summary.interrupted {
            return Ok(Outcome::Stopped);
        }
        Ok(Outcome::Done { inputs_hash, notes, summary: Box::new(ended.summary) })
    }

    /// Says how many jobs came to what.
    fn end(self, args: &BatchArgs) -> Result<()> {
        drop(self.progress);
        let Tally { done, skipped, failed, first } = self.tally;
        let [done, skipped, failed] = [done, skipped, failed].map(AtomicU64::into_inner);
        let jobs = counted(self.list.jobs.len(), "job");
        terminal::note(format_args!("{jobs}: {done} done, {skipped} done before, {failed} failed"));
        if let Some(why) = self.fatal.into_inner().unwrap_or_else(PoisonError::into_inner) {
            return Err(why);
        }
        if interrupt::asked() {
            return Err(Error::interrupted(args.results.as_deref()));
        }
        match first.into_inner().unwrap_or_else(PoisonError::into_inner) {
            Some((_, why)) => Err(Error::check(format!("{failed} of {jobs} failed, first {why}"))),
            None => Ok(()),
        }
    }
}

impl Tally {
    fn add(&self, line: u64, outcome: &Outcome) {
        let count = match outcome {
            Outcome::Done { .. } => &self.done,
            Outcome::Skipped => &self.skipped,
            Outcome::Failed { .. } => &self.failed,
            Outcome::Stopped => return,
        };
        count.fetch_add(1, Ordering::Relaxed);
        if let Outcome::Failed { error } = outcome {
            let mut first = self.first.lock().unwrap_or_else(PoisonError::into_inner);
            if first.as_ref().is_none_or(|(earlier, _)| line < *earlier) {
                *first = Some((line, error.clone()));
            }
        }
    }
}
