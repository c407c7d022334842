// Traditional ChainMail, which the network is compared with: an element that is moved drags a neighbour along only
// as far as the link's bounds demand, and that one drags its own in turn. There is neither a force nor an energy.
// The laboratory has the same method in host/lab/src/chainmail, with its sources.
import { partsOf, reachM } from "./parts.mjs";
import { nearestAtRest } from "./surface.mjs";
import { add, at, length, scale, turned } from "./vectors.mjs";

/** How far an offset may stray from that at rest, as a share of it: of the comparison with the paper. */
export const ALPHA = 0.1;
/** Farthest that a tool goes between two moves, and between two states: beyond it the press begins anew [m]. */
const STEP_M = 0.0004;
const JUMP_M = 0.02;
/** Relaxation sweeps of a state that no tool touches. */
const SWEEPS = 4;

export class ChainMail {
  /** Elements at rest, linked by pairs of indices; `fixed` never move, tools press the corners of `triangles`. */
  constructor({ restM, links, fixed, triangles }, alpha = ALPHA) {
    this.limits = { short: 1 - alpha, long: 1 + alpha, shear: alpha };
    this.restM = Float64Array.from(restM);
    this.triangles = triangles;
    this.positionsM = this.restM.slice();
    const count = this.restM.length / 3;
    this.isFixed = new Uint8Array(count);
    for (const element of fixed) this.isFixed[element] = 1;
    const sets = Array.from({ length: count }, () => new Set());
    for (let link = 0; link < links.length; link += 2) {
      sets[links[link]].add(links[link + 1]);
      sets[links[link + 1]].add(links[link]);
    }
    this.neighbours = sets.map((set) => Uint32Array.from(set).sort());
    this.surface = [...new Set(triangles)].filter((element) => !this.isFixed[element]).sort((a, b) => a - b);
    this.lookedAt = new Uint32Array(count);
    this.moves = 0;
    this.held = [];
    this.tick = -1;
    this.near = new Float64Array(3);
  }

  /** Puts elements at places, pairs of both, and lets the chain follow. Each element is looked at once at most. */
  moveTo(held) {
    this.moves += 1;
    this.held = held.map(([element]) => element);
    for (const [element, place] of held) {
      this.positionsM.set(place, 3 * element);
      this.lookedAt[element] = this.moves;
    }
    const front = [];
    const passOn = (element) => {
      for (const next of this.neighbours[element]) front.push(next, element);
    };
    this.held.forEach(passOn);
    for (let first = 0; first < front.length; first += 2) if (this.#follow(front[first], front[first + 1])) passOn(front[first]);
  }

  /** Moves an element by the least that satisfies its link to a sponsor; returns whether it moved. */
  #follow(element, sponsor) {
    if (this.lookedAt[element] === this.moves) return false;
    this.lookedAt[element] = this.moves;
    if (this.isFixed[element]) return false;
    this.#nearest(element, sponsor, this.limits);
    const isMoved = [0, 1, 2].some((axis) => this.near[axis] !== this.positionsM[3 * element + axis]);
    if (isMoved) this.positionsM.set(this.near, 3 * element);
    return isMoved;
  }

