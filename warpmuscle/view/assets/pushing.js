// A push by hand: drag from a body, with ctrl or while `push` is on, and let go; the longer the drag, the harder.

const PUSH_SEEN = 600, PUSH_LENGTH = 0.01; // ms that a push is seen; m per N s
const LEAST_PUSH = 0.5; // N s

class Pushing {
  constructor(live) {
    const { player } = live, button = document.getElementById("push");
    Object.assign(this, { live, player, on: false, tip: document.getElementById("tip") });
    button.hidden = false;
    button.onclick = () => {
      this.on = !this.on;
      button.classList.toggle("on", this.on);
      button.setAttribute("aria-pressed", String(this.on));
    };
    player.camera.taken = (event) => this.begin(event);
    player.camera.canvas.addEventListener("pointermove", (event) => event.pointerId === this.pointer && this.drag(event));
    player.camera.canvas.addEventListener("pointerup", (event) => event.pointerId === this.pointer && this.end(true));
    player.camera.canvas.addEventListener("pointercancel", (event) => event.pointerId === this.pointer && this.end(false));
    window.addEventListener("keydown", (event) => event.key === "Escape" && this.end(false));
  }

  // Whether a pointer that is pressed begins a push, and so does not turn the camera.
  begin(event) {
    if (this.pointer !== undefined || event.button !== 0 || !(this.on || event.ctrlKey)) return false;
    if (!this.player.pickAt(event.offsetX, event.offsetY)) return false;
    Object.assign(this, { pointer: event.pointerId, from: [event.clientX, event.clientY], impulse: [0, 0, 0] });
    return true;
  }

  drag(event) {
    const { camera, renderer } = this.player, { right, up } = camera.axes();
    const scale = (2 * camera.distance * Math.tan(OPENING / 2)) / Math.max(renderer.canvas.clientHeight, 1) / PUSH_LENGTH;
    const [dx, dy] = [event.clientX - this.from[0], event.clientY - this.from[1]];
    const impulse = add(times(right, scale * dx), times(up, -scale * dy)), size = norm(impulse), { hardest } = this.live.spec;
    this.impulse = times(impulse, size > hardest ? hardest / size : 1);
    const area = renderer.canvas.getBoundingClientRect(), [x, y] = [event.clientX - area.left, event.clientY - area.top];
    Object.assign(this.tip, { hidden: false, textContent: `${norm(this.impulse).toFixed(0)} N s` });
    Object.assign(this.tip.style, { left: `${Math.min(x + 14, area.width - 70)}px`, right: "", top: `${y + 10}px` });
  }

  end(done) {
    if (this.pointer === undefined) return;
    const { impulse } = this;
    this.pointer = this.player.camera.pressed = undefined;
    this.tip.hidden = true;
    this.player.drawn = null;
    if (done && norm(impulse) > LEAST_PUSH) this.live.say({ push: impulse });
  }

  // A push was given, N s.
  given(impulse) {
    this.last = { impulse, until: performance.now() + PUSH_SEEN };
  }

  // What is to be seen of it: an arrow from the root while it is dragged, and for a moment to the root when it was given.
  mark(root) {
    const { player } = this;
    if (this.pointer !== undefined) this.arrow(root, times(this.impulse, PUSH_LENGTH));
    else if (this.last && performance.now() <= this.last.until) {
      const along = times(this.last.impulse, PUSH_LENGTH);
      this.arrow(minus(root, add(along, times(unit(along), 0.15))), along); // whose head is not within the body
    } else return;
    player.drawn = null;
  }

  arrow(from, along) {
    if (norm(along) > 0) arrow(this.player.renderer, from, along, PUSH_TINT);
  }
}
