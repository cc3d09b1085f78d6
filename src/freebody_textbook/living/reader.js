// Tokens into a tree, by recursive descent, and the values of trees at states: numbers that carry
// how large the terms were that they were made of, and vectors and matrices of such.

const PAIR = {"(": ")", "[": "]", "{": "}"}, DEEPEST = 100;
const STARTS = ["name", "function", "open", "fraction"];
const UNDECIDED = "is read by freebody check, and not on this page";
function undecided(what) { return Object.assign(unreadable(`${what} ${UNDECIDED}.`), {undecided: true}); }

// meaning(name): {s: a scalar, t: rows of a vector or matrix}, each to be looked up at a state.
class Reader {
  constructor(tokens, meaning) { Object.assign(this, {tokens, meaning, at: 0, depth: 0}); }
  ahead(k) { return this.tokens[this.at + k] || {kind: "stop", text: ""}; }
  get token() { return this.ahead(0); }
  take() { return this.tokens[this.at++] || {kind: "stop", text: ""}; }
  isOperator(...texts) { return this.token.kind === "operator" && texts.includes(this.token.text); }
  expect(kind, what) {
    if (this.token.kind !== kind) this.failHere(what);
    return this.take();
  }
  failHere(expected) {
    const {kind, text} = this.token;
    throw unreadable(`${kind === "stop" ? "the line ends" : `there is ${text}`} where ${expected} is expected`);
  }
  nested(read) {
    if (++this.depth > DEEPEST) throw unreadable(`more than ${DEEPEST} brackets inside one another`);
    const node = read();
    this.depth--;
    return node;
  }
  side() {
    const node = this.expression();
    if (this.token.kind === "close") throw unreadable(`this ${this.token.text} closes no bracket`);
    if (this.token.kind !== "stop") this.failHere("an operator or the end of the line");
    return node;
  }
  expression() {
    const terms = [this.signed(() => this.product())];
    while (this.isOperator("+", "-")) terms.push(this.signed(() => this.product()));
    return terms.length > 1 ? {is: "sum", parts: terms} : terms[0];
  }
  signed(read) {
    let negative = false;
    while (this.isOperator("+", "-")) negative = (this.take().text === "-") !== negative;
    const node = read();
    return negative ? {is: "negative", parts: [node]} : node;
  }
  product() {
    let factors = [this.factor()];
    for (;;) {
      const {kind, text} = this.token, before = this.ahead(-1);
      if (this.isOperator("*")) {
        const sign = this.take();
        factors = this.multiplied(factors, sign.written, this.following(factors, sign.written));
      } else if (this.isOperator("/")) {
        this.take();
        factors = [{is: "quotient", parts: [productOf(factors), this.signed(() => this.factor())]}];
      } else if (STARTS.includes(kind) || kind === "begin" || (kind === "number" && text.includes(".") && before.kind !== "number")) {
        factors.push(this.factor());
      } else if (kind === "partial") throw undecided("A derivative");
      else if (kind === "number") {
        throw unreadable(`the number ${text} follows ${before.text}: write ${before.text}^${text} for a power, ${before.text}*${text} for a product`);
      } else return productOf(factors);
    }
  }
  // Behind the × of a cross product all factors up to the vector.
  following(factors, sign) {
    const first = this.signed(() => this.factor()), left = productOf(factors);
    const turns = isCross(sign) ? mayBeTable(left) : isVector(left) && first.is === "name" && (first.t || [[]])[0].length > 1;
    if (!turns) return first;
    const found = [first];
    while (["name", "open"].includes(this.token.kind) && !isVector(found.at(-1))) found.push(this.factor());
    return productOf(found);
  }
  // A × between vectors is the cross product, and so that of an angular velocity and a vector in the
  // plane; a raised dot between vectors is the product of numbers.
  multiplied(factors, sign, factor) {
    const left = productOf(factors), sides = [left, factor];
    if (sign === "@" && !sides.every(mayBeTable)) throw unreadable("'@' has no meaning here: it stands between vectors and matrices");
    const dotted = ["\u00b7", "\u22c5", "\u2219", "\u2022", "\\cdot"].includes(sign);
    const before = (left.is === "product" ? left.parts : [left]).some(isBoth) && isTable(factor);
    const may = isBoth(factor) && factor.t[0].length === 1;
    if (dotted && (before || (isVector(left) && may))) return [{is: "dot", parts: sides}];
    if (!isCross(sign) || !sides.some(isTable)) return [...factors, factor];
    const turns = left.is === "name" && /^\u02d9*(omega|w|alpha|theta|q)/.test(left.text);
    if (!turns && !sides.every(mayBeTable)) throw unreadable("this \u00d7 may be a product or the cross product. Write * or cross(a, b).");
    return [{is: "cross", parts: sides}];
  }
  factor() {
    let node = this.primary();
    for (;;) {
      if (this.token.kind === "power" || this.isOperator("^")) {
        const exponent = this.exponent();
        if (exponent !== 1) node = {is: "power", parts: [node], exponent};
      } else if (this.token.kind === "transpose") {
        if (this.take().text === "'" && !mayBeTable(node)) throw unreadable("a prime stands behind what is no vector or matrix");
        node = {is: "transposed", parts: [node]};
      } else if (this.token.kind === "degree") node = this.degrees(node);
      else return node;
    }
  }
  degrees(node) {
    if (this.token.kind !== "degree") return node;
    this.take();
    return productOf([node, numberNode(Math.PI / 180)]);
  }
  exponent() {
    const first = this.take();
    let {value} = first;
    if (first.kind !== "power") {
      const bracket = this.token.kind === "open" ? this.take() : null;
      const sign = this.isOperator("-") && this.take() ? -1 : 1;
      if (this.token.kind === "name") throw unreadable("a power must be a whole number");
      value = this.expect("number", "a whole number as power").value * sign;
      if (bracket) this.expect("close", PAIR[bracket.text]);
    }
    if (!Number.isInteger(value) || Math.abs(value) > table.LARGEST_EXPONENT) {
      throw unreadable(`a power must be a whole number up to ${table.LARGEST_EXPONENT}`);
    }
    if (this.isOperator("^") || this.token.kind === "power") throw unreadable("a power of a power needs brackets");
    return value;
  }
  primary() {
    const {kind, text, value} = this.token;
    if (kind === "begin" || this.isList()) return this.table();
    if (kind === "partial") throw undecided("A derivative");
    if (kind === "number") {
      this.take();
      return numberNode(value, text);
    }
    if (kind === "name") return this.name();
    if (kind === "open") return this.nested(() => this.bracket());
    if (kind === "fraction") return this.nested(() => this.fraction());
    if (kind === "function") return this.nested(() => this.call());
    return this.failHere("a term");
  }
  bracket() {
    const open = this.take(), node = this.expression(), close = this.token;
    if (close.kind !== "close") {
      if (close.kind === "stop") throw unreadable(`this ${open.text} is not closed`);
      this.failHere(PAIR[open.text]);
    }
    if (close.text !== PAIR[open.text]) throw unreadable(`${open.text} is closed by ${close.text}`);
    this.take();
    return node;
  }
  fraction() {
    this.take();
    const part = () => this.token.kind === "open" ? this.nested(() => this.bracket()) : this.primary();
    return {is: "quotient", parts: [part(), part()]};
  }
  name() {
    let {text} = this.take();
    if (this.token.text === "(" && this.ahead(1).text === "t" && this.ahead(2).text === ")") this.at += 3;
    const turn = /^R[0-9]$/.test(text) && this.turnBehind();  // R_1^2 turns components from body 1 to body 2
    if (turn && this.meaning(`R${turn}${text[1]}`)) {
      this.exponent();
      text = `R${turn}${text[1]}`;
    }
    if (text === "pi" && !this.meaning(text)) return numberNode(Math.PI);
    if (text === "t") throw unreadable("the time t does not occur in these equations");
    const meaning = this.meaning(text);
    if (!meaning) throw unreadable(`${text} has no value here.`);
    return {is: "name", text, parts: [], ...meaning};
  }
  turnBehind() {
    const braced = this.ahead(1).text === "{";
    return this.token.kind === "power" ? this.token.value : this.isOperator("^") && this.ahead(1 + braced).value;
  }
  // Whether a bracket [ holds entries, [a, b] or [[a, b], [c, d]].
  isList() {
    if (this.token.text !== "[") return false;
    const rows = this.ahead(1).text === "[" ? 2 : 1;
    for (let k = 0, depth = 0; this.ahead(k).kind !== "stop"; k++) {
      const {kind, text} = this.ahead(k);
      depth += {open: 1, begin: 1, close: -1, end: -1}[kind] || 0;
      if (!depth) return false;
      if (depth <= rows && (kind === "comma" || kind === "row" || text === ";")) return true;
    }
    return false;
  }
  table() {
    const first = this.take();
    let rows;
    if (first.kind === "begin") rows = this.rows(["amp"], ["row"], "end");
    else if (first.kind === "function") {
      this.expect("open", "(");
      rows = this.table().rows;
      this.expect("close", ")");
    } else if (this.token.text === "[") {
      rows = [];
      for (let more = true; more;) {
        this.expect("open", "[");
        rows.push(...this.rows(["comma"], [], "close"));
        const {kind} = this.take();
        if (kind !== "close" && kind !== "comma") this.failHere("the next row of the matrix");
        more = kind === "comma";
      }
    } else rows = this.rows(["comma"], ["line", "row"], "close");
    return {is: "table", rows, parts: rows.flat()};
  }
  rows(column, row, end) {
    const rows = [[]];
    for (;;) {
      rows.at(-1).push(this.expression());
      let {kind} = this.take();
      if (row.includes(kind) && this.token.kind === end) ({kind} = this.take());
      if (row.includes(kind)) rows.push([]);
      else if (kind === end) return rows;
      else if (!column.includes(kind)) {
        this.at--;
        this.failHere("the next entry of the matrix");
      }
    }
  }
  call() {
    const token = this.take(), word = page.functions[token.text];
    if (word === "Derivative") return this.rate();
    if (word === "jacobian") throw undecided("A derivative");
    if (word === "Matrix") {
      this.at--;
      return this.table();
    }
    if (word === "cross" || word === "atan2") {
      this.expect("open", "(");
      const first = this.expression();
      this.expect("comma", ",");
      const second = this.expression();
      this.expect("close", ")");
      return {is: word, parts: [first, second]};
    }
    if (has(INVERSE, word)) return this.inverse(token, word);
    const power = this.token.kind === "power" || this.isOperator("^") ? this.exponent() : 1;
    if (power === -1 && has(INVERSE, `arc${word}`)) return this.inverse(token, `arc${word}`);
    const under = table.RECIPROCALS[word];
    if (under && power === -1) throw undecided("An inverse of it");
    const own = {is: under || word, parts: [this.argument(token)]};
    const node = under ? {is: "quotient", parts: [numberNode(1), own]} : own;
    return power === 1 ? node : {is: "power", parts: [node], exponent: power};
  }
  // Derivative(theta1(t), t) and Derivative(theta1(t), (t, 2)) of a coordinate, as SymPy prints them.
  rate() {
    let text = "", depth = 0;
    do {
      const token = this.take();
      depth += {open: 1, close: -1}[token.kind] || 0;
      text += token.text;
    } while (depth > 0 && this.token.kind !== "stop");
    const [, name, twice] = /^\((\w+?)(?:\(t\))?,(?:t|\(t,1\)|(\(t,2\)|t,t|t,2))\)$/.exec(text) || [];
    const rate = name && this.meaning((twice ? "\u02d9\u02d9" : "\u02d9") + name);
    if (!rate) throw undecided("A derivative");
    return {is: "name", text: name, parts: [], ...rate};
  }
  inverse({text}, word) {
    const bare = ["fraction", "function", ...(word === "sqrt" ? ["number", "name"] : [])];
    if (bare.includes(this.token.kind)) return {is: word, parts: [this.primary()]};
    if (this.token.kind !== "open") this.failHere(`a bracket after ${text}`);
    return {is: word, parts: [this.nested(() => this.bracket())]};
  }
  // A bracket; or, without one, numbers and one angle: cos 2θ1.
  argument(word) {
    if (this.token.kind === "open") return this.nested(() => this.bracket());
    if (this.token.kind === "function" && has(INVERSE, page.functions[this.token.text])) return this.primary();
    const factors = [], first = this.token;
    for (; ["number", "fraction"].includes(this.token.kind) || this.isOperator("-", "*");) {
      if (!this.isOperator("-", "*")) factors.push(this.degrees(this.primary()));
      else if (this.take().text === "-") factors.push(numberNode(-1));
      else if (!factors.length) throw unreadable(`${word.text} needs an angle after it`);
    }
    const isIndex = factors.length === 1 && first.kind === "number" && !first.apart && /^[0-9]+$/.test(first.text);
    if (this.token.kind === "name") factors.push(this.name());
    else if (isIndex && this.ahead(-1) === first) {
      throw unreadable(`${word.text}${first.text} may be that of a sum of angles or of a number. Write ${word.text[0]}${first.text} for the first, ${word.text}(${first.text}) for the second.`);
    }
    if (!factors.length) this.failHere(`the angle of ${word.text}`);
    if (this.token.kind === "power" || this.isOperator("^")) {
      throw unreadable(`this power may belong to the angle or to ${word.text}: write ${word.text}^2(...)`);
    }
    return productOf(factors);
  }
}
const numberNode = (value, text) => ({is: "number", value, text, parts: []});
const productOf = (factors) => factors.length > 1 ? {is: "product", parts: factors} : factors[0];
const isCross = (sign) => sign === "\u00d7" || sign === "\\times";
const nodesOf = (node) => [node, ...node.parts.flatMap(nodesOf)];
const isBoth = (node) => node.is === "name" && Boolean(node.s && node.t);
const tableOf = (x) => x.is === "table" ? x.rows : x.is === "name" && !x.s && x.t;
const isTable = (node) => nodesOf(node).some((x) => x.is === "cross" || tableOf(x));
const isVector = (node) => nodesOf(node).some((x) => x.is === "cross" || (tableOf(x) && tableOf(x)[0].length === 1));
const mayBeTable = (node) => isTable(node) || nodesOf(node).some(isBoth);

