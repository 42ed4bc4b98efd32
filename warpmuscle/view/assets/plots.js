// Curves as small panels, of one biped or of all over one another. What does not move is drawn once and kept; of a long
// list only what is to be seen is drawn.

const LINE_COLOR = { left: "#0072b2", right: "#c24f00", middle: "#404040" };
const TRACK_COLOR = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#7a5195", "#404040"];
const PANEL = { width: 190, height: 112, least: 96, left: 38, right: 8, top: 20, bottom: 16 };
const NORM_ALPHA = 0.16, BAND_ALPHA = 0.22, SQUEEZED = 0.74; // of what is behind curves; of a title's width, at least
// A colour of a line for text, which needs more contrast with white: at least 4.5 of all above.
const inked = (css) => `#${[1, 3, 5].map((i) => Math.round(0.66 * parseInt(css.slice(i, i + 2), 16)).toString(16).padStart(2, "0")).join("")}`;
const INK = "#24313d", QUIET = "#5b6875", GRID = "#e2e7ec", NORM_TINT = { left: "#0072b2", right: "#d55e00", both: "#8a949e" };
const FONT = "11px system-ui, sans-serif";

class Plots {
  constructor(strip, onSeek) {
    this.strip = strip;
    this.canvas = strip.querySelector("canvas");
    this.spacer = strip.querySelector("div");
    this.kept = document.createElement("canvas");
    this.panels = [];
    this.boxes = [];
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    strip.addEventListener("scroll", () => this.onScroll?.());
    const seek = (event) => event.buttons && this.seek(event, onSeek);
    this.canvas.addEventListener("pointerdown", seek);
    this.canvas.addEventListener("pointermove", seek);
  }

  // Show panels of the first of some bipeds; the others' curves of the same names come over them.
  show(bipeds, panels) {
    Object.assign(this, { bipeds, panels });
    this.layout();
  }

  layout() {
    const { clientWidth: room, clientHeight: tall } = this.strip;
    if (!this.bipeds || !room) return;
    const across = Math.max(1, Math.min(Math.floor(room / PANEL.width), this.panels.length));
    const wide = Math.floor(room / across), rows = Math.ceil(this.panels.length / across);
    const seen = Math.min(Math.max(rows, 1), Math.max(1, Math.floor(tall / PANEL.least))); // whole rows, none cut
    const each = Math.min(Math.floor(tall / seen), 2 * PANEL.height);
    Object.assign(this, { room, tall, each, kept_at: undefined });
    for (const canvas of [this.canvas, this.kept])
      Object.assign(canvas, { width: Math.round(room * this.ratio), height: Math.max(1, Math.round(tall * this.ratio)) });
    Object.assign(this.canvas.style, { width: `${room}px`, height: `${tall}px` });
    this.spacer.style.height = `${Math.max(0, each * rows - tall)}px`;
    this.boxes = this.panels.map((panel, i) => ({
      panel, x: (i % across) * wide + PANEL.left, top: Math.floor(i / across) * each + PANEL.top,
      width: wide - PANEL.left - PANEL.right, height: each - PANEL.top - PANEL.bottom, lines: this.linesOf(panel),
    }));
  }

  // The curves of a panel: of one biped in the colours of its sides, else in those of the bipeds, the right one dashed.
  linesOf(panel) {
    const several = this.bipeds.length > 1;
    const stride = (biped, line) => this.inStrides() && meanStride(biped, line.side, (frame) => this.value({ biped, line }, frame));
    return this.bipeds.flatMap((biped, k) => {
      const same = biped === this.bipeds[0] ? panel : biped.panels.find((p) => p.group === panel.group && p.title === panel.title);
      return (same?.lines ?? []).map((line) => ({
        biped, line, stride: stride(biped, line), color: several ? TRACK_COLOR[k % TRACK_COLOR.length] : LINE_COLOR[line.side],
        dash: several && line.side === "right" ? [4, 3] : [],
      }));
    });
  }

