// The page with its own kernel: loads from a file, is pressed by a drag, and comes to the same state as `chaincell
// run`, with and without vector units. node own.mjs PAGE.html CHAINCELL VECTOR.wasm FOLDER [SCALAR.wasm]
import assert from "node:assert/strict";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { Tissue } from "../../host/view/kernel.mjs";
import { partsOf } from "../../host/view/parts.mjs";
import { Browser } from "./browser.mjs";
import { playedNatively } from "./native.mjs";

const [page, chaincell, vector, folder, scalar] = process.argv.slice(2);
/** Ticks of the drag that is played natively. */
const TICKS = 1000;
mkdirSync(folder, { recursive: true });

/** Where a ball is on the page. */
const ball = (tool) => `(() => { const { x, y } = chaincell.camera.project(chaincell.state.tools[${tool}].positionM);
  const { left, top } = document.getElementById("stage").getBoundingClientRect(); return [left + x, top + y]; })()`;
/** The drawn picture's pixels, kept on the page under a name; returns how many the body covers. */
const pixels = (name) => `(() => { const copy = chaincell.scene.picture("#00ff00");
  const { data } = copy.getContext("2d").getImageData(0, 0, copy.width, copy.height);
  globalThis.${name} = data; let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i + 1] !== 255 || data[i] !== 0;
  return count; })()`;
/** The first ball and its arrow on the picture, in pixels of a screen that has one for each of CSS. */
const SHAPES = `(() => { const [tool] = chaincell.state.tools; const { x, y, pixelsPerM } = chaincell.camera.project(tool.positionM);
  const tip = chaincell.scene.forceTip() ?? { x, y };
  return { x, y, radius: tool.radiusM * pixelsPerM, along: [tip.x - x, tip.y - y] }; })()`;
/**
 * Of the body's pixels around the press, how many there are and how many changed: those that the body covers before and
 * after, where neither ball nor arrow is, nor the ball's shadow, which reaches 2.1 radii.
 */
const changes = (shapes) => `(() => { const shapes = ${JSON.stringify(shapes)}; const wide = chaincell.scene.canvas.width;
  const isBody = (data, i) => data[i + 1] !== 255 || data[i] !== 0;
  const near = ({ x, y, radius, along: [ax, ay] }, px, py, radii) => {
    const share = Math.max(0, Math.min(1, ((px - x) * ax + (py - y) * ay) / (ax * ax + ay * ay || 1)));
    return Math.hypot(px - x, py - y) < radii * radius || Math.hypot(px - x - share * ax, py - y - share * ay) < 0.6 * radius; };
  let [area, changed] = [0, 0];
  for (let i = 0; i < before.length; i += 4) {
    const [px, py] = [(i / 4) % wide, Math.floor(i / 4 / wide)];
    if (!isBody(before, i) || !isBody(after, i) || !near(shapes[1], px, py, 4.5)) continue;
    if (shapes.some((shape) => near(shape, px, py, 2.15))) continue;
    area += 1;
    changed += Math.abs(before[i] - after[i]) + Math.abs(before[i + 1] - after[i + 1]) > 24;
  }
  return { area, changed }; })()`;
/** Counts what is drawn before there is a state, and notes the tick of the first picture. */
const WATCH = `{ const clear = WebGL2RenderingContext.prototype.clear; globalThis.drawn = { early: 0, firstTick: null };
  WebGL2RenderingContext.prototype.clear = function (mask) { const state = globalThis.chaincell?.state;
    if (state) drawn.firstTick ??= state.tick; else drawn.early += 1; return clear.call(this, mask); }; }`;

/** What ChainMail shows: how far its cells moved and rose, how deep the deepest is in the ball [m], pixels of its picture. */
const CHAIN = `(() => { const { mail } = chaincell.scene.chain; const [{ positionM, radiusM }] = chaincell.state.tools;
  const far = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);
  const cell = (array, index) => array.subarray(3 * index, 3 * index + 3);
  const movedM = Math.max(...mail.surface.map((index) => far(cell(mail.positionsM, index), cell(mail.restM, index))));
  const insideM = Math.max(...mail.surface.map((index) => radiusM - far(cell(mail.positionsM, index), positionM)));
  const raisedM = Math.max(...mail.surface.map((index) => mail.positionsM[3 * index + 2] - mail.restM[3 * index + 2]));
  const wide = chaincell.scene.canvas.width; let covered = 0;
  for (let i = 0; i < both.length; i += 4) covered += (i / 4) % wide > wide / 2 && (both[i + 1] !== 255 || both[i] !== 0);
  return { movedM, insideM, raisedM, covered }; })()`;

