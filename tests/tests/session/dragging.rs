//! A press of a sphere that then goes along the surface, for grips and pins.

use chaincell_tests::Running;
use chaincell_tests::outsider::Pose;
use chaincell_tests::place::Place;

/// A tick at which the sphere is 2 mm deep.
pub const DEEP: u64 = 40;

/// Its sphere has no friction: what drags the tissue along is a grip.
pub fn serve(place: &Place, options: &[&str]) -> Running {
    let always = ["--watchdog-ms", "0", "--ramp-ms", "0", "--json", "--contact", "probe:0.006"];
    place.serve(&[&always[..], options].concat())
}

/// Down to 2 mm, then along by 0.05 mm a tick to 4 mm, then at rest.
pub fn pose(tick: u64) -> Pose {
    let down = 0.0001 * tick.min(DEEP) as f32;
    let along = 0.00005 * tick.saturating_sub(DEEP).min(80) as f32;
    Pose { tick, position_m: [along, 0.002, 0.048 - down], engaged: u32::from(tick > 0) }
}
