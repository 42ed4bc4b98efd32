// Vectors, quaternions (x, y, z, w) and 4x4 matrices (by columns), in plain arrays.

const add = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (a, s) => [a[0] * s, a[1] * s, a[2] * s];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const norm = (a) => Math.hypot(a[0], a[1], a[2]);
const unit = (a) => times(a, 1 / (norm(a) || 1));

function rotate(q, v) {
  const t = times(cross(q, v), 2);
  return add(add(v, times(t, q[3])), cross(q, t));
}

function multiply(p, q) {
  return [
    p[3] * q[0] + q[3] * p[0] + p[1] * q[2] - p[2] * q[1],
    p[3] * q[1] + q[3] * p[1] + p[2] * q[0] - p[0] * q[2],
    p[3] * q[2] + q[3] * p[2] + p[0] * q[1] - p[1] * q[0],
    p[3] * q[3] - p[0] * q[0] - p[1] * q[1] - p[2] * q[2],
  ];
}

// The shortest turn from the y axis to a direction of any length.
function turnFromY(d) {
  const u = unit(d), w = 1 + u[1];
  if (w < 1e-6) return [1, 0, 0, 0];
  const s = 1 / Math.hypot(u[2], u[0], w);
  return [u[2] * s, 0, -u[0] * s, w * s];
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2), d = near - far;
  return [f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / d, -1, 0, 0, (2 * far * near) / d, 0];
}

function lookAt(eye, target) {
  const z = unit(minus(eye, target)), x = unit(cross([0, 1, 0], z)), y = cross(z, x);
  return [x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, -dot(x, eye), -dot(y, eye), -dot(z, eye), 1];
}

function product(a, b) {
  const c = new Array(16).fill(0);
  for (let i = 0; i < 4; i++)
    for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

// Whether a place is in a picture of the given size.
const isWithin = ([x, y], width, height) => x >= 0 && y >= 0 && x <= width && y <= height;

// Where a point is on a canvas of the given size, and how deep in the picture; null behind the eye.
function onScreen(matrix, p, width, height) {
  const at = (row) => matrix[row] * p[0] + matrix[4 + row] * p[1] + matrix[8 + row] * p[2] + matrix[12 + row];
  const w = at(3);
  return w > 0 ? [((at(0) / w + 1) / 2) * width, ((1 - at(1) / w) / 2) * height, w] : null;
}
