//! Cutting: faces between tetrahedra open, and a cell whose tetrahedra fall apart gets copies.
//!
//! A body that is baked with `--cuttable` has its tetrahedra and spare cells in its image. A cut opens faces
//! between tetrahedra; no tetrahedron is removed, divided or weighted. At a cell of an opened face the
//! tetrahedra that still share a closed face are joined into pieces. The piece of the lowest tetrahedron keeps
//! the cell, each other piece takes the next spare cell. It inherits the cell's positions, rotation and shape,
//! its bound, its weights in the coarse level, and whether it is fixed. Then the cell, its copies and their
//! neighbours get volumes and half-links anew from their tetrahedra ([`nodal`](crate::energy)). A sweep sees
//! cells and half-links, as before.
//!
//! **The level.** `F_i` is a mean over the tetrahedra at a cell, so copies alone raise the energy: by Jensen's
//! inequality, by the spread of the pieces' means. A copy therefore keeps an offset C = F - F', F the shape of
//! the cell before with its own offset, F' the copy's; R, Q and stress follow F' + C, the spread follows F':
//!
//! ```text
//! sum V' psi(F' + C) = V psi(F)                                     the nodal part stays
//! sum of V_t / 4 |F_t - F'|^2 <= sum of V_t / 4 |F_t - F|^2         the spread falls
//! ```
//!
//! No split raises E, and stress stays as it was. In every tick C falls to nine tenths, and to 0 below 1e-6; the
//! change of the energy is booked as that of any correction at the start of a tick.
//!
//! **The bound.** The image has bounds of the cells that hold however tetrahedra are joined, so copies inherit
//! them. Copies also inherit the weights of the basis functions, so P' Lc P stays as it was. These functions do not
//! know the jump, so the coarse level gets further ones on one of the sides, within some 200 ticks after a cut; see
//! `sides`. Without them one sweep beside a cut through half of an organ is off by a third of the force, with them by
//! 1 to 5 %. A level of fewer than 24 functions has none, and a body that tears: stretched far, its forces would
//! buzz.
//!
//! **Links.** In a body of links a link lies in the tetrahedra at its edge. Where these fall apart, each piece has a
//! link with the share of the weight that its volume has in theirs; see `links`. Rest lengths and bands stay, so the
//! shares store what the whole link stores, and no offset is needed: a split changes the energy by rounding alone,
//! which the level takes. A share is rounded down, so no cell's weights exceed those of the cell from which it was
//! copied, whose bound it inherits. Its coarse level has no two-sided functions.
//!
//! **Stiffening.** The bands on the links of a body of shapes are parted in the same way: each piece of a link has them
//! with its share of the volume around the link; see `bands`. The offsets of copies are those of their shapes alone.
//! The load of a tear includes the bands.
//!
//! **The surface.** An opened face gives two triangles, one for each side, behind those of the surface: tools touch
//! them as any other. In a cut that lies closed the two lie on each other beneath the surface, and a sphere that is
//! pressed on the body above them would push them too. So a side counts as far as the other one has moved away from
//! it, see the module `model::opened`: from a gap of a tenth of its mean edge on, in full from four tenths on.
//! Over a closed cut a press is then bit by bit that on a body without these triangles; if all of them counted in
//! full, its force would rise by up to a fifth. As a cut opens under a tool, the energy of the contact changes with
//! the shares; it is booked at the start of the tick like that of a tool's motion. The pressure on the sides has no
//! part in the work that the hand is charged with for it.
//!
//! **Sides that lie on each other.** A copy does not go through the cell it was copied from: half the squared depth
//! of the one in the other, along the normal of the opened faces there, is a term of the energy, see
//! [`lips`](crate::energy). So a closed cut carries pressure: under compression a bar that is cut through half its
//! height has nine tenths of its stiffness. Cells meet their own copies alone: those farther from each other than
//! an edge press less, than two edges not at all, and there is no friction between the sides. The normals turn at
//! the start of a tick, which never raises the energy.
//!
//! **Tears.** A body whose image has a [limit](crate::TearLimit) parts by itself, at most a cell in a tick, across the
//! cell's largest stretch; see `tear`. Nobody pays for the decay of its offsets: they decay only as far as the last
//! tick's sweeps have lowered the energy, all by the same step, which is halved up to three times.
//!
//! **Limits.** At most [`SPLITS_MAX`] cells split in a tick, by ascending cell; the others wait. A cell that a
//! tool holds waits until the tool lets go of it. Without spare cells or half-links a split is refused and
//! counted, and the cell stays whole until a further face opens there. A late tick splits nothing. There are places for
//! the triangles of four faces for each spare cell; a face without a place opens all the same, tools pass its sides,
//! and [`CutOutput::untouched`](crate::CutOutput) counts it. A tool does not touch the sides of a cut whose lips lie
//! on each other or overlap, also where they have slid by less than an edge. A loose
//! piece that a tool carries lags behind it: one of six cells drags with 0.15 N at 50 mm/s and 4 sweeps, and with
//! nothing once the tool stands still.
//!
//! Cost: a split goes over the tetrahedra of the cell and of its neighbours; where a list of half-links outgrows
//! its place, those after it move once. RAM: [`cut_words`](crate::cut_words). A body that is not cuttable takes
//! none, and its bits do not change.
//!
//! - [`memory`]: memory of the caller, divided into arrays.
//! - `body`: the arrays with their image: tetrahedra, faces, and the model that a tick reads.
//! - `numbers`: volumes and half-links of a cell from its tetrahedra; in a body of links `links`: its half-links,
//!   and `ends`: the links by their ends. `bands`: the stiffening bands of half-links. `shares`: the share of a piece
//!   in a link's weight. `hats`: volume and gradients of a tetrahedron.
//! - `coarse`: a copy in the boxes of the coarse level; `labels`: the sides of a cut;
//!   `sides`: two-sided functions beside it, and `renewal`: where their renewal is.
//! - `pieces`: the tetrahedra at a cell, by the faces that are closed.
//! - `split`: the split of a cell.
//! - `opened`: the triangles of opened faces; `lips`: its sides where they lie on each other; `facing`: the way
//!   that these face in a body of links.
//! - `offset`: the offsets of copies, and their decay.
//! - `edge`: the fronts of a blade's edge; `entry`: how it enters; `ahead`: where the tissue is open before it;
//!   `strip`: the faces that it opens; `place`: points of tetrahedra.
//! - `loose`: pieces that hang on nothing; `joined`: sets of cells, for these and for the sides.
//! - `load`: shape and energy of a cell that may tear; `tear`: the cell that does, and the account of a tear.
//! - `kept`: what a snapshot and a state hash contain.

