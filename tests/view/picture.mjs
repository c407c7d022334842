// Pictures without a browser: `chaincell run --picture` and `chaincell picture` draw a press, another tick is another
// picture, and what cannot be is refused with nothing left behind. node picture.mjs CHAINCELL FOLDER
import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { existsSync, mkdirSync, readFileSync, rmSync } from "node:fs";
import { join } from "node:path";
import { inflateSync } from "node:zlib";

const [chaincell, folder] = process.argv.slice(2);
const at = (name) => join(folder, name);
rmSync(folder, { recursive: true, force: true });
mkdirSync(folder, { recursive: true });

function command(code, ...words) {
  const { status, stdout, stderr } = spawnSync(chaincell, words, { encoding: "utf8" });
  assert.equal(status, code, `${words.join(" ")}: ${stderr}`);
  return code ? stderr : stdout;
}

/** Width, height and the unfiltered size of a PNG of three bytes a pixel. */
function sizeOf(file) {
  const bytes = readFileSync(file);
  assert.equal(bytes.subarray(1, 4).toString(), "PNG");
  const [width, height] = [bytes.readUInt32BE(16), bytes.readUInt32BE(20)];
  const data = bytes.indexOf("IDAT");
  const rows = inflateSync(bytes.subarray(data + 4, data + 4 + bytes.readUInt32BE(data - 4)));
  assert.equal(rows.length, height * (1 + 3 * width));
  return [width, height];
}

command(0, "bake", "box:7x7x4x0.01", "--young-pa", "5000", "-o", at("box.chaincell"));
const press = ["run", at("box.chaincell"), "--motion", "press", "--tool", "sphere:0.01", "--seconds", "0.1"];
const said = command(0, ...press, "--out", at("run"), "--picture", at("press.png"));
const [, tick] = /press\.png: tick (\d+), displacement up to [0-9.]+ mm/.exec(said);
assert.deepEqual(sizeOf(at("press.png")), [1280, 800]);
// The same tick from the session, to the same bytes; the first tick is another picture.
const drawn = JSON.parse(command(0, "picture", at("run"), "--json"));
assert.equal(drawn.tick, Number(tick));
assert.ok(Math.hypot(...drawn.force_n) > 0.01 && drawn.displacement_max_m > 0.001, JSON.stringify(drawn));
assert.ok(readFileSync(at(`run/picture_${tick}.png`)).equals(readFileSync(at("press.png"))));
command(0, "picture", at("run/session.trace"), "--tick", "0", "--out", at("rest.png"));
assert.deepEqual(sizeOf(at("rest.png")), [1280, 800]);
assert.ok(!readFileSync(at("rest.png")).equals(readFileSync(at("press.png"))));
for (const curve of ["force.svg", "force_depth.svg"]) {
  const svg = readFileSync(at(`run/${curve}`), "utf8");
  assert.ok(svg.startsWith("<svg") && svg.includes(">force [N]<") && svg.includes("prefers-color-scheme: dark"), curve);
}
// Refused, with place and remedy.
assert.match(command(2, "picture", at("run"), "--tick", "100"), /--tick 100: .* its ticks go from 0 to 99/);
assert.match(command(2, "picture", at("run"), "--tick", "3", "--out", at("run")), /no file; name another one/);
assert.match(command(2, "picture", at("run"), "--tick", "3", "--out", at("none/a.png")), /none\/a\.png: No such file/);
assert.match(command(2, "picture", at("box.chaincell")), /not a chaincell trace/);
assert.match(command(2, ...press, "--out", at("other"), "--picture", at("none/a.png")), /none\/a\.png/);
assert.match(command(2, ...press, "--out", at("other"), "--picture", folder), /no file; name another one/);
assert.match(command(2, "view", at("run"), "--tool", "sphere:0.01", "--html", at("a.html")), /leave it out/);
assert.match(command(2, "view", at("box.chaincell"), "--model", at("box.chaincell"), "--html", at("a.html")), /--model/);
assert.ok(!existsSync(at("other")) && !existsSync(at("a.html")));
console.log(`ok: pictures of tick ${tick} and 0, 8 refusals`);
