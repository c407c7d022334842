//! Example 2: two tools in one message. Both press for half a second; then the second one turns.
//!
//! `chaincell serve box.chaincell --tool sphere:0.008 --tool box:0.008,0.008,0.002,0.004 --scene left`
//! runs meanwhile, of a body of `--young-pa`; then
//! `cargo run --release -p chaincell-client --example two_tools left`.

use chaincell_client::clock::{now_ns, sleep_until_ns};
use chaincell_client::{Client, Options, Result, ToolPose};

/// A second: a device's loop waits for less than a millisecond.
const WAIT_NS: u64 = 1_000_000_000;
/// Where the surface of the body is \[m\].
const TOP_M: f64 = 0.04;

fn main() -> Result<()> {
    let scene = std::env::args().nth(1);
    // The tissue's own forces, however late they are. For a device leave both at 20 ms.
    let options = Options { scene, watchdog_ms: 0, ramp_ms: 0, ..Options::default() };
    let mut client = Client::open(&options)?;
    let start_ns = now_ns();
    for tick in 0..1000 {
        sleep_until_ns(start_ns + 1_000_000 * tick);
        let z_m = TOP_M + 0.003 - 0.005 * (tick as f64 / 500.0).min(1.0);
        // A turn about x: t is the tangent of a quarter of its angle.
        let t = 0.05 * (tick as f64 / 500.0 - 1.0).max(0.0);
        let (sin, cos) = (2.0 * t / (1.0 + t * t), (1.0 - t * t) / (1.0 + t * t));
        let engaged = tick > 0; // first released
        let sphere = ToolPose::at([-0.015, 0.0, (z_m + 0.008) as f32].into(), u32::from(engaged));
        let mut plate = ToolPose::at([0.015, 0.0, (z_m + 0.006) as f32].into(), u32::from(engaged));
        plate.orientation = [sin as f32, 0.0, 0.0, cos as f32];
        let (_, answer) = client.step(&[sphere, plate], WAIT_NS)?;
        if tick % 250 == 249 {
            println!("tick {}: state hash {:016x}", answer.tick, answer.state_hash);
            for (number, tool) in answer.tools[..2].iter().enumerate() {
                let [x, y, z] = tool.force_n;
                println!("  tool {number}: force {x:.9} {y:.9} {z:.9} N");
                let [x, y, z] = tool.torque_n_m;
                println!("  tool {number}: torque {x:.9} {y:.9} {z:.9} N m");
            }
        }
    }
    Ok(())
}
