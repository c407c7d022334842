//! Choices on the command line: one parser for all, and what help says of each value.

use chaincell_kernel::stage::Device;
use chaincell_kernel::{Arithmetic, Choice, Drive, Scheme, Unloading};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

use crate::session::loops::wait::Wait;

/// A choice that help explains.
pub trait Help: Choice + Send + Sync {
    /// What `--help` says of the value.
    fn help(self) -> &'static str;
}

/// Takes the names of a choice, and lists them with their help.
pub fn parser<T: Help>() -> impl TypedValueParser<Value = T> {
    let value = |value: &T| PossibleValue::new(value.name()).help(value.help());
    PossibleValuesParser::new(T::ALL.iter().map(value))
        .try_map(|name| T::from_name(&name).ok_or("no such value"))
}

impl Help for Scheme {
    fn help(self) -> &'static str {
        match self {
            Self::Euler => {
                "The paper's own: one explicit step of common size a sweep; time is physical"
            }
            Self::Track => {
                "Conjugate directions under the energy guard, with a coarse level: follows the \
                 equilibrium"
            }
            Self::Predict => {
                "Track that knows how the body answers a move of the held cells: the force keeps up \
                 in one or two sweeps a tick; 112 bytes a cell"
            }
            Self::Rkl2 => {
                "Runge-Kutta-Legendre of second order: the trajectory in time beyond Euler's bound"
            }
        }
    }
}

impl Help for Arithmetic {
    fn help(self) -> &'static str {
        match self {
            Self::F32 => {
                "Single precision, correctly rounded: every target with an FPU, all schemes"
            }
            Self::Fixed => {
                "Fixed point, 8.24 bits: targets without an FPU; euler and track without the coarse level"
            }
        }
    }
}

impl Help for Unloading {
    fn help(self) -> &'static str {
        match self {
            Self::Off => "Never",
            Self::Release => "From release until the tool takes hold again",
            Self::Retreat => "Also while the tool has come back from its deepest point",
        }
    }
}

impl Help for Drive {
    fn help(self) -> &'static str {
        match self {
            Self::Position => "The cells are held where the tool has them",
            Self::Current => "The cells are free and loaded; a body that nothing fixes drifts",
        }
    }
}

impl Help for Device {
    fn help(self) -> &'static str {
        match self {
            Self::Touch => "3D Systems Touch: 3.3 N, 400 N/m",
            Self::Premium => "3D Systems Phantom Premium 3.0: 22 N, 1000 N/m",
            Self::Falcon => "Novint Falcon: 8 N, 3000 N/m",
            Self::Omega => "Force Dimension omega: 12 N, 5000 N/m",
            Self::Sigma => "Force Dimension sigma.7: 12 N, 4000 N/m",
        }
    }
}

impl Help for Wait {
    fn help(self) -> &'static str {
        match self {
            Self::Hybrid => {
                "Sleep until shortly before the message is expected, poll for at most 200 us, then \
                 short sleeps"
            }
            Self::Spin => {
                "Poll all the time: the shortest answers, but only with a free core for each side"
            }
            Self::Event => {
                "Sleep until the sender wakes this process: no polling, the longest answers"
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn is_complete<T: Help + std::fmt::Debug>() {
        let command = || {
            clap::Command::new("chaincell").arg(clap::Arg::new("of").value_parser(parser::<T>()))
        };
        for &value in T::ALL {
            let found = command().try_get_matches_from(["chaincell", value.name()]).unwrap();
            assert_eq!(found.get_one("of"), Some(&value));
            assert_eq!(T::from_code(value.code()), Some(value));
        }
        let refused = command().try_get_matches_from(["chaincell", "neither"]).unwrap_err();
        let help =
            command().render_long_help().to_string().replace(|c: char| c.is_whitespace(), "");
        for value in T::ALL {
            assert!(refused.to_string().contains(value.name()), "{refused}");
            let text = value.help().replace(|c: char| c.is_whitespace(), "");
            assert!(help.contains(&format!("{}:{text}", value.name())), "{help}");
        }
    }

    #[test]
    fn every_value_is_taken_named_where_another_is_given_and_explained_by_help() {
        is_complete::<Scheme>();
        is_complete::<Arithmetic>();
        is_complete::<Unloading>();
        is_complete::<Drive>();
        is_complete::<Device>();
        is_complete::<Wait>();
    }
}
