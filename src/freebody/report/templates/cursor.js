// One cursor through a motion: it moves robots, curves and the table of this instant.

const find = (id) => document.getElementById(id);

// A plot on the page: a vertical line with a dot on each curve, and what they are there.
class Reading {
  constructor(figure, plot, columns, times) {
    Object.assign(this, {figure, plot, columns, times, svg: figure.querySelector("svg"), seen: false});
    this.line = put(this.svg, "line", {class: "cursor"});
    this.dots = plot.curves.map(({colour}) => put(this.svg, "circle", {class: `spot${colour} f${colour}`, cx: -99, r: 3}));
    this.text = document.createElement("p");
    this.text.className = "reading";
    const [left, top, right, bottom] = plot.page, box = {x: left, y: top, width: right - left, height: bottom - top, viewBox: `${left} ${top} ${right - left} ${bottom - top}`};
    this.within = put(this.svg, "svg", box);
    this.values = plot.curves.map(({name, colour}) => {
      const item = document.createElement("span"), mark = put(item, "svg", {class: "fig", width: 9, height: 9, "aria-hidden": "true"}), value = document.createElement("b");
      put(mark, "circle", {class: `f${colour}`, cx: 4.5, cy: 4.5, r: 4});
      item.append(` ${name} `, value);
      this.text.append(item, " ");
      return value;
    });
    this.beyond = document.createElement("span");
    this.text.append(this.beyond);
    this.again();
    this.svg.after(this.text);
  }
  place(t, value) {
    const {page: [left, top, right, bottom], time: [a, b], range: [low, high], log} = this.plot;
    const y = log ? Math.log10(Math.max(Math.abs(value), 1e-300)) : value;
    return [left + (t - a) / (b - a || 1) * (right - left), bottom - (y - low) / (high - low) * (bottom - top)];
  }
  show(t, k) {
    const [x] = this.place(t, 0), {unit, page: [, top,, bottom]} = this.plot;
    for (const [end, value] of Object.entries({x1: x, y1: top, x2: x, y2: bottom})) this.line.setAttribute(end, value);
    this.columns.forEach((column, i) => {
      const value = column.values[k], [, y] = this.place(t, value);
      this.dots[i].setAttribute("cx", x);
      this.dots[i].setAttribute("cy", y >= this.plot.page[1] && y <= this.plot.page[3] ? y : -99);
      this.values[i].textContent = Number.isNaN(value) ? "over" : `${onCurve(value, column.largest)} ${unit}`;
    });
  }
  // Draws the curves that are computed anew, as far as they lie in the plot; the others are as given.
  again() {
    const [low, high] = this.plot.range, left = [];
    this.within.replaceChildren();
    this.columns.forEach((column, i) => {
      this.values[i].parentElement.classList.toggle("anew", Boolean(column.anew));
      if (!column.anew) return;
      const points = Array.from(this.times, (t, k) => this.place(t, column.values[k]).map((x) => x.toFixed(1)).join(" "));
      put(this.within, "path", {class: "again", d: `M${points.join("L")}`});
      const ends = [Math.min(...column.values), Math.max(...column.values)];
      if (ends[0] < low || ends[1] > high) left.push(...ends);
    });
    const [least, most] = left.map((x) => significant(x));
    this.beyond.textContent = left.length ? `The dashed curve leaves the plot: ${least} to ${most} ${this.plot.unit}` : "";
    this.beyond.className = "anew beyond";
  }
  // The time at a place of the window.
  time(clientX) {
    const box = this.svg.getBoundingClientRect(), x = (clientX - box.left) / box.width * this.svg.viewBox.baseVal.width;
    const {page: [left,, right], time: [a, b]} = this.plot;
    return a + (x - left) / (right - left) * (b - a);
  }
}

