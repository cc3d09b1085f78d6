"""The last step of every method: the equations of motion, sorted as (3.20)-(3.28)."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import sym, vec
from freebody_textbook.derivation import Step
from freebody_textbook.equations.base_parameters import short_by_base
from freebody_textbook.equations.equation_views import in_terms, named
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import motorless

FEW = 4
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


def closed_form(setting: Setting, through_loops: Sequence[Expression] = ()) -> Step:
    """Torques sorted by accelerations, rates and gravity; with a load on the tip, torque and load
    together; through_loops: of a closed chain what its loops add, by coordinate."""
    equations = setting.equations
    numbers = {"RR": tuple(f"3.{k}" for k in range(20, 29))}.get(setting.cited, ("3.28",))
    form = in_terms(setting.letters.notation.terms)
    groups = named(equations, equations.layout, form) if equations.is_short else None
    if groups is None and len(setting.order) <= FEW:
        groups = short_by_base(equations, form)
    if groups is None:
        return Step("The closed form", _told(setting), (), numbers, result=True)
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
    """What the loops add at the end of each torque."""
    return [
        eq(*line.sides[:-1], ex.add(line.sides[-1], more))
        for line, more in zip(torques, through_loops, strict=True)
    ]


def _loaded(setting: Setting, torques: list[Equation]) -> list[Equation]:
    """τ_i + f · ∂r_P/∂q_i in place of τ_i."""
    shares = [ex.dot(vec("f"), ex.partial(vec("r_P"), x)) for x in setting.symbols.coordinates]
    return [
        eq(ex.add(line.sides[0], share), *line.sides[1:])
        for line, share in zip(torques, shares, strict=True)
    ]


def _by(setting: Setting) -> str:
    """What torques are sorted by."""
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
    """What the equations of joints without motor are."""
    if setting.tree.loops or all(map(setting.driven, setting.order)):
        return ""
    return (
        f"{motorless(setting)} An equation with 0 on the left is a condition on the motion, which "
        "cannot be chosen freely: it gives one acceleration in terms of the others."
    )


def _told(setting: Setting) -> str:
    """How long equations are that nobody reads."""
    lines = "" if setting.planar else ", and the recursive method writes them line by line"
    return (
        f"Sorted by {_by(setting)}, the torques are exact but too long to print; fb.equations "
        f"gives them{lines}. ({setting.equations.length}.)"
    )
