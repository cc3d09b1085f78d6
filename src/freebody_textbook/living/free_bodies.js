// Each body alone with the forces on it, as the figures of free bodies have it.

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

// All bodies in rows of two cells; one scale for their forces, one for their lengths.
const WIDE = 360, TALL = 185, LARGEST_BODY = 84, AT_ONCE = 4, TOP = 18;
function drawBodies(svg, bodies, y) {
  const every = bodies;
  if (view.first !== undefined) bodies = bodies.slice(view.first, view.first + AT_ONCE);
  const acting = ({kind, at, is, sign, name}) => ({kind, place: at, is: vector(y, is).map((u) => sign * u), name});
  const whole = every.map((body) => ({body, forces: body.forces.map(acting), moments: body.moments.map(acting)}));
  const all = whole.filter((one) => bodies.includes(one.body));
  const cell = [WIDE / Math.min(2, bodies.length), TALL], sheet = new Sheet(svg, WIDE, TOP + TALL * Math.ceil(bodies.length / 2));
  const largest = (vectors) => Math.max(...vectors.map(length));
  const longest = round(largest(whole.flatMap((one) => one.forces.map((force) => force.is))));
  const turning = round(largest(whole.flatMap((one) => one.moments.map((moment) => moment.is))));
  const reached = (body) => [body.joint, ...body.ends, ...[...body.forces, ...body.moments].map((one) => one.at)];
  const spots = (body) => reached(body).map((places) => vector(y, places));
  const size = largest(every.flatMap((body) => spots(body).flatMap((one) => spots(body).map((other) => minus(one, other))))) || 1;
  const legend = put(svg, "g", {class: "legend"});
  arrow({svg: legend, crowd: sheet.crowd}, "reaction", [8, 18], [8 + LONGEST_ARROW, 18]);
  sheet.crowd.boxes.push({l: 0, t: 0, r: 90, d: 24});
  Object.assign(put(legend, "text", {class: "tick", x: 8, y: 11}), {textContent: `${significant(longest, 2)} N`});
  all.forEach(({body, forces, moments}, k) => {
    const scale = LARGEST_BODY / size, places = spots(body).map(seen);
    const centred = [0, 1].map((i) => (Math.min(...places.map((at) => at[i])) + Math.max(...places.map((at) => at[i]))) / 2);
    const middle = [(k % 2 + 0.5) * cell[0], TOP + (Math.floor(k / 2) + 0.5) * cell[1]];
    const at = (places) => seen(vector(y, places)).map((u, i) => middle[i] + (i ? -1 : 1) * scale * (u - centred[i]));
    const group = {svg: put(svg, "g", {}), crowd: sheet.crowd, want: (...all) => sheet.want(...all)};
    alone(group, body, at, y);
    const drawn = (v, unit) => onPage(v).map((u) => LONGEST_ARROW * u / unit), arrows = [];
    for (const {kind, place, is, name} of forces) {
      if (length(is) > longest / LONGEST_ARROW) arrows.push({kind, from: at(place), along: drawn(is, longest), name, heads: 1});
    }
    for (const {place, is: moment, name} of moments) {
      if (length(moment) < NOISE * Math.max(longest, turning)) continue;
      if (moment.length > 1) arrows.push({kind: "moment", from: at(place), along: drawn(moment, turning), name, heads: 2});
      else turned(group, body, at, at(place), moment[0], name);
    }
    spread(arrows.filter((one) => length(one.along) >= 1));
    for (const {kind, from, along, name, heads} of arrows) {
      const to = plus(from, along);
      arrow(group, kind, from, to, heads);
      sheet.want(`${kind}-text`, name, tipAnchors(from, to));
    }
  });
  sheet.write();
}
function alone(sheet, body, at, y) {
  for (const ends of outline(body, at)) bar(sheet, ...ends, 11);
  ring(sheet, at, y, body, 20);
  const reached = [body.joint, body.centre, ...body.ends].map(at);
  for (const {at: place} of [...body.forces, ...body.moments]) {
    const to = at(place), far = (from) => length(minus(to, from)), from = reached.reduce((a, b) => (far(b) < far(a) ? b : a));
    if (far(from) > 1) line(sheet.svg, "guide", from, to);
  }
  for (const pin of body.pins) mark(sheet, "joint", at(pin));
  if (body.held) mark(sheet, body.joint.length < 3 ? body.mark : body.mark && "joint", at(body.joint), body.axis && unit(onPage(vector(y, body.axis))));
  if (body.heavy) centre(sheet, at(body.centre));
}
// A moment of the plane: an arc on the outer side of the body's end, anticlockwise where positive.
const SPAN = 4 / 3 * Math.PI;
function turned(sheet, body, at, place, value, name) {
  const far = [...body.ends, body.centre].map(at).find((end) => length(minus(end, at(body.joint))) > 0.5);
  const first = length(minus(place, at(body.joint))) < 0.5, way = far ? minus(far, at(body.joint)) : [0, 1];
  const facing = Math.atan2(first ? way[1] : -way[1], first ? -way[0] : way[0]), side = value > 0 ? 1 : -1;
  const on = arc(sheet, "moment", place, first ? 17 : 21, facing - side * SPAN / 2, side * SPAN, 9);
  sheet.want("moment-text", name, [0.75, 0.25, 0.5, 1, 0].map(on), view.predicts ? "" : ` = ${significant(value)} N m`);
}
