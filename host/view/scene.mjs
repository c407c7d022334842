// The picture: body, tools through the body, arrows of force and torque, links and fixed cells.
import { QUANTITIES, RAMP, Scale } from "./colours.mjs";
import { Painter } from "./gl.mjs";
import { partsOf } from "./parts.mjs";
import { arrow, disc, roundedBox } from "./shapes.mjs";
import { Surface } from "./surface.mjs";
import { add, length, placed, times, turnTo, turned, unit } from "./vectors.mjs";

const PAINT = { tool: [0.24, 0.47, 0.78], force: [0.13, 0.62, 0.36], torque: [0.62, 0.36, 0.8], fixed: [0.13, 0.2, 0.32] };
/** Forces [N] and torques [N m] below these have no arrow. */
const LEAST = { force: 5e-3, torque: 2e-4 };

export class Scene {
  constructor(canvas, camera) {
    this.camera = camera;
    this.painter = new Painter(canvas);
    this.canvas = canvas;
    this.look = { colour: "displacement", wires: false, links: false, fixed: true };
    this.scale = new Scale();
    this.force = this.painter.solidMesh(arrow(1));
    this.torque = this.painter.solidMesh(arrow(2));
    this.tools = new Map();
    this.longest = { force: 0.5, torque: 5e-3 };
    this.isNew = true;
  }

  /** Takes over a body. */
  ready(body) {
    this.body = body;
    this.surface = new Surface(body);
    this.mesh = this.painter.bodyMesh(this.surface.points, this.surface.pieces);
    const wires = [];
    for (let corner = 0; corner < body.triangles.length; corner++) {
      const next = corner % 3 === 2 ? corner - 2 : corner + 1;
      if (body.triangles[corner] < body.triangles[next]) wires.push(body.triangles[corner], body.triangles[next]);
    }
    const onSurface = new Set(body.triangles);
    const fixed = body.fixed.filter((cell) => onSurface.size === 0 || onSurface.has(cell));
    this.network = this.painter.network(body.restM.length / 3, { links: body.links, wires: new Uint32Array(wires), fixed });
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

  /** Takes over a state. */
  take(state) {
    this.state = state;
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

  /** Draws where something has changed, and returns whether it did. */
  draw() {
    const { gl } = this.painter;
    const ratio = Math.min(globalThis.devicePixelRatio || 1, 2);
    const [width, height] = [Math.round(this.camera.width * ratio), Math.round(this.camera.height * ratio)];
    if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
    // Nothing is drawn again that would look the same.
    const look = [this.camera.yaw, this.camera.pitch, this.camera.distance, width, height].join();
    if (!this.isNew && look === this.lastLook) return false;
    this.lastLook = look;
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (!this.state) return false;
    if (this.isNew) this.#update();
    this.view = { ...this.camera.axes(), matrix: this.camera.matrix(), ratio };
    if (this.look.links) this.#drawLines("links", [0.55, 0.3, 0.28, 0.5]);
    else this.#drawBody();
    if (this.look.wires && !this.look.links) this.#drawLines("wires", [0.1, 0.05, 0.05, 0.45]);
    if (this.look.fixed) this.#drawLines("fixed", [...PAINT.fixed, 0.85], 5);
    this.#drawShapes();
    return true;
  }

  #update() {
    const quantity = QUANTITIES[this.look.colour];
    this.surface.update(this.state, this.look.colour);
    this.scale.follow(this.surface.most(), quantity);
    this.mesh.fill();
    this.network.fill(this.state.positionsM);
    this.isNew = false;
  }

  #use(program) {
    const { gl } = this.painter;
    program.use();
    gl.uniformMatrix4fv(program.uniform("camera"), false, this.view.matrix);
    for (const name of ["eye", "right", "up"]) gl.uniform3fv(program.uniform(name), this.view[name]);
  }

  #drawBody() {
    const { gl, body } = this.painter;
    this.#use(body);
    gl.uniform3fv(body.uniform("ramp[0]"), RAMP.flat());
    gl.uniform2f(body.uniform("range"), QUANTITIES[this.look.colour].from, this.scale.end);
    const [tool] = this.state.tools;
    const isBall = tool?.kind?.startsWith("sphere");
    gl.uniform4f(body.uniform("shade"), ...(isBall ? [...tool.positionM, tool.radiusM] : [0, 0, 0, 0]));
    gl.uniform4f(body.uniform("tint"), 0, 0, 0, 0);
    this.mesh.draw();
  }

  #drawLines(name, paint, pixels = 0) {
    const { gl, line } = this.painter;
    line.use();
    gl.enable(gl.BLEND);
    gl.uniformMatrix4fv(line.uniform("camera"), false, this.view.matrix);
    gl.uniform4f(line.uniform("paint"), ...paint);
    gl.uniform1f(line.uniform("pixels"), pixels * this.view.ratio);
    this.network.draw(name, pixels > 0);
    gl.disable(gl.BLEND);
  }

  /** Tools and arrows: first pale what lies behind the body, then what lies before it. */
  #drawShapes() {
    const { gl, solid } = this.painter;
    const shapes = this.state.tools.flatMap((tool) => [...this.#toolShapes(tool), ...this.#arrows(tool)]);
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

  #toolShapes(tool) {
    const kind = tool.kind ?? `sphere:${tool.radiusM}`;
    return this.#shapesOf(kind).map((part) => ({
      mesh: part.mesh,
      model: placed(add(tool.positionM, turned(tool.orientation, part.centreM)), times(tool.orientation, part.orientation)),
      paint: PAINT.tool,
      isPale: part.isHalfSpace,
    }));
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

  /** Returns where the force's arrow of the first tool ends, or nothing. */
  forceTip() {
    const tool = this.state?.tools[0];
    const size = tool ? length(tool.forceN) : 0;
    if (!(size > LEAST.force)) return null;
    const long = this.#arrowLength("force", size);
    return { ...this.camera.project(add(tool.positionM, unit(tool.forceN), long)), forceN: size };
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
