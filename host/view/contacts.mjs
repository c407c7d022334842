// Contacts of a running scene on the triangles of the surface: a contact names its cell and its place.
import { add, at, cross, dot, length, scale } from "./vectors.mjs";

/** Distances to two triangles that differ by less than this share of the distance to the cell are the same. */
const SAME = 1e-3;

/** Returns a function that finds the triangles around a cell. */
export function trianglesAround(triangles) {
  const around = new Map();
  triangles.forEach((cell, corner) => {
    if (!around.has(cell)) around.set(cell, []);
    around.get(cell).push(Math.floor(corner / 3));
  });
  return (cell) => around.get(cell) ?? [];
}

/**
 * Returns the pressure on triangles as pairs of triangle and pressure [Pa]. Each contact is on the triangle around its
 * cell that is nearest to its place; of several that are as near, on one that has none yet.
 */
export function pressuresOf(contacts, positionsM, triangles, around) {
  const pairs = [];
  const taken = new Set();
  for (const { cell, positionM, pressurePa } of contacts) {
    const faces = around(cell);
    if (!faces.length) continue;
    const far = faces.map((face) => distance(positionM, [0, 1, 2].map((k) => at(positionsM, triangles[3 * face + k]))));
    const limit = Math.min(...far) + SAME * length(add(positionM, at(positionsM, cell), -1));
    const near = faces.filter((_, index) => far[index] <= limit);
    const face = near.find((one) => !taken.has(one)) ?? faces[far.indexOf(Math.min(...far))];
    taken.add(face);
    pairs.push([face, pressurePa]);
  }
  return pairs;
}

/** Distance from a place to a triangle. */
function distance(place, corners) {
  const [a, b, c] = corners;
  const normal = cross(add(b, a, -1), add(c, a, -1));
  const area = length(normal);
  const isInside = corners.every((from, k) => dot(cross(add(corners[(k + 1) % 3], from, -1), add(place, from, -1)), normal) >= 0);
  if (area > 0 && isInside) return Math.abs(dot(add(place, a, -1), normal)) / area;
  return Math.min(...corners.map((from, k) => distanceToEdge(place, from, corners[(k + 1) % 3])));
}

function distanceToEdge(place, from, to) {
  const [edge, away] = [add(to, from, -1), add(place, from, -1)];
  const share = Math.max(0, Math.min(1, dot(away, edge) / (dot(edge, edge) || 1)));
  return length(add(away, scale(edge, share), -1));
}
