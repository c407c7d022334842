// How deep a tool is: from its first touch, along the force that was felt there.

/** The touch of a tool that already touched when it was first seen: where it began is not known. */
export const UNSEEN = { positionM: null };

/** Returns the touch of a tool, null while it does not touch; `touched` is the one of the tick before. */
export function touchOf(touched, { isTouching, forceN, positionM }) {
  const size = Math.hypot(...forceN);
  if (!isTouching) return null;
  return touched ?? (size > 0 ? { positionM, against: forceN.map((force) => force / size) } : null);
}

/** Returns the depth of a tool at a place [m], NaN where it is not known, 0 without a touch. */
export function depthOf(touched, positionM) {
  if (!touched) return 0;
  if (!touched.positionM) return NaN;
  return touched.against.reduce((sum, against, axis) => sum + against * (touched.positionM[axis] - positionM[axis]), 0);
}