#[cfg(feature = "cut")]
mod ahead;
#[cfg(all(test, feature = "cut"))]
mod band_tests;
#[cfg(feature = "cut")]
mod bands;
#[cfg(feature = "cut")]
pub(crate) mod body;
#[cfg(feature = "cut")]
mod coarse;
#[cfg(feature = "cut")]
pub(crate) mod edge;
#[cfg(feature = "cut")]
mod ends;
#[cfg(feature = "cut")]
mod entry;
#[cfg(feature = "cut")]
mod facing;
#[cfg(feature = "cut")]
mod hats;
#[cfg(feature = "cut")]
mod joined;
#[cfg(feature = "cut")]
pub(crate) mod kept;
#[cfg(feature = "cut")]
mod labels;
#[cfg(all(test, feature = "cut"))]
mod link_tests;
#[cfg(feature = "cut")]
mod links;
#[cfg(feature = "cut")]
mod lips;
#[cfg(feature = "cut")]
mod load;
#[cfg(feature = "cut")]
mod loose;
pub mod memory;
#[cfg(feature = "cut")]
mod numbers;
#[cfg(feature = "cut")]
pub(crate) mod offset;
#[cfg(feature = "cut")]
mod opened;
#[cfg(feature = "cut")]
mod pieces;
#[cfg(feature = "cut")]
mod place;
#[cfg(all(test, feature = "cut"))]
mod random;
#[cfg(feature = "cut")]
mod renewal;
#[cfg(feature = "cut")]
mod shares;
#[cfg(feature = "cut")]
mod sides;
#[cfg(feature = "cut")]
pub(crate) mod split;
#[cfg(feature = "cut")]
mod strip;
#[cfg(feature = "cut")]
mod tear;
#[cfg(all(test, feature = "cut"))]
mod tests;

/// Most cells that split in a tick.
pub const SPLITS_MAX: usize = 8;
/// Most cells whose tetrahedra a tick joins into pieces.
#[cfg(feature = "cut")]
pub(crate) const LOOKS_MAX: usize = 32;
