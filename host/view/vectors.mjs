// Vectors as arrays of three numbers, quaternions as x, y, z, w, matrices of WebGL as 16 numbers by columns.

export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
export const add = (a, b, factor = 1) => [a[0] + factor * b[0], a[1] + factor * b[1], a[2] + factor * b[2]];
export const scale = (a, factor) => [factor * a[0], factor * a[1], factor * a[2]];
export const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
export const length = (a) => Math.hypot(a[0], a[1], a[2]);
/** The unit vector along a, or z where a has no length. */
export const unit = (a) => (length(a) > 0 ? scale(a, 1 / length(a)) : [0, 0, 1]);
/** The vector at an index of a flat array. */
export const at = (array, index) => [array[3 * index], array[3 * index + 1], array[3 * index + 2]];

/** The quaternion a times b: first b, then a. */
export function times([ax, ay, az, aw], [bx, by, bz, bw]) {
  return [
    aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
    aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz,
  ];
}

/** The quaternion that turns about a unit axis by an angle [rad]. */
export const turnAbout = (axis, angle) => [...scale(axis, Math.sin(angle / 2)), Math.cos(angle / 2)];

/** The unit quaternion that turns z into a unit direction. */
export function turnTo(direction) {
  const [x, y, z] = direction;
  if (z < -0.9999) return [1, 0, 0, 0];
  const size = Math.sqrt(2 * (1 + z));
  return [-y / size, x / size, 0, size / 2];
}

/** A vector turned by a quaternion. */
export function turned([x, y, z, w], vector) {
  const twice = scale(cross([x, y, z], vector), 2);
  return add(add(vector, twice, w), cross([x, y, z], twice));
}

/** The matrix that scales, then turns by a quaternion, then moves. */
export function placed(position, orientation, size = [1, 1, 1]) {
  const columns = [[size[0], 0, 0], [0, size[1], 0], [0, 0, size[2]]].map((axis) => turned(orientation, axis));
  return new Float32Array([...columns[0], 0, ...columns[1], 0, ...columns[2], 0, ...position, 1]);
}
