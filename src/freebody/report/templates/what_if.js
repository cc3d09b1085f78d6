// What if: torques of the motion under another load, at another pace, on a tilted base, computed by the
// kernel in this page, once it has given Python's own numbers.

const CLOSE = 1e-9;
const largestOf = (values) => values.reduce((most, x) => Math.max(most, Math.abs(x)), 0);

class WhatIf {
  constructor(player, {what, nv, drives}, rates, expected) {
    Object.assign(this, {player, what, nv, drives, rates, between: new Set(what.between)});  // peaks and means are of samples
    const fault = this.unlike(expected);
    if (fault) {
      find("what").remove();
      find("unlike").textContent = `No sliders: ${fault}`;
      return;
    }
    find("unlike").remove();
    this.given = this.found;
    this.sliders = ["load", "pace", "tilt"].map(find).filter(Boolean);
    this.begin = this.sliders.map((slider) => slider.value);
    for (const slider of this.sliders) slider.addEventListener("input", () => this.follow());
    find("as-given").addEventListener("click", () => { this.sliders.forEach((slider, k) => { slider.value = this.begin[k]; }); this.follow(); });
    this.follow();
  }
  // Torques at all instants: for each coordinate its curve, with its largest, its mean square and power.
  compute(load, pace, tilt) {
    const {player: {t, q}, nv, rates, what} = this, count = t.length, gravity = turned(what.gravity, -tilt * Math.PI / 180);
    const curves = Array.from({length: nv}, () => new Float64Array(count)), qd = new Float64Array(nv), qdd = new Float64Array(nv), tau = new Float64Array(nv);
    for (let k = 0; k < count; k++) {
      for (let i = 0; i < nv; i++) {
        qd[i] = pace * rates[k * nv + i];
        qdd[i] = pace * pace * rates[(count + k) * nv + i];
      }
      torques(q[k], qd, qdd, [load], gravity, tau);
      for (let i = 0; i < nv; i++) curves[i][k] = tau[i];
    }
    return {curves, pace};
  }
  // The share that is used of a limit, with the instant; of a mean none.
  use({quantity, column, limit, fraction, value, time, ...rest}, {curves, pace}) {
    const {player: {t}, nv, rates, between} = this, curve = curves[column], at = (numbers) => {
      let k = 0;
      numbers.forEach((x, j) => { if (!between.has(j) && Math.abs(x) > Math.abs(numbers[k])) k = j; });
      return {value: Math.abs(numbers[k]), time: t[k]};
    };
    let found = {value, time};
    if (quantity === "speed") found = {value: pace * Math.abs(value), time};
    else if (quantity === "power") found = at(curve.map((x, k) => x * pace * rates[k * nv + column]));
    else if (quantity.startsWith("RMS")) found = {value: Math.sqrt(meanSquare(t, curve, between)), time: null};
    else if (quantity !== "position") found = at(curve);
    const share = quantity === "position" ? fraction : quantity === "speed" ? pace * fraction : found.value / limit;
    return {...rest, ...found, quantity, limit, share};
  }
  // Words on how the numbers of this page differ from Python's; empty where they do not.
  unlike(expected) {
    const {what, nv} = this;
    this.found = this.compute(0, 1, 0);
    const {curves} = this.found, size = curves.map((curve) => Math.max(largestOf(curve), 1));
    for (const [j, k] of what.checked.entries()) {
      for (let i = 0; i < nv; i++) {
        if (!(Math.abs(curves[i][k] - expected[j * nv + i]) <= CLOSE * size[i])) return "the torques that this page computes are not those that Python wrote.";
      }
    }
    for (const use of what.uses) {
      if (use.quantity.startsWith("RMS") && !what.whole) continue;
      if (!(Math.abs(this.use(use, this.found).share - use.fraction) <= CLOSE * Math.max(use.fraction, 1))) return `the use of a limit that this page computes (${use.quantity} of ${use.name}) is not the one that Python wrote.`;
    }
    return "";
  }
  follow() {
    const value = (id, none) => (find(id) ? Number(find(id).value) : none), [load, pace, tilt] = [value("load", 0), value("pace", 1), value("tilt", 0)];
    const plain = this.sliders.every((slider, k) => Number(slider.value) === Number(this.begin[k]));
    for (const [id, text] of [["load", `${significant(load)} kg`], ["pace", `${pace.toFixed(2)}×`], ["tilt", `${tilt}°`.replace("-", "\u2212")]]) if (find(id)) find(`${id}-now`).textContent = text;
    find("as-given").disabled = plain;
    this.found = plain ? this.given : this.compute(load, pace, tilt);
    this.player.robot.pace = pace;
    document.documentElement.classList.toggle("otherwise", !plain);
    this.tell();
    for (const {coordinate, effort, speed} of this.drives) {
      again(this.player.columns[effort], plain ? null : this.found.curves[coordinate]);
      again(this.player.columns[speed], plain ? null : this.player.columns[speed].given.map((x) => pace * x));
    }
    for (const reading of this.player.readings) reading.again();
    this.player.show(this.player.k);
  }
  // The largest share of limits of which the verdict does not tell, since it depends on numbers that are
  // wrong: what the table shows all the same.
  loose() {
    const {curves} = this.found, {t} = this.player, known = new Set(this.what.uses.map(({quantity, column}) => `${quantity} ${column}`));
    return this.drives.flatMap(({coordinate, name, unit, limit}) => {
      const quantity = unit === "N m" ? "torque" : "force", curve = curves[coordinate], value = largestOf(curve);
      if (!limit || known.has(`${quantity} ${coordinate}`)) return [];
      return [{quantity, name, unit, limit, value, time: t[curve.findIndex((x) => Math.abs(x) === value)], share: value / limit}];
    }).sort((a, b) => b.share - a.share);
  }
  // The table, and the limit that is nearest.
  tell() {
    const {curves} = this.found;
    for (const row of document.querySelectorAll("[data-drive]")) {
      const {coordinate, unit, limit} = this.drives[Number(row.dataset.drive)], cells = row.querySelectorAll("td"), peak = largestOf(curves[coordinate]);
      cells[0].textContent = `${significant(largestOf(this.given.curves[coordinate]), 4)} ${unit}`;
      cells[1].textContent = `${significant(peak, 4)} ${unit}`;
      cells[2].textContent = `${significant(Math.sqrt(meanSquare(this.player.t, curves[coordinate], this.between)), 4)} ${unit}`;
      cells[3].textContent = limit ? percent(peak / limit) : "no limit";
      cells[3].classList.toggle("over", limit !== null && peak > limit * (1 + CLOSE));
    }
    const uses = this.what.uses.map((use) => this.use(use, this.found)).sort((a, b) => b.share - a.share), over = uses.filter(({share}) => share > 1 + CLOSE);
    const sure = over.filter(({doubtful}) => !doubtful), beyond = [...over, ...this.loose().filter(({share}) => share > 1 + CLOSE)];
    const others = sure.length > 1 ? `; ${sure.length} limits are exceeded` : "";
    let words = "Not judged: no limit is told of.";
    if (sure.length) words = `Not feasible: ${told(sure[0])}${others}.`;
    else if (beyond.length) words = `Not judged; by the numbers that there are ${told(beyond[0])}.`;
    else if (uses.length) words = `${this.what.barred ? "Not judged; the limits that are told of are kept" : "Within every limit"}; nearest: ${told(uses[0])}.`;
    find("recomputed").textContent = words;
    find("recomputed").classList.toggle("bad", beyond.length > 0);
  }
}
const percent = (share) => `${share > 1 && share < 1.01 ? (100 * share).toPrecision(6) : significant(100 * share)} %`;
function told({quantity, name, value, limit, share, time, unit, words}) {
  if (quantity === "position") return words;
  const when = time === null ? "" : ` at t = ${significant(time)} s`;
  return `the ${quantity} of ${name} is ${significant(value, 4)} ${unit}${when}, ${percent(share)} of its limit of ${significant(limit, 4)} ${unit}`;
}
// A column of numbers that is computed anew; null: as given.
function again(column, values) {
  column.values = values || column.given;
  column.anew = values !== null;
  column.largest = largestOf(column.values);
}
function meanSquare(t, x, between) {
  let sum = 0, last = 0;
  for (let k = 1; k < t.length; k++) {
    if (between.has(k)) continue;
    sum += (t[k] - t[last]) * (x[k] ** 2 + x[last] ** 2) / 2;
    last = k;
  }
  return sum / (t[t.length - 1] - t[0]);
}
// A vector turned about x, in the plane about its normal.
function turned(vector, angle) {
  const [c, s] = angle ? [Math.cos(angle), Math.sin(angle)] : [1, 0], [x, y, z] = vector;
  return vector.length === 2 ? [c * x - s * y, s * x + c * y] : [x, c * y - s * z, s * y + c * z];
}
