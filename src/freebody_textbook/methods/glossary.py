"""The table of symbols in a derivation: parameters by their meaning in the model, then the symbols
that the method introduces."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Symbol, nodes
from freebody.expressions.naming import sym_of
from freebody.expressions.nodes import Words
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym, vec
from freebody.expressions.typesetting.literal import literal
from freebody.model.drives import NUMBERS
from freebody.model.joints import JointWords
from freebody.model.parameters import Parameter, Quantity, each_parameter
from freebody.model.placement import AxisRotation, Placement, Shift
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import joints_that

METER, KILOGRAM, NEWTON, MOMENT = "m", "kg", "N", "N m"
INERTIA, SPEED, ACCELERATION, JOULE = "kg m²", "m/s", "m/s²", "J"


def glossary(
    s: Setting, introduced: Iterable[Meaning], forces: bool, steps: Iterable[Step]
) -> tuple[Meaning, ...]:
    """The glossary: coordinates and motors, parameters, the method's symbols, and other symbols in
    the steps; forces: whether the method has any forces."""
    steps = list(steps)
    rows = [*_coordinates(s, forces), *_parameters(s, not forces), *introduced]
    rows = [*_occurring(s, rows, steps), *_further(s, rows, steps)]
    if s.load:
        rows.append(Meaning((vec("f"),), "force on the tip, by the surroundings", NEWTON))
    return tuple(rows)


def _occurring(s: Setting, rows: Iterable[Meaning], steps: Iterable[Step]) -> Iterator[Meaning]:
    """Glossary entries without parameters that occur in no equation, if all equations are printed
    in full."""
    seen = [x for step in steps for line in step.equations for x in nodes(line)]
    used = {x.name for x in seen if isinstance(x, Symbol)} | set(s.symbols.coordinates)
    unused = set(s.symbols.model.parameters) - used
    told = any(isinstance(x, Words) for x in seen)
    for row in rows:
        left = tuple(x for x in row.symbols if told or getattr(x, "name", "") not in unused)
        if left:
            yield replace(row, symbols=left)


def _coordinates(s: Setting, motors: bool) -> Iterator[Meaning]:
    joints_by_words: dict[JointWords, list[int]] = {}
    for i in s.leaders:
        joints_by_words.setdefault(s.words(i), []).append(i)
    for words in sorted(joints_by_words, key=lambda words: words.unit != "rad"):  # angles first
        joints = joints_by_words[words]
        names = [s.coordinate(i) for i in joints]
        plural = "s" if len(joints) > 1 else ""
        where = f"{words.coordinate}{plural} of the {words.joint} joint{plural}"
        absolute = s.symbols.turned is not None and words.unit == "rad"
        where = f"angle{plural} of the bod{'ies' if plural else 'y'}" if absolute else where
        yield Meaning(tuple(map(sym, names)), where, words.unit)
        if not s.at_rest:
            rates = tuple(sym(x + dots) for dots in (RATE, SECOND) for x in names)
            theirs = (
                "their velocities and accelerations" if plural else "its velocity and acceleration"
            )
            yield Meaning(rates, theirs, f"{words.unit}/s, {words.unit}/s²")
        driven = [i for i in joints if s.motor(i) != ex.ZERO]
        if motors and driven:
            yield _motors(s, driven, words, absolute)


def _motors(s: Setting, driven: list[int], words: JointWords, absolute: bool) -> Meaning:
    """Glossary entry of the motor torques or forces of joints of one type; absolute: they act along
    link angles."""
    plural = "s" if len(driven) > 1 else ""
    meaning = f"{words.effort}{plural} of the motor{plural}"
    if absolute:
        meaning = f"torque{plural} on the bod{'ies' if plural else 'y'}"
    return Meaning(tuple(map(s.motor, driven)), meaning, words.effort_unit)


def _parameters(s: Setting, moved: bool) -> Iterator[Meaning]:
    """Glossary entries of occurring parameters; moved: only lengths from joint to joint and to the
    tip."""
    used = set(s.symbols.ring.names)
    found: dict[tuple[str, str], dict[str, None]] = {}
    for parameter, words, unit in in_model(s, moved):
        if parameter.name in used:
            found.setdefault((parameter.name, unit), {})[words] = None
    alike: dict[tuple[str, str], list[str]] = {}
    for (name, unit), told in found.items():
        words = "; also ".join(filter(None, told)) or "length in the place of a joint or body"
        alike.setdefault((words, unit), []).append(name)
    for (words, unit), names in alike.items():
        for one, several in _PLURALS if len(names) > 1 else ():
            words = words.replace(one, several)
        yield Meaning(tuple(map(sym, names)), words, unit)
    gravity = s.layout.order.gravity
    if gravity and s.weighs and not moved:
        yield Meaning((sym(gravity),), "acceleration of gravity", ACCELERATION)


def _further(s: Setting, rows: Iterable[Meaning], steps: Iterable[Step]) -> Iterator[Meaning]:
    """Glossary entries of general symbols in the steps that have none yet."""
    told = {(x.name, x.bold) for row in rows for x in row.symbols if isinstance(x, Symbol)}
    lines = (line for step in steps for line in step.equations)
    used = {(x.name, x.bold) for line in lines for x in nodes(line) if isinstance(x, Symbol)} - told
    n = r"\d+"
    for pattern, symbol, words, unit in (
        (f"m{n}", sym_of("m_i"), "mass of body i", KILOGRAM),
        (
            f"I{n}",
            sym_of("I_i") if s.planar else vec("I_i"),
            "inertia of body i about its centre of mass" + ", a matrix" * (not s.planar),
            INERTIA,
        ),
        (f"z{n}", vec("z_i"), f"direction of a {joints_that(s, turn=True)} joint's axis", ""),
        (f"R{n}_{n}", _ROTATION, "turns components in the axes of body i to those of body k", ""),
    ):
        known = (symbol.name, symbol.bold) in told
        if not known and any(re.fullmatch(pattern, x) and bold == symbol.bold for x, bold in used):
            yield Meaning((symbol,), words, unit)


_ROTATION = Symbol("R_i,k", "R", ("i",), high="k")


_PLURALS = (("entry", "entries"), ("distance", "distances"), ("number by", "numbers by"))
_BY_WHICH = "number by which others are given"
_ROD = re.compile(r"l([0-9]+)")
"""The length of a body that no joint or tip ends, such as of a rod that slides."""


def in_model(s: Setting, moved: bool) -> Iterator[tuple[Parameter, str, str]]:
    """The model's parameters with meaning and unit; moved: without masses and centres of mass."""
    for i in s.order:
        yield from _of_joint(s, i)
        if not moved:
            yield from _of_body(s, i)
    yield from _of_loops(s)
    model = s.symbols.model
    if s.load or moved or (model.tip and (model.formulas or s.symbols.formulas)):
        frame = model.frame()
        yield from placed(frame.placement, f"from joint {s.numbers[s.tip]} to the tip")
    standing = {parameter.name for parameter in each_parameter(replace(model, formulas=()))}
    for parameter in each_parameter(model.formulas):
        if parameter.name not in standing:
            own = _ROD.fullmatch(parameter.name) if s.planar else None
            words, unit = (f"length of body {own[1]}", METER) if own else (_BY_WHICH, "")
            yield parameter, words, unit


