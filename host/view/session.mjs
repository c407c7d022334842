// States from a recorded session, which the kernel in the page plays.
import { bodyOf } from "./image.mjs";
import { bytesOf } from "./own.mjs";

export class Session {
  /** Set `onready(body)`, `onstate(state)`, `onstatus(text)` and then call `start()`. */
  constructor(config) {
    this.config = config;
    this.can = new Set(["pause", "step", "reset", "seek", "speed"]);
  }

  async start() {
    const [wasm, image, session] = [await bytesOf(this.config.kernel), await bytesOf(this.config.model), await bytesOf(this.config.session)];
    this.body = bodyOf(image);
    const text = document.getElementById("worker").textContent;
    this.worker = new Worker(URL.createObjectURL(new Blob([text], { type: "text/javascript" })));
    this.worker.onmessage = ({ data }) => this.#heard(data);
    this.worker.onerror = (event) => this.onstatus(event.message);
    this.worker.postMessage({ kind: "session init", wasm, image, canBeCut: this.body.canBeCut, session });
  }

  #heard(data) {
    if (data.kind === "state") this.onstate(data.state);
    else if (data.kind === "problem") this.onstatus(data.text);
    else if (data.kind === "info") this.#begin(data.info);
  }

  #begin(info) {
    const { rest, triangles, links, fixed, hasShapes, canBeCut, spareCells } = this.body;
    const restM = rest.map((length, index) => length * info.unitM + info.centreM[index % 3]);
    this.first = info.session.first;
    this.onready({ restM, triangles, links, fixed, info: { ...info, hasShapes, canBeCut, spareCells, name: this.config.name } });
    this.worker.postMessage({ kind: "session begin" });
  }

  /** The worker computes what the colours show, of this surface. */
  show(colour, { stressed, list }) {
    const ids = colour === "stress" ? stressed.map((cell) => this.body.inputIds[cell]) : null;
    this.worker.postMessage({ kind: "session show", ids, list });
  }

  pause(on) {
    this.worker.postMessage({ kind: "session pause", on });
  }

  step() {
    this.worker.postMessage({ kind: "session step" });
  }

  reset() {
    this.seek(this.first);
  }

  seek(tick) {
    this.worker.postMessage({ kind: "session seek", tick });
  }

  speed(factor) {
    this.worker.postMessage({ kind: "session speed", factor });
  }
}
