// Formulas that are typed: read by a parser of our own, never run as code. A formula becomes a
// function of the inputs x and the values y, whose result is a number or, of a vector, [a, b] or [a, b, c].

const MARKS = "\u2080\u2081\u2082\u2083\u2084\u2085\u2086\u2087\u2088\u2089";
const GREEK = {"\u03b8": "theta", "\u03c4": "tau", "\u03c9": "omega", "\u03bb": "lam", "\u03c0": "pi",
  "\u03c6": "phi", "\u03c8": "psi", "\u03b1": "alpha", "\u03b2": "beta", "\u03b3": "gamma", "\u03a6": "Phi", "\u0394": "Delta"};
const LONGEST = 2000, DEEPEST = 60;
const COMMA = "Vectors are written in square brackets, [a, b], and decimals with a point.";
const FUNCTIONS = {sin: 1, cos: 1, sgn: 1, cross: 2, dot: 2};
const functionOf = (word) => Object.hasOwn(FUNCTIONS, word.toLowerCase()) ? word.toLowerCase() : "";

function unreadable(message) { return Object.assign(new Error(message), {unreadable: true}); }

// LaTeX, Greek letters, dots above, primes, subscripts and raised numbers in plain letters.
function plainly(text) {
  if (text.length > LONGEST) throw unreadable("The formula is too long.");
  let plain = text.normalize("NFD").replace(/[\u2080-\u2089]/g, (c) => MARKS.indexOf(c));
  plain = plain.replace(/([_^])\s*\{\s*(-?\w+)\s*\}/g, "$1$2").replace(/\\(?:left|right|[,;:! ])/g, " ");
  plain = plain.replace(/\\(?:cdot|times|ast)\b/g, "*").replace(/\\lambda(?![A-Za-z])/g, "\u03bb");
  plain = plain.replace(/\\(d?dot)\s*\{?\s*\\?([A-Za-z]+|[^\x00-\x7f])\s*\}?/g, (_, dots, letters) =>
    ` ${letters}${dots === "dot" ? "\u0307" : "\u0308"}`);
  for (let before = ""; before !== plain;) {
    before = plain;
    plain = plain.replace(/\\[dt]?frac\s*\{([^{}]*)\}\s*\{([^{}]*)\}/g, " (($1)/($2))");
  }
  plain = plain.replace(/\\([A-Za-z]+)/g, " $1").replace(/[\u0370-\u03ff]/g, (c) => GREEK[c] || c);
  plain = plain.replace(/([A-Za-z]+)([\u0307\u0308])(?:_?(\d+)|_(\w+))?/g, (_, letters, dots, digits, low) =>
    letters + (digits || low || "") + (dots === "\u0307" ? "_d" : "_dd"));
  plain = plain.replace(/\b([A-Za-z]\w*)('{1,2}|[\u2019\u2032\u2033])/g, (_, name, primes) =>
    name + (primes === "''" || primes === "\u2033" ? "_dd" : "_d"));
  plain = plain.replace(/\u00b2/g, "^2").replace(/\u00b3/g, "^3").replace(/\*\*/g, "^");
  plain = plain.replace(/(\S*)(\s*)([\u00bc-\u00be\u2153-\u215e])/g, (_, before, space, c) => {
    if (/[\w.)\]]$/.test(before)) throw unreadable(`Write * between ${before} and ${c}.`);
    return `${before}${space}(${c.normalize("NFKD").replace("\u2044", "/")})`;
  });
  plain = plain.replace(/\{/g, "(").replace(/\}/g, ")").replace(/[\s.;]+$/, "");
  return plain.replace(/\u2212/g, "-").replace(/[\u00b7\u00d7\u22c5]/g, "*").trim();
}

function tokens(text) {
  const plain = plainly(text), found = [];
  const pattern = /\s*(?:(\d+\.?\d*(?:[eE][+-]?\d+)?|\.\d+)|([A-Za-z][A-Za-z0-9_]*)|([-+*\/^()\[\],]))/y;
  const rest = /\s*$/y;
  let at = 0;
  for (;;) {
    rest.lastIndex = at;
    if (rest.test(plain)) return found;
    pattern.lastIndex = at;
    const match = pattern.exec(plain);
    if (!match) throw unreadable(`${JSON.stringify(plain.slice(at).trim()[0])} has no meaning here.`);
    if (match[1]) found.push({kind: "number", value: Number(match[1]), text: match[1]});
    else if (match[2]) found.push({kind: "name", text: match[2]});
    else found.push({kind: match[3], text: match[3]});
    at = pattern.lastIndex;
  }
}

