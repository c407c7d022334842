//! In place of `opened` in a kernel that is built without cuts: no face opens.

use core::marker::PhantomData;

/// The triangles of opened faces: none.
#[derive(Clone, Copy)]
pub(crate) struct Opened<'a>(PhantomData<&'a ()>);

impl<'a> Opened<'a> {
    pub const NONE: Self = Self(PhantomData);

    #[inline(always)]
    pub fn numbers(&self, _: usize) -> Option<&'a [f32; 3]> {
        None
    }

    #[inline(always)]
    pub fn name(&self, _: usize) -> Option<u32> {
        None
    }

    #[inline(always)]
    pub fn place(&self, _: u32) -> Option<usize> {
        None
    }

    #[inline(always)]
    pub fn share(&self, _: &[[u16; 3]], _: usize, _: f32, _: &impl Fn(usize) -> [f32; 3]) -> f32 {
        0.0
    }
}
