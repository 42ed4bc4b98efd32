// A biped at a moment: poses and muscles between recorded frames, put where the graphics card looks them up.

const SIDE_TINT = { left: [0.56, 0.7, 0.83], right: [0.9, 0.72, 0.58], middle: [0.8, 0.81, 0.83] };
const BONE_TINT = [0.96, 0.93, 0.85], HOLLOW_TINT = [0.3, 0.27, 0.25], OBJECT_TINT = [0.72, 0.6, 0.42], DEVICE_TINT = [0.16, 0.2, 0.24], COM_TINT = [0, 0.62, 0.45], PUSH_TINT = [0.9, 0.62, 0];
const FORCE_TINT = [[0, 0.38, 0.62], [0.76, 0.31, 0]]; // left, right
const UNTURNED = [0, 0, 0, 1];
const FORCE_SCALE = 0.7; // m that a force of one body weight is drawn as
const PATH_POINTS = [40, 150]; // of many bipeds, and of few
const SLACK_RADIUS = 0.0085, FULL_RADIUS = 0.028, TENDON_RADIUS = 0.0042; // m, of muscles of a body of 75 kg
const BEND = 0.03; // m of the way of a muscle that get as many points as a turn of 1 rad
const ROUND = 0.018; // m beside a point of a muscle, within which it bends
const FULL_FORCE = 1.5; // f_max that a load of 1 stands for

class Biped {
  constructor(content, arrays, widths, doll, renderer) {
    Object.assign(this, content);
    Object.assign(this, { doll, renderer, bodies: doll.parent.length, names: doll.muscles.names, near: false });
    const each = (of) => Object.fromEntries(Object.entries(content.arrays).map(([name, k]) => [name, of(name, k)]));
    this.widths = each((name, k) => widths[k]);
    this.arrays = each((name, k) => part(arrays[k], content.rows?.[name], content.frames, widths[k]));
    const { start, routed } = doll.muscles;
    this.count = doll.muscles.body.length;
    this.ways = new Float32Array(4 * this.count); // of muscles, which are drawn round where they bend
    this.routes = this.names.map((_, m) => m).filter((m) => routed.includes(start[m]));
    this.rounded = this.names.map((_, m) => renderer.fine && !this.routes.includes(m) && start[m + 1] - start[m] > 2);
    this.start = [0]; // of the points that are drawn
    this.rounded.forEach((is, m) => this.start.push(this.start[m] + (start[m + 1] - start[m]) * (is ? 3 : 1) - 4 * is));
    this.first = renderer.reserve(this.bodies, this.start[this.names.length], this.names.length);
    this.order = Math.max(...doll.muscles.f_max, 1); // N that is drawn as FULL_RADIUS
    this.addFigure();
  }

  // Whether its muscles are drawn: those of a body that is coloured as a whole only where it is near.
  get muscled() {
    return Boolean(this.arrays.activation) && !this.over && (!this.renderer.shaded || this.near);
  }

