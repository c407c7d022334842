// A recorded session played by the kernel, to any tick: forwards by its ticks, backwards from a snapshot.
import { BYTES, PINNED, Tissue } from "./kernel.mjs";
import { EVENT } from "./recording.mjs";

/** Ticks between two snapshots at first, and the memory that all may take; beyond it every other one goes. */
const SNAPSHOT_TICKS = 250;
const SNAPSHOT_BYTES = 64e6;
/** Numbers of pins that are looked at where a session begins from a snapshot. */
const PINS = 64;

export class Player extends Tissue {
  /** A tissue where a session starts. */
  constructor(instance, image, canBeCut, recording) {
    super(instance, image, canBeCut);
    /** Number of restores and resets: after one the cuts may be others. */
    this.restores = 0;
    /** Above the numbers of all pins so far; those of a snapshot that a session begins from are not known. */
    this.pinned = recording.snapshot.length && recording.tools ? PINS : 0;
    this.recording = recording;
    const tools = recording.tools;
    this.words = this.take(BYTES.settings, 16);
    this.lists = this.take(4 * Math.max(recording.parts.length, recording.held.length, 1), 16);
    const room = tools ? { tools, pins: PINNED } : { contacts: recording.held.length };
    this.#put(this.words, recording.settings);
    this.make({ scheme: recording.scheme, settings: this.words, room });
    this.choose();
    if (recording.snapshot.length) this.restore(recording.snapshot);
    this.event = 0;
    this.tick = recording.first - 1;
    this.settings = recording.settings;
    this.out = null;
    this.snapshots = [];
    this.apart = SNAPSHOT_TICKS;
    this.compared = new Set();
    this.differs = null;
    this.keep();
  }

