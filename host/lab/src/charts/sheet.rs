//! Panels side by side with one colour bar, and the texts around them.

use std::fmt::Write as _;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

use chaincell_host::error::Result;
use chaincell_host::picture::chart::pen::{INK, text, text_upwards};
use chaincell_host::picture::chart::{SIZE_PX, ticks};
use chaincell_host::picture::{Body, Pixels, View, encode, palette, raster, round_length};

use super::plot::Picture;
use super::raster::over;

/// Pixels of the raster for one of the picture, along each axis.
const FINE: u32 = 3;
/// Room around everything, and between panels \[px\].
const MARGIN: u32 = 28;
const GAP: u32 = 20;
/// Heights of the sheet's title and of a panel's \[px\].
const TITLE: u32 = 62;
const SUBTITLE: u32 = 46;
/// Width that the colour bar takes with its texts, and of the bar alone \[px\].
const BAR_ROOM: u32 = 210;
const BAR: u32 = 40;
/// Air around the bodies of a panel \[px\].
const AIR: f64 = 14.0;
/// Width of a line on a surface, in pixels of the raster.
const WIRE: f32 = 3.0;
/// Sizes of texts \[px\].
const LARGE: u32 = 34;
const TEXT: u32 = 29;
/// Longest scale bar as a part of a panel's width.
const SCALE_BAR: f64 = 0.22;

/// What the colours mean.
#[derive(Debug, Clone, PartialEq)]
pub struct ColourBar {
    /// Quantity and unit: `displacement [mm]`.
    pub label: String,
    /// Values at the lower and the upper end.
    pub range: [f64; 2],
}

/// One view of some bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// Text above it.
    pub title: String,
    /// What is shown.
    pub bodies: Vec<Body>,
    /// Centre and radius of a close-up \[m\]; else all panels show everything at one scale.
    pub close_up: Option<([f64; 3], f64)>,
}

/// Panels that share view and colours.
#[derive(Debug, Clone, PartialEq)]
pub struct Sheet {
    /// Text on top.
    pub title: String,
    /// Row by row.
    pub panels: Vec<Panel>,
    /// Panels in a row.
    pub columns: u32,
    /// Height of a panel without its title \[px\].
    pub panel_height_px: u32,
    /// From the bodies to the eye.
    pub towards: [f64; 3],
    /// Upwards.
    pub up: [f64; 3],
    /// What the colours mean.
    pub bar: ColourBar,
}

/// A rectangle \[px\].
#[derive(Clone, Copy)]
struct Place {
    left: u32,
    top: u32,
    width: u32,
    height: u32,
}

impl Sheet {
    /// Draws the sheet. About a second, by the number of pixels rather than of triangles.
    pub fn draw(&self) -> Result<Picture> {
        let rows = (self.panels.len() as u32).div_ceil(self.columns.max(1)).max(1);
        let height = TITLE + rows * (SUBTITLE + self.panel_height_px) + MARGIN;
        let size_px = (SIZE_PX.0, height);
        let mut pixels = Pixels::white(size_px);
        let mut texts = String::new();
        text(&mut texts, (MARGIN.into(), f64::from(TITLE - 18)), LARGE, "start", &self.title);
        for (at, panel) in self.panels.iter().enumerate() {
            let place = self.place(at as u32);
            let view = self.view(panel, place);
            let drawn = raster(&panel.bodies, view, self.bar.range, FINE, WIRE);
            pixels.paste((place.left, place.top), &drawn);
            let above = (f64::from(place.left + place.width / 2), f64::from(place.top - 12));
            text(&mut texts, above, TEXT, "middle", &panel.title);
            scale_bar(&mut texts, place, view.pixels_per_m);
            if panel.close_up.is_some() {
                let Place { left, top, width, height } = place;
                let _ = writeln!(
                    texts,
                    "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" \
                     fill=\"none\" stroke=\"#b0b0b0\" stroke-width=\"2\"/>"
                );
            }
        }
        self.colour_bar(&mut texts, height);
        let open = format!(
            "<svg viewBox=\"0 0 {} {height}\" xmlns=\"http://www.w3.org/2000/svg\">\n",
            size_px.0
        );
        let image = format!(
            "<image x=\"0\" y=\"0\" width=\"{}\" height=\"{height}\" \
             href=\"data:image/png;base64,{}\"/>\n",
            size_px.0,
            STANDARD.encode(encode(&pixels))
        );
        let over = over(&format!("{open}{texts}</svg>"), &pixels)?;
        let svg = format!("{open}{image}{texts}</svg>\n");
        Ok(Picture { svg, png: encode(&over), left_out: 0 })
    }

    fn place(&self, at: u32) -> Place {
        let columns = self.columns.max(1);
        let width = (SIZE_PX.0 - 2 * MARGIN - BAR_ROOM - (columns - 1) * GAP) / columns;
        let top = TITLE + SUBTITLE + at / columns * (SUBTITLE + self.panel_height_px);
        let left = MARGIN + at % columns * (width + GAP);
        Place { left, top, width, height: self.panel_height_px }
    }

