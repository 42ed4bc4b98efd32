// The page: time, what is shown and chosen, and `window.warpmuscle` for scripts.

const FITTED = 4, FITTED_TIMES = 9; // motions, and times of them, of which all is to be seen
const LEFT_BEHIND = 0.5; // s after its end, at which the camera no longer follows a motion
const APART_WHERE_SPLIT = 200, GAP = 3; // m between motions that are seen one by one; px between their pictures
const NAME = 24; // px, above a head in a picture of its own
const PLOT_PAUSE = [0, 80]; // ms between two places of the cursor with a graphics card, and without

class Player {
  constructor(content, arrays) {
    const asked = asksFor();
    this.element = (id) => document.getElementById(id);
    this.renderer = new Renderer(this.element("scene"), content.ground, content.tracks.length);
    const widths = content.table.map((entry) => entry.low.length);
    content.dolls.forEach((doll) => readHulls(doll, arrays));
    const told = (track) => ({ ...track, panels: content.panels[track.panels] });
    const tint = (k) => (content.over && k ? parted(TRACK_COLOR[k % TRACK_COLOR.length]) : null);
    this.bipeds = content.tracks.map((track, k) => new Biped({ ...told(track), over: tint(k) }, arrays, widths, content.dolls[track.doll], this.renderer));
    Object.assign(this, { seen: [], time: 0, playing: content.autoplay && (Boolean(content.live) || !calm()), speed: 1, selected: 0, pictures: 0, marks: [], words: "", together: false });
    this.shown = { ...content.shown };
    if ("split" in this.shown) this.shown.split ||= this.renderer.canvas.clientWidth < this.renderer.canvas.clientHeight; // as on a phone
    this.camera = new Camera(this.element("scene"), this.bipeds.length > FITTED ? ANGLES.crowd : ANGLES.oblique);
    this.plots = new Plots(this.element("strip"), (time) => this.seek(time));
    this.plots.onScroll = () => (this.drawn = null);
    this.live = content.live ? new Live(this, content.live) : null;
    document.querySelector("main").classList.toggle("live", Boolean(this.live));
    document.querySelector("main").classList.toggle("waiting", Boolean(content.waiting));
    this.measure();
    this.time = this.begin;
    this.controls = new Controls(this, content);
    this.labels = new Labels(this);
    this.shades = new Shades(this, content.shades);
    addDots(this.bipeds, content.over);
    this.setSpeed(1);
    if (!this.live && !("split" in this.shown)) this.bipeds.forEach((biped) => biped.addPath());
    Object.keys(this.shown).forEach((name) => this.show(name, this.shown[name]));
    this.choose(0);
    if (content.over) this.overlay(true);
    this.play(this.playing);
    this.fit();
    this.follow(asked);
    this.live?.connect();
    window.addEventListener("resize", () => !this.camera.touched && this.fit());
    requestAnimationFrame((now) => this.tick(now));
    if (content.waiting) this.waiting = new Waiting(content.waiting);
  }

  // Begin and end of the motion, and the time between two frames, s.
  measure() {
    const times = this.bipeds.map(({ arrays, frames }) => [arrays.time[0], arrays.time[Math.max(frames - 1, 0)]]);
    this.begin = Math.min(...times.map((t) => t[0]));
    this.end = Math.max(...times.map((t) => t[1]), this.begin + 1e-6);
    this.step = (this.end - this.begin) / Math.max(1, ...this.bipeds.map((biped) => biped.frames - 1));
  }

  // What the page's address asks for: a frame or a time, a view, and whether nothing but the picture is to be seen.
  follow(asked) {
    const number = (name) => (asked.has(name) && Number.isFinite(Number(asked.get(name))) ? Number(asked.get(name)) : null);
    if (number("frame") !== null || number("time") !== null) {
      this.play(false);
      this.seek(number("time") ?? this.begin + (number("frame") + 0.01) * this.step); // times are rounded
    }
    if (number("shot")) {
      this.element("scene").closest("main").classList.add("shot");
      this.play(false);
      this.renderer.still = Math.max(this.renderer.still, 2);
      this.show("plots", false);
    }
    if (number("plots") !== null) this.show("plots", number("plots") > 0);
    if (asked.has("group") && this.groups().includes(asked.get("group"))) this.group(asked.get("group"));
    if (Object.hasOwn(ANGLES, asked.get("view"))) this.look(asked.get("view"));
    else if (number("shot")) this.fit();
  }

