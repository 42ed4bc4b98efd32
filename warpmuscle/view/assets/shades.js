// By what bodies are coloured: how active their muscles are, or what is known of each as a whole.

// Low to high: parts of viridis (Smith and van der Walt 2015) that are neither black nor white.
const RAMP = [[0.231, 0.322, 0.545], [0.173, 0.443, 0.557], [0.153, 0.678, 0.506], [0.478, 0.82, 0.318], [0.741, 0.875, 0.149]];
const UNKNOWN_TINT = [0.62, 0.64, 0.66], WENT_ON = [0, 0.447, 0.698], FAILED = [0.835, 0.369, 0]; // Okabe and Ito (2008)
const WIDE = 20; // the greatest cost in the least one, from which on colours are logarithmic
const MOST_NEAR = 8, NEAR_TALL = 100, STAYS_NEAR = 0.85; // bodies; px; of that size, down to which one stays near
const STATURE = 1.75; // m, of a body of 75 kg
const WORST_SHOWN = 0.9; // of costs of those that did not fail, from which on all are the last colour

class Shades {
  constructor(player, { known, first }) {
    Object.assign(this, { player, known });
    const priced = player.bipeds.filter((biped) => biped.cost !== undefined), upright = priced.filter((biped) => !biped.ended);
    const costs = (upright.length > 1 ? upright : priced).map((biped) => biped.cost).sort((a, b) => a - b);
    this.costs = [costs[0], costs[Math.floor(WORST_SHOWN * (costs.length - 1))]];
    this.failed = player.bipeds.filter((biped) => biped.ended).length;
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
    for (const biped of bipeds) biped.near = false;
    this.addFigures();
    this.draw(this.player.element("scale"));
    this.player.drawn = null;
  }

  addFigures() {
    this.player.renderer.clearFigures();
    for (const biped of this.player.bipeds) biped.addFigure();
  }

  // Draw the muscles of those that are seen largest, where bodies are coloured as a whole.
  showNear(views) {
    const { renderer, bipeds, shown, time } = this.player, inside = ([x, y]) => x > 0 && x < 1 && y > 0 && y < 1;
    if (!renderer.shaded) return;
    const sized = views.flatMap(({ matrix, pixels, bipeds: seen, coms }) => seen.map((biped, k) => {
      const at = onScreen(matrix, coms[k], 1, 1), depth = at && inside(at) ? at[2] : Infinity;
      const tall = (STATURE * biped.doll.scale * pixels[3]) / (2 * depth * Math.tan(OPENING / 2));
      return [biped.near ? tall / STAYS_NEAR : tall, biped];
    }));
    const large = shown.muscles ? sized.filter(([tall, one]) => tall > NEAR_TALL && one.arrays.activation).sort((a, b) => b[0] - a[0]) : [];
    const near = new Set(large.slice(0, MOST_NEAR).map(([, biped]) => biped)), fresh = bipeds.filter((one) => near.has(one) !== one.near);
    if (!fresh.length) return;
    for (const biped of fresh) biped.near = near.has(biped);
    this.addFigures();
    for (const biped of near) biped.updateMuscles(biped.moment(time), shown);
    this.draw(this.player.element("scale"));
  }

  // The colour of a whole body.
  tint({ cost, rank, ended }) {
    if (this.name === "condition") return ended ? FAILED : WENT_ON;
    if (cost === undefined) return UNKNOWN_TINT;
    if (ended) return FAILED; // what it costs is not of the same kind
    const [low, high] = this.costs, wide = low > 0 && high > WIDE * low; // some fell where they were disturbed, say
    const priced = wide ? Math.log(cost / low) / Math.log(high / low) : (cost - low) / (high - low || 1);
    const part = this.name === "rank" ? (rank - 1) / Math.max(this.player.bipeds.length - 1, 1) : priced;
    const place = 4 * Math.min(Math.max(part, 0), 1), k = Math.min(Math.floor(place), 3);
    return RAMP[k].map((from, i) => from + (place - k) * (RAMP[k + 1][i] - from));
  }

  // The legend: a scale with its ends, or a colour a word.
  draw(element) {
    element.hidden = !this.name;
    if (!this.name) return;
    const css = (color) => `rgb(${color.map((part) => Math.round(255 * part))})`, short = (number) => String(Number(number.toPrecision(3)));
    const of_muscles = ["0", "0.5", "1"], ends = { activation: of_muscles, rank: ["best", "", "worst"], cost: [short(this.costs[0] ?? 0), "", `${short(this.costs[1] ?? 0)} or more`] }[this.name];
    const line = (tag, ...texts) => Object.assign(document.createElement(tag), { textContent: texts[0] ?? "" });
    const addScale = (ramp, texts) => {
      const bar = element.appendChild(line("i")), row = element.appendChild(line("u"));
      bar.style.background = `linear-gradient(90deg,${ramp.map(css)})`;
      texts.forEach((text) => row.append(line("span", text)));
    };
    const activations = ACTIVATIONS[Number(this.player.renderer.yellow)];
    element.replaceChildren(this.name);
    if (ends) addScale(this.name === "activation" ? activations : RAMP, ends);
    const words = ends ? [] : [[WENT_ON, `${this.player.bipeds.length - this.failed} went on`]];
    if (!ends || (this.name !== "activation" && this.failed)) words.push([FAILED, `${this.failed} failed`]);
    for (const [color, text] of words) {
      const row = element.appendChild(line("em")), mark = row.appendChild(line("s"));
      mark.style.background = css(color);
      row.append(text);
    }
    if (this.player.bipeds.some((biped) => biped.near)) {
      element.append("activation, of the nearest");
      addScale(activations, of_muscles);
    }
  }
}
