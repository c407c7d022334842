// Plays a session at its speed, in the worker, and goes to the ticks that are asked for.
import { Cuts } from "./cuts.mjs";
import { depthOf, touchOf, UNSEEN } from "./depth.mjs";
import { CATCH_UP_MS, Rate, STATE_MS, TICK_MS, TRAIL_TICKS, WORK_MS } from "./pace.mjs";
import { Player } from "./player.mjs";
import { Recording } from "./recording.mjs";
import { Stresses } from "./stresses.mjs";

class SessionLoop {
  constructor(player) {
    this.player = player;
    this.isPaused = false;
    this.speed = 1;
    this.target = null;
    this.trail = [];
    /** First touches and releases, by their ticks. */
    this.touches = [this.first];
    this.owedMs = 0;
    this.lastMs = this.sentMs = performance.now();
    this.rate = new Rate();
    this.stresses = new Stresses(player);
    this.cuts = new Cuts(player);
    const channel = new MessageChannel();
    channel.port1.onmessage = () => this.run();
    this.again = () => channel.port2.postMessage(0);
    this.oneTick();
    this.send();
    this.run();
  }

  oneTick() {
    const begun = performance.now();
    const isDone = this.player.next();
    this.rate.count(begun);
    if (isDone && this.player.tick % TRAIL_TICKS === 0) this.follow();
    return isDone;
  }

  /** Adds to the curves. */
  follow() {
    const [tool] = this.player.tools();
    this.#note(touchOf(this.touched, { ...tool, isTouching: tool.contacts > 0 && tool.engaged }));
    const depthM = depthOf(this.touched, tool.positionM);
    this.trail.push({ timeS: this.player.tick * 1e-3, forceN: Math.hypot(...tool.forceN), errorN: tool.errorN, depthM });
  }

  /** The touch before the first tick: a session from a snapshot may begin in one. */
  get first() {
    return { tick: -1, touched: this.player.recording.snapshot.length ? UNSEEN : null };
  }

  get touched() {
    return this.touches[this.touches.length - 1].touched;
  }

  #note(touched) {
    if (touched !== this.touched) this.touches.push({ tick: this.player.tick, touched });
  }

  /** Goes back to before a tick where that is in the past. */
  rewind(tick) {
    if (!this.player.rewind(tick)) return;
    this.touches = this.touches.filter((touch) => touch.tick <= this.player.tick);
    if (!this.touches.length) this.touches.push(this.first);
  }

  seek(tick) {
    const { first, last } = this.player.recording;
    this.target = Math.min(Math.max(Math.round(tick), first), last);
    if (this.target !== this.player.tick) this.rewind(this.target);
    this.run();
  }

  run() {
    clearTimeout(this.timer);
    const now = performance.now();
    const most = CATCH_UP_MS * Math.max(this.speed, 1);
    if (!this.isPaused) this.owedMs = Math.min(this.owedMs + this.speed * (now - this.lastMs), most);
    this.lastMs = now;
    const isWanted = () => (this.target === null ? !this.isPaused && this.owedMs >= TICK_MS : this.player.tick < this.target);
    while (isWanted() && performance.now() < now + WORK_MS && this.oneTick()) {
      if (this.target === null) this.owedMs -= TICK_MS;
    }
    const isThere = this.target !== null && (this.player.tick >= this.target || this.player.isAtEnd);
    if (isThere) {
      this.target = null;
      this.owedMs = 0;
    }
    if (this.player.isAtEnd) this.owedMs = 0;
    const isMoving = this.target !== null || (!this.isPaused && !this.player.isAtEnd);
    if (isThere || (this.isNew() && performance.now() - this.sentMs >= STATE_MS)) this.send();
    if (!isMoving && !this.isNew()) return;
    if (this.target !== null || this.owedMs >= TICK_MS) this.again();
    else this.timer = setTimeout(() => this.run(), 1);
  }

  /** Whether the last state that was sent is an old one. */
  isNew() {
    return this.player.tick !== this.sentTick;
  }

  pause(on) {
    if (!on && this.player.isAtEnd) this.rewind(this.player.recording.first);
    this.isPaused = on;
    this.owedMs = 0;
    this.lastMs = performance.now();
    this.run();
  }

  step() {
    this.oneTick();
    this.send();
  }

  send() {
    const now = performance.now();
    this.rate.take(now);
    const { player } = this;
    const positionsM = player.positionsM();
    const { energyJ, sweeps } = player.outputAt(player.outputs);
    const { first, last, tools } = player.recording;
    const state = {
      tick: player.tick, timeS: player.tick * 1e-3, hash: player.hash(), positionsM, tools: player.tools(), sweeps, energyJ,
      pressuresPa: tools ? player.pressuresPa() : [], stressesPa: this.stresses.take(this.isPaused || player.isAtEnd), stressList: this.stresses.list, stepUs: this.rate.stepUs, ticksPerS: this.isPaused ? 0 : this.rate.ticksPerS, trail: this.trail,
      ...this.cuts.take(), pins: player.pins(),
      session: { first, last, compared: player.compared.size, differs: player.differs, isAtEnd: player.isAtEnd, isSeeking: this.target !== null },
    };
    this.trail = [];
    this.sentTick = player.tick;
    postMessage({ kind: "state", state }, [positionsM.buffer]);
    this.sentMs = performance.now();
  }
}

let sessionLoop = null;
/** The cells whose stress is shown. */
let askedStress = null;

/** What a page with a recorded session asks of the worker. */
export const sessionOrders = {
  async "session init"({ wasm, image, canBeCut, session }) {
    const { instance } = await WebAssembly.instantiate(wasm);
    sessionOrders.player = new Player(instance, image, canBeCut, new Recording(session));
    const { first, last, tools } = sessionOrders.player.recording;
    postMessage({ kind: "info", info: { ...sessionOrders.player.info, hasTools: tools > 0, session: { first, last } } });
  },
  "session begin"() {
    sessionLoop = new SessionLoop(sessionOrders.player);
    sessionLoop.stresses.show(askedStress);
  },
  "session pause": ({ on }) => sessionLoop.pause(on),
  "session show"(asked) {
    askedStress = asked;
    sessionLoop?.stresses.show(asked);
    sessionLoop?.send();
  },
  "session step": () => sessionLoop.step(),
  "session seek": ({ tick }) => sessionLoop.seek(tick),
  "session speed": ({ factor }) => (sessionLoop.speed = factor),
};
