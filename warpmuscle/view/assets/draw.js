// Many unit primitives with WebGL 2: lit, with flat shadows on the ground.

// A vertex looks up its corner and its instance in textures, so that a batch is one plain draw: where there is no
// graphics card, every instance of an instanced one costs as much as some hundred triangles.
const STRIDE = 16; // numbers an instance, four a texel: position and quaternion's x; y, z, w; size; color
const ROW = 1024; // texels
const BACKGROUND = [0.914, 0.933, 0.953];

const SOLID_VERTEX = `#version 300 es
precision highp sampler2D;
uniform sampler2D mesh; uniform sampler2D instances; uniform int vertices;
uniform mat4 matrix; uniform vec3 light; uniform vec4 ground; uniform float shadow;
out vec3 at; out vec3 normal; out vec4 tint;
vec4 texel(sampler2D table, int k) { return texelFetch(table, ivec2(k % ${ROW}, k / ${ROW}), 0); }
vec3 turned(vec4 turn, vec3 v) { return v + 2.0 * cross(turn.xyz, cross(turn.xyz, v) + turn.w * v); }
void main() {
  int vertex = 2 * (gl_VertexID % vertices), instance = 4 * (gl_VertexID / vertices);
  vec3 corner = texel(mesh, vertex).xyz, outward = texel(mesh, vertex + 1).xyz;
  vec4 place = texel(instances, instance), turn = vec4(place.w, texel(instances, instance + 1).xyz);
  vec3 size = texel(instances, instance + 2).xyz;
  at = place.xyz + turned(turn, corner * size);
  normal = turned(turn, outward / max(size, vec3(1e-6)));
  tint = texel(instances, instance + 3);
  if (shadow > 0.5) at -= light * (dot(at, ground.xyz) - ground.w - 0.002) / dot(light, ground.xyz);
  gl_Position = matrix * vec4(at, 1.0);
}`;
const SOLID_FRAGMENT = `#version 300 es
precision highp float;
in vec3 at; in vec3 normal; in vec4 tint; uniform vec3 light; uniform vec3 eye; uniform float shadow; out vec4 color;
void main() {
  if (shadow > 0.5) { color = vec4(0.10, 0.13, 0.18, 0.22); return; }
  vec3 n = normalize(normal), v = normalize(eye - at);
  float day = max(dot(n, light), 0.0), sky = 0.5 + 0.5 * n.y;
  float shine = pow(max(dot(n, normalize(light + v)), 0.0), 40.0);
  vec3 lit = tint.rgb * (0.34 + 0.26 * sky + 0.52 * day) + vec3(0.14 * shine);
  color = vec4(lit, tint.a);
}`;
const GROUND_VERTEX = `#version 300 es
uniform mat4 matrix; uniform vec4 ground; uniform vec3 middle; out vec2 place;
out float far;
void main() {
  vec3 corner = vec3(gl_VertexID % 2 * 2 - 1, 0, gl_VertexID / 2 * 2 - 1); // of a strip of two triangles
  vec2 p = corner.xz * 80.0 + floor(middle.xz);
  vec3 n = ground.xyz;
  vec3 at = vec3(p.x, (ground.w - n.x * p.x - n.z * p.y) / n.y, p.y);
  place = p; far = length(corner.xz);
  gl_Position = matrix * vec4(at, 1.0);
}`;
const GROUND_FRAGMENT = `#version 300 es
precision highp float;
in vec2 place; in float far; uniform vec3 background; uniform vec3 middle; out vec4 color;
void main() {
  vec2 width = max(fwidth(place), vec2(1e-4));
  vec2 wave = clamp((abs(fract(place * 0.5) - 0.5) - 0.25) * 2.0 / width, -1.0, 1.0);
  float check = 0.5 + 0.5 * wave.x * wave.y;
  vec2 line = abs(fract(place / 5.0 + 0.5) - 0.5) * 5.0;
  float bold = 1.0 - smoothstep(0.0, 1.0, min(line.x / width.x, line.y / width.y) - 0.5);
  vec3 tone = mix(vec3(0.80, 0.83, 0.86), vec3(0.87, 0.895, 0.92), check) - 0.10 * bold;
  float fade = smoothstep(8.0, 34.0, length(place - middle.xz));
  color = vec4(mix(tone, background, fade), 1.0);
}`;

function sphereMesh(rings, sectors) {
  const corners = [], faces = [];
  for (let i = 0; i <= rings; i++)
    for (let j = 0; j <= sectors; j++) {
      const a = (Math.PI * i) / rings, b = (2 * Math.PI * j) / sectors;
      const p = [Math.sin(a) * Math.cos(b), Math.cos(a), Math.sin(a) * Math.sin(b)];
      corners.push(...p, ...p);
      const k = i * (sectors + 1) + j;
      if (i < rings && j < sectors) faces.push(k, k + 1, k + sectors + 1, k + 1, k + sectors + 2, k + sectors + 1);
    }
  return { corners, faces };
}