  hasMuscles() {
    return this.bipeds.some((biped) => biped.count);
  }

  play(on) {
    this.playing = on;
    if (this.live) this.live.play(on);
    else if (on && this.time >= this.end) this.time = this.begin;
    this.element("play").setAttribute("aria-label", on ? "pause" : "play");
    this.element("play").textContent = on ? "\u275a\u275a" : "\u25b6\ufe0e";
  }

  restart() {
    if (this.live) this.live.restart();
    else this.seek(this.begin);
  }

  seek(time) {
    if (this.live && this.playing) this.play(false);
    this.time = Math.min(Math.max(time, this.begin), this.end);
  }

  seekPart(part) {
    this.seek(this.begin + part * (this.end - this.begin));
  }

  frame(count) {
    this.play(false);
    if (this.live) this.live.frame(count);
    else this.seek(this.begin + (Math.round((this.time - this.begin) / this.step) + count) * this.step);
  }

  setSpeed(speed) {
    this.speed = speed;
    this.element("speed").value = String(speed);
    this.live?.setSpeed(speed);
  }

  flip(name) {
    if (name in this.shown) this.show(name, !this.shown[name]);
  }

  show(name, on) {
    this.shown[name] = on;
    const box = this.element("toggles").querySelector(`[data-name="${name}"] input`);
    if (box) box.checked = on;
    if (name === "plots") this.element("scene").closest("main").classList.toggle("bare", !on);
    if (name === "follow") this.camera.follow = on;
    if (name === "turntable") this.camera.turntable = on;
    if (name === "split") this.split(on);
    if (name === "dark") {
      Object.assign(stage, STAGES[Number(on)]);
      this.element("scene").closest("main").classList.toggle("dark", on);
    }
    if (name === "yellow") {
      this.renderer.yellow = on;
      this.shades.draw(this.element("scale"));
    }
    if (name === "norms") this.plots.norms = on;
    if (name === "strides") {
      this.plots.strides = this.element("stride").firstChild.checked = on;
      this.showPlots();
    }
    this.plots.kept_at = undefined;
  }

  choose(k) {
    this.selected = k;
    this.element("selected").value = String(k);
    const nav = this.element("groups");
    nav.innerHTML = "";
    for (const name of this.groups()) {
      const button = nav.appendChild(document.createElement("button"));
      button.textContent = name;
      button.onclick = () => this.group(name);
    }
    this.group(this.groups().includes(this.shownGroup) ? this.shownGroup : this.groups()[0], this.words);
  }

  groups() {
    return [...new Set(this.bipeds[this.selected].panels.map((panel) => panel.group))];
  }

  group(name, words = "") {
    this.shownGroup = name;
    this.words = words;
    this.element("search").value = words;
    for (const button of this.element("groups").querySelectorAll("button"))
      this.markChosen(button, !words && button.textContent === name);
    this.showPlots();
  }

  // Say of a button, to eyes and to screen readers, whether it is the chosen one.
  markChosen(button, on) {
    button.classList.toggle("chosen", on);
    button.setAttribute("aria-pressed", String(on));
  }

  // Curves of any group whose names hold all of these words.
  find(words) {
    this.group(this.shownGroup, words);
  }

  overlay(on) {
    this.together = on;
    this.element("several").firstChild.checked = on;
    this.showPlots();
  }

