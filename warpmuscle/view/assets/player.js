// The page: time, camera, controls, and `window.warpmuscle` for scripts.

const TOGGLES = { muscles: "muscles", shapes: "shapes", bones: "bones", desired: "desired pose", forces: "ground forces",
  path: "centre of mass", follow: "follow", plots: "plots" };
const FEW_LABELS = 16; // beyond which only the chosen biped has one
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

class Player {
  constructor(content, arrays) {
    this.element = (id) => document.getElementById(id);
    this.renderer = new Renderer(this.element("scene"), content.ground, content.tracks.length);
    this.bipeds = content.tracks.map((track) => new Biped(track, arrays, content.dolls[track.doll], this.renderer));
    this.end = Math.max(...this.bipeds.map((biped) => biped.arrays.time[biped.frames - 1]), 1e-6);
    this.step = this.end / Math.max(1, ...this.bipeds.map((biped) => biped.frames - 1));
    Object.assign(this, { time: 0, playing: content.autoplay, speed: 1, selected: 0, pictures: 0, marks: [] });
    this.shown = { ...content.shown };
    this.camera = { ...content.camera, pan: [0, 0, 0], target: null };
    this.plots = new Plots(this.element("curves"), (time) => this.seek(time));
    this.makeControls(content);
    this.makeCamera(this.element("scene"));
    this.choose(0);
    this.group(this.groups()[0]);
    requestAnimationFrame((now) => this.tick(now));
  }

  makeControls(content) {
    this.element("legend").innerHTML = "<b></b>";
    this.element("legend").firstChild.textContent = content.title;
    if (this.bipeds.some((biped) => biped.doll.muscles.names.length)) {
      const colors = [0, 0.25, 0.5, 0.75, 1].map((x) => `rgb(${plasma(x).map((v) => Math.round(255 * v))})`);
      const scale = document.createElement("span");
      scale.innerHTML = `activation 0<i style="background:linear-gradient(90deg,${colors})"></i>1, thick by force`;
      this.element("legend").append(scale);
    }
    this.element("play").onclick = () => this.play(!this.playing);
    this.element("back").onclick = () => this.frame(-1);
    this.element("ahead").onclick = () => this.frame(1);
    this.element("time").oninput = (event) => this.seek(Number(event.target.value) * this.end);
    const options = (id, pairs) => pairs.forEach(([value, text]) => this.element(id).add(new Option(text, value)));
    options("speed", SPEEDS.map((speed) => [speed, `${speed}\u00d7`]));
    this.element("speed").onchange = (event) => this.setSpeed(Number(event.target.value));
    options("selected", this.bipeds.map((biped, k) => [k, biped.label]));
    this.element("selected").onchange = (event) => this.choose(Number(event.target.value));
    this.element("whose").hidden = this.bipeds.length < 2;
    for (const [name, text] of Object.entries(TOGGLES)) {
      if (!(name in this.shown)) continue;
      const label = document.createElement("label");
      label.innerHTML = '<input type="checkbox">';
      label.append(text);
      label.firstChild.onchange = (event) => this.show(name, event.target.checked);
      label.dataset.name = name;
      this.element("toggles").append(label);
    }
    this.labels = this.bipeds.length > 1 ? this.bipeds.map((biped) => {
      const label = this.element("labels").appendChild(document.createElement("span"));
      label.textContent = biped.label;
      return label;
    }) : [];
    window.addEventListener("keydown", (event) => {
      if (/^(INPUT|SELECT)$/.test(event.target.tagName) && event.target.type !== "checkbox") return;
      const act = { " ": () => this.play(!this.playing), ArrowLeft: () => this.frame(-1), ArrowRight: () => this.frame(1) };
      if (act[event.key]) {
        act[event.key]();
        event.preventDefault();
      }
    });
    this.setSpeed(1);
    Object.keys(this.shown).forEach((name) => this.show(name, this.shown[name]));
    this.play(this.playing);
  }

