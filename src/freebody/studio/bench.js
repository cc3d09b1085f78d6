// The robot under the reader's hand: joints dragged, the tip pulled, ellipsoids of its speeds and forces.

const GRIP = 16, RING = 9, ROUND = 64, SHARE = 0.3, SLIM = 1e-3, TINY = 1e-6, AROUND = 1.25, LEAST = 400;  // pixels squared for each radian or metre squared
class Bench extends Stage {
  // act.joint(joint, position) and act.tip(place) move the robot.
  constructor(canvas, svg, studio, state, act) {
    super(canvas, svg, studio.scene, studio.bodies, kernels.placed, {notes: () => this.marks()});
    Object.assign(this, {studio, state, act, ellipsoid: ""});
    this.frame([state.q], AROUND);
    const box = canvas.parentElement;
    for (const [type, does] of [["pointerdown", "grab"], ["pointermove", "drag"], ["pointerup", "release"], ["pointercancel", "release"]]) box.addEventListener(type, (event) => this[does](event), true);
  }
  // The ring by which the tip is pulled, and the ellipsoid about it.
  marks() {
    if (!this.studio.arm) return;
    this.outline();
    circle(this.svg, "handle", this.at(this.scene.tip), RING);
  }
  // The ellipsoid's outline: the projection of J J' (or its inverse) by the view is that of an ellipse.
  outline() {
    const found = this.ellipsoid && this.axes();
    if (!found) return;
    const {right, up} = this.camera, [x, y] = this.at(this.scene.tip), {matrix, longest} = found;
    const size = Math.hypot(...[0, 1, 2].map((k) => this.scene.box[1][k] - this.scene.box[0][k]));
    const factor = SHARE / 2 * size * this.scale / longest;
    const form = (a, b) => dot(a, matrix.map((row) => dot(row, b))), [a, b, c] = [form(right, right), form(right, up), form(up, up)];
    const mean = (a + c) / 2, half = Math.hypot((a - c) / 2, b), angle = Math.atan2(2 * b, a - c) / 2;
    const [long, short] = [mean + half, mean - half].map((square) => factor * Math.sqrt(Math.max(square, 0))), [cos, sin] = [Math.cos(angle), Math.sin(angle)];
    const points = Array.from({length: ROUND}, (_, k) => {
      const u = long * Math.cos(2 * Math.PI * k / ROUND), v = short * Math.sin(2 * Math.PI * k / ROUND);
      return `${(x + u * cos - v * sin).toFixed(1)} ${(y - u * sin - v * cos).toFixed(1)}`;
    });
    put(this.svg, "path", {class: `oval ${this.ellipsoid}`, d: `M${points.join("L")}Z`});
  }
  // The matrix whose square roots are the ellipsoid, and its longest and shortest half-axis; null where
  // the robot is too near to a singular pose.
  axes() {
    const {J} = this.state.look(), {dim, nv} = this.studio, row = (i) => J.subarray(i * nv, (i + 1) * nv);
    const A = [0, 1, 2].map((i) => [0, 1, 2].map((j) => (i < dim && j < dim ? row(i).reduce((sum, x, k) => sum + x * J[j * nv + k], 0) : 0)));
    const long = Math.sqrt(strongest(A)), back = inverse(A, dim), least = back ? 1 / Math.sqrt(strongest(back)) : 0;
    if (this.ellipsoid === "velocity") return long > 0 ? {matrix: A, longest: long, shortest: least} : null;
    return least > SLIM * long ? {matrix: back, longest: 1 / least, shortest: 1 / long} : null;
  }
  pointed(event) {
    const box = this.canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  }
  grab(event) {
    const [x, y] = this.pointed(event);
    if (event.shiftKey || this.held) return;
    if (this.studio.arm) {
      const [a, b] = this.at(this.scene.tip);
      if (Math.hypot(x - a, y - b) < GRIP) this.held = {from: [x, y], place: inWorld(this.frames, this.scene.tip)};
    }
    this.held ||= this.picked(x, y);
    if (!this.held) return;  // the view is turned
    this.held.pointer = event.pointerId;
    this.canvas.parentElement.setPointerCapture(event.pointerId);
    event.stopPropagation();
    this.canvas.focus({preventScroll: true});
    event.preventDefault();
  }
  // What is nearest to the viewer under a point of the page: the joint that carries it, and the place.
  picked(x, y) {
    const {camera, scale} = this, {fine} = this.surface;
    let best = null;
    for (const [role, first, second, radius] of this.scene.solids) {
      if (role.length < 2) continue;
      const [a, b] = [first, second].map((end) => inWorld(this.frames, end)), [p, s] = [a, b].map((place) => camera.seen(place)), way = [0, 1].map((k) => (s[k] - p[k]) / fine);
      const along = Math.min(Math.max(((x - p[0] / fine) * way[0] + (y - p[1] / fine) * way[1]) / (way[0] ** 2 + way[1] ** 2 || 1), 0), 1);
      const far = Math.hypot(x - p[0] / fine - along * way[0], y - p[1] / fine - along * way[1]), depth = p[2] + along * (s[2] - p[2]);
      if (far > radius * scale + 3 || (best && depth <= best.depth)) continue;
      best = {depth, local: this.local((along < 0.5 ? first : second)[0], a.map((c, k) => c + along * (b[k] - c)))};
    }
    const joint = best && this.mover(best.local);
    return joint ? {joint, local: best.local} : null;
  }
  // The joint nearest to a place of the robot that moves it across the view; undefined without one.
  mover(local) {
    const {joints, carried, parents} = this.studio;
    for (let body = local[0] - 1; body >= 0; body = parents[body]) {
      const joint = joints[carried[body]];
      if (joint && this.slope(joint, local, this.state.q[joint.at]).square >= LEAST) return joint;
    }
    return undefined;
  }
  // Where a place of the robot is on the page with a joint at a position, and how it moves with that.
  slope(joint, local, value) {
    const [at, next] = [value, value + TINY].map((x) => {
      const trial = Float64Array.from(this.state.q);
      trial[joint.at] = x;
      this.place(trial, this.own);
      return this.at(local);
    });
    this.place(this.state.q, this.own);
    const d = [0, 1].map((i) => (next[i] - at[i]) / TINY);
    return {at, d, square: d[0] ** 2 + d[1] ** 2};
  }
  // A place of the world as one that is fixed in a frame.
  local(frame, place) {
    const at = FRAME * frame, d = [0, 1, 2].map((k) => place[k] - this.frames[at + 9 + k]);
    return [frame, ...[0, 1, 2].map((k) => dot(d, [0, 3, 6].map((row) => this.frames[at + row + k])))];
  }
  drag(event) {
    const {held} = this;
    if (!held || held.pointer !== event.pointerId) return;
    event.stopPropagation();
    const [x, y] = this.pointed(event);
    if (held.joint) this.follow(held, x, y);
    else {
      const {right, up} = this.camera, per = 1 / this.scale, [dx, dy] = [(x - held.from[0]) * per, (y - held.from[1]) * per];
      this.act.tip(held.place.map((c, k) => c + dx * right[k] - dy * up[k]));
    }
  }
  // Turns the grabbed joint until the grabbed place is as near to the pointer as it comes.
  follow({joint, local}, x, y) {
    let value = this.state.q[joint.at];
    for (let k = 0; k < 6; k++) {
      const {at, d, square} = this.slope(joint, local, value);
      if (square < LEAST) break;
      value += Math.min(Math.max(((x - at[0]) * d[0] + (y - at[1]) * d[1]) / square, -0.5), 0.5);
    }
    this.act.joint(joint, value);
  }
  release(event) {
    if (!this.held || this.held.pointer !== event.pointerId) return;
    event.stopPropagation();
    this.held = null;
    this.show(this.state.q);
  }
  // The view stays while a part is held, which would else slip from the hand.
  show(q) {
    this.pose(q);
    if (!this.held) this.widen();
    this.draw();
  }
}
// The largest eigenvalue of a symmetric matrix that has none below 0, by powers.
function strongest(A) {
  let v = [1, 0.7, 0.4], size = 0;
  for (let k = 0; k < 60; k++) {
    const w = A.map((row) => dot(row, v));
    size = Math.hypot(...w);
    if (!(size > 0)) return 0;
    v = w.map((x) => x / size);
  }
  return size;
}
// The inverse of a symmetric matrix, in the plane of its first two rows and columns; null without one.
function inverse(A, dim) {
  const [a, b, c] = dim === 3 ? A : [A[0], A[1], [0, 0, 1]], rows = [cross(b, c), cross(c, a), cross(a, b)], det = dot(a, rows[0]);
  if (!(det > 1e-300)) return null;
  return rows.map((row, i) => row.map((x, j) => (i < dim && j < dim ? x / det : 0)));
}
