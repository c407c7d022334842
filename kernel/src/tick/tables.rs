//! Tables of flags and codes. Each defines the constants of its type; C headers, pages and the Python package
//! are written from the same lines, and tests compare them.

/// Declares a set of flags in one table: each line is `NAME = bit;` after its meaning.
///
/// ```
/// chaincell_kernel::flags! {
///     /// Limits that acted.
///     Limits {
///         /// The force was clamped.
///         FORCE = 1;
///         /// The torque was clamped.
///         TORQUE = 2;
///     }
/// }
/// let mut limits = Limits::FORCE;
/// limits.insert(Limits::TORQUE);
/// assert!(limits == Limits(3) && limits.contains(Limits::TORQUE));
/// assert_eq!(Limits::ALL[0], (Limits::FORCE, "FORCE", " The force was clamped.\n"));
/// ```
#[macro_export]
macro_rules! flags {
    ($(#[$of_set:meta])* $set:ident {
        $($(#[doc = $meaning:literal])+ $name:ident = $bit:literal;)*
    }) => {
        $(#[$of_set])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
        #[repr(transparent)]
        pub struct $set(pub u32);

        impl $set {
            $($(#[doc = $meaning])+ pub const $name: Self = Self($bit);)*

            /// Every flag in the order of the bits, with its name and its meaning.
            pub const ALL: &'static [(Self, &'static str, &'static str)] =
                &[$((Self::$name, stringify!($name), concat!($($meaning, "\n"),+))),*];

            /// Sets every bit of `other`.
            pub const fn insert(&mut self, other: Self) {
                self.0 |= other.0;
            }

            /// Returns true if every bit of `other` is set.
            #[must_use]
            pub const fn contains(self, other: Self) -> bool {
                self.0 & other.0 == other.0
            }
        }
    };
}

pub(crate) use flags;

/// Declares an enum of stable numbers in one table: each line is `Value = number, text;` after its meaning.
///
/// ```
/// chaincell_kernel::codes! {
///     /// Why a door stays closed.
///     Closed: i32, str {
///         /// There is no key.
///         NoKey = -1, "no key: look under the mat";
///         /// Somebody else has it open.
///         Open = -2, "it is open already";
///     }
/// }
/// assert_eq!(Closed::text_of(-2), Some(Closed::Open.text()));
/// assert_eq!(Closed::text_of(0), None);
/// assert_eq!(Closed::ALL[0], (Closed::NoKey, "NoKey", " There is no key.\n"));
/// ```
#[macro_export]
macro_rules! codes {
    ($(#[doc = $of_enum:literal])+ $name:ident: $number:ident, $text:ty {
        $($(#[doc = $meaning:literal])+ $value:ident = $code:literal, $words:expr;)*
    }) => {
        $(#[doc = $of_enum])+
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        #[repr($number)]
        pub enum $name {
            $($(#[doc = $meaning])+ $value = $code),*
        }

        impl $name {
            /// The meaning of these numbers.
            pub const MEANING: &'static str = concat!($($of_enum, "\n"),+);

            /// Every value in the order of the table, with its name and its meaning.
            pub const ALL: &'static [(Self, &'static str, &'static str)] =
                &[$((Self::$value, stringify!($value), concat!($($meaning, "\n"),+))),*];

            /// Returns the value in words.
            #[must_use]
            pub const fn text(self) -> &'static $text {
                match self {
                    $(Self::$value => $words),*
                }
            }

            /// Returns the value of a number in words.
            #[must_use]
            pub const fn text_of(number: $number) -> Option<&'static $text> {
                match number {
                    $($code => Some($words),)*
                    _ => None,
                }
            }
        }
    };
}