    fn view(&self, panel: &Panel, place: Place) -> View {
        let size_px = (place.width, place.height);
        match panel.close_up {
            None => {
                let whole = self.panels.iter().filter(|panel| panel.close_up.is_none());
                let bodies = whole.flat_map(|panel| &panel.bodies);
                let points = bodies.flat_map(|body| &body.points_m);
                View::fit(points, self.towards, self.up, size_px, AIR)
            }
            Some((centre, radius)) => {
                let ends = [-radius, radius].into_iter().flat_map(|r| {
                    (0..3).map(move |axis| {
                        std::array::from_fn(|x| centre[x] + if x == axis { r } else { 0.0 })
                    })
                });
                let ends: Vec<[f64; 3]> = ends.collect();
                View::fit(ends.iter(), self.towards, self.up, size_px, 0.0)
            }
        }
    }

    fn colour_bar(&self, texts: &mut String, height: u32) {
        let long = (height - TITLE - SUBTITLE - MARGIN).min(2 * SIZE_PX.1 / 3);
        let top = TITLE + SUBTITLE + (height - TITLE - SUBTITLE - MARGIN - long) / 2;
        let left = SIZE_PX.0 - MARGIN - BAR_ROOM + 36;
        let steps = 128;
        for step in 0..steps {
            let [r, g, b] = palette::srgb((f64::from(step) + 0.5) / f64::from(steps));
            let y = f64::from(top) + f64::from(long * (steps - 1 - step)) / f64::from(steps);
            // A pixel more, so that no seam shows the ground.
            let high = f64::from(long) / f64::from(steps) + if step > 0 { 1.0 } else { 0.0 };
            let _ = writeln!(
                texts,
                "<rect x=\"{left}\" y=\"{y:.2}\" width=\"{BAR}\" height=\"{high:.2}\" \
                 fill=\"#{r:02x}{g:02x}{b:02x}\"/>"
            );
        }
        let _ = writeln!(
            texts,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{BAR}\" height=\"{long}\" fill=\"none\" \
             stroke=\"{INK}\" stroke-width=\"2\"/>"
        );
        let [from, to] = self.bar.range;
        let right = left + BAR;
        for (value, label) in ticks(self.bar.range, 6) {
            let part = (value - from) / (to - from);
            let y = f64::from(top + long) - part * f64::from(long);
            let _ = writeln!(
                texts,
                "<path d=\"M{right} {y:.1}h10\" stroke=\"{INK}\" stroke-width=\"2\"/>"
            );
            text(texts, (f64::from(right + 18), y + 10.0), TEXT, "start", &label);
        }
        let side = (f64::from(SIZE_PX.0 - MARGIN), f64::from(top + long / 2));
        text_upwards(texts, side, TEXT, &self.bar.label);
    }
}

/// A round length at the lower left of a panel.
fn scale_bar(texts: &mut String, place: Place, pixels_per_m: f64) {
    let (long_m, label) = round_length(SCALE_BAR * f64::from(place.width) / pixels_per_m);
    let long = long_m * pixels_per_m;
    let (x, y) = (place.left + 12, place.top + place.height - 16);
    let _ = writeln!(
        texts,
        "<path d=\"M{x} {}v16h{long:.1}v-16\" fill=\"none\" stroke=\"{INK}\" stroke-width=\"3\"/>",
        y - 8
    );
    text(texts, (x.into(), f64::from(y - 16)), TEXT, "start", &label);
}

#[cfg(test)]
mod tests {
    use super::*;
    use chaincell_host::picture::Paint;

    #[test]
    fn a_sheet_has_its_pixels_and_texts_and_asks_for_nothing() {
        let mut ball = Body::sphere([0.0; 3], 0.05, [0; 3], 12);
        ball.paint = Paint::Values(ball.points_m.iter().map(|p| 1e3 * p[2]).collect());
        let panel =
            |title: &str| Panel { title: title.into(), bodies: vec![ball.clone()], close_up: None };
        let sheet = Sheet {
            title: "a < b".into(),
            panels: vec![panel("one"), panel("two")],
            columns: 2,
            panel_height_px: 400,
            towards: [0.0, -1.0, 0.3],
            up: [0.0, 0.0, 1.0],
            bar: ColourBar { label: "height [mm]".into(), range: [-50.0, 50.0] },
        };
        let drawn = sheet.draw().unwrap();
        assert!(drawn.svg.contains("a &lt; b") && drawn.svg.contains("height [mm]"));
        assert!(drawn.svg.contains(" mm<") && drawn.svg.contains("data:image/png;base64,"));
        let mut decoded = png::Decoder::new(std::io::Cursor::new(&drawn.png)).read_info().unwrap();
        let mut bytes = vec![0; decoded.output_buffer_size().unwrap()];
        let info = decoded.next_frame(&mut bytes).unwrap();
        assert_eq!((info.width, info.height), (SIZE_PX.0, TITLE + SUBTITLE + 400 + MARGIN));
        let pixel = |x: u32, y: u32| {
            let at = 3 * (y * info.width + x) as usize;
            [bytes[at], bytes[at + 1], bytes[at + 2]]
        };
        // A corner is white; the ball is dark on top and light below.
        assert_eq!(pixel(2, 2), [255; 3]);
        let place = sheet.place(1);
        let (x, y) = (place.left + 20 + place.width / 2 - 20, place.top);
        let (top, bottom) = (pixel(x, y + 60), pixel(x, y + 340));
        assert!(top[0] < 110 && bottom[0] > 110, "{top:?} {bottom:?}");
    }
}
