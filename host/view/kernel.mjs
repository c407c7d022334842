// A tissue of the kernel as WebAssembly, by its C interface (kernel/ffi/include/chaincell.h): addresses have
// 32 bits, all is little-endian, and what the caller owns stands behind the module's own memory.
import { TOOLS_MAX } from "./limits.mjs";

const SCHEME_TRACK = 0;
const SCHEME_PREDICT = 7;
const PAGE_BYTES = 65536;
/** Triangles in reach and samples that friction holds: those of the command. */
const TRIANGLES = 1024;
const SAMPLES = 2048;
/** Samples that all pins together hold: those of the command. */
export const PINNED = 2048;
/** Bytes of the interface's structs; `model` is CHAINCELL_MODEL_BYTES. */
export const BYTES = { model: 656, detail: 20, info: 64, settings: 32, room: 24, budget: 16, pose: 32, output: 60, part: 44, contact: 60, stress: 44, cuts: 32, triangle: 24, pin: 48 };
/** Most parts of a tool. */
const PARTS_MAX = 8;
/** Most sweeps that a tick may be asked for. */
const SWEEPS_MAX = 64;

export class Tissue {
  /** A body at rest of an image's bytes, with memory for cuts if it can be cut. Throws an Error that says what was refused. */
  constructor(instance, image, canBeCut) {
    this.canBeCut = canBeCut;
    this.exports = instance.exports;
    this.memory = this.exports.memory;
    this.free = this.exports.__heap_base.value;
    const imageAt = this.take(image.length, 16);
    new Uint8Array(this.memory.buffer).set(image, imageAt);
    this.model = this.take(BYTES.model, 16);
    this.detail = this.take(BYTES.detail, 16);
    this.check(this.exports.chaincell_model_init(this.model, imageAt, image.length, this.detail));
    this.info = this.#info();
    this.poses = this.take(BYTES.pose * TOOLS_MAX, 16);
    this.outputs = this.take(BYTES.output * TOOLS_MAX, 16);
    this.budget = this.take(BYTES.budget, 16);
    this.result = this.take(16, 16);
    this.positions = this.take(12 * this.info.cells, 16);
    this.contacts = this.take(BYTES.contact * TRIANGLES, 16);
    this.parts = this.take(BYTES.part * PARTS_MAX * TOOLS_MAX, 16);
    this.counts = this.take(4 * TOOLS_MAX, 16);
  }

