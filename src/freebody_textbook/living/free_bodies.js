// Each body alone with the forces on it, as the figures of free bodies have it.

// What the page does not say of a body.
for (const body of page.bodies) {
  for (const list of ["ends", "forces", "moments"]) body[list] ||= [];
  body.names ||= {};
}
const vector = (y, places) => places.map((k) => y[k]);

// The next larger of a few round numbers: scales then stay while a slider moves a little.
function round(size) {
  if (!(size > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(size));
  return ten * [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((n) => n * ten >= size * (1 - 1e-12));
}

const LONGEST_ARROW = 55, LANE = 9;
const NOISE = 1e-9;  // Of the largest moment or force: smaller ones are rounding.

// Whether two arrows lie on one line, and on each other.
function covers(other, one) {
  const [u, v] = unit(other.along), [p, q] = unit(one.along), [x, y] = minus(one.from, other.from);
  if (Math.abs(u * q - v * p) > 0.15 || Math.abs(u * y - v * x) > 6) return false;
  const ends = [u * x + v * y, u * (x + one.along[0]) + v * (y + one.along[1])];
  return Math.min(Math.max(...ends), length(other.along)) - Math.max(Math.min(...ends), 0) > 3;
}
function spread(arrows) {
  arrows.forEach((one, k) => {
    const away = opposite(left(unit(one.along)));
    for (let tries = 0; tries < 3 && arrows.slice(0, k).some((other) => covers(other, one)); tries++) one.from = plus(one.from, away, LANE);
  });
}

// The force on the tip, on the robot: the longest arrow of all.
function pushed(stage, bodies, y) {
  for (const body of bodies) {
    for (const {kind, at, is, name} of body.forces.filter((one) => one.kind === "external" && !page.free)) {
      const a = stage.at(at), pull = stage.onSheet(inSpace(vector(y, is))), far = length(vector(y, is));
      if (!(far > 0)) continue;
      const b = plus(a, pull, Math.min(0.38 * stage.size * stage.scale, EDGE) / far);
      arrow(stage.sheet, kind, a, b);
      stage.sheet.want(`${kind}-text`, name, tipAnchors(a, b));
    }
  }
}
const inSpace = (v) => (v.length < 3 ? [...v, 0] : v);

// All bodies in rows of two cells; one scale for their forces, one for their lengths.
// A link is so many pixels thick at least, where it can be without becoming clumsy.
const EDGE = 48, WIDE = 360, TALL = 185, LARGEST_BODY = 84, AT_ONCE = 4, TOP = 18, THICK = 5.5, LINK = 0.025, CLUMSY = 3;
class FreeBodies {
  // stage: the robot, whose solids and view the bodies have.
  constructor(canvas, svg, scene, stage, bodies) {
    Object.assign(this, {canvas, stage, every: bodies, solids: new Solids(scene.solids), first: 0, most: bodies.length, predicts: false});
    this.surface = new Surface(canvas, svg, scene, () => this.again(), WIDE);
  }
  again() { if (this.y) this.draw(this.y); }
  draw(y) {
    this.y = y;
    const {surface, stage, every} = this, bodies = every.slice(this.first, this.first + this.most), rows = Math.ceil(bodies.length / 2);
    if (rows !== this.rows) {
      this.canvas.style.aspectRatio = `${WIDE} / ${TOP + TALL * rows}`;
      surface.measure();
      this.rows = rows;
    }
    if (!bodies.length || !surface.resize()) return;
    surface.begin();
    const {sheet} = surface, acting = ({kind, at, is, sign, name}) => ({kind, at, is: vector(y, is).map((u) => sign * u), name});
    const whole = every.map((body) => ({body, forces: body.forces.map(acting), moments: body.moments.map(acting)}));
    const largest = (vectors) => Math.max(...vectors.map(length), 0);
    const longest = round(largest(whole.flatMap((one) => one.forces.map((force) => force.is))));
    const turning = round(largest(whole.flatMap((one) => one.moments.map((moment) => moment.is))));
    const spots = (body) => [body.joint, ...body.ends, ...[...body.forces, ...body.moments].map((one) => one.at)].map((at) => inWorld(stage.frames, at));
    const size = largest(every.flatMap((body) => spots(body).flatMap((one) => spots(body).map((other) => minus(one, other))))), scale = LARGEST_BODY / Math.max(size, 0.3 * stage.size);
    this.solids.place(stage.frames, Math.min(Math.max(THICK / (scale * LINK * stage.size), 1), CLUMSY));
    const legend = put(sheet.svg, "g", {class: "legend"}), crowd = sheet.crowd;
    arrow({svg: legend, crowd}, "reaction", [8, 18], [8 + LONGEST_ARROW, 18]);
    sheet.boxes.push({l: 0, t: 0, r: 90, d: 24});
    put(legend, "text", {class: "tick", x: 8, y: 11}).textContent = `${significant(longest, 2)} N`;
    whole.filter((one) => bodies.includes(one.body)).forEach(({body, forces, moments}, k) => {
      const cell = this.cell(k, bodies.length, spots(body), scale), at = (place) => cell.seen(inWorld(stage.frames, place)).slice(0, 2).map((x) => x / surface.fine);
      const own = this.solids.parts.filter((part) => part.bodies.includes(page.bodies.indexOf(body)));
      surface.paint(this.solids, cell, own);
      const group = {svg: put(sheet.svg, "g", {}), crowd, want: (...all) => sheet.want(...all)};
      this.alone(group, body, own, at);
      const drawn = (v, unit) => stage.onSheet(inSpace(v)).map((u) => LONGEST_ARROW * u / unit), arrows = [];
      for (const {kind, at: place, is, name} of forces) {
        if (length(is) > longest / LONGEST_ARROW) arrows.push({kind, from: at(place), along: drawn(is, longest), name, heads: 1});
      }
      for (const {at: place, is: moment, name} of moments) {
        if (length(moment) < NOISE * Math.max(longest, turning)) continue;
        if (moment.length > 1) arrows.push({kind: "moment", from: at(place), along: drawn(moment, turning), name, heads: 2});
        else this.turned(group, body, at, at(place), moment[0], name);
      }
      spread(arrows.filter((one) => length(one.along) >= 1));
      for (const {kind, from, along, name, heads} of arrows) {
        const to = plus(from, along);
        arrow(group, kind, from, to, heads);
        sheet.want(`${kind}-text`, name, tipAnchors(from, to));
      }
    });
    surface.end();
  }
  // The camera of a cell: that of the robot, with some places in the middle.
  cell(k, count, spots, scale) {
    const {camera} = this.stage, {fine} = this.surface, middle = [camera.right, camera.up].map((way) => {
      const far = spots.map((at) => dot(at, way));
      return (Math.min(...far) + Math.max(...far)) / 2;
    });
    const [x, y] = [(k % 2 + 0.5) * WIDE / Math.min(2, count), TOP + (Math.floor(k / 2) + 0.5) * TALL];
    return Object.assign(Object.create(camera), {
      middle: plus(camera.right.map((u) => u * middle[0]), camera.up, middle[1]),
      scale: scale * fine, zoom: 1, aside: [0, 0], wide: 2 * x * fine, tall: 2 * y * fine,
    });
  }
  alone(sheet, body, own, at) {
    for (const {a, b} of this.solids.solids.filter((_, k) => own.includes(this.solids.parts[k]))) sheet.crowd.clear(at(a), at(b), 7);
    const reached = [body.joint, body.centre, ...body.ends].map(at);
    for (const {at: place} of [...body.forces, ...body.moments]) {
      const to = at(place), far = (from) => length(minus(to, from)), from = reached.reduce((a, b) => (far(b) < far(a) ? b : a));
      if (far(from) > 1) line(sheet.svg, "guide", from, to);
    }
    if (body.heavy) centre(sheet, at(body.centre));
  }
  // A moment of the plane: an arc on the outer side of the body's end, anticlockwise where positive.
  turned(sheet, body, at, place, value, name) {
    const far = [...body.ends, body.centre].map(at).find((end) => length(minus(end, at(body.joint))) > 0.5);
    const first = length(minus(place, at(body.joint))) < 0.5, way = far ? minus(far, at(body.joint)) : [0, 1];
    const facing = Math.atan2(first ? way[1] : -way[1], first ? -way[0] : way[0]), side = value > 0 ? 1 : -1;
    const on = arc(sheet, "moment", place, first ? 17 : 21, facing - side * SPAN / 2, side * SPAN, 9);
    sheet.want("moment-text", name, [0.75, 0.25, 0.5, 1, 0].map(on), this.predicts ? "" : ` = ${significant(value)} N m`);
  }
}
const SPAN = 4 / 3 * Math.PI;
