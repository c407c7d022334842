//! Two programs that publish poses at once.

use chaincell_tests::outsider::{Outsider, Pose, RELEASE_FIRST};
use chaincell_tests::turn;
use rustix::process::Signal;

use super::*;

/// First tick of the second publisher.
const SECOND: u64 = 1_000_000;

// REQ-COS-04, REQ-COS-11
#[test]
fn a_second_publisher_is_not_heard_until_the_first_is_gone_and_then_releases_first() {
    let _turn = turn();
    let place = place("two-publishers");
    let serve = place.serve(&["--json"]);
    let outsider = Outsider::join(&place.scene, true);
    let control = holding_control(&place, 60_000);
    let mut seen = until(&outsider, |force| force.tick >= 300);
    // The second publisher's tool is somewhere else.
    let mut tick = SECOND;
    let mut send_as = |engaged: u32| {
        outsider.send(Pose { tick, position_m: [0.004, 0.0, -0.005], engaged });
        tick += 1;
        std::thread::sleep(Duration::from_millis(1));
        tick
    };
    let mut send = || send_as(1);
    while send() < SECOND + 300 {
        seen.extend(std::iter::from_fn(|| outsider.try_receive()));
    }
    assert!(seen.iter().all(|force| force.tick < SECOND), "the second publisher was answered");
    control.signal(Signal::KILL);
    let mut sent = 0;
    while seen.iter().filter(|force| force.tick >= SECOND && force.flags & STALE == 0).count() < 100
    {
        sent = send();
        seen.extend(std::iter::from_fn(|| outsider.try_receive()));
        assert!(sent < SECOND + 20_000, "the second publisher is never heard");
    }
    let second: Vec<&Force> = seen.iter().filter(|force| force.tick >= SECOND).collect();
    assert!(second.iter().all(|force| force.flags & (RELEASE_FIRST | STALE) != 0), "{second:?}");
    // Released once, it is felt.
    send_as(0);
    let is_felt = |force: &Force| force.flags & (RELEASE_FIRST | STALE) == 0 && force.contacts > 0;
    let mut felt = false;
    while !felt {
        assert!(send_as(1) < SECOND + 40_000, "the second publisher is never felt");
        while let Some(force) = outsider.try_receive() {
            felt |= is_felt(&force);
        }
    }
    assert_gentle(&seen);
    let served = serve.interrupt().with(130).json();
    assert_eq!(count(&served, "publishers"), 2);
    let refused = count(&served, "poses_refused");
    assert!(refused >= 200, "{refused} of the second publisher's {} poses refused", sent - SECOND);
    tell_seen("two publishers at once, one killed", count(&served, "ticks_executed"), 0, &seen);
}