  /** Writes the nearest place of an element that satisfies its link to a neighbour into `near`. */
  #nearest(element, neighbour, { short, long, shear }) {
    const { restM, positionsM, near } = this;
    const [here, from] = [3 * element, 3 * neighbour];
    for (let axis = 0; axis < 3; axis++) {
      const [second, third] = [(axis + 1) % 3, (axis + 2) % 3];
      const rest = restM[here + axis] - restM[from + axis];
      const across = shear * (Math.abs(restM[here + second] - restM[from + second]) + Math.abs(restM[here + third] - restM[from + third]));
      const low = Math.min(short * rest, long * rest) - across;
      const high = Math.max(short * rest, long * rest) + across;
      const offset = positionsM[here + axis] - positionsM[from + axis];
      near[axis] = offset < low ? positionsM[from + axis] + low : offset > high ? positionsM[from + axis] + high : positionsM[here + axis];
    }
  }

  /** A relaxation sweep: all that is neither fixed nor held moves by the mean of its links' excess over rest. */
  relax() {
    const rigid = { short: 1, long: 1, shear: 0 };
    const isHeld = new Set(this.held);
    const moved = this.positionsM.slice();
    this.neighbours.forEach((neighbours, element) => {
      if (this.isFixed[element] || isHeld.has(element) || neighbours.length === 0) return;
      const sum = [0, 0, 0];
      for (const neighbour of neighbours) {
        this.#nearest(element, neighbour, rigid);
        for (let axis = 0; axis < 3; axis++) sum[axis] += this.near[axis] - this.positionsM[3 * element + axis];
      }
      for (let axis = 0; axis < 3; axis++) moved[3 * element + axis] += sum[axis] / neighbours.length;
    });
    this.positionsM = moved;
  }

  /** Puts the surface elements that are inside tools on them; returns whether there are any. */
  push(tools) {
    const held = new Map();
    for (const { kind, positionM, orientation } of tools) {
      const parts = partsOf(kind).map((part) => placedPart(part, positionM, orientation));
      for (const element of this.surface) {
        for (const part of parts) {
          const place = putOut(part, held.get(element) ?? at(this.positionsM, element));
          if (place) held.set(element, place);
        }
      }
    }
    if (held.size > 0) this.moveTo([...held]);
    return held.size > 0;
  }

  /** Follows the tools of a state from where they were in the last one; untouched, the chain relaxes. */
  follow({ tick, tools }) {
    if (tick === this.tick) return;
    const engaged = tools.filter((tool) => tool.engaged);
    const isSame = this.last?.length === engaged.length && engaged.every(({ kind }, index) => this.last[index].kind === kind);
    const farthest = (from) => Math.max(0, ...engaged.map(({ positionM }, index) => length(add(positionM, from[index].positionM, -1))));
    const goesOn = isSame && tick > this.tick && farthest(this.last) < JUMP_M;
    // A press that begins anew comes from outside, so that no element is put out on the tool's far side.
    if (!goesOn) this.positionsM = this.restM.slice();
    const before = goesOn ? this.last : engaged.map((tool) => this.#outside(tool));
    const steps = Math.max(1, Math.ceil(farthest(before) / STEP_M));
    let isTouched = false;
    for (let step = 1; step <= steps; step++) {
      const between = engaged.map((tool, index) => {
        const from = before[index].positionM;
        return { ...tool, positionM: add(from, add(tool.positionM, from, -1), step / steps) };
      });
      isTouched = this.push(between);
    }
    if (!isTouched) {
      this.held = [];
      for (let sweep = 0; sweep < SWEEPS; sweep++) this.relax();
    }
    [this.tick, this.last] = [tick, engaged];
  }

  /** A tool outside the body at rest, on the surface's normal where the tool is nearest. */
  #outside(tool) {
    const { normal } = nearestAtRest(this, tool.positionM);
    return { ...tool, positionM: add(tool.positionM, normal, JUMP_M + 2 * reachM(partsOf(tool.kind))) };
  }
}

/** A part of a tool where the tool is: its centre and the turn from its own frame. */
function placedPart(part, positionM, orientation) {
  const inPart = (vector) => turned(inverse(part.orientation), turned(inverse(orientation), vector));
  const inWorld = (vector) => turned(orientation, turned(part.orientation, vector));
  return { ...part, centreM: add(positionM, turned(orientation, part.centreM)), inPart, inWorld };
}

const inverse = ([x, y, z, w]) => [-x, -y, -z, w];

/** The place on a part that an element inside it is put to; none for one outside. */
function putOut({ kind, halfM, radiusM, centreM, inPart, inWorld }, place) {
  const off = inPart(add(place, centreM, -1));
  if (kind === "half-space") return off[2] < 0 ? add(centreM, inWorld([off[0], off[1], 0])) : null;
  const core = off.map((x, axis) => Math.max(-halfM[axis], Math.min(halfM[axis], x)));
  const outward = add(off, core, -1);
  const apart = length(outward);
  if (apart >= radiusM) return null;
  if (apart > 0) return add(centreM, inWorld(add(core, outward, radiusM / apart)));
  // In the core itself: out by the nearest side.
  const rooms = off.map((x, axis) => halfM[axis] - Math.abs(x));
  const axis = rooms.indexOf(Math.min(...rooms));
  const out = scale([0, 1, 2].map((one) => (one === axis ? Math.sign(off[axis]) || 1 : 0)), rooms[axis] + radiusM);
  return add(centreM, inWorld(add(off, out)));
}
