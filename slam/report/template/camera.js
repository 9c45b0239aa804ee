// A camera that circles a target; z is up. Left drag turns, right drag or shift moves, wheel zooms.
const FIELD = 0.75;  // vertical opening [rad]

class OrbitCamera {
  constructor(canvas, changed) {
    this.canvas = canvas;
    this.changed = changed;
    this.pointers = new Map();
    this.reset([0, 0, 0], 1);
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    });
    for (const name of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(name, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("dblclick", () => { this.reset(this.center, this.radius); this.changed(); });
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(Math.exp(Math.max(-60, Math.min(60, event.deltaY)) * 0.0025));
    }, {passive: false});
  }

  reset(center, radius) {
    const narrow = Math.max(1, 1.45 * this.canvas.clientHeight / Math.max(1, this.canvas.clientWidth));
    Object.assign(this, {center, radius, target: center.slice(), distance: radius * 2.3 * narrow, yaw: -1.05, pitch: 0.6});
  }
  look(yaw, pitch) { Object.assign(this, {yaw, pitch}); this.changed(); }
  zoom(factor) {
    this.distance = Math.min(this.radius * 40, Math.max(this.radius * 0.01, this.distance * factor));
    this.changed();
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before[0], dy = event.clientY - before[1];
    const others = [...this.pointers].filter(([id]) => id !== event.pointerId);
    if (others.length > 0) {
      const other = others[0][1];
      const gap = (x, y) => Math.hypot(x - other[0], y - other[1]) || 1;
      this.zoom(gap(...before) / gap(event.clientX, event.clientY));
      this.pan(dx / 2, dy / 2);
    } else if (event.buttons & 6 || event.shiftKey) {
      this.pan(dx, dy);
    } else {
      this.yaw -= dx * 0.007;
      this.pitch = Math.min(1.5707, Math.max(-1.5707, this.pitch + dy * 0.007));
    }
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    this.changed();
  }

  pan(dx, dy) {
    const perPixel = 2 * this.distance * Math.tan(FIELD / 2) / this.canvas.clientHeight;
    const {right, up} = this.axes();
    for (let k = 0; k < 3; ++k) this.target[k] += perPixel * (dy * up[k] - dx * right[k]);
    this.changed();
  }

  axes() {
    const right = [-Math.sin(this.yaw), Math.cos(this.yaw), 0];
    const back = [Math.cos(this.pitch) * Math.cos(this.yaw), Math.cos(this.pitch) * Math.sin(this.yaw), Math.sin(this.pitch)];
    return {right, back, up: cross(back, right)};
  }

  matrix(aspect) {
    const {back, up} = this.axes();
    const eye = this.target.map((value, k) => value + this.distance * back[k]);
    const far = this.distance + this.radius * 12;
    return product(perspective(FIELD, aspect, Math.max(this.distance, this.radius) * 0.002, far), lookAt(eye, this.target, up));
  }
}
