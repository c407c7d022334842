//! Strain and stress for viewers: of every node, at the rate of states.
//!
//! A message is a slice of [`NodeStress`], one for every node by ascending input id, as in a state. A server computes
//! it only while somebody reads, some nodes between two ticks, so that a message holds the ticks of one pass over the
//! body: [`StressHeader::first_tick`] to [`StressHeader::tick`]. A node that a cut has parted has the values of the
//! side with the largest stress after von Mises. Readers keep only the newest. Servers of tissue with a modulus send
//! it; a body of links has no stress.

use iceoryx2::prelude::*;

use crate::services::SceneServices;
use crate::viewed::{Reader, Viewed};

/// Strain and stress around one node: 24 bytes.
///
/// ```
/// use chaincell_client::stress::NodeStress;
///
/// let pulled = NodeStress { node: 7, von_mises_pa: 900.0, mean_pa: 300.0, ..NodeStress::default() };
/// assert_eq!(pulled.von_mises_pa, 3.0 * pulled.mean_pa); // a bar under tension
/// assert_eq!(size_of::<NodeStress>(), 24);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.NodeStress.v1")]
#[repr(C)]
pub struct NodeStress {
    /// Id of the node in the input mesh.
    pub node: u32,
    /// Principal stretches, the largest first.
    pub stretches: [f32; 3],
    /// Stress after von Mises: that of a bar under tension is its tension \[Pa\].
    pub von_mises_pa: f32,
    /// Mean stress, below 0 where the tissue is pressed from all sides \[Pa\].
    pub mean_pa: f32,
}

/// The pass over the body that the stresses are of: 24 bytes, the user header of a slice of [`NodeStress`].
///
/// ```
/// use chaincell_client::stress::StressHeader;
///
/// let header = StressHeader { first_tick: 400, tick: 422, nodes: 995, ..StressHeader::default() };
/// assert_eq!(header.tick - header.first_tick, 22); // a pass of 23 ms at 1 kHz
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("chaincell.Stress.v1")]
#[repr(C)]
pub struct StressHeader {
    /// Number of the last answered tick at its end, 0 before the first.
    pub tick: u64,
    /// Number of the last answered tick at its begin.
    pub first_tick: u64,
    /// Number of nodes in the slice.
    pub nodes: u32,
    /// Checksum of the model image, as `chaincell info` prints it.
    pub model_checksum: u32,
}

// The offsets follow from the order of the fields, which the tables of the reference are compared with.
const _: () = {
    assert!(size_of::<NodeStress>() == 24);
    assert!(size_of::<StressHeader>() == 24);
};

impl Viewed for NodeStress {
    type Header = StressHeader;
    const WHAT: &'static str = "stresses";
    const NONE: &'static str = "no stresses";

    fn name(scene: &SceneServices) -> &ServiceName {
        &scene.stress_name
    }
}

/// A reader of stresses.
///
/// ```no_run
/// # fn read() -> chaincell_client::Result<()> {
/// use chaincell_client::services::{Domain, SceneServices};
/// use chaincell_client::stress::StressReader;
///
/// let scene = SceneServices::open(Some("left"), &Domain::default())?;
/// let reader = StressReader::open(&scene)?;
/// if let Some((header, nodes)) = reader.take()? {
///     let most_pa = nodes.iter().map(|of| of.von_mises_pa).fold(0.0, f32::max);
///     println!("tick {}: up to {most_pa} Pa", header.tick);
/// }
/// # Ok(())
/// # }
/// ```
pub type StressReader = Reader<NodeStress>;
