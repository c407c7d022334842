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
    this.can = new Set(["tool", "pause", "step", "reset", "settings", "path", ...(config.tools.length ? ["tools"] : []), ...(config.can_bake ? ["bake"] : [])]);
    this.setup = { tools: config.tools, chosen: 0, friction: 0, sweeps: config.sweeps, held: config.contact_nodes, openingRad: 1 };
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
    this.worker.postMessage({ kind: "init", wasm: this.wasm, image, canBeCut: this.body.canBeCut, held: this.setup.held.length });
  }

  #heard(data) {
    if (data.kind === "state") this.onstate(data.state);
    else if (data.kind === "problem") this.onstatus(data.text);
    else if (data.kind === "path") this.waiting.splice(0).forEach((give) => give(data));
    else if (data.kind === "info") this.#begin(data.info);
  }

  #begin(info) {
    const { rest, triangles, links, fixed, hasShapes, canBeCut, spareCells } = this.body;
    const restM = rest.map((length, index) => length * info.unitM + info.centreM[index % 3]);
    this.info = info;
    this.place = { restM, triangles };
    this.onready({ restM, triangles, links, fixed, info: { ...info, hasShapes, canBeCut, spareCells, hasTools: this.config.tools.length > 0, name: this.config.name } });
    this.worker.postMessage({ kind: "begin", setup: this.#prepared() });
    this.#play();
  }

  /** The setup with what follows from it: of each tool its parts, and where it stands before the first touch. */
  #prepared() {
    const { setup } = this;
    if (!setup.held.length) return { ...setup, tools: setup.tools.map((kind, index) => this.#preparedTool(kind, index)) };
    const cells = setup.held.map((id) => this.body.inputIds.indexOf(id));
    const sum = cells.reduce((sum, cell) => add(sum, at(this.place.restM, cell)), [0, 0, 0]);
    const place = scale(sum, 1 / cells.length);
    const radiusM = 0.4 * this.info.unitM;
    return { ...setup, tools: [{ kind: `sphere:${radiusM}`, radiusM, startPose: [...place, 0, 0, 0, 1], ...this.#inward(place) }] };
  }

  #preparedTool(kind, index) {
    const parts = partsOf(kind);
    const cell = this.#top(this.#standOf(index));
    const place = at(this.place.restM, cell);
    const { normal } = nearestAtRest(this.place, place);
    const isHalfSpace = parts.some((part) => part.kind === "half-space");
    const isRound = parts.length === 1 && parts[0].kind === "sphere";
    const isBlade = parts.every(({ edge }) => edge);
    const gap = (isHalfSpace || isBlade ? 0 : reachM(parts)) + 0.3 * this.info.unitM;
    const orientation = isRound ? [0, 0, 0, 1] : turnTo(scale(normal, isHalfSpace ? -1 : 1));
    return { kind, parts, radiusM: parts[0].radiusM, startPose: [...add(place, normal, gap), ...orientation], direction: scale(normal, -1) };
  }

  #inward(place) {
    return { direction: scale(nearestAtRest(this.place, place).normal, -1) };
  }

  /** Where a tool stands above the body: the first in the middle, the others around it. */
  #standOf(index) {
    const [x, y] = this.info.centreM;
    if (index === 0) return [x, y];
    const [first, other] = [0, index].map((tool) => reachM(partsOf(this.setup.tools[tool])));
    const apart = 1.3 * (first + other) + this.info.unitM;
    const angle = [0, 4, 2, 6, 1, 5, 3][index - 1] * (Math.PI / 4);
    return [x + apart * Math.cos(angle), y + apart * Math.sin(angle)];
  }

  /** The cell on top of the body, not far from a place. */
  #top([x, y]) {
    const { restM, triangles } = this.place;
    const slope = x === this.info.centreM[0] && y === this.info.centreM[1] ? 0.35 : 1.5;
    const height = (cell) => restM[3 * cell + 2] - slope * Math.hypot(restM[3 * cell] - x, restM[3 * cell + 1] - y);
    return triangles.reduce((best, cell) => (height(cell) > height(best) ? cell : best), triangles[0]);
  }

  /** A press that plays until somebody takes the tool. */
  #play() {
    const depthM = 1.1 * this.info.unitM;
    const [{ parts, startPose, direction }] = this.#prepared().tools;
    // A blade waits for a hand.
    if (parts?.some(({ edge }) => edge)) return;
    const motion = { startPose, direction, depthM, periodTicks: 4000 };
    this.worker.postMessage({ kind: "demo", motion });
  }

  /** The first picture is on the screen: time begins. */
  shown() {
    this.worker.postMessage({ kind: "go" });
  }

  tool(index, { positionM, orientation }) {
    this.worker.postMessage({ kind: "tool", index, pose: [...positionM, ...orientation] });
  }

  /** The worker computes what the colours show, of this surface. */
  show(colour, { stressed, list }) {
    const ids = colour === "stress" ? stressed.map((cell) => this.body.inputIds[cell]) : null;
    this.worker.postMessage({ kind: "show", ids, list });
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

  /** Sweeps and the opening of scissors act from the next tick on; other tools or friction begin anew, with the body at rest. */
  settings(settings) {
    this.setup = { ...this.setup, ...settings };
    const resets = "tools" in settings || "friction" in settings;
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

  /** Returns all ticks since the last reset: of each tool a pose of 7 numbers, and the sweeps; and the hash at the end. */
  path() {
    return new Promise((give) => {
      this.waiting.push(give);
      this.worker.postMessage({ kind: "path" });
    });
  }
}