// Pixels: the longest arrow on the robot, the radius of an arc; shares of the largest that are seen.
const LONGEST = 60, ROUND = 21, WHOLE = 1.5 * Math.PI, LEAST = 0.02;
const BENDS = 200;  // of the tip's path: more are not seen, and take half of a frame's time
// A direction of space across another, and one across both.
function acrossBoth(way) {
  const k = mostAcross(way), first = unit(minus([0, 1, 2].map((i) => +(i === k)), way.map((x) => x * way[k])));
  return [first, cross(way, first)];
}

// A robot that moves through positions, one for each instant; columns: the curves that it is told of.
class MovingRobot {
  constructor(data, canvas, svg, place, q, columns, options = {}) {
    const {scene, bodies} = data;
    Object.assign(this, {data, columns, q, k: 0, pace: 1});
    this.stage = new Stage(canvas, svg, scene, bodies, place, {notes: (stage) => this.acting(stage), ...options});
    this.stage.frame(this.q.filter((_, k) => k % Math.ceil(this.q.length / 40) === 0));
    const tips = scene.tip ? this.stage.places(this.q, scene.tip) : [];
    this.stage.path = tips.filter((_, k, {length}) => k % Math.ceil(length / BENDS) === 0 || k === length - 1);
  }
  show(k) {
    this.k = k;
    this.stage.show(this.q[k]);
  }
  // Makes the arrows of the key as long as those on the robot, in a drawing that is shown smaller.
  keyed({surface: {seen: [wide], wide: drawn}}) {
    if (this.share === wide / drawn) return;
    this.share = wide / drawn;
    for (const key of document.querySelectorAll(".key svg")) key.style.width = `${key.viewBox.baseVal.width * this.share}px`;
  }
  // The torques and forces of the drives, and the velocity of the tip, on the robot.
  acting(stage) {
    this.keyed(stage);
    const {data: {drives, arrows, scene}, columns, k, pace} = this, {sheet} = stage;
    for (const {at, axis, effort, unit: of} of drives) {
      const share = columns[effort].values[k] / arrows.lengths[of];
      if (!axis || !(Math.abs(share) > LEAST)) continue;
      const way = wayInWorld(stage.frames, axis), from = stage.at(at);
      if (of === "N") arrow(sheet, "external", from, plus(from, stage.onSheet(way), LONGEST * share));
      else arc(sheet, "moment", from, ROUND, 0, WHOLE * Math.max(-1.2, Math.min(share, 1.2)), 8, acrossBoth(way).map((one) => stage.onSheet(one)));
    }
    const v = arrows.tip.map((column) => pace * columns[column].values[k]), far = length(v) / arrows.lengths["m/s"];
    if (!(far > LEAST)) return;
    const from = stage.at(scene.tip);
    arrow(sheet, "velocity", from, plus(from, stage.onSheet([...v, 0].slice(0, 3)), LONGEST / arrows.lengths["m/s"]));
  }
}

