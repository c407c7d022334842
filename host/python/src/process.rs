//! What belongs to the process that made it.

use pyo3::prelude::*;

use crate::errors::Class;

/// What the child of a fork is told.
pub(crate) fn forked() -> PyErr {
    Class::Closed.error("it was opened by the process that this one was forked from: open one here")
}

/// Something in shared memory. A forked child has a copy, and giving it back there would take it from
/// the parent: the child neither uses nor drops it.
#[derive(Debug)]
pub(crate) struct Owned<T> {
    value: Option<T>,
    process: u32,
}

impl<T> Owned<T> {
    /// Of this process.
    pub(crate) fn new(value: T) -> Self {
        Self { value: Some(value), process: std::process::id() }
    }

    /// The value, for the process that made it.
    pub(crate) fn get(&mut self) -> PyResult<&mut T> {
        if self.process != std::process::id() {
            return Err(forked());
        }
        self.value.as_mut().ok_or_else(|| Class::Closed.error("it is closed: open another"))
    }

    /// Whether there is none any more.
    pub(crate) fn is_closed(&self) -> bool {
        self.value.is_none() || self.process != std::process::id()
    }

    /// Drops the value, in the process that made it.
    pub(crate) fn close(&mut self) {
        let value = self.value.take();
        if self.process != std::process::id() {
            std::mem::forget(value);
        }
    }
}

impl<T> Drop for Owned<T> {
    fn drop(&mut self) {
        self.close();
    }
}
