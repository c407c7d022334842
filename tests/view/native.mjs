// What a page saves, played natively: path and model by the command that the page shows.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";

/** Plays in a folder what the page of a body has saved; hash, forces and their errors have to be the page's. */
export async function playedNatively(browser, chaincell, body, place) {
  browser.forgetDownloads();
  await browser.click("save-path");
  const path = (await browser.downloaded(".csv")).toString();
  await browser.click("save-model");
  const image = await browser.downloaded(".chaincell");
  const { hash, kinds, ticks } = await browser.evaluate(
    "({ hash: chaincell.state.hash, kinds: chaincell.source.setup.tools, ticks: chaincell.state.tick })");
  assert.equal(path.trim().split("\n").length - 1, ticks * kinds.length);
  const command = await browser.evaluate("document.getElementById('command').textContent");
  assert.ok(command.includes(hash), command);
  mkdirSync(place, { recursive: true });
  writeFileSync(join(place, `${body}.csv`), path);
  writeFileSync(join(place, `${body}.chaincell`), image);
  const words = command.split("#")[0].trim().split(/\s+/).slice(1);
  const said = execFileSync(resolve(chaincell), [...words, "--force", "--json"], { cwd: place, encoding: "utf8", stdio: ["ignore", "pipe", "inherit"] });
  const native = JSON.parse(said.trim().split("\n").pop()).state_hash;
  assert.equal(hash, native, `${place}: the page's hash and that of chaincell run`);
  // The forces of all tools, and their errors, are those of the last tick.
  const shown = await browser.evaluate("chaincell.state.tools.map(({ forceN, errorN }) => [...forceN, errorN])");
  const rows = readFileSync(join(place, body, "tools.csv"), "utf8").trim().split("\n").slice(-kinds.length);
  const wanted = rows.map((row) => row.split(",").map(Number)).map((row) => [...row.slice(2, 5), row[10]]);
  assert.deepEqual(shown.map((each) => each.map(Math.fround)), wanted.map((each) => each.map((of) => Math.fround(Number.isNaN(of) ? -1 : of))));
  return { path, image, kinds, ticks, hash };
}
