"""A page that can be tried: sliders for whatever the equations hold, a drawing with free bodies,
the values of all lines, and answers that are checked before a line is seen."""

from __future__ import annotations

import html
import json
import math
import re
from collections.abc import Iterable
from functools import cache
from importlib import resources
from typing import Any

from freebody.derivations.derivation import Derivation, Step
from freebody.derivations.derive import LOADS
from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.expression import Symbol
from freebody.derivations.expressions.printed_names import sym
from freebody.derivations.living.kernel import PageProgram
from freebody.derivations.living.line_values import LineValues, ValuedLine, line_values
from freebody.derivations.naming import Naming
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.derivations.polynomials.typical_values import typical
from freebody.derivations.relations.formula_values import rank
from freebody.derivations.relations.quantities import Quantities, branches
from freebody.derivations.render.living_parts import LivingParts
from freebody.derivations.render.mathml import mathml
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.spatial import times

MOST_JOINTS = 4
"""Of arms with more, the lines are too long to be evaluated in a page."""
_WIDEST: dict[str, float] = {"rad": math.pi, "rad/s": 5.0, "rad/s²": 20.0, "m/s": 3.0, "N": 100.0}
"""The end of a slider, by unit; of other units three times the value, at least 1."""

VIEWS = (("turn", -180, 180, -60), ("tilt", -10, 90, 20))
"""Of a robot in space: name, range and first value of the angles from which it is seen, degrees."""
_LOAD = dict(zip(LOADS[3], (20.0, -10.0, -10.0), strict=True))
"""The force on the tip at first, N."""


def living(derivation: Derivation) -> LivingParts | None:
    """The living parts of a derivation's page; None of a robot for which there are none: they are
    made for arms of few joints without branches and loops."""
    if not _served(derivation):
        return None
    found = line_values(derivation)
    kernel = PageProgram(found.quantities)
    naming = Naming(_model(derivation))
    tree = derivation.equations.symbols.tree
    page: dict[str, Any] = {"bodies": _bodies(kernel, found, naming, tree)}
    page["lines"] = [_line(kernel, found, line) for line in found.lines]
    spoken = dict.fromkeys(name for line in found.lines for name in line.names)
    readable = {name: x for name in spoken if rank(x := found.quantities[name]) <= 1}
    page["names"] = {name: kernel.places(x) for name, x in readable.items()}
    inputs = _inputs(derivation, kernel)
    page["inputs"] = inputs
    page["size"] = kernel.size
    script = _script().replace("PAGE", _json(page), 1)
    return LivingParts(
        _panel(inputs, _model(derivation).dim),
        _below(found.lines),
        f"{kernel.source([x['name'] for x in inputs])}\n{script}",
    )


def _model(derivation: Derivation) -> Model:
    """The robot with its values, where it has some."""
    symbols = derivation.equations.symbols
    return symbols.given or symbols.model


def _served(derivation: Derivation) -> bool:
    model = _model(derivation)
    single = all(body.kind.nv == 1 and body.joint.mimic is None for body in model.bodies)
    small = 0 < len(model.bodies) <= MOST_JOINTS
    return small and not model.loops and single and not branches(derivation.equations.symbols.tree)


# ---------------------------------------------------------------- what the script is given
def _bodies(
    kernel: PageProgram, found: LineValues, naming: Naming, tree: Tree
) -> list[dict[str, Any]]:
    """Places of what is drawn of each body, and the names of what acts on it."""
    count, made = len(naming.model.bodies), []
    for n in range(1, count + 1):
        drawn = _drawn(found.quantities, naming.model, n)
        if naming.model.dim == 3:
            drawn = _in_world(drawn, found.quantities[f"R{n}"], _joint_axis(tree, n))
        places = {name: kernel.places(x) for name, x in drawn.items()}
        slides = naming.body(n).kind.slides
        made.append(places | {"slides": slides, "called": _called(naming, n)})
    return made


