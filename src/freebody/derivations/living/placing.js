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

// Middles of the places that a label may have, and what each costs whatever the other labels do.
function candidates(one, crowd, hits, before) {
  const half = [one.wide / 2, (RULE.above + RULE.below) / 2], made = [];
  const [aside, over] = RULE.beside;
  one.anchors.forEach(([anchor, wanted], rank) => {
    const [c, s] = length(wanted) ? unit(wanted) : [1, 0];
    TURNS.forEach(([a, b], turn) => {
      const u = [a * c - b * s, a * s + b * c];
      RULE.distances.forEach(([far, price], step) => {
        const [x, y] = u.map((w, k) => anchor[k] + w * far + half[k] * w * Math.abs(w));
        const box = [x - half[0], y - half[1], x + half[0], y + half[1]], key = `${rank} ${turn} ${step}`;
        const beyond = [RULE.edge - box[0], RULE.edge - box[1], box[2] - crowd.wide + RULE.edge, box[3] - crowd.tall + RULE.edge];
        const outside = beyond.reduce((total, x) => total + Math.max(x, 0), 0);
        made.push({box, key, cost: RULE.anchor * rank + RULE.turn * turn + price + RULE.outside * outside
          + (outside > 0 ? RULE.forbidden : 0) + (before && before !== key ? RULE.stay : 0)
          + RULE.line * hits(box[0] - aside, box[1] - over, box[2] + aside, box[3] + over)});
      });
    });
  });
  return made.sort((a, b) => a.cost - b.cost);
}
// What it costs that a box is near another, or on it.
function crowding(box, other) {
  const wide = Math.min(box[2], other[2]) - Math.max(box[0], other[0]), high = Math.min(box[3], other[3]) - Math.max(box[1], other[1]);
  const [x, y] = [wide + RULE.apart[0], high + RULE.apart[1]];
  return x > 0 && y > 0 ? RULE.near * x * y + (wide > 0 && high > 0 ? RULE.forbidden : 0) : 0;
}
function cheapest(choices, others) {
  let best = null, least = Infinity;
  for (const choice of choices) {
    if (choice.cost >= least) break;
    let cost = choice.cost;
    for (const other of others) {
      if (other) cost += crowding(choice.box, other);
      if (cost >= least) break;
    }
    if (cost < least) [best, least] = [choice, cost];
  }
  return best;
}
// One label after the other, then each once more among the others, until none moves. last: where
// they were before.
function settle(wanted, crowd, last) {
  const hits = crowd.count(), choices = wanted.map((one) => candidates(one, crowd, hits, last.get(one.key)));
  const fixed = crowd.boxes, placed = wanted.map(() => null), chosen = [];
  for (let sweep = 0, moved = true; moved && sweep <= RULE.sweeps; sweep++) {
    moved = false;
    choices.forEach((own, k) => {
      placed[k] = null;
      const best = cheapest(own, [...fixed, ...placed]);
      moved ||= best !== chosen[k];
      chosen[k] = best;
      placed[k] = best.box;
    });
  }
  wanted.forEach((one, k) => last.set(one.key, chosen[k].key));
  return placed;
}

// A drawing in which labels are wanted; they are written when all is drawn.
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
      const after = put(one.text, "tspan", {class: "num"});
      after.textContent = one.after;
      if (!ruler.kept) ruler.font = ruler.kept = `12px ${getComputedStyle(after).fontFamily}`;
      one.wide += ruler.measureText(one.after).width;
    }
    settle(wanted, this.crowd, memory[svg.id]).forEach(([l, t, r, b], k) => {
      const {text, anchors: [[anchor]]} = wanted[k];
      text.setAttribute("x", (l + r) / 2);
      text.setAttribute("y", b - RULE.below);
      const near = [Math.min(Math.max(anchor[0], l), r), Math.min(Math.max(anchor[1], t), b)];
      if (length(minus(near, anchor)) > RULE.leader) svg.insertBefore(line(svg, "leader", anchor, near), text);
    });
  }
}
