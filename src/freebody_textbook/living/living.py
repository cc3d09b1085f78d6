"""Interactive derivation pages: sliders for the equations' symbols, a drawing with free bodies,
values of all lines, and answers checked before a line is shown."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from freebody.expressions.expression import Symbol
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.naming import Naming
from freebody.expressions.notations.lettering import Lettering
from freebody.expressions.notations.notation import PRESETS
from freebody.expressions.polynomials.symbols import RATE, SECOND, names_by_body
from freebody.moving.renderer import renderer
from freebody.outputs.pages import joined, packed
from freebody_textbook.closed_chains.multiplier_equations import is_multiplier
from freebody_textbook.derivation import Derivation
from freebody_textbook.living.answers import PageAnswers
from freebody_textbook.living.body_quantities import (
    TracedSetting,
    TracedSymbols,
    body_quantities,
    shown,
)
from freebody_textbook.living.closed_chain import ClosedChain
from freebody_textbook.living.drawn_bodies import DrawnBodies, Labels, PageFigure
from freebody_textbook.living.free_motion import FreeFlight, FreeJoints
from freebody_textbook.living.line_values import LineValues, ValuedLine, line_values, traced_values
from freebody_textbook.living.page_frames import PageFrames
from freebody_textbook.living.page_program import PageProgram
from freebody_textbook.living.panel import (
    LineUnits,
    below,
    is_velocity,
    panel,
    units_of_symbols,
    words_of_drawn,
)
from freebody_textbook.living.units_of_values import UnitsOfValues
from freebody_textbook.methods import METHODS
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.setting import LOADS, Setting
from freebody_textbook.methods.whole_bodies import are_free
from freebody_textbook.relations.formula_values import rank, typical
from freebody_textbook.relations.quantities import Quantities, branches
from freebody_textbook.render.documents import LivingParts

MOST_JOINTS = 4
"""Joints up to which lines are evaluated as polynomials, which proves them; of robots with more
they are one after the other, as the recursion goes."""
MOST_BODIES = 30
"""Bodies up to which a page has numbers; of robots with more they would make it too large."""
_WIDEST: dict[str, float] = {"rad": math.pi, "rad/s": 5.0, "rad/s²": 20.0, "m/s": 3.0, "N": 100.0}
"""The end of a slider, by unit; of other units three times the value, at least 1."""

_EDGE = 48
"""Pixels around the drawing, for names."""
_FOLDER = "freebody_textbook.living"
SCRIPTS = (
    "grammar.js", "reader.js", "free_bodies.js", "closing.js", "answers.js", "page.js",
)  # fmt: skip
"""The script that a page runs, in its parts."""

Following = ClosedChain | FreeFlight | FreeJoints
"""The motion of a page that follows from what is set."""


def living(derivation: Derivation, figure: PageFigure) -> LivingParts | None:
    """The interactive parts of a derivation's page; None if they are not supported, as for closed
    chains whose drives do not determine the motion or with a sliding loop."""
    plain = derivation.plain or derivation
    symbols = plain.equations.symbols
    if not 0 < len(symbols.model.bodies) <= MOST_BODIES:
        return None
    flies = are_free(symbols.given or symbols.model)
    turned = symbols.turned or any(symbols.quarters)
    if (flies and symbols.is_rewritten) or (symbols.model.loops and turned):
        return None
    kernel = PageProgram(symbols.ring.names, plain.equations.layout.form)
    labels = Labels(figure)
    if flies:
        return _flying(derivation, kernel, labels)
    setting = _setting(plain, kernel)
    start = [figure.start[x] for x in symbols.coordinates] if symbols.model.loops else []
    closed = ClosedChain(setting, kernel, start) if symbols.model.loops else None
    if closed and not closed.is_served:
        return None
    found, drawn = _values(plain, setting, closed, kernel)
    naming = Naming(symbols.model, letters=derivation.lettering)
    bodies = DrawnBodies(kernel, drawn, naming, setting, closed, labels)
    following = closed or FreeJoints(plain, drawn)
    marks = {"tip": bodies.tip(), "points": bodies.points()}
    picture = MovingFigure(labels, bodies.frames, bodies.all(), marks)
    return _parts(derivation, kernel, found, picture, following)


def _flying(derivation: Derivation, kernel: PageProgram, labels: Labels) -> LivingParts | None:
    plain = derivation.plain or derivation
    symbols = TracedSymbols.of(plain.equations.symbols, kernel.inputs)
    flight = FreeFlight(TracedSetting(symbols))
    if not flight.is_served:
        return None
    found = traced_values(plain, flight.quantities(), kernel)
    if not flight.need(found.quantities):
        return None
    labels = replace(labels, figure=replace(labels.figure, start=flight.start()))
    frames = flight.frames(kernel)
    body = flight.body(kernel, frames, labels, derivation.lettering)
    picture = MovingFigure(labels, frames, [body], {"tip": body["joint"], "points": []})
    return _parts(derivation, kernel, found, picture, flight)


def _parts(
    derivation: Derivation,
    kernel: PageProgram,
    found: LineValues,
    picture: MovingFigure,
    following: Following,
) -> LivingParts:
    """The assembled parts of an interactive page."""
    plain, letters = derivation.plain or derivation, derivation.lettering
    spoken = dict.fromkeys(name for line in found.lines for name in line.names)
    spoken |= dict.fromkeys(shown(plain.equations.symbols.model, found.quantities))
    readable = {name: x for name in spoken if rank(x := found.quantities[name]) <= 1}
    by_formula: dict[str, Any] = dict(plain.equations.symbols.followed({}))  # lc1 = l1/2
    readable = by_formula | readable
    for value in (*(line.value for line in found.lines), *readable.values()):
        kernel.places(value)
    following.page(
        kernel, dict.fromkeys(following.names, 0)
    )  # first: it needs places in the kernel
    used = kernel.used | frozenset(following.names)
    drawn = picture.data
    answers = PageAnswers(derivation, kernel, readable, found.defined)
    page: dict[str, Any] = drawn | {
        "lines": [_line(kernel, found, line, letters, answers) for line in found.lines],
    }
    units = units_of_symbols(plain) | dict.fromkeys(LOADS[3], "N")
    if isinstance(following, ClosedChain):
        units |= following.units
    figure = picture.labels.figure
    inputs = _inputs(plain, used, following, figure.start, units)
    if following.names:
        indices = {x["name"]: k for k, x in enumerate(inputs)}
        page[following.key] = following.page(kernel, indices)
    page |= {"inputs": inputs, "size": kernel.size}
    page |= answers.page(inputs) | {"option": _option(letters)}
    own = dict(zip(plain.steps, derivation.steps, strict=True))
    unit_of = units_of_lines(plain, units)
    dim, alone = plain.equations.symbols.model.dim, sum(body["alone"] for body in picture.bodies)
    naming = Naming(plain.equations.symbols.model)
    loops = range(len(naming.model.loops))
    exerted = [*map(naming.loop_force, loops), *map(naming.loop_moment, loops)]
    told = below(found.lines, letters, unit_of, {x.name for x in exerted if isinstance(x, Symbol)})
    run = f"{kernel.source(answers.symbols(inputs))}\n{_script()}"
    data = json.dumps(page, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return LivingParts(
        panel(inputs, dim, alone, letters, words_of_drawn(plain)),
        {own[step]: rows for step, rows in told.items()},
        joined(_FOLDER, ["unpacked.js"])
        .replace("PAGE", packed(data))
        .replace("SCRIPT", packed(run)),
        run,
    )


def units_of_lines(derivation: Derivation, units: Mapping[str, str]) -> Callable[[ValuedLine], str]:
    """The unit of a line's value, by the name of its left side, the terms of the value, or the
    symbols that a vector holds."""
    by_name, by_value = LineUnits(derivation, units), UnitsOfValues(derivation.equations, units)
    return lambda x: by_name(x.line.lhs) or by_value(x.value) or by_name.of_entries(x.line)


@dataclass(frozen=True)
class MovingFigure:
    """The drawing of a page: its frames, the bodies as data, and the marked places: that of the
    tip, if any, and of further points."""

    labels: Labels
    frames: PageFrames
    bodies: Sequence[Mapping[str, Any]]
    marks: Mapping[str, Any]

    @property
    def data(self) -> dict[str, Any]:
        """The drawing as the script reads it."""
        figure, frames, marks = self.labels.figure, self.frames, self.marks
        tip = {"at": marks["tip"], "name": self.labels.number(figure.tip)} if marks["tip"] else None
        rods = [
            {"ends": [frames.carrier(loop).place().data, frames.origin(loop).place().data],
             "name": self.labels.number(name)}
            for loop, name in zip(figure.pose.loops, figure.rods, strict=True)
            if name
        ]  # fmt: skip
        notes = {"tip": tip, "points": marks["points"], "rods": rods}
        notes["loop"] = bool(figure.pose.loops)
        scene = figure.scene(frames, self.labels.texts).data | {"edge": _EDGE}
        return {
            "bodies": list(map(_said, self.bodies)), "notes": notes, "scene": scene,
            "frames": frames.data,
        }  # fmt: skip


def _setting(derivation: Derivation, kernel: PageProgram) -> Setting:
    """The derivation's setting over polynomials if these are short, otherwise over the scalars of
    the program."""
    symbols = derivation.equations.symbols
    load = LOADS[symbols.model.dim] if "fx" in symbols.extra else ()
    at_rest = METHODS[derivation.method].at_rest
    told = symbols.model.dim == 2 if symbols.model.loops else not branches(symbols.tree)
    if told and not symbols.is_rewritten and len(symbols.model.bodies) <= MOST_JOINTS:
        return Setting(symbols, load, at_rest)
    return TracedSetting(TracedSymbols.of(symbols, kernel.inputs), load, at_rest)


def _values(
    derivation: Derivation, setting: Setting, closed: ClosedChain | None, kernel: PageProgram
) -> tuple[LineValues, Mapping[str, Any]]:
    """Values of the derivation's lines, and the quantities to be drawn."""
    layout, ring = derivation.equations.layout, setting.symbols.ring
    traced = isinstance(setting, TracedSetting)
    if not (traced or closed):
        found = line_values(derivation)
        return found, found.quantities
    drawn = body_quantities(setting, closed.reactions if closed else SolvedReactions(setting))
    if setting.symbols.turned:  # τ is what turns a body, not what the motor at its joint gives
        names = [f"tau{setting.numbers[i]}" for i in sorted(setting.order, key=setting.index)]
        turning = setting.symbols.of_angles([drawn[name] for name in names])
        drawn |= dict(zip(names, turning, strict=True))
    named = {name: ring[name] for name in ring.names if rank(drawn[name]) == 0}
    told = drawn | named  # m3 in a line is the parameter, also where it is the mass of body 4
    if traced:
        return traced_values(derivation, told, kernel), drawn
    return line_values(derivation, Quantities(told, layout)), drawn


