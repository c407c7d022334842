// The kernel's loop, in a worker: ticks at 1 kHz as far as the machine allows, the newest state some 60 times a
// second. The tools walk to where the hand has them.
import { Cuts } from "./cuts.mjs";
import { depthOf, touchOf } from "./depth.mjs";
import { Tissue } from "./kernel.mjs";
import { OPENING_RAD } from "./limits.mjs";
import { CATCH_UP_MS, Rate, STATE_MS, TICK_MS, TRAIL_TICKS, WORK_MS } from "./pace.mjs";
import { sessionOrders } from "./session_loop.mjs";
import { Stresses } from "./stresses.mjs";

/**
 * Farthest that a tool moves in a tick [m], and in mean link lengths a blade, and the pivot and the crossing of scissors:
 * beyond a quarter of one they cut nothing.
 */
const TOOL_STEP_M = 0.0004;
const BLADE_STEP = 0.2;
const SCISSORS_STEP = 0.1;
/** Ticks that are remembered for a path: ten minutes. */
const PATH_TICKS = 600_000;

class Loop {
  constructor(tissue, setup) {
    this.tissue = tissue;
    this.setup = setup;
    this.isPaused = false;
    this.owedMs = 0;
    this.lastMs = this.sentMs = performance.now();
    this.rate = new Rate();
    this.stresses = new Stresses(tissue);
    this.cuts = new Cuts(tissue);
    this.reset();
    const channel = new MessageChannel();
    channel.port1.onmessage = () => this.run();
    this.again = () => channel.port2.postMessage(0);
    this.send();
  }

  /** The body at rest, the tools where the scene begins. */
  reset() {
    const { tools, held, friction } = this.setup;
    if (held.length) this.tissue.resetHolding(held);
    else this.tissue.resetWithTools(tools.map(({ parts }) => parts), friction);
    this.tick = 0;
    this.poses = Float32Array.from(tools.flatMap(({ startPose }) => startPose));
    this.targets = this.poses.slice();
    this.openings = tools.map((_, tool) => (this.scissors(tool) ? this.opening : 0));
    this.out = tools.map(() => ({ forceN: [0, 0, 0], torqueNM: [0, 0, 0], contacts: 0, flags: 0, energyJ: 0, sweeps: 0, errorN: -1 }));
    this.path = new Float32Array(this.rowLength * 4096);
    this.touched = tools.map(() => null);
    this.trail = [];
  }

  /** Numbers of a tick in the path: seven for each tool, their openings, and the sweeps. */
  get rowLength() {
    return 8 * this.setup.tools.length + 1;
  }

  /** The edge of a tool that has scissors. */
  scissors(tool) {
    return this.setup.tools[tool].parts?.find(({ side }) => side)?.edge;
  }

  /** How far scissors shall be open [2^-16 turn]. */
  get opening() {
    return Math.round(this.setup.openingRad / OPENING_RAD);
  }

  /** Opens or closes scissors by what a tick may: the crossing of their blades moves as far as the pivot does. */
  turn(tool) {
    const edge = this.scissors(tool);
    if (!edge || this.openings[tool] === this.opening) return;
    const [lengthM, offsetM] = [edge.halfM[2], -edge.radiusM];
    const crossingM = (opening) => Math.min(lengthM, offsetM / Math.sin((opening * OPENING_RAD) / 2));
    const nowM = crossingM(this.openings[tool]);
    const awayM = crossingM(this.opening) - nowM;
    const stepM = Math.sign(awayM) * SCISSORS_STEP * this.tissue.info.unitM;
    const isThere = Math.abs(awayM) <= Math.abs(stepM);
    this.openings[tool] = isThere ? this.opening : Math.round((2 * Math.asin(offsetM / (nowM + stepM))) / OPENING_RAD);
  }

  /** Moves the tools towards their targets by what a hand does in a tick, turns them at once. */
  walk() {
    if (this.demo) this.targets.set(this.demo(this.tick));
    for (let start = 0; start < this.poses.length; start += 7) {
      const away = [0, 1, 2].map((axis) => this.targets[start + axis] - this.poses[start + axis]);
      const length = Math.hypot(...away);
      const isBlade = this.setup.tools[start / 7].parts?.some(({ edge }) => edge);
      const step = this.scissors(start / 7) ? SCISSORS_STEP : BLADE_STEP;
      const stepM = isBlade ? Math.min(TOOL_STEP_M, step * this.tissue.info.unitM) : TOOL_STEP_M;
      const share = length > stepM ? stepM / length : 1;
      for (let axis = 0; axis < 3; axis++) this.poses[start + axis] += share * away[axis];
      this.poses.set(this.targets.subarray(start + 3, start + 7), start + 3);
      this.turn(start / 7);
    }
  }

  oneTick() {
    this.walk();
    const begun = performance.now();
    this.out = this.tissue.tick(this.poses, this.setup.sweeps, this.openings);
    this.rate.count(begun);
    this.remember();
    this.tick += 1;
    this.follow();
  }

