// A simulation that a server runs: frames come over a socket, and what is moved in the panel goes back.

const EVERY = 50; // ms between two values of a slider that is dragged
const REFRESH = [150, 400]; // ms between two drawings of past and path, with a graphics card and without
const BEHIND = 0.08, LOST = 0.4; // s that pictures are behind the last frame, and beyond which they leap
const AGAIN = 2000; // ms until a lost server is sought again
const FEW_SLIDERS = 8; // beyond which a section has a search box

class Live {
  constructor(player, spec) {
    Object.assign(this, { player, spec, epoch: null, received: 0, rows: [], waiting: new Map(), refreshed: 0 });
    this.biped = player.bipeds[0];
    this.rate = 50;
    this.most = Math.ceil(spec.window * this.rate) + 5; // frames kept
    for (const [name, width] of spec.order) {
      const first = this.biped.arrays[name];
      this.biped.arrays[name] = new Float32Array(2 * this.most * width);
      if (first) this.biped.arrays[name].set(first.subarray(0, width));
      this.biped.widths[name] = width;
    }
    this.width = spec.order.reduce((sum, [, width]) => sum + width, 0);
    player.plots.window = spec.window;
    document.getElementById("again").hidden = false;
    this.makePanel(document.getElementById("side"));
    const editable = spec.edits && spec.edits.numbers.length + spec.edits.curves.length > 0;
    this.editor = editable ? new Editor(this, spec.edits, document.getElementById("side")) : null;
    document.getElementById("side").hidden = !document.getElementById("side").children.length;
    this.pushing = new Pushing(this);
  }

  // Once the page is made: what it sets for itself until then is not for the simulation, nor for its other pages.
  connect() {
    const scheme = location.protocol === "https:" ? "wss" : "ws";
    this.socket = new WebSocket(`${scheme}://${location.host}/`, [this.spec.protocol]);
    this.socket.binaryType = "arraybuffer";
    this.unsaid = [];
    Object.assign(this, { page: 1 + Math.floor(Math.random() * 2 ** 52), count: 0, said: new Map() });
    this.socket.onopen = () => {
      tell("");
      for (const message of this.unsaid.splice(0)) this.say(message);
    };
    this.socket.onmessage = (event) => (typeof event.data === "string" ? this.hear(JSON.parse(event.data)) : this.take(event.data));
    this.socket.onclose = () => {
      tell("The simulation has ended, or cannot be reached. Start it again, and open the address that it prints.");
      setTimeout(() => this.connect(), AGAIN);
    };
  }

  // What is older than what was said since is left out: it would take a hand's change back until that is heard of, too.
  hear({ values, status, push, doll, ground, edits, refused, saved, copied, heard }) {
    const known = heard?.[this.page] ?? 0, fresh = (what) => (this.said.get(what) ?? 0) <= known;
    for (const [number, value] of Object.entries(values ?? {})) if (fresh(Number(number))) this.rows[number]?.(value);
    if (status !== undefined) document.getElementById("status").textContent = status;
    if (edits && fresh("edits") && ![...this.waiting.values()].some((message) => message.edit)) this.editor?.hear(edits);
    if (refused) this.editor?.refuse(refused);
    if (saved) this.editor?.save(saved);
    if (copied) this.editor?.copy(copied);
    if (push) this.pushing.given(push);
    if (ground) this.player.renderer.ground = ground;
    if (doll) {
      Object.assign(this.biped.doll.muscles, doll.muscles);
      Object.assign(this.biped.doll, { ...doll, muscles: this.biped.doll.muscles });
    }
  }

  // Frames, one row each, behind the number of the start that they follow.
  take(buffer) {
    const numbers = new Float32Array(buffer), { biped, player } = this;
    if (numbers[0] !== this.epoch) {
      biped.frames = 0;
      this.epoch = numbers[0];
      player.time = 0;
    }
    for (let at = 1; at + this.width <= numbers.length; at += this.width) this.append(numbers, at);
    player.measure();
    // Where it is known to pause, they are of a step; until then they were on their way, and leave what was sought.
    if ((!player.playing && !this.running) || player.time < player.begin) player.time = player.end;
    this.received++;
  }

