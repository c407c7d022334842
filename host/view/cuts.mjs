// The cuts of a body, in the worker: their numbers for each state, and the triangles of the surface where they have changed.

export class Cuts {
  constructor(tissue) {
    this.tissue = tissue;
    this.triangles = null;
  }

  /** Returns what a state has of the cuts: nothing of a body that cannot be cut, `triangles` only if they are new. */
  take() {
    if (!this.tissue.canBeCut) return {};
    const { areaM2, workJ, ...counts } = this.tissue.cuts();
    const cuts = { areaM2, workJ, ...counts };
    // A body that is whole has the triangles of its model.
    const triangles = counts.openedFaces > 0 ? this.#now(counts) : null;
    if (triangles === this.triangles) return { cuts };
    this.triangles = triangles;
    return { cuts, triangles };
  }

  /** The triangles of now: the same array while nothing has changed. */
  #now(counts) {
    const { restores } = this.tissue;
    const key = JSON.stringify({ ...counts, restores });
    if (this.triangles && key === this.key) return this.triangles;
    this.key = key;
    return this.tissue.triangles();
  }
}
