// Where labels go: each tries places around its anchors and takes the cheapest, by the rule that the
// figures have too (figures/labelling.py), which a scene holds as data.

const FINEST = 3;  // pixels: places of lines are told apart by so much
// What is drawn already: points of lines to keep clear of.
class Crowd {
  constructor(wide, tall, spacing) { Object.assign(this, {wide, tall, spacing, points: []}); }
  clear(a, b, half = 0) {
    const way = minus(b, a), n = Math.max(Math.floor(length(way) / this.spacing), 1), across = left(unit(way));
    for (const side of half ? [-half, half] : [0]) {
      for (let k = 0; k <= n; k++) this.points.push(plus(plus(a, way, k / n), across, side));
    }
  }
  // How many points are left of and above each cell: those in a box are then four look-ups.
  count() {
    const wide = Math.ceil(this.wide / FINEST) + 1, tall = Math.ceil(this.tall / FINEST) + 1, sums = new Int32Array(wide * tall);
    for (const [x, y] of this.points) {
      const [i, j] = [Math.floor(x / FINEST) + 1, Math.floor(y / FINEST) + 1];
      if (i > 0 && j > 0 && i < wide && j < tall) sums[i + wide * j]++;
    }
    for (let j = 1; j < tall; j++) {
      for (let i = 1, row = 0; i < wide; i++) {
        row += sums[i + wide * j];
        sums[i + wide * j] = row + sums[i + wide * (j - 1)];
      }
    }
    const cell = (x, most) => Math.min(Math.max(Math.round(x / FINEST), 0), most - 1);
    return (l, t, r, b) => {
      const [i, j, k, m] = [cell(l, wide), cell(r, wide), wide * cell(t, tall), wide * cell(b, tall)];
      return sums[j + m] - sums[i + m] - sums[j + k] + sums[i + k];
    };
  }
}