  showPlots() {
    const chosen = this.bipeds[this.selected], others = this.bipeds.filter((biped) => biped !== chosen);
    const plain = (text) => text.toLowerCase().replaceAll("_", " "), words = plain(this.words).split(/\s+/).filter(Boolean);
    const text = (panel) => plain([panel.group, panel.title, ...panel.lines.map((line) => line.name)].join(" "));
    const panels = chosen.panels.filter((panel) =>
      words.length ? words.every((word) => text(panel).includes(word)) : panel.group === this.shownGroup);
    const bipeds = this.together ? [chosen, ...others] : [chosen];
    this.plots.show(bipeds, panels);
    this.drawn = null;
    this.plotted = -Infinity; // they are empty now
    const entries = this.together
      ? bipeds.slice(0, TRACK_COLOR.length).map((biped, k) => [biped.label, TRACK_COLOR[k]])
      : ["left", "right"].filter((side) => panels.some((panel) => panel.lines.some((line) => line.side === side))).map((side) => [side, LINE_COLOR[side]]);
    const norm = panels.find((panel) => panel.norm);
    if (norm && "norms" in this.shown) entries.push([`norm: ${norm.norm.source}`, NORM_TINT.both]);
    this.element("key").replaceChildren(...entries.map(([name, color]) => {
      const entry = document.createElement("span");
      entry.appendChild(document.createElement("i")).style.background = color;
      entry.append(name);
      return entry;
    }));
  }

  // How much a motion counts for where the camera goes: one that has ended, as by a fall, is left behind.
  weight(biped, time) {
    const end = this.live ? Infinity : biped.until ?? biped.arrays.time[Math.max(biped.frames - 1, 0)];
    return Math.min(Math.max(1 - (time - end) / LEFT_BEHIND, 0), 1);
  }

  // Each motion in a picture of its own, far away from the others, or all in one.
  split(on) {
    const { path } = this.renderer;
    path.clear();
    this.bipeds.forEach((biped, k) => {
      biped.lane ??= biped.offset;
      biped.offset = on ? [APART_WHERE_SPLIT * k, 0, 0] : biped.lane;
      biped.addPath();
    });
    this.drawn = null;
    if (this.labels) this.fit();
  }

  // Parts of the picture: from the left and the top, width and height, of the whole; below one another where it is narrow.
  boxes() {
    const count = this.bipeds.length, { clientWidth, clientHeight } = this.renderer.canvas, gap = GAP / Math.max(clientWidth, 1);
    if (!this.shown.split) return [[0, 0, 1, 1]];
    if (clientWidth < clientHeight) return this.bipeds.map((_, k) => [0, k / count, 1, 1 / count - (k < count - 1 ? gap : 0)]);
    return this.bipeds.map((_, k) => [k / count, 0, 1 / count - (k < count - 1 ? gap : 0), 1]);
  }

  // The same in pixels of the page.
  pixels([left, top, wide, tall]) {
    const { clientWidth, clientHeight } = this.renderer.canvas;
    return [left * clientWidth, top * clientHeight, wide * clientWidth, tall * clientHeight];
  }

  // The mean of the centres of mass that count, now or at another time.
  middle(time = this.time) {
    if (this.followed && time === this.time) return this.followed.biped.place(this.followed.body);
    const weights = this.bipeds.map((biped) => this.weight(biped, time)), sum = weights.reduce((a, b) => a + b);
    const places = this.bipeds.map((biped, k) => times(biped.com(biped.moment(time)), sum ? weights[k] / sum : 1 / weights.length));
    return places.reduce(add);
  }

  // Keep a body in the middle of the picture, as it is drawn now; of none, go with all again.
  followBody(found) {
    if (!found) return void (this.followed && this.fit());
    const { biped, muscle } = found, body = found.body ?? biped.doll.muscles.body[biped.doll.muscles.start[muscle]];
    this.followed = { biped, body };
    Object.assign(this.camera, { target: biped.place(body), pan: [0, 0, 0], touched: true });
    this.show("follow", true);
  }

  look(name) {
    this.camera.look(ANGLES[name]);
    this.element("from").value = name;
    this.fit();
  }

  // Go where all is seen now and, of few recorded motions, at all times until they end, as the camera goes with what moves over the ground.
  fit() {
    this.followed = null;
    const points = [], now = this.middle();
    const moments = this.live || this.bipeds.length > FITTED ? 0 : FITTED_TIMES;
    const all = Array.from({ length: moments }, (_, k) => this.begin + (k / (moments - 1)) * (this.end - this.begin));
    for (const time of [...all, this.time])
      for (const biped of this.bipeds.filter((one) => this.shown.split || time === this.time || this.weight(one, time))) {
        const moment = biped.moment(time), [x, , z] = minus(now, this.shown.split ? biped.com(moment) : this.middle(time));
        biped.pose("orientation", moment, biped.first.slots);
        for (const point of biped.outline()) points.push(add(point, [x, 0, z]));
      }
    const boxes = this.boxes().map((box) => this.pixels(box)), [, , wide, tall] = boxes[0];
    this.camera.fit(points, now, wide / Math.max(tall, 1), wide, this.shown.split ? this.under(boxes) : 0);
  }

