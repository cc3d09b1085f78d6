"""The drawings of a living page, measured in the browser: which labels overlap, which are cut off,
and how long a drawing takes."""

from __future__ import annotations

from typing import Any

_MOVES = """
const [states, seed] = arguments;
let last = seed;
const random = () => {
  last = (Math.imul(last, 1664525) + 1013904223) >>> 0;
  return last / 4294967296;
};
const sliders = [...document.querySelectorAll('#try input[type=range]')].filter(
  e => e.max !== e.min);
const starts = sliders.map(e => e.valueAsNumber);
const move = () => {
  const share = random();
  sliders.forEach((slider, i) => {
    const [low, high] = [Number(slider.min), Number(slider.max)];
    const goal = low + random() * (high - low);
    slider.value = starts[i] + share * (goal - starts[i]);
  });
  sliders[0].dispatchEvent(new Event('input'));
};
"""
_MEASURE = (
    _MOVES
    + """
const found = {labels: 0, overlaps: 0, cut: 0, crossed: 0, examples: []};
for (let k = 0; k < states; k++) {
  if (k) move();
  for (const id of ['arm', 'bodies']) {
    const svg = document.getElementById(id), frame = svg.getBoundingClientRect();
    const texts = [...svg.querySelectorAll('text')];
    const boxes = texts.map(e => e.getBoundingClientRect());
    const tell = (what, ...which) => {
      if (found.examples.length < 12) {
        found.examples.push([k, id, what, ...which.map(i => texts[i].textContent)].join(' '));
      }
    };
    found.labels += texts.length;
    found.crossed += svg.querySelectorAll('text.f ~ .leader').length;
    boxes.forEach((a, i) => {
      const beyond = Math.max(frame.left - a.left, frame.top - a.top,
        a.right - frame.right, a.bottom - frame.bottom);
      if (!(beyond < 0.5)) { found.cut++; tell('cut', i); }
      boxes.slice(0, i).forEach((b, j) => {
        const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
        const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
        if (wide > 0.5 && high > 0.5) { found.overlaps++; tell('overlap', i, j); }
      });
    });
  }
}
document.getElementById('again').click();
return found;
"""
)
_DRAW = _MOVES + "for (let k = 0; k < states; k++) move();"


def measured(driver: Any, states: int, seed: int = 1) -> dict[str, Any]:
    """Labels of the drawings in an opened page, counted over its first state and random ones of
    its sliders, which reach from the first to all that they allow: pairs that overlap, labels
    beyond the drawing's edge, and leaders above labels."""
    found: dict[str, Any] = driver.execute_script(_MEASURE, states, seed)
    return found


def drawing_time(driver: Any, states: int, seed: int = 2) -> float:
    """Milliseconds that the page's thread computes for the drawings of a state, the mean over
    random ones."""
    return computed(driver, _DRAW, states, seed) / states


def computed(driver: Any, script: str, *arguments: Any) -> float:
    """Milliseconds of CPU time that the page's thread computes for a script, which nothing else on
    the machine makes longer."""

    def so_far() -> float:
        metrics = driver.execute_cdp_cmd("Performance.getMetrics", {})["metrics"]
        return next(1000 * x["value"] for x in metrics if x["name"] == "ThreadTime")

    driver.execute_cdp_cmd("Performance.enable", {})
    before = so_far()
    driver.execute_script(script, *arguments)
    return so_far() - before
