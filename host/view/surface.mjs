// The surface of the body as it is drawn: normals that are smooth over flat edges and sharp over sharp ones, and a
// number at each corner for the colour.
import { add, at, cross, dot, length, unit } from "./vectors.mjs";

/** Pieces of an edge of a triangle: each triangle is drawn as a curved one. */
const PIECES = 3;
/** Share of the way from the flat triangle to the one that its normals bend. */
const CURVED = 0.75;
/** Edges whose faces meet at more than this at rest are sharp [cosine]. */
const SHARP = Math.cos((50 * Math.PI) / 180);

export class Surface {
  /** `origins` are the cells of the whole body that those of the triangles were made from, if it is cut. */
  constructor({ restM, triangles, origins = triangles }) {
    this.restM = restM;
    this.triangles = triangles;
    // A triangle of a piece that is gone lies in one cell.
    const isThere = (_, corner) => triangles[corner - (corner % 3)] !== triangles[corner - (corner % 3) + 1];
    this.cells = surfaceCells(triangles.filter(isThere));
    this.originOf = new Map(Array.from(triangles, (cell, corner) => [cell, origins[corner]]));
    /** The cells whose stress the colours show, with a number of its own for this list. */
    this.stressed = surfaceCells(origins.filter(isThere));
    this.list = Surface.lists = (Surface.lists ?? 0) + 1;
    this.placeOf = new Map(this.stressed.map((cell, place) => [cell, place]));
    this.#group();
    this.rest = this.#restShapes();
    this.#cut();
    this.values = new Float32Array(restM.length / 3);
  }

  /** Puts the corners around each cell into groups of faces that go over into each other smoothly. */
  #group() {
    const faces = Array.from({ length: this.triangles.length / 3 }, (_, face) => unit(this.#area(this.restM, face)));
    const around = new Map();
    this.triangles.forEach((cell, corner) => around.set(cell, [...(around.get(cell) ?? []), corner]));
    this.groupOf = new Uint32Array(this.triangles.length);
    this.isSmooth = new Float32Array(this.triangles.length).fill(1);
    this.groups = 0;
    for (const corners of around.values()) {
      const left = new Set(corners);
      const first = this.groups;
      while (left.size > 0) {
        const group = [left.values().next().value];
        for (const corner of group) {
          left.delete(corner);
          const face = faces[Math.floor(corner / 3)];
          for (const other of left) {
            if (this.#shareAnEdge(corner, other) && dot(face, faces[Math.floor(other / 3)]) > SHARP) {
              left.delete(other);
              group.push(other);
            }
          }
        }
        for (const corner of group) this.groupOf[corner] = this.groups;
        this.groups += 1;
      }
      if (this.groups > first + 1) for (const corner of corners) this.isSmooth[corner] = 0;
    }
    this.normals = new Float64Array(3 * this.groups);
  }

  /** Cuts all triangles into pieces: points of position, normal and number, and the corners of the pieces. */
  #cut() {
    const index = (i, j) => (i * (2 * PIECES + 3 - i)) / 2 + j;
    const pieces = [];
    this.shares = [];
    for (let i = 0; i <= PIECES; i++) {
      for (let j = 0; i + j <= PIECES; j++) {
        this.shares.push([1 - (i + j) / PIECES, i / PIECES, j / PIECES]);
        if (i + j < PIECES) pieces.push(index(i, j), index(i + 1, j), index(i, j + 1));
        if (i + j < PIECES - 1) pieces.push(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
      }
    }
    const faces = this.triangles.length / 3;
    this.points = new Float32Array(7 * this.shares.length * faces);
    this.pieces = new Uint32Array(pieces.length * faces);
    for (let face = 0; face < faces; face++) {
      this.pieces.set(pieces.map((corner) => corner + this.shares.length * face), pieces.length * face);
    }
  }

  /** Whether two corners at one cell belong to faces that share an edge there. */
  #shareAnEdge(corner, other) {
    const ends = (one) => [0, 1, 2].map((k) => this.triangles[3 * Math.floor(one / 3) + k]);
    const [mine, theirs] = [ends(corner), ends(other)];
    return mine.filter((cell) => theirs.includes(cell)).length >= 2;
  }

