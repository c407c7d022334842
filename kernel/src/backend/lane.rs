//! Arithmetic that is written once for one cell and for eight in parallel, with the same bits.

use core::ops::{Add, Div, Mul, Sub};

use crate::backend::f32x8::F32x8;
use crate::number::sqrt::sqrt;

/// One `f32`, or eight of them: only exactly rounded operations.
pub(crate) trait Real: Copy {
    /// One truth value per lane.
    type Mask: Copy;

    fn of(value: f32) -> Self;
    fn plus(self, other: Self) -> Self;
    fn minus(self, other: Self) -> Self;
    fn times(self, other: Self) -> Self;
    fn over(self, other: Self) -> Self;
    fn root(self) -> Self;
    /// |self|.
    #[cfg(feature = "relax")]
    fn magnitude(self) -> Self;
    /// |self| with the sign of `other`.
    #[cfg(feature = "relax")]
    fn signed_as(self, other: Self) -> Self;
    /// True in lanes where `self > other`.
    fn above(self, other: Self) -> Self::Mask;
    /// True in lanes where `self == other`.
    #[cfg(feature = "relax")]
    fn equals(self, other: Self) -> Self::Mask;
    /// Returns true if the mask holds in any lane.
    fn any(mask: Self::Mask) -> bool;
    /// `yes` where the mask holds, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
}

impl Real for f32 {
    type Mask = bool;

    #[inline(always)]
    fn of(value: f32) -> Self {
        value
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        self / other
    }

    #[inline(always)]
    fn root(self) -> Self {
        sqrt(self)
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn magnitude(self) -> Self {
        self.abs()
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        self.copysign(other)
    }

    #[inline(always)]
    fn above(self, other: Self) -> bool {
        self > other
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn equals(self, other: Self) -> bool {
        self == other
    }

    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
}

impl<V: F32x8> Real for V {
    type Mask = V::Mask;

    #[inline(always)]
    fn of(value: f32) -> Self {
        V::splat(value)
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        F32x8::plus(self, other)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        F32x8::minus(self, other)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        F32x8::times(self, other)
    }

    #[inline(always)]
    fn over(self, other: Self) -> Self {
        F32x8::over(self, other)
    }

    #[inline(always)]
    fn root(self) -> Self {
        F32x8::root(self)
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn magnitude(self) -> Self {
        F32x8::magnitude(self)
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn signed_as(self, other: Self) -> Self {
        F32x8::signed_as(self, other)
    }

    #[inline(always)]
    fn above(self, other: Self) -> V::Mask {
        F32x8::above(self, other)
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    fn equals(self, other: Self) -> V::Mask {
        F32x8::equals(self, other)
    }

    #[inline(always)]
    fn any(mask: V::Mask) -> bool {
        <V as F32x8>::any(mask)
    }

    #[inline(always)]
    fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        F32x8::select(mask, yes, no)
    }
}

/// A number with the usual arithmetic operators.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(transparent)]
pub(crate) struct Lane<V>(pub V);

impl<V: Real> Lane<V> {
    #[inline(always)]
    pub fn of(value: f32) -> Self {
        Self(V::of(value))
    }

    #[inline(always)]
    pub fn root(self) -> Self {
        Self(self.0.root())
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    pub fn magnitude(self) -> Self {
        Self(self.0.magnitude())
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    pub fn signed_as(self, other: Self) -> Self {
        Self(self.0.signed_as(other.0))
    }

    #[inline(always)]
    pub fn above(self, other: Self) -> V::Mask {
        self.0.above(other.0)
    }

    #[cfg(feature = "relax")]
    #[inline(always)]
    pub fn equals(self, other: Self) -> V::Mask {
        self.0.equals(other.0)
    }

    #[inline(always)]
    pub fn select(mask: V::Mask, yes: Self, no: Self) -> Self {
        Self(V::select(mask, yes.0, no.0))
    }
}

impl<V: Real> Add for Lane<V> {
    type Output = Self;

    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self(self.0.plus(other.0))
    }
}

impl<V: Real> Sub for Lane<V> {
    type Output = Self;

    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self(self.0.minus(other.0))
    }
}

impl<V: Real> Mul for Lane<V> {
    type Output = Self;

    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self(self.0.times(other.0))
    }
}

impl<V: Real> Div for Lane<V> {
    type Output = Self;

    #[inline(always)]
    fn div(self, other: Self) -> Self {
        Self(self.0.over(other.0))
    }
}
