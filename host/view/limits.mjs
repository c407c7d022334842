// Limits of the kernel that page and worker know both.

/** Most tools in a body. */
export const TOOLS_MAX = 8;
/** Unit of the opening of scissors: 2^-16 turn [rad]. */
export const OPENING_RAD = (2 * Math.PI) / 65536;
