//! Tool poses and tool parts.

use nalgebra::Vector3;

use crate::energy::surface::{COUNT_RAD, Crossing, Edge, Scissors, Solid};
use crate::number::turn::Turn;

/// Sine and cosine of an eighth of a turn.
const HALF_ROOT: f32 = core::f32::consts::FRAC_1_SQRT_2;
/// The identity orientation x, y, z, w.
pub const NOT_TURNED: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Pose of a tool in a tick, the same bytes in Rust, C, messages and traces.
///
/// Any bit pattern is admitted; a pose that is not good never reaches the cells: the last good one
/// stands in for ten ticks, then the safe state answers.
///
/// ```
/// use chaincell_kernel::ToolPose;
///
/// let pose = ToolPose::at([0.0, 0.0, -0.002].into(), 1); // 2 mm below the origin, engaged
/// assert!(pose.is_good());
/// let unplugged = ToolPose { position_m: [f32::NAN; 3].into(), ..pose };
/// assert!(!unplugged.is_good());
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct ToolPose {
    /// Position of the tool's frame in the frame of the input mesh \[m\].
    pub position_m: Vector3<f32>,
    /// Rotation from the tool's frame to the mesh's: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// 1 while the tool acts on the tissue, else 0.
    pub engaged: u16,
    /// Opening angle between the blades of scissors, in 2^-16 of a full turn as an encoder counts it: at most
    /// 32768, half a turn. Other tools ignore it.
    pub opening_turns_q16: u16,
}

/// Least offset of the edges of scissors from their pivot, in lengths of the blades: the torque that closes them grows
/// with one over it.
const OFFSET_MIN: f32 = 1.0e-3;

/// Largest [`ToolPose::opening_turns_q16`]: half a turn.
pub const OPENING_MAX: u16 = 32768;

impl ToolPose {
    /// A tool at the origin, not turned and not engaged.
    pub const AWAY: Self = Self::at(Vector3::new(0.0, 0.0, 0.0), 0);

    /// A tool at a position, not rotated; scissors are closed. `engaged` above 1 makes a bad pose.
    #[must_use]
    pub const fn at(position_m: Vector3<f32>, engaged: u32) -> Self {
        let most = u16::MAX;
        let engaged = if engaged < most as u32 { engaged as u16 } else { most };
        Self { position_m, orientation: NOT_TURNED, engaged, opening_turns_q16: 0 }
    }

    /// The pose with this opening of scissors, 0 to pi \[rad\], rounded to 96 microradian; any other number makes
    /// a bad pose.
    ///
    /// ```
    /// use chaincell_kernel::ToolPose;
    ///
    /// let open = ToolPose::at([0.0; 3].into(), 1).with_opening_rad(1.0);
    /// assert_eq!(open.opening_turns_q16, 10430);
    /// assert!((open.opening_rad() - 1.0).abs() < 48e-6);
    /// assert!(!open.with_opening_rad(-0.1).is_good());
    /// ```
    #[must_use]
    pub fn with_opening_rad(self, opening_rad: f32) -> Self {
        let counts = opening_rad / COUNT_RAD + 0.5;
        let opening_turns_q16 = if opening_rad >= 0.0 { counts as u16 } else { u16::MAX };
        Self { opening_turns_q16, ..self }
    }

    /// Opening of scissors \[rad\].
    #[must_use]
    pub fn opening_rad(&self) -> f32 {
        COUNT_RAD * f32::from(self.opening_turns_q16)
    }

    /// `engaged` and opening in one word, as a trace has them: the opening in the upper half.
    pub(crate) fn acting(&self) -> u32 {
        u32::from(self.engaged) | u32::from(self.opening_turns_q16) << 16
    }

    /// The pose with `engaged` and opening of a trace's word.
    pub(crate) fn with_acting(self, word: u32) -> Self {
        Self { engaged: word as u16, opening_turns_q16: (word >> 16) as u16, ..self }
    }

    /// Returns true if the tick may use the pose: finite, `engaged` 0 or 1, quaternion length between 1/2 and
    /// 2, an opening of at most half a turn.
    #[must_use]
    pub fn is_good(&self) -> bool {
        self.engaged <= 1
            && self.opening_turns_q16 <= OPENING_MAX
            && self.position_m.iter().all(|x| x.is_finite())
            && self.turn().is_some()
    }

    pub(crate) fn turn(&self) -> Option<Turn> {
        Turn::of_orientation(self.orientation)
    }
}

