// A canvas with a sheet of names above it: solids with light and a depth for each pixel.

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
    [this.hair, this.soft, this.edge] = ["hair", "soft", "link-edge"].map(value);
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

class Surface {
  // least: units that the drawing is wide at least, which are pixels of the page where it is wider.
  constructor(canvas, svg, scene, redraw, least = 0) {
    Object.assign(this, {canvas, context: canvas.getContext("2d"), flat: scene.flat, least, quick: false});
    [this.raster, this.colours, this.sheet] = [new Raster(), new Colours(), new Sheet(svg, scene)];
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { this.colours.read(); redraw(); });
    new ResizeObserver(() => { this.measure(); redraw(); }).observe(canvas);
    this.measure();
  }
  // Reads the canvas's size on the page, for which a browser lays out all that has changed: not in
  // every picture.
  measure() { this.seen = [this.canvas.clientWidth, this.canvas.clientHeight]; }
  // Makes all as large as the canvas is on the page; whether it has a size.
  resize() {
    const [wide, tall] = this.seen, share = Math.max(this.least / wide, 1);
    if (!wide || !tall) return false;
    const wanted = Math.max(this.quick ? QUICK : FINE, this.quick ? 1 : devicePixelRatio), fine = Math.min(wanted, Math.sqrt(MOST / wide / tall));
    const size = [Math.round(wide * fine), Math.round(tall * fine)];
    if (this.canvas.width !== size[0] || this.canvas.height !== size[1] || !this.raster.wide) {
      [this.canvas.width, this.canvas.height] = size;
      this.raster.resize(...size);
    }
    Object.assign(this, {wide: wide * share, tall: tall * share, fine: fine / share});
    return true;
  }
  begin() {
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    this.sheet.begin(this.wide, this.tall);
    this.raster.clear();
  }
  // Solids as a camera sees them.
  paint(solids, camera, parts = solids.parts) {
    for (const part of parts) {
      const shades = this.colours.shades[part.role], {corners} = part, {screen} = solids;
      this.light(solids, camera, part);
      for (let k = 0; k < corners.length; k += 3) this.raster.fill(4 * corners[k], 4 * corners[k + 1], 4 * corners[k + 2], screen, shades, false);
    }
  }
  // Each corner on the page, and its light: from the viewer's upper left, from the sky, less at the rim.
  light({points, normals, screen}, camera, {first, end}) {
    const {right, up, towards, middle} = camera, sky = this.flat ? up : [0, 0, 1];
    const scale = camera.scale * camera.zoom, x0 = camera.wide * (0.5 + camera.aside[0]), y0 = camera.tall * (0.5 + camera.aside[1]);
    const lamp = unit([0, 1, 2].map((k) => -0.45 * right[k] + 0.55 * up[k] + 0.75 * towards[k])), half = unit(plus(lamp, towards));
    for (let i = 3 * first, j = 4 * first; i < 3 * end; i += 3, j += 4) {
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
  // Shows what was painted, and writes the names.
  end() {
    this.context.drawImage(this.raster.shown(), 0, 0);
    this.sheet.write();
  }
}
