// What is drawn with WebGL2: the body's curved triangles, solid shapes, lines and points.

const BODY_VERTEX = `
in vec3 share;
in vec3 placeA, placeB, placeC, normalA, normalB, normalC, numbers, curved;
uniform mat4 camera;
out vec3 normal, place;
out float number;
vec3 onPlane(vec3 p, vec3 corner, vec3 n, float is) { return p - is * dot(p - corner, n) * n; }
void main() {
  vec3 flatPlace = share.x * placeA + share.y * placeB + share.z * placeC;
  vec3 curvedPlace = share.x * onPlane(flatPlace, placeA, normalA, curved.x)
    + share.y * onPlane(flatPlace, placeB, normalB, curved.y) + share.z * onPlane(flatPlace, placeC, normalC, curved.z);
  place = mix(flatPlace, curvedPlace, 0.75);
  normal = share.x * normalA + share.y * normalB + share.z * normalC;
  number = dot(share, numbers);
  gl_Position = camera * vec4(place, 1.0);
}`;

const BODY_FRAGMENT = `
in vec3 normal, place;
in float number;
uniform vec3 eye, right, up, ramp[6];
uniform vec2 range;
uniform vec4 shade, tint;
out vec4 colour;
void main() {
  vec3 towards = normalize(eye - place);
  vec3 n = normalize(normal);
  n = dot(n, towards) < 0.0 ? -n : n;
  float t = clamp((number - range.x) / (range.y - range.x), 0.0, 1.0) * 5.0;
  int low = min(int(t), 4);
  vec3 base = mix(ramp[low], ramp[low + 1], t - float(low));
  vec3 key = normalize(towards + 0.55 * up - 0.5 * right);
  float light = 0.42 + 0.2 * n.z + 0.5 * max(dot(n, key), 0.0);
  float gloss = 0.16 * pow(max(dot(n, normalize(key + towards)), 0.0), 36.0);
  float rim = 0.14 * pow(1.0 - max(dot(n, towards), 0.0), 3.0);
  float near = shade.w > 0.0 ? 0.35 * (1.0 - smoothstep(shade.w, 2.1 * shade.w, distance(place, shade.xyz))) : 0.0;
  vec3 lit = base * light * (1.0 - near) + gloss + rim;
  colour = vec4(mix(lit, tint.rgb, tint.a), 1.0);
}`;

const SOLID_VERTEX = `
in vec3 point, direction;
uniform mat4 camera, model;
out vec3 normal, place;
void main() {
  vec4 world = model * vec4(point, 1.0);
  place = world.xyz;
  normal = mat3(model) * direction;
  gl_Position = camera * world;
}`;

const SOLID_FRAGMENT = `
in vec3 normal, place;
uniform vec3 eye, up, right;
uniform vec4 paint;
out vec4 colour;
void main() {
  vec3 towards = normalize(eye - place);
  vec3 n = normalize(normal);
  n = dot(n, towards) < 0.0 ? -n : n;
  vec3 key = normalize(towards + 0.55 * up - 0.5 * right);
  float light = 0.5 + 0.15 * n.z + 0.45 * max(dot(n, key), 0.0);
  float gloss = 0.4 * pow(max(dot(n, normalize(key + towards)), 0.0), 60.0);
  float alpha = paint.a < 1.0 ? paint.a * (0.5 + pow(1.0 - max(dot(n, towards), 0.0), 2.0)) : 1.0;
  colour = vec4((paint.rgb * light + gloss) * alpha, alpha);
}`;

const LINE_VERTEX = `
in vec3 point;
uniform mat4 camera;
uniform float pixels;
void main() {
  gl_Position = camera * vec4(point, 1.0);
  gl_Position.z -= 0.0006 * gl_Position.w;
  gl_PointSize = pixels;
}`;

const LINE_FRAGMENT = `
uniform vec4 paint;
uniform float pixels;
out vec4 colour;
void main() {
  if (pixels > 0.0 && length(gl_PointCoord - 0.5) > 0.5) discard;
  colour = vec4(paint.rgb * paint.a, paint.a);
}`;

/** Subdivisions of an edge of the body's triangles. */
const PIECES = 4;

export class Painter {
  constructor(canvas) {
    const gl = (this.gl = canvas.getContext("webgl2", { antialias: true, alpha: true }));
    if (!gl) throw new Error("this browser has no WebGL 2: switch hardware acceleration on, or take a newer browser");
    this.body = this.#program(BODY_VERTEX, BODY_FRAGMENT);
    this.solid = this.#program(SOLID_VERTEX, SOLID_FRAGMENT);
    this.line = this.#program(LINE_VERTEX, LINE_FRAGMENT);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
    this.patch = this.#patch();
  }

