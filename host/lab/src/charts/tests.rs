use proptest::prelude::*;
use resvg::tiny_skia::Pixmap;

use super::*;

fn count(picture: &Picture, what: &str) -> usize {
    picture.svg.matches(what).count()
}

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
fn every_point_and_every_text_is_drawn() {
    let points = [[1.0, 2.0], [2.0, 3.0], [3.0, 5.0]];
    let axes = || (Axis::linear("time [ms] & more"), Axis::linear("error [%]"));
    let chart = |style| {
        let (x, y) = axes();
        Chart::new("A title", x, y).series("a series", style, &points)
    };
    let marked = chart(Style::Markers).draw().unwrap();
    // One more in the legend.
    assert_eq!((count(&marked, "<polygon"), marked.left_out), (points.len() + 1, 0));
    for text in ["A title", "time [ms] &amp; more", "error [%]", "a series"] {
        assert_eq!(count(&marked, &format!(">{text}<")), 1, "{text} in {}", marked.svg);
    }
    let line = chart(Style::Line).draw().unwrap();
    let longest = line
        .svg
        .split("points=\"")
        .map(|rest| rest.split('"').next().unwrap_or_default().split_whitespace().count());
    assert_eq!((longest.max(), count(&line, "<polygon")), (Some(points.len()), 0));
    let guide = chart(Style::Line).vertical(2.5, "budget").horizontal(4.0, "bound").draw().unwrap();
    assert_eq!((count(&guide, ">budget<"), count(&guide, ">bound<")), (1, 1));
}

#[test]
fn what_has_no_place_is_left_out_and_counted() {
    let points =
        [[1.0, 2.0], [f64::NAN, 1.0], [2.0, f64::INFINITY], [-1.0, 1.0], [0.0, 3.0], [9.0, 4.0]];
    let log = Chart::new("t", Axis::log10("x"), Axis::linear("y"));
    let picture = log.series("s", Style::Markers, &points).draw().unwrap();
    assert_eq!((picture.left_out, count(&picture, "<polygon")), (4, 2 + 1));
}

#[test]
fn an_empty_chart_and_absurd_numbers_are_drawn() {
    let empty = Chart::new("t", Axis::log10("x"), Axis::linear("y")).draw().unwrap();
    assert_eq!(empty.left_out, 0);
    let far = [[1e-300, -1e149], [1e149, 1e149], [1e-320, 1e300]];
    let chart = Chart::new("t", Axis::log10("x"), Axis::linear("y"));
    assert_eq!(chart.series("s", Style::Dashed, &far).draw().unwrap().left_out, 1);
}

#[test]
fn files_appear_and_the_png_shows_the_text() {
    let place = tempfile::tempdir().unwrap();
    let folder = Folder::open(place.path(), false).unwrap();
    let picture = example().draw().unwrap();
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

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn any_numbers_are_drawn_or_counted(
        points in prop::collection::vec([prop::num::f64::ANY, prop::num::f64::ANY], 0..20),
        logs in any::<[bool; 2]>(),
    ) {
        let axis = |log: bool| if log { Axis::log10("a") } else { Axis::linear("a") };
        let chart = Chart::new("t", axis(logs[0]), axis(logs[1]));
        let (svg, left_out) = draw::svg(&chart.series("", Style::Markers, &points)).unwrap();
        prop_assert_eq!(svg.matches("<polygon").count() + left_out, points.len());
    }
}
