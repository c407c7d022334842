// Tools by their parts, in the words of the command's option --tool: sphere:R, capsule:HALF,R, box:X,Y,Z,R,
// half-space:R, joined by +, each with @X,Y,Z for its place and /X,Y,Z,W for its turn.

/** Reads a tool; throws an Error with the remedy. */
export function partsOf(text) {
  return text.split("+").map((part) => {
    const [before, turn] = part.split("/");
    const [shape, place] = before.split("@");
    const [kind, sizes = ""] = shape.split(":");
    const numbers = sizes.split(",").map(Number);
    const radiusM = numbers[numbers.length - 1] || 0.01;
    const halves = { sphere: [0, 0, 0], capsule: [0, 0, numbers[0]], box: numbers.slice(0, 3), "half-space": [Infinity, Infinity, Infinity] };
    const halfM = halves[kind];
    if (!halfM || !(radiusM > 0) || halfM.some((half) => !(half >= 0))) {
      throw new Error(`${part}: write sphere:R, capsule:HALF_LENGTH,R, box:HX,HY,HZ,R or half-space`);
    }
    const list = (words, otherwise) => (words ? words.split(",").map(Number) : otherwise);
    return { kind, halfM, radiusM, centreM: list(place, [0, 0, 0]), orientation: list(turn, [0, 0, 0, 1]) };
  });
}

/** Returns how far a tool reaches from its frame [m], a half space by its edge. */
export function reachM(parts) {
  const finite = (half) => (Number.isFinite(half) ? half : 0);
  return Math.max(...parts.map((part) => Math.hypot(...part.centreM) + Math.hypot(...part.halfM.map(finite)) + part.radiusM));
}