class Cursor {
  // t: the instants; plots: the curves over them, with columns of numbers.
  constructor(robots, t, {plots, first}, columns) {
    Object.assign(this, {robots, t, columns, k: first, speed: 1, playing: false, work: []});
    this.readings = [...document.querySelectorAll("[data-plot]")].map((figure) => {
      const plot = plots[Number(figure.dataset.plot)];
      return new Reading(figure, plot, plot.curves.map(({column}) => columns[column]), t);
    });
    const seen = new IntersectionObserver((entries) => {
      for (const {target, isIntersecting} of entries) this.readings.find(({figure}) => figure === target).seen = isIntersecting;
      this.read();
    }, {rootMargin: "200px"});
    for (const reading of this.readings) {
      const {figure, svg} = reading, hover = (event) => { this.pause(); this.seek(reading.time(event.clientX)); };
      seen.observe(figure);
      svg.addEventListener("pointermove", hover);
      svg.addEventListener("pointerdown", hover);
    }
    this.rows = [...document.querySelectorAll("[data-now]")].map((cell) => ({cell, column: columns[Number(cell.dataset.now)]}));
    this.ends = [...document.querySelectorAll("[data-end]")].map((words) => ({words, end: Number(words.dataset.end)}));
    this.slider = find("time");
    Object.assign(this.slider, {min: 0, max: t.length - 1, step: 1});
    this.slider.addEventListener("input", () => { this.pause(); this.show(Number(this.slider.value)); });
    find("play").addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    find("speed").addEventListener("change", () => { this.speed = Number(find("speed").value); this.begin(); });
    for (const button of document.querySelectorAll("[data-instant]")) {
      button.addEventListener("click", () => { this.pause(); this.show(Number(button.dataset.instant)); });
    }
    for (const {stage: {canvas}} of robots) {
      canvas.addEventListener("keydown", (event) => {
        if (event.key !== " ") return;
        event.preventDefault();
        find("play").click();
      });
    }
    this.show(this.k);
  }
  // The nearest instant to a time.
  nearest(time) {
    let low = 0, high = this.t.length - 1;
    while (high - low > 1) { const middle = low + high >> 1; if (this.t[middle] <= time) low = middle; else high = middle; }
    return Math.abs(this.t[high] - time) < Math.abs(time - this.t[low]) ? high : low;
  }
  seek(time) { this.show(this.nearest(time)); }
  show(k) {
    const start = performance.now();
    this.k = k;
    for (const robot of this.robots) robot.show(k);
    this.slider.value = k;
    this.slider.setAttribute("aria-valuetext", `${this.t[k].toFixed(3)} s`);
    find("instant").textContent = `${this.t[k].toFixed(3)} s`;
    for (const {cell, column} of this.rows) cell.textContent = Number.isNaN(column.values[k]) ? "–" : onCurve(column.values[k], column.largest);
    for (const {words, end} of this.ends) words.hidden = this.t[k] <= end;
    this.read();
    this.work.push(performance.now() - start);
    if (this.work.length > 600) this.work.shift();
  }
  read() { for (const one of this.readings) if (one.seen) one.show(this.t[this.k], this.k); }
  hurry(quick) { for (const {stage} of this.robots) stage.hurry(quick); }
  // Time runs from what is shown now.
  begin() { this.began = [performance.now(), this.t[this.k]]; }
  play() {
    this.playing = true;
    this.hurry(true);
    if (this.k === this.t.length - 1) this.k = 0;
    this.begin();
    find("play").textContent = "Pause";
    const end = this.t[this.t.length - 1], first = this.t[0], run = () => {
      if (!this.playing) return;
      let time = this.began[1] + (performance.now() - this.began[0]) / 1000 * this.speed;
      const over = time >= end, again = find("loop").checked;
      if (over && again) {
        time = first + (time - first) % (end - first || 1);
        this.began = [performance.now(), time];
      }
      const k = this.nearest(Math.min(time, end));
      if (k !== this.k) this.show(k);
      if (over && !again) this.pause(); else requestAnimationFrame(run);
    };
    requestAnimationFrame(run);
  }
  pause() {
    this.playing = false;
    this.hurry(false);
    find("play").textContent = "Play";
  }
}

// Curves at `count` instants, one behind the other; what is computed anew takes the place of its own.
const curvesOf = (values, count) => Array.from({length: values.length / count}, (_, k) => {
  const own = values.subarray(k * count, (k + 1) * count);
  return {values: own, given: own, anew: false, largest: own.reduce((most, x) => Math.max(most, Math.abs(x) || 0), 0)};
});
const positionsOf = (q, nq) => Array.from({length: q.length / nq}, (_, k) => q.subarray(k * nq, (k + 1) * nq));
const unpacked = async (pack) => JSON.parse(new TextDecoder().decode(await inflated(pack)));
// Shows what moves instead of what stands still.
function moves() {
  document.documentElement.classList.add("moves");
  for (const hidden of document.querySelectorAll(".moving[hidden]")) hidden.hidden = false;
}
