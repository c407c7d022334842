//! Errors as exceptions: the classes stand in `chaincell/errors.py`.

use chaincell_client::Kind;
use chaincell_host::error::Error;
use pyo3::exceptions::PyKeyboardInterrupt;
use pyo3::prelude::*;

/// Defines `Class` and, of each of its members, the exception in Python that it stands for.
macro_rules! classes {
    ($($class:ident = $exception:ident),* $(,)?) => {
        mod exceptions {
            $(pyo3::import_exception!(chaincell.errors, $exception);)*
        }

        /// An exception of the package.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum Class {
            $($class,)*
        }

        impl Class {
            /// The exception with this text. It is made in Python when it is raised there, so that a
            /// thread that has outlived its interpreter asks for nothing.
            pub(crate) fn error(self, text: impl ToString) -> PyErr {
                let text = text.to_string();
                match self {
                    $(Self::$class => exceptions::$exception::new_err(text),)*
                }
            }
        }
    };
}

classes! {
    Base = Error,
    Argument = ArgumentError,
    Model = ModelError,
    Snapshot = SnapshotError,
    Pose = PoseError,
    Refused = Refused,
    Session = SessionError,
    NoServer = NoServer,
    OtherVersion = OtherVersion,
    Taken = Taken,
    Full = Full,
    NoPermission = NoPermission,
    NoReply = NoReply,
    Closed = Closed,
}

impl Class {
    /// The exception for bad input that the host has refused.
    pub(crate) fn host(self, why: Error) -> PyErr {
        match why {
            Error::Interrupted | Error::InterruptedWith(_) => PyKeyboardInterrupt::new_err(()),
            Error::Input(text) => self.error(in_python(&text)),
            other => Self::Base.error(in_python(&other.to_string())),
        }
    }
}

/// The exception for what the client has refused.
pub(crate) fn client(why: chaincell_client::Error) -> PyErr {
    let class = match why.kind() {
        Kind::Stopped => return PyKeyboardInterrupt::new_err(()),
        Kind::Argument => Class::Argument,
        Kind::NoServer => Class::NoServer,
        Kind::Version => Class::OtherVersion,
        Kind::Taken => Class::Taken,
        Kind::Full => Class::Full,
        Kind::Permission => Class::NoPermission,
        Kind::Pose => Class::Pose,
        Kind::NoReply => Class::NoReply,
        Kind::Refused => Class::Refused,
        Kind::Memory | Kind::Service | Kind::Connection | Kind::Viewer => Class::Session,
    };
    class.error(in_python(&why.to_string()))
}

/// Arguments that have another name here than the library's field or the command's option.
const RENAMED: [(&str, &str); 7] = [
    ("`saturation_m`", "`k_m`"),
    ("`resistance`", "`r_x`"),
    ("`coarse_basis`", "`coarse`"),
    ("`fix`", "`fixed`"),
    ("`material`", "`materials`"),
    ("`tool`", "`tools`"),
    ("`branch`", "`branches`"),
];

/// A text of the command line with its options named as arguments: `--young-pa` is `young_pa`, and
/// `'--sweeps <N>'` is `sweeps`.
fn in_python(text: &str) -> String {
    let mut named = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("--") {
        let (before, option) = rest.split_at(at);
        let option = &option[2..];
        let is_part = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
        let end = option.find(|c| !is_part(c)).unwrap_or(option.len());
        if !option.starts_with(|c: char| c.is_ascii_lowercase()) {
            named.push_str(before);
            named.push_str("--");
            rest = option;
            continue;
        }
        rest = &option[end..];
        let quoted = before.strip_suffix('\'').filter(|_| rest.find('\'').is_some());
        if quoted.is_some() {
            rest = rest.split_once('\'').map_or(rest, |(_, behind)| behind);
        }
        named.push_str(quoted.unwrap_or(before));
        named.push('`');
        named.push_str(&option[..end].replace('-', "_"));
        named.push('`');
    }
    named.push_str(rest);
    RENAMED.iter().fold(named, |text, (field, argument)| text.replace(field, argument))
}
