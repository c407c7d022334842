// States of a running scene, from the server of this page: frames as host/src/view/live.rs describes them.
import { pressuresOf, trianglesAround } from "./contacts.mjs";
import { depthOf, touchOf, UNSEEN } from "./depth.mjs";
import { bodyOf } from "./image.mjs";
import { bytesOf, token } from "./own.mjs";
import { COUNT_MS, TRAIL_TICKS } from "./pace.mjs";

const VERSION = 4;
const BYTES = { head: 68, tool: 72, point: 36, contact: 20, stress: 4, cell: 12 };
/** Time between two attempts to connect [ms]. */
const AGAIN_MS = 1000;
/** How long a refusal is shown [ms]. */
const REFUSAL_MS = 5000;
/** Time between two words that the stress is shown [ms]. */
const STRESS_MS = 500;
/** The server's word for too many pages, and for its end. */
const FULL = 1013;
const ENDED = 1001;

/** Words of a triangle: three cells, and three of the whole body that they were made from. */
const TRIANGLE_WORDS = 6;

/** Reads a frame; throws an Error for one of another version or length. */
export function frameOf(buffer) {
  const view = new DataView(buffer);
  let at = 0;
  const whole = () => view.getUint32((at += 4) - 4, true);
  const real = () => view.getFloat32((at += 4) - 4, true);
  const long = () => view.getBigUint64((at += 8) - 8, true);
  const reals = (count) => Array.from({ length: count }, real);
  if (buffer.byteLength < BYTES.head || whole() !== VERSION) {
    throw new Error("the page is of another release than its server: load it again");
  }
  const head = {
    checksum: whole().toString(16).padStart(8, "0"), tick: Number(long()), ticksAnswered: Number(long()),
    hash: long().toString(16).padStart(16, "0"), flags: whole(), sweeps: whole(), stepUs: whole() / 1000, energyJ: real(),
  };
  const [tools, points, cells, contacts, stresses] = [whole(), whole(), whole(), whole(), whole()];
  const bytes = tools * BYTES.tool + points * BYTES.point + contacts * BYTES.contact + stresses * BYTES.stress + cells * BYTES.cell;
  const words = (buffer.byteLength - BYTES.head - bytes) / 4;
  if (words < 0 || words % TRIANGLE_WORDS !== 0) throw new Error("a frame of the server has another length than its parts");
  return {
    ...head,
    tools: Array.from({ length: tools }, () => ({
      number: whole(), ...acting(whole()), positionM: reals(3), orientation: reals(4), forceN: reals(3),
      torqueNM: reals(3), contacts: whole(), flags: whole(), errorN: real(),
    })),
    points: Array.from({ length: points }, () => ({ tick: Number(long()), forceN: reals(3), errorN: real(), positionM: reals(3) })),
    contacts: Array.from({ length: contacts }, () => ({ cell: whole(), positionM: reals(3), pressurePa: real() })),
    stressesPa: reals(stresses),
    positionsM: new Float32Array(buffer.slice(at, (at += cells * BYTES.cell))),
    triangles: new Uint32Array(buffer.slice(at)),
  };
}

/** Whether two arrays hold the same. */
const isSame = (one, other) => one.length === other.length && one.every((word, place) => word === other[place]);

/** Whether a tool acts, and the opening of scissors [rad]: the halves of a word. */
function acting(word) {
  return { engaged: (word & 0xffff) === 1, openingRad: (word >>> 16) * ((2 * Math.PI) / 65536) };
}

/** The curves of tool 0: each tick once, however many frames hold it. */
export class Trail {
  constructor() {
    this.last = -1;
    this.touched = UNSEEN;
  }

  /** Returns the new points. */
  take(points, isTouching) {
    const newest = points.length ? points[points.length - 1].tick : this.last;
    if (newest < this.last) Object.assign(this, new Trail());
    const fresh = points.filter(({ tick }) => tick > this.last);
    this.last = newest;
    return fresh.map((point) => this.#point(point, isTouching)).filter(({ tick }) => tick % TRAIL_TICKS === 0);
  }

  #point({ tick, forceN: force, errorN, positionM }, isTouching) {
    const forceN = Math.hypot(...force);
    this.touched = touchOf(this.touched, { isTouching: isTouching || forceN > 0, forceN: force, positionM });
    const depthM = depthOf(this.touched, positionM);
    return { tick, timeS: tick * 1e-3, forceN, errorN, depthM };
  }
}

export class Live {
  /** Set `onready(body)`, `onstate(state)`, `onstatus(text)`, `onsetup()` and then call `start()`. */
  constructor(config) {
    this.config = config;
    this.can = new Set(config.commands ? ["pause", "reset", "sweeps"] : []);
    this.setup = { tools: config.tools, chosen: 0, sweeps: config.sweeps, friction: 0 };
    this.trail = new Trail();
    this.notice = "";
    this.lacksStress = false;
    this.frames = 0;
    this.counted = { ms: performance.now(), ticks: 0, ticksPerS: 0 };
  }

  async start() {
    const { rest, triangles, links, fixed, hasShapes, spareCells, unitM, centreM } = bodyOf(await bytesOf(this.config.model));
    const restM = rest.map((length, index) => length * unitM + centreM[index % 3]);
    // Held cells are shown by a small ball where the tool is.
    this.kinds = this.config.tools.length ? this.config.tools : [`sphere:${0.4 * unitM}`];
    const info = { cells: rest.length / 3, links: links.length / 2, unitM, centreM, checksum: this.config.checksum, hasShapes, spareCells, hasTools: this.config.tools.length > 0 };
    this.whole = triangles;
    this.cut = new Uint32Array(0);
    this.#showTriangles(triangles, triangles);
    this.onready({ restM, triangles, links, fixed, info: { ...info, name: this.config.name } });
    this.#connect();
  }

