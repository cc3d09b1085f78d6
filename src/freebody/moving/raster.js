// Triangles on pixels with a depth for each pixel, so that what crosses is seen as it is.

// Calls row(y, from, to) for each row of pixels of a triangle: those whose middles lie in it.
function rows(x0, y0, x1, y1, x2, y2, wide, tall, row) {
  const top = Math.max(Math.ceil(Math.min(y0, y1, y2) - 0.5), 0), end = Math.min(Math.ceil(Math.max(y0, y1, y2) - 0.5), tall);
  for (let y = top; y < end; y++) {
    const at = y + 0.5;
    let low = Infinity, high = -Infinity, x = 0;
    if ((y0 <= at) !== (y1 <= at)) { x = x0 + (at - y0) / (y1 - y0) * (x1 - x0); low = Math.min(low, x); high = Math.max(high, x); }
    if ((y1 <= at) !== (y2 <= at)) { x = x1 + (at - y1) / (y2 - y1) * (x2 - x1); low = Math.min(low, x); high = Math.max(high, x); }
    if ((y2 <= at) !== (y0 <= at)) { x = x2 + (at - y2) / (y0 - y2) * (x0 - x2); low = Math.min(low, x); high = Math.max(high, x); }
    const from = Math.max(Math.ceil(low - 0.5), 0), to = Math.min(Math.ceil(high - 0.5), wide);
    if (from < to) row(y, from, to);
  }
}

class Raster {
  constructor() {
    this.canvas = document.createElement("canvas");
    this.context = this.canvas.getContext("2d");
    this.used = [0, 0, 0, 0];
  }
  resize(wide, tall) {
    Object.assign(this.canvas, {width: wide, height: tall});
    this.image = this.context.createImageData(wide, tall);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.depths = new Float32Array(wide * tall);
    this.used = [0, 0, wide, tall];
    Object.assign(this, {wide, tall});
  }
  // Forgets what was drawn; the pixels that were used are all that is touched.
  clear() {
    const [left, top, right, bottom] = this.used;
    for (let y = top; y < bottom; y++) {
      this.pixels.fill(0, y * this.wide + left, y * this.wide + right);
      this.depths.fill(-Infinity, y * this.wide + left, y * this.wide + right);
    }
    this.old = this.used;
    this.used = [this.wide, this.tall, 0, 0];
  }
  // A triangle from the corners' x, y, depth and light (0 to 255); what turns away is not drawn, unless
  // it is seen from both sides.
  fill(a, b, c, screen, shades, both) {
    const x0 = screen[a], y0 = screen[a + 1], x1 = screen[b], y1 = screen[b + 1], x2 = screen[c], y2 = screen[c + 1];
    const area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0);
    if (area === 0 || (area > 0 && !both)) return;
    const z0 = screen[a + 2], zb = screen[b + 2] - z0, zc = screen[c + 2] - z0, i0 = screen[a + 3], ib = screen[b + 3] - i0, ic = screen[c + 3] - i0;
    const zx = (zb * (y2 - y0) - zc * (y1 - y0)) / area, zy = (zc * (x1 - x0) - zb * (x2 - x0)) / area;
    const ix = (ib * (y2 - y0) - ic * (y1 - y0)) / area, iy = (ic * (x1 - x0) - ib * (x2 - x0)) / area;
    const {wide, depths, pixels, used} = this;
    rows(x0, y0, x1, y1, x2, y2, wide, this.tall, (y, from, to) => {
      let depth = z0 + zx * (from + 0.5 - x0) + zy * (y + 0.5 - y0), light = i0 + ix * (from + 0.5 - x0) + iy * (y + 0.5 - y0);
      for (let x = from, k = y * wide + from; x < to; x++, k++, depth += zx, light += ix) {
        if (depth <= depths[k]) continue;
        depths[k] = depth;
        pixels[k] = shades[light < 0 ? 0 : light > 255 ? 255 : light | 0];
      }
      if (from < used[0]) used[0] = from;
      if (to > used[2]) used[2] = to;
      if (y < used[1]) used[1] = y;
      if (y >= used[3]) used[3] = y + 1;
    });
  }
  // A line as wide as two triangles make it.
  line(p, q, half, shades) {
    const far = Math.hypot(q[0] - p[0], q[1] - p[1]);
    if (!(far > 1e-9)) return;
    const x = -(q[1] - p[1]) / far * half, y = (q[0] - p[0]) / far * half;
    const corners = [p[0] + x, p[1] + y, p[2], 255, p[0] - x, p[1] - y, p[2], 255, q[0] - x, q[1] - y, q[2], 255, q[0] + x, q[1] + y, q[2], 255];
    this.fill(0, 4, 8, corners, shades, true);
    this.fill(0, 8, 12, corners, shades, true);
  }
  // What was drawn, as a canvas.
  shown() {
    const [a, b] = [this.old, this.used], left = Math.min(a[0], b[0]), top = Math.min(a[1], b[1]);
    const wide = Math.max(a[2], b[2]) - left, tall = Math.max(a[3], b[3]) - top;
    if (wide > 0 && tall > 0) this.context.putImageData(this.image, 0, 0, left, top, wide, tall);
    return this.canvas;
  }
}
