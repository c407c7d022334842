// States from the kernel in the page itself, in a worker.
import { bodyOf, fromBase64, inflate } from "./image.mjs";
import { partsOf, reachM } from "./parts.mjs";
import { nearestAtRest } from "./surface.mjs";
import { add, at, scale, turnTo } from "./vectors.mjs";

/** Reads what the configuration holds itself or where it is to be fetched. */
export async function bytesOf(place) {
  if (place.inline) return inflate(fromBase64(place.inline));
  const answer = await fetch(place.url, { headers: authorization() });
  if (!answer.ok) throw new Error(`${place.url}: the server answers ${answer.status} ${await answer.text()}`);
  return inflate(new Uint8Array(await answer.arrayBuffer()));
}

/** The server's token, which the address has after #. */
export function token() {
  return location.hash.slice(1);
}

/** The field of a request that shows the token. */
export function authorization() {
  return { Authorization: `Bearer ${token()}` };
}

export class Own {
  /** Set `onready(body)`, `onstate(state)`, `onstatus(text)` and then call `start()`. */
  constructor(config) {
    this.config = config;
    this.can = new Set(["tool", "pause", "step", "reset", "settings", "path", ...(config.can_bake ? ["bake"] : [])]);
    this.setup = { tool: config.tool, friction: 0, sweeps: config.sweeps, held: config.contact_nodes };
    this.waiting = [];
  }

  async start() {
    this.wasm = await bytesOf(this.config.kernel);
    await this.#load(await bytesOf(this.config.model));
  }

  /** Gives the body of an image to a new kernel. */
  async #load(image) {
    this.worker?.terminate();
    this.image = image;
    this.body = bodyOf(image);
    const text = document.getElementById("worker").textContent;
    this.worker = new Worker(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }) => this.#heard(data);
    this.worker.onerror = (event) => this.onstatus(event.message);
    const held = this.setup.tool ? 0 : this.setup.held.length;
    this.worker.postMessage({ kind: "init", wasm: this.wasm, image, held });
  }

  #heard(data) {
    if (data.kind === "state") this.onstate(data.state);
    else if (data.kind === "problem") this.onstatus(data.text);
    else if (data.kind === "path") this.waiting.splice(0).forEach((give) => give(data));
    else if (data.kind === "info") this.#begin(data.info);
  }

  #begin(info) {
    const { rest, triangles, links, fixed, hasShapes } = this.body;
    const restM = rest.map((length, index) => length * info.unitM + info.centreM[index % 3]);
    this.info = info;
    this.place = { restM, triangles };
    this.onready({ restM, triangles, links, fixed, info: { ...info, hasShapes, name: this.config.name } });
    this.worker.postMessage({ kind: "begin", setup: this.#prepared() });
    this.#play();
  }

  /** The setup with what follows from it: parts, and where the tool stands before the first touch. */
  #prepared() {
    const setup = { ...this.setup };
    if (!setup.tool) {
      const cells = setup.held.map((id) => this.body.inputIds.indexOf(id));
      const sum = cells.reduce((sum, cell) => add(sum, at(this.place.restM, cell)), [0, 0, 0]);
      const place = scale(sum, 1 / cells.length);
      this.direction = scale(nearestAtRest(this.place, place).normal, -1);
      return { ...setup, parts: null, radiusM: 0.4 * this.info.unitM, tool: `sphere:${0.4 * this.info.unitM}`, startPose: [...place, 0, 0, 0, 1] };
    }
    setup.parts = partsOf(setup.tool);
    setup.radiusM = setup.parts[0].radiusM;
    const cell = this.#top();
    const { normal } = nearestAtRest(this.place, at(this.place.restM, cell));
    const isHalfSpace = setup.parts.some((part) => part.kind === "half-space");
    const isRound = setup.parts.length === 1 && setup.parts[0].kind === "sphere";
    const gap = (isHalfSpace ? 0 : reachM(setup.parts)) + 0.3 * this.info.unitM;
    const orientation = isRound ? [0, 0, 0, 1] : turnTo(scale(normal, isHalfSpace ? -1 : 1));
    setup.startPose = [...add(at(this.place.restM, cell), normal, gap), ...orientation];
    this.direction = scale(normal, -1);
    return setup;
  }

  /** The cell on top of the body, not far from its middle. */
  #top() {
    const { restM, triangles } = this.place;
    const [x, y] = this.info.centreM;
    const height = (cell) => restM[3 * cell + 2] - 0.35 * Math.hypot(restM[3 * cell] - x, restM[3 * cell + 1] - y);
    return triangles.reduce((best, cell) => (height(cell) > height(best) ? cell : best), triangles[0]);
  }

  /** A press that plays until somebody takes the tool. */
  #play() {
    const depthM = 1.1 * this.info.unitM;
    const { startPose } = this.#prepared();
    const motion = { startPose, direction: this.direction, depthM, periodTicks: 4000 };
    this.worker.postMessage({ kind: "demo", motion });
  }

  tool({ positionM, orientation }) {
    this.worker.postMessage({ kind: "tool", pose: [...positionM, ...orientation] });
  }

  pause(on) {
    this.worker.postMessage({ kind: "pause", on });
  }

  step() {
    this.worker.postMessage({ kind: "step" });
  }

  reset() {
    this.worker.postMessage({ kind: "setup", setup: this.#prepared(), resets: true });
  }

  /** Sweeps act from the next tick on; another tool or friction begins anew, with the body at rest. */
  settings(settings) {
    this.setup = { ...this.setup, ...settings };
    const resets = "tool" in settings || "friction" in settings;
    this.worker.postMessage({ kind: "setup", setup: resets ? this.#prepared() : settings, resets });
  }

  /** Asks the server for the same body of another material. */
  async bake(material) {
    const answer = await fetch("/bake", {
      method: "POST", body: JSON.stringify(material), headers: { ...authorization(), "Content-Type": "application/json" },
    });
    if (!answer.ok) throw new Error(await answer.text());
    await this.#load(await inflate(new Uint8Array(await answer.arrayBuffer())));
  }

  /** Returns all ticks since the last reset: poses of 7 numbers and the sweeps, and the hash that they end in. */
  path() {
    return new Promise((give) => {
      this.waiting.push(give);
      this.worker.postMessage({ kind: "path" });
    });
  }
}
