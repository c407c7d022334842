// The page with its own kernel: loads from a file, is pressed by a drag, and comes to the same state as `chaincell
// run`, with and without vector units. node own.mjs PAGE.html CHAINCELL VECTOR.wasm FOLDER [SCALAR.wasm]
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { Tissue } from "../../host/view/kernel.mjs";
import { partsOf } from "../../host/view/parts.mjs";
import { Browser } from "./browser.mjs";

const [page, chaincell, vector, folder, scalar] = process.argv.slice(2);
/** Ticks of the drag that is played natively. */
const TICKS = 1000;
mkdirSync(folder, { recursive: true });

/** Where the ball is on the page. */
const BALL = `(() => { const { x, y } = chaincell.camera.project(chaincell.state.tools[0].positionM);
  const { left, top } = document.getElementById("stage").getBoundingClientRect(); return [left + x, top + y]; })()`;
/** The drawn picture's pixels, kept on the page under a name; returns how many the body covers. */
const pixels = (name) => `(() => { const copy = chaincell.scene.picture("#00ff00");
  const { data } = copy.getContext("2d").getImageData(0, 0, copy.width, copy.height);
  globalThis.${name} = data; let count = 0;
  for (let i = 0; i < data.length; i += 4) count += data[i + 1] !== 255 || data[i] !== 0;
  return count; })()`;
const CHANGED = `(() => { let count = 0; for (let i = 0; i < before.length; i += 4)
  count += Math.abs(before[i] - after[i]) + Math.abs(before[i + 1] - after[i + 1]) > 24; return count; })()`;

/** Plays a saved path in a module and returns the hash. */
async function played(wasm, image, path, tool) {
  const { instance } = await WebAssembly.instantiate(readFileSync(wasm));
  const tissue = new Tissue(instance, image);
  tissue.init(0);
  tissue.resetWithTool(partsOf(tool), 0);
  for (const row of path.trim().split("\n").slice(1)) {
    const numbers = row.split(",").map(Number);
    tissue.tick(numbers.slice(2, 9), numbers[9] === 1, numbers[10]);
  }
  return tissue.hash();
}

/** Drags the ball down until the body has felt it for long enough. */
async function drag(browser) {
  const [x, y] = await browser.evaluate(BALL);
  await browser.move(x, y);
  await browser.mouse("mousePressed", x, y);
  for (let step = 1; step <= 4; step++) await browser.mouse("mouseMoved", x + 2 * step, y + 14 * step);
  await browser.until(`chaincell.state.tick >= ${TICKS} && chaincell.state.tools[0].contacts > 0`);
  await browser.mouse("mouseReleased", x + 8, y + 56);
}

const browser = await Browser.start({ width: 960, height: 640 });
try {
  const beganS = await browser.processorS();
  await browser.goto(`file://${resolve(page)}`);
  await browser.until("globalThis.chaincell?.frames > 0");
  const firstS = (await browser.processorS()) - beganS;
  assert.equal(await browser.evaluate("document.getElementById('hint').hidden"), false);
  await browser.click("pause");
  await browser.click("reset");
  await browser.until("chaincell.state.tick === 0 && !chaincell.scene.isNew");

  const covered = await browser.evaluate(pixels("before"));
  await browser.picture(join(folder, "rest.png"));
  await browser.click("pause");
  await drag(browser);
  await browser.click("pause");
  await browser.until("chaincell.state.ticksPerS === 0");
  await browser.evaluate(pixels("after"));
  const changed = await browser.evaluate(CHANGED);
  await browser.picture(join(folder, "pressed.png"));
  assert.ok(covered > 30_000, `the body covers ${covered} pixels`);
  assert.ok(changed > 0.05 * covered, `${changed} of ${covered} pixels changed under the press`);
  const forceN = await browser.evaluate("Math.hypot(...chaincell.state.tools[0].forceN)");
  assert.ok(forceN > 0.02, `force ${forceN} N`);

  await browser.click("save-path");
  const path = (await browser.downloaded(".csv")).toString();
  await browser.click("save-model");
  const image = await browser.downloaded(".chaincell");
  const { hash, tool, ticks } = await browser.evaluate(
    "({ hash: chaincell.state.hash, tool: chaincell.source.setup.tool, ticks: chaincell.state.tick })");
  assert.equal(path.trim().split("\n").length - 1, ticks);
  const command = await browser.evaluate("document.getElementById('command').textContent");
  assert.ok(command.includes(hash), command);

  // The command that the page shows, in the folder with what it saved.
  writeFileSync(join(folder, "organ.csv"), path);
  writeFileSync(join(folder, "organ.chaincell"), image);
  const words = command.split("#")[0].trim().split(/\s+/).slice(1);
  const said = execFileSync(resolve(chaincell), [...words, "--force", "--json"], { cwd: folder, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  const native = JSON.parse(said.trim().split("\n").pop()).state_hash;
  assert.equal(hash, native, "the page's hash and that of chaincell run");
  assert.equal(await played(vector, image, path, tool), native, "with vector units, in Node.js");
  if (scalar) assert.equal(await played(scalar, image, path, tool), native, "without vector units");

  // Every quantity, and a tick by hand.
  for (const colour of ["stretch", "pressure", "displacement"]) {
    await browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "${colour}"; e.onchange(); })()`);
    await browser.until(`chaincell.scene.look.colour === "${colour}" && !chaincell.scene.isNew`);
    await browser.picture(join(folder, `${colour}.png`));
  }
  await browser.click("step");
  await browser.until(`chaincell.state.tick === ${ticks} + 1`);
  assert.deepEqual(browser.console, [], "the console is clean");
  console.log(`view: ok, ${ticks} ticks, ${forceN.toFixed(3)} N, hash ${hash} in the page, natively, with${scalar ? " and without" : ""} vector ` +
    `units; ${changed} of ${covered} pixels changed; first picture after ${firstS.toFixed(1)} processor seconds`);
} finally {
  await browser.stop();
}

// A finger on a phone's screen.
const phone = await Browser.start({ width: 390, height: 844, isPhone: true, scheme: "dark", scale: 2 });
try {
  await phone.goto(`file://${resolve(page)}`);
  await phone.until("globalThis.chaincell?.frames > 0");
  const [x, y] = await phone.evaluate(BALL);
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
