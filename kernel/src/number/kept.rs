//! States as words. The same code counts, writes, checks and reads them, so that these passes cannot differ.

use core::marker::PhantomData;

use nalgebra::Vector3;

/// The action of a pass on each word.
enum Way<'a> {
    Count,
    Write(&'a mut [u8]),
    /// Reads without changing arrays.
    Check(&'a [u8]),
    Read(&'a [u8]),
}

/// A pass over the words of a state.
pub struct Pass<'a> {
    way: Way<'a>,
    /// Number of words so far.
    words: usize,
    /// The first invalid word.
    bad: Option<usize>,
    lack: Option<PassError>,
}

/// The reason for which a pass failed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PassError {
    /// The word with this index, from 0, is invalid.
    Word(usize),
    /// An array has `room` items, which are too few.
    Room { needed: usize, room: usize },
}

impl<'a> Pass<'a> {
    fn new(way: Way<'a>) -> Self {
        Self { way, words: 0, bad: None, lack: None }
    }

    pub(crate) fn count() -> Self {
        Self::new(Way::Count)
    }

    pub(crate) fn write(bytes: &'a mut [u8]) -> Self {
        Self::new(Way::Write(bytes))
    }

    pub(crate) fn check(bytes: &'a [u8]) -> Self {
        Self::new(Way::Check(bytes))
    }

    pub(crate) fn read(bytes: &'a [u8]) -> Self {
        Self::new(Way::Read(bytes))
    }

    /// Returns the bytes so far, or the reason for which the pass failed.
    pub(crate) fn end(self) -> Result<usize, PassError> {
        match self.lack.or(self.bad.map(PassError::Word)) {
            Some(why) => Err(why),
            None => Ok(4 * self.words),
        }
    }

    /// Counts or writes a word and returns it, or returns the stored word.
    pub(crate) fn word(&mut self, value: u32) -> u32 {
        let at = 4 * self.words;
        self.words += 1;
        match &mut self.way {
            Way::Count => value,
            Way::Write(bytes) => {
                match bytes.get_mut(at..).and_then(<[u8]>::first_chunk_mut) {
                    Some(slot) => *slot = value.to_le_bytes(),
                    None => self.refuse(),
                }
                value
            }
            Way::Check(bytes) | Way::Read(bytes) => {
                match bytes.get(at..).and_then(<[u8]>::first_chunk) {
                    Some(&stored) => u32::from_le_bytes(stored),
                    None => {
                        self.refuse();
                        value
                    }
                }
            }
        }
    }

    /// Marks the previous word as invalid.
    pub(crate) fn refuse(&mut self) {
        let word = self.words.saturating_sub(1);
        self.bad = self.bad.or(Some(word));
    }

    /// Passes over the first `needed` items of an array.
    pub(crate) fn slice<T: Kept>(&mut self, items: &mut [T], needed: usize) {
        let room = items.len();
        let Some(items) = items.get_mut(..needed) else {
            self.lack = self.lack.or(Some(PassError::Room { needed, room }));
            return;
        };
        if let (Way::Count, [first, ..]) = (&self.way, &*items) {
            // All items have the same number of words.
            let (before, mut copy) = (self.words, *first);
            copy.keep(self);
            self.words = before + (self.words - before) * needed;
            return;
        }
        for item in items {
            let mut copy = *item;
            copy.keep(self);
            if self.is_reading() {
                *item = copy;
            }
        }
    }

    /// Passes over an array, whose items must each be fit at their place.
    pub(crate) fn slice_if<T: Kept>(
        &mut self,
        items: &mut [T],
        mut is_fit: impl FnMut(usize, &T) -> bool,
    ) {
        for (place, item) in items.iter_mut().enumerate() {
            let mut copy = *item;
            copy.keep(self);
            if !is_fit(place, &copy) {
                self.refuse();
            } else if self.is_reading() {
                *item = copy;
            }
        }
    }

    /// Notes that an array is too short.
    #[cfg(any(feature = "cut", feature = "relax"))]
    pub(crate) fn lacks(&mut self, needed: usize, room: usize) {
        self.lack = self.lack.or(Some(PassError::Room { needed, room }));
    }

