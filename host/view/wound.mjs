// The body as it is cut: what the triangles of the worker make of the whole one.
import { at } from "./vectors.mjs";

/**
 * Returns the body of triangles as the worker sends them, six cells of each: the three of now, and those of the whole
 * body that they were made from. Copies lie at rest where their origins do. Its links are the edges of its surface: which
 * of the others a cut has left is not known here.
 */
export function cutBody(body, words) {
  const restM = body.restM.slice();
  const [triangles, origins] = [[], []];
  for (let start = 0; start < words.length; start += 6) {
    const [cells, from] = [words.subarray(start, start + 3), words.subarray(start + 3, start + 6)];
    for (let k = 0; k < 3; k++) restM.set(at(body.restM, from[k]), 3 * cells[k]);
    // A triangle that is gone lies in one cell, and keeps its number.
    triangles.push(...cells);
    origins.push(...from);
  }
  return { ...body, links: null, restM, triangles: Uint32Array.from(triangles), origins: Uint32Array.from(origins) };
}
