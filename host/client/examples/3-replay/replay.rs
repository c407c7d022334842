//! Example 3: plays a file of poses, `tick,x_m,y_m,z_m,engaged` line by line, as `chaincell run` writes
//! it.
//!
//! `chaincell run plane.chaincell --contact 40 --motion press --seconds 2 --out offline` writes
//! offline/path.csv, and `chaincell serve plane.chaincell --contact 40 --scene left --record left.trace`
//! runs meanwhile; then
//! `cargo run --release -p chaincell-client --example replay left offline/path.csv`.

use std::error::Error;
use std::fs::File;
use std::io::{BufRead, BufReader};

use chaincell_client::clock::{now_ns, sleep_until_ns};
use chaincell_client::{Client, Options, ToolPose};

/// A second: a device's loop waits for less than a millisecond.
const WAIT_NS: u64 = 1_000_000_000;

fn main() -> Result<(), Box<dyn Error>> {
    let scene = std::env::args().nth(1);
    let file = BufReader::new(File::open(std::env::args().nth(2).ok_or("which file?")?)?);
    // The tissue's own forces, however late they are. For a device leave both at 20 ms.
    let options = Options { scene, watchdog_ms: 0, ramp_ms: 0, ..Options::default() };
    let mut client = Client::open(&options)?;
    // A tool has no force until a pose has released it once.
    client.step(&[ToolPose::AWAY], WAIT_NS)?;
    let start_ns = now_ns();
    for (tick, line) in (0..).zip(file.lines().skip(1)) {
        sleep_until_ns(start_ns + 1_000_000 * tick);
        let line = line?;
        let words: Vec<&str> = line.split(',').collect();
        let [_, x, y, z, engaged] = words[..] else { return Err(line.into()) };
        let place = [x.parse()?, y.parse()?, z.parse()?];
        let pose = ToolPose::at(place.into(), engaged.parse()?);
        let (_, answer) = client.step(&[pose], WAIT_NS)?;
        if tick % 500 == 499 {
            println!("row {tick}: state hash {:016x}", answer.state_hash);
            let [x, y, z] = answer.tools[0].force_n;
            println!("  force {x:.9} {y:.9} {z:.9} N");
        }
    }
    Ok(())
}
