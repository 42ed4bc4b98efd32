// Flat ground where no graphics card computes each pixel: squares of 1 m and lines every 5 m as triangles, whose colours
// fade from corner to corner as those of GROUND_FRAGMENT do from pixel to pixel.

const NEAR_SQUARES = 15; // m, within which there are squares and lines
const RINGS = [0.01, 5, 8, 11, 15, 20, 26, 110], AROUND = 24; // m, and sectors, of what lies below them
const LINE_WIDTH = 0.012, LINE_PIECE = 3; // m

// A corner: where it is from the middle, and what it belongs to: 0 the ground, 1 a dark square, 2 a line.
const FLOOR_VERTEX = `#version 300 es
precision highp float;
layout(location = 0) in vec3 corner;
uniform mat4 matrix; uniform vec4 ground; uniform vec3 middle; uniform vec3 horizon; uniform float dim; out vec3 tone;
void main() {
  float every = corner.z < 0.5 ? 0.0 : corner.z < 1.5 ? 2.0 : 5.0; // m, after which the pattern is the same
  vec2 p = corner.xy + (every > 0.0 ? every * floor(middle.xz / every) : middle.xz);
  vec3 n = ground.xyz;
  float away = length(p - middle.xz), clear = 1.0 - smoothstep(${(0.5 * NEAR_SQUARES).toFixed(1)}, ${(NEAR_SQUARES - 3).toFixed(1)}, away);
  float check = corner.z < 0.5 ? 1.0 : 0.0;
  vec3 own = mix(vec3(0.735, 0.765, 0.785), vec3(0.76, 0.788, 0.807), corner.z > 1.5 ? 0.5 : mix(0.5, check, clear));
  own -= corner.z > 1.5 ? 0.045 * clear : 0.0;
  tone = mix(dim * own, horizon, smoothstep(5.0, 26.0, away));
  gl_Position = matrix * vec4(p.x, (ground.w - n.x * p.x - n.z * p.y) / n.y, p.y, 1.0);
}`;
const FLOOR_FRAGMENT = `#version 300 es
precision mediump float;
in vec3 tone; out vec4 color;
void main() { color = vec4(tone, 1.0); }`;

class Floor {
  constructor(gl) {
    Object.assign(this, { gl, program: makeProgram(gl, FLOOR_VERTEX, FLOOR_FRAGMENT), array: gl.createVertexArray() });
    const corners = [], faces = [];
    addDisc(corners, faces);
    addSquares(corners, faces);
    addLines(corners, faces);
    this.count = faces.length;
    gl.bindVertexArray(this.array);
    for (const [target, data] of [[gl.ARRAY_BUFFER, new Float32Array(corners)], [gl.ELEMENT_ARRAY_BUFFER, new Uint16Array(faces)]]) {
      gl.bindBuffer(target, gl.createBuffer());
      gl.bufferData(target, data, gl.STATIC_DRAW);
    }
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 12, 0);
    gl.bindVertexArray(null);
  }

  // Before all else that has a depth: what is drawn later of it lies above what was drawn before.
  draw(matrix, middle, ground) {
    const { gl, program: { program, place } } = this;
    gl.useProgram(program);
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform4f(place.ground, ...ground.normal, ground.height);
    gl.uniform3fv(place.middle, middle);
    gl.uniform3fv(place.horizon, stage.horizon);
    gl.uniform1f(place.dim, stage.dim);
    gl.bindVertexArray(this.array);
    gl.depthFunc(gl.ALWAYS);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_SHORT, 0);
    gl.depthFunc(gl.LEQUAL);
    gl.bindVertexArray(null);
  }
}

function addDisc(corners, faces) {
  for (const radius of RINGS)
    for (let j = 0; j < AROUND; j++) corners.push(radius * Math.sin((2 * Math.PI * j) / AROUND), radius * Math.cos((2 * Math.PI * j) / AROUND), 0);
  gridFaces(RINGS.length, AROUND, faces);
}

function addSquares(corners, faces) {
  for (let x = -NEAR_SQUARES; x < NEAR_SQUARES; x++)
    for (let z = -NEAR_SQUARES; z < NEAR_SQUARES; z++)
      if ((x + z) % 2 && Math.hypot(x + 0.5, z + 0.5) < NEAR_SQUARES) addRectangle(corners, faces, x, z, x + 1, z + 1, 1);
}

function addLines(corners, faces) {
  for (let at = -NEAR_SQUARES; at <= NEAR_SQUARES; at += 5)
    for (let from = -NEAR_SQUARES; from < NEAR_SQUARES; from += LINE_PIECE) {
      addRectangle(corners, faces, at - LINE_WIDTH / 2, from, at + LINE_WIDTH / 2, from + LINE_PIECE, 2);
      addRectangle(corners, faces, from, at - LINE_WIDTH / 2, from + LINE_PIECE, at + LINE_WIDTH / 2, 2);
    }
}

function addRectangle(corners, faces, x0, z0, x1, z1, kind) {
  const first = corners.length / 3;
  corners.push(x0, z0, kind, x1, z0, kind, x0, z1, kind, x1, z1, kind);
  faces.push(first, first + 1, first + 2, first + 1, first + 3, first + 2);
}