def _drawn(values: Quantities, model: Model, n: int) -> dict[str, Any]:
    """Of a body its joint, its centre of mass, its far end, the force and the moment at its joint,
    its weight, and a load with the point where it acts."""
    tip = model.frame().body + 1 if model.tip is not None else 0
    end = f"r{n + 1}" if n < len(model.bodies) else "r" if n == tip else f"rc{n}"
    weight = tuple(values[f"m{n}"] * g for g in values["gravity"])
    drawn = {"joint": values[f"r{n}"], "centre": values[f"rc{n}"], "end": values[end]}
    drawn |= {"force": values[f"f{n - 1}{n}"], "weight": weight}
    drawn["moment"] = values[f"M{n}" if model.dim == 2 else f"n{n}"]
    if n == tip and "fx" in values:
        load = tuple(values[name] for name in LOADS[model.dim])
        drawn |= {"load": load, "tip": values["r"]}
    return drawn


def _in_world(drawn: dict[str, Any], turn: Any, axis: Any) -> dict[str, Any]:
    """What was in axes of the body turned into those of the world, and the joint's axis."""
    turned = {name: times(turn, drawn[name]) for name in ("force", "moment")}
    return drawn | turned | {"axis": times(turn, axis)}


def _joint_axis(tree: Tree, n: int) -> Any:
    """The axis of joint n in axes of its body."""
    return next(body.axis for body, k in zip(tree.bodies, tree.body_of, strict=True) if k == n - 1)


def _called(naming: Naming, n: int) -> dict[str, str]:
    """The names; at a pin without motor that of the moment that the state would need there."""
    moment = naming.joint_moment(n)
    if moment == ex.ZERO:
        moment = naming.moment(naming.parent(n), n)
    return {
        "force": str(naming.force(n - 1, n)),
        "moment": str(moment),
        "weight": f"{naming.mass(n)} g",
    }


def _line(kernel: PageProgram, found: LineValues, line: ValuedLine) -> dict[str, Any]:
    """Where its value is; what it is called, if it can be asked for; which of the names with a
    value an answer may not use: its own, or it would be its own reason."""
    left = line.line.lhs
    own = [side.name for side in line.line.sides if isinstance(side, Symbol)]
    name = left.name if isinstance(left, Symbol) and not line.in_world else ""
    asked = {"name": name, "own": own, "diagnosed": is_diagnosed(line, found)} if name else {}
    places = kernel.places(line.value)
    return {"places": places, "vector": len(places) if rank(line.value) else 0, **asked}


def is_diagnosed(line: ValuedLine, found: LineValues) -> bool:
    """Whether `fb.check` knows what a line begins with by the same name: scalars of the model, and
    h."""
    name = getattr(line.line.lhs, "name", "")
    return rank(line.value) == 0 and (name in found.known or bool(re.fullmatch(r"h\d*", name)))


def _inputs(derivation: Derivation, kernel: PageProgram) -> list[dict[str, Any]]:
    """The symbols that have a slider: name, value, range, kind."""
    symbols, units = derivation.equations.symbols, _units(derivation)
    names = [x for x in symbols.ring.names if x in kernel.used]
    values = typical(names, _model(derivation).parameters) | {
        name: value for name, value in _LOAD.items() if name in names
    }
    units |= dict.fromkeys(_LOAD, "N")
    made = []
    for name in names:
        value, unit = values[name], units.get(name, "")
        top = _WIDEST.get(unit) or max(1.0, 3.0 * abs(value))
        signed = value < 0.0 or unit in _WIDEST or unit == "m/s²" or name in symbols.coordinates
        low = min(value, -top if signed else 0.0)
        made.append(
            {"name": name, "value": value, "low": low, "high": max(value, top), "unit": unit}
            | {"group": _group(name, symbols.coordinates), "turns": name in _angles(derivation)}
        )
    return made


_GROUPS = {"q": "Positions", "qd": "Rates", "qdd": "Accelerations", "p": "Lengths, masses, forces"}


def _group(name: str, coordinates: Iterable[str]) -> str:
    endings = (("q", ""), ("qd", RATE), ("qdd", SECOND))
    found = (key for key, ending in endings for x in coordinates if name == x + ending)
    return next(found, "p")