  // Solids and muscles, which stay as they are while their bodies and points move.
  addFigure() {
    const { renderer, doll, first, muscled, start } = this, apart = muscled && renderer.shaded;
    for (const piece of doll.pieces) {
      if (this.over && piece.layer === "flesh") continue; // what is seen through it would be covered
      const flesh = renderer.shade(this) ?? SIDE_TINT[piece.side];
      const slot = first.slots + piece.body, tint = { bone: this.over ?? BONE_TINT, hollow: HOLLOW_TINT, tendon: TENDON, object: OBJECT_TINT, device: DEVICE_TINT }[piece.layer] ?? flesh;
      const place = (piece.start ? times(add(piece.start, piece.end), 0.5) : piece.position) ?? [0, 0, 0];
      const along = piece.start ? minus(piece.end, piece.start) : [0, 0, 0], length = norm(along);
      const turn = piece.start ? turnFromY(length > 1e-9 ? along : [0, 1, 0]) : piece.orientation ?? UNTURNED;
      const [a, b] = piece.start ? piece.radii : [1, 1];
      const size = piece.start ? [a, a, a, length] : [...(piece.radii ?? [1, 1, 1]), 0];
      const kind = piece.kind === "ellipsoid" ? "limb" : piece.kind;
      const layer = piece.layer === "hollow" ? "bone" : piece.layer, named = apart && NEAR_LAYERS[layer] ? NEAR_LAYERS[layer] : layer;
      renderer.addSolid(named, kind, piece.mesh, slot, place, turn, size, tint, b / Math.max(a, 1e-9));
    }
    const unknown = new Set(this.arrays.routed ? [] : this.routes); // whose ways are not told
    for (let m = 0; m < (muscled ? this.names.length : 0); m++)
      for (let k = start[m]; k < start[m + 1] - 1 && !unknown.has(m); k++)
        renderer.addStretch(first.points + k, first.muscles + m, k === start[m], k === start[m + 1] - 2, start[m + 1] - start[m] - 1);
  }

  // The way of the centre of mass over all frames, as a trace on the ground.
  addPath() {
    const every = Math.max(1, Math.ceil(this.frames / PATH_POINTS[Number(this.renderer.fine)])), points = [];
    const { ground } = this.renderer, onGround = (p) => [p[0], groundHeight(ground, p[0], p[2]) + 0.004, p[2]];
    if (!this.arrays.com) return;
    for (let f = 0; f < this.frames; f += every) points.push(onGround(add(Array.from(this.arrays.com.slice(3 * f, 3 * f + 3)), this.offset)));
    this.renderer.addPath(points, 0.005, COM_TINT);
  }

