// Frames of a running scene that cannot be read are refused, and contacts are put on the triangles that the kernel
// has them on. node contacts.mjs MODULE.wasm CHAINCELL FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { pressuresOf, trianglesAround } from "../../host/view/contacts.mjs";
import { bodyOf } from "../../host/view/image.mjs";
import { BYTES, Tissue } from "../../host/view/kernel.mjs";
import { frameOf } from "../../host/view/live.mjs";
import { partsOf } from "../../host/view/parts.mjs";

const [wasm, chaincell, folder] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });

/** A frame of one contact, two stresses and two cells, without tools and points. */
function frame(version = 4, contacts = 1) {
  const view = new DataView(new ArrayBuffer(68 + 20 + 8 + 24));
  const words = [[0, version], [4, 0xc4ec], [56, 2], [60, contacts], [64, 2], [68, 1]];
  for (const [place, word] of words) view.setUint32(place, word, true);
  [7, 8, 9, 2500, 300, 400, 0.5].forEach((number, index) => view.setFloat32(72 + 4 * index, number, true));
  return view.buffer;
}

/** A frame with bytes after it. */
function longer(bytes, words = []) {
  const long = new Uint8Array(frame().byteLength + bytes);
  long.set(new Uint8Array(frame()));
  new Uint32Array(long.buffer, frame().byteLength).set(words);
  return long.buffer;
}

const read = frameOf(frame());
assert.deepEqual(read.contacts, [{ cell: 1, positionM: [7, 8, 9], pressurePa: 2500 }]);
assert.deepEqual(read.stressesPa, [300, 400]);
assert.deepEqual([...read.positionsM], [0.5, 0, 0, 0, 0, 0]);
assert.equal(read.triangles.length, 0);
const cut = frameOf(longer(24, [2, 1, 0, 1, 1, 0]));
assert.deepEqual([cut.positionsM, [...cut.triangles]], [read.positionsM, [2, 1, 0, 1, 1, 0]]);
for (const bytes of [4, 20, 28]) assert.throws(() => frameOf(longer(bytes)), /another length/);
for (const version of [0, 1, 2, 3]) assert.throws(() => frameOf(frame(version)), /another release/);
for (const bytes of [0, 3, 67]) assert.throws(() => frameOf(frame().slice(0, bytes)), /another release/);
for (const bytes of [68, 88, 119]) assert.throws(() => frameOf(frame().slice(0, bytes)), /another length/);
for (const contacts of [0, 2, 0xffff_ffff]) assert.throws(() => frameOf(frame(4, contacts)), /another length/);

const model = join(folder, "organ.chaincell");
execFileSync(chaincell, ["bake", "organ:1000", "-o", model], { stdio: ["ignore", "ignore", "inherit"] });
const image = new Uint8Array(readFileSync(model));
const { rest, triangles, unitM, centreM } = bodyOf(image);
const around = trianglesAround(triangles);
const { instance } = await WebAssembly.instantiate(readFileSync(wasm));
const tissue = new Tissue(instance, image);
tissue.init(0);

/** The kernel's contacts as a frame has them, and the triangle of each. */
function contacts() {
  const pressures = tissue.pressuresPa();
  const view = tissue.view();
  return pressures.map(([triangle, pressurePa], index) => {
    const start = tissue.contacts + BYTES.contact * index;
    const positionM = [0, 1, 2].map((axis) => view.getFloat32(start + 4 * axis, true));
    return { triangle, cell: view.getUint32(start + 44, true), positionM, pressurePa };
  });
}

/** The highest cell near a place across the top. */
function top(x, y) {
  const height = (cell) => rest[3 * cell + 2] - 2 * Math.hypot(rest[3 * cell] - x, rest[3 * cell + 1] - y);
  return triangles.reduce((best, cell) => (height(cell) > height(best) ? cell : best), triangles[0]);
}

let [all, same] = [0, 0];
for (const kind of ["sphere:0.012", "sphere:0.004", "capsule:0.03,0.004"]) {
  for (const [x, y] of [[0, 0], [2, 1], [-3, 1.5]]) {
    tissue.resetWithTools([partsOf(kind)], 0);
    const cell = top(x, y);
    const place = [0, 1, 2].map((axis) => rest[3 * cell + axis] * unitM + centreM[axis]);
    for (let tick = 0; tick < 80; tick++) {
      tissue.tick([place[0], place[1], place[2] + 0.012 - 0.0002 * tick, 0, 0, 0, 1], 4);
      const found = contacts();
      const pairs = pressuresOf(found, tissue.positionsM(), triangles, around);
      assert.equal(pairs.length, found.length);
      all += found.length;
      same += found.filter(({ triangle }, index) => triangle === pairs[index][0]).length;
    }
  }
}
assert.ok(all > 1000, `${all} contacts`);
assert.ok(same >= 0.99 * all, `${same} of ${all} contacts are on their triangle`);
assert.deepEqual(pressuresOf([{ cell: 1e6, positionM: [0, 0, 0], pressurePa: 1 }], rest, triangles, around), [], "a cell that is not there");
console.log(`contacts: ok, ${same} of ${all} on the triangle that the kernel has them on`);
