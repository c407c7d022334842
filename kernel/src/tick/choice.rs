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

/// Declares an enum and its [`Choice`] in one table: each line is `Value = code, name;`.
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
/// ```
#[macro_export]
macro_rules! choices {
    ($(#[$of_enum:meta])* $name:ident {
        $($(#[$of_value:meta])* $value:ident = $code:literal, $text:expr;)*
    }) => {
        $(#[$of_enum])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum $name {
            $($(#[$of_value])* $value = $code),*
        }

        impl $crate::Choice for $name {
            const ALL: &'static [Self] = &[$(Self::$value),*];

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
