// Unit meshes. A vertex is a corner, which of two ends it belongs to (-0.5, 0 or 0.5), and a normal: eight numbers.
// A limb of length l and radii r at its ends has the corner times r, moved along y by end times l.

const CELL = 0.03; // m, of which coarse meshes have one corner

// Two half spheres and the cone between them.
function limbMesh(rings, sectors) {
  const vertices = [], faces = [], rows = 2 * rings + 2;
  for (let row = 0; row < rows; row++) {
    const upper = row > rings, a = ((upper ? row - 1 : row) / (2 * rings) - 0.5) * Math.PI;
    for (let j = 0; j < sectors; j++) {
      const b = (2 * Math.PI * j) / sectors;
      const p = [Math.cos(a) * Math.sin(b), Math.sin(a), Math.cos(a) * Math.cos(b)];
      vertices.push(...p, upper ? 0.5 : -0.5, ...p, 0);
    }
  }
  return { vertices, faces: gridFaces(rows, sectors, faces) };
}

// What is seen of a limb that is small in the picture: its outline and a ridge between.
function flatLimbMesh() {
  const side = (x, y, z, end) => [x, y, z, end, x, 0.6 * y, z + 0.3, 0], ring = (end) => [-1, 0, 1].flatMap((x) => side(x, 0.45 * Math.sign(end), 1 - Math.abs(x), end));
  const vertices = [...side(0, -1, 0, -0.5), ...ring(-0.5), ...ring(0.5), ...side(0, 1, 0, 0.5)];
  return { vertices, faces: [0, 2, 1, 0, 3, 2, 1, 2, 4, 2, 5, 4, 2, 3, 5, 3, 6, 5, 4, 5, 7, 5, 6, 7], flat: true };
}

// The same of a thin one: four corners, which are so many radii beyond its ends.
function bandMesh(beyond = 0) {
  const corner = (x, end) => [x, 2 * beyond * end, 0, end, x, 0, 0.6, 0];
  return { vertices: [-0.5, 0.5].flatMap((end) => [...corner(-1, end), ...corner(1, end)]), faces: [0, 1, 2, 1, 3, 2], flat: true };
}

// Round, with flat ends; a cone if the radius above is 0.
function tubeMesh(sectors, above = 1) {
  const vertices = [], faces = [], slope = 0.4 * (1 - above);
  for (const [end, radius] of [[-0.5, 1], [0.5, above]])
    for (let j = 0; j < sectors; j++) {
      const b = (2 * Math.PI * j) / sectors, x = Math.sin(b), z = Math.cos(b);
      vertices.push(x * radius, 0, z * radius, end, x, slope, z, 0);
    }
  gridFaces(2, sectors, faces);
  for (const [end, radius] of above ? [[-0.5, 1], [0.5, 1]] : [[-0.5, 1]]) {
    const first = vertices.length / 8;
    for (let j = 0; j < sectors; j++) {
      const b = (2 * Math.PI * j) / sectors;
      vertices.push(Math.sin(b) * radius, 0, Math.cos(b) * radius, end, 0, 2 * end, 0, 0);
      if (j > 1) faces.push(...(end > 0 ? [first, first + j - 1, first + j] : [first, first + j, first + j - 1]));
    }
  }
  return { vertices, faces };
}

// Rows of vertices around an axis, from below to above.
function gridFaces(rows, sectors, faces) {
  for (let row = 0; row < rows - 1; row++)
    for (let j = 0; j < (sectors > 2 ? sectors : 1); j++) {
      const next = (j + 1) % sectors, a = row * sectors + j, b = row * sectors + next;
      faces.push(a, b, a + sectors, b, b + sectors, a + sectors);
    }
  return faces;
}

function boxMesh() {
  const vertices = [], faces = [];
  for (let axis = 0; axis < 3; axis++)
    for (const sign of [-1, 1]) {
      const first = vertices.length / 8;
      for (const [s, t] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        const p = [0, 0, 0], n = [0, 0, 0];
        p[axis] = n[axis] = sign;
        p[(axis + 1) % 3] = s * sign;
        p[(axis + 2) % 3] = t;
        vertices.push(...p, 0, ...n, 0);
      }
      faces.push(first, first + 1, first + 2, first, first + 2, first + 3);
    }
  return { vertices, faces };
}

// The mesh of a hull, whose arrays hold a corner and its normal a row, and three corners of a face a row.
function hullMesh(corners, faces, normals) {
  const vertices = [];
  for (let k = 0; k < corners.length; k += 3)
    vertices.push(corners[k], corners[k + 1], corners[k + 2], 0, normals[k], normals[k + 1], normals[k + 2], 0);
  return { vertices, faces: Array.from(faces, Math.round) };
}

// The same with fewer corners: those of a cell that face one way become one, in their middle.
function coarseMesh({ vertices, faces }) {
  const at = (k) => vertices.slice(8 * k, 8 * k + 8), places = new Map(), own = [];
  for (let k = 0; k < vertices.length / 8; k++) {
    const v = at(k), key = [0, 1, 2].map((i) => Math.round(v[i] / CELL)).join() + [4, 5, 6].map((i) => Math.round(v[i])).join();
    if (!places.has(key)) places.set(key, { number: places.size, count: 0, sum: new Array(8).fill(0) });
    const place = places.get(key);
    v.forEach((value, i) => (place.sum[i] += value));
    place.count++;
    own.push(place.number);
  }
  const corners = [...places.values()].flatMap(({ sum, count }) => {
    const normal = unit(sum.slice(4, 7));
    return [...sum.slice(0, 4).map((value) => value / count), ...normal, 0];
  });
  const kept = [];
  for (let k = 0; k < faces.length; k += 3) {
    const [a, b, c] = [own[faces[k]], own[faces[k + 1]], own[faces[k + 2]]];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  return { vertices: corners, faces: kept };
}

// Rings along a stretch of a muscle: part of the way, and cosine and sine around it; flat if of two sectors.
function stretchMesh(rings, sectors) {
  const vertices = [];
  for (let row = 0; row < rings; row++)
    for (let j = 0; j < sectors; j++) {
      const b = (2 * Math.PI * j) / sectors;
      vertices.push(row / (rings - 1), Math.cos(b), Math.sin(b), 0);
    }
  return { vertices, faces: gridFaces(rings, sectors, []), flat: sectors === 2 };
}

// Of each corner, the mean of the directions that its triangles face, by their areas.
function normalsOf(corners, faces) {
  const normals = new Float32Array(corners.length);
  for (let f = 0; f < faces.length; f += 3) {
    const at = [0, 1, 2].map((k) => 3 * Math.round(faces[f + k])), [a, b, c] = at.map((k) => Array.from(corners.subarray(k, k + 3)));
    const area = cross(minus(b, a), minus(c, a));
    for (const k of at) for (let i = 0; i < 3; i++) normals[k + i] += area[i];
  }
  for (let k = 0; k < normals.length; k += 3) {
    const length = Math.hypot(normals[k], normals[k + 1], normals[k + 2]) || 1;
    for (let i = 0; i < 3; i++) normals[k + i] /= length;
  }
  return normals;
}
