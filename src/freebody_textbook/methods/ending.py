"""Last steps of the methods for equations of motion: sorting the equations, explaining their terms,
and known limiting cases."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

from freebody.algorithms.rnea import rnea
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Conditioned, Words, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym, vec
from freebody.model.parameters import each_parameter
from freebody.scalars.generators import sign_of
from freebody.scalars.trig import Trig
from freebody.spatial import dot, sub
from freebody_textbook.derivation import Step
from freebody_textbook.equations.base_parameters import short_by_base
from freebody_textbook.equations.closed_form import in_terms, named
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import motorless
from freebody_textbook.methods.terms import term_meanings

_FEW = 4
"""Joints up to which base parameters are looked for."""


_BASE = (
    " In base parameters, the minimal set of combinations of masses (μ), first moments (κ) and "
    "inertias (J) that the motion depends on, they are short enough to read; the combinations are "
    "listed below."
)


_LOOPS = (
    " The bodies form a tree when {loops} cut; what the closing forces add is Φ_qᵀ λ, as in "
    "Lagrange's equations of the first kind, which are these."
)


def ending(s: Setting, through_loops: Sequence[Expression] = ()) -> list[Step]:
    """Steps for the closed form and what follows it; through_loops: see `_closed_form`."""
    closed = _closed_form(s, through_loops)
    return [closed, *term_meanings(s, closed), *_limits(s)]


def _closed_form(setting: Setting, through_loops: Sequence[Expression] = ()) -> Step:
    """Step: the torques sorted by accelerations, rates and gravity; with a load on the tip, torque
    and load together. through_loops: generalized forces of the loops by coordinate."""
    equations = setting.equations
    numbers = {"RR": tuple(f"3.{k}" for k in range(20, 29))}.get(setting.cited, ("3.28",))
    form = in_terms(setting.letters.notation.terms)
    groups = named(equations, equations.layout, form) if equations.is_short else None
    if groups is None and len(setting.order) <= _FEW:
        groups = short_by_base(equations, form)
    if groups is None:
        return Step("The closed form", _length_in_words(setting), (), numbers, result=True)
    reason = _sorted(setting) + ("" if equations.is_short else _BASE)
    if setting.cited == "RR":
        reason += (
            " (3.22) to (3.24) are misprinted in the notes; the equations here are the corrected "
            "ones."
        )
    if through_loops:
        one = len(setting.tree.loops) == 1
        reason += _LOOPS.format(loops="the loop is" if one else "the loops are")
        groups = [_with(groups[0], through_loops), *groups[1:]]
    if setting.load:
        reason += (
            " The load at the tip, at r_P, acts in addition to the motors: on the left its "
            "part is added to that of each motor."
        )
        groups = [_loaded(setting, groups[0]), *groups[1:]]
    lines = tuple(line for group in groups for line in group)
    return Step("The closed form", reason, lines, numbers, result=True)


def _with(torques: list[Equation], through_loops: Sequence[Expression]) -> list[Equation]:
    """Equations of torques with the loops' part added at the end of each."""
    return [
        eq(*line.sides[:-1], ex.add(line.sides[-1], more))
        for line, more in zip(torques, through_loops, strict=True)
    ]


def _loaded(setting: Setting, torques: list[Equation]) -> list[Equation]:
    """Equations with τ_i + f · ∂r_P/∂q_i in place of τ_i."""
    shares = [ex.dot(vec("f"), ex.partial(vec("r_P"), x)) for x in setting.symbols.coordinates]
    return [
        eq(ex.add(line.sides[0], share), *line.sides[1:])
        for line, share in zip(torques, shares, strict=True)
    ]


def _by(setting: Setting) -> str:
    """Phrase for the kinds of terms by which torques are sorted."""
    return listed(["accelerations", "products of rates", *(["gravity"] if setting.weighs else [])])