  /** Adds the tick to the path. */
  remember() {
    if (this.tick >= PATH_TICKS) return;
    const start = this.rowLength * this.tick;
    if (start === this.path.length) {
      const longer = new Float32Array(2 * this.path.length);
      longer.set(this.path);
      this.path = longer;
    }
    this.path.set(this.poses, start);
    this.path.set(this.openings, start + this.poses.length);
    this.path[start + this.rowLength - 1] = this.setup.sweeps;
  }

  /** Adds to the curves of the chosen tool. */
  follow() {
    this.touched = this.out.map(({ contacts, forceN }, tool) =>
      touchOf(this.touched[tool], { isTouching: contacts > 0, forceN, positionM: this.positionM(tool) }));
    if (this.tick % TRAIL_TICKS !== 0) return;
    const { chosen } = this.setup;
    const depthM = depthOf(this.touched[chosen], this.positionM(chosen));
    const { forceN, errorN } = this.out[chosen];
    this.trail.push({ timeS: this.tick * 1e-3, forceN: Math.hypot(...forceN), errorN, depthM });
  }

  positionM(tool) {
    return [...this.poses.subarray(7 * tool, 7 * tool + 3)];
  }

  /** Works for a while, then looks at messages. */
  run() {
    const now = performance.now();
    if (!this.isPaused) {
      this.owedMs = Math.min(this.owedMs + now - this.lastMs, CATCH_UP_MS);
      while (this.owedMs >= TICK_MS && performance.now() < now + WORK_MS) {
        this.oneTick();
        this.owedMs -= TICK_MS;
      }
    }
    this.lastMs = now;
    if (!this.isPaused && performance.now() - this.sentMs >= STATE_MS) this.send();
    if (this.isPaused || this.owedMs < TICK_MS) setTimeout(() => this.run(), 1);
    else this.again();
  }

  /** Sends the state; its arrays are given away, not copied. */
  send() {
    const now = performance.now();
    this.rate.take(now);
    const positionsM = this.tissue.positionsM();
    const { energyJ, sweeps } = this.out[0];
    const tools = this.setup.tools.map(({ kind, radiusM }, tool) => {
      const { forceN, torqueNM, contacts, flags, errorN } = this.out[tool];
      const orientation = [...this.poses.subarray(7 * tool + 3, 7 * tool + 7)];
      const openingRad = this.openings[tool] * OPENING_RAD;
      return { kind, radiusM, positionM: this.positionM(tool), orientation, openingRad, engaged: true, forceN, torqueNM, contacts, flags, errorN };
    });
    const state = {
      tick: this.tick, timeS: this.tick * 1e-3, hash: this.tissue.hash(), positionsM, tools, sweeps, energyJ,
      pressuresPa: this.setup.held.length ? [] : this.tissue.pressuresPa(),
      stressesPa: this.stresses.take(this.isPaused), stressList: this.stresses.list, stepUs: this.rate.stepUs, ticksPerS: this.isPaused ? 0 : this.rate.ticksPerS, trail: this.trail,
      ...this.cuts.take(),
    };
    this.trail = [];
    postMessage({ kind: "state", state }, [positionsM.buffer]);
    this.sentMs = performance.now();
  }
}

/** Poses of the first tool in a press that plays by itself: down along a direction and up again, slowly. */
function demoOf({ startPose, direction, depthM, periodTicks }) {
  return (tick) => {
    const share = 0.5 - 0.5 * Math.cos((2 * Math.PI * tick) / periodTicks);
    return Float32Array.from(startPose, (number, index) => (index < 3 ? number + share * depthM * direction[index] : number));
  };
}

let loop = null;
/** The cells whose stress is shown. */
let stressed = null;

const orders = {
  ...sessionOrders,
  async init({ wasm, image, canBeCut, held }) {
    const { instance } = await WebAssembly.instantiate(wasm);
    const tissue = new Tissue(instance, image, canBeCut);
    tissue.init(held);
    orders.tissue = tissue;
    postMessage({ kind: "info", info: tissue.info });
  },
  begin({ setup }) {
    loop = new Loop(orders.tissue, setup);
    loop.stresses.show(stressed);
  },
  go() {
    loop.lastMs = performance.now();
    loop.run();
  },
  tool({ index, pose }) {
    loop.demo = null;
    loop.targets.set(pose, 7 * index);
  },
  demo: ({ motion }) => (loop.demo = demoOf(motion)),
  pause({ on }) {
    loop.isPaused = on;
    loop.owedMs = 0;
    loop.send();
  },
  show(asked) {
    stressed = asked;
    loop?.stresses.show(asked);
    if (loop?.isPaused) loop.send();
  },
  step() {
    loop.oneTick();
    loop.send();
  },
  setup({ setup, resets }) {
    loop.setup = { ...loop.setup, ...setup };
    loop.trail = [];
    if (!resets) return;
    loop.demo = null;
    loop.reset();
    loop.send();
  },
  path: () => postMessage({ kind: "path", poses: loop.path.slice(0, loop.rowLength * Math.min(loop.tick, PATH_TICKS)), ticks: loop.tick, hash: loop.tissue.hash() }),
};

onmessage = async ({ data }) => {
  try {
    await orders[data.kind](data);
  } catch (why) {
    postMessage({ kind: "problem", text: why.message });
  }
};
