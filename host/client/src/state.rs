//! States for viewers: all node positions, at a bounded rate.
//!
//! A state is a slice of [`NodePosition`], one for every node by ascending input id, as in
//! cells_final.csv; each row names its node, so that a reader needs only the message. It is sent
//! between ticks while no pose waits for an answer, if somebody reads and there is a new tick,
//! command or reader. Readers keep only the newest state.

use iceoryx2::prelude::*;

use crate::payload::{NodePosition, StateHeader};
use crate::services::SceneServices;
use crate::viewed::{Reader, Viewed};

impl Viewed for NodePosition {
    type Header = StateHeader;
    const WHAT: &'static str = "a state";
    const NONE: &'static str = "no state";

    fn name(scene: &SceneServices) -> &ServiceName {
        &scene.state_name
    }
}

/// A reader of states.
///
/// ```no_run
/// # fn read() -> chaincell_client::Result<()> {
/// use chaincell_client::services::{Domain, SceneServices};
/// use chaincell_client::state::StateReader;
///
/// let scene = SceneServices::open(Some("left"), &Domain::default())?;
/// let reader = StateReader::open(&scene)?;
/// if let Some((header, nodes)) = reader.take()? {
///     let highest_m = nodes.iter().map(|of| of.position_m[2]).fold(f32::MIN, f32::max);
///     println!("tick {}: up to {highest_m} m", header.tick);
/// }
/// # Ok(())
/// # }
/// ```
pub type StateReader = Reader<NodePosition>;
