// The page: sliders set x, the kernel computes y, drawing and numbers follow; answers are compared
// with the kernel at random states.

const STATES = 8, CLOSE = 1e-9;
const find = (id) => document.getElementById(id);
const x = Float64Array.from(page.inputs, (input) => input.value), y = new Float64Array(page.size);

// A number with so many digits, as `significant` of Python has it; in a title all of them stand.
// Loops are closed to 1e-12.
const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";
function significant(value, digits = 3) {
  if (!Number.isFinite(value)) return "no number";
  const [mantissa, power] = (Math.abs(value) < 1e-11 ? 0 : value).toExponential(digits - 1).split("e");
  const size = Number(power), signed = (text) => text.replace("-", "\u2212");
  if (Number(mantissa) === 0) return "0";
  if (size >= -3 && size < 5) return signed(value.toFixed(Math.max(digits - 1 - size, 0)));
  return signed(mantissa) + "·10" + (size < 0 ? "⁻" : "") + [...String(Math.abs(size))].map((digit) => RAISED[digit]).join("");
}
const valueOf = (places, y) => places.length > 1 ? places.map((k) => y[k]) : y[places[0]];
const told = (value, digits) => isVector(value) ? `[${value.map((one) => significant(one, digits)).join(", ")}]` : significant(value, digits);

const OPEN = "The loops cannot be closed here, or not in one way: no values; the drawing is the last that could.";
function follow() {
  const closed = !page.loop || close(x, y, page.loop);
  if (page.free) letGo(x, y, page.free);
  live(x, y);
  if (!closed) y.fill(NaN);
  find("open").textContent = closed ? "" : OPEN;
  page.inputs.forEach((input, k) => {
    const value = input.solved && !closed ? NaN : x[k], output = find(`out${k}`);
    output.textContent = significant(value);
    output.title = String(value);
  });
  for (const row of rows) {
    const value = valueOf(row.line.places, y), output = row.element.querySelector("output");
    output.textContent = told(value);
    output.title = isVector(value) ? `[${value.join(", ")}]` : String(value);
  }
  if (!closed) return;
  drawArm(find("arm"), page.bodies, page.loop ? page.loop.rods : [], y);
  drawBodies(find("bodies"), page.bodies.filter((body) => body.alone), y);
}

// Other spellings of a coordinate, an angular velocity and their derivatives: q1, qd1, dtheta1,
// theta1dot, w1, ...
const LETTERS = {theta: ["theta", "q", "th"], d: ["d", "q"], omega: ["omega", "w"]};
function spellings(name) {
  const parts = /^(theta|omega|d)(\d+)(_d{1,2})?$/.exec(name);
  if (!parts) return [];
  const [, letters, digits, ending] = parts, dots = ending ? ending.slice(1) : "";
  const dotted = ["", "dot", "ddot"][dots.length];
  return LETTERS[letters].flatMap((letter) => dots
    ? [`${letter}${digits}${ending}`, `${letter}${dots}${digits}`, `${dots}${letter}${digits}`, `${letter}${digits}${dotted}`, `${letter}${dotted}${digits}`]
    : [`${letter}${digits}`]);
}
// What words mean: the name of the quantity, and its value. Names without their underscores are
// read too, where only one is meant.
const known = new Map(), squeezed = (word) => word.replace(/_/g, ""), loose = new Map();
function know(word, name, value, vector) {
  if (!known.has(word)) known.set(word, {name, value: Object.assign(value, {vector})});
}
page.inputs.forEach((input, k) => know(input.name, input.name, (x) => x[k]));
for (const [name, places] of Object.entries(page.names)) {
  const vector = places.length > 1;
  know(name, name, (x, y) => valueOf(places, y), vector);
  const [, letters, dots] = /^(.*?)((?:_d{1,2})?)$/.exec(name);
  if (vector) ["x", "y", "z"].slice(0, places.length).forEach((axis, k) => know(letters + axis + dots, name, (x, y) => y[places[k]]));
}
for (const {name, value} of [...known.values()]) {
  for (const word of spellings(name)) know(word, name, (x, y) => value(x, y), value.vector);
}
for (const word of new Set([...Object.keys(page.called), ...known.keys()])) {
  const short = squeezed(word), found = known.get(Object.hasOwn(page.called, word) ? page.called[word] : word);
  loose.set(short, loose.has(short) && loose.get(short)?.name !== found?.name ? undefined : found);
}
const turns = page.inputs.filter((input) => input.turns).map((input) => input.name);

// c12, s12, and theta12: of the sum of the angles of those joints, if they all turn.
function wave(word) {
  const parts = /^([A-Za-z]+)_?([1-9]+)$/.exec(word);
  const names = parts ? [...parts[2]].map((digit) => `theta${digit}`) : [];
  const isWave = parts && Object.hasOwn(page.waves, parts[1]), isSum = parts && names.length > 1 && LETTERS.theta.includes(parts[1]);
  if (!(isWave || isSum) || !names.every((name) => turns.includes(name))) return undefined;
  const f = isWave ? Math[page.waves[parts[1]]] : (angle) => angle;
  return (x, y) => f(names.reduce((total, name) => total + known.get(name).value(x, y), 0));
}
// waves: whether s1 is a sine rather than a vector of that name.
function meaning(line, waves) {
  return (word) => {
    if (waves && wave(word)) return wave(word);
    const called = Object.hasOwn(page.called, word) ? page.called[word] : word;
    const found = known.get(called) || loose.get(squeezed(word));
    return found ? line.own.includes(found.name) ? undefined : found.value : wave(word);
  };
}

// States that are random, and the same at each try.
function* states() {
  let seed = 20191;
  const random = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return seed / 4294967296;
  };
  for (let k = 0; k < STATES; k++) {
    yield Float64Array.from(page.inputs, (input) => input.group === "p" ? 0.3 + 1.4 * random() : 4 * random() - 2);
  }
}