/// A convex part of a tool with rounded edges, in the tool's frame.
///
/// ```
/// use chaincell_kernel::ToolPart;
///
/// // A scalpel's handle of 8 mm, 100 mm long, and a blade in front of it [m].
/// let handle = ToolPart::capsule(0.046, 0.004);
/// let blade = ToolPart::rounded_box([0.0, 0.003, 0.01], 0.0005);
/// let blade = ToolPart { centre_m: [0.0, 0.0, -0.06], ..blade };
/// let tool = [handle, blade];
/// assert_eq!(tool[0].half_m[2] + tool[0].radius_m, 0.05); // half of its length
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(C)]
pub struct ToolPart {
    /// Centre of the part \[m\].
    pub centre_m: [f32; 3],
    /// Rotation from the part's frame to the tool's: a unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Half edges of the core \[m\]: 0 0 0 for a sphere, 0 0 a for a capsule along z. Infinite in every axis
    /// for a half space; its core is everything below z = -radius.
    pub half_m: [f32; 3],
    /// Radius of the rounded edges around the core \[m\]; 0 for the edge of a blade, below 0 for scissors (see
    /// [`Self::scissors`]). A tool presses only so far that no sample lies deeper in it than two fifths of this.
    pub radius_m: f32,
}

impl ToolPart {
    /// A sphere around the tool's position.
    #[must_use]
    pub const fn sphere(radius_m: f32) -> Self {
        let (centre_m, half_m) = ([0.0; 3], [0.0; 3]);
        Self { centre_m, orientation: NOT_TURNED, half_m, radius_m }
    }

    /// A capsule along z: a cylinder of this half length with half spheres at its ends.
    #[must_use]
    pub const fn capsule(half_length_m: f32, radius_m: f32) -> Self {
        Self { half_m: [0.0, 0.0, half_length_m], ..Self::sphere(radius_m) }
    }

    /// A box; its outer half edges are `half_m` plus the radius of its rounded edges.
    #[must_use]
    pub const fn rounded_box(half_m: [f32; 3], radius_m: f32) -> Self {
        Self { half_m, ..Self::sphere(radius_m) }
    }

    /// The half space below z = 0.
    #[must_use]
    pub const fn half_space(radius_m: f32) -> Self {
        Self { half_m: [f32::INFINITY; 3], ..Self::sphere(radius_m) }
    }

    /// A straight edge of a blade, along x: it cuts towards -z, and its plane is that of x and z. It has no sides:
    /// nothing of it touches the surface. It is the last part of its tool, and needs a body that can be cut.
    ///
    /// ```
    /// use chaincell_kernel::ToolPart;
    ///
    /// let blade = [ToolPart::edge(0.005)]; // 10 mm long
    /// assert!(blade[0].is_edge());
    /// ```
    #[must_use]
    pub const fn edge(half_length_m: f32) -> Self {
        Self { half_m: [half_length_m, 0.0, 0.0], ..Self::sphere(0.0) }
    }

    /// Scissors: two straight blades from the pivot along -z, which open in the y direction by the angle of the
    /// tool's pose. The edge of each passes the pivot at `offset_m`, a
    /// thousandth of the length at least. Where the edges cross they cut towards -z, in
    /// the plane of y and z, through tissue of at most `mouth_m` thickness along y. The blades have no sides. It is
    /// the last part of its tool, and needs a body that can be cut.
    ///
    /// ```
    /// use chaincell_kernel::ToolPart;
    ///
    /// let scissors = ToolPart::scissors(0.04, 0.004, 0.02); // blades of 40 mm
    /// assert!(scissors.is_edge());
    /// assert_eq!(scissors.blades().ok_or("no scissors")?.crossing_m(0.0), 0.04); // closed: at the tip
    /// # Ok::<(), &str>(())
    /// ```
    #[must_use]
    pub const fn scissors(length_m: f32, offset_m: f32, mouth_m: f32) -> Self {
        Self { half_m: [0.5 * mouth_m, 0.0, length_m], ..Self::sphere(-offset_m) }
    }

    /// The blades of scissors; `None` for another part.
    #[must_use]
    pub fn blades(&self) -> Option<Scissors> {
        let ([half_mouth, height, length_m], offset_m) = (self.half_m, -self.radius_m);
        let is_far = offset_m >= length_m * OFFSET_MIN && length_m > offset_m;
        let is_any = offset_m > 0.0 && half_mouth > 0.0 && height == 0.0 && is_far;
        is_any.then_some(Scissors { length_m, offset_m })
    }

    /// Returns true if the part cuts: an edge, or scissors.
    #[must_use]
    pub fn is_edge(&self) -> bool {
        let [along, height, width] = self.half_m;
        let is_straight = self.radius_m == 0.0 && along > 0.0 && height == 0.0 && width == 0.0;
        is_straight || self.blades().is_some()
    }

    /// Returns true if the part is a half space.
    #[must_use]
    pub fn is_half_space(&self) -> bool {
        self.half_m == [f32::INFINITY; 3]
    }

