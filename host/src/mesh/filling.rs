//! The sizes of the tetrahedra that fill a closed surface, as an option gives them: `SIZE`, or
//! `SIZE,FINE@WHERE` for smaller ones at a place.

use std::str::FromStr;

/// The form of the option, for error texts.
const FORM: &str = "give SIZE, or SIZE,FINE@X,Y,Z,R in metres, or SIZE,FINE@near:SELECTOR";

/// Most halvings between the two sizes.
pub(crate) const HALVINGS_MAX: f64 = 6.0;
/// Growth of the tetrahedra over the distance from a place: two layers of each size.
pub(crate) const GROWTH: f64 = 0.5;

/// The number of halvings that leads nearest from the coarse size to the fine one.
pub(crate) fn halvings(size_m: f64, fine_m: f64) -> f64 {
    (size_m / fine_m).log2().round()
}

/// Edges of tetrahedra.
#[derive(Debug, Clone, PartialEq)]
pub struct Filling {
    /// Mean edge \[m\]; away from the regions of `finer`, where there are some.
    pub size_m: f64,
    /// Smaller tetrahedra at some places.
    pub finer: Option<Finer>,
}

/// Smaller tetrahedra at some places.
#[derive(Debug, Clone, PartialEq)]
pub struct Finer {
    /// Mean edge there \[m\].
    pub size_m: f64,
    /// The places.
    pub regions: Vec<Region>,
}

/// A place.
#[derive(Debug, Clone, PartialEq)]
pub enum Region {
    /// A ball.
    Ball {
        /// Its middle \[m\].
        centre_m: [f64; 3],
        /// Its radius \[m\].
        radius_m: f64,
    },
    /// Within `size_m` of the nodes that a selector chooses in the body that is filled evenly.
    Near(String),
}

impl Filling {
    /// Edges of one size \[m\] everywhere.
    #[must_use]
    pub fn even(size_m: f64) -> Self {
        Self { size_m, finer: None }
    }
}

impl FromStr for Filling {
    type Err = String;

    /// Reads `SIZE` or `SIZE,FINE@REGION[@REGION...]`; a region is `X,Y,Z,R` or, as the last one,
    /// `near:SELECTOR`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (sizes, regions) = text.split_once('@').map_or((text, None), |(a, b)| (a, Some(b)));
        match (&numbers(sizes)?[..], regions) {
            (&[size_m], None) => Ok(Self::even(size_m)),
            (&[size_m, fine_m], Some(text)) => {
                let finer = Finer { size_m: fine_m, regions: read_regions(text)? };
                Ok(Self { size_m, finer: Some(finer) })
            }
            ([_, _], None) => Err(format!("the second size needs its place: {FORM}")),
            ([_], Some(_)) => Err(format!("a place needs the size there: {FORM}")),
            _ => Err(format!("one size or two: {FORM}")),
        }
    }
}

fn read_regions(mut text: &str) -> Result<Vec<Region>, String> {
    let mut regions = Vec::new();
    loop {
        if let Some(selector) = text.strip_prefix("near:") {
            regions.push(Region::Near(selector.to_owned()));
            return Ok(regions);
        }
        let (first, rest) = text.split_once('@').map_or((text, None), |(a, b)| (a, Some(b)));
        let [x, y, z, radius_m] = numbers(first)?[..] else {
            return Err(format!("'{first}' is no place: {FORM}"));
        };
        regions.push(Region::Ball { centre_m: [x, y, z], radius_m });
        let Some(rest) = rest else { return Ok(regions) };
        text = rest;
    }
}

fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number =
        |word: &str| word.trim().parse().map_err(|_| format!("'{word}' is no number: {FORM}"));
    text.split(',').map(number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_and_places_are_read() {
        assert_eq!("5e-3".parse(), Ok(Filling::even(0.005)));
        let ball = |x, radius_m| Region::Ball { centre_m: [x, 0.0, -1.0], radius_m };
        let near = || Region::Near("file:a@b".into());
        for (text, regions) in [
            ("0.8,0.2@1,0,-1,3", vec![ball(1.0, 3.0)]),
            ("0.8, 0.2@1,0,-1,3@2,0,-1,4", vec![ball(1.0, 3.0), ball(2.0, 4.0)]),
            ("0.8,0.2@1,0,-1,3@near:file:a@b", vec![ball(1.0, 3.0), near()]),
        ] {
            let finer = Some(Finer { size_m: 0.2, regions });
            assert_eq!(text.parse(), Ok(Filling { size_m: 0.8, finer }), "{text}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_named() {
        for (text, part) in [
            ("", "'' is no number"),
            ("5mm", "'5mm' is no number"),
            ("1,2", "needs its place"),
            ("1@0,0,0,1", "needs the size there"),
            ("1,2,3", "one size or two"),
            ("1,0.5@0,0,0", "'0,0,0' is no place"),
            ("1,0.5@box:1", "'box:1' is no number"),
        ] {
            let why = text.parse::<Filling>().unwrap_err();
            assert!(why.contains(part) && why.contains("SIZE,FINE@X,Y,Z,R"), "{text}: {why}");
        }
    }
}
