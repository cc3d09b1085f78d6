// Names in a moving drawing: each stands beside its place, where no other does, and stays there while
// it can.

const WAYS = [[1, -1], [-1, -1], [1, 1], [-1, 1], [0, -1.4], [0, 1.4], [1.4, 0], [-1.4, 0]], RINGS = [9, 16, 26, 40, 60, 90], HIGH = 15, GAP = 2;
class Labels {
  constructor(svg, names) {
    this.svg = svg;
    this.all = names.map(([text, at]) => {
      const element = document.createElementNS("http://www.w3.org/2000/svg", "text");
      element.setAttribute("class", "halo");
      element.setAttribute("text-anchor", "middle");
      element.textContent = text;
      svg.append(element);
      return {element, at, wide: 0, last: 0};
    });
  }
  // Places the names around their places on the page, which is `wide` and `tall` pixels.
  draw(spot, wide, tall) {
    const taken = [];
    for (const one of this.all) {
      one.wide ||= one.element.getComputedTextLength() + 2 * GAP;
      const [x, y] = spot(one.at), box = (n) => {
        const [a, b] = WAYS[n % WAYS.length], far = RINGS[Math.floor(n / WAYS.length)];
        const middle = [x + a * 0.7 * far + Math.sign(a) * one.wide / 2, y + b * 0.7 * far];
        const l = Math.min(Math.max(middle[0] - one.wide / 2, 0), wide - one.wide), t = Math.min(Math.max(middle[1] - HIGH / 2, 0), tall - HIGH);
        return {l, t, r: l + one.wide, d: t + HIGH};
      };
      const free = (b) => !taken.some((o) => Math.min(b.r, o.r) > Math.max(b.l, o.l) && Math.min(b.d, o.d) > Math.max(b.t, o.t));
      let n = one.last;
      for (let k = -1; !free(box(n)) && k + 1 < WAYS.length * RINGS.length; n = ++k);
      one.last = n < WAYS.length * RINGS.length ? n : 0;
      const found = box(one.last);
      taken.push(found);
      one.element.setAttribute("x", ((found.l + found.r) / 2).toFixed(1));
      one.element.setAttribute("y", (found.d - 4).toFixed(1));
    }
  }
}
