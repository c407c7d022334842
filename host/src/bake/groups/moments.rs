//! Moments of a link's direction: its energy under a homogeneous strain depends on that of fourth
//! order, its force on that of third order.

/// A symmetric tensor of fourth order, scaled so that the inner product equals that of the full tensors.
pub type Fourth = [f64; 15];

/// A symmetric tensor of third order, scaled in the same way.
pub type Third = [f64; 10];

/// Returns n n n n of a unit vector: its length is 1, and the inner product of two is (n . m)^4.
pub fn fourth(n: [f64; 3]) -> Fourth {
    of_order(4, n)
}

/// Returns n n n of a unit vector: the inner product of two is (n . m)^3.
pub fn third(n: [f64; 3]) -> Third {
    of_order(3, n)
}

fn of_order<const COMPONENTS: usize>(order: u8, n: [f64; 3]) -> [f64; COMPONENTS] {
    let exponents = (0..=order).flat_map(|x| (0..=order - x).map(move |y| [x, y, order - x - y]));
    let mut moment = [0.0; COMPONENTS];
    for (component, exponents) in moment.iter_mut().zip(exponents) {
        let arrangements =
            exponents.iter().fold(factorial(order), |left, &count| left / factorial(count));
        let product: f64 = n.iter().zip(exponents).map(|(&x, count)| power(x, count)).product();
        *component = arrangements.sqrt() * product;
    }
    moment
}

/// Inner product.
pub fn dot<const N: usize>(a: &[f64; N], b: &[f64; N]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a += s b`.
pub fn add<const N: usize>(a: &mut [f64; N], s: f64, b: &[f64; N]) {
    for (a, b) in a.iter_mut().zip(b) {
        *a += s * b;
    }
}

fn power(x: f64, n: u8) -> f64 {
    (0..n).fold(1.0, |product, _| product * x)
}

fn factorial(n: u8) -> f64 {
    (1..=n).map(f64::from).product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_product_of_two_directions_is_a_power_of_their_cosine() {
        let (a, b) = ([0.6, 0.0, 0.8], [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0]);
        let cosine: f64 = (0..3).map(|axis| a[axis] * b[axis]).sum();
        assert!((dot(&fourth(a), &fourth(b)) - cosine.powi(4)).abs() < 1e-15);
        assert!((dot(&third(a), &third(b)) - cosine.powi(3)).abs() < 1e-15);
        assert!((dot(&third(a), &third(a)) - 1.0).abs() < 1e-15);
    }
}
