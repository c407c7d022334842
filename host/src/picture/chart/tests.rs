use proptest::prelude::*;

use super::*;

fn count(picture: &Drawn, what: &str) -> usize {
    picture.svg.matches(what).count()
}

#[test]
fn every_point_and_every_text_is_drawn() {
    let points = [[1.0, 2.0], [2.0, 3.0], [3.0, 5.0]];
    let axes = || (Axis::linear("time [ms] & more"), Axis::linear("error [%]"));
    let chart = |style| {
        let (x, y) = axes();
        Chart::new("A title", x, y).series("a series", style, &points)
    };
    let marked = chart(Style::Markers).draw();
    // One more in the legend.
    assert_eq!((count(&marked, "<polygon"), marked.left_out), (points.len() + 1, 0));
    for text in ["A title", "time [ms] &amp; more", "error [%]", "a series"] {
        assert_eq!(count(&marked, &format!(">{text}<")), 1, "{text} in {}", marked.svg);
    }
    let line = chart(Style::Line).draw();
    let longest = line
        .svg
        .split("points=\"")
        .map(|rest| rest.split('"').next().unwrap_or_default().split_whitespace().count());
    assert_eq!((longest.max(), count(&line, "<polygon")), (Some(points.len()), 0));
    let guide = chart(Style::Line).vertical(2.5, "budget").horizontal(4.0, "bound").draw();
    assert_eq!((count(&guide, ">budget<"), count(&guide, ">bound<")), (1, 1));
}

#[test]
fn what_has_no_place_is_left_out_and_counted() {
    let points =
        [[1.0, 2.0], [f64::NAN, 1.0], [2.0, f64::INFINITY], [-1.0, 1.0], [0.0, 3.0], [9.0, 4.0]];
    let log = Chart::new("t", Axis::log10("x"), Axis::linear("y"));
    let picture = log.series("s", Style::Markers, &points).draw();
    assert_eq!((picture.left_out, count(&picture, "<polygon")), (4, 2 + 1));
}

#[test]
fn an_empty_chart_and_absurd_numbers_are_drawn() {
    let empty = Chart::new("t", Axis::log10("x"), Axis::linear("y")).draw();
    assert_eq!(empty.left_out, 0);
    let far = [[1e-300, -1e149], [1e149, 1e149], [1e-320, 1e300]];
    let chart = Chart::new("t", Axis::log10("x"), Axis::linear("y"));
    assert_eq!(chart.series("s", Style::Dashed, &far).draw().left_out, 1);
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
        let (svg, left_out) = draw::svg(&chart.series("", Style::Markers, &points));
        prop_assert_eq!(svg.matches("<polygon").count() + left_out, points.len());
    }
}

/// A legend can be read: no two of thirty series have the colour and the shape of each other.
#[test]
fn no_marker_comes_twice() {
    let axes = (Axis::linear("x"), Axis::linear("y"));
    let chart = Chart::new("t", axes.0, axes.1);
    let label = |at: usize| format!("line {at}");
    let chart = (0..30).fold(chart, |chart, at| {
        // Outside of the axes: the legend alone has markers.
        chart.series(&label(at), Style::Markers, &[[f64::NAN, f64::NAN]])
    });
    let (svg, _) = draw::svg(&chart);
    // Moved to the same place, equal markers are equal.
    let marker = |line: &str| {
        let (points, rest) = line.strip_prefix("<polygon points=\"")?.split_once('"')?;
        let places: Vec<f64> = points.split([',', ' ']).map(|x| x.parse().unwrap()).collect();
        let (x, y) = (places[0], places[1]);
        let shape = places
            .chunks(2)
            .map(|at| format!("{},{} ", (at[0] - x).round() as i32, (at[1] - y).round() as i32));
        Some(shape.collect::<String>() + rest)
    };
    let markers: Vec<String> = svg.lines().filter_map(marker).collect();
    let different: std::collections::BTreeSet<&String> = markers.iter().collect();
    assert_eq!((markers.len(), different.len()), (30, 30));
}

/// On a dark screen the document has other colours, and nothing else changes.
#[test]
fn a_dark_screen_has_its_colours() {
    let chart = Chart::new("t", Axis::linear("x"), Axis::linear("y"));
    let drawn = chart.series("s", Style::Line, &[[0.0, 1.0], [1.0, 2.0]]).draw();
    let both = drawn.in_both_lights();
    let (before, rest) = both.split_once("<style>").unwrap();
    let (style, after) = rest.split_once("</style>\n").unwrap();
    assert_eq!(format!("{before}{after}"), drawn.svg);
    assert!(before.starts_with("<svg") && style.contains("prefers-color-scheme: dark"));
    for class in ["ink", "paper", "grid"] {
        assert!(
            after.contains(&format!("class=\"{class}\"")) && style.contains(&format!(".{class} "))
        );
    }
}
