//! From SVG to PNG, with the font that comes along.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use chaincell_host::error::{Error, Result};
use chaincell_host::picture::Pixels;
use chaincell_host::picture::chart::SIZE_PX;

/// The document as PNG of [`SIZE_PX`].
pub(super) fn png(svg: &str) -> Result<Vec<u8>> {
    let mut pixels = blank(SIZE_PX)?;
    draw(svg, &mut pixels)?;
    pixels.encode_png().map_err(|why| Error::check(format!("picture: {why}")))
}

/// The document drawn over opaque pixels of its own size.
pub(super) fn over(svg: &str, under: &Pixels) -> Result<Pixels> {
    let mut drawn = blank(under.size_px)?;
    for (to, from) in drawn.data_mut().chunks_exact_mut(4).zip(&under.rgb) {
        to.copy_from_slice(&[from[0], from[1], from[2], u8::MAX]);
    }
    draw(svg, &mut drawn)?;
    let rgb = drawn.data().chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
    Ok(Pixels { size_px: under.size_px, rgb })
}

fn blank((width, height): (u32, u32)) -> Result<Pixmap> {
    Pixmap::new(width, height).ok_or_else(|| Error::check("picture: no memory for its pixels"))
}

fn draw(svg: &str, pixels: &mut Pixmap) -> Result<()> {
    resvg::render(&tree(svg)?, Transform::identity(), &mut pixels.as_mut());
    Ok(())
}

fn tree(svg: &str) -> Result<Tree> {
    let options = Options { fontdb: fonts(), ..Options::default() };
    Tree::from_str(svg, &options).map_err(|why| Error::check(format!("picture: {why}")))
}

fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    let load = || {
        let mut fonts = fontdb::Database::new();
        fonts.load_font_data(dejavu::sans::regular().to_vec());
        fonts.set_sans_serif_family("DejaVu Sans");
        Arc::new(fonts)
    };
    FONTS.get_or_init(load).clone()
}

#[cfg(test)]
mod tests {
    use chaincell_host::picture::chart::pen::{text, text_width};

    use super::*;

    /// The widths that charts reckon with are those of the font, rounding aside.
    #[test]
    fn texts_are_as_wide_as_charts_reckon() {
        for word in ["time of the tick [us]", "WWWiii", "0.25", "error of the force [%]"] {
            let mut svg =
                String::from("<svg width=\"9\" height=\"9\" xmlns=\"http://www.w3.org/2000/svg\">");
            text(&mut svg, (0.0, 0.0), 29, "start", word);
            let drawn: f64 = tree(&(svg + "</svg>")).unwrap().root().bounding_box().width().into();
            let reckoned = text_width(word, 29);
            assert!(
                drawn <= 1.005 * reckoned && drawn > 0.9 * reckoned,
                "{word}: {drawn} {reckoned}"
            );
        }
    }
}
