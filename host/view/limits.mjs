// Limits of the kernel that page and worker know both.

/** Most tools in a body. */
export const TOOLS_MAX = 8;
