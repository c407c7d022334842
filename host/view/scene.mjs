// The picture: body, tools through the body, arrows of force and torque, links and fixed cells.
import { ChainMail } from "./chainmail.mjs";
import { QUANTITIES, Scale } from "./colours.mjs";
import { Figure } from "./figure.mjs";
import { Painter } from "./gl.mjs";
import { opened, partsOf } from "./parts.mjs";
import { arrow, disc, roundedBox } from "./shapes.mjs";
import { add, length, placed, times, turnTo, turned, unit } from "./vectors.mjs";
import { cutBody } from "./wound.mjs";

const PAINT = { tool: [0.24, 0.47, 0.78], other: [0.5, 0.54, 0.6], force: [0.13, 0.62, 0.36], torque: [0.62, 0.36, 0.8], fixed: [0.13, 0.2, 0.32] };
/** Forces [N] and torques [N m] below these have no arrow. */
const LEAST = { force: 5e-3, torque: 2e-4 };
/** A new surface is made after so many times what the last one took. */
const REST = 3;

export class Scene {
  /** `ramp` are the colours of numbers, red, green and blue from 0 to 255. */
  constructor(canvas, camera, ramp) {
    this.camera = camera;
    this.ramp = ramp.flat().map((part) => part / 255);
    this.painter = new Painter(canvas, ramp.length);
    this.canvas = canvas;
    this.look = { colour: "displacement", wires: false, links: false, fixed: true };
    this.scale = new Scale();
    this.force = this.painter.solidMesh(arrow(1));
    this.torque = this.painter.solidMesh(arrow(2));
    this.tools = new Map();
    this.longest = { force: 0.5, torque: 5e-3 };
    /** The tool that is shown as the chosen one. */
    this.chosen = 0;
    this.chain = null;
    this.isNew = true;
  }

  /** Takes over a body. */
  ready(body) {
    this.body = body;
    this.state = null;
    this.triangles = undefined;
    this.surfaceTook = { ms: 0, atMs: 0 };
    this.#show(body);
    this.compare(this.chain !== null);
    const cells = body.restM.length / 3;
    let [low, high] = [[Infinity, Infinity, Infinity], [-Infinity, -Infinity, -Infinity]];
    for (let cell = 0; cell < cells; cell++) {
      low = low.map((least, axis) => Math.min(least, body.restM[3 * cell + axis]));
      high = high.map((most, axis) => Math.max(most, body.restM[3 * cell + axis]));
    }
    const centre = low.map((least, axis) => (least + high[axis]) / 2);
    this.size = length(add(high, low, -1)) / 2;
    this.camera.lookAt(centre, this.size);
    this.scale = new Scale();
  }

  /** Takes over a state, of a body that is cut with its triangles where they are new; null for a whole one. */
  take(state) {
    this.state = state;
    if (state.triangles !== undefined) this.triangles = state.triangles;
    this.isNew = true;
  }

