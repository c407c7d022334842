//! Sweeps that take longer than a pose period, on a simulated clock: when the force is gone, and what a
//! modelled hand that presses by 20 mm and comes back gets out of nothing.

use chaincell_host::engine::motion::Pose;
use chaincell_host::session::loops::serve::{
    Arrived, Behind, Charge, ServeOptions, Session, Shared, Voice,
};
use chaincell_kernel::stage::StageSettings;
use nalgebra::Vector3;

use crate::served::{MS_NS, Server, World, plane, premium, smooth, tissue};

/// Ticks of a press, a hold and the way back.
const TICKS: u64 = 5000;
/// From this tick on the sweeps are slow.
const SLOW: u64 = 1600;
/// Most energy out of nothing \[J\].
const MADE_MAX_J: f64 = 1.0e-3;

/// Where the hand wants to be, below the start \[m\].
fn depth_m(tick: u64) -> f64 {
    let at = tick as f64 / TICKS as f64;
    0.02 * (smooth((at - 0.1) / 0.15) - smooth((at - 0.7) / 0.15))
}

/// A press against sweeps that are slow from a tick on: the milliseconds from then until the published
/// force is 0, and what came to the hand.
fn press(sweep_ns: u64, stage: Option<StageSettings>, stiffness_n_per_m: f64) -> (u64, World) {
    let image = plane();
    let options = ServeOptions { hash_every: 0, ..ServeOptions::default() };
    let mut staged = tissue(&image, stage);
    let shared = Shared::new(Voice::new(&options, 0));
    let session = Session::new(&mut staged, &shared, &options, (Charge::new(), false));
    let mut server = Server::new(session, &shared);
    server.session.take_charge(1);
    let (slow_ns, mut world, mut sent, mut due_ns) = (SLOW * MS_NS, World::new(), 0, 0);
    let mut zero_ms = u64::MAX;
    let mut under_way: Option<(u64, Arrived)> = None;
    // A tenth of a millisecond a step.
    for step in 0..10 * TICKS {
        let now_ns = step * MS_NS / 10;
        // Publish the hand's pose.
        if step % 10 == 0 {
            sent += 1;
            world.go(depth_m(sent), stiffness_n_per_m);
            server.take(Pose::of(sent, &world.moving.sample(sent > 100)), now_ns);
        }
        // Serve: one tick at a time, while older poses are late.
        let takes_ns = if now_ns < slow_ns { MS_NS / 10 } else { sweep_ns };
        match under_way {
            Some((begun_ns, arrived)) if now_ns >= begun_ns + takes_ns => {
                let behind = if takes_ns > MS_NS { Behind::Yes } else { Behind::No };
                server.tick_ns = takes_ns;
                let newer = std::mem::take(&mut server.inbox);
                under_way = None;
                server.inbox.push_back(arrived);
                server.execute(now_ns, behind, &mut world);
                server.inbox = newer;
            }
            // The watcher speaks while a tick is under way.
            Some(_) if now_ns >= due_ns => {
                let said = shared.voice().falling_in_tick(now_ns);
                said.into_iter().for_each(|answer| world.hear(answer));
                due_ns = now_ns + MS_NS;
            }
            Some(_) => {}
            None => {
                let newest = server.inbox.pop_back();
                server.tick_ns = 0;
                server.execute_late(now_ns, &mut world);
                under_way = newest.map(|arrived| (now_ns, arrived));
            }
        }
        // Note when the force is gone.
        let force_n = Vector3::from(world.last.force.force_n).norm();
        assert!(now_ns != slow_ns || force_n > 0.1, "{force_n} N when the sweeps began to be slow");
        if now_ns > slow_ns && force_n == 0.0 {
            zero_ms = zero_ms.min((now_ns - slow_ns) / MS_NS);
        }
    }
    (zero_ms, world)
}

// REQ-COS-09, REQ-COS-10
#[test]
fn a_slow_sweep_takes_the_force_away_within_forty_milliseconds_and_gives_a_hand_nothing() {
    for stage in [None, Some(premium())] {
        for (periods, hand) in [
            (0.3, 100.0),
            (0.8, 1000.0),
            (1.1, 300.0),
            (1.5, 50.0),
            (1.5, 1000.0),
            (2.0, 100.0),
            (3.0, 100.0),
            (3.0, 1000.0),
            (6.0, 300.0),
        ] {
            let (ms, world) = press((periods * MS_NS as f64) as u64, stage, hand);
            let (made_j, most_n) = (world.made_j, world.most_n);
            println!(
                "OVERLOAD | {periods} | {hand} N/m | 0 after {ms} ms | {made_j:.1e} J, {most_n} N"
            );
            assert!(periods < 1.0 || ms <= 40, "{periods}: {ms} ms");
            assert!(stage.is_none() || made_j <= MADE_MAX_J, "{periods}: {made_j} J");
        }
    }
}
