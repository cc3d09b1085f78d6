// Answers: what names stand for, whether what is typed is equal to a line at states that the robot
// can be in, and of a wrong one what may have been thought.

const words = new Map([["t", {}], ["pi", {}]]);
for (const [spellings, meanings] of page.words) {
  for (const [figures, x] of Object.entries(meanings)) {
    for (const spelling of spellings) {
      const runs = figures.split(",");
      words.set(spelling.replace(/#/g, () => runs.shift()), {...x, isNowhere: !(x.s || x.t)});
    }
  }
}
const isFunction = (word) => has(page.functions, word);
// Names of vectors stand alone, but for those of the equations of motion, Mq̈.
function namesOf(word) {
  const isWhole = words.has(word.plain);
  const found = cutWord(word, (x) => words.has(x) && (isWhole || !words.get(x).apart), isFunction)
    || cutWord(word, (x) => page.glued.includes(x), () => false);
  if (!found && table.UNITS.includes(word.plain)) throw undecided("A unit");
  if (!found) throw unreadable(`there is no ${word.plain} that this line may use.`);
  return found;
}

// The tokens of the one equation that is typed, by its sides.
function sidesOf(text) {
  if (text.length > LONGEST) throw unreadable("the formula is too long.");
  const statements = [[[]]], lexemes = inOneSpelling(text);
  const isOf = (name) => lexemes.some((_, k) => namedPattern(name)(here)(lexemes, k, lexemes.length, {}) >= 0);
  if (isOf("at_rest") || isOf("condition")) throw undecided("What holds at a state or on a condition");
  let depth = 0;
  for (const token of tokensOf(lexemes, namesOf, isFunction)) {
    depth += {open: 1, begin: 1, close: -1, end: -1}[token.kind] || 0;
    if (depth > 0) statements.at(-1).at(-1).push(token);
    else if (["line", "row", "comma"].includes(token.kind)) statements.push([[]]);
    else if (token.kind === "equals") statements.at(-1).push([]);
    else if (token.kind !== "amp") statements.at(-1).at(-1).push(token);
  }
  const said = statements.filter((sides) => sides.length > 1 || sides[0].length);
  if (!said.length) throw unreadable("type what you expect on the right of the =.");
  if (said.flat().some((side) => !side.length)) throw unreadable("one side of this = is empty.");
  if (said.length > 1) throw undecided("More than one equation");
  return said[0];
}
const isOwn = (name, line) => line.own && words.get(name).q === line.own[0];
const isLine = (side, line) => side.length === 1 && side[0].kind === "name" && isOwn(side[0].text, line);

// What is said of a line, as trees.
function claimed(text, line) {
  const sides = sidesOf(text), left = sides.length > 1 ? sides.findIndex((side) => isLine(side, line)) : -1;
  if (sides.length > 1 && left < 0) {
    if (sides.flat().some((token) => token.kind === "name" && isOwn(token.text, line))) throw undecided(`What does not give ${line.name} alone`);
    throw unreadable(`this line gives ${line.name} alone: type what stands on its right.`);
  }
  const right = sides.filter((_, k) => k !== left);
  const bodies = line.bodies || (!line.vector && right.flat().some((token) => token.kind === "name" && words.get(token.text).bodies));
  return right.map((side) => new Reader(side, (name) => meaningOf(name, line, bodies)).side());
}
// In lines about bodies g is the gravitational acceleration too, and J that of the tip's position.
const OF_BODIES = {g: "gravity", J: "JP"};
function meaningOf(name, line, bodies) {
  const found = words.get(name), other = bodies && has(OF_BODIES, name) && words.get(OF_BODIES[name]);
  if (!found || !(found.s || found.t || found.isNowhere)) return undefined;
  if (isOwn(name, line)) throw unreadable(`there is no ${name} that this line may use: it would be its own reason.`);
  if (line.own?.includes(found.q)) throw undecided(`What says it by ${name}, which stands on this line too,`);
  return other && other.t ? {...found, t: other.t} : found;
}

// ---------------------------------------------------------------- states
const lookedUp = (x, y) => {
  const look = (slots) => typeof slots[0] === "string" ? FUNCTIONS[slots[0]](look(slots.slice(1)))
    : slots.map((k) => exact(k < 0 ? x[-k - 1] : y[k])).reduce(add, exact(0));
  return look;
};
let drawn = null;
function stateOf(values) {
  const x = Float64Array.from(values), y = new Float64Array(page.size);
  live(x, y);
  return {x, y};
}
const states = () => drawn ||= page.states.map(([set, energy, ...values]) => ({set, energy, ...stateOf(values)}));
// The entries of a tree that is to be equal to a line, and those of the line.
function entriesAt({x, y}, node, line, seconds) {
  const valuer = new Valuer(lookedUp(x, y), seconds), size = line.vector || 1;
  const found = (line.vector && valuer.asTable(node, [size, 1])) || valuer.at(node), right = [...line.places].map((k) => y[k]);
  if (line.vector && !found.rows) throw unreadable(`${line.name} is a vector: write it as [${["x", "y", "z"].slice(0, size).join(", ")}].`);
  const yours = entriesOf(found);
  const padded = yours.length === 3 && size < 3 ? [[0, 0, right[0]], [...right, 0]][size - 1] : right;
  if (padded.length !== yours.length || (found.rows && !shapeOf(found).includes(1))) throw unreadable(`${line.name} has ${size} ${size > 1 ? "entries" : "entry"} here.`);
  return {yours, right: padded};
}
// How many times larger than a line the terms of an answer may be, or rounding could hide a mistake.
const LARGEST = 1e5;
// Entry by entry at how many of which states it is equal, null where it is not right: everywhere, or
// where loops are closed and what nothing drives moves by itself, there on some branch of its
// functions, if the line is a posture; energies up to a plain number and an energy, told by the
// states in other units.
function compared(node, line) {
  const [found, ...others] = choices(node).map((seconds) => states().map((state) => ({...state, ...entriesAt(state, node, line, seconds)})));
  const some = found.filter(({set}) => set >= 0), any = found.filter(({set}) => set < 0);
  return found[0].yours.map((_, k) => {
    const gap = ({yours, right}) => yours[k].v - right[k];
    const levelOf = ({set, energy}, all) => {
      const own = all.filter((one) => one.set === set), [first] = own, other = own.find((one) => one.energy !== 1);
      return gap(first) + (other ? (gap(other) - gap(first)) * (energy - 1) / (other.energy - 1) : 0);
    };
    const isEqual = (one, all = found) => {
      const {yours, right} = one, level = line.level ? levelOf(one, all) : 0;
      return Math.abs(gap(one) - level) <= EQUAL * (yours[k].s + Math.abs(right[k]));
    };
    const isDrowned = found.every(({yours, right}) => right[k] && yours[k].s > LARGEST * Math.abs(right[k]));
    if (isDrowned) throw undecided("What is so much smaller than terms that cancel");
    const largest = (all) => Math.max(...all.map(({right}) => Math.abs(right[k])));
    const saysNothing = any.length && !line.idle && largest(some) <= EQUAL * largest(any);
    if (any.length && any.every((one) => isEqual(one))) return {at: found.length, of: found.length};
    const at = some.filter((one) => isEqual(one)).length;
    const isSomehow = (one) => isEqual(one) || (line.branches && others.some((all) => isEqual(all[found.indexOf(one)], all)));
    if (!at || saysNothing || !some.every(isSomehow)) return null;
    if (at < some.length && line.moves) throw undecided("A second value of a function in a line of rates");
    return {at, of: some.length};
  });
}
// Whether an answer may be in numbers, with the values of the robot's parameters, where the line has
// such: of one without any symbol that has a value, nearly.
const NEARLY = 0.3;
function isInNumbers(node, line) {
  const {values, given} = page.own, parts = nodesOf(node);
  if (!values) return false;
  const [here, other] = [1, 1.37].map((size) => stateOf(values.map((v, k) => given.includes(k) ? size * v : v)));
  if (line.places.every((k) => here.y[k] === other.y[k])) return false;
  const slots = parts.filter(({is}) => is === "name").flatMap(({s = [], t = []}) => [s, t].flat(3));
  const isMixed = slots.some((k) => k >= 0 || given.includes(-k - 1));
  if (isMixed && !parts.some(({is}) => is === "number")) return false;
  const {yours, right} = entriesAt(here, node, line);
  return yours.every(({v, s}, k) => Math.abs(v - right[k]) <= (isMixed ? EQUAL * s : NEARLY * Math.abs(v)));
}
// The thoughts under which the line would be what is typed, at the first state: of the first table
// that has any, one of a row.
function thoughtsOf(node, line, right) {
  if (nodesOf(node).some(({is}) => SECOND[is] || ["atan2", "abs"].includes(is))) return [];  // what functions tell
  const {yours} = entriesAt(states()[0], node, line), ahead = line.vector ? 0 : yours.length - 1;
  const found = yours.flatMap((own, k) => {
    const thoughts = page.thoughts[line.thoughts?.[k - ahead]];  // not of what a plane lacks
    if (right[k] || !thoughts || vanishes(own)) return [];
    const isIt = ([, value]) => Math.abs(value - own.v) <= ROUNDED * Math.abs(value) + EQUAL * own.s;
    const told = thoughts.map((rows, table) =>
      rows.flatMap((row) => row.filter(isIt).slice(0, 1)).slice(0, page.most[table]));
    return (told.find((rows) => rows.length) || []).map(([sentence]) => sentence);
  });
  return [...new Set(found)].map((k) => page.sentences[k]);
}
const ROUNDED = 1e-7;  // As these travel.

// Symbols that may be read in another way: an answer that is right in one of them is right.
function readings(node, line) {
  const rows = page.readings.filter(({terms}) => line.torque || !terms);
  return rows.flatMap(({numbers = {}, names = {}, terms, note}) => {
    const slotsOf = ({is, text}, parent) => !terms || ["sum", "negative"].includes(parent?.is) ? {number: numbers, name: names}[is]?.[text] : undefined;
    let first = null;
    const change = (part, parent) => {
      const s = slotsOf(part, parent);
      if (s) first ??= part.text;
      if (s) return {is: "name", text: part.text, parts: [], s};
      const rows = part.rows?.map((row) => row.map((x) => change(x, part)));
      return {...part, rows, parts: rows ? rows.flat() : part.parts.map((x) => change(x, part))};
    };
    const changed = change(node, null);
    return first === null ? [] : [[changed, ` ${note.replace("#", first)}`]];
  });
}

// What is said of an answer, and whether it is right. Numbers of the line are shown at the second try.
function judged(row, text) {
  const {line} = row;
  if (!text.trim()) return [false, "Type what you expect on the right of the =."];
  try {
    const notes = claimed(text, line).map((node) => {
      for (const [tree, note] of [[node, ""], ...readings(node, line)]) {
        const found = rightAt(tree, line);
        if (found) return `equal at ${found}.${note}`;
      }
      valuable(node);
      if (isInNumbers(node, line)) throw undecided("An answer in numbers");
      return node;
    });
    const node = notes.find((one) => one.is);
    return node ? [false, wrong(row, text, node)] : [true, `Right: ${[...new Set(notes)].join(" ")}`];
  } catch (problem) {
    if (!problem.unreadable) throw problem;
    return [false, `${problem.undecided ? "Not decided here" : "Cannot be read"}: ${problem.message.replace(/[.]?$/, ".")}`];
  }
}
// At which states it is right as it is written, in words; not where a name has no value here.
function rightAt(node, line) {
  if (nodesOf(node).some((part) => part.isNowhere)) return "";
  const found = compared(node, line);
  if (!found.every(Boolean)) return "";
  const {at, of} = found.reduce((a, b) => a.at < b.at ? a : b);
  return at === of ? `${of} random states` : `${at} of ${of} random states as it stands, at the others on another branch of its functions`;
}
function valuable(node) {
  const part = nodesOf(node).find((one) => one.isNowhere);
  if (part) throw undecided(`${part.text} has no value on this page: what is written with it`);
  const isNothing = (below) => states().every(({x, y}) => entriesOf(new Valuer(lookedUp(x, y)).at(below)).every(vanishes));
  for (const {is, parts, exponent} of nodesOf(node)) {
    if (is === "quotient" ? isNothing(parts[1]) : exponent < 0 && isNothing(parts[0])) throw unreadable("this divides by zero");
  }
}
function wrong(row, text, node) {
  const {line} = row, said = thoughtsOf(node, line, compared(node, line));
  if (row.tries) {
    const [yours, right] = [entriesAt({x, y}, node, line).yours.map(({v}) => v), line.places.map((k) => y[k])].map((entries) =>
      told(entries.length > 1 ? entries : entries[0], 5));
    const unit = row.element.querySelector("output").nextSibling?.textContent || "";
    const differing = yours === right ? "as the line, but not with other values of the sliders" : `the line ${right}${unit}`;
    said.unshift(`here it is ${yours}, ${differing}.`);
  } else if (!said.length) said.push("look at it again; the next try shows numbers.");
  const typed = text.slice(text.indexOf("=") + 1).trim().replace(/'/g, "'\\''");
  if (line.diagnosed && !line.vector) said.push(`For the full diagnosis: freebody check ROBOT '${line.name} = ${typed}'${page.option}`);
  return `Not right: ${said.join(" ")}`;
}