# ---------------------------------------------------------------- what the script is given
def _said(body: Mapping[str, Any]) -> dict[str, Any]:
    """The data of a body or line, without empty entries."""
    return {key: x for key, x in body.items() if x or (x == 0 and x is not False)}


def _line(
    kernel: PageProgram,
    found: LineValues,
    line: ValuedLine,
    letters: Lettering,
    answers: PageAnswers,
) -> dict[str, Any]:
    """The data of a line: places of its value in the output; if it can be asked for, its name and
    how answers are judged, which must not use the line's own names."""
    left = line.line.lhs
    own = [
        x.name
        for x in line.line.sides
        if isinstance(x, Symbol) and (x is left or x.name not in kernel.inputs)
    ]
    name = letters.symbol(left).name if isinstance(left, Symbol) and not line.in_world else ""
    asked = {"name": name, "diagnosed": is_diagnosed(line, found)} if name else {}
    asked |= answers.of_line(left.name, own) if name and isinstance(left, Symbol) else {}
    places = kernel.places(line.value)
    return _said({"places": places, "vector": len(places) if rank(line.value) else None, **asked})


def _option(letters: Lettering) -> str:
    """The command line option that selects a notation."""
    name = letters.notation.name
    told = f" --notation {name if name in PRESETS else f'{name}.toml'}"
    return told if name != PRESETS[0] else ""


