use super::*;

const YOUNG_PA: f64 = 5000.0;
const POISSON: f64 = 0.45;

fn slab([radius_m, height_m]: [f64; 2], law: Law) -> Slab {
    Slab { radius_m, height_m, young_pa: YOUNG_PA, poisson: POISSON, law }
}

/// Hertz on a body far larger than the contact, which gives way a little less than a half space: for
/// a held bottom the force grows by about the circle's radius over the height.
#[test]
fn a_light_touch_is_hertz() {
    let (sphere_m, depth_m) = (0.02, 0.0004);
    for law in [Law::Hooke, Law::NeoHooke] {
        let slab = slab([0.4, 0.4], law);
        let press = press(&slab, sphere_m, sphere_m / 50.0, &[depth_m]).unwrap()[0];
        let modulus = YOUNG_PA / (1.0 - POISSON * POISSON);
        let hertz = 4.0 / 3.0 * modulus * f64::sqrt(sphere_m) * depth_m.powf(1.5);
        let circle = press.contact_m / f64::sqrt(sphere_m * depth_m);
        println!(
            "{law:?}: force {:.4} of Hertz's, circle {circle:.3}, energy {:.4}, penalty gives {:.2} %",
            press.force_n / hertz,
            press.energy_j / (0.4 * hertz * depth_m),
            100.0 * press.into_m / depth_m
        );
        assert!((press.force_n / hertz - 1.0).abs() < 0.02, "{press:?} {hertz}");
        assert!((press.energy_j / (0.4 * hertz * depth_m) - 1.0).abs() < 0.03, "{press:?}");
        assert!((circle - 1.0).abs() < 0.1 && press.into_m < 0.005 * depth_m, "{press:?}");
    }
}

#[test]
fn work_is_stored() {
    let sphere_m = 0.008;
    let steps = 32;
    let depths: Vec<f64> = (1..=steps).map(|k| 0.5 * sphere_m * f64::from(k) / 32.0).collect();
    for law in [Law::Hooke, Law::NeoHooke] {
        let found = press(&slab([0.05, 0.04], law), sphere_m, 0.00125, &depths).unwrap();
        // Simpson's rule.
        let work = found.iter().enumerate().map(|(k, press)| {
            let share = if k + 1 == found.len() { 1.0 } else { [4.0, 2.0][k % 2] };
            share / 3.0 * press.force_n * depths[0]
        });
        let last = found[found.len() - 1];
        let ratio = work.sum::<f64>() / last.energy_j;
        println!("{law:?}: work {ratio:.5} of the energy");
        assert!((ratio - 1.0).abs() < 2e-3, "{ratio}");
    }
}

#[test]
fn finer_elements_and_less_give_change_little() {
    let of = |element_m: f64| {
        let slab = slab([0.05, 0.04], Law::NeoHooke);
        press(&slab, 0.016, element_m, &[0.004, 0.008]).unwrap()
    };
    for (coarse, fine) in of(0.0025).iter().zip(of(0.00125)) {
        assert!((coarse.force_n / fine.force_n - 1.0).abs() < 0.005, "{coarse:?} {fine:?}");
        assert!(fine.into_m < 1e-3 * fine.depth_m);
    }
}

#[test]
fn what_makes_no_sense_is_refused() {
    let slab = slab([0.05, 0.04], Law::NeoHooke);
    assert!(press(&slab, 0.008, 0.0, &[0.001]).is_err());
    assert!(press(&slab, 0.008, 0.002, &[0.002, 0.001]).is_err());
    assert!(press(&Slab { poisson: 0.5, ..slab }, 0.008, 0.002, &[0.001]).is_err());
}
