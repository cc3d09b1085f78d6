// The robot as in the figure above: its parts, and the names of its geometry.

// What the page does not say of a body.
for (const body of page.bodies) {
  for (const list of ["ends", "pins", "forces", "moments", "solids"]) body[list] ||= [];
  body.names ||= {};
}

// A vector of the plane, or one of space as it is seen, y up.
const view = {turn: 0, tilt: 0};
function seen(v) {
  if (v.length < 3) return v;
  const [c, s] = [Math.cos(view.turn), Math.sin(view.turn)];
  const away = c * v[0] + s * v[1], up = v[2];
  return [c * v[1] - s * v[0], Math.cos(view.tilt) * up - Math.sin(view.tilt) * away];
}
const toViewer = () => {
  const flat = Math.cos(view.tilt);
  return [flat * Math.cos(view.turn), flat * Math.sin(view.turn), Math.sin(view.tilt)];
};
const vector = (y, places) => places.map((k) => y[k]);

// The box of the world that is drawn. It grows with what moves, so that the drawing stays where it
// is, and is made anew where little of it is used; symbols are as large as it was at first.
let box = null, size = 1;
function grown(points, own) {
  const around = (points) => [0, 1].map((i) => [Math.min(...points.map((p) => p[i])), Math.max(...points.map((p) => p[i]))]);
  const reach = (box) => Math.max(...box.map(([low, high]) => high - low));
  const now = around(points), both = box && around([...points, [box[0][0], box[1][0]], [box[0][1], box[1][1]]]);
  if (!(both && reach(both) < 2.5 * reach(now))) size = own;
  box = both && reach(both) < 2.5 * reach(now) ? both : now;
}
const ROOM = [360, 300], EDGE = 48;
// Of the box around all places, as figures have it.
function extent(places) {
  const sides = places[0].map((_, i) => Math.max(...places.map((p) => p[i])) - Math.min(...places.map((p) => p[i])));
  return length(sides) > 1e-6 ? length(sides) : 1;
}
const axisShare = (bodies, at) => Math.min(0.3, ...bodies.filter((b) => b.slides && b.parent < 0).map((b) => length(at(b.joint)) / size)
  .filter((share) => share > 0.15).map((share) => 0.65 * share));

function drawArm(svg, bodies, rods, y) {
  const sheet = new Sheet(svg, ...ROOM), plane = bodies[0].joint.length < 3, world = (places) => vector(y, places);
  const tip = page.figure.tip, nothing = plane ? [0, 0] : [0, 0, 0];
  const spots = [nothing, ...bodies.flatMap((body) =>
    [body.from, body.joint, ...body.ends, ...body.pins, ...(body.heavy ? [body.centre] : [])]).concat(...rods).map(world)];
  const own = extent(spots), along = plane ? axisShare(bodies, world) : 0.16;
  const frame = nothing.map((_, k) => nothing.map((_, i) => (i === k ? along : 0)));
  const ends = frame.map((axis) => axis.map((u) => own * u));
  const arcs = bodies.filter((body) => body.zero && body.names.q >= 0).flatMap((body) => [[body.zero, 1.5], [body.along, 1]]
    .map(([way, far]) => plus(world(body.joint), world(way), far * ARC * own)));
  const around = bodies.flatMap(({axis, joint, names}) => (plane || !axis || names.q === undefined ? [] : [0.17, -0.1])
    .map((far) => plus(world(joint), world(axis), far * own)));
  const rims = bodies.filter((body) => isRing(body, world)).flatMap((body) => frame.flatMap((axis) =>
    [RING / along, -RING / along].map((far) => plus(world(body.joint), axis, far * own))));
  grown([...spots, ...ends, ...arcs, ...around, ...rims].map(seen), own);
  const scale = Math.min(...box.map(([low, high], i) => (ROOM[i] - 2 * EDGE) / Math.max(high - low, 1e-12)));
  const place = (v) => seen(v).map((u, i) => ROOM[i] / 2 + (i ? -1 : 1) * scale * (u - (box[i][0] + box[i][1]) / 2));
  const robot = {y, bodies, world, place, scale, at: (places) => place(world(places))};
  const names = page.figure.axes, roles = plane ? ["soft", "soft"] : ["x", "y", "z"];
  const axes = () => frame.forEach((axis, k) => {
    const a = place(nothing), b = place(axis.map((u) => size * u));
    arrow(sheet, roles[k], a, b);
    if (plane) sheet.want("label-text", names[k], [[b, minus(b, a)], [b, minus(a, b)]]);
    else sheet.want(`${roles[k]}-text`, names[k], tipAnchors(a, b));
  });
  (plane ? drawFlat : drawSolid)(sheet, robot, rods, axes);
  if (tip) {
    circle(svg, "position-head", robot.at(tip.at), 3.5);
    const last = bodies[bodies.length - 1], from = robot.at(last.joint), to = robot.at(tip.at);
    if (tip.name >= 0) sheet.want("label-text", tip.name, both(to, plane && length(minus(to, from)) > 1 ? minus(to, from) : [1, -0.5]));
  }
  if (plane) nameFlat(sheet, robot, rods); else nameSolid(sheet, robot, rods);
  for (const {at: point, name} of page.figure.points) sheet.want("label-text", name, both(robot.at(point), [-0.6, -0.8]));
  for (const body of bodies) pushed(sheet, robot, body);
  sheet.write();
}
const both = (at, way) => [[at, way], [at, opposite(way)]];
const tipAnchors = (a, b) => {
  const way = minus(b, a);
  return [[b, length(way) > 1 ? way : [1, -1]], beside(a, b, 1, 0.5)[0], beside(a, b, -1, 0.5)[0]];
};

