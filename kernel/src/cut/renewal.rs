//! Where the renewal of the two-sided functions of a cut is, as words of the state, and their lists.

use crate::model::sides::Sides;
use crate::number::two_float::{Eight, LANES};

/// Links from a side of a cut within which its cells move with it.
pub(super) const RINGS: u32 = 8;
/// Ticks from the end of a renewal to the next one.
pub(super) const PAUSE: u32 = 64;

/// Number of words of [`Renewal`].
pub(super) const WORDS: usize = 7;

/// Where a renewal is, as words.
pub(crate) type Renewal = [u32; WORDS];
/// Index of the step: 0 at rest, then as in the module's text.
pub(super) const STEP: usize = 0;
/// Index of the next ring, hat, or function and axis of this step; at rest the ticks to wait.
pub(super) const NEXT: usize = 1;
/// Index of the number of copies when it began.
pub(super) const COPIES: usize = 2;
/// Index of the number of two-sided functions.
pub(super) const FUNCTIONS: usize = 3;
/// Index of the number of columns of Y.
pub(super) const COLUMNS: usize = 4;
/// Index of the number of cells under the functions.
pub(super) const CELLS: usize = 5;
/// Index of the sides that keep the hats of the image alone, a bit each.
pub(super) const KEEPING: usize = 6;

/// Steps of a renewal.
pub(super) const AT_REST: u32 = 0;
pub(super) const SPREADING: u32 = 1;
pub(super) const SHARING: u32 = 2;
pub(super) const SOLVING: u32 = 3;

/// Numbers of functions, of columns of Y and of cells under the functions.
pub(super) fn in_use(renewal: Renewal) -> [usize; 3] {
    [FUNCTIONS, COLUMNS, CELLS].map(|index| renewal.get(index).map_or(0, |&word| word as usize))
}

/// Returns true if words that were read are such as a renewal leaves behind in a body of `cells` cells, with room for
/// `room` functions.
pub(super) fn is_fit(renewal: Renewal, room: usize, cells: usize) -> bool {
    let [step, next, ..] = renewal;
    let [functions, columns, listed] = in_use(renewal);
    let most = match step {
        AT_REST => PAUSE,
        SPREADING => RINGS,
        SHARING => u16::MAX.into(),
        SOLVING => 3 * functions as u32,
        _ => return false,
    };
    next <= most && functions <= room && columns <= 3 * functions && listed <= cells
}

/// The lists of the two-sided functions, with all that there is room for.
pub(super) struct Lists<'a> {
    pub turns: &'a [u16],
    pub cells: &'a [u16],
    pub rows: &'a [[u8; LANES]],
}

impl<'a> Lists<'a> {
    /// Those in use, with their columns of Y, each of `length` blocks.
    pub fn sides(self, renewal: Renewal, columns: &'a [Eight], length: usize) -> Sides<'a> {
        let [functions, count, listed] = in_use(renewal);
        Sides {
            blocks: self.turns.len() / LANES,
            turns: self.turns.get(..functions).unwrap_or(&[]),
            cells: self.cells.get(..listed).unwrap_or(&[]),
            rows: self.rows,
            columns: columns.get(..count * length).unwrap_or(&[]),
        }
    }
}
