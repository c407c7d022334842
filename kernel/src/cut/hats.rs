//! Volume of a tetrahedron, and the gradients of the hat functions of its corners, in double precision: the numbers of
//! a cut body are then those of the bake but for the last places.

/// A gradient of a hat function.
pub(super) type Slope = [f64; 3];

fn cross([a, b, c]: Slope, [d, e, f]: Slope) -> Slope {
    [b * f - c * e, c * d - a * f, a * e - b * d]
}

pub(super) fn dot([a, b, c]: Slope, [d, e, f]: Slope) -> f64 {
    a * d + b * e + c * f
}

/// Volume of a tetrahedron, and the gradients of its corners' hat functions.
pub(super) fn gradients(corners: [[f32; 3]; 4]) -> (f64, [Slope; 4]) {
    let [a, b, c, d] = corners.map(|corner| corner.map(f64::from));
    let way = |[x, y, z]: Slope| [x - a[0], y - a[1], z - a[2]];
    let [b, c, d] = [way(b), way(c), way(d)];
    let [p, q, r] = [cross(c, d), cross(d, b), cross(b, c)];
    let six = dot(b, p);
    let share = |[x, y, z]: Slope| [x / six, y / six, z / six];
    let [p, q, r] = [share(p), share(q), share(r)];
    let first = [-(p[0] + q[0] + r[0]), -(p[1] + q[1] + r[1]), -(p[2] + q[2] + r[2])];
    (six / 6.0, [first, p, q, r])
}