def _sorted(setting: Setting) -> str:
    equations = setting.equations
    form = setting.letters.notation.terms
    letters = ("H", "C", "velocity", "G", "bias")
    M, C, c, g, bias = (str(setting.letters(sym(x))) for x in letters)
    words = {"coefficients": "the velocity terms h", "vector": f"the velocity terms {c}",
             "matrix": f"the matrix {C} of velocity terms",
             "bias": f"the terms {bias} without accelerations"}  # fmt: skip
    moves, weighs = (any(not x.is_zero for x in row) for row in (equations.c, equations.g))
    found = [f"the mass matrix {M}"]
    found += [words[form]] if moves or (form == "bias" and weighs) else []
    found += [f"gravity {g}"] if weighs and form != "bias" else []
    return f"Sorting by {_by(setting)} gives {listed(found)}.{_undriven(setting)}"


def _undriven(setting: Setting) -> str:
    """A sentence on the equations of joints without motor; "" if every joint has one."""
    if setting.tree.loops or all(map(setting.driven, setting.order)):
        return ""
    return (
        f"{motorless(setting)} An equation with 0 on the left is a condition on the motion, which "
        "cannot be chosen freely: it gives one acceleration in terms of the others."
    )


def _length_in_words(setting: Setting) -> str:
    """A sentence on the number of terms in equations that are too long to print."""
    lines = "" if setting.planar else ", and the recursive method writes them line by line"
    return (
        f"Sorted by {_by(setting)}, the torques are exact but too long to print; fb.equations "
        f"gives them{lines}. ({setting.equations.length}.)"
    )


def _limits(s: Setting) -> list[Step]:
    """Steps for limiting cases of a planar serial chain, each proved by exact comparison with the
    equations of the simpler robot."""
    if not s.planar or s.tree.loops or s.load or s.symbols.turned or not _is_row(s):
        return []
    found = [*_one_turning(s), *_without_last(s)]
    if not found:
        return []
    reason = " ".join(words for words, _ in found)
    lines = tuple(line for _, some in found for line in some)
    title = "Two limits" if len(found) > 1 else "A limit"
    return [Step(title, reason, lines)]


def _is_row(s: Setting) -> bool:
    """Whether the robot is a serial chain of several bodies whose joints are independent."""
    parents = [s.tree.bodies[i].parent for i in s.order]
    return len(s.order) > 1 and parents == [-1, *s.order[:-1]] and all(map(s.is_alone, s.order))


def _readable(lines: Iterable[Equation]) -> bool:
    return not any(isinstance(x, Words) for line in lines for x in nodes(line))


# ---------------------------------------------------------------- a mass to zero
def _without_last(s: Setting) -> Iterator[tuple[str, list[Equation]]]:
    """Limiting case: with the last body's mass and inertia zero, the equations are those of the arm
    without it."""
    *inner, last = s.order
    names = _inertia_names(s, last)
    shorter = rnea(replace(s.tree, bodies=s.tree.bodies[:-1]), s.symbols.q, *s._rates)
    lines = []
    for i in inner if names else ():
        tau, alone = s.equations.tau[s.index(i)], s.symbols.element(shorter.tau[s.index(i)])
        if _dropped(tau, names) != alone:
            return
        lines.append(eq(s.motor(i), ex.add(s.show(alone), s.show_moved(tau - alone))))
    if not lines or not _readable(lines):
        return
    remaining = listed([f"body {s.numbers[i]}" for i in inner])
    what, it = ("mass and inertia", "them") if len(names) > 1 else ("mass", "it")
    yield (
        f"What body {s.numbers[last]} adds stands last, by its {what}: without {it} the rest "
        f"remains, the equation of the arm of {remaining} alone.",
        lines,
    )


def _inertia_names(s: Setting, last: int) -> list[str]:
    """Names of the last body's mass and moments of inertia in the torques; empty if one is a number
    or also belongs to other bodies."""
    model = s.symbols.model
    own, others = model.bodies[s.numbers[last] - 1], model.bodies[: s.numbers[last] - 1]
    found = dict.fromkeys(
        x.name
        for part in own.inertias
        for quantity in (part.inertia.mass, part.inertia.tensor)
        for x in each_parameter(quantity)
    )
    shared = {x.name for x in each_parameter(others)}
    used = {x for tau in s.equations.tau for powers, _ in tau.terms() for x in powers}
    return [] if shared & found.keys() else [x for x in found if x in used]


