// What the page saves: a picture, the path of the tool, the model; and the command that plays them natively.

/** Gives the browser a file to keep. */
export function keep(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** The path as `chaincell run --path` reads it: nine digits bring every number of 32 bits back. */
export function pathText(poses) {
  const number = (value) => String(Number(value.toPrecision(9)));
  const rows = ["tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged,sweeps"];
  for (let tick = 0; 8 * tick < poses.length; tick++) {
    const pose = poses.subarray(8 * tick, 8 * tick + 7);
    rows.push([tick, 0, ...Array.from(pose, number), 1, poses[8 * tick + 7]].join(","));
  }
  return rows.join("\n") + "\n";
}

/** The command that comes to the same state hash, beside the saved model and path. */
export function commandOf(name, { tool, held, friction }, sweepsMax) {
  const touch = tool ? `--tool ${tool}${friction > 0 ? ` --friction ${friction}` : ""}` : `--contact ${held.join(",")}`;
  return `chaincell run ${name}.chaincell --path ${name}.csv ${touch} --sweeps ${sweepsMax} --out ${name}`;
}

/** A name for files: what a shell takes without quotes. */
export function fileName(name) {
  return name.replace(/\.chaincell$/, "").replace(/[^A-Za-z0-9_-]+/g, "-").replace(/^-+|-+$/g, "") || "body";
}
