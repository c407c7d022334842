//! The coarse level beside a probe: without the hats that reach its contacts.
//!
//! Contacts of a probe come and go, so the corrections of [`hold`](crate::hats), which cost 2 hats^2
//! a held cell, are too dear for them. Instead the set H of hats with a weight at a contact is left
//! out: c = 0 there, and no held cell moves. Among the c that are zero on H, the one that lowers
//! the bound of the energy most is
//!
//! ```text
//! c = B g - B_H (B_HH)^-1 (B g)_H
//! ```
//!
//! for which c' (A + R) c = g . c still holds, hence the certificate of
//! [`track`](crate::Track). The principal submatrix `B_HH` is positive definite as B is; its
//! Cholesky factor is worked out when the contacts change. With more than [`TAKEN_MAX`] hats in H,
//! or where rounding makes a pivot too small, there is no coarse level until they change again.
//!
//! Cost: k^3 / 6 multiplications when the contacts change, k = |H|; 3 k (hats + k) a sweep.

use crate::contact::Contact;
use crate::hats::{Eight, Hats, vector};
use crate::number::Number;
use crate::simd::octet::Octet;
use crate::sqrt::sqrt;
use crate::two_float::LANES;

/// Most hats that are taken out.
pub(crate) const TAKEN_MAX: usize = 64;
/// Smallest pivot, in the diagonal element.
const PIVOT_MIN: f32 = 1.0e-5;
/// What may be left of c at the hats taken out, over what was there: above that the factor is no
/// good.
const LEFT_MAX: f32 = 1.0e-2;

/// Octets of a row of the factor.
const fn row_octets(hats: usize) -> usize {
    (if hats < TAKEN_MAX { hats } else { TAKEN_MAX }).div_ceil(LANES)
}

/// Room that the coarse level needs for `hats` hats and a probe \[octets of f32\].
///
/// With K = min(hats, 64) rounded up to a multiple of 8: six vectors over the hats, K numbers of
/// hats, K sums for each axis, K^2 elements of the factor.
#[must_use]
pub const fn probe_room(hats: usize) -> usize {
    let row = row_octets(hats);
    6 * hats.div_ceil(LANES) + row * (4 + LANES * row)
}

/// What stands behind the vectors in the room.
struct Taken<'a> {
    /// Numbers of the hats, ascending.
    hats: &'a mut [f32],
    /// Three sums each.
    sums: &'a mut [[f32; 3]],
    /// Rows of the upper factor U, `B_HH` = U' U, with the inverse of each diagonal element.
    factor: &'a mut [Eight],
    row: usize,
}

impl<'a> Taken<'a> {
    fn cut(hats: &Hats<'_>, behind: &'a mut [Eight]) -> Option<Self> {
        let row = row_octets(hats.count);
        let (numbers, rest) = behind.split_at_mut_checked(row)?;
        let (sums, rest) = rest.split_at_mut_checked(3 * row)?;
        let factor = rest.get_mut(..LANES * row * row)?;
        let (sums, _) = sums.as_flattened_mut().as_chunks_mut();
        Some(Self { hats: numbers.as_flattened_mut(), sums, factor, row })
    }

    /// Row i of the factor.
    fn row_of(&self, i: usize) -> &[f32] {
        vector(self.factor, self.row, i).as_flattened()
    }

    /// Works out the factor of the first `count` hats; whether that could be done.
    fn factorise(&mut self, of: &Hats<'_>, count: usize) -> bool {
        let row = self.row;
        self.factor.fill([0.0; LANES]);
        let numbers = self.hats.get(..count).unwrap_or(&[]);
        for (line, &i) in self.factor.as_flattened_mut().chunks_exact_mut(row * LANES).zip(numbers)
        {
            for (slot, &j) in line.iter_mut().zip(numbers) {
                *slot = of.inverse_at(i as usize, j as usize);
            }
        }
        for pivot in 0..count {
            let Some((above, below)) = self.factor.split_at_mut_checked((pivot + 1) * row) else {
                return false;
            };
            let Some(own) = above.get_mut(pivot * row..) else { return false };
            let own = own.as_flattened_mut();
            let number = numbers.get(pivot).map_or(0, |&hat| hat as usize);
            let left = own.get(pivot).copied().unwrap_or(0.0);
            if left.is_nan() || left <= PIVOT_MIN * of.inverse_at(number, number) {
                return false;
            }
            let inverse = 1.0 / sqrt(left);
            for slot in own.iter_mut().skip(pivot + 1) {
                *slot *= inverse;
            }
            if let Some(slot) = own.get_mut(pivot) {
                *slot = inverse;
            }
            let lines = below.as_flattened_mut().chunks_exact_mut(row * LANES);
            for (i, line) in (pivot + 1..count).zip(lines) {
                let share = own.get(i).copied().unwrap_or(0.0);
                for (slot, u) in line.iter_mut().zip(&*own).skip(i) {
                    *slot -= share * u;
                }
            }
        }
        true
    }

