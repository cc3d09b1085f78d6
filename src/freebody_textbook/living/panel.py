"""HTML of an interactive page: the panel with drawings and sliders, values below the equations, and
units."""

from __future__ import annotations

import html
from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from typing import Any

from freebody.expressions.expression import ZERO, Equation, Expression, Symbol
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.naming import sym_of
from freebody.expressions.nodes import Negative, Sum, Vector
from freebody.expressions.notations.lettering import Lettering
from freebody.expressions.printed_names import sym
from freebody.expressions.typesetting.mathml import mathml
from freebody_textbook.derivation import Derivation, Step
from freebody_textbook.living.line_values import ValuedLine, body_of
from freebody_textbook.living.units_of_values import together
from freebody_textbook.methods.glossary import ACCELERATION, in_model, placed
from freebody_textbook.methods.setting import Setting
from freebody_textbook.relations.formula_values import rank

GROUPS = {
    "q": "Positions",
    "qd": "Rates",
    "qdd": "Accelerations",
    "lam": "Multipliers of the loops",
    "p": "Lengths, masses, forces",
}
MOST = 6
"""Bodies up to which all are drawn alone at once; of more so many as stand beside a slider."""
AT_ONCE = 4
_SEEN = {
    2: 'role="img" aria-label="The robot in the state of the sliders"',
    3: 'tabindex="0" role="application" aria-label="The robot in the state of the sliders: arrow '
    'keys turn the view, plus and minus change its size, 0 resets it" title="Drag to turn the '
    'view; + and − change its size, 0 resets it"',
}
"""Attributes of the drawing for readers of the screen, by dimension."""


def panel(
    inputs: list[dict[str, Any]],
    dim: int,
    alone: int,
    letters: Lettering,
    words: Mapping[str, str],
) -> str:
    """HTML of the drawings, grouped sliders and buttons; alone: number of free-body drawings.
    words: what symbols are that no table of the page explains."""
    groups = []
    for key, title in GROUPS.items():
        rows = [_slider(k, x, letters, words) for k, x in enumerate(inputs) if x["group"] == key]
        if rows:
            state = ' open=""' if key in ("q", "lam") else ""
            groups.append(f"<details{state}><summary>{title}</summary>{''.join(rows)}</details>")
    turned = ""
    if alone > MOST:
        turned = (
            '<p class="slider which"><label for="first">bodies alone</label><input id="first" '
            f'type="range" min="0" max="{alone - AT_ONCE}" value="0" step="1"/></p>'
        )
    moments = "; moments, with two heads, to another" if dim == 3 else ""
    return (
        '<aside class="try" id="try" hidden=""><h2>Try it</h2><div class="drawn">'
        f'<div class="stage view"><canvas id="arm-solids" {_SEEN[dim]}></canvas>'
        '<svg id="arm" class="fig" aria-hidden="true"></svg></div>'
        '<div class="stage"><canvas id="bodies-solids" role="img" aria-label="Its bodies, each '
        'alone, with the forces on them"></canvas>'
        '<svg id="bodies" class="fig" aria-hidden="true"></svg></div>'
        f'<p class="scale">Forces on all bodies are drawn to one scale{moments}. '
        "Values below the equations are in SI units and belong to this state.</p>"
        f'<p id="open" role="status"></p>{turned}</div><div>{"".join(groups)}'
        '<p><button id="again">Back to the first state</button> <button id="fold">Fold all steps'
        '</button></p><p><label><input type="checkbox" id="predict"/> Predict first: hide each '
        f"line until you have tried it</label> {_typed(inputs, dim, letters)}</p></div></aside>"
    )


def _typed(inputs: list[dict[str, Any]], dim: int, letters: Lettering) -> str:
    """Examples of typed names, the first symbol of each group."""
    first = {x["group"]: letters.symbol(sym_of(x["name"])).name for x in reversed(inputs)}
    names = ", ".join(f"<code>{html.escape(first[x])}</code>" for x in GROUPS if x in first)
    return f"(typed as {names}, vectors as <code>[x, y{', z' * (dim == 3)}]</code>; or in LaTeX)"


def _slider(k: int, x: dict[str, Any], letters: Lettering, words: Mapping[str, str]) -> str:
    unit = f" {html.escape(x['unit'])}" if x["unit"] else ""
    name, letter = html.escape(x["name"]), mathml(letters(sym(x["name"])), display=False)
    typed = html.escape(letters.symbol(sym_of(x["name"])).name)
    if x["solved"]:
        return (
            f'<p class="slider" data-of="{name}">{letter} = '
            f'<span><output id="out{k}"></output>{unit} ({x["solved"]})</span></p>'
        )
    title = f' title="{html.escape(words[x["name"]])}"' if x["name"] in words else ""
    return (
        f'<p class="slider" data-of="{name}"><label for="in{k}"{title}>{letter}</label>'
        f'<input id="in{k}" type="range" data-input="{name}" aria-label="{typed}" '
        f'min="{x["low"]!r}" max="{x["high"]!r}" step="any" value="{x["value"]!r}"/>'
        f'<span><output id="out{k}" for="in{k}"></output>{unit}</span></p>'
    )


