//! Pointers from C, checked for null and alignment before anything is read or written.

use crate::code::Code;

/// Alignment of a tissue's storage \[bytes\].
pub const ALIGN: usize = 16;
/// The same for a body of nodal shapes \[bytes\].
pub const SHAPE_ALIGN: usize = 64;

/// Whether a pointer may be used at all.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), Code> {
    check_to(pointer.cast(), align_of::<T>())
}

/// Whether a pointer is not null and a multiple of `align`.
pub(crate) fn check_to(pointer: *const u8, align: usize) -> Result<(), Code> {
    if pointer.is_null() {
        Err(Code::Null)
    } else if pointer.addr() & (align - 1) != 0 {
        Err(Code::Misaligned)
    } else {
        Ok(())
    }
}

/// [`check`], and that so many values are no longer than an object may be.
fn check_many<T>(pointer: *const T, count: usize) -> Result<(), Code> {
    check(pointer)?;
    if count > isize::MAX as usize / size_of::<T>().max(1) { Err(Code::Range) } else { Ok(()) }
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

/// `count` values, for reading; none may stand at null.
///
/// # Safety
/// A pointer that passes [`check`] points to `count` valid values, which nobody writes for `'a`.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize) -> Result<&'a [T], Code> {
    if count == 0 {
        return Ok(&[]);
    }
    check_many(pointer, count)?;
    // SAFETY: not null, aligned, no longer than any object, and the caller says what stands there.
    Ok(unsafe { core::slice::from_raw_parts(pointer, count) })
}

/// The same, for writing.
///
/// # Safety
/// A pointer that passes [`check`] points to `count` valid values, which nobody else uses for `'a`.
pub(crate) unsafe fn slice_mut<'a, T>(pointer: *mut T, count: usize) -> Result<&'a mut [T], Code> {
    if count == 0 {
        return Ok(&mut []);
    }
    check_many(pointer, count)?;
    // SAFETY: not null, aligned, no longer than any object, and the caller says what stands there.
    Ok(unsafe { core::slice::from_raw_parts_mut(pointer, count) })
}
