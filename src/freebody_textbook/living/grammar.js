// Formulas that are typed, read by the tables of Python's reader: characters into lexemes, other
// spellings into one, lexemes into names, numbers, operators and brackets. Nothing is run as code.

const table = page.grammar, has = (object, key) => Object.hasOwn(object, key);
const LONGEST = 2000;

function unreadable(message) { return Object.assign(new Error(message), {unreadable: true}); }

// ---------------------------------------------------------------- lexemes
const oneOf = (texts) => [...texts].join("").replace(/[\\\]^-]/g, "\\$&");
const [LOW, HIGH, VULGAR] = [table.LOW, table.HIGH, table.VULGAR_FRACTIONS].map((x) => oneOf(Object.keys(x)));
const LEXEME = new RegExp([
  `(?<letter>(?![\\p{Nd}${LOW}${HIGH}\u1d40${VULGAR}])[\\p{L}\\p{N}][${table.ANY_MARK}]*)`,
  "(?<digit>[0-9])", `(?<blank>(?:[^\\S\\n]|[${oneOf(table.SILENT)}])+)`,
  "\\\\(?<environment>begin|end)\\s*\\{(?<name>[A-Za-z]+\\*?)\\}(?:\\{[clr|\\s]*\\})?",
  "(?<row>\\\\\\\\(?:\\s*\\[[^\\]\\n]{0,12}\\])?)", "(?<command>\\\\(?:[A-Za-z]+|.|$))",
  `(?<low>[${LOW}])`, `(?<high>[${HIGH}])`, `(?<mark>[${table.ANY_MARK}])`, "(?<line>\\n)",
  "(?<comment>#[^\\n]*)", `(?<sign>${table.SIGNS.map((x) => x.replace(/[*]/g, "\\*")).join("|")}|.)`,
].join("|"), "gsu");
const silent = new Set(table.SILENT_COMMANDS.map((name) => `\\${name}`));

// Accents are decomposed, and letters of mathematical fonts plain ones.
const decomposed = (text) =>
  text.replace(/[\u{1d400}-\u{1d7ff}\u210e]/gu, (c) => c.normalize("NFKC")).normalize("NFD");

function scanned(text) {
  const made = [];
  let apart = true;
  for (const match of text.matchAll(LEXEME)) {
    let [kind, found] = Object.entries(match.groups).find(([, x]) => x !== undefined);
    if (kind === "environment") {
      kind = table.MATRICES.includes(match.groups.name) ? found : "blank";
      found = match.groups.name;
    }
    if (kind === "blank" || kind === "comment" || silent.has(found)) apart = true;
    else {
      made.push({kind, text: found, apart});
      apart = kind === "line";
    }
  }
  return made;
}
const plain = (lexemes) => lexemes.map((x) => x.text).join("");
const commandOf = (x) => x && x.kind === "command" ? x.text.slice(1) : "";

// ---------------------------------------------------------------- patterns of lexemes
// A step is what comes from here on, given what comes behind: it returns where the whole ends, or -1.
const STANDS = {
  apart: (all, k, end) => !touches(all, k, end),
  glued: touches,
  first: (all, k) => k === 0 || all[k - 1].kind === "line",
  last: (all, k, end) => k >= end || all[k].kind === "line",
  fresh: (all, k, end) => !(k && touches(all, k, end)) || !(isOf("name")(all[k - 1]) || all[k - 1].text === "_"),
  ends: (all, k, end) => !touches(all, k, end) || !isOf("name")(all[k]),
  word: (all, k, end) => k === 0 || !touches(all, k, end) || all[k - 1].kind !== "letter",
  word_ends: (all, k, end) => !touches(all, k, end) || all[k].kind !== "letter",
};
function touches(all, k, end) { return k < end && !all[k].apart; }

const classes = new Map();
function members(name) {
  return has(table.CLASSES, name) ? [...table.CLASSES[name]].flatMap((x) => x[0] === "%" && x[1] ? members(x.slice(1)) : [x]) : [`%${name}`];
}
function isOf(name) {
  if (!classes.has(name)) classes.set(name, testOf(name));
  return classes.get(name);
}
function testOf(name) {
  if (name === "any") return (x) => x.kind !== "line";
  if (name.startsWith("not_")) return (x) => x.kind !== "line" && !isOf(name.slice(4))(x);
  if (name === "bare_letter") return (x) => x.kind === "letter" && [...x.text].length === 1;
  if (name === "dotted_letter") return (x) => x.kind === "letter" && /[\u0307\u0308\u02d9\u00a8]/.test(x.text);
  const own = new Set(members(name));
  return (x) => own.has(x.text) || own.has(`%${x.kind}`);
}
const one = (test, glued) => (next) => (all, k, end, kept) =>
  k < end && test(all[k]) && !(glued && all[k].apart) ? next(all, k + 1, end, kept) : -1;
