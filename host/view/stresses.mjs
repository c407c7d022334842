// The stress that the colours show, in the worker: some cells of the surface for each state, so that no tick waits for all.

/** Cells between two states while time goes on. */
const CELLS = 64;

export class Stresses {
  constructor(tissue) {
    this.tissue = tissue;
    this.show(null);
  }

  /** Shows the stress of the cells of these input ids, a list with this number, or none for null. */
  show(asked) {
    const { ids: inputIds, list } = asked ?? {};
    this.list = list;
    const known = new Map(this.inputIds?.map((id, index) => [id, this.valuesPa[index]]));
    this.inputIds = inputIds ?? [];
    this.valuesPa = Float32Array.from(this.inputIds, (id) => known.get(id) ?? 0);
    this.next = 0;
  }

  /** Computes the next cells, or all where time stands still; returns the newest of all [Pa], in the order of the ids. */
  take(standsStill) {
    const count = standsStill ? this.inputIds.length : Math.min(CELLS, this.inputIds.length);
    for (let done = 0; done < count; done++) {
      this.valuesPa[this.next] = this.tissue.stressPa(this.inputIds[this.next]);
      this.next = (this.next + 1) % this.inputIds.length;
    }
    return this.valuesPa.slice();
  }
}