  value({ biped, line }, frame) {
    return biped.arrays[line.from][frame * biped.widths[line.from] + line.column] * line.factor;
  }

  extent(box) {
    let low = Infinity, high = -Infinity;
    for (const curve of box.lines) {
      const { stride } = curve, count = stride ? STRIDE_SAMPLES : curve.biped.frames;
      for (let k = 0; k < count; k++) {
        const value = stride ? stride.mean[k] : this.value(curve, k), off = stride ? stride.sd[k] : 0;
        if (value - off < low) low = value - off;
        if (value + off > high) high = value + off;
      }
    }
    if (box.panel.norm && this.norms && this.hasCycles()) {
      const { mean, sd } = box.panel.norm;
      mean.forEach((m, k) => [low, high] = [Math.min(low, m - sd[k]), Math.max(high, m + sd[k])]);
    }
    if (!(high >= low)) return [0, 1];
    if (box.panel.unit === "" && low >= 0 && high <= 1.001) return [0, 1];
    const room = Math.max(0.06 * (high - low), 1e-3);
    return [low - room, high + room];
  }

  hasCycles() {
    return Object.values(this.bipeds[0].cycles).some((cycles) => cycles.length);
  }

  // Whether curves are of one stride, as is asked for, and there are strides.
  inStrides() {
    return Boolean(this.strides) && this.bipeds.every(hasStrides);
  }

  // What is at both ends of all axes: times, or 0 and 100 % of a stride.
  span() {
    if (this.inStrides()) return [0, 100];
    const { window } = this, times = this.bipeds.map((biped) => biped.arrays.time[Math.max(biped.frames - 1, 0)]);
    const end = Math.max(...times, 1e-6);
    return window ? [Math.max(0, end - window), Math.max(end, window)] : [Math.min(...this.bipeds.map((biped) => biped.arrays.time[0]), end - 1e-6), end];
  }

  // Draw all but the cursor, where it is not drawn yet.
  keep() {
    const { scrollTop, clientWidth, clientHeight } = this.strip;
    if (clientWidth !== this.room || clientHeight !== this.tall) this.layout();
    if (this.kept_at === scrollTop) return;
    this.kept_at = scrollTop;
    this.times = this.span();
    this.kept.getContext("2d").setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    this.kept.getContext("2d").clearRect(0, 0, this.room, this.tall);
    for (const box of this.boxes) {
      box.y = box.top - scrollTop;
      box.seen = box.y + box.height + PANEL.bottom > 0 && box.y - PANEL.top < this.tall;
      if (box.seen) this.drawPanel(this.kept.getContext("2d"), box);
    }
  }

  drawPanel(pen, box) {
    const { panel, x, y, width, height } = box, [begin, end] = this.times, strides = this.inStrides();
    [box.low, box.high] = this.extent(box);
    box.across = (t) => x + ((t - begin) / (end - begin)) * width;
    const up = (v) => this.up(box, v);
    if (panel.norm && this.norms) this.drawNorm(pen, box);
    const title = panel.unit ? `${panel.title} (${panel.unit})` : panel.title;
    Object.assign(pen, { font: FONT, fillStyle: INK, textAlign: "left", strokeStyle: GRID, lineWidth: 1 });
    box.wide = pen.measureText("-00.0").width + 8; // of a value
    const room = width - (box.lines.length > 3 ? 0 : box.wide * box.lines.length + 4);
    box.values = box.lines.length <= 3 && pen.measureText(title).width * SQUEEZED <= room; // or else the title is all there is
    pen.fillText(title, x, y - 7, box.values ? Math.max(room, 40) : width);
    Object.assign(pen, { fillStyle: QUIET, textAlign: "right" });
    for (const v of ticks(box.low, box.high, 3)) {
      line(pen, [[x, up(v)], [x + width, up(v)]]);
      pen.fillText(String(v), x - 4, up(v) + 4);
    }
    pen.textAlign = "center";
    for (const t of strides ? PERCENTS : ticks(begin, end, 4)) if (box.across(t) < x + width - 12) pen.fillText(`${t}`, box.across(t), y + height + 12);
    pen.textAlign = "right";
    pen.fillText(strides ? "% of stride" : "s", x + width + 4, y + height + 12);
    Object.assign(pen, { lineWidth: 1.4, lineJoin: "round" });
    pen.save();
    pen.beginPath();
    pen.rect(x, y - 1, width, height + 2);
    pen.clip();
    for (const curve of box.lines) {
      if (curve.stride && this.bipeds.length === 1) this.drawBand(pen, box, curve.stride.mean, curve.stride.sd, [0, 100], curve.color, BAND_ALPHA);
      this.drawCurve(pen, box, curve);
    }
    pen.restore();
  }