    /// The edge in mean link lengths; `None` for another part, and if a number is not finite or too large.
    pub(crate) fn edge_in_links(&self, unit_m: f32, most: f32) -> Option<Edge> {
        let [half, ..] = self.half_m.map(|x| x / unit_m);
        let centre = self.centre_m.map(|x| x / unit_m);
        let is_within = |x: f32| x.abs() <= most;
        let is_good =
            self.is_edge() && half > 0.0 && is_within(half) && centre.into_iter().all(is_within);
        let turn = Turn::of_orientation(self.orientation).filter(|_| is_good)?;
        let Some(Scissors { length_m, offset_m }) = self.blades() else {
            return Some(Edge::new(half, centre, turn));
        };
        let [length, offset] = [length_m, offset_m].map(|x| x / unit_m);
        if !(is_within(length) && offset > 0.0 && offset < length) {
            return None;
        }
        // The edge of scissors lies along y.
        let across = Turn::of_orientation([0.0, 0.0, HALF_ROOT, HALF_ROOT])?;
        let edge = Edge::new(half, centre, turn.after(across));
        Some(edge.between(Crossing::new(length, offset)))
    }

    /// The part in mean link lengths; `None` if a number is not finite, too small or too large.
    pub(crate) fn solid(&self, unit_m: f32, most: f32) -> Option<Solid> {
        let in_links = |x: f32| x / unit_m;
        let (centre, half) = (self.centre_m.map(in_links), self.half_m.map(in_links));
        let whole = in_links(self.radius_m);
        let is_within = |x: f32| x.is_finite() && x.abs() <= most;
        let is_plane = self.is_half_space();
        let is_good = self.radius_m > 0.0
            && whole > 0.0
            && is_within(whole)
            && centre.into_iter().all(is_within)
            && (is_plane || half.into_iter().all(|x| x >= 0.0 && is_within(x)));
        let turn = Turn::of_orientation(self.orientation).filter(|_| is_good)?;
        let end = f32::INFINITY;
        let core = match is_plane {
            true => [[-end; 3], [end, end, -whole]],
            // -0.0 becomes +0.0.
            false => [half.map(|x| 0.0 - x), half.map(|x| x + 0.0)],
        };
        // Samples under a half space need no finer spacing than under the largest sphere.
        let sampled = if is_plane { most } else { whole };
        Some(Solid { centre, turn, core, radius: whole, whole, sampled })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // REQ-CON-09
    #[test]
    fn parts_that_cannot_be_are_refused() {
        let good = ToolPart::capsule(0.01, 0.002);
        assert!(good.solid(0.005, 100.0).is_some());
        assert!(ToolPart::half_space(0.004).solid(0.005, 100.0).is_some());
        for bad in [
            ToolPart { radius_m: 0.0, ..good },
            ToolPart { radius_m: f32::NAN, ..good },
            ToolPart { half_m: [0.0, -0.01, 0.0], ..good },
            ToolPart { half_m: [0.0, f32::INFINITY, 0.0], ..good },
            ToolPart { centre_m: [f32::NAN, 0.0, 0.0], ..good },
            ToolPart { orientation: [0.0; 4], ..good },
            ToolPart { radius_m: 9.0, ..good },
        ] {
            assert!(bad.solid(0.005, 100.0).is_none(), "{bad:?}");
        }
    }

    /// A word that holds `engaged` alone is that of closed scissors.
    #[test]
    fn the_opening_lies_behind_engaged() {
        use core::mem::offset_of;
        assert_eq!((size_of::<ToolPose>(), offset_of!(ToolPose, engaged)), (32, 28));
        assert_eq!(offset_of!(ToolPose, opening_turns_q16), 30);
        let closed = ToolPose::at([0.0; 3].into(), 1);
        assert_eq!((closed.acting(), closed.with_acting(1)), (1, closed));
        assert_eq!((closed.with_acting(0).engaged, closed.opening_rad()), (0, 0.0));
        for bad in [2, 7, 0xFFFF, u32::MAX, 1 | 32769 << 16] {
            assert!(!closed.with_acting(bad).is_good(), "{bad}");
            assert_eq!(closed.with_acting(bad).acting(), bad);
        }
        let open = closed.with_acting(1 | 5215 << 16);
        assert_eq!(open, closed.with_opening_rad(0.5));
        assert!(open.is_good());
    }

    #[test]
    fn poses_that_cannot_be_are_seen() {
        let good = ToolPose::at([0.0, 0.1, 0.2].into(), 1);
        assert!(good.is_good());
        assert!(!ToolPose { engaged: 2, ..good }.is_good());
        for (opening_turns_q16, is_good) in [(0, true), (32768, true), (32769, false)] {
            assert_eq!(ToolPose { opening_turns_q16, ..good }.is_good(), is_good);
        }
        assert!(good.with_opening_rad(core::f32::consts::PI).is_good());
        for bad_rad in [f32::NAN, -1e-6, 3.1418, f32::INFINITY] {
            assert!(!good.with_opening_rad(bad_rad).is_good(), "{bad_rad}");
        }
        assert!(!ToolPose { orientation: [0.0, f32::NAN, 0.0, 1.0], ..good }.is_good());
        assert!(!ToolPose { position_m: [f32::INFINITY, 0.0, 0.0].into(), ..good }.is_good());
    }
}
