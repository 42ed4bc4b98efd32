// A curve of the controller, whose points are dragged, put in and taken out, by pointer, touch or keys.

const APART = 0.001; // of the width, that two points are apart at least
const MARGIN = { left: 46, right: 16, top: 12, bottom: 22 };
const LEAST_SPAN = { rad: 0.2, m: 0.05, "m/s": 0.2 };
const KEY_STEP = 0.01; // of width and height, that an arrow key moves a point; ten times with shift

class CurveEditor {
  constructor(editor, element) {
    Object.assign(this, { editor, element, index: null, chosen: 0, held: null, sliding: false, handles: [] });
    this.make();
    new ResizeObserver(() => this.index !== null && this.draw()).observe(this.drawing);
  }

  make() {
    const make = (parent, tag, properties) => parent.appendChild(Object.assign(document.createElement(tag), properties));
    const nav = make(this.element, "nav", {});
    this.menu = make(nav, "select", { ariaLabel: "curve" });
    for (const group of this.editor.groups) {
      const curves = group.items.filter((item) => item.kind === "curve");
      const list = curves.length ? make(this.menu, "optgroup", { label: group.name }) : null;
      for (const { index } of curves) list.append(new Option(`${group.name}: ${this.editor.spec.curves[index].name}`, index));
    }
    this.menu.onchange = () => this.open(Number(this.menu.value), this.opener);
    const button = (text, title, act) => make(nav, "button", { textContent: text, title, onclick: act });
    button("add point", "behind the chosen one (insert); or double-click where it is to be", () => this.insertBehind());
    this.taking = button("remove point", "the chosen one (delete)", () => this.remove());
    this.straighten = button("scene's curve", "back to the points of the scene", () => {
      this.editor.say("straighten", { target: this.index });
      (this.handles[this.chosen] ?? this.menu).focus({ preventScroll: true });
    });
    button("copy as TOML", "the points of this curve as lines of a scene's file", () => this.editor.ask("points", this.index));
    this.undo = button("undo", "take the last change back (ctrl z)", () => this.editor.say("undo"));
    button("close", "back to the plots (escape)", () => this.close());
    this.drawing = make(this.element, "div", { className: "drawing" });
    this.canvas = make(this.drawing, "canvas", { role: "img", ariaLabel: "the curve over its phase or time" });
    this.canvas.ondblclick = (event) => this.insertAt(this.fromPixels(event.offsetX, event.offsetY));
    this.fields = make(this.element, "div", { className: "fields" });
    this.fields.onpointerdown = () => (this.sliding = true); // its range is not to change under the hand
    const release = () => {
      if (!this.sliding) return;
      this.sliding = false;
      this.follow();
    };
    ["pointerup", "pointercancel"].forEach((name) => window.addEventListener(name, release));
    const field = (name, act) => {
      const row = make(this.fields, "div", { className: "row" }), label = make(row, "span", {});
      return { label, show: makeRange(row, name, { min: 0, max: 1 }, act) };
    };
    this.across = field("place of the point", (now, dragged) => this.move(this.chosen, now, this.now().along[this.chosen], dragged));
    this.along = field("value of the point", (now, dragged) => this.move(this.chosen, this.now().at[this.chosen], now, dragged));
    window.addEventListener("keydown", ({ key, target }) => {
      if (key === "Escape" && this.index !== null && (this.element.contains(target) || target === document.body)) this.close();
    });
  }

  get spec() {
    return this.editor.spec.curves[this.index];
  }

  now() {
    return this.editor.curves[this.index];
  }

  open(index, opener) {
    const main = document.querySelector("main");
    Object.assign(this, { index, opener, chosen: 0, held: null });
    this.menu.value = String(index);
    this.element.hidden = false;
    main.classList.add("editing");
    window.dispatchEvent(new Event("resize"));
    this.follow();
    (this.handles[0] ?? this.menu).focus({ preventScroll: true });
  }

  close() {
    this.index = null;
    this.element.hidden = true;
    document.querySelector("main").classList.remove("editing");
    window.dispatchEvent(new Event("resize"));
    this.opener?.focus({ preventScroll: true });
  }

  // Whether a curve is being bent here, so that it is not to become what it was a moment ago.
  holds(index) {
    return index === this.index && (this.held !== null || this.sliding);
  }

