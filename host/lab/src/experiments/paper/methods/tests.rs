//! What the text claims, held against the figures.

use std::sync::LazyLock;

use super::*;
use method::Kind;

static PLANE: LazyLock<Comparison> =
    LazyLock::new(|| Comparison::new(Body::plane().unwrap(), 1).unwrap());

fn row(of: &Comparison, kind: Kind) -> &Row {
    of.rows.iter().find(|row| row.method == kind).unwrap()
}

#[test]
fn the_plane_is_as_the_text_says() {
    let plane = &*PLANE;
    let bent = |kind| row(plane, kind).nonlinearity.unwrap();
    let exact = measure::of_plane(&plane.body, &plane.exact).unwrap().unwrap();
    assert!(bent(Kind::Lattice) < 1e-12 && exact > 0.05);
    for settled in [Kind::Track, Kind::MassSpring] {
        assert!((bent(settled) - exact).abs() < 1e-4);
        assert!(row(plane, settled).off_minimum < 1e-4);
        let force = row(plane, settled).force_n.unwrap() / plane.body.force_n(&plane.exact);
        assert!((force - 1.0).abs() < 1e-4, "{force}");
    }
    for on_its_way in [Kind::Euler, Kind::PositionBased] {
        assert!(bent(on_its_way) > 2.0 * exact && row(plane, on_its_way).off_minimum > 0.1);
    }
    assert!(row(plane, Kind::Graph).turned < 1e-4);
    assert!(bent(Kind::Graph) > exact && row(plane, Kind::Graph).off_minimum > 0.05);
    assert!(row(plane, Kind::Euler).force_n > row(plane, Kind::Track).force_n);
    for chain in [Kind::Lattice, Kind::Graph] {
        assert_eq!(row(plane, chain).force_n, None);
    }
    let (chain, track) = (row(plane, Kind::Lattice), row(plane, Kind::Track));
    assert!(chain.visited_per_tick < track.visited_per_tick && chain.turned > 0.1);
    assert_eq!(track.visited_per_tick, usize::from(SWEEPS) * 441);
    assert!(track.turned < 1e-4 && row(plane, Kind::Euler).turned < 1e-4);
    for row in &plane.rows {
        assert!(row.repeats, "{:?}", row.method);
        assert_eq!(row.at_most_once, row.method == Kind::Lattice);
    }
}

#[test]
fn energy_on_the_box() {
    let cuboid = Comparison::new(Body::cuboid().unwrap(), 1).unwrap();
    for network in [Kind::Euler, Kind::Track] {
        let row = row(&cuboid, network);
        assert!(row.energy_rise.max(row.energy_rise_sudden) < 1e-7, "{row:?}");
    }
    for other in [Kind::Graph, Kind::MassSpring] {
        assert!(row(&cuboid, other).energy_rise_sudden > 1e-6);
    }
    assert!(row(&PLANE, Kind::Graph).energy_rise > 0.1);
    assert!(cuboid.rows.iter().all(|row| row.nonlinearity.is_none()));
}

/// Ratios are to `track` of the same run.
#[test]
fn times_are_ratios_to_track() {
    let mut rows = PLANE.rows.clone();
    measure::time(&PLANE.body, &mut rows, 1).unwrap();
    assert!(rows.iter().all(|row| row.tick_ns_p50.is_some_and(|ns| ns > 0)));
    let track = rows.iter().find(|row| row.method == Kind::Track).unwrap();
    assert_eq!(track.time_ratio, Some(1.0));
}

#[test]
fn the_section_is_whole() {
    let section = section(&Context { quick: true, ..Context::default() }).unwrap();
    assert_eq!((section.tables.len(), section.figures.len(), section.text.len()), (2, 1, 3));
    for (_, table) in &section.tables {
        assert_eq!(table.markdown().lines().count(), 2 + Kind::ALL.len() + 1);
    }
    let picture = &section.figures[0].picture;
    assert!(picture.left_out == 0 && picture.png.len() > 10_000);
    assert!(picture.svg.contains("generalised ChainMail"));
    let methods = section.json["plane"]["methods"].as_array().unwrap();
    assert_eq!(methods.len(), Kind::ALL.len());
    assert!(methods[2]["force_n"].is_null() && methods[1]["force_n"].as_f64().unwrap() > 0.0);
    for numbers in &section.numbers {
        let mut widths = numbers.csv.lines().map(|line| line.split(',').count());
        let first = widths.next().unwrap();
        assert!(first > 2 && widths.all(|width| width == first), "{}", numbers.name);
    }
}