const zero = (test) => (next) => (all, k, end, kept) => test(all, k, end) ? next(all, k, end, kept) : -1;
const sequence = (steps) => (next) => steps.reduceRight((behind, step) => step(behind), next);
const either = (steps) => (next) => {
  const ways = steps.map((step) => step(next));
  return (all, k, end, kept) => {
    for (const way of ways) {
      const stop = way(all, k, end, kept);
      if (stop >= 0) return stop;
    }
    return -1;
  };
};
// As often as it can be, else less often.
const repeated = (step, low, high) => (next) => {
  const from = (all, k, end, kept, count) => {
    if (count < high) {
      const again = step((all, j, end, kept) => j > k ? from(all, j, end, kept, count + 1) : -1);
      const stop = again(all, k, end, kept);
      if (stop >= 0) return stop;
    }
    return count >= low ? next(all, k, end, kept) : -1;
  };
  return (all, k, end, kept) => from(all, k, end, kept, 0);
};
const keeping = (name, step) => (next) => (all, k, end, kept) => step((all, j, end, kept) => {
  const before = kept[name];
  kept[name] = [k, j];
  const stop = next(all, j, end, kept);
  if (stop < 0) kept[name] = before;
  return stop;
})(all, k, end, kept);
const here = (all, k) => k;
const looking = (step, follows) => {
  const found = step(here);
  return zero((all, k, end) => (found(all, k, end, {}) >= 0) === follows);
};
const behind = (body, mark) => {
  const test = body[0] === "%" && body.length > 1 ? isOf(body.slice(1)) : (x) => x.text === body;
  const anywhere = mark.includes("--"), wanted = mark[0] !== "!";
  return zero((all, k) => (k > 0 && (anywhere || k >= all.length || !all[k].apart) && test(all[k - 1])) === wanted);
};

const ITEM = new RegExp(`^(?:${table.ITEM})$`, "s"), TIMES = {"?": [0, 1], "*": [0, 60], "+": [1, 60]};
const named = new Map();
function namedPattern(name) {
  if (!named.has(name)) named.set(name, pattern(table.PATTERNS[name]));
  return named.get(name);
}
function pattern(text) {
  const words = text.split(/\s+/);
  let at = 0;
  const ways = () => {
    const found = [[]];
    for (; at < words.length && (words[at][0] !== ">" || words[at] === ">="); ) {
      if (words[at] === "|") { at++; found.push([]); }
      else found.at(-1).push(item());
    }
    return found.length > 1 ? either(found.map(sequence)) : sequence(found[0]);
  };
  const item = () => {
    const {back, look, name, glued, body, times} = ITEM.exec(words[at++]).groups;
    if (back && body !== "<") return behind(body, back);
    let step, often = times;
    if (body === "<") {
      step = ways();
      often = words[at++].slice(1);
      if (glued) step = sequence([zero(touches), step]);
    } else step = single(body, Boolean(glued));
    if (often) step = repeated(step, ...(TIMES[often] || often.slice(1, -1).split(",").map(Number)));
    if (name) step = keeping(name, step);
    return look ? looking(step, look === "&") : step;
  };
  return ways();
}
function single(body, glued) {
  if (body === "~") return zero(touches);
  const name = body.slice(1);
  if (name && body[0] === "%") return has(STANDS, name) ? zero(STANDS[name]) : one(isOf(name), glued);
  if (name && body[0] === "@") return glued ? sequence([zero(touches), namedPattern(name)]) : namedPattern(name);
  const wanted = scanned(body), steps = wanted.map((x, k) => one((y) => y.text === x.text, glued || k > 0));
  const isWord = wanted.length > 1 && wanted.every((x) => x.kind === "letter");
  return sequence(isWord ? [zero(STANDS.word), ...steps, zero(STANDS.word_ends)] : steps);
}

