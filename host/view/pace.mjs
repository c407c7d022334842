// How a worker shares its time between ticks, messages and states, and how a page counts ticks.

export const TICK_MS = 1;
/** Longest piece of work without a look at messages [ms]. */
export const WORK_MS = 12;
/** Time that is caught up at most; what is older is left out [ms]. */
export const CATCH_UP_MS = 20;
/** Time between two states [ms]. */
export const STATE_MS = 15;
/** Ticks between two points of the curves. */
export const TRAIL_TICKS = 4;
/** Time over which ticks are counted [ms]. */
export const COUNT_MS = 500;

/** Time of a tick and ticks a second, of the last half second. */
export class Rate {
  constructor() {
    this.stepUs = this.ticksPerS = 0;
    this.busyMs = this.ticks = 0;
    this.sinceMs = performance.now();
  }

  /** Counts a tick that has just ended. */
  count(begunMs) {
    this.busyMs += performance.now() - begunMs;
    this.ticks += 1;
  }

  /** Takes the figures of what was counted, once that is long enough. */
  take(nowMs) {
    if (nowMs - this.sinceMs <= COUNT_MS) return;
    this.stepUs = this.ticks ? (1000 * this.busyMs) / this.ticks : 0;
    this.ticksPerS = (1000 * this.ticks) / (nowMs - this.sinceMs);
    this.busyMs = this.ticks = 0;
    this.sinceMs = nowMs;
  }
}
