// What is pressed and typed: buttons, keys, the pointer over the picture, pictures and films.

const TOGGLES = { muscles: "muscles", thickness: "thickness by force", yellow: "blue to yellow", flesh: "skin", bones: "bones", surfaces: "wrapping surfaces", shapes: "contact shapes",
  desired: "desired pose", forces: "ground forces", markers: "markers", path: "centre of mass", labels: "names", norms: "norms", strides: "curves over one stride", follow: "follow", turntable: "turntable", split: "each in its own picture", dark: "dark stage", plots: "plots" };
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];
const KEYS = [
  ["space", "play or pause", [" "], (p) => p.play(!p.playing)],
  ["left, right", "one frame back or on; ten with shift", ["ArrowLeft", "ArrowRight"],
    (p, event) => p.frame((event.key === "ArrowLeft" ? -1 : 1) * (event.shiftKey ? 10 : 1))],
  ["home, end", "to the start or the end", ["Home", "End"], (p, event) => p.seek(event.key === "Home" ? 0 : Infinity)],
  ["-, +", "slower, faster", ["-", "+", "="], (p, event) => p.setSpeed(SPEEDS[SPEEDS.indexOf(p.speed) + (event.key === "-" ? -1 : 1)] ?? p.speed)],
  ["f", "see all", ["f"], (p) => p.fit()],
  ["1 to 5", "from the side, the front, behind, above, three-quarter", ["1", "2", "3", "4", "5"],
    (p, event) => p.look(["side", "front", "back", "top", "oblique"][Number(event.key) - 1])],
  ["m, b, w", "muscles, skin, bones", ["m", "b", "w"], (p, event) => p.flip({ m: "muscles", b: "flesh", w: "bones" }[event.key])],
  ["g, d, n, o", "ground forces, desired pose, norms, one stride", ["g", "d", "n", "o"],
    (p, event) => p.flip({ g: "forces", d: "desired", n: "norms", o: "strides" }[event.key])],
  ["c, k, t, l", "trace of the centre of mass, markers, turntable, light or dark", ["c", "k", "t", "l"],
    (p, event) => p.flip({ c: "path", k: "markers", t: "turntable", l: "dark" }[event.key])],
  ["p", "plots", ["p"], (p) => p.flip("plots")],
  ["/", "find a curve", ["/"], (p) => p.element("search").focus()],
  ["tab", "next control", [], null],
  ["[, ]", "curves of the one before, the next one", ["[", "]"], (p, event) => p.choose((p.selected + (event.key === "]" ? 1 : p.bipeds.length - 1)) % p.bipeds.length)],
  ["r, backspace", "start again", ["r", "Backspace"], (p) => p.restart()],
  ["s", "save a picture", ["s"], (p) => p.savePicture()],
  ["?", "these keys", ["?"], (p) => p.help()],
];

class Controls {
  constructor(player, content) {
    this.player = player;
    this.element = player.element;
    this.makeLegend(content.title);
    this.makeBar();
    this.makeToggles();
    this.makeTools();
    this.makeKeys();
    this.makePointer(this.element("scene"));
  }

  makeLegend(title) {
    this.element("legend").firstChild.textContent = title;
    this.element("legend").firstChild.hidden = window.parent !== window && window.innerWidth < 700; // of a page that has it
  }

  makeBar() {
    const { player } = this;
    const press = { play: () => player.play(!player.playing), back: () => player.frame(-1), ahead: () => player.frame(1),
      again: () => player.restart(), fit: () => player.fit(), picture: () => player.savePicture(), film: () => player.saveFilm(),
      keys: () => player.help() };
    for (const [id, act] of Object.entries(press)) this.element(id).onclick = act;
    this.element("time").oninput = (event) => player.seekPart(Number(event.target.value));
    const options = (id, pairs) => pairs.forEach(([value, text]) => this.element(id).add(new Option(text, value)));
    options("speed", SPEEDS.map((speed) => [speed, `${speed}\u00d7`]));
    this.element("speed").onchange = (event) => player.setSpeed(Number(event.target.value));
    options("selected", player.bipeds.map((biped, k) => [k, biped.label]));
    this.element("selected").onchange = (event) => player.choose(Number(event.target.value));
    this.element("whose").hidden = this.element("several").hidden = player.bipeds.length < 2;
    this.element("several").firstChild.onchange = (event) => player.overlay(event.target.checked);
    this.element("search").oninput = (event) => player.find(event.target.value);
    this.element("stride").hidden = !("strides" in player.shown);
    this.element("stride").firstChild.onchange = (event) => player.show("strides", event.target.checked);
    options("save", [["", "save"], ...Object.keys(SAVES).map((kind) => [kind, kind])]);
    this.element("save").onchange = (event) => player.saveCurves(event.target.value);
    options("from", Object.keys(ANGLES).map((name) => [name, name === "oblique" ? "three-quarter" : name]));
    this.element("from").value = player.bipeds.length > FITTED ? "crowd" : "oblique";
    this.element("from").onchange = (event) => player.look(event.target.value);
  }