  // The part of pictures beside each other, from the top, that lies under tools and names.
  under(boxes) {
    const over = boxes.map(([x, y, wide]) => (y < 1 ? covered(x + 0.4 * wide, x + 0.6 * wide) : 0));
    return Math.min((Math.max(...over) + NAME) / boxes[0][3], 0.4);
  }

  zoom(factor) {
    this.camera.zoom(factor);
  }

  // Go around and up by angles, rad.
  turn(around, up = 0) {
    this.camera.turn(around, up);
  }

  pickAt(x, y) {
    const view = this.seen.find(({ pixels: [left, top, wide, tall] }) => isWithin([x - left, y - top], wide, tall));
    if (!view) return null;
    const [left, top, wide, tall] = view.pixels;
    return pick(view.bipeds, view.matrix, wide, tall, x - left, y - top, this.shown);
  }

  describe({ biped, muscle, name }) {
    const label = this.bipeds.length > 1 ? `${biped.label}: ${name}` : name;
    const known = [biped.rank && `rank ${biped.rank} of ${this.bipeds.length}`, biped.ended].filter(Boolean).join(", ");
    if (muscle === undefined) return this.bipeds.length > FITTED && known ? `${biped.label}\n${known}` : label;
    const moment = biped.moment(this.time), part = (array) => biped.between(array, moment, muscle, 1)[0];
    const force = () => `, force ${(FULL_FORCE * part("load") * biped.doll.muscles.f_max[muscle]).toFixed(0)} N`;
    return `${label}\nactivation ${part("activation").toFixed(2)}${biped.arrays.load ? force() : ""}`;
  }

  help() {
    const dialog = this.element("help");
    if (dialog.open) dialog.close();
    else dialog.showModal();
  }

  // What a file of this moment is called.
  fileName(suffix) {
    const title = this.element("legend").firstChild.textContent.replace(/[^\w-]+/g, "_").slice(0, 60) || "motion";
    return `${title}_${this.time.toFixed(2)}s.${suffix}`;
  }

  saveCurves(kind) {
    this.element("save").value = "";
    if (kind) SAVES[kind](this.plots, this.fileName("").replace(/\.$/, ""));
    this.plots.kept_at = this.drawn = null;
  }

  savePicture() {
    this.draw(true);
    this.renderer.canvas.toBlob((blob) => blob && download(this.fileName("png"), blob));
  }

  // Play once from start to end, and save what is seen.
  saveFilm() {
    if (this.film) return this.endFilm();
    this.seek(this.begin);
    this.film = startFilm(this.renderer.canvas, (blob) => download(this.fileName("webm"), blob));
    this.element("film").classList.add("on");
    this.play(true);
  }

  endFilm() {
    this.film.stop();
    this.film = null;
    this.element("film").classList.remove("on");
    this.play(false);
  }

  tick(now) {
    const passed = this.last === undefined ? 0 : Math.min((now - this.last) / 1000, 0.25);
    if (this.last !== undefined && this.playing) this.renderer.adapt(now - this.last);
    this.last = now;
    if (this.shown.turntable) this.camera.turn(TURNTABLE * passed, 0);
    if (this.live) this.live.advance(passed);
    else if (this.playing) this.advance(passed);
    const picture = this.pictureKey();
    if (picture !== this.drawn) {
      this.drawn = picture;
      this.draw();
      this.pictures++;
      this.marks = [...this.marks.filter((mark) => mark > now - 1000), now];
    }
    requestAnimationFrame((next) => this.tick(next));
  }

  advance(passed) {
    this.time += passed * this.speed;
    if (this.time <= this.end) return;
    if (this.film) {
      this.time = this.end;
      this.endFilm();
    } else this.time = this.begin + ((this.time - this.begin) % (this.end - this.begin));
  }