  // Show what the simulation has, unless a point is held.
  follow() {
    if (this.index === null || this.held !== null || this.sliding) return;
    this.reach();
    this.chosen = Math.min(this.chosen, Math.max(this.now().at.length - 1, 0));
    this.straighten.disabled = !this.editor.bent.has(this.index);
    this.undo.disabled = this.editor.undo.disabled;
    this.draw();
  }

  // From where to where it is drawn.
  reach() {
    const { at, along, unit, straight } = this.spec, now = this.now();
    const places = [...at, ...now.at], values = [...along, ...now.along, ...(straight ? [0, 1] : [])];
    const low = Math.min(...values, Infinity), high = Math.max(...values, -Infinity);
    const middle = values.length ? 0.5 * (low + high) : 0, span = Math.max(values.length ? high - low : 0, LEAST_SPAN[unit] ?? 0.5);
    this.box = { x0: Math.min(0, ...places), x1: straight ? 1.25 * Math.max(0.8, ...places) : Math.max(1, ...places), y0: middle - 0.8 * span, y1: middle + 0.8 * span };
  }

  toPixels(x, y) {
    const { clientWidth: wide, clientHeight: tall } = this.drawing, { x0, x1, y0, y1 } = this.box;
    return [MARGIN.left + ((x - x0) / (x1 - x0)) * (wide - MARGIN.left - MARGIN.right),
      tall - MARGIN.bottom - ((y - y0) / (y1 - y0)) * (tall - MARGIN.top - MARGIN.bottom)];
  }

  fromPixels(px, py) {
    const { clientWidth: wide, clientHeight: tall } = this.drawing, { x0, x1, y0, y1 } = this.box;
    return [x0 + ((px - MARGIN.left) / (wide - MARGIN.left - MARGIN.right)) * (x1 - x0),
      y0 + ((tall - MARGIN.bottom - py) / (tall - MARGIN.top - MARGIN.bottom)) * (y1 - y0)];
  }

  draw() {
    const { canvas, drawing } = this, ratio = Math.min(window.devicePixelRatio || 1, 2), pen = canvas.getContext("2d");
    const { clientWidth: wide, clientHeight: tall } = drawing;
    if (!wide || !tall) return;
    Object.assign(canvas, { width: Math.round(wide * ratio), height: Math.round(tall * ratio) });
    pen.scale(ratio, ratio);
    this.drawAxes(pen, wide, tall);
    const spec = this.spec;
    this.drawCurve(pen, spec.at, spec.along, "#8a949e", [5, 4]);
    this.drawCurve(pen, this.now().at, this.now().along, "#0072b2", []);
    this.cursor = this.place();
    if (this.cursor !== null) {
      const [x] = this.toPixels(this.cursor, 0);
      Object.assign(pen, { strokeStyle: "#d55e00", lineWidth: 1 });
      line(pen, [[x, MARGIN.top], [x, tall - MARGIN.bottom]]);
    }
    this.placeHandles();
    this.showFields();
  }

  drawAxes(pen, wide, tall) {
    const { x0, x1, y0, y1 } = this.box, { unit, straight, duration } = this.spec;
    Object.assign(pen, { font: FONT, fillStyle: QUIET, strokeStyle: GRID, lineWidth: 1, textAlign: "center", textBaseline: "top" });
    const seconds = duration >= 0 ? this.editor.values[duration] : null;
    for (let k = 0; k <= 4; k++) {
      const value = x0 + (k / 4) * (x1 - x0), [x] = this.toPixels(value, y0);
      line(pen, [[x, MARGIN.top], [x, tall - MARGIN.bottom]]);
      const text = straight ? `${shortNumber(value.toFixed(2))} s` : seconds === null ? `${shortNumber(value.toFixed(2))}` : `${shortNumber(value.toFixed(2))} (${(value * seconds).toFixed(2)} s)`;
      if (k < 4 || wide > 380) pen.fillText(text, Math.min(Math.max(x, 30), wide - 34), tall - MARGIN.bottom + 5);
    }
    Object.assign(pen, { textAlign: "right", textBaseline: "middle" });
    const step = tickStep((y1 - y0) / 4);
    for (let value = Math.ceil(y0 / step) * step; value <= y1; value += step) {
      const [, y] = this.toPixels(x0, value);
      line(pen, [[MARGIN.left, y], [wide - MARGIN.right, y]]);
      pen.fillText(String(shortNumber(value.toFixed(6))), MARGIN.left - 5, y);
    }
    pen.textAlign = "left";
    pen.fillText(unit, MARGIN.left + 5, MARGIN.top + 7);
  }

