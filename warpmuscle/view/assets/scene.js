// The bipeds of the page at a moment: poses between recorded frames, and what is drawn of them.

const SIDE_TINT = { left: [0.55, 0.72, 0.86], right: [0.93, 0.73, 0.58], middle: [0.78, 0.8, 0.83] };
const BONE_TINT = [0.94, 0.93, 0.88], GHOST_TINT = [0.25, 0.62, 0.5], COM_TINT = [0, 0.62, 0.45];
const FORCE_TINT = [[0, 0.38, 0.62], [0.76, 0.31, 0]]; // left, right
const PLASMA = [[0.05, 0.03, 0.53], [0.49, 0.01, 0.66], [0.8, 0.28, 0.47], [0.97, 0.58, 0.25], [0.94, 0.98, 0.13]];
const UNTURNED = [0, 0, 0, 1];
const MUSCLE_RADIUS = [0.005, 0.015]; // m, without force and with the greatest
const FORCE_SCALE = 0.7; // m that a force of one body weight is drawn as
const PATH_POINTS = [40, 150]; // of many bipeds, and of few
const GLASS = 0.42; // opacity of shapes over muscles

function plasma(x) {
  const place = Math.min(Math.max(x, 0), 1) * 4, k = Math.min(Math.floor(place), 3), part = place - k;
  return PLASMA[k].map((value, i) => value + part * (PLASMA[k + 1][i] - value));
}

class Biped {
  constructor(content, arrays, doll, renderer) {
    Object.assign(this, content);
    this.doll = doll;
    this.bodies = doll.parent.length;
    this.arrays = Object.fromEntries(Object.entries(content.arrays).map(([name, k]) => [name, arrays[k]]));
    const com = this.arrays.com, every = Math.max(1, Math.ceil(this.frames / PATH_POINTS[Number(renderer.fine)]));
    const points = [];
    for (let f = 0; f < this.frames; f += every) points.push(add(this.row(com, 3, f), this.offset));
    this.path = renderer.makePath(points, 0.006, COM_TINT);
  }

  row(array, width, frame, k = 0, stride = width) {
    const first = frame * stride + k * width;
    return Array.prototype.slice.call(array, first, first + width);
  }

