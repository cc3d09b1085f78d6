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
  if (line.own?.includes(found.q)) throw unreadable(`there is no ${name} that this line may use: it would be its own reason.`);
  return other && other.t ? {...found, t: other.t} : found;
}

// ---------------------------------------------------------------- states
const lookedUp = (x, y) => {
  const look = (slots) => typeof slots[0] === "string" ? FUNCTIONS[slots[0]](look(slots.slice(1)))
    : slots.map((k) => exact(k < 0 ? x[-k - 1] : y[k])).reduce(add, exact(0));
  return look;
};
let drawn = null;
const states = () => drawn ||= page.states.map(([set, ...values]) => {
  const x = Float64Array.from(values), y = new Float64Array(page.size);
  live(x, y);
  return {set, x, y};
});
// The entries of a tree that is to be equal to a line, and those of the line.
function entriesAt({x, y}, node, line) {
  const valuer = new Valuer(lookedUp(x, y)), size = line.vector || 1;
  const found = (line.vector && valuer.asTable(node, [size, 1])) || valuer.at(node), right = [...line.places].map((k) => y[k]);
  if (line.vector && !found.rows) throw unreadable(`${line.name} is a vector: write it as [${["x", "y", "z"].slice(0, size).join(", ")}].`);
  const yours = entriesOf(found);
  const padded = yours.length === 3 && size < 3 ? [[0, 0, right[0]], [...right, 0]][size - 1] : right;
  if (padded.length !== yours.length || (found.rows && !shapeOf(found).includes(1))) throw unreadable(`${line.name} has ${size} ${size > 1 ? "entries" : "entry"} here.`);
  return {yours, right: padded};
}
// Entry by entry whether it is right: everywhere, or where loops are closed and what nothing drives
// moves by itself; energies up to a constant.
function compared(node, line) {
  const found = states().map((state) => ({set: state.set, ...entriesAt(state, node, line)}));
  const some = found.filter(({set}) => set >= 0), any = found.filter(({set}) => set < 0);
  return found[0].yours.map((_, k) => {
    const isEqual = (all) => all.every(({set, yours, right}) => {
      const first = all.find((one) => one.set === set), level = line.level ? first.yours[k].v - first.right[k] : 0;
      return Math.abs(yours[k].v - right[k] - level) <= EQUAL * (yours[k].s + Math.abs(right[k]));
    });
    const largest = (all) => Math.max(...all.map(({right}) => Math.abs(right[k])));
    const saysNothing = any.length && !line.idle && largest(some) <= EQUAL * largest(any);
    return (any.length && isEqual(any)) || (!saysNothing && isEqual(some));
  });
}
// The thoughts under which the line would be what is typed, at the first state: of the first table
// that has any, one of a row.
function thoughtsOf(node, line, right) {
  const found = entriesAt(states()[0], node, line).yours.flatMap((own, k) => {
    if (right[k] || !line.thoughts || vanishes(own)) return [];
    const isIt = ([, value]) => Math.abs(value - own.v) <= ROUNDED * Math.abs(value) + EQUAL * own.s;
    const told = page.thoughts[line.thoughts[k]].map((rows, table) =>
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
    const notes = [];
    for (const node of claimed(text, line)) {
      const other = readings(node, line).find(([tree]) => isRight(tree, line));
      if (!isRight(node, line) && !other) {
        valuable(node);
        return [false, wrong(row, text, node)];
      }
      notes.push(isRight(node, line) ? "" : other[1]);
    }
    return [true, `Right: equal at ${page.states.length} random states.${notes.join("")}`];
  } catch (problem) {
    if (!problem.unreadable) throw problem;
    return [false, `${problem.undecided ? "Not decided here" : "Cannot be read"}: ${problem.message.replace(/[.]?$/, ".")}`];
  }
}
// Whether it is right as it is written; not where a name has no value here.
function isRight(node, line) {
  return !nodesOf(node).some((part) => part.isNowhere) && compared(node, line).every(Boolean);
}
function valuable(node) {
  const part = nodesOf(node).find((one) => one.isNowhere);
  if (part) throw undecided(`${part.text} has no value on this page: what is written with it`);
}
function wrong(row, text, node) {
  const {line} = row, said = thoughtsOf(node, line, compared(node, line));
  if (row.tries) {
    const [yours, right] = [entriesAt({x, y}, node, line).yours.map(({v}) => v), line.places.map((k) => y[k])].map((entries) =>
      told(entries.length > 1 ? entries : entries[0], 5));
    const differing = yours === right ? "as the line, but not with other values of the sliders" : `the line ${right}`;
    said.unshift(`here it is ${yours}, ${differing}.`);
  } else if (!said.length) said.push("look at it again; the next try shows numbers.");
  const typed = text.slice(text.indexOf("=") + 1).trim().replace(/'/g, "'\\''");
  if (line.diagnosed && !line.vector) said.push(`For the full diagnosis: freebody check ROBOT '${line.name} = ${typed}'${page.option}`);
  return `Not right: ${said.join(" ")}`;
}
