//! Pointers from C, checked for null and alignment before anything is read or written.

use crate::code::Code;

/// Whether a pointer may be used at all.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), Code> {
    if pointer.is_null() {
        Err(Code::Null)
    } else if !pointer.is_aligned() {
        Err(Code::Misaligned)
    } else {
        Ok(())
    }
}

/// Reads one value.
///
/// # Safety
/// A pointer that passes [`check`] points to a valid `T`.
pub(crate) unsafe fn read<T: Copy>(pointer: *const T) -> Result<T, Code> {
    check(pointer)?;
    // SAFETY: not null and aligned, and the caller says what stands there.
    Ok(unsafe { pointer.read() })
}

/// Writes one value.
///
/// # Safety
/// A pointer that passes [`check`] points to memory for a `T`.
pub(crate) unsafe fn write<T: Copy>(pointer: *mut T, value: T) -> Result<(), Code> {
    check(pointer)?;
    // SAFETY: not null and aligned, and the caller says that it may be written.
    unsafe { pointer.write(value) };
    Ok(())
}

/// Writes one value where somebody asked for it: null asks for nothing.
///
/// # Safety
/// As [`write`].
pub(crate) unsafe fn write_if_asked<T: Copy>(pointer: *mut T, value: T) -> Result<(), Code> {
    if pointer.is_null() {
        return Ok(());
    }
    // SAFETY: the caller's promise is handed on.
    unsafe { write(pointer, value) }
}

/// The bytes of a text before its 0, at most so many: a longer one is cut there and looked at no further.
///
/// # Safety
/// A pointer that is not null points to a text that ends with a 0.
pub(crate) unsafe fn text(pointer: *const u8, bytes_max: usize) -> Vec<u8> {
    let mut bytes = Vec::new();
    while bytes.len() < bytes_max {
        // SAFETY: all bytes before were not the 0 at the end, so this one belongs to the text.
        match unsafe { pointer.add(bytes.len()).read() } {
            0 => break,
            byte => bytes.push(byte),
        }
    }
    bytes
}