// ---------------------------------------------------------------- one spelling
const high = (text) => [...text].map((c) => table.HIGH[c] ?? c).join("");
function replacement(item, all, kept) {
  const of = (name) => all.slice(...(kept[name] || [0, 0]));
  const call = /^(frame|plain)\(\$?(\w+)\)$/.exec(item);
  if (item === "#determinant") return [{kind: "determinant", text: ""}];
  if (call && call[1] === "frame") return [{kind: "frame", text: high(plain(of(call[2])))}];
  if (call) return scanned(high(plain(of(call[2]))).replace(/\u2212/g, "-"));
  return item[0] === "$" ? of(item.slice(1)) : scanned(item);
}
const spellingRows = () => table.SPELLINGS.map(([find, text]) =>
  [pattern(find)(here), text.split(/\s+/).filter(Boolean)]);
let spellingSteps = null;
function inOneSpelling(text) {
  spellingSteps ||= spellingRows();
  return spellingSteps.reduce(respelt, scanned(decomposed(text)));
}
function respelt(all, [found, items]) {
  const matches = [];
  for (let k = 0, at = 0; k < all.length; k++) {
    const kept = {}, stop = k >= at ? found(all, k, all.length, kept) : -1;
    if (stop < 0) continue;
    matches.push([k, stop, kept]);
    at = Math.max(stop, k + 1);
  }
  const made = [];
  let at = 0, isCut = false;
  const upTo = (end) => {
    made.push(...all.slice(at, end).map((x, k) => k || !isCut ? x : {...x, apart: true}));
  };
  for (const [k, stop, kept] of matches) {
    upTo(k);
    let apart = all[k].apart || (isCut && at === k);
    for (const item of items) {
      if (item === "\u2423") apart = true;
      else for (const [j, x] of replacement(item, all, kept).entries()) {
        made.push(j ? x : {...x, apart});
        apart = false;
      }
    }
    [at, isCut] = [stop, true];  // what was put there is no part of what follows
  }
  upTo(all.length);
  return made;
}

// ---------------------------------------------------------------- words
const DOT = "\u02d9", PRIME = "'", DETERMINANT = "\ue01a";
const ONE_LETTER = "a dot or bar needs a single letter under it, such as \\dot{\\theta}_1";
const DEEPEST_COMMANDS = 4, LONGEST_WORD = 200;
const frameMark = (text) => text ? String.fromCharCode(0xe010 + Number(text)) : DETERMINANT;
const isCommand = (name) => table.FONTS.includes(name) || has(table.LETTER_COMMANDS, name) || has(table.ACCENTS, name);

// The plain spelling of a letter with its marks; of anything else "".
function letterOf(x) {
  if (!x || x.kind !== "letter") return "";
  const [c, ...marks] = x.text;
  if (!(has(table.LETTERS, c) || c <= "\x7f") || marks.some((mark) => !has(table.MARKS, mark))) return "";
  return marks.map((mark) => table.MARKS[mark]).join("") + (table.LETTERS[c] ?? c);
}
const beginsWord = (x) => x.text === "_" || isCommand(commandOf(x)) || letterOf(x) !== "";

