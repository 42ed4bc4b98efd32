// Curves of the chosen biped as small panels; what does not move is drawn once and kept.

const LINE_COLOR = { left: "#0072b2", right: "#d55e00", middle: "#404040" };
const PANEL = { width: 210, height: 116, left: 40, right: 10, top: 20, bottom: 16 };

class Plots {
  constructor(canvas, onSeek) {
    this.canvas = canvas;
    this.kept = document.createElement("canvas");
    this.panels = [];
    this.ratio = Math.min(window.devicePixelRatio || 1, 2);
    const seek = (event) => event.buttons && this.seek(event, onSeek);
    canvas.addEventListener("pointerdown", seek);
    canvas.addEventListener("pointermove", seek);
  }

  // Show the panels of a group; `end` is the time at the right of all axes.
  show(biped, group, end) {
    this.biped = biped;
    this.end = end;
    this.panels = biped.panels.filter((panel) => panel.group === group);
    this.layout();
  }

  layout() {
    const { clientWidth: room, clientHeight: tall } = this.canvas.parentElement;
    if (!this.biped || !room) return;
    Object.assign(this, { room, tall });
    const across = Math.max(1, Math.min(Math.floor(room / PANEL.width), this.panels.length));
    const wide = Math.floor(room / across), rows = Math.ceil(this.panels.length / across);
    const each = Math.min(Math.max(PANEL.height, Math.floor(tall / Math.max(rows, 1)) - 2), 2 * PANEL.height);
    const high = each * rows;
    for (const canvas of [this.canvas, this.kept]) {
      canvas.width = Math.round(room * this.ratio);
      canvas.height = Math.max(1, Math.round(high * this.ratio));
    }
    Object.assign(this.canvas.style, { width: `${room}px`, height: `${high}px` });
    this.boxes = this.panels.map((panel, i) => ({
      panel, x: (i % across) * wide + PANEL.left, y: Math.floor(i / across) * each + PANEL.top,
      width: wide - PANEL.left - PANEL.right, height: each - PANEL.top - PANEL.bottom,
    }));
    const pen = this.kept.getContext("2d");
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.clearRect(0, 0, room, high);
    this.boxes.forEach((box) => this.drawPanel(pen, box));
  }

  value(line, frame) {
    return this.biped.arrays.curves[frame * this.biped.curves + line.column];
  }

  extent(panel) {
    let low = Infinity, high = -Infinity;
    for (const line of panel.lines)
      for (let f = 0; f < this.biped.frames; f++) {
        const value = this.value(line, f);
        if (value < low) low = value;
        if (value > high) high = value;
      }
    if (panel.group === "activations") return [0, Math.max(1, high)];
    const room = Math.max(0.06 * (high - low), 1e-3);
    return [low - room, high + room];
  }

  drawPanel(pen, box) {
    const { panel, x, y, width, height } = box, time = this.biped.arrays.time;
    [box.low, box.high] = this.extent(panel);
    const across = (t) => x + (t / this.end) * width, up = (v) => this.up(box, v);
    pen.font = "11px system-ui, sans-serif";
    pen.fillStyle = "#24313d";
    pen.textAlign = "left";
    pen.fillText(panel.unit ? `${panel.title} (${panel.unit})` : panel.title, x, y - 7);
    pen.strokeStyle = "#e2e7ec";
    pen.fillStyle = "#6b7885";
    pen.lineWidth = 1;
    pen.textAlign = "right";
    for (const v of ticks(box.low, box.high, 3)) {
      line(pen, [[x, up(v)], [x + width, up(v)]]);
      pen.fillText(String(v), x - 4, up(v) + 4);
    }
    pen.textAlign = "center";
    for (const t of ticks(0, this.end, 4)) pen.fillText(`${t}`, across(t), y + height + 12);
    pen.textAlign = "right";
    pen.fillText("s", x + width + 8, y + height + 12);
    pen.lineWidth = 1.4;
    pen.lineJoin = "round";
    for (const curve of panel.lines) {
      pen.strokeStyle = LINE_COLOR[curve.side];
      pen.beginPath();
      for (let f = 0; f < this.biped.frames; f++) pen.lineTo(across(time[f]), up(this.value(curve, f)));
      pen.stroke();
    }
  }

  up(box, value) {
    return box.y + box.height * (1 - (value - box.low) / (box.high - box.low));
  }

  // The kept curves with a cursor at this time, and the values there.
  draw(time) {
    if (!this.biped || !this.boxes || !this.boxes.length) return;
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (clientWidth !== this.room || clientHeight !== this.tall) this.layout();
    const pen = this.canvas.getContext("2d"), { frame } = this.biped.moment(time);
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    pen.drawImage(this.kept, 0, 0);
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.font = "11px system-ui, sans-serif";
    pen.textAlign = "right";
    for (const box of this.boxes) {
      const x = box.x + (Math.min(time, this.end) / this.end) * box.width;
      pen.strokeStyle = "#24313d";
      pen.lineWidth = 1;
      line(pen, [[x, box.y], [x, box.y + box.height]]);
      let right = box.x + box.width;
      for (const curve of [...box.panel.lines].reverse()) {
        const value = this.value(curve, frame), text = short(value);
        pen.fillStyle = LINE_COLOR[curve.side];
        pen.beginPath();
        pen.arc(x, this.up(box, value), 2.6, 0, 7);
        pen.fill();
        pen.fillText(text, right, box.y - 7);
        right -= pen.measureText("-000.0").width + 2;
      }
    }
  }

  seek(event, onSeek) {
    const area = this.canvas.getBoundingClientRect(), x = event.clientX - area.left, y = event.clientY - area.top;
    const box = (this.boxes || []).find((b) => x >= b.x - 8 && x <= b.x + b.width + 8 && y >= b.y - PANEL.top
      && y <= b.y + b.height + PANEL.bottom);
    if (box) onSeek((Math.min(Math.max((x - box.x) / box.width, 0), 1)) * this.end);
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
  return value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : 2);
}

// Round numbers within an interval, about so many.
function ticks(low, high, count) {
  const raw = (high - low) / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5].find((s) => s * power >= raw) || 10), found = [];
  for (let k = Math.ceil(low / step); k * step <= high + 1e-9; k++) found.push(Number((k * step).toPrecision(6)));
  return found;
}
