// Ground that is not flat: meshes of heights, each below a biped, drawn in the place of the plane.

const TERRAIN_VERTEX = `#version 300 es
uniform mat4 matrix; in vec3 corner; out vec3 place;
void main() { place = corner; gl_Position = matrix * vec4(corner, 1.0); }`;
// Squares of 1 m as on the plane, lighter or darker as a face is inclined to the light; level ground is as the plane.
const TERRAIN_FRAGMENT = `#version 300 es
precision highp float;
in vec3 place; uniform vec3 horizon; uniform float dim; uniform vec3 middle; uniform vec3 light; out vec4 color;
void main() {
  vec3 normal = normalize(cross(dFdx(place), dFdy(place)));
  normal *= normal.y < 0.0 ? -1.0 : 1.0;
  vec2 width = max(fwidth(place.xz), vec2(1e-4));
  vec2 wave = clamp((abs(fract(place.xz * 0.5) - 0.5) - 0.25) * 2.0 / width, -1.0, 1.0);
  float calm = 1.0 - smoothstep(0.15, 0.6, max(width.x, width.y));
  float check = 0.5 + 0.5 * wave.x * wave.y * calm;
  vec3 tone = mix(vec3(0.735, 0.765, 0.785), vec3(0.76, 0.788, 0.807), check);
  tone *= clamp(1.0 + 0.45 * (dot(normal, light) - light.y), 0.72, 1.12);
  float fade = smoothstep(5.0, 26.0, length(place.xz - middle.xz));
  color = vec4(mix(dim * tone, horizon, fade), 1.0);
}`;

class Terrain {
  constructor(gl, meshes) {
    this.gl = gl;
    this.program = makeProgram(gl, TERRAIN_VERTEX, TERRAIN_FRAGMENT);
    const corners = [], numbers = [];
    for (const { shape: [rows, columns], points, offset } of meshes) {
      const first = corners.length / 3;
      for (let k = 0; k < points.length; k++) corners.push(points[k] + offset[k % 3]);
      for (let j = 0; j < rows - 1; j++)
        for (let i = 0; i < columns - 1; i++) {
          const a = first + j * columns + i, b = a + columns;
          numbers.push(a, a + 1, b, b, a + 1, b + 1);
        }
    }
    this.count = numbers.length;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    this.buffers = [gl.createBuffer(), gl.createBuffer()];
    gl.bindBuffer(gl.ARRAY_BUFFER, this.buffers[0]);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(corners), gl.STATIC_DRAW);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.buffers[1]);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(numbers), gl.STATIC_DRAW);
    const place = gl.getAttribLocation(this.program.program, "corner");
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
  }

  draw(matrix, middle, light) {
    const gl = this.gl, { program, place } = this.program;
    gl.useProgram(program);
    gl.uniformMatrix4fv(place.matrix, false, matrix);
    gl.uniform3fv(place.middle, middle);
    gl.uniform3fv(place.horizon, stage.horizon);
    gl.uniform1f(place.dim, stage.dim);
    gl.uniform3fv(place.light, light);
    gl.bindVertexArray(this.array);
    gl.drawElements(gl.TRIANGLES, this.count, gl.UNSIGNED_INT, 0);
    gl.bindVertexArray(null);
  }

  free() {
    this.buffers.forEach((buffer) => this.gl.deleteBuffer(buffer));
    this.gl.deleteVertexArray(this.array);
    this.gl.deleteProgram(this.program.program);
  }
}

// Height of the ground, m, at a place of the picture: of the plane, or of the mesh in whose lane that is.
function groundHeight({ normal, height, terrain }, x, z) {
  for (const mesh of terrain ?? []) {
    const { shape: [rows, columns], points, offset } = mesh, at = (j, i) => 3 * (j * columns + i);
    const away = (k) => [points[k] - points[0], points[k + 2] - points[2]];
    const shares = (end, asked) => { // of an axis of the mesh, which may be turned
      const axis = away(end), length = axis[0] ** 2 + axis[1] ** 2;
      return (asked[0] * axis[0] + asked[1] * axis[1]) / length;
    };
    const place = [x - offset[0] - points[0], z - offset[2] - points[2]];
    const s = cellOf(columns, shares(at(0, columns - 1), place), (k) => shares(at(0, columns - 1), away(at(0, k))));
    const t = cellOf(rows, shares(at(rows - 1, 0), place), (k) => shares(at(rows - 1, 0), away(at(k, 0))));
    if (!s || !t) continue;
    const y = (j, i) => points[at(t.cell + j, s.cell + i) + 1], row = (j) => y(j, 0) + s.part * (y(j, 1) - y(j, 0));
    return row(0) + t.part * (row(1) - row(0)) + offset[1];
  }
  return (height - normal[0] * x - normal[2] * z) / normal[1];
}

// The cell of a number between the lines of an axis, which lie at share(k) of it, and the part of the cell behind it.
function cellOf(lines, number, share) {
  if (!(number >= 0 && number <= 1)) return null;
  let low = 0, high = lines - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (share(middle) <= number) low = middle;
    else high = middle;
  }
  return { cell: low, part: (number - share(low)) / Math.max(share(high) - share(low), 1e-12) };
}

// The plane that shadows below a place fall on: as the ground lies about it.
function shadowPlane(ground, [x, , z]) {
  if (!ground.terrain?.length) return [...ground.normal, ground.height];
  const step = 0.3, y = (dx, dz) => groundHeight(ground, x + dx, z + dz);
  const n = unit([(y(-step, 0) - y(step, 0)) / (2 * step), 1, (y(0, -step) - y(0, step)) / (2 * step)]);
  const level = 0.2 * (y(0, 0) + y(-step, 0) + y(step, 0) + y(0, -step) + y(0, step));
  return [...n, n[0] * x + n[1] * level + n[2] * z];
}
