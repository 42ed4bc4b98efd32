// By what bodies are coloured: how active their muscles are, or what is known of each as a whole.

// Low to high: parts of viridis (Smith and van der Walt 2015) that are neither black nor white.
const RAMP = [[0.231, 0.322, 0.545], [0.173, 0.443, 0.557], [0.153, 0.678, 0.506], [0.478, 0.82, 0.318], [0.741, 0.875, 0.149]];
const UNKNOWN_TINT = [0.62, 0.64, 0.66], WENT_ON = [0, 0.447, 0.698], FAILED = [0.835, 0.369, 0]; // Okabe and Ito (2008)
const WORST_SHOWN = 0.9; // of all costs, from which on all are the last colour: those of falls are far away

class Shades {
  constructor(player, { known, first }) {
    Object.assign(this, { player, known });
    const costs = player.bipeds.map((biped) => biped.cost).filter((cost) => cost !== undefined).sort((a, b) => a - b);
    this.costs = [costs[0], costs[Math.floor(WORST_SHOWN * (costs.length - 1))]];
    this.select = player.element("shade");
    this.select.closest("label").hidden = known.length < 2;
    for (const name of known) this.select.add(new Option(name, name));
    this.select.onchange = () => this.choose(this.select.value);
    this.choose(first);
  }

  choose(name) {
    const { renderer, bipeds } = this.player;
    this.select.value = this.name = name;
    renderer.shaded = name === "activation" ? "" : name;
    renderer.shade = (biped) => (renderer.shaded ? this.tint(biped) : null);
    renderer.clearFigures();
    for (const biped of bipeds) biped.addFigure();
    this.draw(this.player.element("scale"));
    this.player.drawn = null;
  }

  // The colour of a whole body.
  tint({ cost, rank, ended }) {
    if (this.name === "condition") return ended ? FAILED : WENT_ON;
    if (cost === undefined) return UNKNOWN_TINT;
    const [low, high] = this.costs, part = this.name === "rank" ? (rank - 1) / Math.max(this.player.bipeds.length - 1, 1) : (cost - low) / (high - low || 1);
    const place = 4 * Math.min(Math.max(part, 0), 1), k = Math.min(Math.floor(place), 3);
    return RAMP[k].map((from, i) => from + (place - k) * (RAMP[k + 1][i] - from));
  }

  // The legend: a scale with its ends, or a colour a word.
  draw(element) {
    element.hidden = !this.name;
    if (!this.name) return;
    const css = (color) => `rgb(${color.map((part) => Math.round(255 * part))})`, short = (number) => String(Number(number.toPrecision(3)));
    const ends = { activation: ["0", "0.5", "1"], rank: ["best", "", "worst"], cost: [short(this.costs[0] ?? 0), "", `${short(this.costs[1] ?? 0)} or more`] }[this.name];
    const line = (tag, ...texts) => Object.assign(document.createElement(tag), { textContent: texts[0] ?? "" });
    element.replaceChildren(this.name);
    if (ends) {
      const bar = element.appendChild(line("i")), row = element.appendChild(line("u"));
      bar.style.background = `linear-gradient(90deg,${(this.name === "activation" ? ACTIVATION : RAMP).map(css)})`;
      ends.forEach((text) => row.append(line("span", text)));
      return;
    }
    const failed = this.player.bipeds.filter((biped) => biped.ended).length;
    for (const [color, text] of [[WENT_ON, `${this.player.bipeds.length - failed} went on`], [FAILED, `${failed} failed`]]) {
      const row = element.appendChild(line("em")), mark = row.appendChild(line("s"));
      mark.style.background = css(color);
      row.append(text);
    }
  }
}
