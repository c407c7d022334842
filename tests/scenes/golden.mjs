// Prints the reports of the golden scenes as WebAssembly plays them:
// node golden.mjs WASM TICKS [CELLS_AFTER [FAULT_TICK FAULT_CELL]]
import { readFileSync, writeSync } from "node:fs";

const [file, ticks, cellsAfter = -1, faultTick = -1, faultCell = 0] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(file));
const { memory, scenes, emit, text } = instance.exports;
for (let scene = 0; scene < scenes(); scene++) {
  const length = emit(scene, +ticks, +cellsAfter, +faultTick, +faultCell);
  if (length === 0) throw new Error(`scene ${scene} cannot be played`);
  const bytes = new Uint8Array(memory.buffer, text(), length);
  for (let at = 0; at < length; ) at += writeSync(1, bytes, at);
}
