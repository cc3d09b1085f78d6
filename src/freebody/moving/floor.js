// The floor under a robot: lines a round distance apart, and a soft shadow of what stands on it; and
// what holds a robot of the plane.

const CELLS = 96, SOFT = 1;
class Floor {
  constructor(scene) {
    if (!scene.step) return;
    const {box: [low, high], step, flat} = scene, lines = (k) => [Math.floor(low[k] / step - 0.15), Math.ceil(high[k] / step + 0.15)];
    Object.assign(this, {x: lines(0), y: lines(1), step, flat, level: flat ? -1e-3 : scene.level});
    const sides = [this.x, this.y].map(([a, b]) => (b - a) * step);
    this.cell = Math.max(...sides) / CELLS;
    [this.wide, this.tall] = sides.map((side) => Math.max(Math.round(side / this.cell), 1));
    this.canvas = document.createElement("canvas");
    Object.assign(this.canvas, {width: this.wide, height: this.tall});
    this.context = this.canvas.getContext("2d");
    this.image = this.context.createImageData(this.wide, this.tall);
    [this.cover, this.spare] = [0, 1].map(() => new Uint16Array(this.wide * this.tall));
  }
  draw(context, camera, colours, solids) {
    if (!this.step) return;
    const {x: [x0, x1], y: [y0, y1], step, level} = this, at = (x, y) => camera.seen([x * step, y * step, level]);
    context.beginPath();
    for (let x = x0; x <= x1; x++) { context.moveTo(...at(x, y0)); context.lineTo(...at(x, y1)); }
    for (let y = y0; y <= y1; y++) { context.moveTo(...at(x0, y)); context.lineTo(...at(x1, y)); }
    context.strokeStyle = colours.hair;
    context.lineWidth = camera.thin;
    context.stroke();
    if (this.flat) return;
    this.shade(solids, colours);
    const [o, u, v] = [at(x0, y0), at(x1, y0), at(x0, y1)];
    context.save();
    context.transform((u[0] - o[0]) / this.wide, (u[1] - o[1]) / this.wide, (v[0] - o[0]) / this.tall, (v[1] - o[1]) / this.tall, o[0], o[1]);
    context.drawImage(this.canvas, 0, 0);
    context.restore();
  }
  // The shadow that light from above throws, blurred.
  shade({points, parts}, colours) {
    const {cover, wide, tall, cell} = this, x0 = this.x[0] * this.step, y0 = this.y[0] * this.step;
    const x = (k) => (points[3 * k] - x0) / cell, y = (k) => (points[3 * k + 1] - y0) / cell;
    cover.fill(0);
    const row = (line, from, to) => cover.fill(255, line * wide + from, line * wide + to);
    for (const {role, corners} of parts) {
      if (role.length < 2) continue;  // the world's axes
      for (let k = 0; k < corners.length; k += 3) rows(x(corners[k]), y(corners[k]), x(corners[k + 1]), y(corners[k + 1]), x(corners[k + 2]), y(corners[k + 2]), wide, tall, row);
    }
    blur(cover, this.spare, wide, tall, 1, wide);
    blur(this.spare, cover, tall, wide, wide, 1);
    const {data} = this.image, [r, g, b] = colours.rgb("ink"), dark = colours.shadow;
    for (let k = 0; k < cover.length; k++) {
      data[4 * k] = r; data[4 * k + 1] = g; data[4 * k + 2] = b;
      data[4 * k + 3] = cover[k] * dark;
    }
    this.context.putImageData(this.image, 0, 0);
  }
}
// Means along lines of cells: `count` of them, `step` apart, `next` from line to line.
function blur(from, to, count, lines, step, next) {
  const share = 2 * SOFT + 1;
  for (let line = 0; line < lines; line++) {
    const start = line * next;
    let sum = 0;
    for (let k = -SOFT; k < count + SOFT; k++) {
      if (k + SOFT < count) sum += from[start + (k + SOFT) * step];
      if (k - SOFT > 0) sum -= from[start + (k - SOFT - 1) * step];
      if (k >= 0 && k < count) to[start + k * step] = sum / share;
    }
  }
}
// The ground of a robot of the plane, in pixels of the page: a pedestal under a turn, the hatched guide
// of a slide.
function ground(context, stage, places, colours) {
  const {fine} = stage.surface, ends = places.slice(0, 2).map((place) => stage.camera.seen(inWorld(stage.frames, place)));
  const stroke = (colour, wide, lines) => {
    Object.assign(context, {strokeStyle: colour, lineWidth: wide * fine});
    context.beginPath();
    for (const [a, b] of lines) { context.moveTo(...a); context.lineTo(...b); }
    context.stroke();
  };
  if (places.length === 1) {
    const [[x, y]] = ends, local = (right, up) => [x + 9 * fine * right, y - 9 * fine * up], foot = [local(-1.2, -1.7), local(1.2, -1.7)];
    stroke(colours.soft, 1.3, Array.from({length: 7}, (_, k) => [local(0.6 * k - 1.5, -1.7), local(0.6 * k - 2.1, -2.3)]));
    stroke(colours.edge, 2, [[local(-2.1, -1.7), local(2.1, -1.7)], [local(0, 0), foot[0]], [local(0, 0), foot[1]]]);
    return;
  }
  const [a, b] = ends.map((end) => end.slice(0, 2)), [x0, y0] = wayInWorld(stage.frames, places[2]), reach = 0.12 * stage.size * stage.camera.scale * stage.camera.zoom;
  const half = length(minus(b, a)) / 2 + reach, middle = plus(a, minus(b, a), 0.5), pitch = reach / 4, [x, y] = x0 >= 0 ? [x0, -y0] : [-x0, y0];
  const [from, to] = [plus(middle, [x, y], -half), plus(middle, [x, y], half)], strokes = Math.max(Math.floor(2 * half / pitch / 0.9), 2);
  stroke(colours.edge, 2, [[from, to]]);
  stroke(colours.soft, 1.3, Array.from({length: strokes}, (_, k) => {
    const foot = plus(from, minus(to, from), (k + 1) / strokes);
    return [foot, plus(foot, [-y - 0.7 * x, x - 0.7 * y], pitch)];
  }));
}
