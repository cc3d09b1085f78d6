// Solids as triangles in the world: each has its shape once, and is placed anew in every pose.

const FRAME = 12, CAP = 4, FLAT = 6, OVAL = 2;
// A profile is turned about the line between both ends: distance from it, way beyond an end, which
// end, and the normal's two parts.
function profileOf(radius, round, half) {
  if (round === OVAL) return Array.from({length: 2 * CAP + 1}, (_, k) => {
    const angle = Math.PI / 2 * (k / CAP - 1), c = Math.cos(angle), s = Math.sin(angle);
    return [radius * c, 0, (1 + s) / 2, ...unit([half * c, radius * s])];
  });
  if (!round) return [[0, 0, 0, 0, -1], [radius, 0, 0, 0, -1], [radius, 0, 0, 1, 0], [radius, 0, 1, 1, 0], [radius, 0, 1, 0, 1], [0, 0, 1, 0, 1]];
  return [0, 1].flatMap((end) => Array.from({length: CAP + 1}, (_, k) => {
    const angle = Math.PI / 2 * (k / CAP + end - 1), c = Math.cos(angle), s = Math.sin(angle);
    return [radius * c, radius * s, end, c, s];
  }));
}
// Columns of a round solid belong to two of its sides; each side of a prism has two of its own.
function columnsOf(sides) {
  const angle = (k) => 2 * Math.PI * (k + 0.5) / sides;
  if (sides > FLAT) return {columns: Array.from({length: sides}, (_, k) => [angle(k), angle(k)]), next: (k) => [k, (k + 1) % sides]};
  const columns = Array.from({length: sides}, (_, k) => [[angle(k - 1), angle(k - 0.5)], [angle(k), angle(k - 0.5)]]).flat();
  return {columns, next: (k) => [2 * k, 2 * k + 1]};
}
// The number of the axis of a frame that is most across a direction; a solid within one frame keeps it.
const mostAcross = (way) => [0, 1, 2].reduce((best, k) => (Math.abs(way[k]) < Math.abs(way[best]) ? k : best), 0);

class Solid {
  constructor([role, a, b, radius, round, sides, bodies, side, ratio = 1]) {
    const profile = profileOf(radius, round, length(minus(b.slice(1), a.slice(1))) / 2), {columns, next} = columnsOf(sides), rows = profile.length;
    Object.assign(this, {role, a, b, round, bodies, side, wide: Boolean(side) || (a[0] === b[0] && length(minus(a.slice(1), b.slice(1))) < radius), triangles: [], across: a[0] === b[0] ? mostAcross([1, 2, 3].map((k) => b[k] - a[k])) : -1});
    this.local = columns.flatMap(([angle, normal]) => profile.map(([far, along, end, out, up]) =>
      [far * Math.cos(angle), ratio * far * Math.sin(angle), along, end, ...unit([out * Math.cos(normal), out * Math.sin(normal) / ratio, up])])).flat();
    for (let side = 0; side < sides; side++) {
      const [left, right] = next(side).map((k) => k * rows);
      for (let k = 0; k + 1 < rows; k++) {
        const [now, then] = [profile[k], profile[k + 1]];
        if (now[0] === then[0] && now[1] === then[1] && now[2] === then[2]) continue;
        if (now[0] > 1e-12) this.triangles.push(left + k, right + k, right + k + 1);
        if (then[0] > 1e-12) this.triangles.push(left + k, right + k + 1, left + k + 1);
      }
    }
  }
  get size() { return this.local.length / 7; }
  // Writes places and normals of its corners, from number `first` on; swell: how much thicker it is,
  // and longer where it is the solid of a joint.
  place(frames, points, normals, first, swell) {
    const a = inWorld(frames, this.a), b = inWorld(frames, this.b), longer = this.round === 1 ? 0 : (swell - 1) / 2, way = minus(b, a);
    const [ax, ay, az] = plus(a, way, -longer), [bx, by, bz] = plus(b, way, longer);
    let w = [bx - ax, by - ay, bz - az];
    const far = Math.hypot(...w), at = FRAME * this.a[0];
    w = far > 1e-12 ? w.map((x) => x / far) : [frames[at + 2], frames[at + 5], frames[at + 8]];
    const across = this.side ? 0 : this.across < 0 ? mostAcross([0, 1, 2].map((k) => dot([frames[at + k], frames[at + 3 + k], frames[at + 6 + k]], w))) : this.across;
    let u = this.side ? wayInWorld(frames, this.side) : [frames[at + across], frames[at + 3 + across], frames[at + 6 + across]];
    const along = dot(u, w);
    u = unit(u.map((x, k) => x - along * w[k]));
    const v = cross(w, u), {local} = this;
    for (let k = 0, i = 3 * first; k < local.length; k += 7, i += 3) {
      const x = swell * local[k], y = swell * local[k + 1], z = swell * local[k + 2] + local[k + 3] * far, nx = local[k + 4], ny = local[k + 5], nz = local[k + 6];
      points[i] = ax + u[0] * x + v[0] * y + w[0] * z;
      points[i + 1] = ay + u[1] * x + v[1] * y + w[1] * z;
      points[i + 2] = az + u[2] * x + v[2] * y + w[2] * z;
      normals[i] = u[0] * nx + v[0] * ny + w[0] * nz;
      normals[i + 1] = u[1] * nx + v[1] * ny + w[1] * nz;
      normals[i + 2] = u[2] * nx + v[2] * ny + w[2] * nz;
    }
  }
}
// The place in the world of one that is fixed in a frame; frame 0 is the world.
function inWorld(frames, [frame, x, y, z]) {
  const k = FRAME * frame;
  return [0, 1, 2].map((i) => frames[k + 9 + i] + frames[k + 3 * i] * x + frames[k + 3 * i + 1] * y + frames[k + 3 * i + 2] * z);
}

// The direction in the world of one that is fixed in a frame.
function wayInWorld(frames, [frame, x, y, z]) {
  const k = FRAME * frame;
  return [0, 1, 2].map((i) => frames[k + 3 * i] * x + frames[k + 3 * i + 1] * y + frames[k + 3 * i + 2] * z);
}

// All solids of a robot, in the order of their numbers: roles, bodies, corners from number `first` to
// `end`, and triangles.
class Solids {
  constructor(solids) {
    this.solids = solids.map((one) => new (Array.isArray(one[4]) ? Hull : Solid)(one));
    const first = [0];
    for (const solid of this.solids) first.push(first[first.length - 1] + solid.size);
    this.first = first;
    [this.points, this.normals] = [0, 1].map(() => new Float64Array(3 * first[first.length - 1]));
    this.parts = this.solids.map((solid, k) => ({role: solid.role, bodies: solid.bodies, first: first[k], end: first[k + 1],
      corners: Uint32Array.from(solid.triangles, (i) => i + first[k])}));
    this.screen = new Float64Array(4 * first[first.length - 1]);
  }
  // Places between which all lies, but for the roundness of bars: their ends, and the corners of
  // boxes, discs and balls.
  reach(frames) {
    return this.solids.flatMap((solid, k) => {
      const ends = [inWorld(frames, solid.a), inWorld(frames, solid.b)];
      if (!solid.wide) return ends;
      for (let i = 3 * this.first[k]; i < 3 * this.first[k + 1]; i += 3) ends.push([this.points[i], this.points[i + 1], this.points[i + 2]]);
      return ends;
    });
  }
  place(frames, swell = 1) { this.solids.forEach((solid, k) => solid.place(frames, this.points, this.normals, this.first[k], swell)); }
}
