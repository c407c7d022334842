// Tools by their parts, in the words of the command's option --tool: sphere:R, capsule:HALF,R, box:X,Y,Z,R,
// half-space:R, blade:LENGTH, joined by +, each with @X,Y,Z for its place and /X,Y,Z,W for its turn.
import { add, turned } from "./vectors.mjs";

/** Reads a tool; throws an Error with the remedy. */
export function partsOf(text) {
  return text.split("+").map((part) => {
    const [before, turn] = part.split("/");
    const [shape, place] = before.split("@");
    const [kind, sizes = ""] = shape.split(":");
    const numbers = sizes.split(",").map(Number);
    if (kind === "blade" && numbers[0] > 0) return bladePart(0.5 * numbers[0], listed(place, [0, 0, 0]), listed(turn, [0, 0, 0, 1]));
    const radiusM = numbers[numbers.length - 1] || 0.01;
    const halves = { sphere: [0, 0, 0], capsule: [0, 0, numbers[0]], box: numbers.slice(0, 3), "half-space": [Infinity, Infinity, Infinity] };
    const halfM = halves[kind];
    if (!halfM || !(radiusM > 0) || halfM.some((half) => !(half >= 0))) {
      throw new Error(`${part}: write sphere:R, capsule:HALF_LENGTH,R, box:HX,HY,HZ,R, blade:LENGTH or half-space`);
    }
    return { kind, halfM, radiusM, centreM: listed(place, [0, 0, 0]), orientation: listed(turn, [0, 0, 0, 1]) };
  });
}

function listed(words, otherwise) {
  return words ? words.split(",").map(Number) : otherwise;
}

/** A blade as it is drawn: a thin plate that stands on its edge, which is along x. */
function bladePart(halfM, place, orientation) {
  const [heightM, radiusM] = [0.4 * halfM, 0.02 * halfM];
  const centreM = add(place, turned(orientation, [0, 0, heightM]));
  return { kind: "blade", halfM: [halfM - radiusM, 0, heightM - radiusM], radiusM, centreM, orientation };
}

/** Returns how far a tool reaches from its frame [m], a half space by its edge. */
export function reachM(parts) {
  const finite = (half) => (Number.isFinite(half) ? half : 0);
  return Math.max(...parts.map((part) => Math.hypot(...part.centreM) + Math.hypot(...part.halfM.map(finite)) + part.radiusM));
}
