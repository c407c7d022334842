// The page's ChainMail on one press, against that of the laboratory, whose test makes chainmail.json.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { ChainMail } from "../../host/view/chainmail.mjs";

const press = JSON.parse(readFileSync(new URL("chainmail.json", import.meta.url)));
/** Sums of coordinates in another order [m]. */
const ROUNDING_M = 1e-12;
const body = { restM: press.rest_m.flat(), links: press.links.flat(), fixed: press.fixed, triangles: press.triangles.flat() };
const chain = new ChainMail(body, press.alpha);
const farthest = (places) => places.flat().reduce((most, x, index) => Math.max(most, Math.abs(x - chain.positionsM[index])), 0);

assert.ok(farthest(press.held_m) > 1e-3, "the press moves nothing");
for (const positionM of press.path_m) {
  chain.push([{ kind: `sphere:${press.radius_m}`, positionM, orientation: [0, 0, 0, 1] }]);
}
assert.ok(farthest(press.held_m) < ROUNDING_M, `pressed, ${farthest(press.held_m)} m apart`);
for (let sweep = 0; sweep < 8; sweep++) chain.relax();
assert.ok(farthest(press.relaxed_m) < ROUNDING_M, `relaxed, ${farthest(press.relaxed_m)} m apart`);

// Every kind of tool, above a cell of the top, puts what is inside it on its surface; far away it lets go. One that is
// deep in the body at once pushes cells down too, as one that came from outside.
const [x, y, top] = press.rest_m[press.rest_m.length - 15];
for (const kind of ["sphere:0.008", "capsule:0.01,0.004", "box:0.006,0.006,0.003,0.002", "half-space:0.005"]) {
  const other = new ChainMail(body);
  const upsideDown = kind.startsWith("half") ? [1, 0, 0, 0] : [0, 0, 0, 1];
  const at = (z) => ({ kind, engaged: true, orientation: upsideDown, positionM: [x, y, z] });
  other.follow({ tick: 0, tools: [at(top - 0.001)] });
  const moved = () => other.positionsM.reduce((most, place, index) => Math.max(most, Math.abs(place - other.restM[index])), 0);
  const raised = other.surface.reduce((most, element) => Math.max(most, other.positionsM[3 * element + 2] - other.restM[3 * element + 2]), 0);
  assert.ok(moved() > 5e-4 && raised < 2e-3, `${kind} moves ${moved()} m, up ${raised} m`);
  const before = other.positionsM.slice();
  other.push([at(top - 0.001)]);
  const again = other.positionsM.reduce((most, place, index) => Math.max(most, Math.abs(place - before[index])), 0);
  assert.ok(again < 5e-4, `${kind}: elements were left ${again} m inside`);
  for (let tick = 10; tick < 4000; tick += 10) other.follow({ tick, tools: [at(top + 0.018)] });
  for (let tick = 4000; tick < 8000; tick += 10) other.follow({ tick, tools: [{ ...at(top), engaged: false }] });
  assert.ok(moved() < 1e-4, `${kind}: ${moved()} m after letting go`);
}
console.log("ok: ChainMail of the page and of the laboratory");