// The word that begins at a lexeme: its plain spelling, where new names may begin in it, a power
// that stood before its subscript, and the lexeme behind it.
function spell(all, at, depth = 0) {
  const word = {plain: "", cuts: new Set(), power: null, at};
  const add = (text, cut = true) => {
    if (cut) word.cuts.add(word.plain.length);
    word.plain += text;
  };
  const text = (k) => all[k] ? all[k].text : "", glued = (k) => all[k] && !all[k].apart ? all[k].text : "";
  const closing = (k) => {
    for (let j = k, deep = 0; j < all.length; j++) {
      deep += text(j) === "{" ? 1 : text(j) === "}" ? -1 : 0;
      if (!deep) return j;
    }
    throw unreadable("this brace is not closed");
  };
  const star = () => {
    if (text(word.at) !== "^") return 0;
    if (table.STARS.includes(text(word.at + 1))) return 2;
    return text(word.at + 1) === "{" && table.STARS.includes(text(word.at + 2)) && all[word.at + 3] ? 4 : 0;
  };
  // Of how many lexemes a power is in front of a subscript.
  const earlyPower = () => {
    const k = word.at;
    let figure = text(k), count = 1;
    if (figure === "^") {
      const braced = +(glued(k + 1) === "{");
      figure = glued(k + 1 + braced);
      count = 2 + braced;
      count += +(glued(k + count) === "}");
      if (!/^[0-9]+$/.test(figure)) return 0;
    } else if (!["\u00b2", "\u00b3"].includes(figure)) return 0;
    const next = glued(k + count);
    if (next !== "_" && !/^[0-9]$/.test(table.LOW[next] ?? "")) return 0;
    word.power = Number(table.HIGH[figure] ?? figure);
    return count;
  };
  const unit = () => {
    const x = all[word.at], letter = letterOf(x);
    let count = 0;
    if (letter) {
      word.at++;
      let marks = "";
      while (all[word.at] && all[word.at].kind === "mark" && !all[word.at].apart) marks += table.MARKS[all[word.at++].text] ?? "";
      add(marks + letter);
    } else if (x.kind === "digit") { word.at++; add(x.text); }
    else if (x.kind === "low") { word.at++; add(table.LOW[x.text], false); }
    else if (has(table.PRIMES, x.text)) { word.at++; add(PRIME.repeat(table.PRIMES[x.text]), false); }
    else if ((count = star())) { word.at += count; add("*", false); }
    else if ((count = earlyPower())) word.at += count;
    else if (x.kind === "frame" || x.kind === "determinant") { word.at++; add(frameMark(x.text), false); }
    else if (x.text === "_") subscript();
    else return false;
    return true;
  };
  // Behind underscores a group in braces, or one letter, with which no name begins.
  const subscript = () => {
    while (text(word.at) === "_") word.at++;
    const x = all[word.at];
    if (!x || x.apart) return;
    if (x.text !== "{") {
      const start = word.plain.length;
      if (has(table.LETTER_COMMANDS, commandOf(x))) { add(table.LETTER_COMMANDS[commandOf(x)], false); word.at++; }
      else if (start && unit()) word.cuts.delete(start);
      return;
    }
    const close = closing(word.at);
    for (const y of all.slice(word.at + 1, close)) {
      const own = ["letter", "digit"].includes(y.kind) && y.text[0] <= "\x7f" ? y.text[0] : "";
      add(own || PRIME.repeat(table.PRIMES[y.text] ?? 0) || (table.LETTER_COMMANDS[commandOf(y)] ?? ""), false);
    }
    word.at = close + 1;
  };
  // A Greek letter, a dot over something, a font.
  const command = () => {
    const name = commandOf(all[word.at++]);
    if (has(table.LETTER_COMMANDS, name)) return add(table.LETTER_COMMANDS[name]);
    if (!isCommand(name)) throw unreadable(`the command \\${name} is not known here`);
    if (depth === DEEPEST_COMMANDS) throw unreadable("commands inside commands, too deep");
    const inner = argument(), marks = table.ACCENTS[name] ?? "";
    word.at = inner.at;
    if (marks.includes(DOT) && inner.plain.startsWith(DOT)) throw unreadable("dots over dots");
    [...marks + inner.plain].forEach((c, k) => add(c, k === 0 || (!marks && inner.cuts.has(k))));
    word.power = inner.power;
  };
  const argument = () => {
    const x = all[word.at];
    if (!x || !(x.text === "{" || beginsWord(x) || x.kind === "command")) throw unreadable(ONE_LETTER);
    if (x.text === "{") {
      const close = closing(word.at), inner = grouped(word.at + 1, close, depth + 1);
      if (inner.at !== close) throw unreadable(ONE_LETTER);
      return {...inner, at: close + 1};
    }
    if (x.kind !== "command") {
      const inner = spell(all.slice(0, word.at + 1), word.at, depth);
      return inner;
    }
    if (!has(table.LETTER_COMMANDS, commandOf(x))) throw unreadable(ONE_LETTER);
    return {plain: table.LETTER_COMMANDS[commandOf(x)], cuts: new Set([0]), power: null, at: word.at + 1};
  };
  const grouped = (k, close, depth) => {
    if (text(k) === "{" && depth < DEEPEST_COMMANDS) {
      const end = closing(k), inner = grouped(k + 1, end, depth + 1);
      return inner.at === end ? {...inner, at: end + 1} : inner;
    }
    if (k >= close || !(beginsWord(all[k]) || all[k].kind === "command")) throw unreadable(ONE_LETTER);
    return spell(all, k, depth);
  };
  if (all[at].kind === "command") command();
  for (let first = word.at === at; word.at < all.length; first = false) {
    if ((all[word.at].apart && !first) || !unit()) break;
  }
  return word;
}