def _angles(derivation: Derivation) -> set[str]:
    symbols = derivation.equations.symbols
    pairs = zip(symbols.coordinates, _model(derivation).bodies, strict=True)
    return {name for name, body in pairs if body.kind.turns}


def _units(derivation: Derivation) -> dict[str, str]:
    """Units of symbols by name, as the derivation's table tells them; of several units in a row
    each serves as many symbols."""
    found = {}
    for row in derivation.glossary:
        units = row.unit.split(", ")
        each = max(1, len(row.symbols) // len(units))
        for k, symbol in enumerate(row.symbols):
            if isinstance(symbol, Symbol):
                found[symbol.name] = units[min(k // each, len(units) - 1)]
    return found


def _json(page: dict[str, Any]) -> str:
    """Data inside a script element, which no name in it can end."""
    text = json.dumps(page, ensure_ascii=True, allow_nan=False, separators=(",", ":"))
    return text.replace("<", "\\u003c")


@cache
def _script() -> str:
    """The page's own script, the same of all pages but for the data."""
    folder = resources.files("freebody.derivations.living")
    names = ("formula.js", "placing.js", "drawing.js", "page.js")
    text = "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)
    return f'(function () {{\n"use strict";\n{text}}})();\n'


# ---------------------------------------------------------------- HTML
def _panel(inputs: list[dict[str, Any]], dim: int) -> str:
    groups = []
    for key, title in _GROUPS.items():
        rows = [_slider(k, x) for k, x in enumerate(inputs) if x["group"] == key]
        if rows:
            state = ' open=""' if key == "q" else ""
            groups.append(f"<details{state}><summary>{title}</summary>{''.join(rows)}</details>")
    turned = "".join(
        f'<p class="slider"><label for="{name}">{name} the view</label><input id="{name}" '
        f'type="range" min="{low}" max="{high}" value="{value}" step="1"></p>'
        for name, low, high, value in (VIEWS if dim == 3 else ())
    )
    moments = "; moments, with two heads, to another" if dim == 3 else ""
    return (
        '<aside class="try" id="try" hidden=""><h2>Try it</h2>'
        '<svg id="arm" class="fig" viewBox="0 0 360 250" role="img" '
        'aria-label="The arm in the state of the sliders"></svg>'
        '<svg id="bodies" class="fig" viewBox="0 0 360 190" role="img" '
        'aria-label="Its bodies, each alone, with the forces on them"></svg>'
        '<p class="scale">Forces on all bodies are drawn to one scale: this long is '
        f'<output id="scale"></output>{moments}. Values below the equations are in SI units and '
        f"belong to this state.</p>{turned}"
        f"{''.join(groups)}"
        '<p><button id="again">Back to the first state</button> <button id="fold">Fold all steps'
        '</button></p><p><label><input type="checkbox" id="predict"> Predict first: hide each '
        "line until you have tried it</label></p></aside>"
    )


def _slider(k: int, x: dict[str, Any]) -> str:
    unit = f" {html.escape(x['unit'])}" if x["unit"] else ""
    return (
        f'<p class="slider"><label for="in{k}">{mathml(sym(x["name"]), display=False)}</label>'
        f'<input id="in{k}" type="range" data-input="{html.escape(x["name"])}" '
        f'min="{x["low"]!r}" max="{x["high"]!r}" step="any" '
        f'value="{x["value"]!r}"><span><output id="out{k}" for="in{k}"></output>{unit}</span></p>'
    )


def _below(lines: Iterable[ValuedLine]) -> dict[Step, str]:
    """Of each step the values of its lines, and a place for answers."""
    rows: dict[Step, list[str]] = {}
    for k, line in enumerate(lines):
        left = line.line.lhs
        name = "" if line.in_world else getattr(left, "name", "")
        rows.setdefault(line.step, []).append(
            f'<p class="value" data-line="{k}" data-name="{html.escape(name)}">'
            f"{mathml(left, display=False)} = <output></output>"
            f"{' (in axes of the world)' if line.in_world else ''}</p>"
        )
    return {step: f'<div class="values">{"".join(made)}</div>' for step, made in rows.items()}
