//! What is beside the loop: states, contacts, commands.

use chaincell_client::Command;
use chaincell_client::command::refusal_text;
use chaincell_client::payload::CommandMessage;

use crate::code::{Code, keep};
use crate::handles::{guarded, with};
use crate::memory;
use crate::step::Handle;
use crate::types::{Contacts, Reply, State};

/// The body takes its rest shape.
pub const COMMAND_RESET: u32 = 1;
/// Poses are answered with force 0, and no cell moves.
pub const COMMAND_PAUSE: u32 = 2;
/// Ends a pause.
pub const COMMAND_RESUME: u32 = 3;
/// Sets a parameter to the value.
pub const COMMAND_SET: u32 = 4;
/// The tool that is the parameter takes hold of what it is in contact with.
pub const COMMAND_GRIP: u32 = 5;
/// The tool that is the parameter lets go within so many ticks as the value says.
pub const COMMAND_LET_GO: u32 = 6;
/// The session is saved beside its trace.
pub const COMMAND_SNAPSHOT: u32 = 7;
/// What the tool that is the parameter grips, or touches, is held to the world where it is, by springs of the stiffness
/// that is the value \[N/m\]; infinity for a rigid pin. It takes the lowest free number, from 0. At a place
/// `chaincell_client_pin_at` sets one.
pub const COMMAND_PIN: u32 = 8;
/// The pin that is the parameter is released within so many ticks as the value says.
pub const COMMAND_UNPIN: u32 = 9;
/// Sweeps a tick, 1 to 1,000.
pub const PARAMETER_SWEEPS: u32 = 1;
/// Largest force \[N\]; infinity for no limit.
pub const PARAMETER_MAX_FORCE: u32 = 2;
/// Largest move of a tool a tick \[m\].
pub const PARAMETER_MAX_TOOL_STEP: u32 = 3;
/// Unloading: 0 off, 1 release, 2 retreat.
pub const PARAMETER_UNLOADING: u32 = 4;
/// Blades and tears: 0 on, 1 off.
pub const PARAMETER_CUT: u32 = 7;

/// Takes the newest state that was not taken yet, where it lies in shared memory, until
/// `chaincell_client_release`: 3 where none has come; where one is held already it is given once more
/// with -42. The first call joins the readers, allocates
/// and mostly gives 3. Not for the loop of a device: use a viewer's handle in another thread.
///
/// # Safety
/// `state` is null or, where aligned, storage for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_state(client: Handle, state: *mut State) -> Code {
    // SAFETY: the caller's promise is handed on.
    guarded(|| unsafe {
        memory::write(state, State::NONE)?;
        with(client, |open| {
            if let Some(held) = &open.state {
                memory::write(state, State::of(held.header(), held.rows()))?;
                return Err(Code::Held);
            }
            let Some(view) = open.client.state()? else { return Ok(Code::NothingNew) };
            memory::write(state, State::of(view.header(), view.rows()))?;
            open.state = Some(view);
            Ok(Code::Ok)
        })
    })
}

/// Takes the newest contacts that were not taken yet, as `chaincell_client_state` does; until
/// `chaincell_client_release`. A server without tools on a contact surface sends none.
///
/// # Safety
/// `contacts` is null or, where aligned, storage for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_contacts(
    client: Handle,
    contacts: *mut Contacts,
) -> Code {
    // SAFETY: the caller's promise is handed on.
    guarded(|| unsafe {
        memory::write(contacts, Contacts::NONE)?;
        with(client, |open| {
            if let Some(held) = &open.contacts {
                memory::write(contacts, Contacts::of(held.header(), held.rows()))?;
                return Err(Code::Held);
            }
            let Some(view) = open.client.contacts()? else { return Ok(Code::NothingNew) };
            memory::write(contacts, Contacts::of(view.header(), view.rows()))?;
            open.contacts = Some(view);
            Ok(Code::Ok)
        })
    })
}

/// Gives back the state and the contacts that are held: they must not be read any more.
#[unsafe(no_mangle)]
pub extern "C" fn chaincell_client_release(client: Handle) -> Code {
    guarded(|| {
        with(client, |open| {
            let (state, contacts) = (open.state.take(), open.contacts.take());
            if state.is_none() && contacts.is_none() { Err(Code::NotHeld) } else { Ok(Code::Ok) }
        })
    })
}

/// Sends a command and waits for its reply at most `wait_ns`: `kind` is one of CHAINCELL_CLIENT_COMMAND_,
/// `parameter` one of CHAINCELL_CLIENT_PARAMETER_, the tool or the pin, both and `value` 0 where the kind has none.
/// `reply` may be null. Not for the loop of a device.
///
/// # Safety
/// `reply` is null or, where aligned, storage for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_command(
    client: Handle,
    kind: u32,
    parameter: u32,
    value: f32,
    wait_ns: u64,
    reply: *mut Reply,
) -> Code {
    // SAFETY: the caller's promise is handed on.
    guarded(|| unsafe {
        let message = CommandMessage { kind, parameter, value, ..CommandMessage::default() };
        memory::write_if_asked(reply, Reply::default())?;
        ask(client, message, wait_ns, reply)
    })
}

/// Pins the surface within `radius_m` of a point, 3 numbers in the frame of the input mesh \[m\], where it is now:
/// it is held to the world by springs of `stiffness_n_per_m` in all, infinity for a rigid pin. Waits for the reply at
/// most `wait_ns`; `reply` may be null, its `reason` is the pin's number, the lowest free one. The command
/// CHAINCELL_CLIENT_COMMAND_UNPIN releases the pin. Not for the loop of a device.
///
/// # Safety
/// `point_m` is null or, where aligned, three numbers; `reply` is null or, where aligned, storage for one.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn chaincell_client_pin_at(
    client: Handle,
    point_m: *const f32,
    radius_m: f32,
    stiffness_n_per_m: f32,
    wait_ns: u64,
    reply: *mut Reply,
) -> Code {
    // SAFETY: the caller's promises are handed on.
    guarded(|| unsafe {
        memory::write_if_asked(reply, Reply::default())?;
        let point_m = memory::read(point_m.cast::<[f32; 3]>())?;
        let pin = Command::PinAt { point_m, radius_m, stiffness_n_per_m };
        ask(client, CommandMessage::new(&pin), wait_ns, reply)
    })
}

/// Sends a command, waits for its reply and gives it.
///
/// # Safety
/// `reply` is null or, where aligned, storage for one.
unsafe fn ask(
    client: Handle,
    message: CommandMessage,
    wait_ns: u64,
    reply: *mut Reply,
) -> Result<Code, Code> {
    with(client, |open| {
        let found = open.client.ask(message, wait_ns)?;
        // SAFETY: the caller's promise is handed on.
        unsafe { memory::write_if_asked(reply, found.into()) }?;
        if found.result != 0 {
            keep(refusal_text(found.reason));
            return Err(Code::Refused);
        }
        Ok(Code::Ok)
    })
}
