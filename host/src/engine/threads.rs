//! Threads that share the sweeps of a large body with the ticking thread.
//!
//! Each thread is pinned to its own processor. Between the loops of a tick, and for up to two milliseconds
//! after one, a thread waits by polling for work, without a system call; then it sleeps. A shared loop
//! allocates a few small blocks on the heap. The bits are those of one thread.

use std::fmt::{self, Display};
use std::hint::spin_loop;
use std::str::FromStr;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, Once, OnceLock, PoisonError};
use std::time::{Duration, Instant};

use chaincell_kernel::parts::{LINKS_SHARED, PARTS, SHAPES_SHARED};
use chaincell_kernel::{Job, Model, Workers};
use rayon_core::{ThreadPool, ThreadPoolBuilder, Yield, yield_now};
use rustix::thread::{CpuSet, sched_getaffinity, sched_setaffinity};

use crate::choice::by_text;
use crate::error::{Error, Result};
use crate::words::counted;

/// Time for which a thread polls for work before it sleeps.
const LOOKING: Duration = Duration::from_millis(2);

/// Looks at the helpers, some tens of microseconds, before the ticking thread sleeps until they end.
const SPINS: u32 = 4_096;

/// Number of threads that sweep a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ThreadCount {
    /// This many, 1 to [`PARTS`].
    Of(usize),
    /// One on a small body, otherwise one less than the number of processors.
    Auto,
}

impl FromStr for ThreadCount {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        match text.parse() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(count @ 1..=PARTS) => Ok(Self::Of(count)),
            _ => Err(format!("give 1 to {}, or auto", PARTS)),
        }
    }
}

impl Display for ThreadCount {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Of(count) => count.fmt(to),
            Self::Auto => "auto".fmt(to),
        }
    }
}

by_text!(ThreadCount);

impl ThreadCount {
    /// Starts the threads for a body; `None` if the ticking thread works alone.
    ///
    /// # Errors
    /// More threads than the body has parts, or than there are processors.
    pub fn start(self, model: &Model<'_>) -> Result<Option<Threads>> {
        let processors = processors().len();
        let most = model.thread_parts().count();
        let count = match self {
            Self::Auto if most == 1 => 1,
            Self::Auto => processors.saturating_sub(1).clamp(1, most),
            Self::Of(count) => count,
        };
        if count > most {
            let cells = counted(model.body_cells() as u64, "cell");
            return Err(Error::input(match most {
                1 => format!(
                    "--threads {count}: a body of {cells} is swept by one thread, several share one \
                     of {SHAPES_SHARED} cells of shapes or more, or of {LINKS_SHARED} of links; \
                     leave it out"
                ),
                _ => format!(
                    "--threads {count}: a body of {cells} of shapes has {most} parts; take at most \
                     as many threads"
                ),
            }));
        }
        if count > processors {
            return Err(Error::input(format!(
                "--threads {count}: this process may use {}; take at most as many threads",
                counted(processors as u64, "processor")
            )));
        }
        if count == 1 { Ok(None) } else { Threads::new(count).map(Some) }
    }
}

/// Helper threads of the thread that created them.
pub struct Threads {
    pool: ThreadPool,
    /// Pins the ticking thread at its first shared loop: not before, since a process that it starts would
    /// inherit the pinning to that processor.
    pinned: Once,
    /// Number of helpers that poll for work.
    awake: Arc<AtomicUsize>,
}

impl Threads {
    /// Creates `count` threads, including the ticking one.
    fn new(count: usize) -> Result<Self> {
        let failed =
            |why: &dyn Display| Error::check(format!("--threads {count}: {why}; take --threads 1"));
        let pool = ThreadPoolBuilder::new()
            .num_threads(count - 1)
            .thread_name(|index| format!("sweep-{}", index + 1))
            .start_handler(move |index| {
                if let Some(&processor) = processors().get(index + 1) {
                    pin(processor);
                }
            })
            .build()
            .map_err(|why| failed(&why))?;
        Ok(Self { pool, pinned: Once::new(), awake: Arc::default() })
    }

    /// Makes every helper poll for work.
    fn wake(&self) {
        let count = self.pool.current_num_threads();
        while self.awake.load(Ordering::Relaxed) < count {
            self.awake.fetch_add(1, Ordering::Relaxed);
            let awake = Arc::clone(&self.awake);
            self.pool.spawn(move || {
                look_for_work();
                awake.fetch_sub(1, Ordering::Relaxed);
            });
        }
    }
}

/// The processors that this process may use before any of its threads is pinned; empty if the system does not
/// report them.
fn processors() -> &'static [usize] {
    static PROCESSORS: OnceLock<Vec<usize>> = OnceLock::new();
    PROCESSORS.get_or_init(|| {
        let allowed = sched_getaffinity(None).unwrap_or_default();
        (0..CpuSet::MAX_CPU).filter(|&processor| allowed.is_set(processor)).collect()
    })
}

/// Pins the calling thread to a processor; a thread that cannot be pinned works unpinned.
fn pin(processor: usize) {
    let mut only = CpuSet::new();
    only.set(processor);
    if let Err(why) = sched_setaffinity(None, &only) {
        log::warn!("a sweeping thread cannot be pinned to processor {processor}: {why}");
    }
}

/// Executes available work until none has arrived for a while.
fn look_for_work() {
    let mut last = Instant::now();
    while last.elapsed() < LOOKING {
        if yield_now() == Some(Yield::Executed) {
            last = Instant::now();
        } else {
            spin_loop();
        }
    }
}

impl Workers for Threads {
    fn run(&self, jobs: &mut [Job<'_>]) {
        self.pinned.call_once(|| {
            if let Some(&processor) = processors().first() {
                pin(processor);
            }
        });
        // Distribute the jobs: helpers and this thread take the next one in turn.
        self.wake();
        let jobs: Vec<Mutex<&mut Job<'_>>> = jobs.iter_mut().map(Mutex::new).collect();
        let (next, helping) = (AtomicUsize::new(0), AtomicUsize::new(0));
        let work = || {
            while let Some(job) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
                job.lock().unwrap_or_else(PoisonError::into_inner)();
            }
        };
        self.pool.in_place_scope(|scope| {
            for _ in 0..self.pool.current_num_threads() {
                helping.fetch_add(1, Ordering::Relaxed);
                scope.spawn(|_| {
                    work();
                    helping.fetch_sub(1, Ordering::Release);
                });
            }
            work();
            // Mostly without a system call: the end of the scope then takes no time. It sleeps for a helper
            // that has lost its processor.
            for _ in 0..SPINS {
                if helping.load(Ordering::Acquire) == 0 {
                    break;
                }
                spin_loop();
            }
        });
    }
}
