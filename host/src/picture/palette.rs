//! From a value to a colour, and between sRGB and amounts of light.

use std::sync::OnceLock;

/// Colours of the map.
const ENTRIES: usize = 256;
/// Amounts of light between black and white of which the byte is kept.
const SHADES: usize = 1 << 14;

/// Magma (van der Walt and Smith 2015) from its light end on, evenly: uniform to the eye and falling in
/// lightness, so that it survives grey; without its ends, on which shading would be lost \[sRGB\].
pub const MAGMA: [[u8; 3]; 17] = [
    [252, 239, 177],
    [254, 215, 153],
    [254, 192, 133],
    [254, 168, 115],
    [252, 143, 101],
    [249, 120, 93],
    [241, 96, 93],
    [227, 78, 101],
    [208, 65, 111],
    [188, 57, 120],
    [167, 49, 125],
    [146, 43, 129],
    [125, 35, 130],
    [105, 28, 129],
    [85, 20, 125],
    [64, 15, 115],
    [42, 17, 92],
];

/// sRGB of a part from 0 to 1, light to dark. A part that is not a number is grey.
#[must_use]
pub fn srgb(part: f64) -> [u8; 3] {
    if part.is_nan() {
        return [128; 3];
    }
    let place = part.clamp(0.0, 1.0) * (MAGMA.len() - 1) as f64;
    let (from, share) = (place.floor(), place.fract());
    let at = from as usize;
    let (low, high) = (MAGMA[at], MAGMA[(at + 1).min(MAGMA.len() - 1)]);
    std::array::from_fn(|x| {
        (f64::from(low[x]) + share * (f64::from(high[x]) - f64::from(low[x]))).round() as u8
    })
}

/// The same as amounts of light.
pub(super) fn light(part: f64) -> [f32; 3] {
    static TABLE: OnceLock<Vec<[f32; 3]>> = OnceLock::new();
    let last = (ENTRIES - 1) as f64;
    let entry = |at: usize| linear(srgb(at as f64 / last));
    let table = TABLE.get_or_init(|| (0..ENTRIES).map(entry).collect());
    let at = (part.clamp(0.0, 1.0) * last).round();
    if at.is_nan() { linear([128; 3]) } else { table[at as usize] }
}

/// Amounts of light of an sRGB colour.
pub(super) fn linear(colour: [u8; 3]) -> [f32; 3] {
    colour.map(|byte| {
        let c = f32::from(byte) / 255.0;
        if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) }
    })
}

/// sRGB of amounts of light; more than white is white.
pub(super) fn encode(light: [f32; 3]) -> [u8; 3] {
    static TABLE: OnceLock<Vec<u8>> = OnceLock::new();
    let last = (SHADES - 1) as f32;
    let entry = |at: usize| {
        let c = at as f32 / last;
        let s = if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 };
        (255.0 * s).round() as u8
    };
    let table = TABLE.get_or_init(|| (0..SHADES).map(entry).collect());
    light.map(|c| table[(c.clamp(0.0, 1.0) * last + 0.5) as usize])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back_from_their_light() {
        for byte in 0..=255 {
            assert_eq!(encode(linear([byte; 3])), [byte; 3]);
        }
    }

    #[test]
    fn the_map_has_its_ends_and_falls_in_lightness() {
        assert_eq!((srgb(0.0), srgb(1.0)), ([252, 239, 177], [42, 17, 92]));
        assert_eq!((srgb(-1.0), srgb(2.0), srgb(f64::NAN)), (srgb(0.0), srgb(1.0), [128; 3]));
        let grey = |part: f64| {
            let [r, g, b] = light(part);
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        let falls = (1..=32).all(|at| grey(f64::from(at) / 32.0) < grey(f64::from(at - 1) / 32.0));
        assert!(falls);
    }
}
