// Programs that run while a page shows them.
import { spawn } from "node:child_process";

/** Longest wait for a line of a program [ms]. */
const LIMIT_MS = 120_000;
const running = new Set();

/** Returns a function that starts the command, and returns it with its output, once a line begins so if one has to. */
export const starter = (chaincell) => async (args, beginning) => {
  const child = spawn(chaincell, args, { stdio: ["ignore", "pipe", "pipe"] });
  running.add(child);
  child.ended = new Promise((end) => child.once("exit", (code) => (running.delete(child), end(code))));
  child.text = "";
  const lines = new Promise((give, fail) => {
    const look = (piece) => {
      child.text += piece;
      if (child.text.split("\n").some((line) => line.startsWith(beginning))) give();
    };
    for (const stream of [child.stdout, child.stderr]) stream.setEncoding("utf8").on("data", look);
    child.ended.then((code) => fail(new Error(`${args[0]} ended with ${code}: ${child.text}`)));
    setTimeout(() => fail(new Error(`${args[0]} does not say ${beginning}: ${child.text}`)), LIMIT_MS).unref();
  });
  if (beginning) await lines;
  else lines.catch(() => {});
  return child;
};

/** The address that the command has printed. */
export const addressOf = (child) => child.text.split("\n").find((line) => line.startsWith("http://"));

/** Ends all that still runs. */
export function endAll() {
  for (const child of running) child.kill("SIGKILL");
}