def _of_loops(s: Setting) -> Iterator[tuple[Parameter, str, str]]:
    frames = {frame.name: frame for frame in s.symbols.model.frames}
    for loop in s.symbols.model.loops:
        for name in loop.frames:
            body = frames[name].body + 1
            start = f"joint {body}" if body else "the base's origin"
            yield from placed(frames[name].placement, f"from {start} to {literal(name)}")
        for parameter in each_parameter(loop.distance):
            yield parameter, f"length of the rod {literal(loop.name)}", METER


def _of_joint(s: Setting, i: int) -> Iterator[tuple[Parameter, str, str]]:
    n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    start = f"joint {parent}" if parent else "the base's origin"
    body = s.symbols.model.bodies[n - 1]
    yield from placed(body.joint.placement, f"from {start} to joint {n}")
    for number, value in zip(body.kind.numbers, body.joint.numbers, strict=True):
        for parameter in each_parameter(value):
            yield parameter, f"{number.what} of joint {n}", number.unit


def _of_body(s: Setting, i: int) -> Iterator[tuple[Parameter, str, str]]:
    n = s.numbers[i]
    body = s.symbols.model.bodies[n - 1]
    for part in body.inertias:
        for parameter in each_parameter(part.inertia.mass):
            yield parameter, f"mass of body {n}", KILOGRAM
        centre = f"distance from joint {n} to the centre of mass of body {n}"
        bare = all(isinstance(x, float) and x == 0.0 for x in part.inertia.com)
        yield from placed(part.placement, centre.removeprefix("distance ") if bare else "")
        for x in part.inertia.com:
            for parameter in each_parameter(x):
                yield parameter, centre if x is parameter else "", METER
        for parameter in each_parameter(part.inertia.tensor):
            yield parameter, _inertia(parameter, part.inertia.tensor, n), INERTIA
    for name, number in NUMBERS.items():
        unit = number.unit_of(s.turns(i))
        for parameter in each_parameter(getattr(body.joint.drive, name)):
            yield parameter, f"{number.words} of joint {n}", "" if unit == "1" else unit


