// The names of a robot's geometry as the figures have them: angles, lengths, axes, centres of mass.
// Each body is data: its places and directions, [frame, x, y, z], and the numbers of its names.

const MEASURED = 0.05, ARC = 0.15;
class Notes {
  // rods: places of both ends, and the number of the length's name; tip and points: place and name.
  constructor(bodies, {rods = [], tip = null, points = [], loop = false} = {}) {
    Object.assign(this, {bodies, rods, tip, points, loop, shown: bodies.filter((body) => !body.link)});
  }
  draw(stage) {
    const {sheet} = stage, {tip, points} = this;
    if (tip) {
      const at = stage.at(tip.at), last = this.bodies[this.bodies.length - 1], way = minus(at, stage.at(last.joint));
      circle(sheet.svg, "position-head", at, 3.5);
      sheet.want("label-text", tip.name, both(at, stage.scene.flat && length(way) > 1 ? way : [1, -0.5]));
    }
    (stage.scene.flat ? this.flat : this.solid).call(this, stage);
    for (const {ends, name} of this.rods) this.measured(stage, ...ends.map((end) => stage.at(end)), 20, name);
    for (const {at, name} of points) sheet.want("label-text", name, both(stage.at(at), [-0.6, -0.8]));
  }
  world(stage, place) { return inWorld(stage.frames, place); }
  way(stage, direction) { return wayInWorld(stage.frames, direction); }
  measured(stage, a, b, aside, name, least = MEASURED * stage.size * stage.scale) {
    if (name >= 0 && length(minus(b, a)) > Math.max(least, 1)) dimension(stage.sheet, a, b, aside, name);
  }
  lengths(stage, {names, joint, from, centre: heavy, ends}, side) {
    const at = (place) => stage.at(place), origin = at([0, 0, 0, 0]);
    if (names.lc >= 0) this.measured(stage, at(joint), at(heavy), 12 * side, names.lc);
    if (names.l >= 0) this.measured(stage, at(joint), at(ends[0]), 46 * side, names.l);
    if (names.ground >= 0) this.measured(stage, origin, at(from), at(from)[0] >= origin[0] ? -34 : 34, names.ground);
  }
  // The direction of a body on the page, from its joint outwards.
  heading(stage, body) {
    const next = this.bodies.find((one) => this.bodies[one.parent] === body), places = [next && next.joint, ...body.ends, body.centre];
    const from = stage.at(body.joint), far = places.find((place) => place && length(minus(stage.at(place), from)) > 0.5);
    return unit(far ? minus(stage.at(far), from) : stage.onSheet(this.way(stage, body.along || body.axis || [0, 1, 0, 0])));
  }
  // The direction from a joint in which nothing of the arm lies.
  clearWay(stage, body) {
    const after = this.heading(stage, body);
    if (body.parent < 0) {
      const angle = (Math.atan2(-after[1], after[0]) * 180 / Math.PI + 360) % 360, foot = angle < 90 || angle > 270 ? 240 : -60;
      return towards(((angle <= 270 ? angle : angle - 360) + foot) / 360 * Math.PI);
    }
    const away = minus(this.heading(stage, this.bodies[body.parent]), after);
    return length(away) > 0.1 ? away : left(after);
  }
  // 1: left of a body, -1: right of it; an angle is drawn behind the turn that made it.
  clearSide(stage, body) {
    if (body.slides) return body.parent < 0 ? 1 : this.clearSide(stage, this.bodies[body.parent]);
    if (!body.zero) return 1;
    const [[a, b], [c, d]] = [body.zero, body.along].map((way) => this.way(stage, way));
    return a * d - b * c >= 0 ? 1 : -1;
  }
  flat(stage) {
    const {sheet} = stage, at = (place) => stage.at(place);
    for (const body of this.shown) {
      const {names} = body, joint = at(body.joint);
      if (names.point >= 0) sheet.want("label-text", names.point, both(joint, this.clearWay(stage, body)));
      if (body.zero && names.q >= 0) this.angle(stage, body);
      if (!body.heavy) continue;
      centre(sheet, at(body.centre));
      sheet.want("label-text", names.C, both(at(body.centre), opposite(left(this.heading(stage, body)))));
    }
    for (const body of this.shown) {
      const side = this.clearSide(stage, body), aside = body.parent < 0 && this.loop ? 50 : 20;
      if (body.slides) this.measured(stage, at(body.from), at(body.joint), -side * aside, body.names.q, 1);
      this.lengths(stage, body, side);
    }
  }
  // From the direction in which it is 0, dashed, an arc with a head where it ends.
  angle(stage, body) {
    const {sheet} = stage, [before, now] = [body.zero, body.along].map((way) => { const [x, y] = this.way(stage, way); return Math.atan2(y, x); });
    const turned = now - before - 2 * Math.PI * Math.round((now - before) / (2 * Math.PI)), middle = stage.at(body.joint), radius = ARC * stage.size * stage.scale;
    const end = plus(middle, towards(before), 1.5 * radius);
    line(sheet.svg, "guide", middle, end);
    sheet.crowd.clear(middle, end);
    sheet.want("", body.names.q, [0.5, 0.7, 0.3].map(arc(sheet, "angle", middle, radius, before, turned, 7)));
  }
  solid(stage) {
    const {sheet, size} = stage;
    for (const {names, axis, from, joint, slides} of this.shown.filter((body) => body.axis)) {
      if (names.z === undefined && names.q === undefined) continue;
      const way = this.way(stage, axis), start = this.world(stage, slides ? from : joint), on = (far) => stage.seen(plus(start, way, far * size));
      const [a, b, back] = [0, 0.17, -0.102].map(on);
      line(sheet.svg, "axisline", back, a);
      sheet.crowd.clear(back, a);
      if (names.z >= 0) {
        arrow(sheet, "z", a, b);
        sheet.want("z-text", names.z, tipAnchors(a, b));
      }
      const foot = stage.seen(plus(this.world(stage, from), way, -0.1 * size)), along = minus(a, b);
      sheet.want("label-text", names.q, both(foot, length(along) > 1 ? along : [1, 0]));
    }
    for (const body of this.shown) {
      if (body.names.C >= 0) {
        centre(sheet, stage.at(body.centre));
        sheet.want("label-text", body.names.C, both(stage.at(body.centre), [0, 1]));
      }
      this.lengths(stage, body, 1);
    }
  }
}
