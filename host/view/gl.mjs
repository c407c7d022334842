// What is drawn with WebGL2: the body, solid shapes, lines and points.

const BODY_VERTEX = `
in vec3 point, direction;
in float value;
uniform mat4 camera;
out vec3 normal, place;
out float number;
void main() {
  place = point;
  normal = direction;
  number = value;
  gl_Position = camera * vec4(point, 1.0);
}`;

/** Of a ramp of so many colours. */
const bodyFragment = (colours) => `
in vec3 normal, place;
in float number;
uniform vec3 eye, right, up, ramp[${colours}];
uniform vec2 range;
uniform vec4 shade;
out vec4 colour;
void main() {
  vec3 towards = normalize(eye - place);
  vec3 n = normalize(normal);
  n = dot(n, towards) < 0.0 ? -n : n;
  float t = clamp((number - range.x) / (range.y - range.x), 0.0, 1.0) * float(${colours - 1});
  int low = min(int(t), ${colours - 2});
  vec3 base = mix(ramp[low], ramp[low + 1], t - float(low));
  vec3 key = normalize(towards + 0.55 * up - 0.5 * right);
  float light = 0.46 + 0.16 * n.z + 0.4 * max(dot(n, key), 0.0);
  float gloss = 0.13 * pow(max(dot(n, normalize(key + towards)), 0.0), 36.0);
  float rim = 0.14 * pow(1.0 - max(dot(n, towards), 0.0), 3.0);
  float near = shade.w > 0.0 ? 0.35 * (1.0 - smoothstep(shade.w, 2.1 * shade.w, distance(place, shade.xyz))) : 0.0;
  colour = vec4(base * light * (1.0 - near) + gloss + rim, 1.0);
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

export class Painter {
  /** `colours` is the number of colours of the body's ramp. */
  constructor(canvas, colours) {
    // Smooth edges cost a processor too much that draws by itself.
    const gl = (this.gl =
      canvas.getContext("webgl2", { antialias: true, failIfMajorPerformanceCaveat: true }) ??
      canvas.getContext("webgl2", { antialias: false }));
    if (!gl) throw new Error("this browser has no WebGL 2: switch hardware acceleration on, or take a newer browser");
    this.body = this.#program(BODY_VERTEX, bodyFragment(colours));
    this.solid = this.#program(SOLID_VERTEX, SOLID_FRAGMENT);
    this.line = this.#program(LINE_VERTEX, LINE_FRAGMENT);
    gl.enable(gl.DEPTH_TEST);
    gl.blendFunc(gl.ONE, gl.ONE_MINUS_SRC_ALPHA);
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
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, corners, gl.STATIC_DRAW);
    return buffer;
  }

  /** Makes the mesh of a body: points of position, normal and number, which `fill` renews. */
  bodyMesh(points, corners) {
    const gl = this.gl;
    const array = gl.createVertexArray();
    gl.bindVertexArray(array);
    const buffer = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.bufferData(gl.ARRAY_BUFFER, points.byteLength, gl.DYNAMIC_DRAW);
    this.#attach(this.body.attribute("point"), 3, 28, 0);
    this.#attach(this.body.attribute("direction"), 3, 28, 12);
    this.#attach(this.body.attribute("value"), 1, 28, 24);
    const ends = this.#indices(corners);
    return {
      free() {
        gl.deleteVertexArray(array);
        for (const one of [buffer, ends]) gl.deleteBuffer(one);
      },
      fill() {
        gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
        gl.bufferSubData(gl.ARRAY_BUFFER, 0, points);
      },
      draw() {
        gl.bindVertexArray(array);
        gl.drawElements(gl.TRIANGLES, corners.length, gl.UNSIGNED_INT, 0);
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
      const ends = this.#indices(indices);
      return [name, { array, ends, count: indices.length }];
    }));
    return {
      free() {
        gl.deleteBuffer(places);
        for (const { array, ends } of Object.values(arrays)) {
          gl.deleteVertexArray(array);
          gl.deleteBuffer(ends);
        }
      },
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