function isRight(answer, line) {
  const at = new Float64Array(page.size);
  return [...states()].every((state) => {
    live(state, at);
    const right = [valueOf(line.places, at)].flat(), given = [answer(state, at)].flat();
    const size = Math.max(...right.map(Math.abs), Number.MIN_VALUE);
    return given.length === right.length && right.every((value, k) => Math.abs(given[k] - value) <= CLOSE * size);
  });
}

// An answer as it is right, if one of its readings is, else as it can be read.
function reading(typed, line) {
  let found = null;
  for (const waves of [false, true]) {
    try {
      const answer = readFormula(typed, meaning(line, waves));
      const one = {answer, here: answer(x, y), right: isRight(answer, line)};
      if (one.right || !found || found.unreadable) found = one;
    } catch (problem) {
      if (!problem.unreadable) throw problem;
      found ||= problem;
    }
  }
  if (found.unreadable) throw found;
  return found;
}

// What is said of an answer, and whether it is right.
function judged(row, text) {
  const {line} = row, parts = text.split("="), typed = parts.at(-1);
  if (!typed.trim()) return [false, "Type what you expect on the right of the =."];
  try {
    if (parts.length > 2 || (parts.length > 1 && squeezed(plainly(parts[0])) !== squeezed(line.name))) {
      throw unreadable(`This line gives ${line.name} alone: type what stands on its right.`);
    }
    const {answer, here, right: isSame} = reading(typed, line);
    if (isSame) return [true, `Right: equal at ${STATES} random states.`];
    const command = `freebody check ROBOT '${line.name} = ${plainly(typed)}'${page.option}`;
    const diagnosis = line.diagnosed && !answer.vector ? ` For the full diagnosis: ${command}` : "";
    const [yours, right] = [here, valueOf(line.places, y)].map((value) => told(value, 5));
    const differing = yours === right ? "as the line, but not with other values of the sliders" : `the line ${right}`;
    return [false, `Not right: here it is ${yours}, ${differing}.${diagnosis}`];
  } catch (problem) {
    if (!problem.unreadable) throw problem;
    return [false, `Cannot be read: ${problem.message}`];
  }
}

// Predict first: a step is hidden until each line that can be asked for is right, or all are shown.
function element(tag, attributes, text) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}
function question(row, reveal) {
  const field = element("div", {class: "answer", "data-name": row.line.name}, "");
  const label = element("label", {}, "");
  const input = element("input", {type: "text", maxlength: LONGEST, spellcheck: "false", autocomplete: "off"}, "");
  if (row.line.vector) input.placeholder = row.line.vector === 3 ? "[x, y, z]" : "[x, y]";
  const button = element("button", {type: "button"}, "Check"), verdict = element("p", {role: "status"}, "");
  label.append(row.element.querySelector("math").cloneNode(true), " = ", input);
  const check = () => {
    const [right, words] = judged(row, input.value);
    verdict.textContent = words;
    field.classList.toggle("right", right);
    row.right = right;
    reveal();
  };
  button.addEventListener("click", check);
  input.addEventListener("keydown", (event) => { if (event.key === "Enter") check(); });
  field.append(label, " ", button, verdict);
  return field;
}
function hide(values) {
  const own = rows.filter((row) => row.element.parentElement === values && row.line.name);
  const step = values.parentElement, questions = element("div", {class: "questions"}, "");
  const show = element("button", {type: "button"}, "Show the lines");
  const open = () => step.classList.remove("hidden");
  own.forEach((row) => { row.right = false; });
  questions.append(...own.map((row) => question(row, () => { if (own.every((one) => one.right)) open(); })), show);
  if (!own.length) show.before(element("p", {}, "Write these lines on paper first; they cannot be typed here."));
  show.addEventListener("click", open);
  step.classList.add("hidden");
  values.before(questions);
}
function predict(on) {
  for (const old of document.querySelectorAll(".questions")) old.remove();
  for (const step of document.querySelectorAll(".hidden")) step.classList.remove("hidden");
  if (on) document.querySelectorAll(".values").forEach(hide);
}

// A slider may round its value in the last digit, so that all are read from the first.
function read() {
  page.inputs.forEach((input, k) => { if (!input.solved) x[k] = Number(find(`in${k}`).value); });
}
const rows = [...document.querySelectorAll(".value")].map((element) =>
  ({element, line: page.lines[Number(element.dataset.line)]}));
page.inputs.forEach((input, k) => {
  if (input.solved) return;
  find(`in${k}`).addEventListener("input", () => { read(); follow(); });
});
for (const [angle, unit] of [["turn", Math.PI / 180], ["tilt", Math.PI / 180], ["first", 1]]) {
  const slider = find(angle), set = () => { view[angle] = Number(slider.value) * unit; };
  if (!slider) continue;
  set();
  slider.addEventListener("input", () => { read(); set(); follow(); });
}
find("again").addEventListener("click", () => {
  page.inputs.forEach((input, k) => {
    x[k] = input.value;
    if (!input.solved) find(`in${k}`).value = input.value;
  });
  box = null;
  memory.arm.clear();
  memory.bodies.clear();
  read();
  follow();
});
const steps = [...find("try").parentElement.querySelectorAll("section > details")];
const folding = () => { find("fold").textContent = steps.some((step) => step.open) ? "Fold all steps" : "Unfold all steps"; };
find("fold").addEventListener("click", () => {
  const open = !steps.some((step) => step.open);
  for (const step of steps) step.open = open;
  folding();
});
folding();
find("predict").addEventListener("change", (event) => predict(event.target.checked));
find("try").hidden = false;
read();
follow();
