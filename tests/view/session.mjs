// A recorded session in the page: some hundred ticks with late ones, a pin and a change of settings come to the hash of
// `chaincell replay`, forwards and backwards. node session.mjs CHAINCELL FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { Browser } from "./browser.mjs";
import { hashOf, sweepsOf, withCommand } from "./trace.mjs";

const [chaincell, folder] = process.argv.slice(2);
const at = (name) => join(folder, name);
const command = (...words) => execFileSync(chaincell, words, { encoding: "utf8" });
const TICKS = 600;
const CHANGE_TICK = 300;
/** A tick before the change whose state is looked at again, its hash in the trace. */
const LOOK_TICK = 270;

/** A press from above with a sideways motion; every seventh tick is late, every fifth has two sweeps. */
function path([x, y, z]) {
  const rows = Array.from({ length: TICKS }, (_, tick) => {
    const depthM = 0.012 * Math.sin((Math.PI * tick) / TICKS);
    const sweeps = tick % 7 === 3 ? 0 : tick % 5 === 1 ? 2 : "";
    return `${tick},${x + 0.004 * Math.sin(tick / 60)},${y},${z + 0.0125 - depthM},1,${sweeps}`;
  });
  return `tick,x_m,y_m,z_m,engaged,sweeps\n${rows.join("\n")}\n`;
}

mkdirSync(at("changed"), { recursive: true });
command("bake", "box:9x7x4x0.01", "--young-pa", "5000", "-o", at("box.chaincell"));
writeFileSync(at("path.csv"), path([0, 0, 0.03]));
command("run", at("box.chaincell"), "--path", at("path.csv"), "--recorded", "--tool", "sphere:0.012", "--pin", "0.02,0,0.03,0.012", "--out", at("run"), "--force", "--json");
const trace = readFileSync(at("run/session.trace"));
writeFileSync(at("changed/session.trace"), withCommand(trace, CHANGE_TICK, sweepsOf(9)));
copyFileSync(at("run/model.chaincell"), at("changed/model.chaincell"));
const replayed = JSON.parse(command("replay", at("changed"), "--json"));
assert.equal(replayed.ticks, TICKS);
assert.equal(replayed.commands, 2);
const unchanged = JSON.parse(readFileSync(at("run/summary.json"), "utf8"));
assert.notEqual(replayed.state_hash, unchanged.state_hash, "the change has no effect");
command("view", at("changed"), "--html", at("session.html"));

const browser = await Browser.start();
try {
  await browser.goto(`file://${resolve(at("session.html"))}`);
  await browser.until("globalThis.chaincell?.state");
  await browser.evaluate(`document.getElementById("speed").value = "1000"; document.getElementById("speed").onchange()`);
  const isThere = (tick) => `chaincell.state.tick === ${tick} && !chaincell.state.session.isSeeking`;
  const go = async (tick) => {
    // The state that stands there now is not the answer, even where it has this tick.
    await browser.evaluate(`(() => { chaincell.state.session.isSeeking = true; const scrub = document.getElementById("scrub"); scrub.value = ${tick}; scrub.oninput(); })()`);
    await browser.until(isThere(tick));
    return browser.evaluate("({ hash: chaincell.state.hash, force: Math.hypot(...chaincell.state.tools[0].forceN), session: chaincell.state.session })");
  };
  await browser.until(isThere(TICKS - 1));
  const end = await go(TICKS - 1);
  assert.equal(end.hash, replayed.state_hash, "the end");
  assert.equal(end.session.differs, null);
  assert.ok(end.session.compared >= TICKS / 20, `${end.session.compared} hashes compared`);
  assert.equal(await browser.evaluate(`document.getElementById("pause").textContent`), "Go on", "it stops at the end");
  // The stress is there in a pause too.
  const show = (colour) => browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "${colour}"; e.onchange(); })()`);
  await show("stress");
  await browser.until("chaincell.state.stressesPa.length > 100 && Math.max(...chaincell.state.stressesPa) > 0");
  await show("displacement");
  await browser.until("chaincell.state.stressesPa.length === 0");
  // Backwards, one tick on, and to the end once more.
  const look = await go(LOOK_TICK);
  assert.equal(look.hash, hashOf(trace, LOOK_TICK), `tick ${LOOK_TICK}`);
  assert.ok(look.force > 0.05, `${look.force} N`);
  const pinN = await browser.evaluate("chaincell.state.pins.map(({ forceN }) => Math.hypot(...forceN))");
  assert.ok(pinN.length === 1 && pinN[0] > 1e-3, `forces on pins ${pinN} N`);
  await browser.picture(at("session.png"));
  await browser.click("step");
  await browser.until(isThere(LOOK_TICK + 1));
  assert.equal(await browser.evaluate("chaincell.state.hash"), hashOf(trace, LOOK_TICK + 1));
  assert.equal((await go(TICKS - 1)).hash, replayed.state_hash, "the end after a step back");
  assert.deepEqual(browser.console, []);
  console.log(`ok: ${TICKS} ticks in the page, state hash ${replayed.state_hash}, ${end.session.compared} hashes compared`);
} finally {
  await browser.stop();
}
