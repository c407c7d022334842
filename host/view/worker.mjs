// The kernel's loop, in a worker: ticks at 1 kHz as far as the machine allows, the newest state some 60 times a
// second. The tool walks to where the hand has it.
import { Tissue } from "./kernel.mjs";
import { CATCH_UP_MS, Rate, STATE_MS, TICK_MS, TRAIL_TICKS, WORK_MS } from "./pace.mjs";
import { sessionOrders } from "./session_loop.mjs";

/** Farthest that the tool moves in a tick [m]. */
const TOOL_STEP_M = 0.0004;
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
    this.reset();
    const channel = new MessageChannel();
    channel.port1.onmessage = () => this.run();
    this.again = () => channel.port2.postMessage(0);
    this.send();
    this.run();
  }

  /** The body at rest, the tool where the scene begins. */
  reset() {
    const { parts, held, friction, startPose } = this.setup;
    if (parts) this.tissue.resetWithTool(parts, friction);
    else this.tissue.resetHolding(held);
    this.tick = 0;
    this.pose = Float32Array.from(startPose);
    this.target = Float32Array.from(startPose);
    this.out = { forceN: [0, 0, 0], torqueNM: [0, 0, 0], contacts: 0, flags: 0, energyJ: 0, sweeps: 0 };
    this.path = new Float32Array(8 * 4096);
    this.touched = null;
    this.trail = [];
  }

  /** Moves the tool towards its target by what a hand does in a tick, turns it at once. */
  walk() {
    if (this.demo) this.target = this.demo(this.tick);
    const away = [0, 1, 2].map((axis) => this.target[axis] - this.pose[axis]);
    const length = Math.hypot(...away);
    const share = length > TOOL_STEP_M ? TOOL_STEP_M / length : 1;
    for (let axis = 0; axis < 3; axis++) this.pose[axis] += share * away[axis];
    this.pose.set(this.target.subarray(3), 3);
  }

  oneTick() {
    this.walk();
    const begun = performance.now();
    this.out = this.tissue.tick(this.pose, true, this.setup.sweeps);
    this.rate.count(begun);
    this.remember();
    this.tick += 1;
    this.follow();
  }

  /** Adds the tick to the path. */
  remember() {
    if (this.tick >= PATH_TICKS) return;
    if (8 * this.tick === this.path.length) {
      const longer = new Float32Array(2 * this.path.length);
      longer.set(this.path);
      this.path = longer;
    }
    this.path.set(this.pose, 8 * this.tick);
    this.path[8 * this.tick + 7] = this.setup.sweeps;
  }

  /** Adds to the curves; depth counts from the first touch, against the force that was felt there. */
  follow() {
    const forceN = Math.hypot(...this.out.forceN);
    if (this.out.contacts === 0) this.touched = null;
    else if (!this.touched && forceN > 0) {
      this.touched = { pose: this.pose.slice(0, 3), against: this.out.forceN.map((force) => force / forceN) };
    }
    if (this.tick % TRAIL_TICKS !== 0) return;
    const depth = (sum, against, axis) => sum + against * (this.touched.pose[axis] - this.pose[axis]);
    const depthM = this.touched ? this.touched.against.reduce(depth, 0) : 0;
    this.trail.push({ timeS: this.tick * 1e-3, forceN, depthM });
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
    const { forceN, torqueNM, contacts, flags, energyJ, sweeps } = this.out;
    const tool = {
      kind: this.setup.tool, radiusM: this.setup.radiusM, positionM: [...this.pose.slice(0, 3)],
      orientation: [...this.pose.slice(3, 7)], engaged: true, forceN, torqueNM, contacts, flags,
    };
    const state = {
      tick: this.tick, timeS: this.tick * 1e-3, hash: this.tissue.hash(), positionsM, tools: [tool], sweeps, energyJ,
      pressuresPa: this.setup.parts ? this.tissue.pressuresPa() : [],
      stepUs: this.rate.stepUs, ticksPerS: this.isPaused ? 0 : this.rate.ticksPerS, trail: this.trail,
    };
    this.trail = [];
    postMessage({ kind: "state", state }, [positionsM.buffer]);
    this.sentMs = performance.now();
  }
}

/** Poses of a press that plays by itself: down along a direction and up again, slowly. */
function demoOf({ startPose, direction, depthM, periodTicks }) {
  return (tick) => {
    const share = 0.5 - 0.5 * Math.cos((2 * Math.PI * tick) / periodTicks);
    return Float32Array.from(startPose, (number, index) => (index < 3 ? number + share * depthM * direction[index] : number));
  };
}

let loop = null;

const orders = {
  ...sessionOrders,
  async init({ wasm, image, held }) {
    const { instance } = await WebAssembly.instantiate(wasm);
    const tissue = new Tissue(instance, image);
    tissue.init(held);
    orders.tissue = tissue;
    postMessage({ kind: "info", info: tissue.info });
  },
  begin: ({ setup }) => (loop = new Loop(orders.tissue, setup)),
  tool({ pose }) {
    loop.demo = null;
    loop.target = Float32Array.from(pose);
  },
  demo: ({ motion }) => (loop.demo = demoOf(motion)),
  pause({ on }) {
    loop.isPaused = on;
    loop.owedMs = 0;
    loop.send();
  },
  step() {
    loop.oneTick();
    loop.send();
  },
  setup({ setup, resets }) {
    loop.setup = { ...loop.setup, ...setup };
    if (!resets) return;
    loop.demo = null;
    loop.reset();
    loop.send();
  },
  path: () => postMessage({ kind: "path", poses: loop.path.slice(0, 8 * Math.min(loop.tick, PATH_TICKS)), ticks: loop.tick, hash: loop.tissue.hash() }),
};

onmessage = async ({ data }) => {
  try {
    await orders[data.kind](data);
  } catch (why) {
    postMessage({ kind: "problem", text: why.message });
  }
};