  #info() {
    const info = this.take(BYTES.info, 16);
    this.check(this.exports.chaincell_model_info(this.model, info));
    const view = new DataView(this.memory.buffer, info, BYTES.info);
    const whole = (word) => view.getUint32(4 * word, true);
    const real = (word) => view.getFloat32(4 * word, true);
    const checksum = whole(6).toString(16).padStart(8, "0");
    const centreM = [real(8), real(9), real(10)];
    return { cells: whole(0), links: whole(1), checksum, unitM: real(7), centreM, alpha: real(12), sweepsMax: SWEEPS_MAX };
  }

  /** Makes the tissue for the page's own scene, with memory for every tool or for so many held cells. */
  init(heldCells) {
    const scheme = this.info.alpha > 0 ? SCHEME_TRACK : SCHEME_PREDICT;
    const settings = this.take(BYTES.settings, 16);
    this.check(this.exports.chaincell_settings_default(this.model, scheme, settings));
    this.view().setUint32(settings, SWEEPS_MAX, true);
    this.make({ scheme, settings, room: heldCells ? { contacts: heldCells } : { tools: TOOLS_MAX } });
  }

  /** Makes the tissue, with settings at an address and memory for so many held cells, or tools and samples of pins. */
  make({ scheme, settings, room }) {
    const { contacts = 0, tools = 0, pins = 0 } = room;
    const roomAt = this.take(BYTES.room, 16);
    new Uint32Array(this.memory.buffer, roomAt, 6).set([contacts, tools, tools ? TRIANGLES : 0, tools ? SAMPLES : 0, this.canBeCut ? 1 : 0, pins]);
    this.check(this.exports.chaincell_model_size(this.model, scheme, roomAt, this.result, this.result + 4));
    const [bytes, align] = new Uint32Array(this.memory.buffer, this.result, 2);
    const storage = this.take(bytes, align);
    const init = this.exports.chaincell_tissue_init;
    this.check(init(storage, bytes, this.model, scheme, roomAt, settings, this.result, this.detail));
    this.tissue = new Uint32Array(this.memory.buffer, this.result, 1)[0];
  }

  /** Back to rest, with tools, each of its parts, and this friction. */
  resetWithTools(tools, friction) {
    this.check(this.exports.chaincell_tissue_reset(this.tissue, this.detail));
    // The second blade of scissors is drawn alone.
    const taken = tools.map((tool) => tool.filter(({ side }) => side !== -1));
    const parts = taken.flat();
    const words = new Float32Array(this.memory.buffer, this.parts, 11 * parts.length);
    parts.forEach((part, index) => {
      const { centreM, orientation, halfM, radiusM } = part.edge ?? part;
      words.set([...centreM, ...orientation, ...halfM, radiusM], 11 * index);
    });
    new Uint32Array(this.memory.buffer, this.counts, tools.length).set(taken.map((tool) => tool.length));
    this.check(this.exports.chaincell_choose_tools(this.tissue, this.parts, this.counts, tools.length, friction, this.detail));
  }

  /** Back to rest, with a tool that holds the cells of these input ids. */
  resetHolding(inputIds) {
    this.check(this.exports.chaincell_tissue_reset(this.tissue, this.detail));
    const ids = (this.ids ??= this.take(4 * inputIds.length, 16));
    new Uint32Array(this.memory.buffer, ids, inputIds.length).set(inputIds);
    this.check(this.exports.chaincell_choose_contacts(this.tissue, ids, inputIds.length, this.detail));
  }

  /**
   * One tick of so many sweeps with every tool engaged at its pose: in an array of seven numbers a tool, position
   * x, y, z [m], orientation x, y, z, w. `openings` are those of scissors [2^-16 turn]. Returns what each felt.
   */
  tick(poses, sweeps, openings = []) {
    const view = this.view();
    const count = poses.length / 7;
    for (let tool = 0; tool < count; tool++) {
      const start = this.poses + BYTES.pose * tool;
      for (let word = 0; word < 7; word++) view.setFloat32(start + 4 * word, poses[7 * tool + word], true);
      view.setUint32(start + 28, 1 | ((openings[tool] ?? 0) << 16), true);
    }
    view.setUint32(this.budget, sweeps, true);
    this.exports.chaincell_tick(this.tissue, this.poses, count, this.budget, this.outputs);
    return Array.from({ length: count }, (_, tool) => this.outputAt(this.outputs + BYTES.output * tool));
  }

  /** A chaincell_output. */
  outputAt(output) {
    const view = this.view();
    const real = (word) => view.getFloat32(output + 4 * word, true);
    const whole = (word) => view.getUint32(output + 4 * word, true);
    return {
      forceN: [real(0), real(1), real(2)], torqueNM: [real(3), real(4), real(5)],
      contacts: whole(6), flags: whole(7), energyJ: real(8), sweeps: whole(11), errorN: real(13),
    };
  }

  /** Returns the positions of all cells [m], x, y, z of each, in a new array. */
  positionsM() {
    const { cells, unitM, centreM } = this.info;
    this.check(this.exports.chaincell_positions(this.tissue, this.positions, cells));
    const inside = new Float32Array(this.memory.buffer, this.positions, 3 * cells);
    return inside.map((length, index) => length * unitM + centreM[index % 3]);
  }

  /** Returns the pressure on each triangle in contact: pairs of triangle and pressure [Pa]. */
  pressuresPa() {
    const count = this.result;
    this.check(this.exports.chaincell_contact_forces(this.tissue, this.contacts, TRIANGLES, count));
    const view = this.view();
    const shown = Math.min(view.getUint32(count, true), TRIANGLES);
    return Array.from({ length: shown }, (_, index) => {
      const at = this.contacts + BYTES.contact * index;
      const real = (word) => view.getFloat32(at + 4 * word, true);
      return [view.getUint32(at + 40, true), Math.hypot(real(3), real(4), real(5)) / real(9)];
    });
  }

  /** Returns the state of the cuts of a body that can be cut. */
  cuts() {
    const cuts = (this.cutsAt ??= this.take(BYTES.cuts, 16));
    this.check(this.exports.chaincell_cut(this.tissue, 0, 0, cuts, this.detail));
    const view = this.view();
    const whole = (word) => view.getUint32(cuts + 4 * word, true);
    const real = (word) => view.getFloat32(cuts + 4 * word, true);
    return { openedFaces: whole(0), copies: whole(1), waiting: whole(2), areaM2: real(4), workJ: real(5), torn: whole(7) };
  }

  /** Returns the triangles of the surface as it is now, in a new array: of each three cells, and the three of the whole body that these were made from. */
  triangles() {
    const count = this.result;
    this.trianglesRoom ??= 0;
    for (;;) {
      this.check(this.exports.chaincell_triangles(this.tissue, this.trianglesAt ?? 0, this.trianglesRoom, count));
      const found = this.view().getUint32(count, true);
      if (found <= this.trianglesRoom) return new Uint32Array(this.memory.buffer, this.trianglesAt, 6 * found).slice();
      this.trianglesRoom = 2 * found;
      this.trianglesAt = this.take(BYTES.triangle * this.trianglesRoom, 16);
    }
  }

  /** Returns the stress after von Mises at the node of an input id [Pa]. */
  stressPa(inputId) {
    const stress = (this.stress ??= this.take(BYTES.stress, 16));
    this.check(this.exports.chaincell_stress(this.tissue, inputId, stress));
    return this.view().getFloat32(stress + 36, true);
  }

  /** Returns the state hash as 16 hexadecimal digits. */
  hash() {
    this.check(this.exports.chaincell_state_hash(this.tissue, this.result));
    return this.view().getBigUint64(this.result, true).toString(16).padStart(16, "0");
  }

  view() {
    return new DataView(this.memory.buffer);
  }

  /** Takes memory behind what is in use; views made earlier are void afterwards. */
  take(bytes, align) {
    const start = Math.ceil(this.free / align) * align;
    this.free = start + bytes;
    const missing = this.free - this.memory.buffer.byteLength;
    if (missing > 0) this.memory.grow(Math.ceil(missing / PAGE_BYTES));
    return start;
  }

  /** Throws the words of a code other than 0. */
  check(code) {
    if (code === 0) return;
    const text = new Uint8Array(this.memory.buffer, this.exports.chaincell_code_text(code));
    throw new Error(new TextDecoder().decode(text.slice(0, text.indexOf(0))));
  }
}
