//! What other programs put into shared memory: poses and commands of any bits, in any order, by
//! the rules of `serve`.

use chaincell_host::engine::{Arithmetic, Engine, Scheme};
use chaincell_host::session::ipc::payload::CommandMessage;
use chaincell_host::session::ipc::tools::{Answer, Asking as _, OneToolPose, ToolPoses};
use chaincell_kernel::trace::Command;
use chaincell_kernel::{Choice, Network, ToolPose};
use chaincell_lab::monitor::Monitor;

use super::{bodies, tick};

/// Of a pose in the short form of these inputs: the tick, the place of tool 0, whether it is engaged.
const POSE_BYTES: usize = 24;
const POSES_BYTES: usize = size_of::<ToolPoses>();
const COMMAND_BYTES: usize = size_of::<CommandMessage>();
/// Of a command in the short form of these inputs, without a place.
const SHORT_COMMAND_BYTES: usize = 16;
/// Most messages of a session, and most sweeps a tick.
const MESSAGES_MAX: usize = 64;
const SWEEPS_MAX: u16 = 16;

/// Two bytes choose body and scheme; then messages, each behind a byte whose lowest bits
/// tell a command of 16 bytes (01) and one of 32 (11) from a pose of 24 (00) and poses of 344 (10).
pub fn payload(data: &[u8]) {
    let Some((&[body, scheme], mut rest)) = data.split_first_chunk() else { return };
    let model = bodies::model(body);
    let schemes = Scheme::ALL;
    let scheme = schemes[usize::from(scheme) % schemes.len()];
    let network = Network::new(model, scheme.settings(&model, 2)).unwrap();
    let cells = bodies::free_cells(&model, body, 2);
    let Ok(mut engine) = Engine::new(network, scheme, &cells) else { return };
    let mut monitor = Monitor::new(&engine, Arithmetic::F32);
    let (mut last, mut paused) = (None, false);
    for _ in 0..MESSAGES_MAX {
        let Some((&kind, behind)) = rest.split_first() else { return };
        if kind & 1 == 1 {
            let bytes = if kind & 2 == 0 { SHORT_COMMAND_BYTES } else { COMMAND_BYTES };
            let Some((message, behind)) = behind.split_at_checked(bytes) else { return };
            rest = behind;
            monitor.interfere();
            match command(message).command() {
                Ok(Command::Pause) => paused = true,
                Ok(Command::Resume) => paused = false,
                Ok(Command::Sweeps(sweeps)) if sweeps > SWEEPS_MAX => {}
                Ok(command) => {
                    let before = engine.state_hash();
                    let refused = engine.obey(&command).is_err();
                    assert!(!refused || engine.state_hash() == before);
                }
                Err(_) => {}
            }
        } else {
            let message = if kind & 2 == 0 {
                let Some((message, behind)) = behind.split_first_chunk() else { return };
                rest = behind;
                pose(message)
            } else {
                let Some((message, behind)) = behind.split_first_chunk() else { return };
                rest = behind;
                poses(message)
            };
            let pose = answered(&message);
            if last.is_none_or(|last| message.tick > last) && !paused {
                tick(&mut monitor, &mut engine, &[pose], None);
            }
            last = last.max(Some(message.tick));
        }
    }
}

fn words<const N: usize>(bytes: &[u8]) -> [u32; N] {
    let mut words = [0; N];
    for (word, bytes) in words.iter_mut().zip(bytes.chunks_exact(4)) {
        *word = bytes.first_chunk().map_or(0, |bytes| u32::from_le_bytes(*bytes));
    }
    words
}

fn pose(bytes: &[u8; POSE_BYTES]) -> ToolPoses {
    let [low, high, x, y, z, engaged] = words(bytes);
    let tick = u64::from(low) | u64::from(high) << 32;
    let place = [x, y, z].map(f32::from_bits);
    ToolPoses::of(tick, 0, &[ToolPose::at(place.into(), engaged)])
}

fn poses(bytes: &[u8; POSES_BYTES]) -> ToolPoses {
    let [low, high, send_low, send_high, tools, reserved] = words(bytes);
    let mut poses = ToolPoses {
        tick: u64::from(low) | u64::from(high) << 32,
        send_ns: u64::from(send_low) | u64::from(send_high) << 32,
        tools,
        reserved,
        ..ToolPoses::default()
    };
    for (tool, bytes) in poses.each.iter_mut().zip(bytes[24..].chunks_exact(40)) {
        let [number, acting, px, py, pz, x, y, z, w, reserved] = words(bytes);
        *tool = OneToolPose {
            number,
            engaged: acting as u16,
            opening_turns_q16: (acting >> 16) as u16,
            position_m: [px, py, pz].map(f32::from_bits),
            orientation: [x, y, z, w].map(f32::from_bits),
            reserved,
        };
    }
    poses
}

/// The pose of tool 0 of a message, whose answer holds whatever it holds.
fn answered(poses: &ToolPoses) -> ToolPose {
    let answer = Answer { asked: poses.asked(0), ..Answer::default() };
    let forces = answer.message(1);
    assert!((1..=8).contains(&forces.tools) && forces.send_ns == poses.send_ns);
    poses.poses(0).each().first().copied().unwrap()
}

/// The words that a short form leaves out are zeros.
fn command(bytes: &[u8]) -> CommandMessage {
    let [kind, parameter, value, reserved, place @ ..] = words::<8>(bytes);
    let [x, y, z, radius_m] = place.map(f32::from_bits);
    let value = f32::from_bits(value);
    CommandMessage { kind, parameter, value, reserved, point_m: [x, y, z], radius_m }
}