  // The frame at or before a time, and the part of the way to the next one.
  moment(time) {
    const t = this.arrays.time, last = Math.max(this.frames - 1, 0);
    if (!(time < t[last])) return { frame: last, next: last, part: 0 };
    let low = 0, high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle;
      else high = middle;
    }
    return { frame: low, next: high, part: Math.max(0, (time - t[low]) / (t[high] - t[low])) };
  }

  // A row of an array at a moment, or of it the part from a number on.
  between(name, moment, from = 0, count = this.widths[name]) {
    const array = this.arrays[name], width = this.widths[name], { frame, next, part } = moment, out = new Array(count);
    for (let i = 0; i < count; i++) {
      const a = array[frame * width + from + i];
      out[i] = a + part * (array[next * width + from + i] - a);
    }
    return out;
  }

  // Write the pose of all bodies, as an array of orientations has it, to the table from a slot on.
  pose(name, moment, slot) {
    const { parent, in_parent, in_child, sliding } = this.doll, out = this.renderer.poses.numbers;
    const turns = this.arrays[name], width = 4 * this.bodies, { frame, next, part } = moment;
    const root = this.between("root", moment), slid = sliding.length ? this.between("slid", moment) : [];
    for (let body = 0; body < this.bodies; body++) {
      const at = 8 * (slot + body), a = frame * width + 4 * body, b = next * width + 4 * body;
      const same = turns[a] * turns[b] + turns[a + 1] * turns[b + 1] + turns[a + 2] * turns[b + 2] + turns[a + 3] * turns[b + 3];
      let square = 0;
      for (let i = 0; i < 4; i++) {
        const value = turns[a + i] + part * ((same < 0 ? -1 : 1) * turns[b + i] - turns[a + i]);
        out[at + 4 + i] = value;
        square += value * value;
      }
      const scale = 1 / (Math.sqrt(square) || 1);
      for (let i = 4; i < 8; i++) out[at + i] *= scale;
      if (body === 0) for (let i = 0; i < 3; i++) out[at + i] = root[i] + this.offset[i];
      else if (parent[body] < 0) for (let i = 0; i < 3; i++) out[at + i] = slid[3 * sliding.indexOf(body) + i] + this.offset[i]; // an object
      else this.hang(out, at, 8 * (slot + parent[body]), in_parent[body], in_child[body], slid, sliding.indexOf(body));
    }
  }

  // Put a body where its joint is in its parent.
  hang(out, at, above, in_parent, in_child, slid, k) {
    const place = k < 0 ? in_parent : [0, 1, 2].map((i) => in_parent[i] + slid[3 * k + i]);
    turnInto(out, at, out, above + 4, place[0], place[1], place[2], 1);
    for (let i = 0; i < 3; i++) out[at + i] += out[above + i];
    const [x, y, z] = [out[at], out[at + 1], out[at + 2]];
    turnInto(out, at, out, at + 4, in_child[0], in_child[1], in_child[2], -1);
    out[at] += x;
    out[at + 1] += y;
    out[at + 2] += z;
  }

  // Points around all flesh, and around bones without, by the poses in the table.
  outline() {
    const poses = this.renderer.poses.numbers, fleshy = new Set(this.doll.pieces.filter((piece) => piece.layer === "flesh").map((piece) => piece.body));
    const seen = (piece) => piece.layer === "flesh" || (piece.layer === "bone" && piece.reach && !fleshy.has(piece.body));
    return this.doll.pieces.filter(seen).flatMap((piece) => {
      const at = 8 * (this.first.slots + piece.body), turn = Array.from(poses.slice(at + 4, at + 8));
      const ends = piece.start ? [piece.start, piece.end] : [piece.position ?? piece.middle];
      const radii = piece.start ? piece.radii : [piece.reach ?? Math.max(...piece.radii)];
      return ends.flatMap((end, k) => {
        const p = add([poses[at], poses[at + 1], poses[at + 2]], rotate(turn, end));
        return [[1, 0, 0], [0, 1, 0], [0, 0, 1]].flatMap((axis) => [add(p, times(axis, radii[k])), add(p, times(axis, -radii[k]))]);
      });
    });
  }

  // Where a body is as it is drawn now.
  place(body) {
    const at = 8 * (this.first.slots + body);
    return Array.from(this.renderer.poses.numbers.slice(at, at + 3));
  }

  com(moment) {
    return add(this.between(this.arrays.com ? "com" : "root", moment), this.offset);
  }

  // Bring all that moves to a time.
  update(time, shown) {
    const moment = this.moment(time), { renderer, first } = this;
    this.pose("orientation", moment, first.slots);
    if (shown.desired && this.arrays.desired) this.pose("desired", moment, first.slots + renderer.shift);
    if (this.muscled) this.updateMuscles(moment, shown);
    if (shown.forces && this.arrays.plate) markPlates(this, moment);
    else if (shown.forces && this.arrays.force) this.markForces(moment);
    if (shown.markers && this.arrays.marker) markMarkers(this, moment);
    if (shown.path) {
      const r = 0.03 * this.doll.scale;
      renderer.mark("limb", this.com(moment), UNTURNED, [r, r, r, 0], COM_TINT);
    }
  }

  updateMuscles(moment, shown) {
    const { body, place, conditional, routed, start, f_max, share, belly, length } = this.doll.muscles, { renderer, first } = this;
    const out = this.ways, points = renderer.points.numbers, poses = renderer.poses.numbers;
    for (let k = 0; k < this.count; k++) {
      const at = 4 * k, pose = 8 * (first.slots + body[k]), p = place[k];
      turnInto(out, at, poses, pose + 4, p[0], p[1], p[2], 1);
      for (let i = 0; i < 3; i++) out[at + i] += poses[pose + i];
    }
    if (routed.length && this.arrays.routed) {
      const routes = this.between("routed", moment);
      routed.forEach((k, n) => {
        const at = 4 * k, on = this.routed_on?.[n], pose = 8 * (first.slots + (on ?? 0)), p = routes.slice(3 * n, 3 * n + 3);
        if (on === undefined) p.forEach((value, i) => (out[at + i] = value)); // of a live run: along the axes of the world
        else turnInto(out, at, poses, pose + 4, p[0], p[1], p[2], 1);
        for (let i = 0; i < 3; i++) out[at + i] += poses[pose + i];
      });
    }
    this.routes.forEach((m) => spreadPoints(out, 4 * start[m], start[m + 1] - start[m]));
    if (conditional.length && this.arrays.weight) this.slideConditional(this.between("weight", moment), out, 0);
    const activation = this.between("activation", moment), load = this.arrays.load && this.between("load", moment), s = this.doll.scale;
    const rest = SLACK_RADIUS ** 2, full = FULL_RADIUS ** 2 - rest; // the area grows with the force
    for (let m = 0; m < this.names.length; m++) {
      const to = 4 * (first.points + this.start[m]), at = 4 * (first.muscles + m);
      const bends = asPoints(out.subarray(4 * start[m], 4 * start[m + 1]));
      (this.rounded[m] ? roundBends(bends, s * ROUND) : bends).forEach((p, k) => points.set(p, to + 4 * k));
      const way = measureWay(points, to, this.start[m + 1] - this.start[m]);
      const force = load ? FULL_FORCE * load[m] * f_max[m] / this.order : 0, swollen = belly[m] * Math.sqrt(length[m] / Math.max(way, 0.5 * length[m]));
      const radius = shown.thickness ? s * Math.sqrt(rest + full * force) : swollen; // or a volume that stays
      const numbers = [radius, s * TENDON_RADIUS, activation[m], share[m]];
      renderer.muscles.numbers.set(numbers, at);
    }
  }

  // A conditional point slides onto the line between its neighbours as its weight goes to 0.
  slideConditional(weights, out, from) {
    const { conditional } = this.doll.muscles, weight = new Map(conditional.map((k, i) => [k, weights[i]]));
    const counts = (k) => (weight.get(k) ?? 1) >= 0.5, at = (k) => Array.from(out.slice(from + 4 * k, from + 4 * k + 3));
    const placed = conditional.map((k) => {
      let before = k - 1, behind = k + 1;
      while (!counts(before)) before--;
      while (!counts(behind)) behind++;
      const a = at(before), along = minus(at(behind), a), p = at(k);
      const part = Math.min(Math.max(dot(minus(p, a), along) / Math.max(dot(along, along), 1e-12), 0), 1);
      const onLine = add(a, times(along, part));
      return add(onLine, times(minus(p, onLine), weight.get(k)));
    });
    conditional.forEach((k, i) => out.set(placed[i], from + 4 * k));
  }

  markForces(moment) {
    const forces = this.between("force", moment), centers = this.between("center", moment);
    for (const side of [0, 1]) {
      const force = forces.slice(3 * side, 3 * side + 3), size = norm(force) / this.doll.weight;
      if (size < 0.02) continue;
      arrow(this.renderer, add(centers.slice(3 * side, 3 * side + 3), this.offset), times(unit(force), FORCE_SCALE * size), FORCE_TINT[side]);
    }
  }
}