  drawCurve(pen, box, { biped, line, stride, color, dash }) {
    pen.strokeStyle = color;
    pen.setLineDash(dash);
    pen.beginPath();
    if (stride) stride.mean.forEach((value, k) => pen.lineTo(box.across((100 * k) / (STRIDE_SAMPLES - 1)), this.up(box, value)));
    else for (let f = 0; f < biped.frames; f++) pen.lineTo(box.across(biped.arrays.time[f]), this.up(box, this.value({ biped, line }, f)));
    pen.stroke();
    pen.setLineDash([]);
  }

  // A mean and so much to both sides, from one place of the axis to another one.
  drawBand(pen, box, mean, sd, [from, to], color, alpha) {
    const last = mean.length - 1, order = Array.from(mean, (_, k) => k);
    const at = (k, sign) => [box.across(from + ((to - from) * k) / last), this.up(box, mean[k] + sign * sd[k])];
    Object.assign(pen, { fillStyle: color, globalAlpha: alpha });
    pen.beginPath();
    [...order.map((k) => at(k, 1)), ...order.reverse().map((k) => at(k, -1))].forEach(([a, b]) => pen.lineTo(a, b));
    pen.fill();
    pen.globalAlpha = 1;
  }

  // The band of a norm over one stride, or over every gait cycle of the first biped, of each side in its colour.
  drawNorm(pen, box) {
    const { mean, sd } = box.panel.norm, { cycles } = this.bipeds[0];
    const sides = new Set(box.panel.lines.map((one) => (one.side === "middle" ? "left" : one.side)));
    pen.save();
    pen.beginPath();
    pen.rect(box.x, box.y, box.width, box.height);
    pen.clip();
    if (this.inStrides()) this.drawBand(pen, box, mean, sd, [0, 100], NORM_TINT.both, 1.6 * NORM_ALPHA);
    else for (const side of sides) for (const cycle of cycles[side] ?? []) this.drawBand(pen, box, mean, sd, cycle, NORM_TINT[side], NORM_ALPHA);
    pen.restore();
  }

  up(box, value) {
    return box.y + box.height * (1 - (value - box.low) / (box.high - box.low));
  }

