//! What the client allocates in the loop of a device: what iceoryx2 takes for a message sent.

use chaincell_client::{Client, Options, Outcome, ToolPose};
use chaincell_tests::allocations::so_far;
use chaincell_tests::place::Place;
use chaincell_tests::turn;

use super::{BYTES_PER_SEND, COUNTED_TICKS, WARM_UP_TICKS};

/// Longest wait for an answer \[ns\].
const WAIT_NS: u64 = 20_000_000_000;

/// Pieces and bytes that this thread asked for meanwhile.
fn counted(work: impl FnOnce()) -> (u64, u64) {
    let before = so_far();
    work();
    let now = so_far();
    (now.0 - before.0, now.1 - before.1)
}

#[test]
fn a_step_allocates_for_its_message_and_nothing_else() {
    let _turn = turn();
    let place = Place::new("client-allocates");
    let serve = place.serve(&[]);
    let scene = Some(place.scene.clone());
    let mut client = Client::open(&Options { scene, ..Options::default() }).unwrap();
    let mut steps = |count: u64| {
        for tick in 0..count {
            let pose = ToolPose::at([0.0, 0.0, -1e-5 * tick as f32].into(), u32::from(tick > 0));
            assert_eq!(client.step(&[pose], WAIT_NS).unwrap().0, Outcome::Answered);
        }
    };
    steps(WARM_UP_TICKS);
    let (pieces, bytes) = counted(|| steps(COUNTED_TICKS));
    assert_eq!((pieces, bytes), (COUNTED_TICKS, COUNTED_TICKS * BYTES_PER_SEND));
    let looked = counted(|| {
        for _ in 0..COUNTED_TICKS {
            client.try_receive().unwrap();
            client.shown().unwrap();
        }
    });
    assert_eq!(looked, (0, 0));
    drop(client);
    serve.interrupt().with(130);
}