// ---------------------------------------------------------------- values
const EQUAL = 1e-9, STEEPEST = 100;
const exact = (v) => ({v, s: Math.abs(v)});
const add = (a, b) => ({v: a.v + b.v, s: a.s + b.s});
const negated = ({v, s}) => ({v: -v, s});
const times = (a, b) => ({v: a.v * b.v, s: Math.abs(a.v) * b.s + Math.abs(b.v) * a.s});
const over = (a, b) => {
  const v = vanishes(b) ? NaN : a.v / b.v;
  return {v, s: (a.s + Math.abs(v) * b.s) / Math.abs(b.v)};
};
const vanishes = ({v, s}) => Math.abs(v) <= EQUAL * s;
function raised(a, n) {
  return n < 0 ? over(exact(1), raised(a, -n)) : {v: a.v ** n, s: n * Math.abs(a.v) ** Math.max(n - 1, 0) * a.s};
}
const through = (f, slope) => ({v, s}) => ({v: f(v), s: Math.min(Math.abs(slope(v)), STEEPEST) * s + Math.abs(f(v))});
const INVERSE = {
  sqrt: through(Math.sqrt, (v) => 0.5 / Math.sqrt(v)), arccos: through(Math.acos, (v) => 1 / Math.sqrt(1 - v * v)),
  arcsin: through(Math.asin, (v) => 1 / Math.sqrt(1 - v * v)), arctan: through(Math.atan, (v) => 1 / (1 + v * v)),
};
const FUNCTIONS = {
  ...INVERSE, sin: through(Math.sin, Math.cos), cos: through(Math.cos, Math.sin),
  tan: through(Math.tan, (v) => Math.cos(v) ** -2), sgn: through(Math.sign, () => 0), abs: through(Math.abs, () => 1),
};