// The force on the tip, the longest arrow of all.
function pushed(sheet, {y, at, scale}, body) {
  for (const force of body.forces.filter((one) => one.kind === "external" && body.holds)) {
    const a = at(force.at), pull = onPage(vector(y, force.is)), far = length(vector(y, force.is));
    if (!(far > 0)) continue;
    const b = plus(a, pull, Math.min(0.38 * size * scale, EDGE) / far);
    arrow(sheet, "external", a, b);
    sheet.want("external-text", force.name, tipAnchors(a, b));
  }
}

const closings = () => (page.loop ? page.loop.symbols : []);
// Segments of a body: from its joint to where it reaches, else to its centre of mass.
function outline(body, at) {
  const apart = (place) => length(minus(at(place), at(body.joint))) > 0.5;
  const far = body.ends.filter(apart);
  return (far.length ? far : [body.centre].filter((place) => body.heavy && apart(place))).map((place) => [at(body.joint), at(place)]);
}

// ---------------------------------------------------------------- the plane
function drawFlat(sheet, robot, rods, axes) {
  const {at, world, scale} = robot, {svg, crowd} = sheet, way = (body) => unit(onPage(world(body.axis)));
  const bodies = robot.bodies.filter((body) => !body.link);
  for (const body of bodies.filter((one) => one.parent < 0 && one.holds)) {
    if (body.slides) guide(sheet, at(body.from), at(body.joint), way(body), scale);
    else ground(sheet, at(body.from));
  }
  axes();
  for (const body of bodies) {
    if (body.slides && body.parent >= 0) {
      line(svg, "rail", at(body.from), at(body.joint));
      crowd.clear(at(body.from), at(body.joint));
    }
    for (const ends of outline(body, at)) bar(sheet, ...ends, 11);
  }
  for (const body of bodies) if (body.held) mark(sheet, body.mark, at(body.joint), body.axis && way(body));
  for (const ends of rods) {
    line(svg, "rail", ...ends.map(at));
    crowd.clear(...ends.map(at));
  }
  for (const body of bodies) ring(sheet, at, robot.y, body, RING * size * scale);
  for (const closing of closings()) {
    const [a, b] = closing.at.map(at);
    for (const place of length(minus(b, a)) > 1 ? [a, b] : [b]) mark(sheet, closing.mark, place);
  }
  for (const body of bodies) if (body.heavy) centre(sheet, at(body.centre));
}
// The hatched guide of a slide of the ground.
function guide({svg, crowd}, from, to, way, scale) {
  const half = length(minus(to, from)) / 2 + 0.12 * size * scale, middle = plus(from, minus(to, from), 0.5), pitch = 0.03 * size * scale;
  const [x, y] = way[0] >= 0 ? way : opposite(way), a = plus(middle, [x, y], -half), b = plus(middle, [x, y], half);
  line(svg, "rail", a, b);
  crowd.clear(a, b);
  const strokes = Math.max(Math.floor(2 * half / pitch / 0.9), 2);
  for (let k = 1; k <= strokes; k++) {
    const foot = plus(a, minus(b, a), k / strokes), end = plus(foot, [-y - 0.7 * x, x - 0.7 * y], pitch);
    line(svg, "hatch", foot, end);
    crowd.clear(foot, end);
  }
}
// A wheel, a body without extent that turns and carries nothing: a ring about its axis, which in the
// plane points at the viewer.
const RING = 0.09, SIDES = 40;
const isRing = (body, world) => !body.slides && body.heavy && body.holds && !page.bodies.some((other) => page.bodies[other.parent] === body)
  && [...body.ends, body.centre].every((place) => length(minus(world(place), world(body.joint))) < 1e-6);