// A colour such as #0072b2 as three parts up to 1, lighter.
function parted(color) {
  return [1, 3, 5].map((k) => 0.25 + (0.75 * parseInt(color.slice(k, k + 2), 16)) / 255);
}

// The rows of an array that are of one motion, where several share it.
function part(array, first, frames, width) {
  return first === undefined ? array : array.subarray(first * width, (first + frames) * width);
}

function arrow(renderer, from, along, color) {
  const length = norm(along), way = unit(along), head = Math.min(0.09, length), neck = length - head, turn = turnFromY(way);
  renderer.mark("tube", add(from, times(way, neck / 2)), turn, [0.011, 1, 0.011, neck], color);
  renderer.mark("cone", add(from, times(way, neck + head / 2)), turn, [0.03, 1, 0.03, head], color);
}

// Write a vector, turned by the quaternion at a place and times a sign, to another place.
function turnInto(out, at, q, k, x, y, z, sign) {
  const a = q[k], b = q[k + 1], c = q[k + 2], w = q[k + 3];
  const s = 2 * (b * z - c * y), t = 2 * (c * x - a * z), u = 2 * (a * y - b * x);
  out[at] = sign * (x + w * s + b * u - c * t);
  out[at + 1] = sign * (y + w * t + c * s - a * u);
  out[at + 2] = sign * (z + w * u + a * t - b * s);
}