  #program(vertex, fragment) {
    const gl = this.gl;
    const program = gl.createProgram();
    for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(type);
      gl.shaderSource(shader, `#version 300 es\nprecision highp float;${text}`);
      gl.compileShader(shader);
      gl.attachShader(program, shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    }
    gl.linkProgram(program);
    const uniform = new Map();
    return {
      use: () => gl.useProgram(program),
      attribute: (name) => gl.getAttribLocation(program, name),
      uniform(name) {
        if (!uniform.has(name)) uniform.set(name, gl.getUniformLocation(program, name));
        return uniform.get(name);
      },
    };
  }

  /** A triangle in pieces, by the shares of its corners. */
  #patch() {
    const [shares, corners] = [[], []];
    const index = (i, j) => (i * (2 * PIECES + 3 - i)) / 2 + j;
    for (let i = 0; i <= PIECES; i++) {
      for (let j = 0; i + j <= PIECES; j++) {
        shares.push(1 - (i + j) / PIECES, i / PIECES, j / PIECES);
        if (i + j < PIECES) corners.push(index(i, j), index(i + 1, j), index(i, j + 1));
        if (i + j < PIECES - 1) corners.push(index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
      }
    }
    return { shares: this.#buffer(new Float32Array(shares)), corners: new Uint16Array(corners) };
  }

  #buffer(data) {
    const gl = this.gl;
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
    return buffer;
  }

  #attach(location, size, stride, offset) {
    const gl = this.gl;
    gl.enableVertexAttribArray(location);
    gl.vertexAttribPointer(location, size, gl.FLOAT, false, stride, offset);
  }

  #indices(corners) {
    const gl = this.gl;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
  }

  /** Makes the mesh of a body with so many triangles: what is drawn of `fill`'s numbers of each triangle. */
  bodyMesh(triangles) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.patch.shares);
    this.#attach(this.body.attribute("share"), 3, 0, 0);
    this.#indices(this.patch.corners);
    const numbers = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, numbers);
    gl.bufferData(gl.ARRAY_BUFFER, 96 * triangles, gl.DYNAMIC_DRAW);
    ["placeA", "placeB", "placeC", "normalA", "normalB", "normalC", "numbers", "curved"].forEach((name, index) => {
      const location = this.body.attribute(name);
      this.#attach(location, 3, 96, 12 * index);
      gl.vertexAttribDivisor(location, 1);
    });
    return {
      fill(corners) {
        gl.bindBuffer(gl.ARRAY_BUFFER, numbers);
        gl.bufferSubData(gl.ARRAY_BUFFER, 0, corners);
      },
      draw: () => {
        gl.bindVertexArray(array);
        gl.drawElementsInstanced(gl.TRIANGLES, this.patch.corners.length, gl.UNSIGNED_SHORT, 0, triangles);
      },
    };
  }

  /** Makes a mesh of a shape that only moves. */
  solidMesh({ points, normals, corners }) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    for (const [name, data] of [["point", points], ["direction", normals]]) {
      this.#buffer(new Float32Array(data));
      this.#attach(this.solid.attribute(name), 3, 0, 0);
    }
    this.#indices(new Uint16Array(corners));
    return {
      draw() {
        gl.bindVertexArray(array);
        gl.drawElements(gl.TRIANGLES, corners.length, gl.UNSIGNED_SHORT, 0);
      },
    };
  }

  /** Makes lines and points between cells: lists of indices over one set of places. */
  network(cells, lists) {
    const gl = this.gl;
    const places = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, places);
    gl.bufferData(gl.ARRAY_BUFFER, 12 * cells, gl.DYNAMIC_DRAW);
    const arrays = Object.fromEntries(Object.entries(lists).map(([name, indices]) => {
      const array = gl.createVertexArray();
      gl.bindVertexArray(array);
      gl.bindBuffer(gl.ARRAY_BUFFER, places);
      this.#attach(this.line.attribute("point"), 3, 0, 0);
      this.#indices(indices);
      return [name, { array, count: indices.length }];
    }));
    return {
      fill(positionsM) {
        gl.bindBuffer(gl.ARRAY_BUFFER, places);
        gl.bufferSubData(gl.ARRAY_BUFFER, 0, positionsM);
      },
      draw(name, isPoints) {
        gl.bindVertexArray(arrays[name].array);
        gl.drawElements(isPoints ? gl.POINTS : gl.LINES, arrays[name].count, gl.UNSIGNED_INT, 0);
      },
    };
  }
}