  append(numbers, from) {
    const { biped, most } = this;
    if (biped.frames && numbers[from] <= biped.arrays.time[biped.frames - 1]) return; // seen already
    if (biped.frames === 2 * most) {
      for (const [name, width] of this.spec.order) biped.arrays[name].copyWithin(0, (most + 1) * width);
      biped.frames = most - 1;
    }
    let at = from;
    for (const [name, width] of this.spec.order) {
      biped.arrays[name].set(numbers.subarray(at, at + width), biped.frames * width);
      at += width;
    }
    biped.frames++;
  }

  // Follow the frames that come, smoothly, and draw the past anew from time to time.
  advance(passed) {
    const { player } = this, last = player.end, now = performance.now();
    this.editor?.curve?.tick();
    if (player.playing) {
      const wanted = last - BEHIND * player.speed, next = player.time + passed * player.speed;
      const near = next + 0.1 * (wanted - next);
      player.time = Math.abs(wanted - next) > LOST * Math.max(player.speed, 1) ? last : Math.min(Math.max(near, player.begin), last);
    }
    if (now - this.refreshed < REFRESH[Number(player.renderer.slow)] || this.drawn === this.received) return;
    this.refreshed = now;
    this.drawn = this.received;
    player.plots.kept_at = undefined;
    player.renderer.path.clear();
    this.biped.addPath();
  }

  mark() {
    const { biped, player } = this;
    this.pushing.mark(add(biped.between("root", biped.moment(player.time)), biped.offset));
  }

  say(message) {
    this.sayWaiting();
    const { OPEN, CONNECTING } = WebSocket, now = this.socket?.readyState;
    if (now === OPEN) {
      this.said.set(message.edit ? "edits" : message.control, ++this.count);
      this.socket.send(JSON.stringify({ ...message, page: this.page, count: this.count }));
    } else if (now === CONNECTING) this.unsaid.push(message); // the page can be used before
  }

  // The same, of many messages of one key in a short time only the last.
  saySoon(key, message) {
    if (!this.waiting.size) setTimeout(() => this.sayWaiting(), EVERY);
    this.waiting.set(key, message);
  }

  // What waits comes before what is said later.
  sayWaiting() {
    const waiting = [...this.waiting.values()];
    this.waiting.clear();
    for (const message of waiting) this.say(message);
  }

  send(control, value) {
    this.say({ control, value });
  }

  sendSoon(control, value) {
    this.saySoon(control, { control, value });
  }

  play(on) {
    if (this.asked !== on) this.send(this.spec.bar.play, on);
    this.asked = on;
  }

  setSpeed(speed) {
    this.send(this.spec.bar.speed, String(speed));
  }

  // From frame to frame: a page that was behind has missed some. Behind the last one it is simulated.
  frame(count) {
    const { arrays, frames } = this.biped, { frame, part } = this.biped.moment(this.player.time), to = frame + Math.round(part) + count;
    if (to < frames) return this.player.seek(arrays.time[Math.max(to, 0)]);
    this.asked = false;
    this.send(this.spec.bar.step, true);
  }

  restart() {
    this.send(this.spec.bar.again, true);
  }

  makePanel(side) {
    const { bar, controls } = this.spec, sections = new Map(), bars = new Set(Object.values(bar));
    this.rows[bar.play] = (on) => {
      this.asked = this.running = on;
      if (this.player.playing !== on && this.player.controls) this.player.play(on);
    };
    this.rows[bar.speed] = (speed) => {
      this.player.speed = Number(speed);
      document.getElementById("speed").value = speed;
    };
    controls.forEach((control, number) => {
      if (bars.has(number)) return;
      if (!sections.has(control.section)) sections.set(control.section, []);
      sections.get(control.section).push([number, control]);
    });
    for (const [name, entries] of sections) this.makeSection(side, name, entries);
  }

