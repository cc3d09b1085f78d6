// The page of a studio: sliders, fields and buttons, and what they show.

const find = (id) => document.getElementById(id);
const DEGREES = 180 / Math.PI, SETTLES = 200;  // ms
// A position as it is read: degrees or metres.
const told = ({turns}, value) => (turns ? `${onCurve(DEGREES * value, 100, 4)}°` : `${onCurve(value, 1, 4)} m`);

class Studio {
  constructor(studio) {
    const state = new State(studio);
    Object.assign(this, {studio, state, work: []});
    this.bench = new Bench(find("canvas"), find("names"), studio, state, {
      joint: (joint, value) => this.change(() => state.lead(joint, value)),
      tip: (place) => this.pull(place),
    });
    this.run = new Run(state, () => this.show(), (words) => { this.say(words); this.running(); });
    this.rows = [...document.querySelectorAll("[data-joint]")].map((row) => {
      const joint = studio.joints[Number(row.dataset.joint)], slider = row.querySelector("input"), cell = (name) => row.querySelector(`.${name}`);
      slider.addEventListener("input", () => this.change(() => state.lead(joint, Number(slider.value))));
      return {joint, slider, value: cell("at"), torque: cell("torque"), share: cell("share")};
    });
    this.places = [...document.querySelectorAll("[data-place]")];
    for (const field of this.places) field.addEventListener("input", () => this.typed());
    this.on("load", "input", (field) => this.change(() => { state.mass = Number(field.value); }));
    this.on("ellipsoid", "change", (field) => { this.bench.ellipsoid = field.value; this.show(); });
    this.on("drives", "change", (field) => { this.run.law = field.value; this.run.begin(); });
    this.on("stops", "change", (field) => { this.run.stops = field.checked; });
    this.on("run", "click", () => this.running(!this.run.on));
    this.on("first", "click", () => this.change(() => { state.q.set(studio.q0); state.qd.fill(0); }));
    this.on("still", "click", () => this.change(() => state.qd.fill(0)));
    this.on("branch", "click", () => this.listed());
    this.on("copy", "click", () => this.copied());
    this.show();
  }
  on(id, type, does) {
    const element = find(id);
    if (element) element.addEventListener(type, () => does(element));
  }
  say(words) { find("said").textContent = words; }
  // Changes the state by hand, which ends a simulation's count of energy.
  change(how) {
    const start = performance.now();
    this.hurry();
    how();
    this.run.begin();
    this.say("");
    this.show(start);
  }
  // Draws quickly while the robot is moved, and finely when it rests.
  hurry() {
    clearTimeout(this.resting);
    this.bench.hurry(true);
    this.resting = setTimeout(() => { if (!this.run.on) this.bench.hurry(false); }, SETTLES);
  }
  running(on = this.run.on) {
    if (on && !this.run.on) { this.say(""); this.run.start(); } else if (!on) this.run.stop();
    this.bench.hurry(on);
    find("run").textContent = on ? "Stop" : "Simulate";
    if (!on) this.show();
  }
  // Brings the tip to a place, or as near as the joints let it; false where it does not get there.
  pull(place) {
    const {state, studio: {dim}} = this, target = Float64Array.from(state.look().T), keep = find("keep").checked;
    for (let k = 0; k < dim; k++) target[k * (dim + 1) + dim] = place[k];
    let left = 0;
    this.change(() => { left = state.pull(target, keep); });
    if (left > 1e-6) this.say("The tip does not reach this place within the joints' limits; it is as near as it comes.");
    return left <= 1e-6;
  }
  typed() {
    const place = this.places.map((field) => field.valueAsNumber);
    if (place.every(Number.isFinite)) this.pull(place);
  }
  show(start = performance.now()) {
    const {state, studio, bench, run} = this;
    bench.show(state.q);
    this.joints();
    if (studio.arm) this.tip();
    const [kinetic, potential] = state.energy();
    find("time").textContent = `${run.t.toFixed(2)} s`;
    find("kinetic").textContent = `${significant(kinetic, 4)} J`;
    find("potential").textContent = `${significant(potential, 4)} J`;
    find("gained").textContent = `${significant(run.gained, 3)} J`;
    find("pace").textContent = run.on ? `${run.pace.toFixed(2)} of real time` : "";
    if (find("load")) find("load-now").textContent = `${significant(state.mass)} kg`;
    find("python").value = this.python();
    this.work.push(performance.now() - start);
    if (this.work.length > 600) this.work.shift();
  }
  joints() {
    const {state, studio: {driven}} = this, tau = state.held();
    for (const {joint, slider, value, torque, share} of this.rows) {
      const at = state.q[joint.at], {rate, unit, effort} = joint, words = told(joint, at);
      if (document.activeElement !== slider || this.run.on || Number(slider.value) !== at) slider.value = at;
      slider.setAttribute("aria-valuetext", words);
      value.textContent = words;
      value.classList.toggle("over", at < (joint.low ?? -Infinity) - CLOSE || at > (joint.high ?? Infinity) + CLOSE);
      const passive = !driven.includes(rate), used = effort === null ? 0 : Math.abs(tau[rate]) / effort;
      torque.textContent = passive && Math.abs(tau[rate]) < CLOSE * largestOf(tau) ? "passive" : `${significant(tau[rate])} ${unit}${passive ? " is missing" : ""}`;
      share.textContent = effort === null ? "no limit" : `${significant(100 * used)} % of ${significant(effort)} ${unit}`;
      share.classList.toggle("over", used > 1 + CLOSE);
    }
  }
  tip() {
    const {T, sizes} = this.state.look(), {dim} = this.studio, n = sizes.length;
    this.places.forEach((field, k) => { if (document.activeElement !== field) field.value = T[k * (dim + 1) + dim].toFixed(4); });
    if (n) {
      const least = sizes[n - 1], most = sizes[0];
      find("least").textContent = significant(least);
      find("condition").textContent = least > CLOSE * most ? significant(most / least) : "infinite";
      find("product").textContent = significant(sizes.reduce((product, x) => product * x, 1));
      find("near").textContent = least < 1e-3 * most ? "At a singular pose, or next to one: in some direction the tip hardly moves." : "";
    }
    const axes = this.bench.ellipsoid && this.bench.axes(), [rate, unit] = this.bench.ellipsoid === "force" ? ["joint torques", "N"] : ["joint rates", "m/s"];
    find("axes").textContent = axes ? `${significant(axes.shortest)} to ${significant(axes.longest)} ${unit} at ${rate} of length 1` : this.bench.ellipsoid ? "next to singular: not drawn" : "";
  }
  listed() {
    const found = this.state.branches(), list = find("branches");
    list.replaceChildren(...found.map((q) => {
      const item = document.createElement("li"), button = document.createElement("button"), good = this.state.allowed(q);
      button.type = "button";
      button.textContent = this.studio.joints.map((joint) => told(joint, q[joint.at])).join(", ");
      button.addEventListener("click", () => this.change(() => { this.state.q.set(q); this.state.qd.fill(0); }));
      item.append(button, good ? "" : " beyond a joint's limits");
      return item;
    }));
    if (!found.length) this.say("No branch was found for the tip where it is.");
  }
  // The state as Python reads it, to the last bit.
  python() {
    const {q, qd, mass} = this.state, row = (name, values) => `${name} = [${Array.from(values, (x) => (Object.is(x, -0) ? 0 : x)).join(", ")}]`;
    const load = mass ? [`model = model.with_payload(${mass}, frame=${JSON.stringify(this.studio.tip)})`] : [];
    return [...load, row("q", q), ...(qd.some((x) => x !== 0) ? [row("qd", qd)] : [])].join("\n");
  }
  copied() {
    const field = find("python");
    field.focus();
    field.select();
    const done = () => this.say("Copied."), failed = () => this.say(document.execCommand("copy") ? "Copied." : "Copying is not allowed here; the text is selected.");
    if (navigator.clipboard) navigator.clipboard.writeText(field.value).then(done, failed); else failed();
  }
}

let page;
(async () => {
  const studio = JSON.parse(new TextDecoder().decode(await inflated("STUDIO"))), other = await unlike(studio.proofs);
  if (other) {
    find("unlike").hidden = false;
    find("unlike").textContent = `Nothing moves here: what this page computes as "${other}" is not what Python wrote. Another browser may do it right.`;
    return;
  }
  document.documentElement.classList.add("moves");
  for (const hidden of document.querySelectorAll(".moving[hidden]")) hidden.hidden = false;
  page = new Studio(studio);
})();