  // All that a picture depends on, so that nothing is drawn twice.
  pictureKey() {
    const { clientWidth, clientHeight } = this.renderer.canvas, { clientWidth: room, clientHeight: tall } = this.element("strip");
    const { time, playing, shown, selected, shownGroup, camera } = this, frames = this.live?.received;
    return JSON.stringify([time, playing, shown, selected, shownGroup, camera.state(), camera.busy(), clientWidth, clientHeight,
      room, tall, this.renderer.chosen, frames]);
  }

  draw(still = !this.playing && !this.camera.busy()) {
    const { renderer, shown, time } = this;
    renderer.resize(still);
    renderer.clearMarks();
    for (const biped of this.bipeds) biped.update(time, shown);
    this.live?.mark();
    this.seen = this.boxes().map((box, k) => {
      const bipeds = shown.split ? [this.bipeds[k]] : this.bipeds, pixels = this.pixels(box);
      const middle = shown.split && this.followed?.biped !== bipeds[0] ? bipeds[0].com(bipeds[0].moment(time)) : this.middle();
      const coms = bipeds.map((one) => one.com(one.moment(time)));
      return { box, pixels, bipeds, coms, ...this.camera.view(middle, pixels[2] / Math.max(pixels[3], 1)) };
    });
    this.shades.showNear(this.seen);
    renderer.draw(this.seen, shown);
    this.labels.draw(this.seen);
    this.drawPlots(still);
    this.element("time").value = String((time - this.begin) / (this.end - this.begin));
    this.element("clock").textContent = this.live ? `${time.toFixed(2)} s` : `${time.toFixed(2)} / ${this.end.toFixed(2)} s`;
  }

  drawPlots(still) {
    const now = performance.now(), pause = PLOT_PAUSE[Number(this.renderer.slow)];
    if (!this.shown.plots) return;
    if (!still && now - this.plotted < pause) return void (this.drawn = null); // another picture has them
    this.plotted = now;
    this.plots.draw(this.time);
  }

  // Where the parts of the last picture have a motion's centre of mass, from the left and the top of its part, 0 to 1.
  places() {
    return this.seen.flatMap(({ matrix, coms }) => coms.map((com) => onScreen(matrix, com, 1, 1)));
  }

  // What the page holds now.
  state() {
    const biped = this.bipeds[this.selected], moment = biped.moment(this.time);
    return { time: this.time, end: this.end, frame: moment.frame, frames: biped.frames, playing: this.playing,
      speed: this.speed, shown: { ...this.shown }, selected: this.selected, group: this.shownGroup, words: this.words,
      panels: this.plots.panels.length, rowHeight: this.plots.each, curves: this.plots.boxes.reduce((sum, box) => sum + box.lines.length, 0),
      bipeds: this.bipeds.length, shade: this.shades.name, places: this.places(), counts: this.renderer.counts(), com: biped.com(moment), target: this.camera.target,
      camera: this.camera.state(), followed: this.followed ? this.followed.biped.doll.names[this.followed.body] : "", pictures: this.pictures, received: this.live?.received,
      fps: this.marks.filter((mark) => mark > performance.now() - 1000).length };
  }
}

// Whether whoever looks has asked for little motion: a film is begun by hand then.
function calm() {
  return window.matchMedia("(prefers-reduced-motion: reduce)").matches;
}

// What the address asks for: that of the page around this one, where this one has none of its own. A notebook may not
// let it be read.
function asksFor() {
  try {
    const around = location.protocol === "about:" ? parent.location : location;
    return new URLSearchParams(around.search);
  } catch {
    return new URLSearchParams();
  }
}

async function begin() {
  const text = (id) => document.getElementById(id).textContent;
  const content = JSON.parse(new TextDecoder().decode(await inflate(text("content"))));
  const player = new Player(content, await unpack(content.table, text("arrays")));
  const names = ["play", "seek", "frame", "setSpeed", "show", "choose", "group", "find", "overlay", "look", "fit", "zoom", "turn", "followBody", "pickAt", "describe", "state"];
  Object.assign(window.warpmuscle, Object.fromEntries(names.map((name) => [name, (...given) => player[name](...given)])));
  return player.state();
}

function tell(text) {
  const message = document.getElementById("message");
  message.style.display = text ? "block" : "none";
  message.textContent = text;
}

window.warpmuscle = {};
window.warpmuscle.ready = begin().catch((error) => {
  tell(String(error.message || error));
  throw error;
});