  makeSection(side, name, entries) {
    const section = side.appendChild(document.createElement("details"));
    section.open = entries.length <= 3 * FEW_SLIDERS;
    section.appendChild(document.createElement("summary")).textContent = name;
    const rows = [];
    if (entries.length > FEW_SLIDERS) {
      const box = section.appendChild(document.createElement("input"));
      Object.assign(box, { type: "search", placeholder: `find one of ${entries.length}`, ariaLabel: `find in ${name}` });
      box.oninput = () => this.filter(rows, box.value);
    }
    let group = "";
    for (const [number, control] of entries) {
      if (control.group && control.group !== group) {
        group = control.group;
        const heading = section.appendChild(document.createElement("h3"));
        heading.textContent = group;
        rows.push({ element: heading, text: group.toLowerCase(), heading: true, group });
      }
      const element = section.appendChild(this.makeRow(number, control));
      rows.push({ element, text: `${control.hint} ${control.name}`.toLowerCase(), group: control.group });
    }
  }

  // Show only rows whose names hold all words, and the headings over them.
  filter(rows, text) {
    const words = text.toLowerCase().split(/\s+/).filter(Boolean), groups = new Set();
    for (const row of rows.filter((one) => !one.heading)) {
      row.element.hidden = !words.every((word) => row.text.includes(word));
      if (!row.element.hidden) groups.add(row.group);
    }
    for (const row of rows.filter((one) => one.heading)) row.element.hidden = !groups.has(row.group);
  }

  makeRow(number, control) {
    const row = document.createElement(control.kind === "button" ? "div" : "label");
    row.className = "row";
    row.title = control.hint;
    const add = (tag, properties) => row.appendChild(Object.assign(document.createElement(tag), properties));
    if (control.kind === "button") {
      add("button", { textContent: control.name, className: control.section === "Push" ? "strong" : "", onclick: () => this.send(number, true) });
    } else if (control.kind === "toggle") {
      const name = add("span", {}), box = name.appendChild(Object.assign(document.createElement("input"), { type: "checkbox", checked: control.value }));
      name.append(control.name);
      box.onchange = () => this.send(number, box.checked);
      this.rows[number] = (value) => (box.checked = value);
    } else {
      add("span", { textContent: control.unit ? `${control.name}, ${control.unit}` : control.name });
      if (control.kind === "choice") {
        const menu = add("select", { ariaLabel: control.name });
        control.options.forEach((option) => menu.add(new Option(option, option)));
        menu.value = control.value;
        menu.onchange = () => this.send(number, menu.value);
        this.rows[number] = (value) => (menu.value = value);
      } else this.makeSlider(number, control, add);
    }
    return row;
  }

  makeSlider(number, { name, min, max, step, value }, add) {
    const bounds = { min, max, step: "any" };
    const slider = add("input", { type: "range", ...bounds, step, ariaLabel: name }), box = add("input", { type: "number", ...bounds, ariaLabel: `${name}, number` });
    let editing = false; // what is being typed stays as it is
    const show = (now) => {
      if (now < Number(slider.min)) slider.min = box.min = now; // its number was edited farther
      if (now > Number(slider.max)) slider.max = box.max = now;
      slider.value = now;
      if (!editing) box.value = Number(Number(now).toPrecision(5));
    };
    show(value);
    slider.oninput = () => {
      editing = false;
      show(slider.value);
      this.sendSoon(number, Number(slider.value));
    };
    box.oninput = () => (editing = true);
    box.onchange = () => {
      editing = false;
      if (box.value !== "" && Number.isFinite(Number(box.value))) this.send(number, Number(box.value));
    };
    this.rows[number] = (now) => {
      if (!this.waiting.has(number)) show(now);
    };
  }
}