  // The frame at or before a time, and the part of the way to the next one.
  moment(time) {
    const t = this.arrays.time, last = this.frames - 1;
    if (time >= t[last]) return { frame: last, next: last, part: 0 };
    let low = 0, high = last;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (t[middle] <= time) low = middle;
      else high = middle;
    }
    return { frame: low, next: high, part: Math.max(0, (time - t[low]) / (t[high] - t[low])) };
  }

  between(name, width, moment, k = 0, stride = width) {
    const array = this.arrays[name], { frame, next, part } = moment;
    const a = frame * stride + k * width, b = next * stride + k * width, out = new Array(width);
    for (let i = 0; i < width; i++) out[i] = array[a + i] + part * (array[b + i] - array[a + i]);
    return out;
  }

  turn(name, moment, body) {
    const { frame, next, part } = moment, array = this.arrays[name], stride = 4 * this.bodies;
    const a = this.row(array, 4, frame, body, stride), b = this.row(array, 4, next, body, stride);
    const sign = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3] < 0 ? -1 : 1;
    const q = a.map((value, i) => value + part * (sign * b[i] - value));
    const length = Math.hypot(...q) || 1;
    return q.map((value) => value / length);
  }

  pose(name, moment) {
    const { parent, in_parent, in_child, sliding } = this.doll, turns = [], places = [];
    for (let body = 0; body < this.bodies; body++) {
      turns.push(this.turn(name, moment, body));
      if (body === 0) places.push(add(this.between("root", 3, moment), this.offset));
      else {
        const slid = sliding.indexOf(body);
        const away = slid < 0 ? [0, 0, 0] : this.between("slid", 3, moment, slid, 3 * sliding.length);
        const anchor = add(places[parent[body]], rotate(turns[parent[body]], add(in_parent[body], away)));
        places.push(minus(anchor, rotate(turns[body], in_child[body])));
      }
    }
    return { turns, places };
  }

  com(moment) {
    return add(this.between("com", 3, moment), this.offset);
  }

  draw(renderer, time, shown) {
    const { batches } = renderer;
    const moment = this.moment(time), pose = this.pose("orientation", moment);
    const inside = shown.muscles && this.doll.muscles.names.length > 0;
    const shapes = this.doll.parts.filter((part) => !part.bone), bones = this.doll.parts.filter((part) => part.bone);
    const tint = (part) => (part.bone ? BONE_TINT : SIDE_TINT[part.side]);
    if (shown.shapes) drawParts(inside ? batches.glass : batches.body, shapes, pose, tint, inside ? GLASS : 1);
    if (shown.bones) drawParts(batches.body, bones, pose, tint, 1);
    if (inside) this.drawMuscles(batches.lines, pose, moment, renderer.fine);
    if (shown.desired && this.arrays.desired)
      drawParts(batches.glass, this.doll.parts, this.pose("desired", moment), () => GHOST_TINT, 0.3);
    if (shown.forces) this.drawForces(batches.lines, moment);
    if (shown.path) {
      renderer.paths.push(this.path);
      batches.lines.sphere.add(this.com(moment), UNTURNED, [0.035, 0.035, 0.035], COM_TINT, 1);
    }
  }

  musclePoints({ turns, places }, moment) {
    const { body, place, conditional, routed } = this.doll.muscles;
    const points = place.map((p, i) => add(places[body[i]], rotate(turns[body[i]], p)));
    routed.forEach((k, i) => (points[k] = add(places[0], this.between("routed", 3, moment, i, 3 * routed.length))));
    if (!conditional.length) return points;
    const weight = new Array(points.length).fill(1), drawn = points.slice();
    const weights = this.between("weight", conditional.length, moment);
    conditional.forEach((k, i) => (weight[k] = weights[i]));
    for (const k of conditional) {
      let before = k - 1, behind = k + 1;
      while (weight[before] < 0.5) before--;
      while (weight[behind] < 0.5) behind++;
      const along = minus(points[behind], points[before]), square = Math.max(dot(along, along), 1e-12);
      const part = Math.min(Math.max(dot(minus(points[k], points[before]), along) / square, 0), 1);
      const line = add(points[before], times(along, part));
      drawn[k] = add(line, times(minus(points[k], line), weight[k]));
    }
    return drawn;
  }

  drawMuscles(batch, pose, moment, fine) {
    const { start, names } = this.doll.muscles, count = names.length;
    const points = this.musclePoints(pose, moment);
    const activation = this.between("activation", count, moment), load = this.between("load", count, moment);
    for (let m = 0; m < count; m++) {
      const radius = MUSCLE_RADIUS[0] + load[m] * (MUSCLE_RADIUS[1] - MUSCLE_RADIUS[0]), color = plasma(activation[m]);
      for (let k = start[m]; k < start[m + 1]; k++) {
        const inner = fine && k > start[m] && k < start[m + 1] - 1;
        if (inner) batch.sphere.add(points[k], UNTURNED, [radius, radius, radius], color, 1);
        if (k > start[m]) tube(batch.cylinder, points[k - 1], points[k], radius, color);
      }
    }
  }

  drawForces(batch, moment) {
    for (const side of [0, 1]) {
      const force = this.between("force", 3, moment, side, 6), size = norm(force) / this.doll.weight;
      if (size < 0.02) continue;
      const from = add(this.between("center", 3, moment, side, 6), this.offset), way = unit(force);
      const length = FORCE_SCALE * size, head = Math.min(0.09, length);
      const neck = add(from, times(way, length - head)), color = FORCE_TINT[side];
      tube(batch.cylinder, from, neck, 0.011, color);
      batch.cone.add(add(neck, times(way, head / 2)), turnFromY(way), [0.03, head, 0.03], color, 1);
    }
  }
}

function drawParts(batch, parts, { turns, places }, tint, alpha) {
  for (const part of parts) {
    const q = turns[part.body], position = add(places[part.body], rotate(q, part.position));
    batch[part.kind].add(position, multiply(q, part.orientation), part.size, tint(part), alpha);
  }
}

function tube(batch, a, b, radius, color) {
  const along = minus(b, a), length = norm(along);
  if (length > 1e-6) batch.add(times(add(a, b), 0.5), turnFromY(along), [radius, length, radius], color, 1);
}