def below(
    lines: Iterable[ValuedLine],
    letters: Lettering,
    unit_of: Callable[[ValuedLine], str],
    of_loops: Container[str],
) -> dict[Step, str]:
    """HTML of the values of each step's lines, with an input field for answers; of_loops: names of
    loop forces, which are in world axes."""
    rows: dict[Step, list[str]] = {}
    for k, line in enumerate(lines):
        left = letters(line.line.lhs)
        name = "" if line.in_world else getattr(left, "name", "")
        rows.setdefault(line.step, []).append(
            f'<p class="value" data-line="{k}" data-name="{html.escape(name)}">'
            f"{mathml(left, display=False)} = <output></output>"
            f" {html.escape(unit_of(line))}".rstrip()
            + f"{_axes(line, of_loops)}</p>"
        )
    return {step: f'<div class="values">{"".join(made)}</div>' for step, made in rows.items()}


def _axes(line: ValuedLine, of_loops: Container[str]) -> str:
    """Phrase for the axes in which a spatial vector is given."""
    if rank(line.value) != 1 or len(line.value) != 3:
        return ""
    if line.in_world or line.names[0] in of_loops:
        return " (in axes of the world)"
    body = body_of(line.names[0])
    return f" (in axes of body {body})" if body else ""


def is_velocity(name: str) -> bool:
    """Whether a name is a velocity component of a free body, or its rate."""
    own = atom(name)
    return own.letter in ("v", "omega") and own.index in (("x",), ("y",), ("z",)) and own.dots < 2


def units_of_symbols(derivation: Derivation) -> dict[str, str]:
    """Units of symbols by name, from the derivation's table, and of those that only drawings
    use."""
    symbols = derivation.equations.symbols
    found = {symbol.name: unit for symbol, unit in _told(derivation)}
    for name in symbols.extra:
        if is_velocity(name):
            own = atom(name)
            found[name] = ("rad/s" if own.letter == "omega" else "m/s") + "²" * own.dots
    if symbols.model.tip is not None:
        for parameter, _, unit in placed(symbols.model.frame().placement, ""):
            found.setdefault(parameter.name, unit)
    for parameter, _, unit in in_model(Setting(symbols), moved=False):
        found.setdefault(parameter.name, unit)
    gravity = derivation.equations.layout.order.gravity
    return {gravity: ACCELERATION} | found if gravity else found


def words_of_drawn(derivation: Derivation) -> dict[str, str]:
    """Descriptions of the lengths and angles that only drawings use, those of the tip, by name."""
    model, told = derivation.equations.symbols.model, {x.name for x, _ in _told(derivation)}
    if model.tip is None:
        return {}
    rows = placed(model.frame().placement, "from the last joint to the tip")
    return {x.name: words for x, words, _ in rows if words and x.name not in told}


def _told(derivation: Derivation) -> Iterator[tuple[Symbol, str]]:
    """Symbols in the glossary with their units; if several units are listed in order, each applies
    to as many symbols. Symbols with alternative units are left out."""
    for row in derivation.glossary:
        units = [unit if " or " not in unit else "" for unit in row.unit.split(", ")]
        each = max(1, len(row.symbols) // len(units))
        for k, symbol in enumerate(row.symbols):
            if isinstance(symbol, Symbol):
                yield symbol, units[min(k // each, len(units) - 1)]


class LineUnits:
    """Units of left sides, from the symbol that they start with or symbols with the same letter and
    similar indices; "" if the table gives none, or several."""

    def __init__(self, derivation: Derivation, known: Mapping[str, str]):
        self._known = known
        self._alike: dict[object, set[str]] = {}
        for symbol, unit in _told(derivation):
            near, (letter, _) = _keys(symbol)
            for key in (near, (letter, True)):
                self._alike.setdefault(key, set()).add(_still(unit, symbol.dots))

    def __call__(self, left: Expression) -> str:
        while isinstance(left, Sum | Negative):
            left = left.terms[0] if isinstance(left, Sum) else left.operand
        if not isinstance(left, Symbol):
            return ""
        if left.name in self._known:
            return self._known[left.name]
        alike = next((self._alike[key] for key in _keys(left) if key in self._alike), set())
        unit = next(iter(alike)) if len(alike) == 1 else ""
        return _per_second(unit, left.dots)

    def of_entries(self, line: Equation) -> str:
        """The units of a vector of symbols, such as q = [θ₁, d₂]."""
        vectors = (x.entries for x in line.sides if isinstance(x, Vector))
        entries = next(vectors, ())
        return together(None if x == ZERO else self(x) for x in entries)


def _keys(symbol: Symbol) -> Iterator[tuple[object, ...]]:
    """Lookup keys of a symbol, from specific to general: letter and kinds of indices; for totals
    and components the letter alone."""
    yield symbol.letter, symbol.high, ",".join(symbol.low).translate(_ANY_LINK)
    yield symbol.letter, not symbol.low or symbol.low[-1] in "xyz"


_ANY_LINK = str.maketrans(dict.fromkeys("0123456789ik", "#"))
_RATES = {"rad": "rad/s", "rad/s": "rad/s²", "m": "m/s", "m/s": "m/s²"}


def _per_second(unit: str, dots: int) -> str:
    for _ in range(dots):
        unit = _RATES.get(unit, "")
    return unit


def _still(unit: str, dots: int) -> str:
    back = {rate: unit for unit, rate in _RATES.items()}
    for _ in range(dots):
        unit = back.get(unit, "")
    return unit
