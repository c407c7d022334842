use resvg::tiny_skia::Pixmap;

use chaincell_host::files::output::Folder;

use super::plot::{Axis, Chart, Picture, Style};
use super::raster;
use chaincell_host::picture::chart::SIZE_PX;

fn example() -> Chart {
    let track = [[57.0, 31.0], [114.0, 9.0], [228.0, 2.0], [456.0, 0.4], [912.0, 0.09]];
    let coarse = [[160.0, 1.5], [320.0, 0.8], [640.0, 0.02]];
    let euler = [[55.0, 60.0], [110.0, 45.0], [220.0, 33.0], [440.0, 24.0], [880.0, 17.0]];
    let xpbd = [[390.0, 55.0], [1560.0, 54.0]];
    let rkl: Vec<[f64; 2]> =
        (0..60).map(|n| [60.0 * 1.05_f64.powi(n), 40.0 / f64::from(n + 1)]).collect();
    Chart::new(
        "Liver, a press of 3 link lengths in 300 ms: error over time",
        Axis::log10("time of the tick, 99th percentile [\u{b5}s]"),
        Axis::log10("error of the contact force [%]"),
    )
    .series("track", Style::MarkedLine, &track)
    .series("track with a coarse level of 320 coarse functions", Style::MarkedLine, &coarse)
    .series("euler", Style::MarkedLine, &euler)
    .series("XPBD, links in their order", Style::Markers, &xpbd)
    .series("rkl2", Style::Dashed, &rkl)
    .vertical(1000.0, "1 ms budget")
    .horizontal(7.0, "7 %: just noticeable")
}

#[test]
fn files_appear_and_the_png_shows_the_text() {
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::open(place.path(), false).unwrap();
    let picture = Picture::of(&example()).unwrap();
    assert_eq!(picture.left_out, 0);
    picture.write(&folder, "chart").unwrap();
    let png = Pixmap::decode_png(&std::fs::read(folder.file("chart.png")).unwrap()).unwrap();
    assert_eq!((png.width(), png.height()), SIZE_PX);
    let dark = |png: &Pixmap| png.pixels().iter().filter(|pixel| pixel.red() < 100).count();
    let svg = std::fs::read_to_string(folder.file("chart.svg")).unwrap();
    let (before, rest) = svg.split_once("<text").unwrap();
    let without: String =
        rest.split("<text").map(|part| part.split_once("</text>").unwrap().1).collect();
    let bare = Pixmap::decode_png(&raster::png(&format!("{before}{without}")).unwrap()).unwrap();
    assert!(dark(&png) > dark(&bare) + 5_000, "{} {}", dark(&png), dark(&bare));
}
