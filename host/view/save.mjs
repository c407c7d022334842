// What the page saves: a picture, the path of the tools, the model; and the command that plays them natively.

/** Gives the browser a file to keep. */
export function keep(name, content, type) {
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** The path as `chaincell run --path` reads it: nine digits bring every number of 32 bits back. */
export function pathText(poses, tools) {
  const number = (value) => String(Number(value.toPrecision(9)));
  const rows = ["tick,tool,x_m,y_m,z_m,qx,qy,qz,qw,engaged,sweeps"];
  const length = 7 * tools + 1;
  for (let tick = 0; length * tick < poses.length; tick++) {
    const row = poses.subarray(length * tick, length * (tick + 1));
    for (let tool = 0; tool < tools; tool++) {
      rows.push([tick, tool, ...Array.from(row.subarray(7 * tool, 7 * tool + 7), number), 1, row[length - 1]].join(","));
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
