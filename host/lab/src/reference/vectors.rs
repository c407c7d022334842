//! Sums and lengths of vectors, and of fields of one vector a cell.

/// `a - b`.
#[inline]
#[must_use]
pub fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// `a + factor b`.
#[inline]
#[must_use]
pub fn plus(a: [f64; 3], factor: f64, b: [f64; 3]) -> [f64; 3] {
    [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]]
}

/// Scalar product.
#[inline]
#[must_use]
pub fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Length.
#[inline]
#[must_use]
pub fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

/// The same direction with length 1.
#[must_use]
pub fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = norm(a);
    a.map(|x| x / length)
}

/// `a + factor b`, cell by cell.
#[must_use]
pub fn fields(a: &[[f64; 3]], factor: f64, b: &[[f64; 3]]) -> Vec<[f64; 3]> {
    a.iter().zip(b).map(|(a, b)| plus(*a, factor, *b)).collect()
}

/// L2 norm of a field over the cells.
#[must_use]
pub fn size(field: &[[f64; 3]]) -> f64 {
    field.as_flattened().iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// L2 norm of the difference of two fields.
#[must_use]
pub fn distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.as_flattened().iter().zip(b.as_flattened());
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Largest distance of a cell between two fields.
#[must_use]
pub fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(a, b)| norm(minus(*a, *b))).fold(0.0, f64::max)
}