def _inertia(parameter: Parameter, tensor: Sequence[Quantity], n: int) -> str:
    """Description of an inertia parameter; for diagonal entries the axis, unless its name shows
    it."""
    if len(tensor) == 1:
        return f"moment of inertia of body {n} about its centre of mass"
    entries = ("x", "", "", "y", "", "z")
    axes = [axis for axis, x in zip(entries, tensor, strict=True) if x == parameter]
    if axes and all(axes) and not re.search("[xyz]{2}$", parameter.name):
        plural = "axes" if len(axes) > 1 else "axis"
        return f"moment of inertia of body {n} about {plural} {listed(axes)} through its centre"
    return f"entry of the inertia matrix of body {n} about its centre of mass"


def placed(placement: Placement, words: str) -> Iterator[tuple[Parameter, str, str]]:
    """Lengths and angles of a constant pose: parameter, description and unit."""
    for step in placement.steps:
        turn = isinstance(step, AxisRotation)
        for x in step.by if isinstance(step, Shift) else (step.angle,) if turn else ():
            told = f"{'angle' if turn else 'distance'} {words}" if words else ""
            for parameter in each_parameter(x):
                yield parameter, told if x is parameter else "", "rad" if turn else METER


# ---------------------------------------------------------------- rows that several methods
# introduce
def vectors(s: Setting) -> Iterator[Meaning]:
    """Glossary entries of the vectors along the bodies, and of the joints' directions."""
    if s.load or any(map(s.tree.children, s.order)):
        yield from meanings(s, "s{n}")
    yield from meanings(s, "sc{n}")
    if not s.planar:
        turning = joints_that(s, turn=True)
        if turning:
            yield Meaning((sym("z_i", True),), f"direction of a {turning} joint's axis", "")
    sliding = joints_that(s, turn=False)
    if sliding:
        yield Meaning((sym("u_i", True),), f"direction of a {sliding} joint's slide", "")


def joint_moments(s: Setting) -> Iterator[Meaning]:
    """Glossary entries of moments in joints that are not only a motor's torque."""
    if not all(map(s.is_pin, s.order)):
        yield from meanings(s, "M{n}")


def loop_equations(s: Setting) -> Meaning:
    """Glossary entry of the loop equations Φ_k."""
    meaning = "a loop equation, zero where the loop is closed"
    return Meaning((sym("Phi_k"),), meaning, _loop_units(s, "m", "m²", "1"))


def multipliers(s: Setting) -> Meaning:
    """Glossary entry of the multipliers, components of the loops' forces."""
    meaning = "multiplier of loop equation k: the loop's constraint force"
    return Meaning((sym("lam_k"),), meaning, _loop_units(s, "N", "N/m", "N m"))


def _loop_units(s: Setting, point: str, rod: str, turn: str) -> str:
    """Units of the loop equations that occur: of points, of a rod's squared distance, of
    directions."""
    closures = [loop.closure for loop in s.tree.loops]
    occurring = {
        point: any(x.point or x.slides for x in closures),
        rod: any(x.distance for x in closures),
        turn: any(x.turns for x in closures),
    }
    return ", ".join(unit for unit, occurs in occurring.items() if occurs)
