// Vectors of the page and of space, as arrays of numbers. On the page y points down.

const length = (v) => Math.hypot(...v);
const unit = (v) => { const far = length(v) || 1; return v.map((u) => u / far); };
const plus = (a, b, share = 1) => a.map((u, k) => u + share * b[k]);
const minus = (a, b) => a.map((u, k) => u - b[k]);
const opposite = (v) => v.map((u) => -u);
const left = ([x, y]) => [y, -x];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const towards = (angle) => [Math.cos(angle), -Math.sin(angle)];
function dot(a, b) {
  let total = 0;
  for (let k = 0; k < a.length; k++) total += a[k] * b[k];
  return total;
}