  /** The normal of a face, as long as twice its area. */
  #area(positions, face) {
    const [a, b, c] = [0, 1, 2].map((k) => at(positions, this.triangles[3 * face + k]));
    return cross(add(b, a, -1), add(c, a, -1));
  }

  /** The inverse of each triangle's two edges at rest, in its plane: what a stretch is measured by. */
  #restShapes() {
    const shapes = new Float64Array(this.triangles.length);
    for (let face = 0; face < this.triangles.length / 3; face++) {
      const [a, b, c] = [0, 1, 2].map((k) => at(this.restM, this.triangles[3 * face + k]));
      const [first, second] = [add(b, a, -1), add(c, a, -1)];
      const along = length(first);
      // One of a piece that is gone.
      if (!(along > 0)) continue;
      const shift = dot(first, second) / along;
      const height = length(cross(first, second)) / along;
      shapes.set([1 / along, -shift / (along * height), 1 / height], 3 * face);
    }
    return shapes;
  }

  /** Takes over a state; `what` is displacement [m], stretch [1], stress [Pa] or pressure [Pa]. */
  update(state, what) {
    const positions = state.positionsM;
    this.#updateNormals(positions);
    if (what === "stretch") this.#spread((face) => this.#stretch(positions, face), 1);
    else if (what === "pressure") {
      // Several parts of a tool may press on a triangle.
      const pressures = new Map();
      for (const [face, pressurePa] of state.pressuresPa ?? []) pressures.set(face, (pressures.get(face) ?? 0) + pressurePa);
      this.#spread((face) => pressures.get(face) ?? 0, 0);
    } else if (what === "stress") this.#takeStresses(state);
    else this.#displacements(positions);
    for (let face = 0; face < this.triangles.length / 3; face++) this.#fill(positions, face);
  }

  /** Takes over stresses [Pa]; those of another list of cells, which was asked for before a cut, are passed over. */
  #takeStresses({ stressesPa = [], stressList = this.list }) {
    if (stressList !== this.list) return;
    for (const cell of this.cells) this.values[cell] = stressesPa[this.placeOf.get(this.originOf.get(cell))] ?? 0;
  }

  /** Begins with the numbers of another surface of the same body: a copy with that of its origin. */
  inherit({ values, cells }) {
    const known = new Set(cells);
    for (const cell of this.cells) this.values[cell] = values[known.has(cell) ? cell : this.originOf.get(cell)];
  }

  /** Writes the points of a face: each as far from the flat triangle as the planes at its corners say. */
  #fill(positions, face) {
    const { points, shares, normals, values } = this;
    for (let point = 0; point < shares.length; point++) {
      const share = shares[point];
      const start = 7 * (shares.length * face + point);
      const flat = [0, 0, 0];
      for (let place = start; place < start + 7; place++) points[place] = 0;
      for (let k = 0; k < 3; k++) {
        const [cell, group] = [this.triangles[3 * face + k], this.groupOf[3 * face + k]];
        for (let axis = 0; axis < 3; axis++) {
          flat[axis] += share[k] * positions[3 * cell + axis];
          points[start + 3 + axis] += share[k] * normals[3 * group + axis];
        }
        points[start + 6] += share[k] * values[cell];
      }
      for (let axis = 0; axis < 3; axis++) points[start + axis] = flat[axis];
      for (let k = 0; k < 3; k++) {
        const [cell, group] = [this.triangles[3 * face + k], this.groupOf[3 * face + k]];
        let above = 0;
        for (let axis = 0; axis < 3; axis++) above += (flat[axis] - positions[3 * cell + axis]) * normals[3 * group + axis];
        above *= CURVED * share[k] * this.isSmooth[3 * face + k];
        for (let axis = 0; axis < 3; axis++) points[start + axis] -= above * normals[3 * group + axis];
      }
    }
  }

  #updateNormals(positions) {
    this.normals.fill(0);
    for (let face = 0; face < this.triangles.length / 3; face++) {
      const area = this.#area(positions, face);
      for (let k = 0; k < 3; k++) {
        const group = this.groupOf[3 * face + k];
        for (let axis = 0; axis < 3; axis++) this.normals[3 * group + axis] += area[axis];
      }
    }
    for (let group = 0; group < this.groups; group++) this.normals.set(unit(at(this.normals, group)), 3 * group);
  }

  #displacements(positions) {
    for (const cell of this.cells) this.values[cell] = length(add(at(positions, cell), at(this.restM, cell), -1));
  }

  /** Largest principal stretch of a face: the larger singular value of its change of shape. */
  #stretch(positions, face) {
    const [a, b, c] = [0, 1, 2].map((k) => at(positions, this.triangles[3 * face + k]));
    const [inverse, shear, height] = at(this.rest, face);
    const first = add(b, a, -1);
    const u = first.map((x) => x * inverse);
    const v = add(add([0, 0, 0], first, shear), add(c, a, -1), height);
    const [uu, vv, uv] = [dot(u, u), dot(v, v), dot(u, v)];
    return Math.sqrt((uu + vv) / 2 + Math.hypot((uu - vv) / 2, uv));
  }

  /** Gives each cell the mean of a number of the faces around it. */
  #spread(numberOf, otherwise) {
    this.values.fill(0);
    const counts = (this.counts ??= new Float32Array(this.values.length));
    counts.fill(0);
    for (let face = 0; face < this.triangles.length / 3; face++) {
      const number = numberOf(face);
      for (let k = 0; k < 3; k++) {
        this.values[this.triangles[3 * face + k]] += number;
        counts[this.triangles[3 * face + k]] += 1;
      }
    }
    for (const cell of this.cells) this.values[cell] = counts[cell] > 0 ? this.values[cell] / counts[cell] : otherwise;
  }

  /** The largest of the numbers. */
  most() {
    return this.cells.reduce((most, cell) => Math.max(most, this.values[cell]), 0);
  }
}

/** Returns the cells of a surface, ascending. */
export function surfaceCells(triangles) {
  return [...new Set(triangles)].sort((a, b) => a - b);
}

/** Returns the cell of the surface nearest to a place at rest, and the outward normal there. */
export function nearestAtRest({ restM, triangles }, place) {
  let [nearest, least] = [0, Infinity];
  for (const cell of triangles) {
    const distance = length(add(at(restM, cell), place, -1));
    if (distance < least) [nearest, least] = [cell, distance];
  }
  let normal = [0, 0, 0];
  for (let face = 0; face < triangles.length; face += 3) {
    const corners = [triangles[face], triangles[face + 1], triangles[face + 2]];
    if (!corners.includes(nearest)) continue;
    const [a, b, c] = corners.map((cell) => at(restM, cell));
    normal = add(normal, cross(add(b, a, -1), add(c, a, -1)));
  }
  return { cell: nearest, normal: unit(normal) };
}
