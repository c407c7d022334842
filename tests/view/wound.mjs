// A body that is cut in the page: a blade and scissors of the page's own open it as chaincell run does, a recorded session shows its
// wound, forwards and backwards, and a running scene shows it to a page that comes late too, until a reset and after a
// restart. node wound.mjs CHAINCELL FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdirSync, readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { Browser } from "./browser.mjs";
import { playedNatively } from "./native.mjs";
import { addressOf, endAll, starter } from "./programs.mjs";
import { RESET, withCommand } from "./trace.mjs";

const [chaincell, folder] = process.argv.slice(2);
const started = starter(chaincell);
const at = (name) => join(folder, name);
const command = (...words) => execFileSync(chaincell, words, { encoding: "utf8" });
const BLADE = "blade:0.06/0,0,0.7071068,0.7071068";
/** Ticks of each of two cuts, between which the body is put to rest. */
const CUT_TICKS = 400;
/** Number of triangles that the page draws. */
const DRAWN = "chaincell.scene.figure.surface.triangles.length / 3";
/** The surface is that of the state. */
const IS_SHOWN = "chaincell.scene.triangles === undefined && !chaincell.scene.isNew";
/** Edges of two triangles that do not run once in each direction: 0 of a closed surface. */
const LOOSE_EDGES = `(() => { const { triangles } = chaincell.scene.figure.surface; const edges = new Map();
  triangles.forEach((cell, corner) => { const to = triangles[corner % 3 === 2 ? corner - 2 : corner + 1];
    const [key, way] = cell < to ? [cell * 65536 + to, 1] : [to * 65536 + cell, -1]; edges.set(key, (edges.get(key) ?? 0) + way); });
  return [...edges.values()].filter((sum) => sum !== 0).length; })()`;

mkdirSync(folder, { recursive: true });
command("bake", "box:9x7x5x0.005", "--young-pa", "5000", "--poisson", "0.3", "--cuttable", "--toughness-j-per-m2", "4",
  "--cut-spare", "0.5", "-o", at("slab.chaincell"));
command("run", at("slab.chaincell"), "--motion", "press", "--touch-m", "0,0,0.0201", "--direction=0,0,-1", "--depth-m", "0.012",
  "--seconds", "1", "--tool", BLADE, "--out", at("cut"), "--force", "--json");
const replayed = JSON.parse(command("replay", at("cut"), "--json"));
command("view", at("cut"), "--html", at("cut.html"));
const cutsOf = [-0.0101, 0.0101].flatMap((x, cut) =>
  Array.from({ length: CUT_TICKS }, (_, tick) => `${cut * CUT_TICKS + tick},${x},0,${0.0205 - 2e-5 * tick},1`));
writeFileSync(at("two.csv"), `tick,x_m,y_m,z_m,engaged\n${cutsOf.join("\n")}\n`);
// The first of them by a controller, whose tool is released before.
writeFileSync(at("one.csv"), `tick,x_m,y_m,z_m,engaged\n${[cutsOf[0].replace(/1$/, "0"), ...cutsOf.slice(1, CUT_TICKS)].join("\n")}\n`);
command("run", at("slab.chaincell"), "--path", at("two.csv"), "--tool", BLADE, "--out", at("two"), "--force", "--json");
mkdirSync(at("reset"), { recursive: true });
writeFileSync(at("reset/session.trace"), withCommand(readFileSync(at("two/session.trace")), CUT_TICKS - 1, RESET));
copyFileSync(at("two/model.chaincell"), at("reset/model.chaincell"));
command("view", at("reset"), "--html", at("reset.html"));
command("view", at("slab.chaincell"), "--tool", BLADE, "--html", at("own.html"));
command("view", at("slab.chaincell"), "--tool", "scissors:0.04", "--html", at("scissors.html"));