// Functions of several values, with the second one by the first; more in one answer are not tried.
const SECOND = {sqrt: negated, arccos: negated, arcsin: (y) => add(exact(Math.PI), negated(y)), arctan: (y) => add(y, exact(Math.PI))};
const MOST_BRANCHES = 5;
// Sets of functions, as text, whose second value is taken; first that of none.
function choices(node) {
  const several = [...new Set(nodesOf(node).filter(({is}) => SECOND[is]).map((x) => JSON.stringify(x)))];
  if (several.length > MOST_BRANCHES) throw unreadable(`at most ${MOST_BRANCHES} inverse functions are read in an equation`);
  return Array.from({length: 2 ** several.length}, (_, k) => several.filter((_, j) => k >> j & 1));
}

// Of a vector or matrix {rows}.
const eachOf = (x, change) => x.rows ? {rows: x.rows.map((row) => row.map(change))} : change(x);
const shapeOf = ({rows}) => {
  if (rows.some((row) => row.length !== rows[0].length)) throw unreadable("the rows of this matrix have different lengths");
  return [rows.length, rows[0].length];
};
const flipped = ({rows}) => ({rows: rows[0].map((_, j) => rows.map((row) => row[j]))});
const sizeOf = (x) => x.rows ? (shapeOf(x).includes(1) ? `a vector of ${Math.max(...shapeOf(x))}` : `a matrix of ${shapeOf(x).join(" \u00d7 ")}`) : "a number";
const entriesOf = (x) => x.rows ? x.rows.flat() : [x];
const inner = (a, b) => a.map((x, k) => times(x, b[k])).reduce(add);
const determinant = (rows) => rows.length === 1 ? rows[0][0] : rows[0].map((x, k) => {
  const term = times(x, determinant(rows.slice(1).map((row) => row.filter((_, j) => j !== k))));
  return k % 2 ? negated(term) : term;
}).reduce(add);
const inverseOf = ({rows}) => {
  const minor = (i, j) => rows.filter((_, r) => r !== j).map((row) => row.filter((_, c) => c !== i));
  return {rows: rows.map((_, i) => rows.map((_, j) => {
    const above = rows.length > 1 ? determinant(minor(i, j)) : exact(1);
    return over((i + j) % 2 ? negated(above) : above, determinant(rows));
  }))};
};

