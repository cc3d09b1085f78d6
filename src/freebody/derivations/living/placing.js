// Where arrows and names go, so that none lies on another.

const LETTER = 6.8, LINE = 13, STEP = 8;
const meet = (a, b) => a[0] < b[2] && b[0] < a[2] && a[1] < b[3] && b[1] < a[3];
const around = ([x, y], wide, tall) => [x - wide, y - tall, x + wide, y + tall];
const unit = (v) => v.map((u) => u / (length(v) || 1));

// Boxes along a line.
function along(from, to, half) {
  const count = Math.ceil(length(minus(to, from)) / STEP) || 1;
  return Array.from({length: count + 1}, (_, k) =>
    around([0, 1].map((i) => from[i] + (to[i] - from[i]) * k / count), half, half));
}

// Whether two arrows lie on one line, and on each other.
function covers(other, one) {
  const [u, v] = unit(other.along), [p, q] = unit(one.along), [x, y] = minus(one.from, other.from);
  if (Math.abs(u * q - v * p) > 0.15 || Math.abs(u * y - v * x) > 6) return false;
  const ends = [u * x + v * y, u * (x + one.along[0]) + v * (y + one.along[1])];
  return Math.min(Math.max(...ends), length(other.along)) - Math.max(Math.min(...ends), 0) > 3;
}
function spread(arrows) {
  arrows.forEach((one, k) => {
    const [u, v] = unit(one.along);
    for (let tries = 0; tries < 3 && arrows.slice(0, k).some((other) => covers(other, one)); tries++) {
      one.from = [one.from[0] - 8 * v, one.from[1] + 8 * u];
    }
  });
}

// Names beside their tips: the first place at which a name meets the fewest others.
function write(svg, names, taken, right, bottom) {
  for (const {kind, text, tip, way} of names) {
    const wide = LETTER * [...text].length / 2, tall = LINE / 2, [u, v] = way;
    const ways = [[u, v], [-v, u], [v, -u], [u - v, v + u], [u + v, v - u], [-u, -v]];
    const places = [6, 18].flatMap((away) => ways.map(([a, b]) => {
      const far = length([a, b]) || 1;
      return [tip[0] + (wide + away) * a / far, tip[1] + (tall + away) * b / far];
    }));
    const costs = places.map((place) => {
      const box = around(place, wide, tall), outside = box[0] < 0 || box[1] < 0 || box[2] > right || box[3] > bottom;
      return taken.filter((other) => meet(box, other)).length + (outside ? 100 : 0);
    });
    const place = places[costs.indexOf(Math.min(...costs))];
    for (let k = 0; k < 3; k++) taken.push(around(place, wide, tall));  // worse to meet than an arrow
    put(svg, "text", {class: `${kind}-text halo`, x: place[0], y: place[1] + 4, "text-anchor": "middle"}, text);
  }
}