  // The kept curves with a cursor at this time, and the values there.
  draw(time) {
    this.time = time;
    if (!this.bipeds || !this.boxes.length) return;
    this.keep();
    const pen = this.canvas.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.kept, 0, 0);
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    Object.assign(pen, { font: FONT, textAlign: "right", lineWidth: 1 });
    for (const box of this.boxes.filter((one) => one.seen)) this.drawCursor(pen, box, time);
  }

  // Where curves are now: in time one line, in strides a line a side, whose feet touch the ground at different times.
  drawCursor(pen, box, time) {
    let right = box.x + box.width;
    for (const curve of [...box.lines].reverse()) {
      if (!curve.biped.frames) continue;
      const x = this.cursor(box, curve, time), { frame } = curve.biped.moment(time), value = this.value(curve, frame);
      if (x !== null) {
        pen.strokeStyle = curve.stride ? curve.color : INK;
        line(pen, [[x, box.y], [x, box.y + box.height]]);
        pen.fillStyle = curve.color;
        pen.beginPath();
        pen.arc(x, Math.min(Math.max(this.up(box, value), box.y), box.y + box.height), 2.6, 0, 7);
        pen.fill();
      }
      pen.fillStyle = inked(curve.color);
      if (!box.values) continue;
      pen.fillText(short(value), right, box.y - 7);
      right -= box.wide;
    }
  }

  cursor(box, { biped, line, stride }, time) {
    const [begin, end] = this.times, part = stride ? strideAt(biped, line.side, time) : null;
    if (stride) return part === null ? null : box.across(100 * part);
    return box.across(Math.min(Math.max(time, begin), end));
  }

  // All panels, those that are scrolled away as well: their size, and drawn by any pen.
  whole() {
    return { wide: this.room, tall: Math.max(...this.boxes.map((box) => box.top + box.height + PANEL.bottom), 1) };
  }

  drawWhole(pen) {
    this.times = this.span();
    for (const box of this.boxes) this.drawPanel(pen, Object.assign(box, { y: box.top }));
    this.kept_at = undefined;
  }

  // The curves as rows of numbers under a row of names: over time of the first biped's frames, or over a stride.
  table() {
    const curves = this.boxes.flatMap((box) => box.lines.map((curve) => ({ ...curve, unit: box.panel.unit, title: box.panel.title, group: box.panel.group })));
    const name = ({ biped, group, title, line, unit }) => [...(this.bipeds.length > 1 ? [biped.label] : []), group, title, line.side === "middle" ? "" : line.side, unit && `(${unit})`].filter(Boolean).join(" ");
    if (this.inStrides()) {
      const names = curves.flatMap((curve) => [`${name(curve)}, mean`, `${name(curve)}, standard deviation`]);
      const rows = Array.from({ length: STRIDE_SAMPLES }, (_, k) => [(100 * k) / (STRIDE_SAMPLES - 1), ...curves.flatMap(({ stride }) => [stride.mean[k], stride.sd[k]])]);
      return [["% of stride", ...names], ...rows];
    }
    const { frames, arrays: { time } } = this.bipeds[0];
    const rows = Array.from({ length: frames }, (_, f) => [time[f], ...curves.map((curve) => this.value(curve, curve.biped.moment(time[f]).frame))]);
    return [["time (s)", ...curves.map(name)], ...rows];
  }

  seek(event, onSeek) {
    this.keep(); // panels may have changed since the last picture
    const area = this.canvas.getBoundingClientRect(), x = event.clientX - area.left, y = event.clientY - area.top;
    const box = this.boxes.find((b) => b.seen && x >= b.x - 8 && x <= b.x + b.width + 8 && y >= b.y - PANEL.top
      && y <= b.y + b.height + PANEL.bottom);
    if (!box) return;
    const part = Math.min(Math.max((x - box.x) / box.width, 0), 1), side = box.panel.lines[0].side;
    onSeek(this.inStrides() ? timeInStride(this.bipeds[0], side, part, this.time ?? 0) : this.times[0] + part * (this.times[1] - this.times[0]));
  }
}

function line(pen, points) {
  pen.beginPath();
  points.forEach(([x, y]) => pen.lineTo(x, y));
  pen.stroke();
}

// Some three digits, never with an exponent where it can be helped.
function short(value) {
  const size = Math.abs(value);
  return value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 0.1 || size === 0 ? 2 : 3);
}

// Round numbers within an interval, about so many.
function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const steps = [0.5, 1, 2, 5, 10], first = Math.max(steps.findIndex((s) => s * power >= raw), 1);
  const every = (step) => {
    const found = [];
    for (let k = Math.ceil(low / step); k * step <= high + 1e-9 * step; k++) found.push(Number((k * step).toPrecision(6)));
    return found;
  };
  const found = every(steps[first] * power);
  return found.length > 1 ? found : every(steps[first - 1] * power); // at least two, of most extents
}
