//! Sharing a loop among threads that a host lends.
//!
//! The kernel has no threads. It cuts a loop over a large body into [`PARTS`] parts that do not touch each
//! other's memory, and asks its [`Workers`] to run them. The parts are fixed by the model alone, and each has
//! its own sums: any number of threads gives the same bits.

use core::marker::PhantomData;

use super::{VectorUnit, Work, run};
use crate::model::parts::PARTS;

/// One part of a loop.
pub type Job<'j> = &'j mut (dyn FnMut() + Send);

/// Threads that a host lends to the kernel.
///
/// ```
/// # use chaincell_kernel::{Model, Network, Settings, Tissue, Track, include_model};
/// use chaincell_kernel::{Job, Team, Workers};
///
/// /// One thread for each part; a host keeps its threads from tick to tick.
/// struct Threads;
///
/// impl Workers for Threads {
///     fn run(&self, jobs: &mut [Job<'_>]) {
///         std::thread::scope(|scope| jobs.iter_mut().for_each(|job| drop(scope.spawn(job))));
///     }
/// }
/// # let image = include_model!(concat!(env!("CARGO_MANIFEST_DIR"), "/data/plane9.chaincell"));
/// # let model = Model::from_bytes(image)?;
/// # let network = Network::new(model, Settings::for_model(&model))?;
/// # let mut tissue = Tissue::<128, Track>::new();
/// # tissue.reset(&network)?;
/// let mut view = tissue.view();
/// view.team = Team::of(&Threads); // small bodies are one part
/// # let mut done = [false; 3];
/// # let [mut a, mut b, mut c] = done.each_mut().map(|done| move || *done = true);
/// # Threads.run(&mut [&mut a, &mut b, &mut c]);
/// # assert_eq!(done, [true; 3]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Workers: Sync {
    /// Runs each of these jobs once, in any order and on any threads, and returns when the last of
    /// them has ended. A job that is left out is run by the caller.
    fn run(&self, jobs: &mut [Job<'_>]);
}

/// The threads that run the parts of a loop: the calling thread alone, or workers too. On targets without a
/// vector unit it is always the calling thread, and workers are not stored.
#[derive(Clone, Copy, Default)]
pub struct Team<'a> {
    #[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
    workers: Option<&'a dyn Workers>,
    workers_of: PhantomData<&'a ()>,
}

impl<'a> Team<'a> {
    /// The calling thread alone.
    pub const ALONE: Self = Self {
        #[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
        workers: None,
        workers_of: PhantomData,
    };

    /// Returns a team of these workers, if the target has a vector unit. The bits are those of one thread.
    #[must_use]
    pub fn of(workers: &'a dyn Workers) -> Self {
        #[cfg(any(
            target_arch = "x86_64",
            all(target_arch = "aarch64", target_feature = "neon")
        ))]
        return Self { workers: Some(workers), workers_of: PhantomData };
        #[cfg(not(any(
            target_arch = "x86_64",
            all(target_arch = "aarch64", target_feature = "neon")
        )))]
        {
            let _ = workers;
            Self::ALONE
        }
    }

    fn share(self, jobs: &mut [Job<'_>]) {
        #[cfg(any(target_arch = "x86_64", all(target_arch = "aarch64", target_feature = "neon")))]
        if let Some(workers) = self.workers {
            workers.run(jobs);
        }
        #[cfg(not(any(
            target_arch = "x86_64",
            all(target_arch = "aarch64", target_feature = "neon")
        )))]
        let _ = jobs;
    }

    /// Runs the works of the parts on the unit; the calling thread runs that of a single part.
    #[inline(always)]
    pub(crate) fn run<W>(self, unit: Option<VectorUnit>, mut works: [Option<W>; PARTS])
    where
        W: Work<Output = ()> + Send,
    {
        let is_shared = works.iter().skip(1).any(Option::is_some);
        let mut jobs = works.each_mut().map(|slot| {
            move || {
                if let Some(work) = slot.take() {
                    run(unit, work);
                }
            }
        });
        let mut jobs = jobs.each_mut().map(|job| job as Job<'_>);
        if is_shared {
            self.share(&mut jobs);
        }
        for job in jobs {
            job();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::f32x8::F32x8;
    use super::*;
    use core::sync::atomic::{AtomicUsize, Ordering};

    struct Count<'a>(&'a AtomicUsize);

    impl Work for Count<'_> {
        type Output = ();

        #[inline(always)]
        fn run<V: F32x8>(self) {
            self.0.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Runs only the first three jobs, each in its own thread.
    struct FirstThree;

    impl Workers for FirstThree {
        fn run(&self, jobs: &mut [Job<'_>]) {
            std::thread::scope(|scope| {
                for job in jobs.iter_mut().take(3) {
                    scope.spawn(job);
                }
            });
        }
    }

    // REQ-BIT-08
    #[test]
    fn each_part_is_done_once_whoever_helps() {
        for team in [Team::ALONE, Team::of(&FirstThree)] {
            let count = AtomicUsize::new(0);
            team.run(VectorUnit::find(), [(); PARTS].map(|()| Some(Count(&count))));
            assert_eq!(count.into_inner(), PARTS);
        }
    }
}