    /// Solves `B_HH` y = sums, in place.
    fn solve(&mut self, count: usize) {
        for at in 0..count {
            let row = vector(self.factor, self.row, at).as_flattened();
            let inverse = row.get(at).copied().unwrap_or(0.0);
            let Some((own, later)) = self.sums.get_mut(at..).and_then(<[_]>::split_first_mut)
            else {
                return;
            };
            *own = own.map(|x| x * inverse);
            for (sum, &u) in later.iter_mut().zip(row.iter().skip(at + 1)) {
                *sum = [sum[0] - u * own[0], sum[1] - u * own[1], sum[2] - u * own[2]];
            }
        }
        for at in (0..count).rev() {
            let row = self.row_of(at);
            let inverse = row.get(at).copied().unwrap_or(0.0);
            let known = self.sums.iter().zip(row).take(count).skip(at + 1);
            let own = self.sums.get(at).copied().unwrap_or([0.0; 3]);
            let own = known
                .fold(own, |own, (y, u)| [own[0] - u * y[0], own[1] - u * y[1], own[2] - u * y[2]]);
            if let Some(slot) = self.sums.get_mut(at) {
                *slot = own.map(|x| x * inverse);
            }
        }
    }
}

/// Finds the hats that reach the contacts and factorises their part of the inverse; their number,
/// or `None` where they are too many or the factor does not exist.
pub(crate) fn take_out<N: Number>(
    hats: &Hats<'_>,
    room: &mut [Eight],
    held: &[Contact<N>],
) -> Option<u16> {
    let octets = hats.octets();
    let (vectors, behind) = room.split_at_mut_checked(6 * octets)?;
    let marks = vectors.get_mut(..octets)?.as_flattened_mut();
    marks.fill(0.0);
    for contact in held {
        for (hat, weight) in hats.row_of(contact.cell()) {
            if let Some(mark) = marks.get_mut(hat)
                && weight > 0.0
            {
                *mark = 1.0;
            }
        }
    }
    let mut taken = Taken::cut(hats, behind)?;
    let mut count = 0;
    let marked = marks.iter().enumerate().filter(|&(_, &mark)| mark > 0.0);
    for (hat, _) in marked {
        *taken.hats.get_mut(count)? = hat as f32;
        count += 1;
    }
    taken.factorise(hats, count).then_some(count as u16)
}

/// Takes the first `count` hats that stand in the room out of c = B g; whether the rest is sound.
#[inline(always)]
pub(crate) fn without<V: Octet>(
    hats: &Hats<'_>,
    behind: &mut [Eight],
    count: usize,
    c: &mut [Eight],
) -> bool {
    let octets = hats.octets();
    if count == 0 {
        return true;
    }
    let Some(mut taken) = Taken::cut(hats, behind) else { return false };
    let numbers = |taken: &Taken<'_>, at: usize| taken.hats.get(at).map_or(0, |&hat| hat as usize);
    let stride = octets * LANES;
    let value = |c: &[Eight], axis: usize, hat: usize| {
        c.as_flattened().get(axis * stride + hat).copied().unwrap_or(0.0)
    };
    let mut highest = 0.0;
    for at in 0..count {
        let sum = [0, 1, 2].map(|axis| value(c, axis, numbers(&taken, at)));
        let here = crate::cell::peak(sum);
        highest = if here > highest { here } else { highest };
        if let Some(slot) = taken.sums.get_mut(at) {
            *slot = sum;
        }
    }
    taken.solve(count);
    for at in 0..count {
        let sum = taken.sums.get(at).copied().unwrap_or([0.0; 3]);
        let row = vector(hats.inverse, octets, numbers(&taken, at));
        for (axis, &share) in sum.iter().enumerate() {
            let share = V::splat(share);
            let c = c.get_mut(axis * octets..(axis + 1) * octets).unwrap_or(&mut []);
            for (b, c) in row.iter().zip(c) {
                V::load(c).minus(V::load(b).times(share)).store(c);
            }
        }
    }
    let mut left = 0.0;
    for at in 0..count {
        for axis in 0..3 {
            let at = axis * stride + numbers(&taken, at);
            if let Some(slot) = c.as_flattened_mut().get_mut(at) {
                left = if slot.abs() > left { slot.abs() } else { left };
                *slot = 0.0;
            }
        }
    }
    left <= LEFT_MAX * highest
}
