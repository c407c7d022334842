use super::*;
use crate::reference::Npz;

/// The findings of the report, on the quick bodies.
#[test]
fn the_section_holds_in_the_quick_context() {
    let section = section(&Context { quick: true, ..Context::default() }).unwrap();
    assert_eq!((section.figures.len(), section.tables.len(), section.numbers.len()), (8, 2, 8));
    assert!(section.figures.iter().all(|figure| figure.picture.left_out == 0));
    let number = |at: &str| section.json.pointer(at).and_then(Value::as_f64).unwrap();
    // Geometry makes the plane cubic, and a straight chain to the border goes taut where it must.
    let plane = "/bodies/0/cases";
    let exponent = number(&format!("{plane}/0/compression/nonlinearity_exponent"));
    assert!((2.6..3.1).contains(&exponent), "{exponent}");
    assert_eq!(number(&format!("{plane}/0/slack_m")), 0.0);
    for (at, alpha) in ALPHAS.into_iter().enumerate().skip(1) {
        let (slack, taut) =
            (number(&format!("{plane}/{at}/slack_m")), 0.1 * (alpha * (2.0 + alpha)).sqrt());
        assert!((slack - taut).abs() < 1.1 * 0.1 / 25.0, "alpha {alpha}: {slack} {taut}");
        // Restored links give back more than the tool gave; the difference is what they were given.
        let area = number(&format!("{plane}/{at}/loop_area_j"));
        assert!(area < 0.0 && -area < number(&format!("{plane}/{at}/band_energy_j")) * 1.2);
    }
    // A solid body softens.
    assert!(number("/bodies/1/cases/0/compression/nonlinearity_exponent") < 1.0);
    for body in 0..2 {
        let elastic = format!("/bodies/{body}/cases/0");
        let (area, work) = (
            number(&format!("{elastic}/loop_area_j")),
            number(&format!("{elastic}/loading_work_j")),
        );
        assert!(area.abs() < 1e-3 * work, "{area} {work}");
        // Speed makes a loop in the sense of tissue.
        assert!(
            number(&format!("/bodies/{body}/speeds_at_alpha_0/0/loop_area_of_loading_work")) > 0.1
        );
        let (first, minimum) = (
            number(&format!("{elastic}/relaxation/first_n")),
            number(&format!("{elastic}/relaxation/minimum_n")),
        );
        assert!(first > 1.2 * minimum && minimum > 0.0);
        assert!(number(&format!("/bodies/{body}/relaxation_error_against_exact")) < 0.02);
    }
}

/// Euler's force in seconds against trajectories of another code, F = sum of mu (`P_j` - `P_c`).
#[test]
fn relaxation_is_that_of_the_reference() {
    let Some(folder) = std::env::var_os("CHAINCELL_REFERENCE") else {
        println!("SKIPPED: CHAINCELL_REFERENCE names no folder of reference data");
        return;
    };
    let body = Source::plane(true).unwrap().with_alpha(0.0).unwrap();
    let two_k = 2.0 * f64::from(body.model().unwrap().stiffness_n_per_m());
    for (name, depth_m) in [("flow_c8_a000_d010", 0.01), ("flow_c8_a000_d050", 0.05)] {
        let path = std::path::Path::new(&folder).join(format!("plane/{name}.npz"));
        let mut data = Npz::open(&path).unwrap();
        let (t, force) = (data.reals("t").unwrap(), data.reals("F").unwrap());
        let force_n = if force.len() == 3 * t.len() {
            force.as_chunks::<3>().0.iter().map(|f| two_k * f[2].abs()).collect::<Vec<f64>>()
        } else {
            force.iter().map(|f| two_k * f.abs()).collect()
        };
        let found = relax(&body, depth_m, 2.0, TIME_CONSTANT_S).unwrap();
        let mut compared = 0;
        for (t_s, force_n) in t.iter().map(|t| t * TIME_CONSTANT_S).zip(force_n) {
            let Some(ours) = interpolate(&found.curve, t_s).filter(|_| t_s >= 0.005) else {
                continue;
            };
            assert!((ours / force_n - 1.0).abs() < 0.01, "{name} {t_s} s: {ours} {force_n}");
            compared += 1;
        }
        println!("{name}: {compared} moments");
        assert!(compared > 5, "{compared}");
    }
}
