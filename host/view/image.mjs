// Reads from a model image what a picture needs. The kernel checks the image; layout: kernel/src/model/image.

const SECTION = { params: 1, rest: 2, rows: 3, upper: 4, fixed: 10, inputId: 11, triangles: 16, nodal: 38, contact: 45, corners: 46, cutting: 49 };

/** Unpacks gzip: a Uint8Array to a Uint8Array. */
export async function inflate(bytes) {
  const unpacked = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(unpacked).arrayBuffer());
}

/** Decodes base64 to bytes. */
export function fromBase64(text) {
  if (Uint8Array.fromBase64) return Uint8Array.fromBase64(text);
  const letters = atob(text);
  const bytes = new Uint8Array(letters.length);
  for (let index = 0; index < letters.length; index++) bytes[index] = letters.charCodeAt(index);
  return bytes;
}

/** Returns the sections of an image by kind, each a copy of its bytes. */
function sectionsOf(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const sections = new Map();
  const count = view.getUint32(16, true);
  for (let entry = 0; entry < count; entry++) {
    const place = 32 + 16 * entry;
    const start = view.getUint32(place + 8, true);
    sections.set(view.getUint32(place, true), bytes.slice(start, start + view.getUint32(place + 12, true)));
  }
  return sections;
}

/**
 * Returns the body of an image: rest positions in mean link lengths from its centre, and as indices of cells
 * the corners of its surface triangles, the ends of its links, its fixed cells; input ids by cell; the mean link
 * length and the centre [m]; whether it can be cut, and the number of its spare cells, which are the last.
 */
export function bodyOf(bytes) {
  const sections = sectionsOf(bytes);
  const array = (kind, Type) => new Type((sections.get(kind) ?? new Uint8Array(0)).buffer);
  const rows = array(SECTION.rows, Uint32Array);
  const upper = array(SECTION.upper, Uint16Array);
  const links = new Uint32Array(2 * upper.length);
  for (let cell = 0; cell + 1 < rows.length; cell++) {
    for (let link = rows[cell]; link < rows[cell + 1]; link++) links.set([cell, upper[link]], 2 * link);
  }
  const params = array(SECTION.params, Float32Array);
  return {
    unitM: params[3],
    centreM: [...params.slice(4, 7)],
    rest: array(SECTION.rest, Float32Array),
    triangles: Uint32Array.from(array(SECTION.triangles, Uint16Array)),
    links,
    fixed: Uint32Array.from(array(SECTION.fixed, Uint16Array)),
    inputIds: array(SECTION.inputId, Uint32Array),
    hasShapes: sections.has(SECTION.nodal),
    hasContactSurface: sections.has(SECTION.contact),
    canBeCut: sections.has(SECTION.corners),
    spareCells: array(SECTION.cutting, Uint32Array)[1] ?? 0,
  };
}
