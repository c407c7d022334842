//! A body under tools that move goes on as it went.
//!
//! With `p_i` the point of the next pass when tick i begins and `v_i` how far the body is taken to go
//! by itself in it, the body goes on by
//!
//! ```text
//! v_i+1 = c share ((1 - k) v_i + k (p_i+1 - p_i))
//! ```
//!
//! share being how much of their last moves the tools make again. The way p_i+1 - p_i is `v_i` and
//! what the sweeps added, so k is how much of a correction is learnt. The sweep behind a push goes
//! too far as often as not; where all of that is learnt, each tick takes the last overshoot along and
//! adds its own. On shapes k is therefore small, and grows with the sweeps that a tick has to take
//! its own overshoot back; c is 1. Links snap from one equilibrium to another under a deep press, and
//! a body that remembers goes the wrong way for long: there k is 1 and c below 1.

use super::{ARRAYS, TRACK};
use crate::model::Model;
use crate::number::cell::{Cell, add, peak, scale, sub};

/// On shapes k for each sweep of a tick, and the largest k.
const LEARNT: f32 = 0.15;
const LEARNT_MOST: f32 = 0.6;
/// c on links: it damps what the last tick had not yet settled.
const CARRIED: f32 = 0.9;

/// What goes on in a tick.
#[derive(Debug, Clone, Copy)]
pub(super) struct Going {
    /// How much of their last moves the tools make again.
    pub share: f32,
    /// Sweeps of the last tick.
    pub sweeps: u16,
    /// Whether the tools moved in the last tick too.
    pub is_marked: bool,
    /// Whether the next pass is at a point beyond the published one. Else the guard discarded where
    /// the way has led: it is forgotten, and the body stays.
    pub is_going: bool,
}

/// Moves the point of the next pass and that of the last one by the way that the body goes on by. The
/// first field is where the former began the last tick, the second one v. Whether some coordinate is
/// beyond K.
pub(super) fn go_on(
    model: &Model<'_>,
    own: &mut [Cell],
    published: &[Cell],
    Going { share, sweeps, is_marked, is_going }: Going,
) -> bool {
    let cells = model.cells();
    if own.len() != ARRAYS * cells {
        return false;
    }
    let Some((points, fields)) = own.split_at_mut_checked(TRACK * cells) else { return false };
    let Some((at, before)) = points.split_at_mut_checked(cells) else { return false };
    let Some((marks, ways)) = fields.split_at_mut_checked(cells) else { return false };
    if !is_marked || !is_going {
        ways.iter_mut().for_each(|way| *way = Cell::ZERO);
    }
    if !is_going {
        for (mark, here) in marks.iter_mut().zip(published) {
            *mark = *here;
        }
        return false;
    }
    let (learnt, carried) = learning(model, sweeps);
    let (learnt, share) = (if is_marked { learnt } else { 0.0 }, carried * share);
    let mut highest = 0.0;
    for (((at, before), mark), way) in at.iter_mut().zip(before).zip(marks).zip(ways) {
        let (here, last) = (at.xyz(), way.xyz());
        let gone = sub(here, mark.xyz());
        let on = scale(share, add(last, scale(learnt, sub(gone, last))));
        (*mark, *way) = (Cell::at(here), Cell::at(on));
        *at = Cell::at(add(here, on));
        *before = Cell::at(add(before.xyz(), on));
        let here = peak(at.xyz());
        highest = if here > highest { here } else { highest };
    }
    highest > model.saturation()
}

/// k and c, behind a tick of so many sweeps.
fn learning(model: &Model<'_>, sweeps: u16) -> (f32, f32) {
    if model.kept_states() == 0 {
        return (1.0, CARRIED);
    }
    let learnt = LEARNT * f32::from(sweeps);
    (if learnt < LEARNT_MOST { learnt } else { LEARNT_MOST }, 1.0)
}