function ring({svg, crowd}, at, y, body, radius) {
  if (!isRing(body, (places) => vector(y, places))) return;
  let across = [[1, 0], [0, 1]];
  if (body.axis) {
    const axis = vector(y, body.axis), first = unit(cross(axis, Math.abs(axis[2]) < 0.9 ? [0, 0, 1] : [1, 0, 0]));
    across = [first, cross(axis, first)];
  }
  const [u, v] = across.map(onPage), middle = at(body.joint);
  const points = Array.from({length: SIDES}, (_, k) => {
    const angle = 2 * Math.PI * k / SIDES;
    return plus(plus(middle, u, radius * Math.cos(angle)), v, radius * Math.sin(angle));
  });
  polygon(svg, "rail", points);
  points.forEach((point, k) => crowd.clear(point, points[(k + 1) % SIDES]));
}

function heading({bodies, at, world}, body) {
  const next = bodies.find((one) => bodies[one.parent] === body), places = [next && next.joint, ...body.ends, body.centre];
  const far = places.find((place) => place && length(minus(at(place), at(body.joint))) > 0.5);
  return unit(far ? minus(at(far), at(body.joint)) : onPage(world(body.along || body.axis)));
}
// The direction from a joint in which nothing of the arm lies.
function clearWay(robot, body) {
  const after = heading(robot, body);
  if (body.parent < 0) {
    const angle = (Math.atan2(-after[1], after[0]) * 180 / Math.PI + 360) % 360, foot = angle < 90 || angle > 270 ? 240 : -60;
    return towards(((angle <= 270 ? angle : angle - 360) + foot) / 360 * Math.PI);
  }
  const away = minus(heading(robot, robot.bodies[body.parent]), after);
  return length(away) > 0.1 ? away : left(after);
}
// 1: left of a body, -1: right of it; an angle is drawn behind the turn that made it.
function clearSide(robot, body) {
  if (body.slides) return body.parent < 0 ? 1 : clearSide(robot, robot.bodies[body.parent]);
  const [[a, b], [c, d]] = [body.zero, body.along].map(robot.world);
  return a * d - b * c >= 0 ? 1 : -1;
}
const MEASURED = 0.05, ARC = 0.15;
function measured(sheet, robot, a, b, aside, name, least = MEASURED * size * robot.scale) {
  if (name >= 0 && length(minus(b, a)) > Math.max(least, 1)) dimension(sheet, a, b, aside, name);
}
function lengths(sheet, robot, {names, joint, from, centre, ends}, side, origin) {
  const {at} = robot;
  if (names.lc >= 0) measured(sheet, robot, at(joint), at(centre), 12 * side, names.lc);
  if (names.l >= 0) measured(sheet, robot, at(joint), at(ends[0]), 46 * side, names.l);
  if (names.ground >= 0) measured(sheet, robot, origin, at(from), at(from)[0] >= origin[0] ? -34 : 34, names.ground);
}
function nameFlat(sheet, robot, rods) {
  const {at, world, place} = robot, origin = place([0, 0]), bodies = robot.bodies.filter((body) => !body.link);
  for (const body of bodies) {
    const {names} = body, joint = at(body.joint);
    if (names.point >= 0) sheet.want("label-text", names.point, both(joint, clearWay(robot, body)));
    if (body.zero && names.q >= 0) angle(sheet, robot, body);
    if (body.heavy) sheet.want("label-text", names.C, both(at(body.centre), opposite(left(heading(robot, body)))));
  }
  for (const body of bodies) {
    const side = body.slides || body.zero ? clearSide(robot, body) : 1, aside = body.parent < 0 && page.loop ? 50 : 20;
    if (body.slides) measured(sheet, robot, at(body.from), at(body.joint), -side * aside, body.names.q, 1);
    lengths(sheet, robot, body, side, origin);
  }
  rods.forEach((ends, k) => measured(sheet, robot, ...ends.map(at), 20, page.figure.rods[k]));
}
// From the direction in which it is 0, dashed, an arc with a head where it ends.
function angle(sheet, {at, world, scale}, body) {
  const [before, now] = [body.zero, body.along].map((places) => { const [x, y] = world(places); return Math.atan2(y, x); });
  const turned = now - before - 2 * Math.PI * Math.round((now - before) / (2 * Math.PI)), middle = at(body.joint), radius = ARC * size * scale;
  const end = plus(middle, towards(before), 1.5 * radius);
  line(sheet.svg, "guide", middle, end);
  sheet.crowd.clear(middle, end);
  const on = arc(sheet, "angle", middle, radius, before, turned, 7);
  sheet.want("", body.names.q, [0.5, 0.7, 0.3].map(on));
}

