//! The fourth-order moment of a direction: what a link's energy under a homogeneous strain
//! depends on.

/// Components of a symmetric tensor of fourth order in space.
pub const COMPONENTS: usize = 15;

/// A symmetric tensor of fourth order, scaled so that the inner product of two is the full one.
pub type Moment = [f64; COMPONENTS];

/// n n n n of a unit vector: of length 1, and the inner product of two is (n . m)^4.
pub fn of_direction(n: [f64; 3]) -> Moment {
    let mut moment = [0.0; COMPONENTS];
    let mut at = 0;
    for x in 0..=4_u8 {
        for y in 0..=4 - x {
            let z = 4 - x - y;
            let product = power(n[0], x) * power(n[1], y) * power(n[2], z);
            moment[at] = (24.0 / (factorial(x) * factorial(y) * factorial(z))).sqrt() * product;
            at += 1;
        }
    }
    moment
}

/// Inner product.
pub fn dot(a: &Moment, b: &Moment) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// `a += s b`.
pub fn add(a: &mut Moment, s: f64, b: &Moment) {
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
    fn the_product_of_two_directions_is_their_cosine_to_the_fourth() {
        let (a, b) = ([0.6, 0.0, 0.8], [2.0 / 3.0, -1.0 / 3.0, 2.0 / 3.0]);
        let cosine: f64 = (0..3).map(|axis| a[axis] * b[axis]).sum();
        let product = dot(&of_direction(a), &of_direction(b));
        assert!((product - cosine.powi(4)).abs() < 1e-15, "{product}");
        assert!((dot(&of_direction(b), &of_direction(b)) - 1.0).abs() < 1e-15);
    }
}
