// Tools by their parts, in the words of the command's option --tool: sphere:R, capsule:HALF,R, box:X,Y,Z,R,
// half-space:R, blade:LENGTH, scissors:LENGTH,OFFSET,MOUTH, joined by +, each with @X,Y,Z for its place and /X,Y,Z,W for its turn.
import { add, times, turned } from "./vectors.mjs";

/** Reads a tool; throws an Error with the remedy. */
export function partsOf(text) {
  return text.split("+").flatMap((part) => {
    const [before, turn] = part.split("/");
    const [shape, place] = before.split("@");
    const [kind, sizes = ""] = shape.split(":");
    const numbers = sizes.split(",").map(Number);
    if (kind === "blade" && numbers[0] > 0) return bladePart(0.5 * numbers[0], listed(place, [0, 0, 0]), listed(turn, [0, 0, 0, 1]));
    if (kind === "scissors" && numbers[0] > 0) return scissorParts(numbers, listed(place, [0, 0, 0]), listed(turn, [0, 0, 0, 1]));
    const radiusM = numbers[numbers.length - 1] || 0.01;
    const halves = { sphere: [0, 0, 0], capsule: [0, 0, numbers[0]], box: numbers.slice(0, 3), "half-space": [Infinity, Infinity, Infinity] };
    const halfM = halves[kind];
    if (!halfM || !(radiusM > 0) || halfM.some((half) => !(half >= 0))) {
      throw new Error(`${part}: write sphere:R, capsule:HALF_LENGTH,R, box:HX,HY,HZ,R, blade:LENGTH, scissors:LENGTH or half-space`);
    }
    return { kind, halfM, radiusM, centreM: listed(place, [0, 0, 0]), orientation: listed(turn, [0, 0, 0, 1]) };
  });
}

function listed(words, otherwise) {
  return words ? words.split(",").map(Number) : otherwise;
}

/** A blade as it is drawn: a thin plate that stands on its edge, which is along x. `edge` is what the kernel takes. */
function bladePart(halfM, place, orientation) {
  const [heightM, radiusM] = [0.4 * halfM, 0.02 * halfM];
  const centreM = add(place, turned(orientation, [0, 0, heightM]));
  const edge = { centreM: place, orientation, halfM: [halfM, 0, 0], radiusM: 0 };
  return { kind: "blade", halfM: [halfM - radiusM, 0, heightM - radiusM], radiusM, centreM, orientation, edge };
}

/**
 * Scissors as they are drawn: two plates side by side, from the pivot along -z. `edge` of the first is what the kernel
 * takes for both.
 */
function scissorParts([lengthM, offsetM = 0.1 * lengthM, mouthM = 0.5 * lengthM], placeM, orientation) {
  const radiusM = 0.1 * offsetM;
  const halfM = [0, offsetM - radiusM, 0.5 * lengthM - radiusM];
  const edge = { centreM: placeM, orientation, halfM: [0.5 * mouthM, 0, lengthM], radiusM: -offsetM };
  return [1, -1].map((side) => {
    const middleM = [side * radiusM, 0, -0.5 * lengthM];
    const centreM = add(placeM, turned(orientation, middleM));
    const part = { kind: "scissors", halfM, radiusM, centreM, orientation, side, placeM, middleM };
    return side === 1 ? { ...part, edge } : part;
  });
}

/** Where a part is in its tool's frame: a blade of scissors turns about x by half of their opening [rad]. */
export function opened(part, openingRad = 0) {
  if (!part.side) return part;
  const quarter = 0.25 * part.side * openingRad;
  const orientation = times(part.orientation, [Math.sin(quarter), 0, 0, Math.cos(quarter)]);
  return { orientation, centreM: add(part.placeM, turned(orientation, part.middleM)) };
}

/** Returns how far a tool reaches from its frame [m], a half space by its edge. */
export function reachM(parts) {
  const finite = (half) => (Number.isFinite(half) ? half : 0);
  return Math.max(...parts.map((part) => Math.hypot(...part.centreM) + Math.hypot(...part.halfM.map(finite)) + part.radiusM));
}
