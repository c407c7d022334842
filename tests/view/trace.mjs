// Changes a recorded trace (kernel/src/trace/mod.rs describes the layout) so that a test has what a short run has not.

const RECORD_BYTES = 48;
const AT = { headerBytes: 12, headerSum: 60, hash: 24, kind: 32, flags: 34, sum: 44 };
const KIND = { tick: 1, command: 2 };
const HAS_HASH = 1;

const TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; bit++) byte = byte & 1 ? 0xedb88320 ^ (byte >>> 1) : byte >>> 1;
  return byte;
});

/** CRC-32 (ISO-HDLC). */
function crc32(bytes) {
  return ~bytes.reduce((sum, byte) => TABLE[(sum ^ byte) & 0xff] ^ (sum >>> 8), -1) >>> 0;
}

/** Returns the hash of a tick as 16 hexadecimal digits. */
export function hashOf(trace, tick) {
  for (let at = trace.readUInt32LE(AT.headerBytes); at < trace.length; at += RECORD_BYTES) {
    if (trace.readUInt16LE(at + AT.kind) !== KIND.tick || trace.readBigUInt64LE(at) !== BigInt(tick)) continue;
    return trace.readBigUInt64LE(at + AT.hash).toString(16).padStart(16, "0");
  }
  throw new Error(`the trace has no tick ${tick}`);
}

/** Commands: other sweeps, and the body at rest. */
export const sweepsOf = (sweeps) => ({ kind: 4, parameter: 1, value: sweeps });
export const RESET = { kind: 1, parameter: 0, value: 0 };

/** Returns the trace with a command after a tick. What was recorded after it has no hashes: its states are others. */
export function withCommand(trace, tick, { kind, parameter, value }) {
  const start = trace.readUInt32LE(AT.headerBytes);
  const records = [];
  let isChanged = false;
  for (let at = start; at < trace.length; at += RECORD_BYTES) {
    const record = Buffer.from(trace.subarray(at, at + RECORD_BYTES));
    const isTick = record.readUInt16LE(AT.kind) === KIND.tick;
    if (isTick && isChanged) {
      record.fill(0, AT.hash, AT.hash + 8);
      record.writeUInt16LE(record.readUInt16LE(AT.flags) & ~HAS_HASH, AT.flags);
    }
    records.push(record);
    if (!isTick || record.readBigUInt64LE(0) !== BigInt(tick)) continue;
    const command = Buffer.alloc(RECORD_BYTES);
    command.writeBigUInt64LE(BigInt(tick), 0);
    command.writeUInt32LE(kind, 8);
    command.writeUInt32LE(parameter, 12);
    command.writeFloatLE(value, 16);
    command.writeUInt16LE(KIND.command, AT.kind);
    records.push(command);
    isChanged = true;
  }
  records.forEach((record, index) => {
    const summed = Buffer.alloc(8 + AT.sum);
    summed.writeUInt32LE(trace.readUInt32LE(AT.headerSum), 0);
    summed.writeUInt32LE(index, 4);
    record.copy(summed, 8, 0, AT.sum);
    record.writeUInt32LE(crc32(summed), AT.sum);
  });
  return Buffer.concat([trace.subarray(0, start), ...records]);
}