const browser = await Browser.start();
try {
  const open = async (page) => {
    await browser.goto(`file://${resolve(at(page))}`);
    await browser.until("globalThis.chaincell?.state");
    await browser.evaluate(`document.getElementById("speed").value = "1000"; document.getElementById("speed").onchange()`);
  };
  // The session: whole at first, a closed surface with a wound at the end, whole again at its start.
  await open("cut.html");
  const { first, last } = await browser.evaluate("chaincell.state.session");
  const go = async (tick) => {
    await browser.evaluate(`(() => { chaincell.state.session.isSeeking = true; const scrub = document.getElementById("scrub"); scrub.value = ${tick}; scrub.oninput(); })()`);
    await browser.until(`chaincell.state.tick === ${tick} && !chaincell.state.session.isSeeking && ${IS_SHOWN}`);
    return browser.evaluate(`({ hash: chaincell.state.hash, cuts: chaincell.state.cuts, session: chaincell.state.session, drawn: ${DRAWN}, loose: ${LOOSE_EDGES} })`);
  };
  await browser.until(`chaincell.state.tick === ${last}`);
  const end = await go(last);
  assert.equal(end.hash, replayed.state_hash, "the end");
  assert.equal(end.session.differs, null);
  assert.ok(end.cuts.openedFaces > 10 && end.cuts.copies > 5, JSON.stringify(end.cuts));
  await browser.picture(at("wound.png"));
  // The stress of all cells of the surface is asked for, those inside the wound among them; fixed corners have none.
  await browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "stress"; e.onchange(); })()`);
  await browser.until("chaincell.state.stressesPa.length === chaincell.scene.figure.surface.stressed.length && chaincell.state.stressesPa.filter((stressPa) => stressPa > 0).length > 0.9 * chaincell.state.stressesPa.length");
  const start = await go(first);
  assert.ok(start.cuts.openedFaces === 0 && start.drawn < end.drawn, `${start.drawn} triangles, cut ${end.drawn}`);
  assert.deepEqual([start.loose, end.loose], [0, 0], "edges at which the surface is open");
  assert.equal((await go(last)).hash, replayed.state_hash, "the end once more");

  // Another cut after a reset is drawn as what it is, also where no state in between was drawn.
  await open("reset.html");
  await browser.until(`chaincell.state.tick === ${2 * CUT_TICKS - 1}`);
  const drawn = "Array.from(chaincell.scene.figure.surface.triangles)";
  await go(CUT_TICKS - 1);
  const before = await browser.evaluate(drawn);
  await go(2 * CUT_TICKS - 1);
  const after = await browser.evaluate(drawn);
  await go(0);
  await go(2 * CUT_TICKS - 1);
  assert.deepEqual(after, await browser.evaluate(drawn));
  assert.notDeepEqual(after, before);

  // The page's own blade, lowered by keys.
  await browser.goto(`file://${resolve(at("own.html"))}`);
  await browser.until("globalThis.chaincell?.frames > 0");
  assert.equal(await browser.evaluate("document.getElementById('cut').textContent"), "whole");
  for (let step = 0; step < 80 && (await browser.evaluate("chaincell.state.cuts.copies")) < 4; step++) {
    const tick = await browser.evaluate(`(() => { document.getElementById("stage").dispatchEvent(new KeyboardEvent("keydown", { key: "PageDown", bubbles: true })); return chaincell.state.tick; })()`);
    await browser.until(`chaincell.state.tick > ${tick} + 4`);
  }
  await browser.click("pause");
  await browser.until(`chaincell.state.ticksPerS === 0 && ${IS_SHOWN}`);
  const own = await browser.evaluate(`({ cuts: chaincell.state.cuts, drawn: ${DRAWN}, loose: ${LOOSE_EDGES}, said: document.getElementById("cut").textContent })`);
  await browser.picture(at("own.png"));
  assert.ok(own.cuts.copies >= 4 && own.drawn > start.drawn && own.loose === 0, JSON.stringify(own));
  assert.match(own.said, /^\d+ mm²$/);
  const { hash, ticks } = await playedNatively(browser, chaincell, "slab", at("own"));
  await browser.click("reset");
  await browser.until(`chaincell.state.tick === 0 && ${IS_SHOWN}`);
  assert.equal(await browser.evaluate(DRAWN), start.drawn, "whole after a reset");

  // The page's own scissors, whose crossing is lowered close above the body: they cut as keys close them.
  await browser.goto(`file://${resolve(at("scissors.html"))}`);
  await browser.until("globalThis.chaincell?.frames > 0 && chaincell.state.tick > 0");
  const key = (name) => browser.evaluate(`document.getElementById("stage").dispatchEvent(new KeyboardEvent("keydown", { key: "${name}", bubbles: true }))`);
  await browser.evaluate("chaincell.hand.along(-1.1)");
  await browser.until("Math.abs(chaincell.state.tools[0].positionM[2] - chaincell.hand.goal.positionM[2]) < 1e-6");
  const ajar = await browser.evaluate("({ cuts: chaincell.state.cuts, openingRad: chaincell.state.tools[0].openingRad })");
  assert.ok(ajar.cuts.openedFaces === 0 && Math.abs(ajar.openingRad - 1) < 1e-4, JSON.stringify(ajar));
  for (let step = 0; step < 40 && (await browser.evaluate("chaincell.state.cuts.copies")) < 4; step++) {
    const tick = await browser.evaluate("chaincell.state.tick");
    await key("c");
    await browser.until(`chaincell.state.tick > ${tick} + 20`);
  }
  await browser.click("pause");
  await browser.until(`chaincell.state.ticksPerS === 0 && ${IS_SHOWN}`);
  const snipped = await browser.evaluate("({ cuts: chaincell.state.cuts, openingRad: chaincell.state.tools[0].openingRad, said: document.getElementById('opening-text').textContent })");
  await browser.picture(at("scissors.png"));
  assert.ok(snipped.cuts.copies >= 4 && snipped.openingRad < 0.8 && /^\d+°$/.test(snipped.said), JSON.stringify(snipped));
  await playedNatively(browser, chaincell, "slab", at("snipped"));
  assert.match(readFileSync(at("snipped/slab.csv"), "utf8"), /,engaged,opening_rad,sweeps\n/);

  // A running scene: whole at first, then with its wound.
  const scene = `wound-${process.pid}`;
  const options = [at("slab.chaincell"), "--scene", scene, "--tool", BLADE];
  const serve = (...more) => started(["serve", ...options, "--late-share", "off", "--watchdog-ms", "0", ...more], "ready");
  let server = await serve("--out", at("served"), "--force");
  const view = await started(["view", ...options, "--commands", "--no-open"], "http://");
  const attach = async () => {
    await browser.goto("about:blank");
    await browser.goto(addressOf(view));
    await browser.until(`globalThis.chaincell?.state && ${IS_SHOWN}`);
  };
  const surface = () => browser.evaluate(`({ triangles: ${DRAWN}, loose: ${LOOSE_EDGES} })`);
  await attach();
  assert.deepEqual(await surface(), { triangles: start.drawn, loose: 0 });
  const hand = await started(["control", "--scene", scene, "--path", at("one.csv"), "--late-share", "off"]);
  assert.equal(await hand.ended, 0, hand.text);
  await browser.until(`chaincell.state.tick === ${CUT_TICKS - 1} && ${IS_SHOWN}`);
  const live = await surface();
  assert.ok(live.triangles > start.drawn && live.loose === 0, JSON.stringify(live));
  await browser.picture(at("live.png"));
  const stresses = `(() => { const e = document.getElementById("colour"); e.value = "stress"; e.onchange(); })()`;
  await browser.evaluate(stresses);
  await browser.until("chaincell.state.stressesPa.length === chaincell.scene.figure.surface.stressed.length && chaincell.scene.figure.surface.most() > 100");
  // A page that comes late has the same surface, and so has one after the server was killed and goes on from a snapshot.
  const copies = await browser.evaluate("chaincell.state.positionsM.length");
  await attach();
  assert.deepEqual(await surface(), live);
  command("command", "--scene", scene, "snapshot");
  const snapshot = at(join("served", readdirSync(at("served")).find((name) => name.endsWith(".snapshot"))));
  server.kill("SIGKILL");
  await browser.until('document.getElementById("status").textContent.includes("was killed")');
  server = await serve("--restore", snapshot);
  await browser.until('document.getElementById("status").textContent === ""');
  await attach();
  assert.deepEqual([await surface(), await browser.evaluate("chaincell.state.positionsM.length")], [live, copies]);
  // After a reset it is whole.
  await browser.click("reset");
  await browser.until(`chaincell.state.positionsM.length < ${copies} && ${IS_SHOWN}`);
  assert.deepEqual(await surface(), { triangles: start.drawn, loose: 0 });

  assert.deepEqual(browser.console, []);
  console.log(`ok: ${end.cuts.openedFaces} faces open in the session, ${own.cuts.openedFaces} under the page's blade, ${ticks} ticks, hash ${hash} as natively`);
} finally {
  endAll();
  await browser.stop();
}