// Write to the fourth number of each point how far along the polyline it is, 0 to 1; returns its length.
function measureWay(points, from, count) {
  let length = 0;
  points[from + 3] = 0;
  for (let k = 1; k < count; k++) {
    const at = from + 4 * k;
    length += Math.hypot(points[at] - points[at - 4], points[at + 1] - points[at - 3], points[at + 2] - points[at - 2]);
    points[at + 3] = length;
  }
  for (let k = 1; k < count; k++) points[from + 4 * k + 3] /= length || 1;
  return length;
}

// A polyline with three points in place of each but its ends, so that it bends within some length and not at once.
function roundBends(points, length) {
  return points.flatMap((p, k) => {
    if (!k || !points[k + 1]) return [p];
    const [a, b] = [k - 1, k + 1].map((n) => {
      const along = minus(points[n], p);
      return add(p, times(along, Math.min(length / Math.max(norm(along), 1e-6), 0.4)));
    });
    return [a, times(add(p, times(add(a, b), 0.5)), 0.5), b];
  });
}

// Points of a table of fours, as arrays of three.
function asPoints(numbers) {
  return Array.from({ length: numbers.length / 4 }, (_, k) => Array.from(numbers.slice(4 * k, 4 * k + 3)));
}

// Put the points of a polyline elsewhere along it, denser where it bends: between few of them a belly would have edges.
function spreadPoints(points, first, count) {
  const old = asPoints(points.subarray(first, first + 4 * count));
  const ways = old.slice(1).map((p, k) => minus(p, old[k])), lengths = ways.map(norm);
  const bend = (k) => (lengths[k] > 1e-6 && lengths[k + 1] > 1e-6 ? Math.acos(Math.min(Math.max(dot(ways[k], ways[k + 1]) / (lengths[k] * lengths[k + 1]), -1), 1)) : 0);
  const bends = [0, ...ways.slice(1).map((_, k) => bend(k)), 0], ends = [0];
  lengths.forEach((length, k) => ends.push(ends[k] + (length > 1e-6 ? length + 0.5 * BEND * (bends[k] + bends[k + 1]) : 0)));
  for (let k = 1, at = 0; k < count - 1; k++) {
    const place = (k / (count - 1)) * ends[count - 1];
    while (at < count - 2 && ends[at + 1] < place) at++;
    const part = (place - ends[at]) / (ends[at + 1] - ends[at] || 1);
    for (let i = 0; i < 3; i++) points[first + 4 * k + i] = old[at][i] + part * ways[at][i];
  }
}

// Make meshes of the hulls of a doll, whose arrays the page holds by number.
function readHulls(doll, arrays) {
  doll.pieces.filter((piece) => piece.kind === "hull").forEach((piece) => {
    const [corners, faces, normals] = piece.arrays.map((at) => arrays[at]), middle = [0, 0, 0];
    corners.forEach((value, i) => (middle[i % 3] += (3 * value) / corners.length));
    let reach = 0;
    for (let i = 0; i < corners.length; i += 3) reach = Math.max(reach, norm(minus(Array.from(corners.slice(i, i + 3)), middle)));
    Object.assign(piece, { middle, reach: 0.7 * reach, mesh: hullMesh(corners, faces, normals ?? normalsOf(corners, faces)) });
  });
}
