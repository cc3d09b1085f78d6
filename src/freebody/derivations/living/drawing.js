// The arm and its free bodies as SVG, from the values y. Everything is an element with attributes:
// the page's policy allows no other styles or code.

const SVG = document.getElementById("arm").namespaceURI;
function put(parent, tag, attributes, text) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  if (text !== undefined) made.textContent = text;
  parent.append(made);
  return made;
}
const line = (parent, kind, a, b, width) => put(parent, "line",
  {class: kind, x1: a[0], y1: a[1], x2: b[0], y2: b[1], "stroke-width": width});
const length = (v) => Math.hypot(v[0], v[1]);

// The next larger of a few round numbers: scales then stay while a slider moves a little.
function round(size) {
  if (!(size > 0)) return 1;
  const ten = 10 ** Math.floor(Math.log10(size));
  return ten * [1, 1.5, 2, 3, 4, 5, 6, 8, 10].find((n) => n * ten >= size * (1 - 1e-12));
}

const LONGEST_ARROW = 55, HEAD = 8;
function arrow(parent, kind, from, along, name) {
  const size = length(along);
  if (size < 1) return;
  const [u, v] = [along[0] / size, along[1] / size], tip = [from[0] + along[0], from[1] + along[1]];
  const back = [tip[0] - HEAD * u, tip[1] - HEAD * v];
  line(parent, kind, from, size > HEAD ? back : from);
  put(parent, "polygon", {class: `${kind}-head`, points:
    `${tip} ${[back[0] - 3.5 * v, back[1] + 3.5 * u]} ${[back[0] + 3.5 * v, back[1] - 3.5 * u]}`});
  put(parent, "text", {class: `${kind}-text halo`, x: tip[0] + 9 * u, y: tip[1] + 9 * v + 4,
    "text-anchor": u < -0.3 ? "end" : u > 0.3 ? "start" : "middle"}, name);
}

const NOISE = 1e-9;  // Of the largest moment or force: smaller ones are rounding.
// A moment: three quarters of a circle, anticlockwise where positive.
function turn(parent, at, value, name, radius, away) {
  const way = value > 0 ? 1 : -1;
  const on = (angle) => [at[0] + radius * Math.cos(angle), at[1] - radius * Math.sin(way * angle)];
  const from = on(-0.5), to = on(3.8), back = on(3.8 - 9 / radius);
  put(parent, "path", {class: "moment",
    d: `M${from} A${radius} ${radius} 0 1 ${way > 0 ? 0 : 1} ${back}`});
  const out = [(back[0] - at[0]) / radius, (back[1] - at[1]) / radius];
  put(parent, "polygon", {class: "moment-head", points:
    `${to} ${[back[0] + 4 * out[0], back[1] + 4 * out[1]]} ${[back[0] - 4 * out[0], back[1] - 4 * out[1]]}`});
  const beside = Math.min(Math.max(at[0] + 32 * away[0], 48), 312);
  put(parent, "text", {class: "moment-text halo", x: beside, y: at[1] + 26 * away[1] + 4, "text-anchor": "middle"}, `${name} = ${shown(value)}`);
}

function joint(parent, place, slides) {
  if (slides) put(parent, "rect", {class: "pin", x: place[0] - 7, y: place[1] - 5, width: 14, height: 10});
  else put(parent, "circle", {class: "pin", cx: place[0], cy: place[1], r: 5});
}
function centre(parent, place) { put(parent, "circle", {class: "com", cx: place[0], cy: place[1], r: 3.5}); }
// A body reaches from its joint to its end and to its centre of mass.
function bars(parent, body, at) {
  const ends = [at(body.end), at(body.centre)];
  for (const end of ends) line(parent, "edge", at(body.joint), end, 13);
  for (const end of ends) line(parent, "bar", at(body.joint), end, 10);
}

const vector = (y, places) => [y[places[0]], y[places[1]]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1]];

function drawArm(svg, bodies, y) {
  svg.replaceChildren();
  let from = [0, 0], reach = 0;
  for (const body of bodies) {
    for (const place of [body.joint, body.end]) {
      reach += length(minus(vector(y, place), from));
      from = vector(y, place);
    }
  }
  const scale = 128 / (reach || 1), at = (places) => [180 + scale * y[places[0]], 135 - scale * y[places[1]]];
  line(svg, "hatch", [150, 135], [210, 135]);
  for (const body of bodies) {
    if (body.slides) line(svg, "rail", body.index ? at(bodies[body.index - 1].joint) : [180, 135], at(body.joint));
    bars(svg, body, at);
  }
  for (const body of bodies) {
    joint(svg, at(body.joint), body.slides);
    centre(svg, at(body.centre));
  }
}

// What acts on each body: [kind, place, force, name] and [place, moment, name].
function loads(bodies, y) {
  return bodies.map((body, k) => {
    const forces = [["reaction", body.joint, vector(y, body.force), body.called.force]];
    const moments = [[body.joint, y[body.moment[0]], body.called.moment]];
    const child = bodies[k + 1];
    if (child) {
      forces.push(["reaction", child.joint, minus([0, 0], vector(y, child.force)), `\u2212${child.called.force}`]);
      moments.push([child.joint, -y[child.moment[0]], `\u2212${child.called.moment}`]);
    }
    forces.push(["weight", body.centre, vector(y, body.weight), body.called.weight]);
    if (body.load) forces.push(["external", body.tip, vector(y, body.load), "f"]);
    return {body, forces, moments};
  });
}

// All bodies in a row of cells; one scale for their forces, one for their lengths. Returns the force
// that the longest arrow stands for.
function drawBodies(svg, bodies, y) {
  svg.replaceChildren();
  const all = loads(bodies, y), wide = 360 / Math.min(2, bodies.length), tall = 190;
  svg.setAttribute("viewBox", `0 0 360 ${tall * Math.ceil(bodies.length / 2)}`);
  const longest = round(Math.max(...all.flatMap((one) => one.forces.map((force) => length(force[2])))));
  const most = Math.max(longest, ...all.flatMap((one) => one.moments.map((moment) => Math.abs(moment[1]))));
  const size = Math.max(...bodies.map((body) => length(minus(vector(y, body.end), vector(y, body.joint))))) || 1;
  all.forEach(({body, forces, moments}, k) => {
    const a = vector(y, body.joint), b = vector(y, body.end);
    const middle = [(k % 2 + 0.5) * wide, (Math.floor(k / 2) + 0.5) * tall], scale = 85 / size;
    const at = (places) => {
      const place = vector(y, places);
      return [middle[0] + scale * (place[0] - (a[0] + b[0]) / 2), middle[1] - scale * (place[1] - (a[1] + b[1]) / 2)];
    };
    const cell = put(svg, "g", {});
    bars(cell, body, at);
    joint(cell, at(body.joint), body.slides);
    centre(cell, at(body.centre));
    const [from, to] = [at(body.joint), at(body.end)], long = length(minus(to, from)) || 1;
    const along = long > 1 ? [(to[0] - from[0]) / long, (to[1] - from[1]) / long] : [0, -1];
    for (const [place, moment, name] of moments) {
      if (Math.abs(moment) < NOISE * most) continue;
      const first = place === body.joint;
      turn(cell, at(place), moment, name, first ? 13 : 18, first ? [-along[0], -along[1]] : along);
    }
    for (const [kind, place, force, name] of forces) {
      const along = [LONGEST_ARROW * force[0] / longest, -LONGEST_ARROW * force[1] / longest];
      arrow(cell, kind, at(place), along, name);
    }
  });
  return longest;
}
