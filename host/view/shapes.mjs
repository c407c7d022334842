// Meshes of tools and arrows: { points, normals, corners }, flat arrays.
import { add, cross, scale, unit } from "./vectors.mjs";

/** Steps of a quarter of a rounded edge. */
const STEPS = 10;

/** A box of half edges with rounded edges of a radius: a sphere, a capsule, a box. */
export function roundedBox(halfM, radiusM) {
  const mesh = { points: [], normals: [], corners: [] };
  for (const [normal, right] of [[[1, 0, 0], [0, 1, 0]], [[0, 1, 0], [0, 0, 1]], [[0, 0, 1], [1, 0, 0]]]) {
    for (const side of [1, -1]) addFace(mesh, scale(normal, side), scale(right, side), halfM, radiusM);
  }
  return mesh;
}

/** One of the six faces, with its half of the rounded edges around it. */
function addFace(mesh, normal, right, halfM, radiusM) {
  const up = cross(normal, right);
  const first = mesh.points.length / 3;
  const rows = 2 * STEPS + 2;
  // Rows up to the middle belong to the lower corner, the others to the upper one.
  const row = (index) => {
    const side = index <= STEPS ? -1 : 1;
    const step = index <= STEPS ? index / STEPS - 1 : (index - STEPS - 1) / STEPS;
    return { side, slope: Math.tan((step * Math.PI) / 4) };
  };
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < rows; j++) {
      const [across, along] = [row(i), row(j)];
      const direction = unit(add(add(normal, right, across.slope), up, along.slope));
      const corner = add(add(normal, right, across.side), up, along.side);
      mesh.points.push(...add(corner.map((sign, axis) => sign * halfM[axis]), direction, radiusM));
      mesh.normals.push(...direction);
      if (i > 0 && j > 0) addQuad(mesh, first + rows * (i - 1) + j - 1, first + rows * i + j - 1, first + rows * i + j, first + rows * (i - 1) + j);
    }
  }
}

function addQuad(mesh, a, b, c, d) {
  mesh.corners.push(a, b, c, a, c, d);
}

/** A disc across z. */
export function disc(radiusM) {
  const mesh = { points: [0, 0, 0], normals: [0, 0, 1], corners: [] };
  const sides = 64;
  for (let side = 0; side <= sides; side++) {
    const angle = (2 * Math.PI * side) / sides;
    mesh.points.push(radiusM * Math.cos(angle), radiusM * Math.sin(angle), 0);
    mesh.normals.push(0, 0, 1);
    if (side > 0) mesh.corners.push(0, side, side + 1);
  }
  return mesh;
}

/** An arrow of length 1 along z, with one head or two. */
export function arrow(heads) {
  const neck = heads === 2 ? [[0.034, 0.6], [0.085, 0.6], [0.034, 0.8], [0.085, 0.8]] : [[0.034, 0.74], [0.085, 0.74]];
  return lathe([[0, 0], [0.034, 0], ...neck, [0, 1]]);
}

/** Turns a profile of radii and heights around z, with sharp edges at its points. */
function lathe(profile) {
  const mesh = { points: [], normals: [], corners: [] };
  const sides = 28;
  for (let part = 0; part + 1 < profile.length; part++) {
    const [[r0, z0], [r1, z1]] = [profile[part], profile[part + 1]];
    const first = mesh.points.length / 3;
    const size = Math.hypot(r1 - r0, z1 - z0);
    for (let side = 0; side <= sides; side++) {
      const angle = (2 * Math.PI * side) / sides;
      const [cos, sin] = [Math.cos(angle), Math.sin(angle)];
      mesh.points.push(r0 * cos, r0 * sin, z0, r1 * cos, r1 * sin, z1);
      const normal = [(cos * (z1 - z0)) / size, (sin * (z1 - z0)) / size, (r0 - r1) / size];
      mesh.normals.push(...normal, ...normal);
      if (side > 0) addQuad(mesh, first + 2 * side - 2, first + 2 * side, first + 2 * side + 1, first + 2 * side - 1);
    }
  }
  return mesh;
}
