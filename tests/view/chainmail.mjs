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

// Every kind of tool puts what is inside it on its surface, and lets go of it far away.
for (const kind of ["capsule:0.01,0.004", "box:0.006,0.006,0.003,0.002", "half-space:0.005"]) {
  const other = new ChainMail(body);
  const top = Math.max(...other.restM.filter((_, index) => index % 3 === 2));
  const upsideDown = kind.startsWith("half") ? [1, 0, 0, 0] : [0, 0, 0, 1];
  const at = (z) => ({ kind, engaged: true, orientation: upsideDown, positionM: [0, 0, z] });
  other.follow({ tick: 0, tools: [at(top + 0.006)] });
  other.follow({ tick: 10, tools: [at(top - 0.001)] });
  const moved = () => Math.max(...other.positionsM.map((x, index) => Math.abs(x - other.restM[index])));
  assert.ok(moved() > 1e-3 && Number.isFinite(moved()), `${kind} moves ${moved()} m`);
  assert.equal(other.push([at(top - 0.001 + 1e-9)]), false, `${kind}: elements are left inside`);
  for (let tick = 20; tick < 4000; tick += 10) other.follow({ tick, tools: [at(top + 0.02)] });
  assert.ok(moved() < 1e-4, `${kind}: ${moved()} m after letting go`);
}
console.log("ok: ChainMail of the page and of the laboratory");