// The value of a tree; look: of what a name stands for; seconds: functions whose second value is taken.
class Valuer {
  constructor(look, seconds = []) { Object.assign(this, {look, seconds}); }
  scalar(node) {
    const found = this.at(node);
    if (found.rows) throw unreadable("a vector or matrix stands where one expression is expected");
    return found;
  }
  at(node) {
    const [a, b] = node.parts;
    switch (node.is) {
      case "number": return exact(node.value);
      case "name": return node.s ? this.look(node.s) : {rows: node.t.map((row) => row.map(this.look))};
      case "table": return {rows: node.rows.map((row) => row.map((x) => this.scalar(x)))};
      case "sum": return this.sum(node.parts);
      case "negative": return eachOf(this.at(a), negated);
      case "product": return this.product(node.parts);
      case "quotient": {
        const below = this.scalar(b);
        return eachOf(this.at(a), (x) => over(x, below));
      }
      case "power": return this.power(this.at(a), node.exponent);
      case "transposed": return eachOf(this.table(a), (x) => x).rows ? flipped(this.table(a)) : this.table(a);
      case "cross": return this.cross(this.table(a), this.table(b));
      case "dot": {
        const [u, v] = [a, b].map((x) => entriesOf(this.table(x)));
        if (u.length !== v.length) throw unreadable("vectors of different lengths have no product");
        return inner(u, v);
      }
      case "atan2": {
        const [y, x] = [a, b].map((part) => this.scalar(part)), v = Math.atan2(y.v, x.v);
        return {v, s: (x.s + y.s) / Math.hypot(x.v, y.v) + Math.abs(v)};
      }
      default: {
        const found = FUNCTIONS[node.is](this.scalar(a));
        return this.seconds.length && this.seconds.includes(JSON.stringify(node)) ? SECOND[node.is](found) : found;
      }
    }
  }
  table(node) {
    const found = this.at(node);
    return found.rows ? found : this.asTable(node) || found;
  }
  // A scalar expression as vector, where one of its factors may be one; 0 as that of 0s.
  asTable(node, shape) {
    if (isTable(node)) {
      const found = this.at(node);
      if (found.rows) return found;
    }
    if (isBoth(node)) return {rows: node.t.map((row) => row.map(this.look))};
    const [a] = node.parts;
    if (node.is === "negative") {
      const own = this.asTable(a, shape);
      return own && eachOf(own, negated);
    }
    if (node.is === "quotient") {
      const own = this.asTable(a, shape);
      return own && eachOf(own, (x) => over(x, this.scalar(node.parts[1])));
    }
    if (node.is === "sum") {
      const own = node.parts.map((part) => this.asTable(part, shape));
      return own.every((x) => x && String(shapeOf(x)) === String(shapeOf(own[0]))) ? this.added(own) : null;
    }
    if (node.is === "product") {
      const own = node.parts.map((part) => this.asTable(part, shape)), k = own.findIndex(Boolean);
      if (own.filter(Boolean).length !== 1) return null;
      const rest = node.parts.filter((_, j) => j !== k).map((part) => this.scalar(part));
      return eachOf(own[k], (x) => rest.reduce(times, x));
    }
    if (node.is === "number" && node.value === 0 && shape) return {rows: Array.from({length: shape[0]}, () => Array(shape[1]).fill(exact(0)))};
    return null;
  }
  added(tables) { return {rows: tables[0].rows.map((row, i) => row.map((_, j) => tables.map((x) => x.rows[i][j]).reduce(add)))}; }
  sum(parts) {
    const terms = parts.map((part) => this.at(part)), first = terms.find((x) => x.rows);
    if (!first) return terms.reduce(add);
    const shape = shapeOf(first);
    return this.added(terms.map((x, k) => {
      let found = x.rows ? x : this.asTable(parts[k], shape) || (String(shape) === "1,1" ? {rows: [[x]]} : x);
      if (found.rows && String(shapeOf(found)) !== String(shape) && String(shapeOf(found).reverse()) === String(shape) && shape.includes(1)) found = flipped(found);
      if (!found.rows || String(shapeOf(found)) !== String(shape)) throw unreadable(`${sizeOf(found)} is added to ${sizeOf(first)}`);
      return found;
    }));
  }
  product(parts) {
    const factors = parts.map((part) => this.at(part));
    if (!factors.some((x) => x.rows)) return factors.reduce(times);
    return factors.slice(1).reduce((a, b, k) => this.times(a, b, parts[k], parts[k + 1]), factors[0]);
  }
  times(a, b, left, right) {
    const named = (node) => ({rows: node.t.map((row) => row.map(this.look))});
    if (!a.rows && b.rows && isBoth(left) && left.t[0].length > 1) a = named(left);
    else if (a.rows && !b.rows && isBoth(right) && right.t[0].length === 1 && right.t.length > 1 && shapeOf(a)[1] === right.t.length) b = named(right);
    if (!a.rows && !b.rows) return times(a, b);
    if (!a.rows || !b.rows) return a.rows ? eachOf(a, (x) => times(b, x)) : eachOf(b, (x) => times(a, x));
    let [n, m] = shapeOf(a), [k, p] = shapeOf(b);
    if (m !== k && k === 1 && m === p) { b = flipped(b); [k, p] = [p, 1]; }
    if (m !== k && m === 1 && p === 1 && n === k) { a = flipped(a); [n, m] = [1, n]; }
    if (m !== k) throw unreadable(`${sizeOf(a)} is multiplied with ${sizeOf(b)}`);
    const rows = a.rows.map((row) => flipped(b).rows.map((column) => inner(row, column)));
    return n === 1 && p === 1 ? rows[0][0] : {rows};
  }
  power(base, exponent) {
    if (!base.rows) return raised(base, exponent);
    const [rows, columns] = shapeOf(base);
    if (exponent === 2 && (rows === 1 || columns === 1)) return inner(entriesOf(base), entriesOf(base));
    if (exponent === -1 && rows === columns && rows <= 3) return inverseOf(base);
    throw unreadable(`${sizeOf(base)} has no power ${exponent} here`);
  }
  cross(left, right) {
    const [a, b] = [left, right].map(entriesOf), less = (x, y) => add(x, negated(y));
    const turned = (w) => ({rows: [[negated(times(w, b[1]))], [times(w, b[0])]]});
    const sizes = `${a.length} ${b.length}`;
    if (sizes === "3 3") return {rows: [[1, 2], [2, 0], [0, 1]].map(([i, j]) => [less(times(a[i], b[j]), times(a[j], b[i]))])};
    if (sizes === "2 2") return less(times(a[0], b[1]), times(a[1], b[0]));
    if (sizes === "1 2") return turned(a[0]);
    if (sizes === "3 2") return turned(a[2]);
    if (sizes === "1 1") return times(a[0], b[0]);
    throw unreadable(`${sizeOf(left)} and ${sizeOf(right)} have no cross product`);
  }
}