/** Plays a saved path in a module and returns the hash. */
async function played(wasm, image, path, kinds) {
  const { instance } = await WebAssembly.instantiate(readFileSync(wasm));
  const tissue = new Tissue(instance, image, false);
  tissue.init(0);
  tissue.resetWithTools(kinds.map(partsOf), 0);
  const rows = path.trim().split("\n").slice(1).map((row) => row.split(",").map(Number));
  for (let row = 0; row < rows.length; row += kinds.length) {
    const tick = rows.slice(row, row + kinds.length);
    tissue.tick(tick.flatMap((numbers) => numbers.slice(2, 9)), tick[0][10]);
  }
  return tissue.hash();
}

/** Drags a ball down until the body has felt it and that many ticks have gone by. */
async function drag(browser, tool, ticks) {
  const [x, y] = await browser.evaluate(ball(tool));
  await browser.move(x, y);
  await browser.mouse("mousePressed", x, y);
  for (let step = 1; step <= 4; step++) await browser.mouse("mouseMoved", x + 2 * step, y + 14 * step);
  await browser.until(`chaincell.state.tick >= ${ticks} && chaincell.state.tools[${tool}].contacts > 0`);
  await browser.mouse("mouseReleased", x + 8, y + 56);
}

/** The stress after von Mises by node in a VTU file [Pa]. */
function stressesOf(file) {
  const vtu = readFileSync(file, "utf8");
  const [nodes, stressesPa] = ["node", "von_mises_pa"].map((name) => vtu.match(new RegExp(`Name="${name}"[^>]*>([^<]*)<`))[1].trim().split(/\s+/).map(Number));
  return new Map(nodes.map((node, index) => [node, Math.fround(stressesPa[index])]));
}

/** Processor seconds of a browser from its start until a page has drawn its first picture. */
async function costS(file, isDrawn) {
  const browser = await Browser.start({ width: 960, height: 640 });
  try {
    await browser.goto(`file://${resolve(file)}`);
    await browser.until(isDrawn);
    return await browser.processorS();
  } finally {
    await browser.stop();
  }
}

const empty = join(folder, "empty.html");
writeFileSync(empty, "<!doctype html><title>empty</title><p>Nothing");
const emptyS = await costS(empty, "new Promise((go) => requestAnimationFrame(() => requestAnimationFrame(() => go(document.title === 'empty'))))");
const firstS = await costS(page, "globalThis.chaincell?.frames > 0");

