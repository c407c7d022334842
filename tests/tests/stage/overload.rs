//! Sweeps that take longer than a pose period, on a simulated clock.

use chaincell_host::engine::motion::Pose;
use chaincell_host::session::loops::serve::{
    Arrived, Behind, Charge, ServeOptions, Session, Shared, Voice,
};
use chaincell_kernel::stage::StageSettings;
use nalgebra::Vector3;

use crate::served::{MS_NS, Server, World, plane, premium, tissue};

/// Sweeps of a budget that take longer than a pose period, from tick 300 on, in a tool that stands
/// pressed: the milliseconds until the published force is 0.
fn until_zero_ms(sweep_ns: u64, stage: Option<StageSettings>) -> u64 {
    let image = plane();
    let options = ServeOptions { hash_every: 0, ..ServeOptions::default() };
    let mut staged = tissue(&image, stage);
    let shared = Shared::new(Voice::new(&options, 0));
    let session = Session::new(&mut staged, &shared, &options, (Charge::new(), false));
    let mut server = Server::new(session, &shared);
    server.session.take_charge(1);
    let (slow_ns, mut world, mut sent, mut due_ns) = (300 * MS_NS, World::new(), 0, 0);
    let mut under_way: Option<(u64, Arrived)> = None;
    // A tenth of a millisecond a step.
    for step in 0..20_000 {
        let now_ns = step * MS_NS / 10;
        if step % 10 == 0 {
            sent += 1;
            let depth_m = 1.0e-4 * (sent as f32 - 50.0).clamp(0.0, 200.0);
            let pose = Pose {
                tick: sent,
                position_m: [0.0, 0.0, -depth_m],
                engaged: u32::from(sent > 20),
                sweeps: None,
            };
            server.take(pose, now_ns);
        }
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
        let force_n = Vector3::from(world.last.force.force_n).norm();
        assert!(now_ns != slow_ns || force_n > 0.1, "{force_n} N when the sweeps began to be slow");
        if now_ns > slow_ns && force_n == 0.0 {
            return (now_ns - slow_ns) / MS_NS;
        }
    }
    u64::MAX
}

// REQ-COS-09
#[test]
fn a_sweep_above_the_pose_period_takes_the_force_away_within_forty_milliseconds() {
    for stage in [None, Some(premium())] {
        for periods in [1.1, 1.5, 2.0, 3.0, 6.0] {
            let ms = until_zero_ms((periods * MS_NS as f64) as u64, stage);
            println!("OVERLOAD | {periods} | force 0 after {ms} ms |");
            assert!(ms <= 40, "{periods}: {ms} ms");
        }
    }
}
