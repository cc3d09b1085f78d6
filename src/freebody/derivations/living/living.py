"""A page that can be tried: sliders for whatever the equations hold, a drawing with free bodies,
the values of all lines, and answers that are checked before a line is seen."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Sequence
from functools import cache
from importlib import resources
from typing import Any

from freebody.derivations.closed_chains.first_kind import MULTIPLIER
from freebody.derivations.derivation import Derivation
from freebody.derivations.derive import LOADS
from freebody.derivations.expressions.expression import Symbol
from freebody.derivations.living.closed_chain import ClosedChain
from freebody.derivations.living.drawn_bodies import DrawnBodies
from freebody.derivations.living.free_joints import FreeJoints
from freebody.derivations.living.kernel import PageProgram
from freebody.derivations.living.line_values import LineValues, ValuedLine, line_values
from freebody.derivations.living.panel import below, panel
from freebody.derivations.naming import Naming
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.derivations.polynomials.typical_values import typical
from freebody.derivations.relations.formula_values import rank
from freebody.derivations.relations.quantities import branches
from freebody.derivations.render.living_parts import LivingParts
from freebody.model.model import Model

MOST_JOINTS = 4
"""Of arms with more, the lines are too long to be evaluated in a page."""
_WIDEST: dict[str, float] = {"rad": math.pi, "rad/s": 5.0, "rad/s²": 20.0, "m/s": 3.0, "N": 100.0}
"""The end of a slider, by unit; of other units three times the value, at least 1."""

_LOAD = dict(zip(LOADS[3], (20.0, -10.0, -10.0), strict=True))
"""The force on the tip at first, N."""


def living(derivation: Derivation, start: Sequence[float] = ()) -> LivingParts | None:
    """The living parts of a derivation's page; None of a robot for which there are none: they are
    made for open chains of few joints without branches, and for planar closed chains whose drives
    determine the motion.

    start: coordinates at which the loops of a closed chain are closed; it needs them.
    """
    if not _served(derivation):
        return None
    closed = ClosedChain(derivation) if _model(derivation).loops else None
    if closed and not (closed.is_served and len(start)):
        return None
    found = line_values(derivation, closed.quantities() if closed else None)
    kernel, naming = PageProgram(found.quantities), Naming(_model(derivation))
    tree = derivation.equations.symbols.tree
    page: dict[str, Any] = {
        "bodies": DrawnBodies(kernel, found.quantities, naming, tree, closed).all(),
        "lines": [_line(kernel, found, line) for line in found.lines],
    }
    spoken = dict.fromkeys(name for line in found.lines for name in line.names)
    readable = {name: x for name in spoken if rank(x := found.quantities[name]) <= 1}
    page["names"] = {name: kernel.places(x) for name, x in readable.items()}
    following = closed or FreeJoints(derivation, found.quantities)
    following.page(
        kernel, dict.fromkeys(following.names, 0)
    )  # first: it needs places in the kernel
    inputs = _inputs(derivation, kernel, following)
    if closed:
        coordinates = derivation.equations.symbols.coordinates
        for name, value in zip(coordinates, start, strict=True):
            next(x for x in inputs if x["name"] == name)["value"] = float(value)
    if following.names:
        indices = {x["name"]: k for k, x in enumerate(inputs)}
        page[following.key] = following.page(kernel, indices)
    page |= {"inputs": inputs, "size": kernel.size}
    script = _script().replace("PAGE", _json(page), 1)
    return LivingParts(
        panel(inputs, _model(derivation).dim),
        below(found.lines),
        f"{kernel.source([x['name'] for x in inputs])}\n{script}",
    )


def _model(derivation: Derivation) -> Model:
    """The robot with its values, where it has some."""
    symbols = derivation.equations.symbols
    return symbols.given or symbols.model


def _served(derivation: Derivation) -> bool:
    model = _model(derivation)
    single = all(body.kind.nv == 1 and body.joint.mimic is None for body in model.bodies)
    if not single or not 0 < len(model.bodies) <= MOST_JOINTS:
        return False
    if model.loops:
        return model.dim == 2 and not model.missing
    return not branches(derivation.equations.symbols.tree)


# ---------------------------------------------------------------- what the script is given
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
    asked = name in found.known or bool(found.known and re.fullmatch(r"h\d*", name))
    return rank(line.value) == 0 and asked


def _inputs(
    derivation: Derivation, kernel: PageProgram, following: ClosedChain | FreeJoints
) -> list[dict[str, Any]]:
    """The symbols that have a slider: name, value, range, kind."""
    symbols, units = derivation.equations.symbols, _units(derivation)
    used = kernel.used | frozenset(following.names)
    moving = [x + dots for dots in ("", RATE, SECOND) for x in symbols.coordinates]
    names = [x for x in dict.fromkeys((*moving, *symbols.ring.names)) if x in used]
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
            | {"solved": following.why if name in following.solved_names else ""}
        )
    return made


def _group(name: str, coordinates: Iterable[str]) -> str:
    if name.startswith(MULTIPLIER):
        return "lam"
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
    names = ("formula.js", "placing.js", "drawing.js", "closing.js", "page.js")
    text = "\n".join(folder.joinpath(name).read_text(encoding="utf-8") for name in names)
    return f'(function () {{\n"use strict";\n{text}}})();\n'
