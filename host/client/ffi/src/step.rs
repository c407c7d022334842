//! Opening, poses and forces.

use std::ffi::c_char;

use chaincell_client::names::SCENE_BYTES_MAX;
use chaincell_client::{Answer, Client, Outcome, ToolPose};

use crate::VERSION;
use crate::code::{Code, keep};
use crate::handles::{self, Open, guarded, with};
use crate::memory;
use crate::types::{Options, Shown, TOOLS_MAX};

/// An open scene; 0 is none. A number that was closed is never given again.
pub type Handle = u64;

/// Opens a scene by its name, null for the unnamed one; without `options` by default. `version` is
/// CHAINCELL_CLIENT_VERSION. Waits for a server as the options say, allocates and maps memory: not for
/// the loop of a device. At most 64 clients a process.
///
/// # Safety
/// `scene` is null or a text that ends with a 0; `options` is null or, where aligned, options; `client`
/// is null or, where aligned, storage for a handle.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_open(
    version: u32,
    scene: *const c_char,
    options: *const Options,
    client: *mut Handle,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    guarded(|| unsafe {
        memory::write(client, 0)?;
        if version != VERSION {
            keep(&format!("header {version:#x}, library {VERSION:#x}: take both of one release"));
            return Err(Code::Version);
        }
        let options = match options.is_null() {
            true => chaincell_client::Options::default().into(),
            false => memory::read(options)?,
        };
        let options = options.with_scene(name(scene)?)?;
        let handle = handles::insert(Client::open(&options)?)?;
        memory::write(client, handle)?;
        Ok(Code::Ok)
    })
}

/// The scene's name, `None` for the unnamed one.
///
/// # Safety
/// `scene` is null or a text that ends with a 0.
unsafe fn name(scene: *const c_char) -> Result<Option<String>, Code> {
    if scene.is_null() {
        return Ok(None);
    }
    // SAFETY: the caller's promise is handed on; one byte more tells a name that is too long.
    let bytes = unsafe { memory::text(scene.cast(), SCENE_BYTES_MAX + 1) };
    String::from_utf8(bytes).map(Some).map_err(|_| {
        keep("the scene's name is no UTF-8 text: give 1 to 64 letters, digits, '-', '_' or '.'");
        Code::Argument
    })
}

/// Leaves the scene: the server lets its force fall. What is held of states and contacts is gone with it.
/// A call of another thread that is under way keeps it to its end.
#[unsafe(no_mangle)]
pub extern "C" fn chaincell_client_close(client: Handle) -> Code {
    guarded(|| handles::remove(client))
}

/// Sends the poses of `count` tools, 1 to 8, tool 0 first, waits for the answer at most `wait_ns`, and
/// gives what to show. Tools beyond `count` are not engaged. Where the poses are refused `shown` is
/// what to show now; where the handle is, it is all 0.
///
/// One allocation of 104 bytes; it sleeps or polls as the options say.
///
/// # Safety
/// `poses` is null or, where aligned, `count` poses; `shown` is null or, where aligned, storage for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_step(
    client: Handle,
    poses: *const ToolPose,
    count: usize,
    wait_ns: u64,
    shown: *mut Shown,
) -> Code {
    let step = |open: &mut Open| {
        // SAFETY: the caller's promise is handed on.
        let (poses, count) = unsafe { read_poses(poses, count) }?;
        Ok(open.client.step(poses.get(..count).unwrap_or(&[]), wait_ns)?)
    };
    // SAFETY: the caller's promise is handed on.
    unsafe { show(client, shown, step) }
}

/// Sends the poses of tools and waits for nothing. `tick`, which may be null, gets the number of the tick.
/// One allocation of 104 bytes.
///
/// # Safety
/// `poses` is null or, where aligned, `count` poses; `tick` is null or, where aligned, storage for a
/// number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_send(
    client: Handle,
    poses: *const ToolPose,
    count: usize,
    tick: *mut u64,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    guarded(|| unsafe {
        memory::write_if_asked(tick, 0)?;
        let mut sent = 0;
        let code = with(client, |open| {
            let (poses, count) = read_poses(poses, count)?;
            sent = open.client.send(poses.get(..count).unwrap_or(&[]))?;
            Ok(Code::Ok)
        })?;
        memory::write_if_asked(tick, sent)?;
        Ok(code)
    })
}

/// Takes all answers that have come, and gives what to show now: 0 where one came, else 1 or 2. Waits for
/// nothing and allocates nothing.
///
/// # Safety
/// `shown` is null or, where aligned, storage for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_try_receive(client: Handle, shown: *mut Shown) -> Code {
    // SAFETY: the caller's promise is handed on.
    unsafe { show(client, shown, |open| Ok(open.client.try_receive()?)) }
}

/// Does something that gives an answer and writes it. What is refused leaves what to show now, or nothing
/// to feel where there is no client.
///
/// # Safety
/// `shown` is null or, where aligned, storage for one.
unsafe fn show(
    client: Handle,
    shown: *mut Shown,
    work: impl FnOnce(&mut Open) -> Result<(Outcome, Answer), Code>,
) -> Code {
    // SAFETY: the caller's promise is handed on, and here at the second time too.
    guarded(|| unsafe {
        memory::write(shown, Shown::default())?;
        with(client, |open| {
            let (code, answer) = match work(open) {
                Ok((outcome, answer)) => (Ok(code_of(outcome)), answer),
                Err(code) => (Err(code), open.client.shown().unwrap_or_default()),
            };
            memory::write(shown, answer.into())?;
            code
        })
    })
}

fn code_of(outcome: Outcome) -> Code {
    match outcome {
        Outcome::Answered => Code::Ok,
        Outcome::NoAnswer => Code::NoAnswer,
        Outcome::Silent => Code::Silent,
    }
}

/// The poses, and how many they are: none where there are none or too many, which the client refuses.
///
/// # Safety
/// `poses` is null or, where aligned, `count` poses.
pub(crate) unsafe fn read_poses(
    poses: *const ToolPose,
    count: usize,
) -> Result<([ToolPose; TOOLS_MAX], usize), Code> {
    let mut read = [ToolPose::AWAY; TOOLS_MAX];
    if !(1..=TOOLS_MAX).contains(&count) {
        keep(&format!("poses of {count} tools: give those of 1 to {TOOLS_MAX}"));
        return Err(Code::Pose);
    }
    memory::check(poses)?;
    for (number, place) in read.iter_mut().enumerate().take(count) {
        // SAFETY: not null and aligned, and the caller says that there are `count` of them.
        *place = unsafe { poses.add(number).read() };
    }
    Ok((read, count))
}
