// A robot on a canvas: floor, shadow, solids with light, the path of its tip, and names.

// Pixels of the drawing for each of the page, still and while it plays.
const FINE = 2, QUICK = 1, MOST = 2.6e6;
// The page's colours, as they are in light or dark.
class Colours {
  constructor() { this.read(); }
  read() {
    const style = getComputedStyle(document.documentElement), value = (name) => style.getPropertyValue(`--${name}`).trim();
    this.rgb = (name) => [1, 3, 5].map((k) => parseInt(value(name).slice(k, k + 2), 16));
    const dark = this.rgb("paper")[0] < 128;
    this.shadow = dark ? 0 : 0.2;
    this.hair = value("hair");
    const shades = (name) => Uint32Array.from({length: 256}, (_, k) => {
      const light = k / 200, glint = Math.max(k - 215, 0) / 40 * 0.35;
      const [r, g, b] = this.rgb(name).map((c) => Math.min(Math.round(c * Math.min(light, 1.12) * (1 - glint) + 255 * glint), 255));
      return (255 << 24 | b << 16 | g << 8 | r) >>> 0;
    });
    this.shades = {link: shades("shell"), joint: shades("hub"), rod: shades("link-edge"), x: shades("x"), y: shades("y"), z: shades("z")};
    const [r, g, b] = this.rgb("path");
    this.path = new Uint32Array(256).fill((255 << 24 | b << 16 | g << 8 | r) >>> 0);
  }
}

class Stage {
  // place(q, frames) is the robot's kernel.
  constructor(canvas, svg, scene, bodies, place) {
    Object.assign(this, {canvas, svg, scene, place, context: canvas.getContext("2d"), path: [], quick: false});
    this.frames = new Float64Array(FRAME * (bodies + 1));
    this.frames.set([1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
    this.own = this.frames.subarray(FRAME);
    [this.solids, this.camera, this.raster, this.floor] = [new Solids(scene.solids), new Camera(scene), new Raster(), new Floor(scene)];
    [this.colours, this.labels] = [new Colours(), new Labels(svg, scene.names)];
    this.screen = new Float64Array(this.solids.points.length / 3 * 4);
    turnable(canvas, this.camera, () => this.draw());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.colours.read(); this.draw(); });
    new ResizeObserver(() => { this.resize(); this.draw(); }).observe(canvas);
    this.resize();
  }
  resize() {
    const {clientWidth: wide, clientHeight: tall} = this.canvas, wanted = Math.max(this.quick ? QUICK : FINE, this.quick ? 1 : devicePixelRatio);
    if (!wide || !tall) return;
    const fine = Math.min(wanted, Math.sqrt(MOST / wide / tall));
    [this.wide, this.tall, this.fine] = [wide, tall, fine];
    Object.assign(this.canvas, {width: Math.round(wide * fine), height: Math.round(tall * fine)});
    this.raster.resize(this.canvas.width, this.canvas.height);
    this.camera.fit(this.canvas.width, this.canvas.height);
    this.camera.thin = fine;
    this.svg.setAttribute("viewBox", `0 0 ${wide} ${tall}`);
  }
  // Draws coarser and quicker, or finely again.
  hurry(quick) {
    if (this.quick === quick) return;
    this.quick = quick;
    this.resize();
    this.draw();
  }
  // Places of a point of the robot at each of several positions.
  places(positions, point) {
    return positions.map((q) => { this.place(q, this.own); return inWorld(this.frames, point); });
  }
  // Frames all that moves through some positions.
  frame(positions) {
    const ends = this.scene.solids.flatMap(([, a, b]) => [a, b]);
    this.camera.corners = positions.flatMap((q) => {
      this.place(q, this.own);
      return ends.map((end) => inWorld(this.frames, end));
    });
    this.resize();
  }
  show(q) {
    this.place(q, this.own);
    this.solids.place(this.frames);
    this.draw();
  }
  draw() {
    if (!this.wide) return;
    const {context, camera, raster, colours, canvas, fine} = this;
    context.clearRect(0, 0, canvas.width, canvas.height);
    this.floor.draw(context, camera, colours, this.solids);
    raster.clear();
    this.light();
    for (const {role, corners} of this.solids.parts) {
      const shades = colours.shades[role];
      for (let k = 0; k < corners.length; k += 3) raster.fill(4 * corners[k], 4 * corners[k + 1], 4 * corners[k + 2], this.screen, shades, false);
    }
    const path = this.path.map((p) => camera.seen(p));
    for (let k = 1; k < path.length; k++) raster.line(path[k - 1], path[k], 0.8 * fine, colours.path);
    context.drawImage(raster.shown(), 0, 0);
    this.labels.draw((at) => camera.seen(inWorld(this.frames, at)).map((x) => x / fine), this.wide, this.tall);
  }
  // Each corner on the page, and its light: from the viewer's upper left, from the sky, less at the rim.
  light() {
    const {points, normals} = this.solids, {camera, screen} = this, {right, up, towards, middle} = camera, sky = this.scene.flat ? up : [0, 0, 1];
    const scale = camera.scale * camera.zoom, x0 = camera.wide * (0.5 + camera.aside[0]), y0 = camera.tall * (0.5 + camera.aside[1]);
    const lamp = unit3([0, 1, 2].map((k) => -0.45 * right[k] + 0.55 * up[k] + 0.75 * towards[k])), half = unit3(lamp.map((x, k) => x + towards[k]));
    for (let i = 0, j = 0; i < points.length; i += 3, j += 4) {
      const x = points[i] - middle[0], y = points[i + 1] - middle[1], z = points[i + 2] - middle[2];
      screen[j] = x0 + scale * (x * right[0] + y * right[1] + z * right[2]);
      screen[j + 1] = y0 - scale * (x * up[0] + y * up[1] + z * up[2]);
      screen[j + 2] = scale * (x * towards[0] + y * towards[1] + z * towards[2]);
      const a = normals[i], b = normals[i + 1], c = normals[i + 2];
      const facing = a * towards[0] + b * towards[1] + c * towards[2], lit = Math.max(a * lamp[0] + b * lamp[1] + c * lamp[2], 0);
      const bright = Math.max(a * half[0] + b * half[1] + c * half[2], 0) ** 16, above = 0.5 + 0.5 * (a * sky[0] + b * sky[1] + c * sky[2]);
      screen[j + 3] = (84 + 92 * lit + 34 * above) * (0.7 + 0.3 * Math.min(Math.max(2.2 * facing, 0), 1)) + 40 * bright;
    }
  }
}
