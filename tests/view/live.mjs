// The page on a running scene: shows its states, says that a killed server is gone and another model no match, and
// comes back. node live.mjs CHAINCELL FOLDER
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import { Browser } from "./browser.mjs";
import { addressOf, endAll, starter } from "./programs.mjs";

const [chaincell, folder] = process.argv.slice(2);
const started = starter(chaincell);
const scene = `view-${process.pid}`;
mkdirSync(folder, { recursive: true });

const serve = (model) => started(["serve", model, "--scene", scene, "--contact", "probe:0.012", "--late-share", "off"], "ready");
const press = (model) =>
  started(["control", "--scene", scene, "--model", model, "--contact", "probe:0.012", "--depth-m", "0.01", "--seconds", "60", "--repeat", "10"]);

const [organ, other] = ["organ", "other"].map((name) => join(folder, `${name}.chaincell`));
execFileSync(chaincell, ["bake", "organ:1000", "-o", organ, "--young-pa", "5000", "--poisson", "0.45"]);
execFileSync(chaincell, ["bake", "organ:1000", "-o", other, "--young-pa", "9000", "--poisson", "0.45"]);
/** The farthest triangle under pressure from the ball's centre, and how far one can be: its radius and a link [m]. */
const PRESSED = `(() => { const { pressuresPa, positionsM, tools: [{ positionM, radiusM }] } = chaincell.state; const { triangles, info } = chaincell.body;
  const middle = (face, axis) => [0, 1, 2].reduce((sum, k) => sum + positionsM[3 * triangles[3 * face + k] + axis] / 3, 0);
  const farM = Math.max(...pressuresPa.map(([face]) => Math.hypot(...positionM.map((x, axis) => x - middle(face, axis)))));
  return { farM, reachM: radiusM + info.unitM }; })()`;
const browser = await Browser.start({ width: 960, height: 640 });
const status = (words) => browser.until(`document.getElementById("status")?.textContent.includes(${JSON.stringify(words)})`);
try {
  const view = await started(["view", organ, "--scene", scene, "--tool", "sphere:0.012", "--commands", "--no-open"], "http://");
  await browser.goto(addressOf(view));
  await status("no server on");
  let server = await serve(organ);
  let hand = await press(organ);
  await browser.until("globalThis.chaincell?.state?.tools[0]?.forceN.some((part) => part !== 0)");
  assert.equal(await browser.evaluate('document.getElementById("status").textContent'), "");
  assert.match(await browser.evaluate("chaincell.state.hash"), /^[0-9a-f]{16}$/);
  assert.ok(await browser.evaluate("chaincell.state.positionsM.every(Number.isFinite)"));
  // The error of the force is shown beside it.
  await browser.until("chaincell.state.tools[0].errorN > 0 && /^± 0\\.\\d+ N$/.test(document.getElementById('error').textContent)");
  // The body gives way under the tool.
  const moved = "Math.max(...chaincell.state.positionsM.map((x, i) => Math.abs(x - chaincell.body.restM[i])))";
  await browser.until(`${moved} > 1e-3 && chaincell.state.tick > 1000 && chaincell.depthM > 1e-3`);
  await browser.picture(join(folder, "live.png"));
  // Pressure is where the ball presses.
  assert.equal(await browser.evaluate("document.querySelector('#colour [value=pressure]').disabled"), false);
  await browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "pressure"; e.onchange(); })()`);
  await browser.until("chaincell.state.pressuresPa.length > 0 && chaincell.scene.figure.surface.most() > 100");
  const { farM, reachM } = await browser.evaluate(PRESSED);
  assert.ok(farM < reachM, `pressure ${farM} m from the ball's centre`);
  await browser.picture(join(folder, "pressure.png"));
  // The server computes the stress while a page shows it.
  await browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "stress"; e.onchange(); })()`);
  await browser.until("Math.max(...chaincell.state.stressesPa) > 100 && chaincell.scene.figure.surface.most() > 100");
  await browser.picture(join(folder, "stress.png"));
  await browser.evaluate(`(() => { const e = document.getElementById("colour"); e.value = "displacement"; e.onchange(); })()`);
  await browser.until("Math.max(...chaincell.state.stressesPa) === 0");
  // A frame of another version is refused in words.
  const refused = `(() => { chaincell.source.socket.onmessage({ data: new ArrayBuffer(70) }); return document.getElementById("status").textContent; })()`;
  assert.match(await browser.evaluate(refused), /another release/);
  await browser.until('document.getElementById("status").textContent === ""');
  // The server makes four sweeps at most, which the page does not know beforehand.
  await browser.until("document.getElementById('sweeps').value === '4'");
  // Commands reach the scene: paused, the force is 0.
  await browser.click("pause");
  await browser.until("chaincell.state.tools[0].forceN.every((part) => part === 0)");
  await browser.click("pause");
  await browser.until("chaincell.state.tools[0].forceN.some((part) => part !== 0)");
  // A killed server is gone; when it is there again, so are its states.
  hand.kill("SIGKILL");
  server.kill("SIGKILL");
  await status("was killed");
  const last = await browser.evaluate("chaincell.state.tick");
  server = await serve(organ);
  hand = await press(organ);
  await browser.until('document.getElementById("status").textContent === ""');
  await browser.until(`chaincell.state.tick > 10 && chaincell.state.tick !== ${last}`);
  // Another model is none of this page.
  hand.kill("SIGKILL");
  server.kill("SIGKILL");
  await status("was killed");
  server = await serve(other);
  await status("another model");
  // A wrong token gets the page and nothing else.
  view.kill("SIGINT");
  await status("has ended");
  assert.equal(await view.ended, 0);
  const again = await started(["view", organ, "--scene", `${scene}-none`, "--no-open"], "http://");
  await browser.goto("about:blank");
  await browser.goto(addressOf(again).replace(/.$/, (digit) => (digit === "0" ? "1" : "0")));
  await status("the token is missing or wrong");
  const known = browser.console.filter((line) => !/403|ERR_CONNECTION/.test(line));
  assert.deepEqual(known, [], "the console is clean");

  const cosim = await started(["cosim", "--view", "--no-open", "--seconds", "4", "--scene", `${scene}-cosim`, "--late-share", "off", "--json"], "http://");
  await browser.goto("about:blank");
  await browser.goto(addressOf(cosim));
  await status("The session has ended, 4000 of 4000 ticks answered");
  assert.ok(await browser.evaluate("chaincell.state.tick > 3000 && chaincell.source.frames > 5"));
  await browser.picture(join(folder, "ended.png"));
  await browser.goto("about:blank");
  assert.equal(await cosim.ended, 0);
  console.log("live: ok");
} finally {
  endAll();
  await browser.stop();
}