  #connect() {
    const socket = new WebSocket(`ws://${location.host}/live`, ["chaincell", token()]);
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => (typeof data === "string" ? this.#hear(JSON.parse(data)) : this.#receive(data));
    socket.onclose = ({ code, reason }) => this.#closed(code, reason);
    this.socket = socket;
  }

  #closed(code, reason) {
    if (code === FULL) this.onstatus(reason);
    else {
      const ended = "The command that serves this page has ended: this is the last state. Start it again, and open its new address";
      const lost = "No connection to the command that serves this page: this is the last state";
      this.onstatus(code === ENDED ? ended : lost);
      if (code !== ENDED) setTimeout(() => this.#connect(), AGAIN_MS);
    }
  }

  /** A notice of the scene stays; a refusal is shown for a while. */
  #hear(message) {
    if ("status" in message) {
      this.notice = message.status === "live" ? "" : message.text;
      this.onstatus(this.notice);
    } else if (!message.done) {
      this.onstatus(message.text);
      setTimeout(() => this.onstatus(this.notice), REFUSAL_MS);
    }
  }

  /** Takes a frame, and says so; why one cannot be read is shown until another one can. */
  #receive(buffer) {
    this.socket.send("seen");
    try {
      this.#take(frameOf(buffer));
      if (this.hasRefused) this.onstatus(this.notice);
      this.hasRefused = false;
    } catch (why) {
      this.hasRefused = true;
      this.onstatus(why.message);
    }
  }

  /** Contacts are on these triangles, whose cells are or were made from those of `origins`. */
  #showTriangles(triangles, origins) {
    this.triangles = triangles;
    this.around = trianglesAround(origins);
  }

  /** Returns the triangles of a body that is cut where they are new, null for one that is whole again, else nothing. */
  #takeTriangles(words) {
    if (isSame(words, this.cut)) return {};
    this.cut = words;
    const part = (first) => words.filter((_, place) => Math.floor((place % TRIANGLE_WORDS) / 3) === first);
    if (words.length) this.#showTriangles(part(0), part(1));
    else this.#showTriangles(this.whole, this.whole);
    return { triangles: words.length ? words : null };
  }

  #take(frame) {
    this.frames += 1;
    const triangles = this.#takeTriangles(frame.triangles);
    this.#tellOfStress(this.showsStress && frame.stressesPa.length === 0);
    this.#followSweeps(frame.sweeps);
    const now = performance.now();
    if (now - this.counted.ms > COUNT_MS) {
      const ticks = Math.max(0, frame.ticksAnswered - this.counted.ticks);
      const isFirst = this.counted.ticks === 0;
      this.counted = { ms: now, ticks: frame.ticksAnswered, ticksPerS: isFirst ? 0 : (1000 * ticks) / (now - this.counted.ms) };
    }
    // One that no message has is at the origin.
    const isThere = (tool) => tool.number === 0 || tool.engaged || tool.positionM.some((x) => x !== 0);
    const tools = frame.tools.filter(isThere).map((tool) => {
      const kind = this.kinds[tool.number] ?? this.kinds[0];
      return { ...tool, kind, radiusM: Number(kind.match(/^sphere:([^@+/]+)$/)?.[1] ?? 0) };
    });
    this.onstate({
      tick: frame.tick, timeS: frame.tick * 1e-3, hash: frame.hash, positionsM: frame.positionsM, tools,
      pressuresPa: pressuresOf(frame.contacts, frame.positionsM, this.triangles, this.around),
      stressesPa: this.stressed.map((cell) => frame.stressesPa[cell] ?? 0), stressList: this.stressList, ...triangles, sweeps: frame.sweeps, energyJ: frame.energyJ, stepUs: frame.stepUs, ticksPerS: this.counted.ticksPerS,
      trail: this.trail.take(frame.points, frame.tools.some((tool) => tool.number === 0 && tool.contacts > 0)),
    });
  }

  /** Shows the most sweeps that the scene has made, until the page sets them: a tick may make fewer. */
  #followSweeps(sweeps) {
    if (this.hasSetSweeps || sweeps <= this.setup.sweeps) return;
    this.setup.sweeps = sweeps;
    if (this.can.has("sweeps")) this.onsetup();
  }

  /** The server computes the stress while a page says that it shows it, which is of this surface. */
  show(colour, { stressed, list }) {
    [this.stressed, this.stressList] = [stressed, list];
    clearInterval(this.asking);
    this.showsStress = colour === "stress";
    this.#tellOfStress(false);
    const ask = () => {
      if (this.socket?.readyState === WebSocket.OPEN) this.socket.send("stress");
    };
    if (!this.showsStress) return;
    ask();
    this.asking = setInterval(ask, STRESS_MS);
  }

  /** Says that there is no stress yet, as soon as that is so and until it is no more. */
  #tellOfStress(lacks) {
    if (lacks !== this.lacksStress) this.onstatus(lacks && !this.notice ? "The scene has sent no stress yet" : this.notice);
    this.lacksStress = lacks;
  }

  #ask(order) {
    this.socket.send(JSON.stringify(order));
  }

  pause(on) {
    this.#ask({ do: on ? "pause" : "resume" });
  }

  reset() {
    this.#ask({ do: "reset" });
  }

  settings({ sweeps }) {
    this.hasSetSweeps = true;
    this.#ask({ do: "set", name: "sweeps", value: sweeps });
  }
}