const MOST_ANCHORS = 5;
// The labels of one drawing: they stay where they are while they can.
class Sheet {
  constructor(svg, {rule, labels}) {
    const turns = rule.turns.map((turn) => towards(-turn * Math.PI / 180));
    Object.assign(this, {svg, rule, labels, widths: new Map(), last: new Map()});
    this.ruler = document.createElement("canvas").getContext("2d");
    // All places by what they cost wherever they are; key: their number.
    this.places = Array.from({length: MOST_ANCHORS}, (_, rank) => turns.flatMap((way, turn) => rule.distances.map(([far, price]) =>
      ({rank, way, far, price: rule.anchor * rank + rule.turn * turn + price})))).flat()
      .map((place, key) => ({...place, key})).sort((a, b) => a.price - b.price);
  }
  begin(wide, tall) {
    this.svg.replaceChildren();
    this.svg.setAttribute("viewBox", `0 0 ${wide} ${tall}`);
    if (this.crowd?.wide !== wide || this.crowd.tall !== tall) this.last.clear();  // a smaller sheet drove labels far away
    Object.assign(this, {crowd: new Crowd(wide, tall, this.rule.spacing), boxes: [], wanted: [], seen: new Map()});
  }
  // A label wants a place at one of its anchors, [place, direction]; after: plain text behind it. What is
  // off the sheet has none.
  want(css, name, anchors, after = "") {
    const {wide, tall} = this.crowd;
    if (name === undefined || name < 0 || !anchors.some(([[x, y]]) => x >= 0 && y >= 0 && x <= wide && y <= tall)) return;
    const count = (this.seen.get(name) || 0) + 1;
    this.seen.set(name, count);
    this.wanted.push({css, name, anchors, after, key: `${name} ${count}`});
  }
  // Writes all labels, above all leaders.
  write() {
    const {svg, wanted, rule} = this;
    for (const one of wanted) {
      one.text = put(svg, "text", {class: `halo f ${one.css}`, "text-anchor": "middle"});
      one.text.append(...typeset(this.labels[one.name]));
      if (!this.widths.has(one.name)) this.widths.set(one.name, one.text.getComputedTextLength());
      one.wide = this.widths.get(one.name) + 2;
      if (one.after) one.wide += this.behind(one.text, one.after);
    }
    this.settle().forEach(({l, t, r, d}, k) => {
      const {text, anchors: [[anchor]]} = wanted[k];
      text.setAttribute("x", (l + r) / 2);
      text.setAttribute("y", d - rule.below);
      const near = [Math.min(Math.max(anchor[0], l), r), Math.min(Math.max(anchor[1], t), d)];
      if (length(minus(near, anchor)) > rule.leader) svg.insertBefore(line(svg, "leader", anchor, near), wanted[0].text);
    });
  }
  // Puts plain text behind a formula; how wide it is.
  behind(text, words) {
    const risen = [...text.childNodes].reduce((total, run) => total - Number(run.getAttribute("dy")), 0);
    const after = put(text, "tspan", {class: "num", dy: risen});
    after.textContent = words;
    this.ruler.font = `12px ${this.family ||= getComputedStyle(after).fontFamily}`;
    return this.ruler.measureText(words).width;
  }
  // The box of a label at a place, and what that costs whatever the other labels do.
  choice(one, {rank, way: [a, b], far, price, key}, hits) {
    const {rule, crowd} = this, [[x, y], wanted] = one.anchors[rank], [c, s] = length(wanted) ? unit(wanted) : [1, 0];
    const wide = one.wide / 2, tall = (rule.above + rule.below) / 2, [aside, over] = rule.beside, u = a * c - b * s, v = a * s + b * c;
    const l = x + u * far + wide * (u * Math.abs(u) - 1), t = y + v * far + tall * (v * Math.abs(v) - 1), r = l + 2 * wide, d = t + 2 * tall;
    const outside = Math.max(rule.edge - l, 0) + Math.max(rule.edge - t, 0)
      + Math.max(r - crowd.wide + rule.edge, 0) + Math.max(d - crowd.tall + rule.edge, 0);
    return {l, t, r, d, key, cost: price + rule.outside * outside + (outside > 0 ? rule.forbidden : 0)
      + rule.line * hits(l - aside, t - over, r + aside, d + over)};
  }
  // What it costs that a box is near another, or on it.
  crowding(box, other) {
    const {rule} = this, wide = Math.min(box.r, other.r) - Math.max(box.l, other.l), high = Math.min(box.d, other.d) - Math.max(box.t, other.t);
    const x = wide + rule.apart[0], y = high + rule.apart[1];
    return x > 0 && y > 0 ? rule.near * x * y + (wide > 0 && high > 0 ? rule.forbidden : 0) : 0;
  }
  cheapest(one, own, others, hits) {
    const before = this.last.get(one.key), moving = before === undefined ? 0 : this.rule.stay;
    let best = null, least = Infinity;
    for (const place of this.places) {
      if (place.rank >= one.anchors.length) continue;
      if (place.price >= least) break;
      const it = (own[place.key] ||= this.choice(one, place, hits));
      let cost = it.cost + (place.key === before ? 0 : moving);
      for (let k = 0; k < others.length && cost < least; k++) cost += this.crowding(it, others[k]);
      if (cost < least) [best, least] = [it, cost];
    }
    return [best, least];
  }
  // One label after the other, then each once more among the others, until none moves; from the first
  // to the last and from the last to the first, of which the cheaper is kept.
  settle() {
    const {wanted, rule} = this, hits = this.crowd.count(), made = wanted.map(() => []), order = [...wanted.keys()];
    const settled = (order) => {
      const placed = [];
      let total = 0;
      for (let sweep = 0, moved = true; moved && sweep <= rule.sweeps; sweep++) {
        [moved, total] = [false, 0];
        for (const k of order) {
          const others = [...this.boxes, ...placed.filter((_, i) => i !== k)];
          const [best, cost] = this.cheapest(wanted[k], made[k], others, hits);
          moved ||= best !== placed[k];
          placed[k] = best;
          total += cost;
        }
      }
      return {placed, total};
    };
    const [a, b] = [order, [...order].reverse()].map(settled), {placed} = b.total < a.total ? b : a;
    wanted.forEach((one, k) => this.last.set(one.key, placed[k].key));
    return placed;
  }
}
// A formula's runs as SVG, from the text that Python has typeset and escaped.
const reader = new DOMParser(), typesetOnce = new Map();
function typeset(text) {
  if (!typesetOnce.has(text)) typesetOnce.set(text, reader.parseFromString(`<svg xmlns="${SVG}"><text>${text}</text></svg>`, "image/svg+xml").querySelector("text"));
  return document.importNode(typesetOnce.get(text), true).childNodes;
}
