// A simulation from where the robot stands, in real time or as near to it as this computer comes.

const BUDGET = 5, SLOWEST = 0.1, SWEEPS = 8;  // ms of a picture's time; s of time that is made up for
// On which side a position is beyond a joint's limits, 1 or -1; 0 within them.
const beyond = ({low, high}, x) => (high !== null && x > high ? 1 : low !== null && x < low ? -1 : 0);
const limit = ({low, high}, side) => (side > 0 ? high : low);
class Run {
  // changed() shows the state; ended(words) is called where it cannot go on.
  constructor(state, changed, ended) {
    const {nq, nv} = state.studio;
    Object.assign(this, {state, changed, ended, on: false, law: "off", stops: true, t: 0, work: 0, pace: 1});
    Object.assign(this, {nothing: new Float64Array(nv), pushed: new Float64Array(nv), next: [new Float64Array(nq), new Float64Array(nv)]});
    this.begin();
  }
  // Counts time and energy from here.
  begin() { Object.assign(this, {t: 0, work: 0, first: this.total()}); }
  total() { const [kinetic, potential] = this.state.energy(); return kinetic + potential; }
  // What the energy has gained beyond the drives' work, J.
  get gained() { return this.total() - this.first - this.work; }
  // Torques of the drives: none, or those that carry the robot's weight.
  torque() {
    const {state, nothing} = this;
    if (this.law === "off") return nothing;
    state.held();
    state.tau.forEach((_, k) => { if (!state.studio.driven.includes(k)) state.tau[k] = 0; });
    return state.tau;
  }
  // Makes steps; false where the state is no number any more, which leaves the last one that was.
  advance(count) {
    const {state, next: [q1, qd1]} = this, h = state.studio.step;
    for (let k = 0; k < count; k++) {
      const tau = this.torque();
      this.step(tau);
      if (this.stops) this.stopped(tau);
      if (!q1.every(Number.isFinite) || !qd1.every(Number.isFinite)) return false;
      tau.forEach((x, i) => { this.work += h * x * (state.qd[i] + qd1[i]) / 2; });
      state.q.set(q1);
      state.qd.set(qd1);
      this.t += h;
    }
    return true;
  }
  // Where a step with torques and pushes leads: into next.
  step(torques) {
    const {state, next: [q1, qd1]} = this;
    kernels.stepped(state.q, state.qd, torques, state.studio.step, ...state.load, q1, qd1);
  }
  // Joints that a step would lead beyond a limit come to rest there, without rebound: each stop pushes
  // back, as a torque during the step, by what takes its joint's speed away.
  stopped(tau) {
    const {state, next: [q1, qd1], pushed} = this, at = state.studio.joints.map((joint) => [joint, beyond(joint, q1[joint.at])]).filter(([{rate}, side]) => side && side * qd1[rate] > 0);
    if (!at.length) return;
    pushed.set(tau);
    for (let sweep = 0; sweep < (at.length > 1 ? SWEEPS : 1); sweep++) {
      for (const [{rate}, side] of at) {
        const speed = qd1[rate], before = pushed[rate];
        pushed[rate] = before - side;
        this.step(pushed);
        const slower = (speed - qd1[rate]) * side;
        // what has been pushed is taken back where it is too much, and no stop pulls
        pushed[rate] = slower > 0 ? tau[rate] - side * Math.max(side * (tau[rate] - before) + side * speed / slower, 0) : before;
        this.step(pushed);
      }
    }
    for (const [joint, side] of at) if (side * q1[joint.at] > side * limit(joint, side) && !state.studio.loops) q1[joint.at] = limit(joint, side);
  }
  start() {
    this.on = true;
    this.begin();
    let last = performance.now(), due = 0;
    const frame = (now) => {
      if (!this.on) return;
      const passed = Math.max(now - last, 0) / 1000, begin = performance.now(), h = this.state.studio.step, from = this.t;
      due += Math.min(passed, SLOWEST);
      last = now;
      while (due >= h && performance.now() - begin < BUDGET) {
        if (!this.advance(1)) { this.stop(); this.ended("The simulation stops here: it has no next state. In a closed chain the loops are singular or open; else the motion is too fast for its step."); return; }
        due -= h;
      }
      if (due >= h) due = 0;
      if (passed > 0) this.pace += 0.05 * ((this.t - from) / passed - this.pace);
      this.changed();
      requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }
  stop() { this.on = false; }
}
