//! Result codes: what a call came to, stable numbers for C.

use std::cell::{Cell, RefCell};
use std::ffi::{CStr, c_char};

use chaincell_client::{Error, Kind};

chaincell_kernel::codes! {
    /// What a call came to: 0 when all is well, above 0 when there is nothing new, negative when it was
    /// refused.
    ///
    /// A number never changes its meaning; `chaincell_client_error_text` says it in words.
    Code: i32, CStr {
        /// Done; of a step: the answer to these poses has come.
        Ok = 0, c"done";
        /// No answer has come, and the watchdog has not bitten: the last force counts.
        NoAnswer = 1, c"no answer in time: the last force counts";
        /// No answer has come for the time of the watchdog: the force falls to 0 along its ramp, or is 0.
        Silent = 2, c"no answer for the time of the watchdog: the force falls to 0, or is 0";
        /// Nothing has come that was not taken yet.
        NothingNew = 3, c"nothing has come that was not taken yet";
        /// A pointer is null.
        Null = -1, c"a pointer is null";
        /// A pointer does not have the alignment of what it points to.
        Misaligned = -2, c"a pointer has not the alignment of what it points to";
        /// Header and library are of different versions.
        Version = -3, c"header and library are of different versions: build with the header beside the library";
        /// No client has this handle: it was closed, or never opened.
        Closed = -4, c"no client has this handle: it was closed, or never opened";
        /// Another thread is in a call with this handle.
        Busy = -5, c"another thread is in a call with this handle: open one for each thread";
        /// The process has as many clients as it can.
        TooMany = -6, c"this process has 64 clients open: close one";
        /// The library has a fault; its handle cannot be used any more, close it.
        Fault = -7, c"the library has a fault: close the handle, and report it";
        /// A scene name or an option that cannot be.
        Argument = -8, c"a scene name or an option cannot be";
        /// No server on the scene.
        NoServer = -20, c"no server on the scene: start chaincell serve with this scene";
        /// The scene speaks messages of another version or make.
        Messages = -21, c"the scene speaks messages of another version: take server and client of one release";
        /// Another controller has joined the scene.
        Taken = -22, c"another controller has joined the scene: end it, or take another scene";
        /// As many programs as can be have joined already.
        Full = -23, c"as many programs as can be have joined the scene: end one";
        /// The files of shared memory belong to somebody else, or may be written by others.
        Permission = -24, c"the files of shared memory are not this user's alone: run as their owner";
        /// Shared memory is full.
        Memory = -25, c"shared memory is full: free some of /dev/shm";
        /// A service of the scene has other limits, or cannot be used.
        Service = -26, c"a service of the scene has other limits: end the programs that use it";
        /// Shared memory failed under way.
        Connection = -27, c"shared memory failed: start the server again";
        /// A pose that is no pose, or none, or too many: nothing was sent.
        Pose = -40, c"a pose that is no pose, or none, or more than 8: nothing was sent";
        /// The handle is that of a viewer, which has no tools.
        Viewer = -41, c"a viewer has no tools: open the scene as its controller";
        /// What was taken last was not released yet.
        Held = -42, c"what was taken last is still held: release it first";
        /// There is nothing to release.
        NotHeld = -43, c"there is nothing to release";
        /// No reply to the command in its time: whether it was carried out is not known.
        NoReply = -44, c"no reply in time: whether the command was carried out is not known";
        /// The server refused the command: nothing has changed.
        Refused = -45, c"the server refused the command: nothing has changed";
    }
}

impl Code {
    fn of(kind: Kind) -> Self {
        match kind {
            Kind::Argument => Self::Argument,
            Kind::NoServer => Self::NoServer,
            Kind::Version => Self::Messages,
            Kind::Taken => Self::Taken,
            Kind::Full => Self::Full,
            Kind::Permission => Self::Permission,
            Kind::Memory => Self::Memory,
            Kind::Service => Self::Service,
            Kind::Connection | Kind::Stopped => Self::Connection,
            Kind::Pose => Self::Pose,
            Kind::NoReply => Self::NoReply,
            Kind::Refused => Self::Refused,
            Kind::Viewer => Self::Viewer,
        }
    }
}

/// Longest text of a refusal, with the 0 at its end.
const TEXT_BYTES: usize = 512;

thread_local! {
    static LAST: RefCell<[u8; TEXT_BYTES]> = const { RefCell::new([0; TEXT_BYTES]) };
    /// The code that the text belongs to, 0 where there is none.
    static LAST_CODE: Cell<i32> = const { Cell::new(0) };
    /// Whether the call that is under way has kept why.
    static IS_KEPT: Cell<bool> = const { Cell::new(false) };
}

/// A call begins: nothing was refused in it.
pub(crate) fn begin() {
    let _ = IS_KEPT.try_with(|is_kept| is_kept.set(false));
}

/// A call was refused: where it has kept no reason, the code in words is it.
pub(crate) fn refused(code: Code) {
    if !IS_KEPT.try_with(Cell::get).unwrap_or(true) {
        keep(&code.text().to_string_lossy());
    }
    let _ = LAST_CODE.try_with(|last| last.set(code as i32));
}

/// Keeps why a call was refused, for this thread.
pub(crate) fn keep(text: &str) {
    // A thread that ends has nobody who could ask.
    let _ = LAST.try_with(|last| {
        let end = text.floor_char_boundary(TEXT_BYTES - 1);
        if let Ok(mut last) = last.try_borrow_mut() {
            last.fill(0);
            last.iter_mut().zip(text.bytes().take(end)).for_each(|(place, byte)| *place = byte);
        }
    });
    let _ = IS_KEPT.try_with(|is_kept| is_kept.set(true));
}

/// Why the last call was refused, if it was with this code.
pub(crate) fn kept(code: i32) -> Option<*const c_char> {
    let is_last = LAST_CODE.try_with(|last| last.get() == code && code < 0).unwrap_or(false);
    let text = LAST.try_with(|last| last.as_ptr().cast_const().cast()).ok();
    text.filter(|_| is_last)
}

impl From<Error> for Code {
    /// Keeps the text.
    fn from(why: Error) -> Self {
        keep(&why.to_string());
        Self::of(why.kind())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_a_number_and_a_text_of_its_own() {
        for (at, (one, ..)) in Code::ALL.iter().enumerate() {
            for (other, ..) in &Code::ALL[at + 1..] {
                assert_ne!(*one as i32, *other as i32);
                assert_ne!(one.text(), other.text());
            }
        }
    }

    #[test]
    fn a_text_is_kept_whole_or_cut_between_letters() {
        // SAFETY: the text ends with a 0 and is this thread's own.
        let now = || unsafe { CStr::from_ptr(kept(-40).unwrap()) }.to_str().unwrap().to_owned();
        assert_eq!(kept(-40), None);
        let told = |text: &str| {
            keep(text);
            refused(Code::Pose);
        };
        told("käfer");
        assert_eq!(now(), "käfer");
        assert_eq!((kept(-41), kept(0)), (None, None));
        told(&"ä".repeat(400));
        assert_eq!(now(), "ä".repeat(255));
        told("");
        assert_eq!(now(), "");
    }
}