// Arithmetic of numbers and vectors of two or three entries.
const isVector = Array.isArray;
const one = (a, f) => isVector(a) ? a.map(f) : f(a);
function sum(a, b) {
  if (isVector(a) !== isVector(b)) throw unreadable("A number and a vector cannot be added.");
  if (isVector(a) && a.length !== b.length) throw unreadable("Vectors of two and of three entries cannot be added.");
  return isVector(a) ? a.map((u, k) => u + b[k]) : a + b;
}
function product(a, b) {
  if (isVector(a) && isVector(b)) throw unreadable("Of two vectors write cross(a, b) or dot(a, b).");
  return isVector(a) ? one(a, (u) => u * b) : one(b, (u) => a * u);
}
function quotient(a, b) {
  if (isVector(b)) throw unreadable("Nothing can be divided by a vector.");
  return one(a, (u) => u / b);
}
function scalar(a) {
  if (isVector(a)) throw unreadable("A number is needed where a vector stands.");
  return a;
}
function cross(a, b) {
  if (!isVector(b) || (b.length === 3 && !isVector(a))) throw unreadable("cross(a, b) needs vectors a and b.");
  if (isVector(a) && a.length !== b.length) throw unreadable("cross(a, b) needs vectors of one size.");
  if (b.length === 3) return [0, 1, 2].map((k) => a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
  return isVector(a) ? a[0] * b[1] - a[1] * b[0] : [-a * b[1], a * b[0]];
}
function dot(a, b) {
  if (!isVector(a) || !isVector(b) || a.length !== b.length) throw unreadable("dot(a, b) needs two vectors.");
  return a.reduce((total, u, k) => total + u * b[k], 0);
}
const raised = (a, power) => power === 1 ? a : isVector(a) && power === 2 ? dot(a, a) : scalar(a) ** power;
const CALLS = {
  sin: (a) => Math.sin(scalar(a)), cos: (a) => Math.cos(scalar(a)), sgn: (a) => Math.sign(scalar(a)),
  cross, dot,
};

// A word as the fewest names and functions that it can be made of, m2lc2 or cosq2; null where there
// is no way, or not one alone.
function cut(word, meaning) {
  let ways = [[0, []]];
  const best = new Map(ways);
  for (let end = 1; end <= word.length && word.length <= 60; end++) {
    ways = [...best].filter(([from]) => meaning(word.slice(from, end)) || functionOf(word.slice(from, end)));
    const shortest = Math.min(...ways.map(([, way]) => way.length));
    const found = ways.filter(([, way]) => way.length === shortest);
    if (found.length) best.set(end, found.length > 1 ? Array(99) : [...found[0][1], word.slice(found[0][0], end)]);
  }
  const way = best.get(word.length);
  return way && way.length < 99 ? way : null;
}

// meaning(name): a function of (x, y), with .vector where that is one, or undefined. So is what is
// returned.
function readFormula(text, meaning) {
  const all = tokens(text);
  let at = 0, depth = 0, bare = -1; // bare: where the last number without a power ended
  let vector = false;
  function next() {
    const token = all[at];
    if (token && token.kind === "name" && !functionOf(token.text) && !meaning(token.text)) {
      const way = cut(token.text, meaning);
      if (way) all.splice(at, 1, ...way.map((piece) => ({kind: "name", text: piece})));
    }
    return all[at] ? all[at].kind : "end";
  }
  function expect(kind) {
    if (next() !== kind) throw unreadable(`${kind} is missing ${all[at] ? `before ${all[at].text}` : "at the end"}.`);
    return all[at++];
  }
  function expression() {
    if (++depth > DEEPEST) throw unreadable("The brackets are too deep.");
    let total = term();
    while (next() === "+" || next() === "-") {
      const minus = all[at++].kind === "-", left = total, right = term();
      total = (x, y) => sum(left(x, y), minus ? one(right(x, y), (u) => -u) : right(x, y));
    }
    depth--;
    return total;
  }
  function term() {
    let total = signed(), divided = false;
    for (;;) {
      const left = total, kind = next();
      if (kind === "/") {
        at++;
        const right = signed();
        total = (x, y) => quotient(left(x, y), right(x, y));
        divided ||= bare !== at; // 1/2 m and l1/2 c1 can mean but one thing
      } else if (kind === "*" || kind === "number" || kind === "name" || kind === "(" || kind === "[") {
        if (kind === "*") at++;
        else if (kind === "number" && (all[at - 1].kind === "number" || !all[at].text.includes(".")))
          throw unreadable(`Write * or ^ between ${all[at - 1].text} and ${all[at].text}.`);
        else if (divided) throw unreadable("Write * or brackets after a division by what is not a number.");
        const right = kind === "*" ? signed() : factor();
        total = (x, y) => product(left(x, y), right(x, y));
      } else return total;
    }
  }
  function signed() {
    if (++depth > DEEPEST) throw unreadable("There are too many signs.");
    let found;
    if (next() === "-") {
      at++;
      const operand = signed();
      found = (x, y) => one(operand(x, y), (u) => -u);
    } else if (next() === "+") {
      at++;
      found = signed();
    } else found = factor();
    depth--;
    return found;
  }
  function factor() {
    const base = atom();
    if (next() !== "^") {
      if (all[at - 1].kind === "number") bare = at;
      return base;
    }
    const power = exponent();
    return (x, y) => raised(base(x, y), power);
  }
  function exponent() {
    at++;
    const inside = next() === "(";
    if (inside) at++;
    const minus = next() === "-";
    if (minus) at++;
    const power = expect("number").value * (minus ? -1 : 1);
    if (inside) expect(")");
    if (!Number.isInteger(power)) throw unreadable("Powers are whole numbers.");
    if (next() === "^") throw unreadable("Write brackets around a power of a power.");
    return power;
  }
  function atom() {
    next();
    const token = all[at++];
    if (!token) throw unreadable("The formula ends too soon.");
    if (token.kind === "number") return () => token.value;
    if (token.kind === "(") {
      const inside = expression();
      if (next() === ",") throw unreadable(COMMA);
      expect(")");
      return inside;
    }
    if (token.kind === "[") {
      const entries = [expression()];
      while (next() === "," && entries.length < 3) {
        at++;
        entries.push(expression());
      }
      expect("]");
      if (entries.length < 2) return entries[0];
      vector = true;
      return (x, y) => entries.map((entry) => scalar(entry(x, y)));
    }
    if (token.kind !== "name") throw unreadable(`${token.text} stands where a number or a name is needed.`);
    return functionOf(token.text) ? call(functionOf(token.text)) : name(token.text);
  }
  function call(word) {
    if (FUNCTIONS[word] > 1) vector = true;
    let power = 1;
    if (next() === "^" && FUNCTIONS[word] === 1) power = exponent();
    if (power < 1) throw unreadable(`Write (${word}(...))^${power}.`);
    const given = next() === "(" || next() === "[" ? inBrackets() : [angle(word)];
    if (given.length !== FUNCTIONS[word]) throw unreadable(`${word} is given ${given.length} values.`);
    return (x, y) => raised(CALLS[word](...given.map((f) => f(x, y))), power);
  }
  function inBrackets() {
    const close = all[at++].kind === "(" ? ")" : "]";
    const given = [expression()];
    while (next() === ",") {
      at++;
      given.push(expression());
    }
    expect(close);
    return given;
  }
  // Without brackets a function takes numbers and one name: cos 2 theta1.
  function angle(word) {
    const factors = [];
    while (next() === "number" || next() === "-") {
      const token = all[at++];
      factors.push(() => token.kind === "-" ? -1 : token.value);
    }
    if (next() !== "name" || functionOf(all[at].text) || FUNCTIONS[word] > 1) throw unreadable(`Write brackets: ${word}(...).`);
    factors.push(name(all[at++].text));
    if (next() === "^") throw unreadable(`Write ${word}^2(...) or ${word}((...)^2).`);
    return (x, y) => factors.reduce((total, factor) => total * scalar(factor(x, y)), 1);
  }
  function name(word) {
    const found = meaning(word) || (word === "pi" ? () => Math.PI : undefined);
    if (!found) throw unreadable(`There is no ${word} that this line may use.`);
    vector ||= Boolean(found.vector);
    return found;
  }
  const whole = expression();
  if (at < all.length) throw unreadable(next() === "," ? COMMA : `${all[at].text} is not expected.`);
  return Object.assign(whole, {vector});
}
