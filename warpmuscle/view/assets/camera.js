// Where the picture is seen from: turned, moved and zoomed by mouse, fingers and keys, or fitted to what there is.

const OPENING = 0.55; // rad, from the lower to the upper edge of the picture
const ANGLES = { side: [-Math.PI / 2, 0.05], front: [0, 0.05], back: [Math.PI, 0.05], top: [-Math.PI / 2, 1.5], oblique: [-0.95, 0.16], crowd: [-0.55, 0.3] };
// Of pictures and of narrow ones, where controls and title lie over them: factors of what is fitted, across and up, and
// how far it is below the middle.
const ROOM = { wide: [1.12, 1.14, 0.03], narrow: [1.12, 1.3, 0.1] }, NARROW = 420; // px
const WHEEL_CALM = 250; // ms after which the wheel is at rest
const TURNTABLE = 0.5; // rad/s

class Camera {
  constructor(canvas, angles) {
    Object.assign(this, { canvas, distance: 4, pan: [0, 0, 0], target: [0, 1, 0], follow: true, moved: null, fingers: new Map() });
    this.look(angles);
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const name of ["pointerup", "pointercancel"])
      canvas.addEventListener(name, (event) => this.fingers.delete(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      this.zoom(Math.exp(0.001 * event.deltaY));
      this.wheeled = performance.now();
      event.preventDefault();
    }, { passive: false });
  }

  look([yaw, pitch]) {
    Object.assign(this, { yaw, pitch });
  }

  press(event) {
    if (this.taken?.(event)) return void this.canvas.setPointerCapture(event.pointerId);
    this.canvas.setPointerCapture(event.pointerId);
    this.fingers.set(event.pointerId, [event.clientX, event.clientY]);
    this.pressed = { x: event.clientX, y: event.clientY };
  }

  // One finger turns; two zoom and move, and so does the mouse with shift or its right button.
  drag(event) {
    const before = this.fingers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY], dx = now[0] - before[0], dy = now[1] - before[1];
    if (this.fingers.size === 2) {
      const other = [...this.fingers].find(([id]) => id !== event.pointerId)[1];
      const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]);
      this.zoom(apart(before) / Math.max(apart(now), 1));
      this.move(dx / 2, dy / 2);
    } else if (event.buttons & 2 || event.shiftKey) this.move(dx, dy);
    else this.turn(-0.006 * dx, 0.006 * dy);
    this.fingers.set(event.pointerId, now);
  }

  // Whether a hand is at it, so that pictures are to come fast.
  busy() {
    return this.turntable || this.fingers.size > 0 || performance.now() - (this.wheeled ?? -WHEEL_CALM) < WHEEL_CALM;
  }

  // Whether a pointer has moved since it was pressed, so that its release is no click.
  dragged(event) {
    return !this.pressed || Math.hypot(event.clientX - this.pressed.x, event.clientY - this.pressed.y) > 4;
  }

  turn(yaw, pitch) {
    this.touched = true;
    this.yaw += yaw;
    this.pitch = Math.min(Math.max(this.pitch + pitch, -0.3), 1.55);
  }

  move(dx, dy) {
    this.touched = true;
    const { right, up } = this.axes(), scale = (2 * this.distance * Math.tan(OPENING / 2)) / Math.max(this.canvas.clientHeight, 1);
    this.pan = add(this.pan, add(times(right, -dx * scale), times(up, dy * scale)));
  }

  zoom(factor) {
    this.touched = true;
    this.distance = Math.min(Math.max(this.distance * factor, 0.2), 400);
  }

  axes() {
    const back = [Math.sin(this.yaw) * Math.cos(this.pitch), Math.sin(this.pitch), Math.cos(this.yaw) * Math.cos(this.pitch)];
    const right = [Math.cos(this.yaw), 0, -Math.sin(this.yaw)];
    return { right, up: cross(back, right), back };
  }

  // Go where points are all seen, in a picture of the given shape and width, a part of which is covered from the top;
  // `middle` is what is followed.
  fit(points, middle, aspect, wide, top) {
    const { right, up, back } = this.axes(), reach = (axis) => points.map((p) => dot(p, axis));
    let center = [right, up, back].reduce((sum, axis) => {
      const along = reach(axis);
      return add(sum, times(axis, (Math.min(...along) + Math.max(...along)) / 2));
    }, [0, 0, 0]);
    const steep = Math.tan(OPENING / 2), [across, tall, below] = wide < NARROW && aspect < 1 ? ROOM.narrow : ROOM.wide;
    this.distance = Math.max(0.3, ...points.map((p) => {
      const away = minus(p, center), x = across * Math.abs(dot(away, right)), y = (tall / (1 - top)) * Math.abs(dot(away, up));
      return dot(away, back) + Math.max(x / (steep * aspect), y / steep);
    }));
    center = add(center, times(up, (below + top) * this.distance * steep));
    this.pan = minus(center, middle);
    this.touched = false;
    this.target = middle;
  }

  // The matrix of the picture, the eye and what it looks at, when the middle of all is somewhere.
  view(middle, aspect) {
    if (this.follow) this.target = [middle[0], this.target[1], middle[2]];
    const at = add(this.target, this.pan), eye = add(at, times(this.axes().back, this.distance));
    if (eye[1] < 0.03 && at[1] > 0) eye[1] = 0.03; // not from below the ground
    const far = Math.max(300, 3 * this.distance), matrix = product(perspective(OPENING, aspect, far / 6000, far), lookAt(eye, at));
    return { matrix, eye, at };
  }

  state() {
    const { yaw, pitch, distance, pan, target } = this;
    return { yaw, pitch, distance, pan: [...pan], target: [...target] };
  }
}
