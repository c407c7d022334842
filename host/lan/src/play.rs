//! Plays a file of poses at 1 kHz, as a device would send them.

use chaincell_client::clock::{MILLISECOND_NS, PERIOD_NS, SECOND_NS, now_ns};
use chaincell_client::{Answer, Result, ToolPose};

use crate::controller::{Came, State};
use crate::hand::{Hand, refusal};
use crate::report::{PlayReport, RoundTrips};

/// Wait for the answers to the last poses, in which the force falls too \[ns\].
const LAST_NS: u64 = 100 * MILLISECOND_NS;
/// Silence of the agent after which the program ends \[ns\].
const GONE_NS: u64 = 2 * SECOND_NS;

/// Plays poses until their end, a refusal, a silence of 2 s, or `stop` returns true. `see` gets each answer with the
/// number of its pose, which counts from 1; pose 1 is the first of the list, not engaged.
///
/// # Errors
/// A pose that is none.
pub fn play(
    hand: &mut Hand,
    poses: &[ToolPose],
    stop: impl Fn() -> bool,
    mut see: impl FnMut(u64, &Answer),
) -> Result<PlayReport> {
    let mut player =
        Player { hand, sent: 0, trips_ns: Vec::with_capacity(poses.len() + 1), largest_n: 0.0 };
    // A tool has no force until a pose has released it once.
    let released = poses.first().map(|first| ToolPose { engaged: 0, ..*first });
    let mut begin_ns = now_ns();
    let mut ended = None;
    for pose in released.iter().chain(poses) {
        player.sent = player.hand.send(&[*pose])?;
        // A period that took longer is not made up for.
        begin_ns = now_ns().max(begin_ns + PERIOD_NS);
        player.hear_until(begin_ns, &mut see);
        ended = match player.hand.state() {
            State::Refused(p999_ns) => Some(refusal(p999_ns).to_string()),
            _ if player.hand.silent_ns() >= GONE_NS => Some(
                "2 s without a word of the agent: does it still run, and the network?".to_owned(),
            ),
            _ if stop() => break,
            _ => continue,
        };
        break;
    }
    player.hear_until(now_ns() + LAST_NS, &mut see);
    let is_failed = ended.is_some();
    let is_stopped = player.sent <= poses.len() as u64;
    let asked = if is_stopped { "stopped" } else { "the end of the path" };
    Ok(PlayReport {
        ended: ended.unwrap_or_else(|| asked.to_owned()),
        is_failed,
        poses: player.sent,
        answered: player.trips_ns.len() as u64,
        round_trips: RoundTrips::of(player.trips_ns),
        silences: player.hand.silences(),
        largest_force_n: player.largest_n,
        dropped: player.hand.dropped(),
    })
}

struct Player<'a> {
    hand: &'a mut Hand,
    sent: u64,
    trips_ns: Vec<u64>,
    largest_n: f32,
}

impl Player<'_> {
    fn hear_until(&mut self, end_ns: u64, see: &mut impl FnMut(u64, &Answer)) {
        while let Some(came) = self.hand.next(end_ns) {
            if let Came::Answer { number, round_trip_ns } = came {
                self.trips_ns.push(round_trip_ns);
                see(number, &self.hand.shown());
            }
            let force_n = self.hand.shown().tools[0].force_n;
            let size_n = force_n.iter().map(|x| x * x).sum::<f32>().sqrt();
            self.largest_n = self.largest_n.max(size_n);
        }
    }
}
