// All numbers of the running scene, found by words, each with a slider once it is looked for; undo, and saving.

const FEW_ROWS = 60; // that a search shows at once
const TOLD = 6000; // ms that it says why something was refused

class Editor {
  constructor(live, spec, side) {
    Object.assign(this, { live, spec, rows: new Map(), saving: false, copying: false });
    this.values = spec.numbers.map((number) => number.value);
    this.curves = spec.curves.map(({ at, along }) => ({ at, along }));
    this.moved = new Set();
    this.bent = new Set();
    this.groups = spec.groups.map((name) => ({ name, items: [] }));
    const item = (kind) => (one, index) => this.groups[one.group].items.push({ kind, index, text: plainText(`${this.groups[one.group].name} ${one.name} ${one.key}`) });
    spec.curves.forEach(item("curve"));
    spec.numbers.forEach(item("number"));
    this.makeSection(side);
    this.curve = spec.curves.length ? new CurveEditor(this, document.getElementById("editor")) : null;
    window.addEventListener("keydown", (event) => {
      const typing = /^(number|search)$/.test(event.target.type);
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || typing) return;
      this.say(event.shiftKey ? "redo" : "undo");
      event.preventDefault();
    });
  }

  say(edit, more = {}) {
    this.live.say({ edit, ...more });
  }

  makeSection(side) {
    const make = (parent, tag, properties) => parent.appendChild(Object.assign(document.createElement(tag), properties));
    const section = document.createElement("details"), summary = make(section, "summary", { textContent: "All numbers" });
    section.id = "numbers";
    side.insertBefore(section, [...side.children].find((one) => one.firstChild.textContent === "Parameters") ?? null);
    this.count = make(summary, "small", {});
    const tools = make(section, "div", { className: "row tools" });
    const button = (text, title, act) => make(tools, "button", { textContent: text, title, onclick: act });
    this.undo = button("undo", "take the last change back (ctrl z)", () => this.say("undo"));
    this.redo = button("redo", "make it again (ctrl shift z)", () => this.say("redo"));
    this.back = button("all back", "the scene's own numbers and curves again", () => this.say("back"));
    button("save as a scene", "a TOML file with all numbers as they are now", () => {
      this.saving = true;
      this.say("save");
    });
    button("copy as --set", "a command with all that was changed", () => this.ask("settings"));
    this.box = make(section, "input", { type: "search", placeholder: `find one of ${this.spec.numbers.length + this.spec.curves.length} by words`, ariaLabel: "find a number or a curve" });
    this.box.oninput = () => this.filter();
    this.more = make(section, "p", { hidden: true });
    for (const group of this.groups) {
      group.element = make(section, "details", { className: "group" });
      make(group.element, "summary", { textContent: group.name });
      group.element.addEventListener("toggle", () => group.element.open && this.build(group));
    }
    section.addEventListener("toggle", () => {
      document.querySelector("main").classList.toggle("tuning", section.open);
      if (section.open) section.scrollIntoView({ block: "start" });
    });
    this.showCount();
  }

  // Rows of a group, made when they are to be seen first.
  build(group) {
    if (group.built) return;
    group.built = true;
    for (const item of group.items) {
      item.row = item.kind === "curve" ? this.curveRow(item.index) : this.numberRow(item.index);
      item.row.hidden = item.absent ?? false;
      group.element.appendChild(item.row);
    }
  }

  // Show only what holds all words, opened, as long as it is not too much.
  filter() {
    const words = plainText(this.box.value).split(/\s+/).filter(Boolean);
    let room = FEW_ROWS, left = 0;
    for (const group of this.groups) {
      const found = group.items.filter((item) => words.every((word) => item.text.includes(word)));
      const open = words.length > 0 && found.length > 0 && found.length <= room;
      for (const item of group.items) {
        item.absent = !found.includes(item);
        if (item.row) item.row.hidden = item.absent;
      }
      group.element.hidden = !found.length;
      if (open) this.build(group);
      if (open || !words.length) group.element.open = open;
      if (open) room -= found.length;
      else if (words.length) left += found.length;
    }
    const none = words.length > 0 && room === FEW_ROWS && !left;
    this.more.hidden = !none && !left;
    this.more.textContent = none ? "nothing is called so" : `${left} more are in closed groups`;
  }

  curveRow(index) {
    const { name, unit } = this.spec.curves[index], row = document.createElement("div");
    row.className = "row";
    const button = row.appendChild(document.createElement("button"));
    button.textContent = `curve: ${name}${unit ? `, ${unit}` : ""}`;
    button.title = this.spec.curves[index].key;
    button.onclick = () => this.curve.open(index, button);
    this.rows.set(`curve ${index}`, () => button.classList.toggle("strong", this.bent.has(index)));
    this.rows.get(`curve ${index}`)();
    return row;
  }

  numberRow(index) {
    const { name, unit, factor, key, min, max, value, follows } = this.spec.numbers[index], row = document.createElement("div");
    row.className = "row";
    row.title = follows ? `${key}: follows ${follows}; once moved it stands alone` : key;
    const label = row.appendChild(document.createElement("span"));
    label.append(`${unit ? `${name}, ${unit}` : name}${follows ? " (follows)" : ""}`);
    const back = label.appendChild(backButton(`back to the scene's value, ${shortNumber(value * factor)}`, () => this.say("number", { target: index })));
    const show = makeRange(row, `${this.groups[this.spec.numbers[index].group].name}: ${name}`, { min: min * factor, max: max * factor, own: value * factor }, (now, dragged) => {
      if (dragged) this.soon(`number ${index}`, { edit: "number", target: index, value: now / factor });
      else this.say("number", { target: index, value: now / factor });
    });
    this.rows.set(`number ${index}`, () => {
      back.hidden = !this.moved.has(index);
      show(this.values[index] * factor);
    });
    this.rows.get(`number ${index}`)();
    return row;
  }

  soon(key, message) {
    this.live.saySoon(key, message);
  }

  hear({ numbers, curves, moved, bent, undo, redo }) {
    this.values = this.spec.numbers.map((number, index) => numbers[index] ?? number.value);
    this.curves = this.spec.curves.map(({ at, along }, index) => (this.curve?.holds(index) ? this.curves[index] : curves[index] ?? { at, along }));
    this.moved = new Set(moved);
    this.bent = new Set(bent);
    for (const show of this.rows.values()) show();
    this.undo.disabled = !undo;
    this.redo.disabled = !redo;
    this.showCount();
    this.curve?.follow();
  }

  showCount() {
    const changed = this.moved.size + this.bent.size;
    this.count.textContent = changed ? `${changed} changed` : "";
    this.back.disabled = !changed;
  }

  refuse(why) {
    tell(`refused: ${why}`);
    clearTimeout(this.telling);
    this.telling = setTimeout(() => tell(""), TOLD);
  }

  // Ask for text to copy: what was changed as options of a command, or the points of a curve.
  ask(what, target = 0) {
    this.copying = true;
    this.say(what, { target });
  }

  copy(text) {
    if (this.copying) showCopy(text);
    this.copying = false;
  }

  save({ name, text }) {
    if (this.saving) download(name, new Blob([text], { type: "application/toml" }));
    this.saving = false;
  }
}

