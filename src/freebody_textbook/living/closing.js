// What follows from the equations that the kernel evaluates: accelerations of joints without motor;
// in a closed chain the coordinates that are not driven, their rates, and the forces in the loops.

const STEPS = 60, CLOSED = 1e-12, SINGULAR = 1e-10, LONGEST_STEP = 0.4;

// x of A x = b, by elimination with the largest pivots; null where they vanish. Where there are more
// equations than unknowns, which in a loop agree with each other, Aᵀ A x = Aᵀ b.
function solved(A, b) {
  if (A.length > A[0].length) {
    const columns = A[0].map((_, k) => A.map((row) => row[k]));
    return solved(columns.map((u) => columns.map((v) => dot(u, v))), columns.map((u) => dot(u, b)));
  }
  const rows = A.map((row, k) => [...row, b[k]]), n = b.length;
  const size = Math.max(...A.flat().map(Math.abs));
  for (let k = 0; k < n; k++) {
    let best = k;
    for (let i = k + 1; i < n; i++) if (Math.abs(rows[i][k]) > Math.abs(rows[best][k])) best = i;
    [rows[k], rows[best]] = [rows[best], rows[k]];
    if (!(Math.abs(rows[k][k]) > SINGULAR * size)) return null;
    for (let i = 0; i < n; i++) {
      const factor = i === k ? 0 : rows[i][k] / rows[k][k];
      for (let j = k; j <= n && factor; j++) rows[i][j] -= factor * rows[k][j];
    }
  }
  return rows.map((row, k) => row[n] / row[k]);
}

// Of an open chain the accelerations of joints without motor: those for which they need none. What
// they need is linear in them.
function letGo(x, y, free) {
  const needs = (one) => {
    for (const at of free.accelerations) x[at] = at === one ? 1 : 0;
    live(x, y);
    return free.needs.map((k) => y[k]);
  };
  const still = needs(-1), columns = free.accelerations.map((at) => minus(needs(at), still));
  const found = solved(still.map((_, i) => columns.map((column) => column[i])), opposite(still));
  free.accelerations.forEach((at, k) => { x[at] = found ? found[k] : 0; });
}

// Whether the loops could be closed; x then holds the state that is, else it is as it was.
function close(x, y, loop) {
  const before = Float64Array.from(x), columns = loop.solved;
  const give = (names, values) => columns.forEach((k, i) => { x[names[k]] = values[i]; });
  const part = () => loop.jacobian.map((row) => columns.map((k) => y[row[k]]));
  const least = () => Math.max(...loop.phi.map((k) => Math.abs(y[k])));
  const giveUp = () => { x.set(before); return false; };
  const size = () => Math.max(...loop.jacobian.flat().map((k) => Math.abs(y[k])), 1e-300);
  live(x, y);
  for (let k = 0; k < STEPS && least() > CLOSED * size(); k++) {
    const step = solved(part(), loop.phi.map((k) => -y[k]));
    if (!step) return giveUp();
    const longest = Math.max(...step.map(Math.abs)), short = Math.min(1, LONGEST_STEP / longest);
    columns.forEach((k, i) => { x[loop.q[k]] += short * step[i]; });
    live(x, y);
  }
  if (!(least() <= 1e-10 * size())) return giveUp();
  const needed = (names, right) => solved(part(), loop.jacobian.map((row, i) =>
    names.reduce((total, at, k) => columns.includes(k) ? total : total - y[row[k]] * x[at], right[i])));
  for (const [names, right] of [[loop.qd, loop.phi.map(() => () => 0)], [loop.qdd, loop.c.map((k) => () => y[k])]]) {
    if (!names) continue;
    const found = needed(names, right.map((f) => f()));
    if (!found) return giveUp();
    give(names, found);
    live(x, y);
  }
  if (!loop.need.length) return true;  // all joints have motors: the forces are free
  const across = columns.map((k) => loop.jacobian.map((row) => y[row[k]]));
  const forces = solved(across, loop.need.map((k) => -y[k]));
  if (!forces) return giveUp();
  loop.multipliers.forEach((at, k) => { x[at] = forces[k]; });
  return true;
}
