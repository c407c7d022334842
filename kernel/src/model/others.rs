//! The terms besides the links, as this crate is built.

#[cfg(feature = "cut")]
use super::lips::Lips;
#[cfg(feature = "nodal")]
use super::nodal::Nodal;
#[cfg(test)]
use super::pin::Pins;
#[cfg(feature = "nodal")]
use super::stiffening::Stiffening;
use super::terms::NoTerm;

/// The terms besides the links: nested pairs that end in [`NoTerm`].
#[cfg(not(test))]
pub(crate) type Others<'a> = Built<'a>;
/// In this crate's tests the list has a further term, to show that one can be added.
#[cfg(test)]
pub(crate) type Others<'a> = (Pins<'a>, Built<'a>);

/// The terms that the features of this crate build.
#[cfg(all(feature = "nodal", not(feature = "cut")))]
type Built<'a> = (Nodal<'a>, (Stiffening<'a>, NoTerm));
#[cfg(feature = "cut")]
type Built<'a> = (Nodal<'a>, (Stiffening<'a>, (Lips<'a>, NoTerm)));
#[cfg(not(feature = "nodal"))]
type Built<'a> = NoTerm;

/// The nodal shapes of a body.
#[cfg(all(not(test), any(feature = "cut", feature = "relax")))]
pub(crate) fn shapes<'a>(of: &Others<'a>) -> Nodal<'a> {
    of.0
}
#[cfg(all(test, any(feature = "cut", feature = "relax")))]
pub(crate) fn shapes<'a>(of: &Others<'a>) -> Nodal<'a> {
    of.1.0
}

/// The stiffening bands of a body.
#[cfg(all(not(test), feature = "cut"))]
pub(crate) fn bands<'a>(of: &Others<'a>) -> Stiffening<'a> {
    of.1.0
}
#[cfg(all(test, feature = "cut"))]
pub(crate) fn bands<'a>(of: &Others<'a>) -> Stiffening<'a> {
    of.1.1.0
}

/// The same terms with these nodal shapes.
#[cfg(all(not(test), feature = "relax"))]
pub(crate) fn with_shapes<'a>(of: Others<'a>, shapes: Nodal<'a>) -> Others<'a> {
    let (_, rest) = of;
    (shapes, rest)
}
#[cfg(all(test, feature = "relax"))]
pub(crate) fn with_shapes<'a>(of: Others<'a>, shapes: Nodal<'a>) -> Others<'a> {
    let (pins, (_, rest)) = of;
    (pins, (shapes, rest))
}

/// The same terms with these nodal shapes, bands and lips.
#[cfg(all(not(test), feature = "cut"))]
pub(crate) fn cut<'a>(
    _: Others<'a>,
    shapes: Nodal<'a>,
    bands: Stiffening<'a>,
    lips: Lips<'a>,
) -> Others<'a> {
    (shapes, (bands, (lips, NoTerm)))
}
#[cfg(all(test, feature = "cut"))]
pub(crate) fn cut<'a>(
    (pins, _): Others<'a>,
    shapes: Nodal<'a>,
    bands: Stiffening<'a>,
    lips: Lips<'a>,
) -> Others<'a> {
    (pins, (shapes, (bands, (lips, NoTerm))))
}

/// All terms empty.
#[cfg(all(test, feature = "cut"))]
pub(crate) const NONE: Built<'static> = (Nodal::NONE, (Stiffening::NONE, (Lips::NONE, NoTerm)));
#[cfg(all(test, feature = "nodal", not(feature = "cut")))]
pub(crate) const NONE: Built<'static> = (Nodal::NONE, (Stiffening::NONE, NoTerm));
#[cfg(all(test, not(feature = "nodal")))]
pub(crate) const NONE: Built<'static> = NoTerm;
