// Python's own results at several states, which the kernels of a page have to give before it offers
// anything.

const CLOSE = 1e-9;
const largestOf = (values) => values.reduce((most, x) => Math.max(most, Math.abs(x) || 0), 0);
const alike = (a, b, size) => (Number.isNaN(b) ? Number.isNaN(a) : Math.abs(a - b) <= CLOSE * size);

// The name of a kernel that gives other numbers than Python's; empty where none does.
async function unlike(proofs) {
  for (const [name, {inputs, outputs, rows}] of Object.entries(proofs)) {
    const all = await numbers(rows, Float64Array), sizes = [...inputs.map((size) => size || 1), ...outputs];
    const wide = sizes.reduce((sum, size) => sum + size, 0), taken = [];
    for (let start = 0; start < all.length; start += wide) {
      let at = start;
      const parts = sizes.map((size) => { at += size; return all.slice(at - size, at); });
      const given = parts.slice(0, inputs.length).map((part, k) => (inputs[k] ? part : part[0]));
      const made = outputs.map((size) => new Float64Array(size));
      kernels[name](...given, ...made);
      taken.push([made, parts.slice(inputs.length)]);
    }
    for (const k of outputs.keys()) {
      const size = largestOf(taken.flatMap(([, expected]) => [...expected[k]])) || 1;
      if (!taken.every(([made, expected]) => made[k].every((x, i) => alike(x, expected[k][i], size)))) return name;
    }
  }
  return "";
}