// Of length 1 about the middle; the radius at the upper end is 1 for a cylinder and 0 for a cone.
function tubeMesh(sectors, upper) {
  const corners = [], faces = [];
  for (let j = 0; j <= sectors; j++) {
    const b = (2 * Math.PI * j) / sectors, x = Math.cos(b), z = Math.sin(b), slope = 1 - upper;
    corners.push(x, -0.5, z, x, slope, z, x * upper, 0.5, z * upper, x, slope, z);
    if (j < sectors) faces.push(2 * j, 2 * j + 1, 2 * j + 2, 2 * j + 1, 2 * j + 3, 2 * j + 2);
  }
  return { corners, faces };
}

function boxMesh() {
  const corners = [], faces = [];
  for (let axis = 0; axis < 3; axis++)
    for (const sign of [-1, 1]) {
      const first = corners.length / 6;
      for (const [s, t] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const p = [0, 0, 0], n = [0, 0, 0];
        p[axis] = sign / 2;
        p[(axis + 1) % 3] = s / 2;
        p[(axis + 2) % 3] = t / 2;
        n[axis] = sign;
        corners.push(...p, ...n);
      }
      faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  return { corners, faces };
}

function makeProgram(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const place = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); i++) {
    const name = gl.getActiveUniform(program, i).name;
    place[name] = gl.getUniformLocation(program, name);
  }
  return { program, place };
}

// A texture of four numbers a texel, and its size; never filtered.
function makeTable(gl) {
  const table = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, table);
  for (const name of ["TEXTURE_MIN_FILTER", "TEXTURE_MAG_FILTER"]) gl.texParameteri(gl.TEXTURE_2D, gl[name], gl.NEAREST);
  return table;
}

function fillTable(gl, table, numbers) {
  gl.bindTexture(gl.TEXTURE_2D, table);
  gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA32F, ROW, numbers.length / (4 * ROW), 0, gl.RGBA, gl.FLOAT, numbers);
}

// Instances of one primitive, filled anew for every picture.
class Batch {
  constructor(gl, { corners, faces }) {
    this.gl = gl;
    this.data = new Float32Array(4 * ROW);
    this.rows = 0; // of the table on the device
    this.count = 0;
    this.vertices = faces.length;
    const numbers = new Float32Array(4 * ROW * Math.ceil((2 * faces.length) / ROW));
    faces.forEach((corner, k) => {
      numbers.set(corners.slice(6 * corner, 6 * corner + 3), 8 * k);
      numbers.set(corners.slice(6 * corner + 3, 6 * corner + 6), 8 * k + 4);
    });
    this.mesh = makeTable(gl);
    fillTable(gl, this.mesh, numbers);
    this.instances = makeTable(gl);
  }

  add(position, turn, size, color, alpha) {
    if ((this.count + 1) * STRIDE > this.data.length) {
      const wider = new Float32Array(2 * this.data.length);
      wider.set(this.data);
      this.data = wider;
    }
    const d = this.data, k = this.count++ * STRIDE;
    d[k] = position[0]; d[k + 1] = position[1]; d[k + 2] = position[2];
    d[k + 3] = turn[0]; d[k + 4] = turn[1]; d[k + 5] = turn[2]; d[k + 6] = turn[3];
    d[k + 8] = size[0]; d[k + 9] = size[1]; d[k + 10] = size[2];
    d[k + 12] = color[0]; d[k + 13] = color[1]; d[k + 14] = color[2]; d[k + 15] = alpha;
  }

  send() {
    const { gl } = this, rows = Math.ceil((this.count * STRIDE) / (4 * ROW));
    if (this.rows * 4 * ROW < this.data.length) {
      fillTable(gl, this.instances, this.data);
      this.rows = this.data.length / (4 * ROW);
      return;
    }
    gl.bindTexture(gl.TEXTURE_2D, this.instances);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, gl.RGBA, gl.FLOAT, this.data.subarray(0, rows * 4 * ROW));
  }

  // With the program in use whose places of uniforms are given.
  draw(place) {
    if (!this.count) return;
    const { gl } = this;
    [this.mesh, this.instances].forEach((table, unit) => {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(gl.TEXTURE_2D, table);
    });
    gl.uniform1i(place.mesh, 0);
    gl.uniform1i(place.instances, 1);
    gl.uniform1i(place.vertices, this.vertices);
    gl.drawArrays(gl.TRIANGLES, 0, this.vertices * this.count);
  }
}
