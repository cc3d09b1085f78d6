// The symbols of textbooks as SVG, as figures have them. Places are [x, y] in pixels, y down.
// Everything is an element with attributes: the page's policy allows no other styles or code.

const SVG = "http://www.w3.org/2000/svg";
function put(parent, tag, attributes) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value !== undefined) made.setAttribute(name, value);
  }
  parent.append(made);
  return made;
}
const line = (parent, kind, a, b) => put(parent, "line", {class: kind, x1: a[0], y1: a[1], x2: b[0], y2: b[1]});
const circle = (parent, kind, [x, y], r) => put(parent, "circle", {class: kind, cx: x, cy: y, r});
const polygon = (parent, kind, points) => put(parent, "polygon", {class: kind, points: points.join(" ")});

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
// An arc from the direction `start` over `sweep` with a head where it ends; across: two directions
// of the page between which it turns, of a circle that is seen from aside.
function arc({svg, crowd}, kind, at, radius, start, sweep, size, across = [[1, 0], [0, -1]]) {
  const on = (angle) => plus(plus(at, across[0], radius * Math.cos(angle)), across[1], radius * Math.sin(angle));
  const ahead = Math.sign(sweep) || 1, count = Math.max(8, Math.floor(Math.abs(sweep) * radius / 5));
  const points = Array.from({length: count + 1}, (_, k) => on(start + sweep * k / count)), end = start + sweep;
  put(svg, "polyline", {class: kind, fill: "none", points: points.join(" ")});
  const bent = end - ahead * Math.min(0.45 * size / radius, Math.abs(sweep) / 2), way = minus(on(bent + 0.01 * ahead), on(bent - 0.01 * ahead));
  head(svg, kind, points[count], unit(way), size);
  crowd.points.push(...points);
  return (share) => [on(start + sweep * share), unit(minus(on(start + sweep * share), at))];
}
// Anchors on a side of a segment, about a share of its length; 1: left.
const beside = (a, b, side, share) => [share, share + 0.15, share - 0.15].map((part) =>
  [plus(a, minus(b, a), part), left(minus(b, a)).map((u) => side * u)]);
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
function centre({svg, crowd}, at) {
  circle(svg, "com", at, 6);
  put(svg, "path", {class: "comq", d: [-1, 1].map((k) => `M${at}h${6 * k}A6 6 0 0 0 ${at[0]} ${at[1] - 6 * k}Z`).join("")});
  crowd.clear(plus(at, [-5, 0]), plus(at, [5, 0]), 5);
}
// Anchors of a name: at a place in a direction or against it, and at the head of an arrow.
const both = (at, way) => [[at, way], [at, opposite(way)]];
const tipAnchors = (a, b) => {
  const way = minus(b, a);
  return [[b, length(way) > 1 ? way : [1, -1]], beside(a, b, 1, 0.5)[0], beside(a, b, -1, 0.5)[0]];
};