def is_diagnosed(line: ValuedLine, found: LineValues) -> bool:
    """Whether `fb.check` knows the left side of a line by the same name: scalars of the model, and
    h."""
    name = getattr(line.line.lhs, "name", "")
    asked = name in found.known or (bool(found.known) and name == f"h{atom(name).figures}")
    return rank(line.value) == 0 and asked


def _inputs(
    derivation: Derivation,
    used: frozenset[str],
    following: Following,
    start: Mapping[str, float],
    units: Mapping[str, str],
) -> list[dict[str, Any]]:
    """Slider data of the used symbols: name, value, range, kind; start: initial values of some."""
    symbols = derivation.equations.symbols
    moving = [x + dots for dots in ("", RATE, SECOND) for x in symbols.coordinates]
    names = [x for x in dict.fromkeys((*moving, *symbols.ring.names)) if x in used]
    values = typical(names, derivation.equations.symbols.model.parameters)
    values |= {name: 0.0 for name in names if is_multiplier(name)} | dict(start)
    made = []
    for name in names:
        value, unit, force = values[name], units.get(name, ""), is_multiplier(name)
        top = _WIDEST.get("N" if force else unit) or max(1.0, 3.0 * abs(value))
        signed = force or unit in {*_WIDEST, "m/s²"} or name in symbols.coordinates
        low = min(value, -top if signed or value < 0.0 else 0.0)
        high = max(value, top)
        if symbols.model.loops and name in symbols.coordinates:  # it may have turned more than once
            low, high = value - top, value + top
        made.append(
            {"name": name, "value": value, "low": low, "high": high, "unit": unit}
            | {"group": _group(name, symbols.coordinates), "turns": name in _angles(derivation)}
            | {"solved": following.why if name in following.solved_names else ""}
        )
    return made


def _group(name: str, coordinates: Iterable[str]) -> str:
    if is_multiplier(name):
        return "lam"
    if is_velocity(name):
        return "qdd" if atom(name).dots else "qd"
    endings = (("q", ""), ("qd", RATE), ("qdd", SECOND))
    found = (key for key, ending in endings for x in coordinates if name == x + ending)
    return next(found, "p")


def _angles(derivation: Derivation) -> set[str]:
    model = derivation.equations.symbols.model
    pairs = zip(names_by_body(model), model.bodies, strict=True)
    return {name for names, body in pairs for name in names if body.kind.turns}


@cache
def _script() -> str:
    """The part of the script common to all pages."""
    drawing = renderer(notes=True)
    return f'(function () {{\n"use strict";\n{drawing}\n{joined(_FOLDER, SCRIPTS)}\n}})();\n'