  makeCamera(canvas) {
    canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) return;
      const c = this.camera;
      if (event.buttons & 2 || event.shiftKey) {
        const s = (0.0012 * c.distance), right = [-Math.cos(c.yaw), 0, Math.sin(c.yaw)];
        c.pan = add(c.pan, add(times(right, event.movementX * s), [0, event.movementY * s, 0]));
      } else {
        c.yaw -= 0.006 * event.movementX;
        c.pitch = Math.min(Math.max(c.pitch + 0.006 * event.movementY, -0.1), 1.5);
      }
    });
    canvas.addEventListener("wheel", (event) => {
      this.camera.distance = Math.min(Math.max(this.camera.distance * Math.exp(0.001 * event.deltaY), 0.3), 120);
      event.preventDefault();
    }, { passive: false });
  }

  play(on) {
    this.playing = on;
    if (on && this.time >= this.end) this.time = 0;
    this.element("play").textContent = on ? "\u275a\u275a" : "\u25b6\ufe0e";
  }

  seek(time) {
    this.time = Math.min(Math.max(time, 0), this.end);
  }

  frame(count) {
    this.play(false);
    this.seek((Math.round(this.time / this.step) + count) * this.step);
  }

  setSpeed(speed) {
    this.speed = speed;
    this.element("speed").value = String(speed);
  }

  show(name, on) {
    this.shown[name] = on;
    const label = this.element("toggles").querySelector(`[data-name="${name}"] input`);
    if (label) label.checked = on;
    if (name === "plots") {
      this.element("plots").classList.toggle("hidden", !on);
      this.plots.layout();
    }
    if (name === "follow" && on) this.camera.target = null;
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
    const key = nav.appendChild(document.createElement("span"));
    key.innerHTML = '<span style="color:#0072b2">left</span> <span style="color:#d55e00">right</span>';
    this.group(this.groups().includes(this.shownGroup) ? this.shownGroup : this.groups()[0]);
  }

  groups() {
    return [...new Set(this.bipeds[this.selected].panels.map((panel) => panel.group))];
  }

  group(name) {
    this.shownGroup = name;
    for (const button of this.element("groups").querySelectorAll("button"))
      button.classList.toggle("chosen", button.textContent === name);
    this.plots.show(this.bipeds[this.selected], name, this.end);
  }

  // The point that the camera looks at: the mean of all centres of mass, at a steady height.
  middle() {
    const places = this.bipeds.map((biped) => biped.com(biped.moment(this.time)));
    const mean = times(places.reduce(add), 1 / places.length);
    if (this.shown.follow || !this.camera.target) this.camera.target = mean;
    const height = this.camera.height ??= mean[1] - 0.08;
    return [this.camera.target[0], height, this.camera.target[2]];
  }

  tick(now) {
    const passed = this.last === undefined ? 0 : Math.min((now - this.last) / 1000, 0.25);
    if (this.last !== undefined && this.playing) this.renderer.adapt(now - this.last);
    this.last = now;
    if (this.playing) {
      this.time += passed * this.speed;
      if (this.time > this.end) this.time = this.time % this.end;
    }
    const picture = this.pictureKey();
    if (picture !== this.drawn) {
      this.drawn = picture;
      this.draw();
      this.pictures++;
      this.marks = [...this.marks.filter((mark) => mark > now - 1000), now];
    }
    requestAnimationFrame((next) => this.tick(next));
  }

  // All that a picture depends on, so that nothing is drawn twice.
  pictureKey() {
    const { clientWidth, clientHeight } = this.renderer.canvas, { yaw, pitch, distance, pan } = this.camera;
    const { time, playing, shown, selected, shownGroup, plots } = this;
    return JSON.stringify([time, playing, shown, selected, shownGroup, yaw, pitch, distance, pan, clientWidth, clientHeight,
      plots.canvas.parentElement.clientWidth, plots.canvas.parentElement.clientHeight]);
  }

  draw() {
    const aspect = this.renderer.resize(!this.playing), c = this.camera;
    const middle = add(this.middle(), c.pan);
    const way = [Math.sin(c.yaw) * Math.cos(c.pitch), Math.sin(c.pitch), Math.cos(c.yaw) * Math.cos(c.pitch)];
    const eye = add(middle, times(way, c.distance));
    eye[1] = Math.max(eye[1], 0.05);
    const matrix = product(perspective(0.62, aspect, 0.1, 300), lookAt(eye, middle));
    this.renderer.clear();
    for (const biped of this.bipeds) biped.draw(this.renderer, this.time, this.shown);
    this.renderer.draw(matrix, eye, middle);
    this.drawLabels(matrix);
    if (this.shown.plots) this.plots.draw(this.time);
    this.element("time").value = String(this.time / this.end);
    this.element("clock").textContent = `${this.time.toFixed(2)} / ${this.end.toFixed(2)} s`;
  }

  drawLabels(matrix) {
    const { clientWidth, clientHeight } = this.renderer.canvas;
    this.labels.forEach((label, k) => {
      const biped = this.bipeds[k], com = biped.com(biped.moment(this.time));
      const at = onScreen(matrix, add(com, [0, 0.9, 0]), clientWidth, clientHeight);
      label.hidden = !at || (this.labels.length > FEW_LABELS && k !== this.selected);
      if (at) Object.assign(label.style, { left: `${at[0]}px`, top: `${at[1]}px` });
    });
  }

  // What the page holds now.
  state() {
    const biped = this.bipeds[this.selected], moment = biped.moment(this.time);
    return { time: this.time, end: this.end, frame: moment.frame, frames: biped.frames, playing: this.playing,
      speed: this.speed, shown: { ...this.shown }, selected: this.selected, group: this.shownGroup,
      panels: this.plots.panels.length, bipeds: this.bipeds.length, counts: this.renderer.counts(),
      com: biped.com(moment), target: this.camera.target, pictures: this.pictures,
      fps: this.marks.filter((mark) => mark > performance.now() - 1000).length };
  }
}

async function begin() {
  const content = JSON.parse(document.getElementById("content").textContent);
  const player = new Player(content, await unpack(content.table, document.getElementById("arrays").textContent));
  const names = ["play", "seek", "frame", "setSpeed", "show", "choose", "group", "state"];
  Object.assign(window.warpmuscle, Object.fromEntries(names.map((name) => [name, (...given) => player[name](...given)])));
  return player.state();
}

window.warpmuscle = {};
window.warpmuscle.ready = begin().catch((error) => {
  const message = document.getElementById("message");
  message.style.display = "flex";
  message.textContent = String(error.message || error);
  throw error;
});
