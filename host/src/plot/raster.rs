//! From SVG to PNG, with the font that comes along.

use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

use super::SIZE_PX;
use crate::error::{Error, Result};

/// The document as PNG of [`SIZE_PX`].
pub(super) fn png(svg: &str) -> Result<Vec<u8>> {
    let options = Options { fontdb: fonts(), ..Options::default() };
    let tree =
        Tree::from_str(svg, &options).map_err(|why| Error::check(format!("picture: {why}")))?;
    let mut pixels = Pixmap::new(SIZE_PX.0, SIZE_PX.1)
        .ok_or_else(|| Error::check("picture: no memory for its pixels"))?;
    resvg::render(&tree, Transform::identity(), &mut pixels.as_mut());
    pixels.encode_png().map_err(|why| Error::check(format!("picture: {why}")))
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
