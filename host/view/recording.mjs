// A recorded session: its words, and where its events stand in them. host/src/view/session.rs describes the layout.

const MAGIC = 0x53455343;
const VERSION = 2;
const HEAD_WORDS = 19;
const PART_WORDS = 11;
const POSE_WORDS = 8;
const SETTINGS_WORDS = 8;
export const EVENT = { tick: 1, still: 2, settings: 3, reset: 4, grip: 5, letGo: 6, pin: 7, pinAt: 8, unpin: 9 };
const HAS_HASH = 1 << 8;
const HAS_SWEEPS = 1 << 9;

export class Recording {
  /** Reads a session's bytes; throws an Error where they are none. */
  constructor(bytes) {
    const words = (this.words = new Uint32Array(bytes.buffer, bytes.byteOffset, bytes.byteLength >> 2));
    if (words[0] !== MAGIC || words[1] !== VERSION) throw new Error("this is no recorded session of this page's version");
    const reals = new Float32Array(words.buffer, words.byteOffset, words.length);
    const [tools, parts, held, snapshotBytes] = words.subarray(12, 16);
    this.scheme = words[2];
    this.settings = words.subarray(3, 11);
    this.friction = reals[11];
    this.tools = tools;
    this.first = words[16] + words[17] * 2 ** 32;
    this.last = this.first + words[18];
    let at = HEAD_WORDS;
    const take = (count, of = words) => of.subarray(at, (at += count));
    this.counts = take(tools);
    this.parts = take(PART_WORDS * parts, reals);
    this.held = take(held);
    this.snapshot = bytes.subarray(4 * at, 4 * at + snapshotBytes);
    at += (snapshotBytes + 3) >> 2;
    this.kinds = this.#kinds();
    this.#index(at);
  }

  /** The tools in the words of --tool. */
  #kinds() {
    let first = 0;
    return Array.from(this.counts, (count) => {
      const texts = Array.from({ length: count }, () => kindOf(this.parts.subarray(PART_WORDS * first, PART_WORDS * ++first)));
      return texts.join("+");
    });
  }

  /** Finds the events: the words where each begins, and for ticks which one it is. */
  #index(at) {
    this.events = [];
    this.numbers = [];
    const poses = POSE_WORDS * Math.max(this.tools, 1);
    while (at < this.words.length) {
      const head = this.words[at];
      const kind = head & 0xff;
      const hash = head & HAS_HASH ? 2 : 0;
      const lengths = [0, 2 + poses + hash, 2, 1 + SETTINGS_WORDS, 1, 2, 3, 3, 6, 3];
      if (!(kind in lengths) || kind === 0) throw new Error(`the session has an event of the unknown kind ${kind}`);
      this.events.push(at);
      this.numbers.push(kind <= EVENT.still ? this.first + this.words[at + 1] : null);
      at += lengths[kind];
    }
  }

  /** What stands at an event. */
  at(index) {
    const at = this.events[index];
    const head = this.words[at];
    const event = { kind: head & 0xff, tick: this.numbers[index], words: this.words.subarray(at + 1, this.events[index + 1]) };
    if (event.kind !== EVENT.tick) return event;
    const poses = POSE_WORDS * Math.max(this.tools, 1);
    event.poses = event.words.subarray(1, 1 + poses);
    event.sweeps = head & HAS_SWEEPS ? head >>> 16 : null;
    if (head & HAS_HASH) {
      const [low, high] = event.words.subarray(1 + poses);
      event.hash = ((BigInt(high) << 32n) | BigInt(low)).toString(16).padStart(16, "0");
    }
    return event;
  }
}

/** A part in the words of --tool. */
function kindOf(part) {
  const [x, y, z, i, j, k, w, a, b, c, radiusM] = part;
  const place = x || y || z ? `@${x},${y},${z}` : "";
  const turn = w === 1 ? "" : `/${i},${j},${k},${w}`;
  if (radiusM < 0) return `scissors:${c},${-radiusM}${place}${turn}`;
  if (radiusM === 0) return `blade:${2 * a}${place}${turn}`;
  if (!Number.isFinite(c)) return `half-space:${radiusM}${place}${turn}`;
  if (a || b) return `box:${a},${b},${c},${radiusM}${place}${turn}`;
  return c ? `capsule:${c},${radiusM}${place}${turn}` : `sphere:${radiusM}${place}${turn}`;
}