  drawCurve(pen, at, along, color, dash) {
    const { x0, x1 } = this.box, points = [];
    for (let k = 0; k <= 240; k++) {
      const x = x0 + (k / 240) * (x1 - x0);
      points.push(this.toPixels(x, curveValue(at, along, x, this.spec.straight)));
    }
    Object.assign(pen, { strokeStyle: color, lineWidth: 2 });
    pen.setLineDash(dash);
    line(pen, points);
    pen.setLineDash([]);
  }

  // Where the running controller is on this curve, null while it is in another state.
  place() {
    const { live } = this.editor, { biped, player } = live, state = /^controller\.states\.(\d+)\./.exec(this.spec.key);
    if (!biped.frames) return null;
    if (this.spec.straight) return player.time <= this.box.x1 ? player.time : null;
    const { frame } = biped.moment(player.time), [at, phase] = biped.arrays.moment.subarray(2 * frame, 2 * frame + 2);
    return state && at === Number(state[1]) ? Math.min(Math.max(phase, this.box.x0), this.box.x1) : null;
  }

  tick() {
    if (this.index !== null && this.place() !== this.cursor) this.draw();
  }

  placeHandles() {
    const { at, along } = this.now();
    while (this.handles.length > at.length) this.handles.pop().remove();
    while (this.handles.length < at.length) this.handles.push(this.makeHandle(this.handles.length));
    this.handles.forEach((handle, k) => {
      const [x, y] = this.toPixels(at[k], along[k]);
      Object.assign(handle.style, { left: `${x}px`, top: `${Math.min(Math.max(y, 6), this.drawing.clientHeight - 6)}px` });
      handle.classList.toggle("chosen", k === this.chosen);
      handle.setAttribute("aria-label", `point ${k + 1} of ${at.length}`);
      handle.setAttribute("aria-valuenow", along[k]);
      handle.setAttribute("aria-valuetext", this.words(k));
      handle.title = this.words(k);
    });
  }

  words(k) {
    const { at, along } = this.now(), { unit, straight } = this.spec;
    const degrees = unit === "rad" ? ` (${((along[k] * 180) / Math.PI).toFixed(1)}\u00b0)` : "";
    return `${straight ? "time" : "phase"} ${shortNumber(at[k])}${straight ? " s" : ""}: ${shortNumber(along[k])} ${unit}${degrees}`.trim();
  }

  makeHandle(k) {
    const handle = this.drawing.appendChild(document.createElement("button"));
    handle.className = "point";
    handle.setAttribute("role", "slider");
    handle.onfocus = () => this.choose(k);
    handle.onpointerdown = (event) => {
      if (event.button) return;
      const [x, y] = this.toPixels(this.now().at[k], this.now().along[k]);
      this.held = { x: x - event.clientX, y: y - event.clientY };
      handle.setPointerCapture(event.pointerId);
      this.choose(k);
    };
    handle.onpointermove = (event) => this.held && this.move(k, ...this.fromPixels(event.clientX + this.held.x, event.clientY + this.held.y), true);
    handle.onpointerup = handle.onpointercancel = () => (this.held = null);
    handle.onlostpointercapture = () => {
      this.held = null;
      this.follow();
    };
    handle.onkeydown = (event) => this.press(k, event);
    return handle;
  }

  choose(k) {
    this.chosen = k;
    this.draw();
  }