// ---------------------------------------------------------------- space
const CROWDED = 12;
function drawSolid(sheet, robot, rods, axes) {
  const {bodies, at, world, scale, place} = robot, shown = bodies.filter((body) => !body.link), parts = [];
  const [width, radius, least] = bodies.length > CROWDED ? [5, 0.014, 3.5] : [8, 0.022, 6], viewer = toViewer(), deep = (v) => dot(v, viewer);
  const stick = (a, b) => {
    if (length(minus(b, a)) > 1e-6) parts.push({depth: deep(plus(a, b)) / 2, draw: (sheet) => bar(sheet, place(a), place(b), width)});
  };
  const symbol = (places, kind, solids) => {
    for (const {at: middle, axis, size: [wide, half, sides]} of solids) {
      const r = Math.max(radius * size, least / scale), v = world(middle);
      parts.push({depth: deep(v) + 2.5 * r * wide, draw: (sheet) =>
        prism(sheet, place(v), world(axis), wide * r * scale, half * r * scale, sides, viewer)});
    }
    for (const v of solids.length || !kind ? [] : places) parts.push({depth: deep(world(v)), draw: (sheet) => mark(sheet, kind, at(v))});
  };
  for (const body of shown) {
    const [from, joint] = [body.from, body.joint].map(world);
    if (body.parent < 0 && body.holds) stick([0, 0, 0], from);
    if (body.slides) stick(from, joint);
    for (const [, far] of ends(body, world)) stick(joint, far);
    if (!body.held) continue;
    symbol([body.joint], body.mark, body.solids);
  }
  for (const closing of closings()) symbol(closing.at, closing.mark, closing.solids);
  const depths = parts.map((part) => part.depth), low = Math.min(...depths), high = Math.max(...depths);
  for (const part of parts.sort((a, b) => a.depth - b.depth)) {
    const far = high - low > 1e-9 && part.depth < low + 0.33 * (high - low);
    part.draw({svg: put(sheet.svg, "g", {class: far ? "far" : undefined}), crowd: sheet.crowd});
  }
  for (const ends of rods) line(sheet.svg, "rail", ...ends.map(at));
  axes();
  for (const body of shown) ring(sheet, at, robot.y, body, RING * size * scale);
}
// Of the outline in the world.
function ends(body, world) {
  const joint = world(body.joint), apart = (v) => length(minus(v, joint)) > 1e-6, far = body.ends.map(world).filter(apart);
  return (far.length ? far : [world(body.centre)].filter((v) => body.heavy && apart(v))).map((v) => [joint, v]);
}
function nameSolid(sheet, robot, rods) {
  const {bodies, at, world, place} = robot;
  for (const body of bodies.filter((one) => one.axis)) {
    const {names} = body, axis = world(body.axis), from = world(body.from), start = body.slides ? from : world(body.joint);
    if (names.z === undefined && names.q === undefined) continue;
    const a = place(start), b = place(plus(start, axis, 0.17 * size)), back = place(plus(start, axis, -0.102 * size));
    line(sheet.svg, "axisline", back, a);
    sheet.crowd.clear(back, a);
    if (names.z >= 0) {
      arrow(sheet, "z", a, b);
      sheet.want("z-text", names.z, tipAnchors(a, b));
    }
    const foot = place(plus(from, axis, -0.1 * size)), way = minus(a, b);
    sheet.want("label-text", names.q, both(foot, length(way) > 1 ? way : [1, 0]));
  }
  for (const body of bodies) {
    const {names} = body;
    if (names.C >= 0) {
      centre(sheet, at(body.centre));
      sheet.want("label-text", names.C, both(at(body.centre), [0, 1]));
    }
    lengths(sheet, robot, body, 1, place([0, 0, 0]));
  }
  rods.forEach((ends, k) => measured(sheet, robot, ...ends.map(at), 20, page.figure.rods[k]));
}
