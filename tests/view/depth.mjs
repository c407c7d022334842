// The depth of a tool that a page shows. node depth.mjs
import assert from "node:assert/strict";
import { depthOf, touchOf, UNSEEN } from "../../host/view/depth.mjs";

/** What a tool above a body feels that begins at z = 0. */
const felt = (z) => ({ isTouching: z < 0, forceN: [0, 0, Math.max(0, -z)], positionM: [0, 0, z] });
/** The depths of a tool on its way. */
const depths = (first, way) => {
  let touched = first;
  return way.map((z) => {
    touched = touchOf(touched, felt(z));
    return Number(depthOf(touched, [0, 0, z]).toFixed(6));
  });
};

assert.deepEqual(depths(null, [0.001, -0.001, -0.003, -0.002, 0.001, -0.002]), [0, 0, 0.002, 0.001, 0, 0]);
// A press that had begun before has a depth once the tool was out.
assert.deepEqual(depths(UNSEEN, [-0.003, -0.002, 0.001, -0.001, -0.004]), [NaN, NaN, 0, 0, 0.003]);
console.log("ok: depths");