// A word as the fewest known names; a number may follow a function, cos2θ1. null where there is no way.
function cutWord(word, isKnown, isFunction) {
  if (isKnown(word.plain) || isFunction(word.plain)) return [word.plain];
  const size = word.plain.length, cuts = [...word.cuts].sort((a, b) => a - b);
  if (!size || size > LONGEST_WORD) return null;
  const best = new Map([[0, [[0]]]]);
  for (const i of cuts) {
    for (const j of [...new Set([...cuts, size])].sort((a, b) => a - b)) {
      if (!best.has(i) || j <= i) continue;
      const piece = word.plain.slice(i, j);
      let ways = best.get(i);
      if (/^[0-9]+$/.test(piece)) ways = ways.filter((way) => way.length > 1 && isFunction(word.plain.slice(way.at(-2), i)));
      else if (!isKnown(piece) && !isFunction(piece)) ways = [];
      const longer = ways.map((way) => [...way, j]), before = best.get(j);
      if (!longer.length) continue;
      if (!before || longer[0].length < before[0].length) best.set(j, longer);
      else if (longer[0].length === before[0].length) best.set(j, [...before, ...longer].slice(0, 2));
    }
  }
  const ways = best.get(size);
  if (!ways) return null;
  const pieces = (way) => way.slice(1).map((j, k) => word.plain.slice(way[k], j));
  if (ways.length > 1) throw unreadable(`${word.plain} may be ${ways.map((way) => pieces(way).join("\u00b7")).join(" or ")}: put spaces`);
  return pieces(ways[0]);
}

// ---------------------------------------------------------------- tokens
const numberStep = () => namedPattern("number")(here);
// names(word): the names that a word is made of.
function tokensOf(all, names, isFunction) {
  const found = [], closing = new Set(Object.values(table.BRACKETS));
  const is = (kind, text, value) => found.push({kind, text, value, apart: all[k].apart});
  let k = 0;
  const number = () => {
    let stop = numberStep()(all, k, all.length, {});
    if (stop < 0) {
      if (all[k + 1] && !all[k + 1].apart && all[k + 1].kind !== "line") throw unreadable("a decimal point without digits");
      return k + 1;  // a full stop
    }
    const kinds = found.slice(-2).map((token) => token.kind);
    const bare = kinds.at(-1) === "fraction" || kinds.join() === "fraction,number";
    if (bare && all.slice(k, stop).every((x) => x.kind === "digit")) stop = k + 1;  // \frac12
    const text = plain(all.slice(k, stop)), [mantissa, exponent] = text.toLowerCase().split("e");
    if (mantissa.length > 40 || Math.abs(Number(exponent ?? 0)) > 30) throw unreadable("this number is too long or too large");
    is("number", text, Number(text));
    return stop;
  };
  const power = () => {
    let stop = k + 1;
    while (all[stop] && all[stop].kind === "high" && !all[stop].apart) stop++;
    const digits = high(plain(all.slice(k, stop)));
    if (!/^-?[0-9]{1,9}$/.test(digits)) throw unreadable(`${all[k].text} has no meaning here`);
    is("power", digits, Number(digits));
    return stop;
  };
  const mark = (x) => {
    const {text} = x, name = commandOf(x);
    if (has(table.OPERATORS, text)) found.push({kind: "operator", text: table.OPERATORS[text], written: text, apart: x.apart});
    else if (has(table.BRACKETS, text)) is("open", text.at(-1));
    else if (closing.has(text)) is("close", text.at(-1));
    else if (has(table.KINDS_OF_SIGNS, text)) is(table.KINDS_OF_SIGNS[text], text);
    else if (has(table.VULGAR_FRACTIONS, text)) is("number", text, table.VULGAR_FRACTIONS[text].reduce((a, b) => a / b));
    else if (["row", "begin", "end"].includes(x.kind)) is(x.kind, text);
    else if (table.FRACTIONS.includes(text)) is("fraction", text);
    else if (table.FUNCTION_COMMANDS.includes(name) && isFunction(name)) is("function", name);
    else if (x.kind === "mark") throw unreadable("a dot without a letter under it");
    else throw unreadable(name ? `the command ${text.slice(0, 40)} is not known here` : `${text.slice(0, 1)} has no meaning here`);
  };
  while (k < all.length) {
    const x = all[k];
    if (beginsWord(x)) {
      const word = spell(all, k);
      for (const [j, name] of names(word).entries()) {
        if (/^[0-9]+$/.test(name)) is("number", name, Number(name));
        else is(isFunction(name) ? "function" : "name", name);
        if (j) found.at(-1).apart = false;
      }
      if (word.power !== null) is("power", String(word.power), word.power);
      k = word.at;
    } else if (x.kind === "digit" || x.text === ".") k = number();
    else if (x.kind === "high") k = power();
    else { mark(x); k++; }
  }
  return found;
}
