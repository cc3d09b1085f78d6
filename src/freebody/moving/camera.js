// A view of the world in parallel projection: turned by mouse, touch or keys, made larger and moved.

const LOWEST = 2, ROOM = 0.7, DEGREE = Math.PI / 180;
const within = (elevation) => Math.min(Math.max(elevation, LOWEST), 90);
class Camera {
  constructor(scene) {
    this.scene = scene;
    this.corners = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => [0, 1, 2].map((k) => scene.box[n >> k & 1][k]));
    this.reset();
  }
  reset() {
    Object.assign(this, {azimuth: this.scene.view[0], elevation: this.scene.view[1], zoom: 1, aside: [0, 0], thin: 1});
    this.turn(0, 0);
  }
  turn(azimuth, elevation) {
    Object.assign(this, {azimuth: this.azimuth + azimuth, elevation: within(this.elevation + elevation)});
    Object.assign(this, this.axes(this.azimuth, this.elevation));
  }
  // What points to the right, up and towards the viewer, as seen from two angles; a drawing of the
  // plane is seen from the front.
  axes(azimuth, elevation) {
    if (this.scene.flat) return {right: [1, 0, 0], up: [0, 1, 0], towards: [0, 0, 1]};
    const a = azimuth * DEGREE, e = within(elevation) * DEGREE, [c, s, h, v] = [Math.cos(a), Math.sin(a), Math.cos(e), Math.sin(e)];
    return {right: [-s, c, 0], up: [-v * c, -v * s, h], towards: [h * c, h * s, v]};
  }
  closer(factor) { this.zoom = Math.min(Math.max(this.zoom * factor, 0.3), 12); }
  shift(x, y) { this.aside = [this.aside[0] + x, this.aside[1] + y]; }
  // Fits all that moves into the window, as it is seen at first: the corners of its box, or
  // places on its way with some room about them.
  fit(wide, tall) { Object.assign(this, {wide, tall}, this.fitting(this.corners, wide, tall)); }
  // The middle and the pixels for each metre with which some places fill a window.
  fitting(places, wide, tall) {
    const {right, up, towards} = this.axes(...this.scene.view), ends = [right, up, towards].map((way) => places.reduce(([low, high], place) => {
      const far = dot(place, way);
      return [Math.min(low, far), Math.max(high, far)];
    }, [Infinity, -Infinity]));
    const [a, b, c] = ends.map(([low, high]) => (low + high) / 2), room = ROOM * this.scene.step, edge = 2 * (this.scene.edge || 0) * this.thin;
    return {
      middle: [0, 1, 2].map((k) => a * right[k] + b * up[k] + c * towards[k]),
      scale: Math.min((wide - edge) / (ends[0][1] - ends[0][0] + room || 1), (tall - edge) / (ends[1][1] - ends[1][0] + room || 1)),
    };
  }
  // x to the right, y down, in pixels, and how near.
  seen(p) {
    const scale = this.scale * this.zoom, d = [p[0] - this.middle[0], p[1] - this.middle[1], p[2] - this.middle[2]];
    return [this.wide * (0.5 + this.aside[0]) + scale * dot(d, this.right), this.tall * (0.5 + this.aside[1]) - scale * dot(d, this.up), scale * dot(d, this.towards)];
  }
}

const KEYS = {
  ArrowLeft: (camera, flat) => (flat ? camera.shift(0.05, 0) : camera.turn(8, 0)),
  ArrowRight: (camera, flat) => (flat ? camera.shift(-0.05, 0) : camera.turn(-8, 0)),
  ArrowUp: (camera, flat) => (flat ? camera.shift(0, 0.05) : camera.turn(0, 6)),
  ArrowDown: (camera, flat) => (flat ? camera.shift(0, -0.05) : camera.turn(0, -6)),
  "+": (camera) => camera.closer(1.2), "=": (camera) => camera.closer(1.2), "-": (camera) => camera.closer(1 / 1.2),
  "0": (camera) => camera.reset(),
};
// Lets a canvas be turned: dragged, pinched, with Ctrl and the wheel, and by keys; changed() draws.
function turnable(canvas, camera, changed) {
  const held = new Map(), flat = camera.scene.flat;
  const spread = () => { const [a, b] = [...held.values()]; return Math.hypot(a[0] - b[0], a[1] - b[1]); };
  canvas.addEventListener("pointerdown", (event) => {
    held.set(event.pointerId, [event.clientX, event.clientY]);
    canvas.setPointerCapture(event.pointerId);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, (event) => held.delete(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    const before = held.get(event.pointerId), box = canvas.getBoundingClientRect();
    if (!before) return;
    const apart = held.size === 2 ? spread() : 0, x = event.clientX - before[0], y = event.clientY - before[1];
    held.set(event.pointerId, [event.clientX, event.clientY]);
    if (held.size === 2) camera.closer(spread() / apart);
    if (flat || event.shiftKey || held.size === 2) camera.shift(x / box.width / held.size, y / box.height / held.size);
    else camera.turn(-0.5 * x, 0.5 * y);
    changed();
  });
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey) return;  // without Ctrl the wheel moves the page
    event.preventDefault();
    camera.closer(Math.exp(-0.005 * event.deltaY));
    changed();
  }, {passive: false});
  canvas.addEventListener("keydown", (event) => {
    const act = KEYS[event.key];
    if (!act || event.altKey || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    act(camera, flat);
    changed();
  });
  canvas.addEventListener("dblclick", () => { camera.reset(); changed(); });
}
