// The hand: pointer, wheel, keys and buttons move the tool or turn the view.
import { add, length, scale, times, turnAbout } from "./vectors.mjs";

/** Least distance from the tool at which a pointer takes it [CSS pixels]: of a mouse, of a finger. */
const REACH = { mouse: 22, touch: 44, pen: 30 };
/** What a notch of the wheel, a key and a frame of a held button move [m in parts of the body's radius]. */
const MOVES = { wheel: 0.012, key: 0.012, button: 0.0035 };

export class Hand {
  /**
   * `scene` has the tool's place and the body's size, `move(pose)` puts the tool there, `normal()` is the surface's
   * outward normal at the tool, `touched()` is called when somebody takes the tool.
   */
  constructor(stage, camera, { tool, size, normal, move, touched }) {
    Object.assign(this, { stage, camera, tool, size, normal, move, touched });
    this.pointers = new Map();
    this.holds = null;
    stage.addEventListener("pointerdown", (event) => this.#down(event));
    stage.addEventListener("pointermove", (event) => this.#moved(event));
    for (const end of ["pointerup", "pointercancel"]) stage.addEventListener(end, (event) => this.#up(event));
    stage.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    stage.addEventListener("contextmenu", (event) => event.preventDefault());
  }

  #place(event) {
    const { left, top } = this.stage.getBoundingClientRect();
    return { x: event.clientX - left, y: event.clientY - top };
  }

  /** Whether a pointer is at the tool. */
  isAtTool(event) {
    const tool = this.tool();
    if (!tool) return false;
    const place = this.#place(event);
    const { x, y, pixelsPerM } = this.camera.project(tool.positionM);
    const reach = Math.max(REACH[event.pointerType] ?? REACH.mouse, 1.15 * tool.reachM * pixelsPerM);
    return Math.hypot(place.x - x, place.y - y) < reach;
  }

  #down(event) {
    this.stage.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, this.#place(event));
    if (this.pointers.size === 2) {
      this.holds = "zoom";
      return;
    }
    this.holds = this.isAtTool(event) && event.button === 0 ? "tool" : "view";
    if (this.holds === "tool") this.#take();
    this.#showCursor(event);
  }

  #take() {
    this.touched();
    this.goal = { positionM: [...this.tool().positionM], orientation: [...this.tool().orientation] };
  }

  #moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return this.#showCursor(event);
    const place = this.#place(event);
    const [right, down] = [place.x - before.x, place.y - before.y];
    if (this.holds === "zoom") this.#pinch(event.pointerId, before, place);
    else if (this.holds === "view") this.camera.turn(right, down);
    else if (event.shiftKey) this.#turnTool(right, down);
    else this.#shift(this.camera.across(this.goal.positionM, right, down));
    this.pointers.set(event.pointerId, place);
  }

  #pinch(id, before, place) {
    const [other] = [...this.pointers].filter(([key]) => key !== id).map(([, value]) => value);
    const span = (one) => Math.max(Math.hypot(one.x - other.x, one.y - other.y), 1);
    this.camera.zoom(span(before) / span(place));
  }

  #up(event) {
    this.pointers.delete(event.pointerId);
    if (this.pointers.size === 0) this.holds = null;
    this.#showCursor(event);
  }

  #showCursor(event) {
    const isAt = this.holds === "tool" || (!this.holds && this.isAtTool(event));
    this.stage.style.cursor = isAt ? (this.holds ? "grabbing" : "grab") : "";
  }

  #wheel(event) {
    event.preventDefault();
    if (event.ctrlKey || !this.tool()) this.camera.zoom(Math.exp(event.deltaY / 400));
    else this.along(event.deltaY > 0 ? -MOVES.wheel : MOVES.wheel);
  }

  /** Moves the tool along the surface's normal, by so much of the body's radius; below 0 into the body. */
  along(share) {
    if (!this.tool()) return;
    if (this.holds !== "tool") this.#take();
    this.#shift(scale(this.normal(), share * this.size()));
  }

  /** One frame of a button that is held. */
  hold(direction) {
    this.along(direction * MOVES.button);
  }

  #shift(motion) {
    const moved = add(this.goal.positionM, motion);
    const away = add(moved, this.camera.aim, -1);
    const most = 2 * this.size();
    this.goal.positionM = length(away) > most ? add(this.camera.aim, away, most / length(away)) : moved;
    this.move(this.goal);
  }

  #turnTool(right, down) {
    const { right: axis, up } = this.camera.axes();
    const turn = times(turnAbout(up, right / 120), turnAbout(axis, down / 120));
    const turned = times(turn, this.goal.orientation);
    const size = Math.hypot(...turned);
    this.goal.orientation = turned.map((part) => part / size);
    this.move(this.goal);
  }

  /** Moves by a key; returns whether the key means a motion. */
  key(name) {
    const across = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[name];
    const along = { PageDown: -1, PageUp: 1, s: -1, w: 1 }[name];
    if (!this.tool() || (!across && !along)) return false;
    if (along) this.along(along * MOVES.key);
    else {
      this.#take();
      const { right, up } = this.camera.axes();
      const step = MOVES.key * this.size();
      this.#shift(add(scale(right, across[0] * step), up, across[1] * step));
    }
    return true;
  }
}
