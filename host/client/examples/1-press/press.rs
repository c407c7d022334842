//! Example 1: presses a served tissue for half a second, holds it as long, and lets go.
//!
//! `chaincell serve plane.chaincell --contact 40 --scene left` runs meanwhile; then
//! `cargo run --release -p chaincell-client --example press left`.

use chaincell_client::clock::{now_ns, sleep_until_ns};
use chaincell_client::{Client, Options, Result, ToolPose};

/// A second: a device's loop waits for less than a millisecond.
const WAIT_NS: u64 = 1_000_000_000;

fn main() -> Result<()> {
    let scene = std::env::args().nth(1);
    // The tissue's own forces, however late they are. For a device leave both at 20 ms.
    let options = Options { scene, watchdog_ms: 0, ramp_ms: 0, ..Options::default() };
    let mut client = Client::open(&options)?;
    let mut largest_n = 0.0_f64;
    let mut answers = 0;
    let start_ns = now_ns();
    for tick in 0..1500 {
        sleep_until_ns(start_ns + 1_000_000 * tick);
        let depth_m = 0.02 * (tick as f64 / 500.0).min(1.0);
        // A tool has no force until a pose has released it once.
        let engaged = tick > 0 && tick <= 1000;
        let pose = ToolPose::at([0.0, 0.0, -depth_m as f32].into(), u32::from(engaged));
        let (_, answer) = client.step(&[pose], WAIT_NS)?;
        let [x, y, z] = answer.tools[0].force_n.map(f64::from); // what a device shows now
        largest_n = largest_n.max((x * x + y * y + z * z).sqrt());
        answers = answer.answers;
        if tick == 1000 || tick == 1499 {
            println!("tick {}: state hash {:016x}", answer.tick, answer.state_hash);
        }
    }
    println!("{answers} answers, largest force {largest_n:.9} N");
    Ok(())
}
