//! The steps of rotation and shape, for one cell and for eight.

use proptest::prelude::*;

use super::matrix::{Matrix, cofactors, dot, inner, minus};
use super::nearest::{of_unit_volume, rotation, turned};
use crate::backend::f32x8::{F32x8, Lanes8};
use crate::backend::lane::Lane;

/// A matrix of these elements, by rows.
fn of([a, b, c, d, e, f, g, h, i]: [f32; 9]) -> Matrix<f32> {
    [[a, b, c], [d, e, f], [g, h, i]].map(|row| row.map(Lane))
}

fn determinant(m: Matrix<f32>) -> f32 {
    dot(m[0], cofactors(m)[0]).0
}

/// A unit quaternion.
fn turn() -> impl Strategy<Value = [f32; 4]> {
    prop::array::uniform4(-1.0_f32..1.0).prop_filter_map("too short", |q| {
        let size = q.iter().map(|x| x * x).sum::<f32>().sqrt();
        (size > 0.1).then(|| q.map(|x| x / size))
    })
}

/// A matrix of determinant 1.
fn unit() -> impl Strategy<Value = Matrix<f32>> {
    prop::array::uniform9(-1.5_f32..1.5).prop_filter_map("flat", |m| {
        let det = determinant(of(m));
        (det > 0.2).then(|| of(m.map(|x| x / det.cbrt())))
    })
}

fn eight(m: Matrix<f32>) -> Matrix<Lanes8> {
    m.map(|row| row.map(|x| Lane(Lanes8::splat(x.0))))
}

fn distance(a: Matrix<f32>, b: Matrix<f32>) -> f32 {
    let off = minus(a, b);
    inner(off, off).0.sqrt()
}

proptest! {
    /// The step never rotates away from the shape, also from an inverted one, and the quaternion stays a
    /// unit.
    #[test]
    fn a_step_turns_towards_the_shape(f in prop::array::uniform9(-2.0_f32..2.0), q in turn()) {
        let (f, q) = (of(f), q.map(Lane));
        let next = turned(f, q);
        let (before, after) = (inner(rotation(q), f).0, inner(rotation(next), f).0);
        let room = 4.0 * f32::EPSILON * inner(f, f).0.sqrt();
        prop_assert!(after >= before - room, "{before} {after}");
        let size = next.iter().map(|x| x.0 * x.0).sum::<f32>();
        prop_assert!((size - 1.0).abs() < 1e-6);
        let wide = turned(eight(f), q.map(|x| Lane(Lanes8::splat(x.0))));
        for (one, eight) in next.iter().zip(wide) {
            prop_assert_eq!(one.0.to_bits(), eight.0.0[3].to_bits());
        }
    }

    /// The step never increases the distance from the shape, keeps the volume, and returns the distance.
    #[test]
    fn a_step_of_unit_volume_leads_nearer(f in prop::array::uniform9(-2.0_f32..2.0), q in unit()) {
        let f = of(f);
        let (next, squared) = of_unit_volume(f, q);
        prop_assert!(distance(f, next) <= distance(f, q) * 1.000_001);
        prop_assert!((squared.0.sqrt() - distance(f, next)).abs() < 1e-5);
        let taken = next != q;
        prop_assert!(!taken || (determinant(next) - 1.0).abs() < 2e-5, "{}", determinant(next));
        let (wide, wide_squared) = of_unit_volume(eight(f), eight(q));
        prop_assert_eq!(squared.0.to_bits(), wide_squared.0.0[7].to_bits());
        for (one, eight) in next.iter().flatten().zip(wide.iter().flatten()) {
            prop_assert_eq!(one.0.to_bits(), eight.0.0[5].to_bits());
        }
    }

    /// Near rest a few steps find the nearest rotation and the nearest shape of unit volume.
    #[test]
    fn steps_settle(small in prop::array::uniform9(-0.1_f32..0.1), q in turn()) {
        let r = rotation(q.map(Lane));
        let matrix = |of: &dyn Fn(usize, usize) -> f32| -> Matrix<f32> {
            std::array::from_fn(|i| std::array::from_fn(|j| Lane(of(i, j))))
        };
        let stretch = matrix(&|i, j| {
            let own = small[3 * i + j] + small[3 * j + i];
            if i == j { 1.0 + own } else { own }
        });
        // F = R S with S symmetric: R is the nearest rotation.
        let f = matrix(&|i, j| dot(r[i], [stretch[0][j], stretch[1][j], stretch[2][j]]).0);
        let (mut turn, mut unit) = (q.map(|x| Lane(x + 0.01)), r);
        for _ in 0..12 {
            turn = turned(f, turn);
            unit = of_unit_volume(f, unit).0;
        }
        prop_assert!(distance(rotation(turn), r) < 1e-4);
        // At the nearest shape F - Q is a multiple of Q's cofactors. The remainder is the square root of the
        // distance error that one last place of the determinant causes.
        let (off, normal) = (minus(f, unit), cofactors(unit));
        let share = inner(off, normal).0 / inner(normal, normal).0;
        let left = matrix(&|i, j| off[i][j].0 - share * normal[i][j].0);
        let left = inner(left, left).0.sqrt();
        prop_assert!(left < 1e-3, "{left}");
    }
}

#[test]
fn at_rest_nothing_changes() {
    let one = of([1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let turn = [1.0, 0.0, 0.0, 0.0].map(Lane);
    assert_eq!(turned(one, turn), turn);
    assert_eq!(of_unit_volume(one, one), (one, Lane(0.0)));
    assert_eq!(rotation(turn), one);
}

/// K times a displacement along one axis, cell by cell, is that of all axes together.
#[cfg(feature = "cut")]
#[test]
fn a_push_along_an_axis_is_that_of_all_axes() {
    use crate::model::{Model, others};
    use crate::number::cell::{Cell, add};

    let image = crate::include_model!("../../../../tests/data/tissue6.chaincell");
    let model = Model::from_bytes(image).unwrap();
    let shapes = others::shapes(&model.others);
    let length = |cell: usize| (cell * 37 % 17) as f32 * 0.1 - 0.5;
    for axis in 0..3 {
        let field =
            |cell: usize| core::array::from_fn(|at| if at == axis { length(cell) } else { 0.0 });
        let field: std::vec::Vec<Cell> =
            (0..model.cells()).map(|cell| Cell::at(field(cell))).collect();
        let mut expected = std::vec![Cell::ZERO; model.cells()];
        shapes.add_resistance(&field, &mut expected);
        let mut pushes = std::vec![[0.0; 3]; model.cells()];
        for cell in 0..model.cells() {
            shapes.resist_along(cell, axis, &length, &mut |to, push| {
                pushes[to] = add(pushes[to], push);
            });
        }
        let largest =
            expected.iter().flat_map(|cell| cell.xyz()).fold(0.0_f32, |a, b| a.max(b.abs()));
        for (push, expected) in pushes.iter().zip(&expected) {
            for (a, b) in push.iter().zip(expected.xyz()) {
                assert!(largest > 0.1 && (a - b).abs() < 1e-5 * largest, "{a} {b} of {largest}");
            }
        }
    }
}