  makeToggles() {
    const { player } = this;
    for (const [name, text] of Object.entries(TOGGLES)) {
      if (!(name in player.shown)) continue;
      const label = document.createElement("label");
      label.innerHTML = '<input type="checkbox">';
      label.append(text);
      label.firstChild.onchange = (event) => player.show(name, event.target.checked);
      label.dataset.name = name;
      this.element("toggles").append(label);
    }
    this.element("options").onclick = (event) => {
      const open = this.element("toggles").classList.toggle("open");
      event.currentTarget.setAttribute("aria-expanded", String(open));
    };
  }

  makeTools() {
    this.element("film").hidden = !window.MediaRecorder || !this.element("scene").captureStream || Boolean(this.player.live);
    const rows = KEYS.filter(([key]) => !key.startsWith("r,") || this.player.live);
    for (const [key, text] of rows) {
      const row = this.element("help").querySelector("table").insertRow();
      row.insertCell().textContent = key;
      row.insertCell().textContent = text;
    }
  }

  makeKeys() {
    window.addEventListener("keydown", (event) => {
      const { tagName, type } = event.target;
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      if (event.key === "Escape" && tagName === "INPUT") event.target.blur();
      if (/^(INPUT|SELECT|TEXTAREA)$/.test(tagName) && type !== "checkbox") return;
      if (tagName === "BUTTON" && event.key === " ") return;
      const entry = KEYS.find(([, , keys]) => keys.includes(event.key));
      if (!entry) return;
      entry[3](this.player, event);
      event.preventDefault();
    });
  }

  // Names of what the pointer is over; a click chooses a biped, and the curves of a muscle.
  makePointer(canvas) {
    const { player } = this;
    canvas.addEventListener("pointermove", (event) => {
      if (!event.buttons) this.point(event.offsetX, event.offsetY);
    });
    canvas.addEventListener("pointerleave", () => this.point(null));
    canvas.addEventListener("dblclick", (event) => player.followBody(player.pickAt(event.offsetX, event.offsetY)));
    canvas.addEventListener("click", (event) => {
      if (player.camera.dragged(event)) return;
      const found = player.pickAt(event.offsetX, event.offsetY);
      if (!found) return;
      player.choose(player.bipeds.indexOf(found.biped));
      if (found.muscle !== undefined) player.find(found.name);
    });
  }

  point(x, y) {
    const { player } = this, tip = this.element("tip"), found = x === null ? null : player.pickAt(x, y);
    tip.hidden = !found;
    this.element("scene").classList.toggle("over", Boolean(found));
    player.renderer.chosen = found?.muscle === undefined ? -1 : found.biped.first.muscles + found.muscle;
    if (!found) return;
    tip.textContent = player.describe(found);
    const right = x > 0.6 * this.element("scene").clientWidth;
    Object.assign(tip.style, { left: right ? "" : `${x + 14}px`, right: right ? `${this.element("scene").clientWidth - x + 14}px` : "", top: `${y + 10}px` });
  }
}

function download(name, blob) {
  const link = document.createElement("a");
  Object.assign(link, { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

// A film of what a canvas shows until it is stopped, as WebM.
function startFilm(canvas, onEnd) {
  const film = new MediaRecorder(canvas.captureStream(), { mimeType: "video/webm", videoBitsPerSecond: 8e6 }), parts = [];
  film.ondataavailable = (event) => parts.push(event.data);
  film.onstop = () => onEnd(new Blob(parts, { type: "video/webm" }));
  film.start();
  return film;
}
