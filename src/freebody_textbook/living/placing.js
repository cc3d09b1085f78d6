// Where labels go: each tries places around its anchors and takes the cheapest, by the rule that
// the figures have too.

const RULE = page.figure.rule, TURNS = RULE.turns.map((turn) => towards(-turn * Math.PI / 180));
const template = document.getElementById("names").content.querySelectorAll("text");
const widths = new Map(), ruler = document.createElement("canvas").getContext("2d");

// What is drawn already: points of lines to keep clear of, and boxes of text.
class Crowd {
  constructor(wide, tall) { Object.assign(this, {wide, tall, points: [], boxes: []}); }
  clear(a, b, half = 0) {
    const way = minus(b, a), n = Math.max(Math.floor(length(way) / RULE.spacing), 1), across = left(unit(way));
    for (const side of half ? [-half, half] : [0]) {
      for (let k = 0; k <= n; k++) this.points.push(plus(plus(a, way, k / n), across, side));
    }
  }
  // How many points are left of and above each pixel: those in a box are then four look-ups.
  count() {
    const wide = Math.ceil(this.wide) + 1, tall = Math.ceil(this.tall) + 1, sums = new Int32Array(wide * tall);
    for (const [x, y] of this.points) {
      const [i, j] = [Math.floor(x) + 1, Math.floor(y) + 1];
      if (i > 0 && j > 0 && i < wide && j < tall) sums[i + wide * j]++;
    }
    for (let j = 1; j < tall; j++) {
      for (let i = 1, row = 0; i < wide; i++) {
        row += sums[i + wide * j];
        sums[i + wide * j] = row + sums[i + wide * (j - 1)];
      }
    }
    const at = (x, y) => sums[Math.min(Math.max(Math.round(x), 0), wide - 1) + wide * Math.min(Math.max(Math.round(y), 0), tall - 1)];
    return (l, t, r, b) => at(r, b) - at(l, b) - at(r, t) + at(l, t);
  }
}

// All places by what they cost wherever they are; key: their number.
const MOST_ANCHORS = 5;
const PLACES = Array.from({length: MOST_ANCHORS}, (_, rank) => TURNS.flatMap((way, turn) => RULE.distances.map(([far, price]) =>
  ({rank, way, far, price: RULE.anchor * rank + RULE.turn * turn + price})))).flat()
  .map((place, key) => ({...place, key})).sort((a, b) => a.price - b.price);

// The box of a label at a place, and what that costs whatever the other labels do.
function choice(one, {rank, way: [a, b], far, price, key}, crowd, hits) {
  const [[x, y], wanted] = one.anchors[rank], [c, s] = length(wanted) ? unit(wanted) : [1, 0];
  const wide = one.wide / 2, tall = (RULE.above + RULE.below) / 2, [aside, over] = RULE.beside, u = a * c - b * s, v = a * s + b * c;
  const l = x + u * far + wide * (u * Math.abs(u) - 1), t = y + v * far + tall * (v * Math.abs(v) - 1), r = l + 2 * wide, d = t + 2 * tall;
  const outside = Math.max(RULE.edge - l, 0) + Math.max(RULE.edge - t, 0)
    + Math.max(r - crowd.wide + RULE.edge, 0) + Math.max(d - crowd.tall + RULE.edge, 0);
  return {l, t, r, d, key, cost: price + RULE.outside * outside + (outside > 0 ? RULE.forbidden : 0)
    + RULE.line * hits(l - aside, t - over, r + aside, d + over)};
}
// What it costs that a box is near another, or on it.
function crowding(box, other) {
  const wide = Math.min(box.r, other.r) - Math.max(box.l, other.l), high = Math.min(box.d, other.d) - Math.max(box.t, other.t);
  const x = wide + RULE.apart[0], y = high + RULE.apart[1];
  return x > 0 && y > 0 ? RULE.near * x * y + (wide > 0 && high > 0 ? RULE.forbidden : 0) : 0;
}
// One label after the other, then each once more among the others, until none moves; from the first
// to the last and from the last to the first, of which the cheaper is kept. last: where they were
// before.
function settle(wanted, crowd, last) {
  const hits = crowd.count(), made = wanted.map(() => []), order = [...wanted.keys()];
  const cheapest = (one, own, others) => {
    const before = last.get(one.key), moving = before === undefined ? 0 : RULE.stay;
    let best = null, least = Infinity;
    for (const place of PLACES) {
      if (place.rank >= one.anchors.length) continue;
      if (place.price >= least) break;
      const it = (own[place.key] ||= choice(one, place, crowd, hits));
      let cost = it.cost + (place.key === before ? 0 : moving);
      for (let k = 0; k < others.length && cost < least; k++) cost += crowding(it, others[k]);
      if (cost < least) [best, least] = [it, cost];
    }
    return [best, least];
  };
  const settled = (order) => {
    const placed = [];
    let total = 0;
    for (let sweep = 0, moved = true; moved && sweep <= RULE.sweeps; sweep++) {
      [moved, total] = [false, 0];
      for (const k of order) {
        const others = [...crowd.boxes, ...placed.filter((_, i) => i !== k)];
        const [best, cost] = cheapest(wanted[k], made[k], others);
        moved ||= best !== placed[k];
        placed[k] = best;
        total += cost;
      }
    }
    return {placed, total};
  };
  const [a, b] = [order, [...order].reverse()].map(settled), {placed} = b.total < a.total ? b : a;
  wanted.forEach((one, k) => last.set(one.key, placed[k].key));
  return placed;
}

// A drawing in which labels are wanted; they are written when all is drawn, above all leaders.
const memory = {arm: new Map(), bodies: new Map()};
class Sheet {
  constructor(svg, wide, tall) {
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${wide} ${tall}`);
    Object.assign(this, {svg, crowd: new Crowd(wide, tall), wanted: [], seen: new Map()});
  }
  want(css, name, anchors, after = "") {
    if (name === undefined || name < 0) return;
    const count = (this.seen.get(name) || 0) + 1;
    this.seen.set(name, count);
    this.wanted.push({css, name, anchors, after, key: `${name} ${count}`});
  }
  write() {
    const {svg, wanted} = this;
    for (const one of wanted) {
      one.text = put(svg, "text", {class: `halo f ${one.css}`, "text-anchor": "middle"});
      one.text.append(...template[one.name].cloneNode(true).childNodes);
      if (!widths.has(one.name)) widths.set(one.name, one.text.getComputedTextLength());
      one.wide = widths.get(one.name) + 2;
      if (!one.after) continue;
      const risen = [...one.text.childNodes].reduce((total, run) => total - Number(run.getAttribute("dy")), 0);
      const after = put(one.text, "tspan", {class: "num", dy: risen});
      after.textContent = one.after;
      if (!ruler.kept) ruler.font = ruler.kept = `12px ${getComputedStyle(after).fontFamily}`;
      one.wide += ruler.measureText(one.after).width;
    }
    settle(wanted, this.crowd, memory[svg.id]).forEach(({l, t, r, d}, k) => {
      const {text, anchors: [[anchor]]} = wanted[k];
      text.setAttribute("x", (l + r) / 2);
      text.setAttribute("y", d - RULE.below);
      const near = [Math.min(Math.max(anchor[0], l), r), Math.min(Math.max(anchor[1], t), d)];
      if (length(minus(near, anchor)) > RULE.leader) svg.insertBefore(line(svg, "leader", anchor, near), wanted[0].text);
    });
  }
}
