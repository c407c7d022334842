//! What threads share and use in turns.

use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};

use pyo3::prelude::*;

use crate::errors::Class;
use crate::signals::{LOOK, caught};

/// A value that one thread has at a time. Ctrl-C ends the wait for it, and nobody waits for a turn that
/// cannot come: that of the same thread, whose signal handler asks, and that of a thread which a fork has
/// left behind.
#[derive(Debug)]
pub(crate) struct Turns<T> {
    value: Mutex<T>,
    /// Who has the value.
    owner: Mutex<Option<Owner>>,
    /// Told when it is given back.
    given_back: Condvar,
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

impl<T> Turns<T> {
    pub(crate) fn new(value: T) -> Self {
        Self { value: Mutex::new(value), owner: Mutex::new(None), given_back: Condvar::new() }
    }

    /// The value, once other threads are done with it. Not while attached to Python: another thread may
    /// have it and wait for Python.
    pub(crate) fn take(&self) -> PyResult<Turn<'_, T>> {
        let own = Owner::own();
        loop {
            let mut owner = locked(&self.owner);
            if owner.is_some() {
                let waited = self.given_back.wait_timeout(owner, LOOK);
                owner = waited.unwrap_or_else(PoisonError::into_inner).0;
            }
            let Some(other) = *owner else {
                *owner = Some(own);
                drop(owner);
                return Ok(Turn { value: locked(&self.value), _back: Back(self) });
            };
            drop(owner);
            own.check(other)?;
            caught()?;
        }
    }
}

impl<T> Drop for Back<'_, T> {
    fn drop(&mut self) {
        *locked(&self.0.owner) = None;
        self.0.given_back.notify_one();
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
