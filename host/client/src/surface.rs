//! The surface of a body that can be cut, for viewers: all nodes, the copies that cuts have made, and the triangles
//! as they are now, at the rate of states.
//!
//! A message holds two lists, row by row in a slice of [`SurfaceRow`]: the nodes by ascending input id, as in a
//! state, with the copies of split ones after them, and the triangles, whose corners count in the first list. The
//! longer list makes the length; [`SurfaceHeader`] has the lengths of both. Readers keep only the newest. Servers of
//! bodies baked with `--cuttable` send it, whole ones too.

use iceoryx2::prelude::*;

use crate::payload::StateHeader;
use crate::services::SceneServices;
use crate::viewed::{Reader, Viewed};

/// A place of each of the two lists: 28 bytes, zeros beyond the end of a list.
///
/// ```
/// use chaincell_client::surface::SurfaceRow;
///
/// // Node 7 and its copy on the other side of a cut, each at a triangle that the cut has parted.
/// let row = |position_m, corners| SurfaceRow { node: 7, position_m, corners };
/// let rows = [row([0.0, 0.0, 0.01], [0, 4, 5]), row([0.001, 0.0, 0.01], [1, 6, 4])];
/// let first_m = rows.map(|of| rows[of.corners[0] as usize].position_m[0]);
/// assert_eq!(first_m, [0.0, 0.001]);
/// assert_eq!(size_of::<SurfaceRow>(), 28);
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, ZeroCopySend)]
#[type_name("chaincell.SurfaceRow.v1")]
#[repr(C)]
pub struct SurfaceRow {
    /// Id of the node in the input mesh; of a copy that of the node it was made from.
    pub node: u32,
    /// Position of the node or the copy in the frame of the input mesh \[m\].
    pub position_m: [f32; 3],
    /// Rows of the corners of a triangle, counter-clockwise from outside. One of a piece that is gone has three
    /// times the same row.
    pub corners: [u32; 3],
}

/// Tick and lengths of the lists: 48 bytes, the user header of a slice of [`SurfaceRow`].
///
/// ```
/// use chaincell_client::surface::SurfaceHeader;
///
/// let header = SurfaceHeader { nodes: 315, copies: 14, triangles: 624, ..SurfaceHeader::default() };
/// let is_copy = |row| (header.nodes..header.nodes + header.copies).contains(&row);
/// assert!(is_copy(315) && !is_copy(314));
/// ```
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, ZeroCopySend)]
#[type_name("chaincell.Surface.v1")]
#[repr(C)]
pub struct SurfaceHeader {
    /// Number of the last answered tick, 0 before the first.
    pub tick: u64,
    /// Ticks answered since the server began.
    pub ticks_answered: u64,
    /// Hash of the state.
    pub state_hash: u64,
    /// Number of nodes.
    pub nodes: u32,
    /// Number of copies, after the nodes.
    pub copies: u32,
    /// Number of triangles.
    pub triangles: u32,
    /// Flags of the last answer.
    pub flags: u32,
    /// Checksum of the model image, as `chaincell info` prints it.
    pub model_checksum: u32,
    /// Zero.
    pub reserved: u32,
}

// The offsets follow from the order of the fields, which the tables of the reference are compared with.
const _: () = {
    assert!(size_of::<SurfaceRow>() == 28);
    assert!(size_of::<SurfaceHeader>() == 48);
};

impl From<SurfaceHeader> for StateHeader {
    /// The header of the state of the same tick.
    fn from(of: SurfaceHeader) -> Self {
        let SurfaceHeader {
            tick, ticks_answered, state_hash, nodes, flags, model_checksum, ..
        } = of;
        Self { tick, ticks_answered, state_hash, nodes, flags, model_checksum, reserved: 0 }
    }
}

impl Viewed for SurfaceRow {
    type Header = SurfaceHeader;
    const WHAT: &'static str = "a surface";
    const NONE: &'static str = "no surface";

    fn name(scene: &SceneServices) -> &ServiceName {
        &scene.surface_name
    }
}

/// A reader of surfaces.
///
/// ```no_run
/// # fn read() -> chaincell_client::Result<()> {
/// use chaincell_client::services::{Domain, SceneServices};
/// use chaincell_client::surface::SurfaceReader;
///
/// let scene = SceneServices::open(Some("left"), &Domain::default())?;
/// let reader = SurfaceReader::open(&scene)?;
/// if let Some((header, rows)) = reader.take()? {
///     for of in &rows[..header.triangles as usize] {
///         let corners_m = of.corners.map(|row| rows[row as usize].position_m);
///         println!("{corners_m:?}");
///     }
/// }
/// # Ok(())
/// # }
/// ```
pub type SurfaceReader = Reader<SurfaceRow>;