    /// Returns true if a part follows that not every state has: words are left to be read, or the state to be
    /// written `has` it.
    pub(crate) fn has_more(&self, has: bool) -> bool {
        match &self.way {
            Way::Count | Way::Write(_) => has,
            Way::Check(bytes) | Way::Read(bytes) => 4 * self.words < bytes.len(),
        }
    }

    /// Returns true if the items of arrays take the values that are read.
    pub(crate) fn is_reading(&self) -> bool {
        matches!(self.way, Way::Read(_))
    }
}

/// A value that a snapshot can hold.
pub trait Kept: Copy {
    /// Identifies the layout: a hash of the names, order and types of all fields.
    const LAYOUT: u32;
    /// Any value.
    const BLANK: Self;
    /// Passes over the words of the value.
    fn keep(&mut self, pass: &mut Pass<'_>);
}

/// Returns the FNV-1a hash of a name, starting from a layout.
pub const fn named(layout: u32, name: &str) -> u32 {
    let (bytes, mut hash, mut at) = (name.as_bytes(), layout ^ 0x811c_9dc5, 0);
    while at < bytes.len() {
        // Constant functions can read a slice only by an index.
        #[allow(clippy::indexing_slicing)]
        let byte = bytes[at] as u32;
        hash = (hash ^ byte).wrapping_mul(0x0100_0193);
        at += 1;
    }
    hash
}

/// Returns the layout of one value followed by another.
pub const fn joined(first: u32, second: u32) -> u32 {
    (first.rotate_left(5) ^ second).wrapping_mul(0x0100_0193)
}

/// Defines a struct and implements `Kept` for it, field by field in this order. A second list has the
/// fields that are not stored, with their values in `Kept::BLANK`.
macro_rules! kept {
    ($(#[$meta:meta])* $vis:vis struct $name:ident $(<$param:ident $(= $default:ty)?>)? {
        $($fields:tt)*
    } $(not stored { $($left_out:tt)* })?) => {
        kept!(@define [$(#[$meta])* $vis struct $name $(<$param $(= $default)?>)?]
            [$(<$param: $crate::number::kept::Kept>)?] [$name $(<$param>)?]
            concat!(stringify!($name) $(, "<", stringify!($param), ">")?),
            [$($fields)*] [$($($left_out)*)?]);
    };
    ($(#[$meta:meta])* $vis:vis struct $name:ident<
        const $size:ident: usize = $value:literal $(, $param:ident = $default:ty)?
    > { $($fields:tt)* }) => {
        kept!(@define
            [$(#[$meta])* $vis struct $name<const $size: usize = $value $(, $param = $default)?>]
            [<const $size: usize $(, $param: $crate::number::kept::Kept)?>] [$name<$size $(, $param)?>]
            concat!(stringify!($name), "<", stringify!($size) $(, ", ", stringify!($param))?, ">"),
            [$($fields)*] []);
    };
    ($(#[$meta:meta])* $vis:vis struct $name:ident $(<$param:ident = $default:ty>)? (
        $in:vis $of:ty
    );) => {
        $(#[$meta])* $vis struct $name $(<$param = $default>)? ($in $of);
        kept!(@implement [$(<$param: $crate::number::kept::Kept>)?] [$name $(<$param>)?]
            concat!(stringify!($name) $(, "<", stringify!($param), ">")?), [0: $of] []);
    };
    (@define [$($head:tt)*] $generics:tt $type:tt $text:expr,
        [$($(#[$of_field:meta])* $in:vis $field:ident: $of:ty),* $(,)?]
        [$($(#[$of_other:meta])* $other_in:vis $other:ident: $other_of:ty = $value:expr),* $(,)?]) => {
        $($head)* {
            $($(#[$of_field])* $in $field: $of,)*
            $($(#[$of_other])* $other_in $other: $other_of,)*
        }
        kept!(@implement $generics $type $text, [$($field: $of),*] [$($other: $value),*]);
    };
    (@implement [$($generics:tt)*] [$($type:tt)*] $text:expr,
        [$($field:tt: $of:ty),*] [$($other:ident: $value:expr),*]) => {
        impl $($generics)* $crate::number::kept::Kept for $($type)* {
            const LAYOUT: u32 = {
                let layout = $crate::number::kept::named(0, $text);
                $(
                    let layout = $crate::number::kept::named(layout, stringify!($field));
                    let layout = $crate::number::kept::joined(layout, <$of as $crate::number::kept::Kept>::LAYOUT);
                )*
                layout
            };
            const BLANK: Self = Self {
                $($other: $value,)*
                $($field: <$of as $crate::number::kept::Kept>::BLANK),*
            };

            fn keep(&mut self, pass: &mut $crate::number::kept::Pass<'_>) {
                $($crate::number::kept::Kept::keep(&mut self.$field, pass);)*
                let _ = pass;
            }
        }
    };
}
pub(crate) use kept;

/// Integers that are stored in one word.
macro_rules! whole {
    ($($type:ty),*) => {$(
        impl Kept for $type {
            const LAYOUT: u32 = named(0, stringify!($type));
            const BLANK: Self = 0;

            fn keep(&mut self, pass: &mut Pass<'_>) {
                match Self::try_from(pass.word(*self as u32)) {
                    Ok(value) => *self = value,
                    Err(_) => pass.refuse(),
                }
            }
        }
    )*};
}
whole!(u8, u16, u32, usize);

impl Kept for u64 {
    const LAYOUT: u32 = named(0, "u64");
    const BLANK: Self = 0;

    fn keep(&mut self, pass: &mut Pass<'_>) {
        let low = pass.word(*self as u32);
        let high = pass.word((*self >> 32) as u32);
        *self = u64::from(low) | u64::from(high) << 32;
    }
}

impl Kept for bool {
    const LAYOUT: u32 = named(0, "bool");
    const BLANK: Self = false;

    fn keep(&mut self, pass: &mut Pass<'_>) {
        match pass.word((*self).into()) {
            0 => *self = false,
            1 => *self = true,
            _ => pass.refuse(),
        }
    }
}

/// A NaN is refused. -0.0 is stored as +0.0.
impl Kept for f32 {
    const LAYOUT: u32 = named(0, "f32");
    const BLANK: Self = 0.0;

    fn keep(&mut self, pass: &mut Pass<'_>) {
        let value = Self::from_bits(pass.word((*self + 0.0).to_bits()));
        if value.is_nan() {
            pass.refuse();
        } else {
            *self = value + 0.0;
        }
    }
}

impl Kept for fixed::types::I8F24 {
    const LAYOUT: u32 = named(0, "I8F24");
    const BLANK: Self = Self::ZERO;

    fn keep(&mut self, pass: &mut Pass<'_>) {
        *self = Self::from_bits(pass.word(self.to_bits() as u32) as i32);
    }
}

impl<T> Kept for PhantomData<T> {
    const LAYOUT: u32 = 0;
    const BLANK: Self = Self;

    fn keep(&mut self, _: &mut Pass<'_>) {}
}

impl Kept for Vector3<f32> {
    const LAYOUT: u32 = named(0, "Vector3");
    const BLANK: Self = Self::new(0.0, 0.0, 0.0);

    fn keep(&mut self, pass: &mut Pass<'_>) {
        self.iter_mut().for_each(|x| x.keep(pass));
    }
}

impl<T: Kept, const N: usize> Kept for [T; N] {
    const LAYOUT: u32 = joined(T::LAYOUT, N as u32);
    const BLANK: Self = [T::BLANK; N];

    fn keep(&mut self, pass: &mut Pass<'_>) {
        self.iter_mut().for_each(|item| item.keep(pass));
    }
}

impl<A: Kept, B: Kept> Kept for (A, B) {
    const LAYOUT: u32 = joined(A::LAYOUT, B::LAYOUT);
    const BLANK: Self = (A::BLANK, B::BLANK);

    fn keep(&mut self, pass: &mut Pass<'_>) {
        self.0.keep(pass);
        self.1.keep(pass);
    }
}

/// The words of a value are present for `None` too.
impl<T: Kept> Kept for Option<T> {
    const LAYOUT: u32 = joined(T::LAYOUT, 1);
    const BLANK: Self = None;

    fn keep(&mut self, pass: &mut Pass<'_>) {
        let (mut is_some, mut value) = (self.is_some(), self.unwrap_or(T::BLANK));
        is_some.keep(pass);
        value.keep(pass);
        *self = is_some.then_some(value);
    }
}
