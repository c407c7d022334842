// How a worker shares its time between ticks, messages and states.

export const TICK_MS = 1;
/** Longest piece of work without a look at messages [ms]. */
export const WORK_MS = 12;
/** Time that is caught up at most; what is older is left out [ms]. */
export const CATCH_UP_MS = 20;
/** Time between two states [ms]. */
export const STATE_MS = 15;
/** Ticks between two points of the curves. */
export const TRAIL_TICKS = 4;
