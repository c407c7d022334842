//! From SVG to PNG, with the font that comes along.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::SIZE_PX;
use crate::charts::pen;
use chaincell_host::error::{Error, Result};

/// The document as PNG of [`SIZE_PX`].
pub(super) fn png(svg: &str) -> Result<Vec<u8>> {
    let mut pixels = blank(SIZE_PX)?;
    draw(svg, &mut pixels)?;
    pixels.encode_png().map_err(|why| Error::check(format!("picture: {why}")))
}

/// The document drawn over opaque `pixels` (sRGB, row by row) of its own size.
pub(crate) fn over(svg: &str, size_px: (u32, u32), pixels: &[[u8; 3]]) -> Result<Vec<[u8; 3]>> {
    let mut drawn = blank(size_px)?;
    for (to, from) in drawn.data_mut().chunks_exact_mut(4).zip(pixels) {
        to.copy_from_slice(&[from[0], from[1], from[2], u8::MAX]);
    }
    draw(svg, &mut drawn)?;
    Ok(drawn.data().chunks_exact(4).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect())
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

/// Width of a text \[px\], 0 of none.
pub(super) fn text_width(text: &str, size: u32) -> Result<f64> {
    let mut svg =
        String::from("<svg width=\"9\" height=\"9\" xmlns=\"http://www.w3.org/2000/svg\">");
    pen::text(&mut svg, (0.0, 0.0), size, "start", text);
    Ok(tree(&(svg + "</svg>"))?.root().bounding_box().width().into())
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