# ---------------------------------------------------------------- one joint turning
def _one_turning(s: Setting) -> Iterator[tuple[str, list[Equation]]]:
    """Limiting case: with all joints locked but the first turning one and later angles 0, the arm
    is a rigid pendulum about that joint."""
    pivot = next((i for i in s.order if s.turns(i) and not s.slides(i)), None)
    if pivot is None:
        return
    held = [i for i in s.order if i != pivot]
    straight = [i for i in held if s.turns(i) and s.numbers[i] > s.numbers[pivot]]
    at = _at_zero(s, held, straight)
    limit = at(s.equations.tau[s.index(pivot)])
    if limit != at(_swinging(s, pivot)):
        return
    zero = [s.coordinate(i) for i in straight]
    names = [*zero, *(s.coordinate(i) + dots for dots in (RATE, SECOND) for i in held)]
    line = eq(Conditioned((eq(*map(sym, names), ex.ZERO),), s.motor(pivot)), s.show(limit))
    if not _readable([line]):
        return
    n, others = s.numbers[pivot], [f"joint {s.numbers[i]}" for i in held]
    how = "held and the arm stretched" if straight and _is_straight(s, pivot, at) else "held"
    what = "a compound pendulum" if s.weighs else "one rigid body"
    yield (
        f"With {listed(others)} {how}, all that joint {n} carries is {what}: its moment of inertia "
        "about the joint is, body by body, that about the centre of mass and the mass times the "
        "square of the centre's distance.",
        [line],
    )


def _swinging(s: Setting, pivot: int) -> Trig:
    """The torque of a rigid body turning about a joint: moment of inertia times acceleration, minus
    the moment of its weights, plus the drive's friction and springs."""
    k, total = s.index(pivot), s.symbols.zero()
    _, origin = s.world[pivot]
    for i in s.order[s.order.index(pivot) :]:
        if i in s.weighted:
            arm, m = sub(s.centre_position(i), origin), s.mass(i)
            (weight,) = s.tree.space.moment(arm, s.gravity(i))
            total = total + (s.inertia(i) + m * dot(arm, arm)) * s.symbols.qdd[k] - m * weight
    return s.symbols.element(total) + s.equations.drives[k] + s.rotor_part(pivot)


def _at_zero(s: Setting, held: Iterable[int], straight: Iterable[int]) -> Callable[[Trig], Trig]:
    """Function that sets the rates of locked joints and some angles to 0 in a polynomial."""
    still = {s.coordinate(i) + dots for i in held for dots in (RATE, SECOND)}
    angles = {s.coordinate(i) for i in straight}
    gone = still | {f"sin_{x}" for x in angles} | set(map(sign_of, still))
    ones = {f"cos_{x}" for x in angles}

    def at(x: Trig) -> Trig:
        kept = (
            ({name: e for name, e in powers.items() if name not in ones}, c)
            for powers, c in _dropped(x, gone | angles).terms()
        )
        return s.symbols.ring.polynomial(kept)

    return at


def _is_straight(s: Setting, pivot: int, at: Callable[[Trig], Trig]) -> bool:
    """Whether a joint and the centres of mass beyond it are on one line."""
    _, origin = s.world[pivot]
    arms = [
        sub(s.centre_position(i), origin) for i in s.weighted if s.numbers[i] >= s.numbers[pivot]
    ]
    first, *others = arms
    moments = (s.tree.space.moment(first, arm)[0] for arm in others)
    return all(at(s.symbols.element(x)).is_zero for x in moments)


def _dropped(x: Trig, names: Iterable[str]) -> Trig:
    """A polynomial without the terms that contain one of the names."""
    gone = set(names)
    return x.ring.polynomial((powers, c) for powers, c in x.terms() if not gone & powers.keys())