  #put(at, words) {
    new Uint32Array(this.memory.buffer, at, words.length).set(words);
  }

  /** Gives the tissue at rest its tools or held cells. */
  choose() {
    const { tools, counts, parts, held, friction } = this.recording;
    if (tools) {
      new Float32Array(this.memory.buffer, this.lists, parts.length).set(parts);
      this.#put(this.counts, counts);
      this.check(this.exports.chaincell_choose_tools(this.tissue, this.lists, this.counts, tools, friction, this.detail));
    } else {
      this.#put(this.lists, held);
      this.check(this.exports.chaincell_choose_contacts(this.tissue, this.lists, held.length, this.detail));
    }
  }

  get isAtEnd() {
    return this.event >= this.recording.events.length;
  }

  /** Plays up to the end of the next tick. Returns false at the end. */
  next() {
    while (!this.isAtEnd) {
      const event = this.recording.at(this.event++);
      this.#play(event);
      if (event.tick === null) continue;
      this.tick = event.tick;
      if (this.tick - this.snapshots[this.snapshots.length - 1].tick >= this.apart) this.keep();
      return true;
    }
    return false;
  }

  #play(event) {
    const { exports, tissue, detail } = this;
    const [first, second] = event.words;
    if (event.kind === EVENT.tick) this.#tick(event);
    else if (event.kind === EVENT.settings) this.change(event.words);
    else if (event.kind === EVENT.grip) this.check(exports.chaincell_grip(tissue, first, 0));
    else if (event.kind === EVENT.letGo) this.check(exports.chaincell_let_go(tissue, first, second));
    else if (event.kind >= EVENT.pin) this.#pin(event);
    else if (event.kind === EVENT.reset) {
      this.check(exports.chaincell_tissue_reset(tissue, detail));
      this.restores += 1;
      this.choose();
    }
  }

  /** Sets or releases a pin. */
  #pin({ kind, words }) {
    const { exports, tissue, result, detail } = this;
    const reals = new Float32Array(words.slice().buffer);
    if (kind === EVENT.unpin) this.check(exports.chaincell_unpin(tissue, words[0], words[1]));
    else if (kind === EVENT.pin) this.check(exports.chaincell_pin_held(tissue, words[0], reals[1], result, detail));
    else {
      this.pointAt ??= this.take(12, 16);
      new Float32Array(this.memory.buffer, this.pointAt, 3).set(reals.subarray(0, 3));
      this.check(exports.chaincell_pin_at(tissue, this.pointAt, reals[3], reals[4], result, detail));
    }
    this.pinned = Math.max(this.pinned, kind === EVENT.unpin ? 0 : this.view().getUint32(result, true) + 1);
  }

  /** The pins: where each is in the tissue, and the force on it. */
  pins() {
    const pin = (this.pinAt ??= this.take(BYTES.pin, 16));
    return Array.from({ length: this.pinned }, (_, number) => number).flatMap((number) => {
      if (this.exports.chaincell_pin_force(this.tissue, number, pin) !== 0) return [];
      const reals = new Float32Array(this.memory.buffer, pin, 9);
      return [{ positionM: [3, 4, 5].map((place) => reals[place] + reals[place + 3]), forceN: [...reals.subarray(0, 3)] }];
    });
  }

  #tick({ tick, poses, sweeps, hash }) {
    this.#put(this.poses, poses);
    if (sweeps !== null) this.view().setUint32(this.budget, sweeps, true);
    const count = Math.max(this.recording.tools, 1);
    this.exports.chaincell_tick(this.tissue, this.poses, count, sweeps === null ? 0 : this.budget, this.outputs);
    if (!hash) return;
    const here = this.hash();
    if (here !== hash) this.differs ??= { tick, recorded: hash, here };
    this.compared.add(tick);
  }

  change(settings) {
    this.settings = settings;
    this.#put(this.words, settings);
    this.check(this.exports.chaincell_change_settings(this.tissue, this.words, this.detail));
  }

  /** Keeps a snapshot of now. */
  keep() {
    const last = this.snapshots[this.snapshots.length - 1];
    if (last && last.event >= this.event) return;
    const { tick, event, settings } = this;
    this.snapshots.push({ tick, event, settings, bytes: this.save() });
    const held = this.snapshots.reduce((sum, { bytes }) => sum + bytes.length, 0);
    if (held < SNAPSHOT_BYTES) return;
    this.snapshots = this.snapshots.filter((_, index) => index % 2 === 0);
    this.apart *= 2;
  }

  /** Goes to the last snapshot before a tick, if the tick is in the past or the snapshot ahead of now. */
  rewind(tick) {
    const before = this.snapshots.filter((snapshot) => snapshot.tick < tick);
    const snapshot = before[before.length - 1] ?? this.snapshots[0];
    if (tick > this.tick && snapshot.tick <= this.tick) return false;
    this.change(snapshot.settings);
    this.restore(snapshot.bytes);
    [this.tick, this.event] = [snapshot.tick, snapshot.event];
    return true;
  }

  save() {
    const { exports, tissue, result, detail } = this;
    this.check(exports.chaincell_tissue_save(tissue, 0, 0, result, detail));
    const bytes = this.view().getUint32(result, true);
    const at = this.#copyRoom(bytes);
    this.check(exports.chaincell_tissue_save(tissue, at, bytes, result, detail));
    return new Uint8Array(this.memory.buffer, at, bytes).slice();
  }

  restore(bytes) {
    const at = this.#copyRoom(bytes.length);
    new Uint8Array(this.memory.buffer, at, bytes.length).set(bytes);
    this.check(this.exports.chaincell_tissue_restore(this.tissue, at, bytes.length, this.detail));
    this.restores += 1;
  }

  /** Memory through which snapshots go. */
  #copyRoom(bytes) {
    if (!(this.copyBytes >= bytes)) {
      this.copyBytes = 2 * bytes;
      this.copyAt = this.take(this.copyBytes, 16);
    }
    return this.copyAt;
  }

  /** The tools with what each felt in the last tick; held cells as a ball in their middle. */
  tools() {
    const { tools, kinds, parts } = this.recording;
    const poses = new Float32Array(this.memory.buffer, this.poses, 8 * Math.max(tools, 1));
    const held = tools ? null : this.#middleOfHeld();
    const radiusM = 0.4 * this.info.unitM;
    let part = 0;
    return Array.from({ length: Math.max(tools, 1) }, (_, index) => {
      const output = this.outputAt(this.outputs + BYTES.output * index);
      const pose = poses.subarray(8 * index, 8 * index + 8);
      const shape = tools ? { kind: kinds[index], radiusM: parts[11 * part + 10] } : { kind: `sphere:${radiusM}`, radiusM };
      part += this.recording.counts[index] ?? 0;
      const [engaged, openingTurnsQ16] = new Uint16Array(poses.buffer, poses.byteOffset + 32 * index + 28, 2);
      return {
        ...shape, positionM: held ?? [...pose.slice(0, 3)], orientation: held ? [0, 0, 0, 1] : [...pose.slice(3, 7)], engaged: engaged === 1,
        openingRad: (openingTurnsQ16 / 65536) * 2 * Math.PI,
        forceN: output.forceN, torqueNM: output.torqueNM, contacts: output.contacts, flags: output.flags, errorN: output.errorN,
      };
    });
  }

  #middleOfHeld() {
    const { held } = this.recording;
    const sum = [0, 0, 0];
    for (const id of held) {
      this.check(this.exports.chaincell_position(this.tissue, id, this.positions));
      new Float32Array(this.memory.buffer, this.positions, 3).forEach((length, axis) => (sum[axis] += length / held.length));
    }
    return sum;
  }
}