  press(k, event) {
    const { x0, x1, y0, y1 } = this.box, { at, along } = this.now(), far = KEY_STEP * (event.shiftKey ? 10 : 1);
    const ways = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key in ways) {
      const [x, y] = ways[event.key];
      this.move(k, at[k] + x * far * (x1 - x0), along[k] + y * far * (y1 - y0), true);
    } else if (event.key === "Delete" || event.key === "Backspace") this.remove();
    else if (event.key === "Insert" || event.key === "+") this.insertBehind();
    else return;
    event.preventDefault();
    event.stopPropagation();
  }

  // The nearest value that the curve may have: excitations are between 0 and 1.
  within(y) {
    return shortNumber(this.spec.straight ? Math.min(Math.max(y, 0), 1) : y);
  }

  // A point somewhere between its neighbours.
  move(k, x, y, dragged) {
    const { at, along } = this.now(), { x0, x1 } = this.box, apart = APART * (x1 - x0);
    if (!(k < at.length)) return;
    const low = k ? at[k - 1] + apart : Math.min(x0, at[0]), last = k === at.length - 1;
    const high = !last ? at[k + 1] - apart : this.spec.straight && !dragged ? Infinity : Math.max(x1, at[k]);
    const place = shortNumber(Math.min(Math.max(x, low), Math.max(low, high))), value = this.within(y);
    this.editor.curves[this.index] = { at: at.with(k, place), along: along.with(k, value) };
    this.draw();
    const message = { edit: "move", target: this.index, point: k, at: place, value };
    if (dragged) this.editor.soon(`point ${this.index} ${k}`, message);
    else this.editor.live.say(message);
  }

  insertBehind() {
    const { at, along } = this.now(), { x0, x1 } = this.box, k = this.chosen, { straight } = this.spec;
    if (!at.length) return this.insertAt([0.5 * (x0 + x1), 0]);
    const next = k < at.length - 1 ? at[k + 1] : x1;
    const x = next - at[k] > 4 * APART * (x1 - x0) ? 0.5 * (at[k] + next) : 0.5 * (at[k] + (k ? at[k - 1] : x0));
    this.insertAt([x, curveValue(at, along, x, straight)]);
  }

  insertAt([x, y]) {
    const { at, along } = this.now(), { x0, x1 } = this.box, place = shortNumber(Math.min(Math.max(x, x0), x1));
    const value = this.within(y);
    const k = at.findIndex((one) => one > place), before = k < 0 ? at.length : k;
    if (at.some((one) => Math.abs(one - place) < APART * (x1 - x0))) return this.editor.refuse("there is a point already");
    if (at.length >= this.editor.spec.most) return this.editor.refuse(`a curve has ${this.editor.spec.most} points at most here`);
    this.editor.curves[this.index] = { at: at.toSpliced(before, 0, place), along: along.toSpliced(before, 0, value) };
    this.editor.say("insert", { target: this.index, point: before, at: place, value });
    this.chosen = before;
    this.draw();
    this.handles[before].focus({ preventScroll: true });
  }

  remove() {
    const { at, along } = this.now(), k = this.chosen;
    if (!at.length) return;
    this.editor.curves[this.index] = { at: at.toSpliced(k, 1), along: along.toSpliced(k, 1) };
    this.editor.say("remove", { target: this.index, point: k });
    this.chosen = Math.max(0, Math.min(k, at.length - 2));
    this.draw();
    this.handles[this.chosen]?.focus({ preventScroll: true });
  }

  showFields() {
    const { at, along } = this.now(), { unit, straight } = this.spec, k = this.chosen, { x0, x1, y0, y1 } = this.box;
    this.fields.hidden = this.taking.disabled = !at.length;
    if (!at.length) return;
    this.across.label.textContent = `point ${k + 1} of ${at.length}: ${straight ? "time, s" : "phase"}`;
    this.along.label.textContent = unit === "rad" ? `value, rad (${((along[k] * 180) / Math.PI).toFixed(1)}\u00b0)` : unit ? `value, ${unit}` : "value";
    this.across.show.reach(k ? at[k - 1] : x0, k < at.length - 1 ? at[k + 1] : x1);
    this.along.show.reach(y0, y1);
    this.across.show(at[k]);
    this.along.show(along[k]);
  }
}

// 1, 2 or 5 times a power of ten, not smaller than this.
function tickStep(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [1, 2, 5, 10].find((factor) => factor * power >= 0.999 * least) * power;
}

// As the simulation evaluates it (kernels/spline.py): Catmull-Rom tangents whatever the spacing, constant beyond its ends.
function curveValue(at, along, x, straight) {
  const last = at.length - 1;
  if (last < 0) return 0;
  if (x <= at[0]) return along[0];
  if (x >= at[last]) return along[last];
  const k = at.findIndex((one) => x < one), s = (x - at[k - 1]) / (at[k] - at[k - 1]), [from, to] = [along[k - 1], along[k]];
  if (straight) return from + s * (to - from);
  const before = along[Math.max(k - 2, 0)], after = along[Math.min(k + 1, last)], s2 = s * s, s3 = s2 * s;
  return from * (2 * s3 - 3 * s2 + 1) + to * (3 * s2 - 2 * s3) + 0.5 * (to - before) * (s3 - 2 * s2 + s) + 0.5 * (after - from) * (s3 - s2);
}