// Text to take along: it is copied at once where the browser lets it, and can be marked by hand everywhere.
function showCopy(text) {
  const dialog = document.getElementById("copy"), box = dialog.querySelector("textarea"), said = dialog.querySelector("output");
  Object.assign(box, { value: text, rows: Math.min(Math.max(text.split("\n").length, 3), 16) });
  said.textContent = "";
  const copy = () => navigator.clipboard?.writeText(text).then(() => (said.textContent = "copied"), () => (said.textContent = "press ctrl c"));
  dialog.querySelector("button").onclick = copy;
  if (!dialog.open) dialog.showModal();
  box.focus();
  box.select();
  copy();
}

const plainText = (text) => text.toLowerCase().replaceAll(/[_.]/g, " ");
const shortNumber = (number) => Number(Number(number).toPrecision(6));

function backButton(title, act) {
  return Object.assign(document.createElement("button"), { textContent: "\u21ba\ufe0e", title, ariaLabel: title, className: "back", onclick: act, hidden: true });
}

// A slider and a box beside it; returns what shows a number. It reaches as far as any number but its own, such as a limit that limits nothing.
function makeRange(row, name, { min, max, own }, changed) {
  const add = (properties) => row.appendChild(Object.assign(document.createElement("input"), properties));
  const slider = add({ type: "range", min, max, step: (max - min) / 200 || "any", ariaLabel: name });
  const box = add({ type: "number", step: "any", ariaLabel: `${name}, number` });
  let editing = false;
  const show = (now) => {
    if (now < Number(slider.min) && now !== own) slider.min = now;
    if (now > Number(slider.max) && now !== own) slider.max = now;
    slider.value = now;
    if (!editing) box.value = shortNumber(now);
  };
  slider.oninput = () => {
    editing = false;
    box.value = shortNumber(slider.value);
    changed(shortNumber(slider.value), true);
  };
  box.oninput = () => (editing = true);
  box.onchange = () => {
    editing = false;
    if (box.value === "" || !Number.isFinite(Number(box.value))) return;
    slider.value = box.value;
    changed(Number(box.value), false);
  };
  return Object.assign(show, { reach: (low, high) => Object.assign(slider, { min: low, max: high, step: (high - low) / 200 }) });
}
