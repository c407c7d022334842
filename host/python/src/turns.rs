//! What threads share and use in turns.

use std::collections::VecDeque;
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;

use crate::errors::Class;
use crate::signals::LOOK;

/// A value that one thread has at a time, in the order in which they asked. Ctrl-C ends the wait for it, and nobody waits for a turn that
/// cannot come: that of the same thread, whose signal handler asks, and that of a thread which a fork has
/// left behind.
#[derive(Debug)]
pub(crate) struct Turns<T> {
    value: Mutex<T>,
    line: Mutex<Line>,
    /// Told when the value is given back.
    given_back: Condvar,
}

/// Who has the value, and who waits for it.
#[derive(Debug, Default)]
struct Line {
    owner: Option<Owner>,
    waiting: VecDeque<Owner>,
}

/// A thread of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Owner {
    process: u32,
    thread: u32,
}

/// The value, for the thread that took it; given back in the order of the fields.
pub(crate) struct Turn<'a, T> {
    value: MutexGuard<'a, T>,
    _back: Back<'a, T>,
}

/// Lets the next thread have the value.
struct Back<'a, T>(&'a Turns<T>);

impl Owner {
    fn own() -> Self {
        static NEXT: AtomicU32 = AtomicU32::new(0);
        thread_local!(static NUMBER: u32 = NEXT.fetch_add(1, Ordering::Relaxed));
        Self { process: std::process::id(), thread: NUMBER.with(|number| *number) }
    }

    /// Refuses to wait for what never ends.
    fn check(self, owner: Self) -> PyResult<()> {
        let text = if owner == self {
            "a signal handler uses what its own thread is using: let the handler set a flag or raise"
        } else if owner.process != self.process {
            "another thread used it when this process was forked: make another one here"
        } else {
            return Ok(());
        };
        Err(Class::Base.error(text))
    }
}

fn locked<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Line {
    /// Lets the first in the line have the value, if that is `own` and it is there.
    fn next(&mut self, own: Owner) -> bool {
        // A child of a fork has none of the threads that waited in its parent.
        self.waiting.retain(|other| other.process == own.process);
        let is_next = self.owner.is_none() && self.waiting.front() == Some(&own);
        if is_next {
            self.owner = self.waiting.pop_front();
        }
        is_next
    }

    fn leave(&mut self, own: Owner) {
        self.waiting.retain(|other| *other != own);
    }
}

impl<T> Turns<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value: Mutex::new(value), line: Mutex::default(), given_back: Condvar::new() }
    }

    /// The value, once other threads are done with it. Not while attached to Python: another thread may
    /// have it and wait for Python.
    pub(crate) fn take(&self) -> PyResult<Turn<'_, T>> {
        let own = Owner::own();
        let mut line = locked(&self.line);
        line.waiting.push_back(own);
        while !line.next(own) {
            let waited = self.given_back.wait_timeout(line, LOOK);
            let (found, timeout) = waited.unwrap_or_else(PoisonError::into_inner);
            line = found;
            if timeout.timed_out() {
                // A handler that asks for the value too must not wait behind its own thread.
                line.leave(own);
                line.owner.map_or(Ok(()), |owner| own.check(owner))?;
                drop(line);
                Python::attach(|py| py.check_signals())?;
                line = locked(&self.line);
                line.waiting.push_front(own);
            }
        }
        drop(line);
        Ok(Turn { value: locked(&self.value), _back: Back(self) })
    }
}

impl<T> Drop for Back<'_, T> {
    fn drop(&mut self) {
        locked(&self.0.line).owner = None;
        self.0.given_back.notify_all();
    }
}

impl<T> Deref for Turn<'_, T> {
    type Target = T;

    fn deref(&self) -> &T {
        &self.value
    }
}

impl<T> DerefMut for Turn<'_, T> {
    fn deref_mut(&mut self) -> &mut T {
        &mut self.value
    }
}
