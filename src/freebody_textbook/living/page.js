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
  for (const row of valueRows) {
    const value = valueOf(row.line.places, y), output = row.element.querySelector("output");
    output.textContent = told(value);
    output.title = Array.isArray(value) ? `[${value.join(", ")}]` : String(value);
  }
  if (!closed) return;
  stage.pose(y);
  frame();
  stage.draw();
}

// The drawing, and the bodies alone, which are seen as the robot is.
const notes = new Notes(page.bodies, page.notes);
const stage = new Stage(find("arm-solids"), find("arm"), page.scene, page.frames.length / FRAME, (y, own) => page.frames.forEach((place, k) => { own[k] = y[place]; }),
  {least: WIDE, notes: (stage) => { notes.draw(stage); pushed(stage, page.bodies, y); alone.draw(y); }});
const alone = new FreeBodies(find("bodies-solids"), find("bodies"), page.scene, stage, page.bodies.filter((body) => body.alone));
// The box that is drawn, along the axes of the first view. It grows with what moves, so that the
// drawing stays where it is, and is made anew where it could be much larger; symbols are as large as
// it was at first.
const SMALL = 0.65;  // of the scale that is possible
let box = null;
function frame() {
  const {camera, canvas} = stage, {right, up, towards} = camera.axes(...page.scene.view), ways = [right, up, towards];
  const centres = page.bodies.filter(({heavy}) => heavy).map(({centre}) => inWorld(stage.frames, centre));
  const places = [...stage.solids.reach(stage.frames), ...centres], now = ways.map((way) => {
    const far = places.map((place) => dot(place, way));
    return [Math.min(...far), Math.max(...far)];
  });
  const both = box ? now.map(([low, high], k) => [Math.min(box[k][0], low), Math.max(box[k][1], high)]) : now;
  const ends = (box) => [0, 1].map((k) => box.reduce((sum, side, i) => plus(sum, ways[i], side[k]), [0, 0, 0]));
  const [scale, most] = [both, now].map((one) => camera.fitting(ends(one), canvas.width, canvas.height).scale), kept = box && scale > SMALL * most;
  if (!kept) stage.size = box ? length(now.map(([low, high]) => high - low)) : page.scene.size;
  box = kept ? both : now;
  camera.corners = ends(box);
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
  const own = valueRows.filter((row) => row.element.parentElement === values && row.line.name);
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
  alone.predicts = on;  // numbers of forces and moments could be read off the drawing
  follow();
}

// A slider may round its value in the last digit, so that all are read from the first.
function read() {
  page.inputs.forEach((input, k) => { if (!input.solved) x[k] = Number(find(`in${k}`).value); });
}
const valueRows = [...document.querySelectorAll(".value")].map((element) =>
  ({element, line: page.lines[Number(element.dataset.line)]}));
page.inputs.forEach((input, k) => {
  if (input.solved) return;
  find(`in${k}`).addEventListener("input", () => { read(); follow(); });
});
const slider = find("first");
if (slider) {
  alone.most = AT_ONCE;
  slider.addEventListener("input", () => { alone.first = Number(slider.value); alone.again(); });
}
find("again").addEventListener("click", () => {
  page.inputs.forEach((input, k) => {
    x[k] = input.value;
    if (!input.solved) find(`in${k}`).value = input.value;
  });
  box = null;
  for (const {sheet} of [stage, alone.surface]) sheet.last.clear();
  stage.camera.reset();
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
