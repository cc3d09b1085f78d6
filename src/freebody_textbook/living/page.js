// The page: sliders set x, the kernel computes y, drawing and numbers follow; lines are hidden until
// they are predicted.

const find = (id) => document.getElementById(id);
const x = Float64Array.from([...page.inputs.map((input) => input.value), ...page.others]), y = new Float64Array(page.size);

const valueOf = (places, y) => places.length > 1 ? places.map((k) => y[k]) : y[places[0]];
const told = (value, digits) => Array.isArray(value) ? `[${value.map((one) => significant(one, digits)).join(", ")}]` : significant(value, digits);

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
    output.title = Array.isArray(value) ? `[${value.join(", ")}]` : String(value);
  }
  if (!closed) return;
  drawArm(find("arm"), page.bodies, page.loop ? page.loop.rods : [], y);
  drawBodies(find("bodies"), page.bodies.filter((body) => body.alone), y);
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
    row.tries += 1;
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
  own.forEach((row) => Object.assign(row, {right: false, tries: 0}));
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
  view.predicts = on;  // numbers of forces and moments could be read off the drawing
  follow();
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