const browser = await Browser.start({ width: 960, height: 640 });
try {
  await browser.page("Page.addScriptToEvaluateOnNewDocument", { source: WATCH });
  await browser.goto(`file://${resolve(page)}`);
  await browser.until("globalThis.chaincell?.frames > 0");
  assert.deepEqual(await browser.evaluate("drawn"), { early: 0, firstTick: 0 }, "drawn before there was a body, or after the first tick");
  assert.equal(await browser.evaluate("document.getElementById('hint').hidden"), false);
  await browser.click("pause");
  await browser.click("reset");
  await browser.until("chaincell.state.tick === 0 && !chaincell.scene.isNew");

  const covered = await browser.evaluate(pixels("before"));
  const shapes = [await browser.evaluate(SHAPES)];
  await browser.picture(join(folder, "rest.png"));
  await browser.click("pause");
  await drag(browser, 0, TICKS);
  await browser.click("pause");
  await browser.until("chaincell.state.ticksPerS === 0");
  await browser.evaluate(pixels("after"));
  shapes.push(await browser.evaluate(SHAPES));
  const { area, changed } = await browser.evaluate(changes(shapes));
  await browser.picture(join(folder, "pressed.png"));
  assert.ok(covered > 30_000, `the body covers ${covered} pixels`);
  assert.ok(area > 2000 && changed > 0.3 * area, `${changed} of ${area} pixels of the body around the press changed`);
  const forceN = await browser.evaluate("Math.hypot(...chaincell.state.tools[0].forceN)");
  assert.ok(forceN > 0.02, `force ${forceN} N`);

  const { path, image, kinds, ticks, hash } = await playedNatively(browser, chaincell, "organ", join(folder, "one"));
  assert.equal(await played(vector, image, path, kinds), hash, "with vector units, in Node.js");
  if (scalar) assert.equal(await played(scalar, image, path, kinds), hash, "without vector units");

  // Every quantity, and a tick by hand.
  for (const colour of ["stretch", "stress", "pressure", "displacement"]) {
    await browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "${colour}"; e.onchange(); })()`);
    await browser.until(`chaincell.scene.look.colour === "${colour}" && !chaincell.scene.isNew`);
    if (colour === "stress") {
      // Of the surface it is what the command has written, to the bit.
      await browser.until("Math.max(...chaincell.state.stressesPa) > 0 && !chaincell.scene.isNew");
      const written = stressesOf(join(folder, "one", "organ", "final.vtu"));
      const shown = await browser.evaluate("chaincell.scene.figure.surface.cells.map((cell, index) => [chaincell.source.body.inputIds[cell], chaincell.state.stressesPa[index]])");
      assert.ok(shown.length > 100 && shown.every(([, stressPa]) => stressPa > 0), `${shown.length} stresses`);
      assert.deepEqual(shown.map(([node]) => written.get(node)), shown.map(([, stressPa]) => stressPa));
    }
    await browser.picture(join(folder, `${colour}.png`));
  }
  assert.equal(await browser.evaluate("document.getElementById('replay').hidden"), false);
  await browser.click("step");
  await browser.until(`chaincell.state.tick === ${ticks} + 1`);
  // The command comes to the state before.
  assert.equal(await browser.evaluate("document.getElementById('replay').hidden"), true);

  // ChainMail under the same ball: beside the body, its cells put out of the ball, and nothing of it without the switch.
  assert.equal(await browser.evaluate("chaincell.scene.chain"), null);
  await browser.click("beside");
  await browser.until("chaincell.scene.chain && !chaincell.scene.isNew");
  await browser.evaluate(pixels("both"));
  const chain = await browser.evaluate(CHAIN);
  await browser.picture(join(folder, "beside.png"));
  assert.ok(chain.movedM > 1e-3 && chain.insideM < 1e-3 && chain.raisedM < 3e-3 && chain.covered > 10_000, JSON.stringify(chain));
  assert.equal(await browser.evaluate("document.getElementById('captions').hidden"), false);
  await browser.click("beside");
  await browser.until("chaincell.scene.chain === null && chaincell.camera.pictures === 1");

  // A second ball: the one that is taken moves, and both come to the native state.
  await browser.click("add-tool");
  await browser.until("chaincell.state.tools.length === 2 && !chaincell.scene.isNew");
  const apart = await browser.evaluate("Math.hypot(...[0, 1].map((axis) => chaincell.state.tools[0].positionM[axis] - chaincell.state.tools[1].positionM[axis]))");
  assert.ok(apart > 0.02, `the balls are ${apart} m apart`);
  await browser.click("pause");
  await drag(browser, 0, 100);
  assert.equal(await browser.evaluate("chaincell.chosen"), 0);
  await drag(browser, 1, 300);
  assert.equal(await browser.evaluate("chaincell.chosen"), 1);
  await browser.click("pause");
  await browser.until("chaincell.state.ticksPerS === 0 && !chaincell.scene.isNew");
  await browser.picture(join(folder, "two.png"));
  const forces = await browser.evaluate("chaincell.state.tools.map(({ forceN }) => Math.hypot(...forceN))");
  assert.ok(forces.every((force) => force > 0.01), `forces ${forces} N`);
  const two = await playedNatively(browser, chaincell, "organ", join(folder, "two"));
  assert.equal(two.kinds.length, 2);
  assert.equal(await played(vector, two.image, two.path, two.kinds), two.hash, "two balls, in Node.js");
  await browser.click("remove-tool");
  await browser.until("chaincell.state.tools.length === 1");
  assert.deepEqual(browser.console, [], "the console is clean");
  console.log(`view: ok, ${ticks} ticks, ${forceN.toFixed(3)} N, hash ${hash} in the page, natively, with${scalar ? " and without" : ""} vector ` +
    `units; ${changed} of ${area} pixels of the body around the press changed; two balls ${forces.map((force) => force.toFixed(3)).join(" and ")} N, ` +
    `${two.ticks} ticks, hash ${two.hash}; first picture ${firstS.toFixed(1)} processor seconds after the start of the browser, an empty page ${emptyS.toFixed(1)}: ${(firstS - emptyS).toFixed(1)} for this one`);
} finally {
  await browser.stop();
}

// A finger on a phone's screen.
const phone = await Browser.start({ width: 390, height: 844, isPhone: true, scheme: "dark", scale: 2 });
try {
  await phone.goto(`file://${resolve(page)}`);
  await phone.until("globalThis.chaincell?.frames > 0");
  const [x, y] = await phone.evaluate(ball(0));
  await phone.touch("touchStart", [{ x, y }]);
  for (let step = 1; step <= 4; step++) await phone.touch("touchMove", [{ x, y: y + 10 * step }]);
  await phone.until("document.getElementById('hint').hidden && Math.hypot(...chaincell.state.tools[0].forceN) > 0.02");
  await phone.picture(join(folder, "phone.png"));
  await phone.touch("touchEnd", []);
  const wide = await phone.evaluate("document.documentElement.scrollWidth");
  assert.ok(wide <= 390, `the page is ${wide} pixels wide`);
  assert.deepEqual(phone.console, [], "the console is clean");
} finally {
  await phone.stop();
}