  /** Draws another body from now on: whole or cut. */
  #show(body) {
    this.figure?.free();
    this.figure = new Figure(this.painter, body);
  }

  /** Makes the surface of a body that was cut since. Returns whether it did: it takes its time, so it pauses in between. */
  renew() {
    const now = performance.now();
    if (this.triangles === undefined || now < this.surfaceTook.atMs + REST * this.surfaceTook.ms) return false;
    const { surface } = this.figure;
    this.#show(this.triangles ? cutBody(this.body, this.triangles) : this.body);
    this.figure.surface.inherit(surface);
    this.triangles = undefined;
    const endMs = performance.now();
    this.surfaceTook = { ms: endMs - now, atMs: endMs };
    this.isNew = true;
    return true;
  }

  /** Shows another tool as the chosen one. */
  choose(tool) {
    this.chosen = tool;
    this.isNew = true;
  }

  setLook(look) {
    if (look.colour && look.colour !== this.look.colour) this.scale = new Scale();
    this.look = { ...this.look, ...look };
    this.isNew = true;
  }

  /** Meshes of a tool by its text. */
  #shapesOf(kind) {
    if (!this.tools.has(kind)) {
      const shapes = partsOf(kind).map((part) => {
        const isHalfSpace = part.kind === "half-space";
        const mesh = isHalfSpace ? disc(1.4 * this.size) : roundedBox(part.halfM, part.radiusM);
        return { ...part, isHalfSpace, mesh: this.painter.solidMesh(mesh) };
      });
      this.tools.set(kind, shapes);
    }
    return this.tools.get(kind);
  }

  /** Shows ChainMail under the same tools beside the body, or no more. */
  compare(on) {
    this.chain?.figure.free();
    this.chain = on ? { mail: new ChainMail(this.body), figure: new Figure(this.painter, this.body) } : null;
    this.isNew = true;
  }

  /** Draws where something has changed, and returns whether it did. */
  draw() {
    if (!this.state) return false;
    const { gl } = this.painter;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const [width, height] = [Math.round(this.camera.width * ratio), Math.round(this.camera.height * ratio)];
    const { yaw, pitch, distance, pictures } = this.camera;
    if (this.canvas.width !== pictures * width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [pictures * width, height];
    // Nothing is drawn again that would look the same.
    const look = [yaw, pitch, distance, pictures, width, height].join();
    if (!this.isNew && look === this.lastLook) return false;
    this.lastLook = look;
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.isNew) this.#update();
    this.view = { ...this.camera.axes(), matrix: this.camera.matrix(), ratio };
    gl.viewport(0, 0, width, height);
    this.#drawFigure(this.figure, this.state.tools, this.state.pins);
    if (this.chain && pictures > 1) {
      gl.viewport(width, 0, width, height);
      const withoutForce = this.state.tools.map((tool) => ({ ...tool, forceN: [0, 0, 0], torqueNM: [0, 0, 0] }));
      this.#drawFigure(this.chain.figure, withoutForce);
    }
    return true;
  }

  #update() {
    const { colour } = this.look;
    let most = this.figure.update(this.state, colour);
    if (this.chain) {
      const { mail, figure } = this.chain;
      mail.follow(this.state);
      most = Math.max(most, figure.update({ positionsM: Float32Array.from(mail.positionsM) }, colour));
    }
    this.scale.follow(most, QUANTITIES[colour]);
    this.isNew = false;
  }

  #drawFigure(figure, tools, pins = []) {
    if (this.look.links) this.#drawLines(figure, "links", [0.55, 0.3, 0.28, 0.5]);
    else this.#drawBody(figure, tools[0]);
    if (this.look.wires && !this.look.links) this.#drawLines(figure, "wires", [0.1, 0.05, 0.05, 0.45]);
    if (this.look.fixed) this.#drawLines(figure, "fixed", [...PAINT.fixed, 0.85], 5);
    this.#drawShapes(tools, pins);
  }

  #use(program) {
    const { gl } = this.painter;
    program.use();
    gl.uniformMatrix4fv(program.uniform("camera"), false, this.view.matrix);
    for (const name of ["eye", "right", "up"]) gl.uniform3fv(program.uniform(name), this.view[name]);
  }

  #drawBody(figure, tool) {
    const { gl, body } = this.painter;
    this.#use(body);
    gl.uniform3fv(body.uniform("ramp[0]"), this.ramp);
    gl.uniform2f(body.uniform("range"), QUANTITIES[this.look.colour].from, this.scale.end);
    const isBall = tool?.kind?.startsWith("sphere");
    gl.uniform4f(body.uniform("shade"), ...(isBall ? [...tool.positionM, tool.radiusM] : [0, 0, 0, 0]));
    figure.mesh.draw();
  }

  #drawLines(figure, name, paint, pixels = 0) {
    const { gl, line } = this.painter;
    line.use();
    gl.enable(gl.BLEND);
    gl.uniformMatrix4fv(line.uniform("camera"), false, this.view.matrix);
    gl.uniform4f(line.uniform("paint"), ...paint);
    gl.uniform1f(line.uniform("pixels"), pixels * this.view.ratio);
    figure.network.draw(name, pixels > 0);
    gl.disable(gl.BLEND);
  }

  /** Tools and arrows: first pale what lies behind the body, then what lies before it. */
  #drawShapes(tools, pins) {
    const { gl, solid } = this.painter;
    const shapes = tools.flatMap((tool, index) => [...this.#toolShapes(tool, index), ...this.#arrows(tool)]);
    shapes.push(...pins.flatMap((pin) => [this.#pinShape(pin), ...this.#arrows({ ...pin, torqueNM: [0, 0, 0] })]));
    this.#use(solid);
    const draw = ({ mesh, model, paint }, alpha) => {
      gl.uniformMatrix4fv(solid.uniform("model"), false, model);
      gl.uniform4f(solid.uniform("paint"), ...paint, alpha);
      mesh.draw();
    };
    gl.enable(gl.BLEND);
    gl.depthMask(false);
    gl.depthFunc(gl.GREATER);
    for (const shape of shapes) draw(shape, 0.4);
    gl.depthFunc(gl.LEQUAL);
    for (const shape of shapes.filter((shape) => shape.isPale)) draw(shape, 0.35);
    gl.depthMask(true);
    gl.disable(gl.BLEND);
    for (const shape of shapes.filter((shape) => !shape.isPale)) draw(shape, 1);
  }

  #toolShapes(tool, index) {
    const kind = tool.kind ?? `sphere:${tool.radiusM}`;
    return this.#shapesOf(kind).map((part) => {
      const { centreM, orientation } = opened(part, tool.openingRad);
      return {
        mesh: part.mesh,
        model: placed(add(tool.positionM, turned(tool.orientation, centreM)), times(tool.orientation, orientation)),
        paint: index === this.chosen ? PAINT.tool : PAINT.other,
        isPale: part.isHalfSpace,
      };
    });
  }

  /** A small ball where a pin holds the tissue. */
  #pinShape({ positionM }) {
    this.pin ??= this.painter.solidMesh(roundedBox([0, 0, 0], 1));
    const radiusM = 0.025 * this.size;
    return { mesh: this.pin, model: placed(positionM, [0, 0, 0, 1], [radiusM, radiusM, radiusM]), paint: PAINT.fixed };
  }

  #arrows(tool) {
    return [["force", tool.forceN], ["torque", tool.torqueNM]].flatMap(([name, vector]) => {
      const size = length(vector);
      if (!(size > LEAST[name])) return [];
      this.longest[name] = Math.max(this.longest[name], size);
      const long = this.#arrowLength(name, size);
      const thick = 0.55 * this.size;
      const model = placed(tool.positionM, turnTo(unit(vector)), [thick, thick, long]);
      return [{ mesh: this[name], model, paint: PAINT[name] }];
    });
  }

  /** Arrows are as long as the size of what they show, the longest so far half the body's radius. */
  #arrowLength(name, size) {
    return this.size * (0.16 + (0.36 * size) / this.longest[name]);
  }

  /** Returns where the force's arrow of the chosen tool ends, and whether it points down; or nothing. */
  forceTip() {
    const tool = this.state?.tools[this.chosen];
    const size = tool ? length(tool.forceN) : 0;
    if (!(size > LEAST.force)) return null;
    const long = this.#arrowLength("force", size);
    const tip = this.camera.project(add(tool.positionM, unit(tool.forceN), long));
    return { ...tip, isDown: tip.y > this.camera.project(tool.positionM).y, forceN: size };
  }

  /** Returns a picture of what is shown, as a canvas. */
  picture(background) {
    this.isNew = true;
    this.draw();
    const copy = document.createElement("canvas");
    [copy.width, copy.height] = [this.canvas.width, this.canvas.height];
    const pen = copy.getContext("2d");
    pen.fillStyle = background;
    pen.fillRect(0, 0, copy.width, copy.height);
    pen.drawImage(this.canvas, 0, 0);
    return copy;
  }
}
