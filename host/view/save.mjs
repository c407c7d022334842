// What the page saves: a picture, the path of the tools, the model; and the command that plays them natively.
import { OPENING_RAD } from "./limits.mjs";

/** Gives the browser a file to keep. */
export function keep(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** The path of tools as `chaincell run --path` reads it: nine digits bring every number of 32 bits back. */
export function pathText(poses, kinds) {
  const number = (value) => String(Number(value.toPrecision(9)));
  const tools = Math.max(kinds.length, 1);
  const hasScissors = kinds.some((kind) => kind.includes("scissors"));
  const rows = [`tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged${hasScissors ? ",opening_rad" : ""},sweeps`];
  const length = 8 * tools + 1;
  for (let tick = 0; length * tick < poses.length; tick++) {
    const row = poses.subarray(length * tick, length * (tick + 1));
    for (let tool = 0; tool < tools; tool++) {
      const opening = hasScissors ? [number(row[7 * tools + tool] * OPENING_RAD)] : [];
      rows.push([tick, tool, ...Array.from(row.subarray(7 * tool, 7 * tool + 7), number), 1, ...opening, row[length - 1]].join(","));
    }
  }
  return rows.join("\n") + "\n";
}

/** The command that comes to the same state hash, beside the saved model and path. */
export function commandOf(name, { tools, held, friction }, sweepsMax) {
  const touch = tools.length ? `${tools.map((tool) => `--tool ${tool}`).join(" ")}${friction > 0 ? ` --friction ${friction}` : ""}` : `--contact ${held.join(",")}`;
  return `chaincell run ${name}.chaincell --path ${name}.csv ${touch} --sweeps ${sweepsMax} --out ${name}`;
}

/** A name for files: what a shell takes without quotes. */
export function fileName(name) {
  return name.replace(/\.chaincell$/, "").replace(/[^A-Za-z0-9_-]+/g, "-").replace(/^-+|-+$/g, "") || "body";
}
