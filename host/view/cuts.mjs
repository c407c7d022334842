// The cuts of a body, in the worker: their numbers for each state, and the triangles of the surface where they have changed.

export class Cuts {
  constructor(tissue) {
    this.tissue = tissue;
    this.triangles = null;
  }

  /** Returns what a state has of the cuts: nothing of a body that cannot be cut, `triangles` only if they are new. */
  take() {
    if (!this.tissue.canBeCut) return {};
    const cuts = this.tissue.cuts();
    // A body that is whole has the triangles of its model.
    const triangles = cuts.openedFaces > 0 ? this.#now(cuts) : null;
    if (triangles === this.triangles) return { cuts };
    this.triangles = triangles;
    return { cuts, triangles };
  }

  /** The triangles of now: the same array while nothing has changed. */
  #now({ openedFaces, copies, waiting, torn }) {
    const key = [openedFaces, copies, waiting, torn, this.tissue.restores].join();
    if (this.triangles && key === this.key) return this.triangles;
    this.key = key;
    return this.tissue.triangles();
  }
}
