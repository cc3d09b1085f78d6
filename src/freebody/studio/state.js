// Where the robot stands, and what its kernels tell of it.

const GOAL = 1e-12, PULLS = 40, LEAD = 4e-3, HEAVY = 1e4, NEWTON = 3, APART = 1e-3, RESTARTS = 60;
class State {
  constructor(studio) {
    const {nq, nv, dim, bodies} = studio;
    Object.assign(this, {studio, q: Float64Array.from(studio.q0), qd: new Float64Array(nv), mass: 0, weights: new Float64Array(nv)});
    Object.assign(this, {tau: new Float64Array(nv), q1: new Float64Array(nq), one: [0, 1, 2].map(() => new Float64Array(1)), energies: [0, 1].map(() => new Float64Array(1))});
    this.seen = [(dim + 1) ** 2, dim * nv, studio.sizes].map((size) => new Float64Array(size));
    this.frames = new Float64Array(12 * bodies);
  }
  // The load at the tip, as kernels take it.
  get load() { return this.studio.heaviest ? [[this.mass]] : []; }
  // Torques that hold the robot still.
  held() { return kernels.held(this.q, ...this.load, this.tau); }
  // Kinetic and potential energy, J.
  energy() {
    kernels.energies(this.q, this.qd, ...this.load, ...this.energies);
    return this.energies.map(([x]) => x);
  }
  // The tip's pose and Jacobian, and singular values of the counted rows.
  look() {
    kernels.looked(this.q, ...this.seen);
    const [T, J, sizes] = this.seen;
    return {T, J, sizes};
  }
  within(joint, value) { return Math.min(Math.max(value, joint.low ?? -Infinity), joint.high ?? Infinity); }
  // Moves a joint to a position, within its limits; of a closed chain as far as the loops allow.
  lead(joint, value) {
    const wanted = this.within(joint, value), {at, rate} = joint;
    this.qd.fill(0);
    if (!this.studio.loops) { this.q[at] = wanted; return; }
    this.weights.fill(1);
    this.weights[rate] = HEAVY;
    for (let far = wanted - this.q[at]; Math.abs(far) > 1e-9; far = wanted - this.q[at]) {
      const step = Math.sign(far) * Math.min(Math.abs(far), LEAD), before = this.q[at], trial = Float64Array.from(this.q);
      trial[at] += step;
      for (let k = 0; k < NEWTON; k++) { kernels.closed(trial, this.weights, this.q1); trial.set(this.q1); }
      if (!((trial[at] - before) * Math.sign(far) > Math.abs(step) / 2)) return;  // the loops hold it
      this.q.set(trial);
    }
  }
  // The joints' positions after steps from a start that bring the tip to a pose, or as near as they can.
  reached(start, target, whole) {
    const step = whole ? kernels.turned : kernels.pulled, [damped, left, longest] = this.one, q = Float64Array.from(start);
    damped[0] = this.studio.damping;
    for (let k = 0; k < PULLS; k++) {
      step(q, damped[0], target, this.q1, damped, left, longest);
      q.set(this.q1);
      if (!(left[0] > GOAL && longest[0] > GOAL)) break;
    }
    return {q, left: left[0]};
  }
  pull(target, whole) {
    const found = this.reached(this.q, target, whole);
    this.qd.fill(0);
    if (found.q.every(Number.isFinite)) this.q.set(found.q);
    return found.left;
  }
  // Positions of the joints with the tip where it is: all of a closed form, else what a search finds.
  branches() {
    const target = Float64Array.from(this.look().T), {joints, whole} = this.studio, found = [];
    const add = (q) => {
      if (found.every((other) => joints.some((joint) => joint.moves && apart(joint, q[joint.at], other[joint.at]) > APART))) found.push(q);
    };
    if (kernels.branches) {
      const [all, valid] = kernels.branches(target), size = this.q.length;
      valid.forEach((good, k) => { if (good) add(this.turnedInto(all.slice(k * size, (k + 1) * size))); });
      return found;
    }
    add(Float64Array.from(this.q));
    const chance = chances(1);
    for (let k = 0; k < RESTARTS && found.length < 9; k++) {
      const start = Float64Array.from(this.q);
      for (const joint of joints) if (joint.moves) start[joint.at] = joint.ends[0] + chance() * (joint.ends[1] - joint.ends[0]);
      const {q, left} = this.reached(start, target, whole);
      if (left < 1e-9) add(q);
    }
    return found;
  }
  // A branch with angles brought by whole turns into the joints' limits, where that can be; joints that do
  // not matter stay.
  turnedInto(q) {
    for (const {at, turns, low, high, moves} of this.studio.joints) {
      if (!moves) q[at] = this.q[at];
      if (!turns || low === null || high === null) continue;
      const around = [0, 2 * Math.PI, -2 * Math.PI].map((turn) => q[at] + turn).find((x) => x >= low && x <= high);
      if (around !== undefined) q[at] = around;
    }
    return q;
  }
  // Whether all joints are within their limits.
  allowed(q) { return this.studio.joints.every(({at, low, high}) => q[at] >= (low ?? -Infinity) - CLOSE && q[at] <= (high ?? Infinity) + CLOSE); }
}
const apart = (joint, a, b) => Math.abs(joint.turns ? Math.sin((a - b) / 2) * 2 : a - b);
// Numbers from 0 to 1, the same at each call (Park and Miller 1988).
function chances(seed) {
  let x = seed;
  return () => { x = x * 16807 % 2147483647; return x / 2147483647; };
}
