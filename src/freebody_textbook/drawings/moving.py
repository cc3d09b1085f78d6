"""What a page that can be tried takes from the first figure of its derivation, so that its moving
drawing is that figure."""

from __future__ import annotations

import math
from collections.abc import Collection

import numpy as np

from freebody.arrays import Array
from freebody.expressions.expression import Expression, Symbol, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.figures.drawing import SAME, Drawing, Label
from freebody.figures.label_placement import RULE
from freebody.figures.names import is_letter
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot
from freebody.figures.text import bold, canonical, label, marked, runs
from freebody_textbook.derivation import Derivation
from freebody_textbook.living.page_figure import PageFigure
from freebody_textbook.methods.method import LOADS


def page_figure(
    derivation: Derivation, seen: Snapshot, drawing: Drawing, spoken: Collection[str]
) -> PageFigure:
    """A derivation's first figure, and the state that it shows; spoken: names of quantities in the
    equations, the only ones that are written."""
    written = {e.text for e in drawing.elements if isinstance(e, Label)}
    joints = {seen.names.point(seen.pose, body.number) for body in seen.pose.bodies}
    joints |= {seen.names.tip}
    rods = list(map(seen.names.rod, range(len(seen.model.loops))))
    view = drawing.view.towards or (1.0, 0.0, 0.0)
    return PageFigure(
        bodies=[_names(seen, body, written, spoken) for body in seen.pose.bodies],
        ends=[
            [end.name if end.child is None else end.child + 1 for end in body.ends]
            for body in seen.pose.bodies
        ],
        tip=seen.names.tip,
        points={x: x for x in seen.pose.frames if is_letter(x) and x in written - joints},
        rods=[x if canonical(x) in spoken else "" for x in rods],
        start=_start(derivation.plain or derivation, seen),
        view=(math.degrees(math.atan2(view[1], view[0])), math.degrees(math.asin(view[2]))),
        rule=RULE,
        formula=_formula,
        typeset=lambda formula: marked(runs(formula)),
    )


def _formula(name: Expression) -> str:
    """A name, in bold where it is a vector's."""
    vector = any(isinstance(x, Symbol) and x.bold for x in nodes(name))
    return bold(label(name)) if vector else label(name)


def _names(
    seen: Snapshot, body: BodyPlace, written: Collection[str], spoken: Collection[str]
) -> dict[str, str]:
    """What stands beside a body and its joint, by what it names."""
    names, n, plane = seen.names, body.number, seen.model.dim == 2
    lengths = {
        "lc": names.centre_length(body) if body.mass > 0 else "",
        "l": names.length(body, body.ends[0]) if body.ends else "",
        "ground": names.on_the_ground(body) if body.parent < 0 and not body.kind.slides else "",
    }
    same = bool(body.ends) and np.linalg.norm(body.ends[0].place - body.com) < SAME
    if same and lengths["lc"] == lengths["l"]:
        lengths["lc"] = ""
    found = {what: name for what, name in lengths.items() if canonical(name) in spoken}
    point = names.point(seen.pose, n)
    found["point"] = point if plane and point in written else ""
    centred = plane or names.naming.centre_length(n) is not None
    found["C"] = names.on("C", n) if centred and body.mass > 0 else ""
    found["q"] = names.coordinate(body) if plane or body.axis is not None else ""
    if not plane and body.axis is not None:
        found["z"] = names.axis(body) if canonical(names.axis(body)) in spoken else ""
    return {what: name for what, name in found.items() if name}


# ---------------------------------------------------------------- the state
def _start(derivation: Derivation, seen: Snapshot) -> dict[str, float]:
    """First values of the symbols: those for which the figure is drawn."""
    symbols, model = derivation.equations.symbols, seen.model
    found = {name: x for name, x in model.parameters.items() if x is not None}
    arrays = (("", seen.q), (RATE, seen.qd), (SECOND, seen.qdd))
    for ending, values in arrays:
        if len(values) == len(symbols.coordinates):
            own = _own(symbols, np.asarray(values), ending == "")
            found |= {x + ending: float(v) for x, v in zip(symbols.coordinates, own, strict=True)}
    if seen.wrenches is not None:
        found |= dict(zip(LOADS[model.dim], map(float, np.asarray(seen.wrenches)), strict=False))
    return found


def _own(symbols: Symbols, joints: Array, positions: bool) -> Array:
    """Values of the coordinates of the equations, from those of the joints."""
    turned, quarters = symbols.turned, symbols.quarters if positions else ()
    own = joints if turned is None else np.linalg.solve(np.array(turned, dtype=float), joints)
    return np.asarray(own - math.pi / 2 * np.array(quarters or 0.0), dtype=float)
