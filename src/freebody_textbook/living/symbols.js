// The symbols of textbooks as SVG, as figures have them. Places are [x, y] in pixels, y down.
// Everything is an element with attributes: the page's policy allows no other styles or code.

const SVG = document.getElementById("arm").namespaceURI;
function put(parent, tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined) made.setAttribute(name, value);
  }
  parent.append(made);
  return made;
}
const line = (parent, kind, a, b, width) => put(parent, "line",
  {class: kind, x1: a[0], y1: a[1], x2: b[0], y2: b[1], "stroke-width": width});
const circle = (parent, kind, [x, y], r) => put(parent, "circle", {class: kind, cx: x, cy: y, r});
const polygon = (parent, kind, points) => put(parent, "polygon", {class: kind, points: points.join(" ")});

const length = (v) => Math.hypot(...v);
const unit = (v) => v.map((u) => u / (length(v) || 1));
const plus = (a, b, share = 1) => a.map((u, k) => u + share * b[k]);
const minus = (a, b) => a.map((u, k) => u - b[k]);
const opposite = (v) => v.map((u) => -u);
const left = ([x, y]) => [y, -x];
const dot = (a, b) => a.reduce((total, u, k) => total + u * b[k], 0);
const cross = (a, b) => [0, 1, 2].map((k) => a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
const towards = (angle) => [Math.cos(angle), -Math.sin(angle)];

function head(parent, kind, tip, way, size) {
  const back = plus(tip, way, -size), across = left(way);
  polygon(parent, `${kind}-head`, [tip, plus(back, across, 0.36 * size), plus(back, across, -0.36 * size)]);
}
// heads: two of a moment in space, which is a vector along the axis about which it turns.
function arrow({svg, crowd}, kind, a, b, heads = 1) {
  const along = minus(b, a), far = length(along), way = unit(along), size = Math.min(10, Math.max(5, 0.4 * far));
  line(svg, kind, a, plus(b, way, -Math.min(0.7 * size, far)));
  if (far < 4) {
    circle(svg, kind, b, 5);
    circle(svg, `${kind}-head`, b, 2);
  }
  for (let k = 0; k < heads && far >= 4; k++) head(svg, kind, plus(b, way, -0.8 * k * size), way, size);
  crowd.clear(a, b);
}
// An arc from the direction `start` over `sweep` with a head where it ends.
function arc({svg, crowd}, kind, at, radius, start, sweep, size) {
  const on = (angle) => plus(at, towards(angle), radius);
  const [a, b] = [on(start), on(start + sweep)], ahead = Math.sign(sweep) || 1;
  put(svg, "path", {class: kind, d: `M${a}A${radius} ${radius} 0 ${+(Math.abs(sweep) > Math.PI)} ${+(sweep < 0)} ${b}`});
  const bent = start + sweep - ahead * Math.min(0.45 * size / radius, Math.abs(sweep) / 2);
  head(svg, kind, b, towards(bent + ahead * Math.PI / 2), size);
  const count = Math.max(8, Math.floor(Math.abs(sweep) * radius / 5));
  for (let k = 0; k <= count; k++) crowd.points.push(on(start + sweep * k / count));
  return (share) => [on(start + sweep * share), towards(start + sweep * share)];
}
// A line aside of two places, with a head at both ends, and thin ones to it from the places.
function dimension(sheet, p, q, aside, name) {
  const away = left(unit(minus(q, p))), a = plus(p, away, aside), b = plus(q, away, aside);
  const way = unit(minus(b, a)), size = Math.min(8, 0.45 * length(minus(b, a)));
  for (const [from, to] of [[p, a], [q, b], [a, b]]) {
    line(sheet.svg, "dimension", from, to);
    sheet.crowd.clear(from, to);
  }
  head(sheet.svg, "dimension", b, way, size);
  head(sheet.svg, "dimension", a, opposite(way), size);
  sheet.want("dimension-text", name, beside(a, b, aside < 0 ? -1 : 1, 0.5));
}
// Anchors on a side of a segment, about a share of its length; 1: left.
const beside = (a, b, side, share) => [share, share + 0.15, share - 0.15].map((part) =>
  [plus(a, minus(b, a), part), left(minus(b, a)).map((u) => side * u)]);

function ground({svg, crowd}, at) {
  const local = (right, up) => [at[0] + 9 * right, at[1] - 9 * up];
  for (let k = 0; k < 7; k++) line(svg, "hatch", local(0.6 * k - 1.5, -1.7), local(0.6 * k - 2.1, -2.3));
  line(svg, "rail", local(-2.1, -1.7), local(2.1, -1.7));
  polygon(svg, "pin", [local(0, 0), local(-1.2, -1.7), local(1.2, -1.7)]);
  for (const depth of [-1.2, -2]) crowd.clear(local(-2, depth), local(2, depth));
}
function mark({svg, crowd}, kind, at, way = [1, 0]) {
  const across = left(way);
  if (kind === "slider") {
    polygon(svg, "pin", [[-1, -1], [1, -1], [1, 1], [-1, 1]].map(([a, b]) => plus(plus(at, way, 12 * a), across, 8 * b)));
  } else if (kind === "sphere") {
    circle(svg, "side", at, 8);
    circle(svg, "spot", plus(at, [-2.4, -2.4]), 2.4);
  } else if (kind) circle(svg, "pin", at, 6);
  if (kind) crowd.clear(plus(at, [-6, 0]), plus(at, [6, 0]), 6);
}
function centre({svg, crowd}, at) {
  circle(svg, "com", at, 6);
  put(svg, "path", {class: "comq", d: [-1, 1].map((k) => `M${at}h${6 * k}A6 6 0 0 0 ${at[0]} ${at[1] - 6 * k}Z`).join("")});
  crowd.clear(plus(at, [-5, 0]), plus(at, [5, 0]), 5);
}
function bar({svg, crowd}, a, b, width) {
  line(svg, "edge", a, b, width + 2.4);
  line(svg, "bar", a, b, width);
  crowd.clear(a, b, width / 2 + 2);
}

// Corners of the convex hull.
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const half = (points) => {
    const kept = [];
    for (const c of points) {
      const isRight = ([a, b] = kept.slice(-2)) => (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) <= 0;
      while (kept.length > 1 && isRight()) kept.pop();
      kept.push(c);
    }
    return kept.slice(0, -1);
  };
  return [...half(sorted), ...half(sorted.reverse())];
}
// A short solid along a direction of space, of measures in the drawing's pixels.
function prism({svg, crowd}, at, axis, radius, half, sides, toViewer) {
  const least = axis.map(Math.abs), first = unit(cross(axis, [0, 1, 2].map((k) => +(k === least.indexOf(Math.min(...least))))));
  const second = cross(axis, first), turned = sides === 4 ? Math.PI / 4 : 0;
  const ring = (far) => Array.from({length: sides}, (_, k) => {
    const angle = turned + 2 * Math.PI * k / sides;
    const v = [0, 1, 2].map((i) => radius * (Math.cos(angle) * first[i] + Math.sin(angle) * second[i]) + far * axis[i]);
    return plus(at, onPage(v));
  });
  const near = dot(axis, toViewer) < 0 ? -half : half, rings = [ring(near), ring(-near)], outline = hull(rings.flat());
  polygon(svg, "side", outline);
  polygon(svg, "cap", rings[0]);
  outline.forEach((place, k) => crowd.clear(place, outline[(k + 1) % outline.length]));
}
const onPage = (v) => { const [x, y] = seen(v); return [x, -y]; };
