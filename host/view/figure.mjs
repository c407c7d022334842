// One body as it is drawn: its surface, its links and its fixed cells.
import { Surface } from "./surface.mjs";

export class Figure {
  constructor(painter, body) {
    this.surface = new Surface(body);
    this.mesh = painter.bodyMesh(this.surface.points, this.surface.pieces);
    const wires = [];
    for (let corner = 0; corner < body.triangles.length; corner++) {
      const next = corner % 3 === 2 ? corner - 2 : corner + 1;
      if (body.triangles[corner] < body.triangles[next]) wires.push(body.triangles[corner], body.triangles[next]);
    }
    const onSurface = new Set(body.triangles);
    const fixed = body.fixed.filter((cell) => onSurface.size === 0 || onSurface.has(cell));
    this.network = painter.network(body.restM.length / 3, { links: body.links ?? new Uint32Array(wires), wires: new Uint32Array(wires), fixed });
  }

  /** Gives its memory back. */
  free() {
    this.mesh.free();
    this.network.free();
  }

  /** Takes over positions and pressures; returns the largest of the numbers that the colours show. */
  update(state, colour) {
    this.surface.update(state, colour);
    this.mesh.fill();
    this.network.fill(state.positionsM);
    return this.surface.most();
  }
}
