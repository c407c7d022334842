//! Choices among named values: one table each, which defines names and codes for every caller.

/// A choice among named values.
///
/// The command line and JSON go by the name; the C interface, traces and the command service by
/// the code. A name and a code keep their meaning in every release.
///
/// ```
/// use chaincell_kernel::{Choice, Scheme};
///
/// assert_eq!(Scheme::from_name("predict"), Some(Scheme::Predict));
/// assert_eq!((Scheme::Rkl2.name(), Scheme::Rkl2.code()), ("rkl2", 3));
/// ```
pub trait Choice: Copy + Eq + 'static {
    /// Every value, in the order in which help lists them.
    const ALL: &'static [Self];
    /// The lines of the table in the same order: code, name and meaning.
    const TABLE: &'static [(u16, &'static str, &'static str)];

    /// The value's name.
    fn name(self) -> &'static str;

    /// The value's code.
    fn code(self) -> u16;

    /// The value of a name.
    #[must_use]
    fn from_name(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.name() == name)
    }

    /// The value of a code.
    #[must_use]
    fn from_code(code: u16) -> Option<Self> {
        Self::ALL.iter().copied().find(|value| value.code() == code)
    }
}

/// Declares an enum and its [`Choice`] in one table: each line is `Value = code, name;` after its meaning. The
/// first paragraph of the meaning is the help of the command line and the comment of the C header.
///
/// ```
/// use chaincell_kernel::{Choice, choices};
///
/// choices! {
///     /// A side of the body.
///     Side {
///         /// The left one.
///         Left = 0, "left";
///         /// The right one.
///         Right = 1, "right";
///     }
/// }
/// assert_eq!((Side::from_name("right"), Side::Left.code()), (Some(Side::Right), 0));
/// assert_eq!(Side::TABLE[1], (1, "right", " The right one.\n"));
/// ```
#[macro_export]
macro_rules! choices {
    ($(#[$of_enum:meta])* $name:ident {
        $($(#[doc = $meaning:literal])+ $(#[default $($is_default:tt)?])? $value:ident = $code:literal, $text:expr;)*
    }) => {
        $(#[$of_enum])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $($(#[doc = $meaning])+ $(#[default $($is_default)?])? $value = $code),*
        }

        impl $crate::Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$value),*];
            const TABLE: &'static [(u16, &'static str, &'static str)] =
                &[$(($code, $text, concat!($($meaning, "\n"),+))),*];

            fn name(self) -> &'static str {
                match self {
                    $(Self::$value => $text),*
                }
            }

            fn code(self) -> u16 {
                self as u16
            }
        }
    };
}

pub(crate) use choices;
