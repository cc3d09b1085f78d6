// The arm and its free bodies as SVG, from the values y. Everything is an element with attributes:
// the page's policy allows no other styles or code.

const SVG = document.getElementById("arm").namespaceURI;
function put(parent, tag, attributes, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined) made.setAttribute(name, value);
  }
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}
const line = (parent, kind, a, b, width) => put(parent, "line",
  {class: kind, x1: a[0], y1: a[1], x2: b[0], y2: b[1], "stroke-width": width});
const length = (v) => Math.hypot(...v);

// The next larger of a few round numbers: scales then stay while a slider moves a little.
function round(size) {
  if (!(size > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(size));
  return ten * [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((n) => n * ten >= size * (1 - 1e-12));
}

const LONGEST_ARROW = 55, HEAD = 8;
// heads: two of a moment in space, which is a vector along the axis about which it turns.
function arrow(parent, {kind, from, along, heads}) {
  const size = length(along), [u, v] = unit(along), tip = [from[0] + along[0], from[1] + along[1]];
  const back = [tip[0] - HEAD * u, tip[1] - HEAD * v];
  line(parent, kind, from, size > HEAD ? back : from);
  for (let k = 0; k < heads; k++) {
    const [x, y] = [-0.7 * HEAD * k * u, -0.7 * HEAD * k * v], [a, b] = [back[0] + x, back[1] + y];
    put(parent, "polygon", {class: `${kind}-head`, points:
      `${[tip[0] + x, tip[1] + y]} ${[a - 3.5 * v, b + 3.5 * u]} ${[a + 3.5 * v, b - 3.5 * u]}`});
  }
}

const NOISE = 1e-9;  // Of the largest moment or force: smaller ones are rounding.
// A moment: three quarters of a circle, anticlockwise where positive.
function turn(parent, at, value, radius) {
  const way = value > 0 ? 1 : -1;
  const on = (angle) => [at[0] + radius * Math.cos(angle), at[1] - radius * Math.sin(way * angle)];
  const from = on(-0.5), to = on(3.8), back = on(3.8 - 9 / radius);
  put(parent, "path", {class: "moment",
    d: `M${from} A${radius} ${radius} 0 1 ${way > 0 ? 0 : 1} ${back}`});
  const out = [(back[0] - at[0]) / radius, (back[1] - at[1]) / radius];
  put(parent, "polygon", {class: "moment-head", points:
    `${to} ${[back[0] + 4 * out[0], back[1] + 4 * out[1]]} ${[back[0] - 4 * out[0], back[1] - 4 * out[1]]}`});
}

function axis(parent, place, along) {
  line(parent, "axisline", [place[0] - 22 * along[0], place[1] + 22 * along[1]],
    [place[0] + 22 * along[0], place[1] - 22 * along[1]]);
}
function joint(parent, place, slides) {
  if (slides) put(parent, "rect", {class: "pin", x: place[0] - 7, y: place[1] - 5, width: 14, height: 10});
  else put(parent, "circle", {class: "pin", cx: place[0], cy: place[1], r: 5});
}
function centre(parent, place) { put(parent, "circle", {class: "com", cx: place[0], cy: place[1], r: 3.5}); }
// A body without extent that turns: a ring about its axis, which in the plane points at the viewer.
const RING = 20, LARGE_RING = 75, SIDES = 40;
function ring(parent, place, axis, radius) {
  let across = [[1, 0], [0, 1]];
  if (axis) {
    const first = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    across = [first, cross(axis, first)].map(seen);
  }
  const points = Array.from({length: SIDES}, (_, k) => {
    const angle = 2 * Math.PI * k / SIDES, [c, s] = [radius * Math.cos(angle), radius * Math.sin(angle)];
    return [place[0] + c * across[0][0] + s * across[1][0], place[1] - c * across[0][1] - s * across[1][1]];
  });
  put(parent, "polygon", {class: "rail", points: points.join(" ")});
}

// A body reaches from its joint to its ends and to its centre of mass.
function bars(parent, body, at, y, radius = RING) {
  const ends = [...body.ends.map(at), at(body.centre)];
  if (!body.slides && ends.every((end) => length(minus(end, at(body.joint))) < 1)) {
    ring(parent, at(body.joint), body.axis && vector(y, body.axis), radius);
  }
  for (const [kind, width] of [["edge", 13], ["bar", 10]]) {
    for (const end of ends) line(parent, kind, at(body.joint), end, width);
  }
}

// A vector of the plane, or one of space as it is seen; its size is that in space.
const view = {turn: 0, tilt: 0};
function seen(v) {
  if (v.length < 3) return v;
  const [c, s] = [Math.cos(view.turn), Math.sin(view.turn)];
  const away = c * v[0] + s * v[1], up = v[2];
  return [c * v[1] - s * v[0], Math.cos(view.tilt) * up - Math.sin(view.tilt) * away];
}
const vector = (y, places) => places.map((k) => y[k]);
const minus = (a, b) => a.map((u, k) => u - b[k]);
const opposite = (v) => v.map((u) => -u);

// The box of the world that is drawn. It grows with what moves, so that the drawing stays where it
// is, and is made anew where little of it is used.
let box = null;
function grown(points) {
  const around = (points) => [0, 1].map((i) => [Math.min(...points.map((p) => p[i])), Math.max(...points.map((p) => p[i]))]);
  const size = (box) => Math.max(...box.map(([low, high]) => high - low));
  const now = around(points), both = box && around([...points, [box[0][0], box[1][0]], [box[0][1], box[1][1]]]);
  box = both && size(both) < 2.5 * size(now) ? both : now;
}
const ROOM = [360, 250], EDGE = 34, LARGEST = 1e12;  // of all in one point
function drawArm(svg, bodies, rods, y) {
  svg.replaceChildren();
  const spots = bodies.flatMap((body) => [body.from || body.joint, body.joint, body.centre, ...body.ends, ...body.pins]);
  grown([...spots, ...rods.flat()].map((places) => seen(vector(y, places))));
  const scale = Math.min(...box.map(([low, high], i) => (ROOM[i] - 2 * EDGE) / (high - low)), LARGEST);
  const place = (v) => v.map((u, i) => ROOM[i] / 2 + (i ? -1 : 1) * scale * (u - (box[i][0] + box[i][1]) / 2));
  const at = (places) => place(seen(vector(y, places)));
  const shown = bodies.filter((body) => !body.link);
  for (const body of shown) {
    const from = at(body.slides ? body.from : body.joint), [u, v] = from;
    if (body.parent < 0 && body.held) line(svg, "hatch", [u - 30, v], [u + 30, v]);
    if (body.slides) line(svg, "rail", from, at(body.joint));
    bars(svg, body, at, y, scale < LARGEST ? RING : LARGE_RING);
  }
  for (const ends of rods) line(svg, "rail", ...ends.map(at));
  for (const body of shown) {
    for (const pin of body.pins) joint(svg, at(pin), false);
    if (!body.held) continue;
    if (body.axis) axis(svg, at(body.joint), seen(vector(y, body.axis)));
    joint(svg, at(body.joint), body.slides);
    centre(svg, at(body.centre));
  }
}

// All bodies in rows of two cells; one scale for their forces, one for their lengths. Returns the
// force that the longest arrow stands for.
const WIDE = 360, TALL = 175, LARGEST_BODY = 88, AT_ONCE = 4;
function drawBodies(svg, bodies, y) {
  const every = bodies;
  if (view.first !== undefined) bodies = bodies.slice(view.first, view.first + AT_ONCE);
  svg.replaceChildren();
  const acting = ({kind, at, is, sign, name}) =>
    ({kind, place: at, is: vector(y, is).map((u) => sign * u), name});
  const whole = every.map((body) =>
    ({body, forces: body.forces.map(acting), moments: body.moments.map(acting)}));
  const all = whole.filter((one) => bodies.includes(one.body));
  const cell = [WIDE / Math.min(2, bodies.length), TALL];
  const bottom = TALL * Math.ceil(bodies.length / 2);
  svg.setAttribute("viewBox", `0 0 ${WIDE} ${bottom}`);
  const largest = (vectors) => Math.max(...vectors.map(length));
  const longest = round(largest(whole.flatMap((one) => one.forces.map((force) => force.is))));
  const turning = round(largest(whole.flatMap((one) => one.moments.map((moment) => moment.is))));
  const drawn = (v, unit) => seen(v).map((u, k) => (k ? -1 : 1) * LONGEST_ARROW * u / unit);
  const ways = (body) => body.ends.map((end) => minus(vector(y, end), vector(y, body.joint)));
  const spots = (body) => [body.joint, ...body.ends].map((places) => vector(y, places));
  const size = largest(every.flatMap((body) =>
    spots(body).flatMap((one) => spots(body).map((other) => minus(one, other))))) || 1;
  const names = [], taken = [[0, 4, 72, 20]];  // there is the scale
  all.forEach(({body, forces, moments}, k) => {
    const far = body.ends.reduce((one, other, i) => length(ways(body)[i]) > length(ways(body)[body.ends.indexOf(one)]) ? other : one);
    const scale = LARGEST_BODY / size, places = spots(body).map(seen);
    const centred = [0, 1].map((i) => (Math.min(...places.map((at) => at[i])) + Math.max(...places.map((at) => at[i]))) / 2);
    const middle = [(k % 2 + 0.5) * cell[0], (Math.floor(k / 2) + 0.5) * cell[1]];
    const at = (places) => seen(vector(y, places)).map((u, i) => middle[i] + (i ? -1 : 1) * scale * (u - centred[i]));
    const group = put(svg, "g", {});
    bars(group, body, at, y);
    for (const pin of body.pins) joint(group, at(pin), false);
    if (body.held) joint(group, at(body.joint), body.slides);
    centre(group, at(body.centre));
    const [from, to] = [at(body.joint), at(far)], away = unit(minus(to, from));
    taken.push(...along(from, to, 6));
    const arrows = forces.map(({kind, place, is, name}) =>
      ({kind, from: at(place), along: drawn(is, longest), text: name, heads: 1}));
    for (const {place, is: moment, name: text} of moments) {
      if (length(moment) < NOISE * Math.max(longest, turning)) continue;
      const first = String(place) === String(body.joint), radius = first ? 13 : 18, [x, y] = at(place);
      if (moment.length > 1) arrows.push({kind: "moment", from: [x, y], along: drawn(moment, turning), text, heads: 2});
      else {
        turn(group, [x, y], moment[0], radius);
        taken.push(around([x, y], radius, radius));
        const way = length(away) ? (first ? opposite(away) : away) : [0, 1];
        names.push({kind: "moment", text: `${text} = ${shown(moment[0])} N m`, way,
          tip: [x + radius * way[0], y + radius * way[1]]});
      }
    }
    const long = arrows.filter((one) => length(one.along) >= 1);
    spread(long);
    for (const one of long) {
      arrow(group, one);
      const tip = one.from.map((u, i) => u + one.along[i]);
      taken.push(...along(one.from, tip, 3));
      names.push({kind: one.kind, text: one.text, tip, way: unit(one.along)});
    }
  });
  write(svg, names, taken, WIDE, bottom);
  return longest;
}
