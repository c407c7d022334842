use super::*;

#[test]
fn the_section_holds_in_the_quick_context() {
    let section = section(&Context { quick: true, reference: None }).unwrap();
    assert_eq!((section.figures.len(), section.tables.len(), section.numbers.len()), (1, 3, 3));
    assert!(section.figures.iter().all(|figure| figure.picture.left_out == 0));
    assert!(section.numbers.iter().all(|numbers| numbers.csv.lines().count() > 3));
}

/// K and `R_x` change no bit within K; beyond it K changes the force.
#[test]
fn saturation_acts_only_when_it_is_reached() {
    let found = Results::run().unwrap();
    assert_eq!(words::hashes(&found.within), 1, "{:?}", found.within);
    let at = |k: f64| found.beyond.iter().find(|range| range.k_of_largest == k).unwrap();
    assert!(at(2.0).force_n < 0.9 * at(8.0).force_n, "{:?}", found.beyond);
    assert_eq!(at(4.0).state_hash, at(8.0).state_hash);
    forces_agree_where_they_must(&found);
    // Stiffness that all links share does not move the cell, only the force.
    for at in found.yields.iter().filter(|at| at.alpha == 0.0) {
        let soft = found.yields.iter().find(|soft| soft.input_m == at.input_m).unwrap();
        assert!((at.displacement_m / soft.displacement_m - 1.0).abs() < 1e-3, "{at:?} {soft:?}");
        assert!(at.displacement_m > at.input_m);
    }
}

fn forces_agree_where_they_must(found: &Results) {
    let [settled, under_way, patch] = found.readings.as_slice() else { panic!("three states") };
    let near = |a: f64, b: f64| (a / b - 1.0).abs() < 2e-3;
    for row in [settled, patch] {
        assert!(near(row.adjustments_n, row.published_n) && near(row.fixed_n, row.published_n));
        assert!(near(row.energy_slope_n, row.published_n), "{row:?}");
    }
    assert!(near(under_way.adjustments_n, under_way.published_n));
    assert!(under_way.energy_slope_n < 0.8 * under_way.published_n);
    assert!(under_way.fixed_n < 0.1 * under_way.published_n);
    assert!(patch.one_cell_n < 0.5 * patch.published_n);
}
