"""The shorter route of section 3.2: moments about a joint's pivot, of all that hangs on it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import sym, vec
from freebody.scalars.trig import Trig
from freebody.spatial import dot
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods.glossary import INERTIA, METER
from freebody_textbook.methods.setting import Setting


def about_pivots(s: Setting, drives: Mapping[int, Trig]) -> list[Step]:
    """One equation a joint, from the base outward; drives: what each joint's friction and the like
    takes."""
    if s.cited == "R":
        return [_fixed_axis(s, s.show(drives[s.order[0]]))]
    return [_carried(s, i, drives) for i in s.order]


def arms_of_pivots(s: Setting) -> Iterator[Meaning]:
    """The symbols that moments about pivots bring in."""
    if s.cited == "R":
        yield Meaning((sym("I_A"),), "moment of inertia about the pivot", INERTIA)
    elif any(s.turns(i) and s.tree.children(i) for i in s.order):
        words = "vector from joint i to the centre of mass of body k"
        yield Meaning((sym("r_i,ck", True),), words, METER)


def _fixed_axis(s: Setting, drive: Expression) -> Step:
    """A single body on a fixed pivot: its moment of inertia about it."""
    (i,) = s.order
    centre = s.centre_name(i)
    moments: list[Expression] = [s.motor(i), ex.neg_each(drive)]
    if s.weighs:
        moments.append(ex.cross(centre, s.mass_times(i, vec("g"))))
    if s.loaded(i):
        moments.append(ex.cross(s.tip_name(), vec("f")))
    length = dot(s.centre(i), s.centre(i))
    own = ex.ZERO if s.is_point(i) else "I1"
    about = ex.add(own, s.mass_times(i, s.show(length)))
    return Step(
        "Moments about the pivot",
        "The body turns about a fixed pivot, where the reaction f_0,1 has no moment: one equation "
        "gives the torque, with the moment of inertia about the pivot by the parallel-axis "
        "theorem. (The notes print (3.3) and (3.4) with the opposite sign of the weight.)",
        (eq("I_A", about), eq(ex.add(*moments), ex.mul("I_A", sym("omega1_d")))),
        ("1.19", "3.3", "3.4"),
        figure="free-body 1",
    )


def _carried(s: Setting, i: int, drives: Mapping[int, Trig]) -> Step:
    n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    held = f"f_{parent},{n}" + ("" if s.is_pin(i) else f" with the moment n_{parent},{n}")
    found = (
        f"the {s.words(i).effort}" if s.driven(i) else "an equation of motion: there is no motor"
    )
    line = eq(s.motor(i), ex.add(_balance(s, i), s.show(drives[i]))) if s.is_alone(i) else None
    if line is None:
        reaction = s.force_name(s.tree.bodies[i].parent, i)
        line = eq(s.along(i, s.joint_moment(i), reaction), _balance(s, i))
    lines = [*_arms(s, i), line]
    if not s.is_alone(i):
        reason = (
            f"Take all that joint {n} carries as one system: the reactions inside it cancel, and "
            f"one equation gives the part of the reaction {held} at the joint that does work."
        )
    elif s.turns(i):
        pivot = "the pivot" if s.planar else "its axis"
        none = f"has no moment about {pivot}, so that one moment equation gives {found}"
        if s.slides(i):
            none = (
                "does no work along the screw: the moments about its axis, and pitch times the "
                f"forces along it, give {found}"
            )
        reason = (
            f"Take all that joint {n} carries as one system: the reactions inside it cancel, and "
            f"the reaction {held} at the joint {none}."
        )
    else:
        reason = (
            f"Take all that joint {n} carries as one system: the reactions inside it cancel, and "
            f"of the reaction {held} at the joint {'only the motor' if s.driven(i) else 'nothing'} "
            f"acts along the slide, so that one force equation gives {found}."
        )
    return Step(f"All that joint {n} carries", reason, tuple(lines), figure=f"carried {n}")


def _arms(s: Setting, i: int) -> list[Equation]:
    """From the pivot to the centres of mass beyond the next joint."""
    if not s.turns(i):
        return []
    lines = [eq(_arm(s, i, k), _way(s, i, k, s.centre_name(k))) for k in _subtree(s, i) if k != i]
    if _loaded(s, i) and not s.loaded(i):
        lines.append(eq(_tip_arm(s, i), _way(s, i, s.tip, s.tip_name())))
    return lines


def _arm(s: Setting, i: int, k: int) -> Expression:
    a, b = s.numbers[i], s.numbers[k]
    return (
        s.centre_name(i) if k == i else ex.Symbol(f"r{a}_c{b}", "r", (str(a), f"c{b}"), bold=True)
    )


def _tip_arm(s: Setting, i: int) -> Expression:
    n = str(s.numbers[i])
    return s.tip_name() if s.loaded(i) else ex.Symbol(f"r{n}_P", "r", (n, "P"), bold=True)


def _way(s: Setting, i: int, k: int, last: Expression) -> Expression:
    """Sum of the vectors from joint i to a point of body k."""
    path = [last]
    while k != i:
        parent = s.tree.bodies[k].parent
        path.append(s.reach_name(parent, k))
        k = parent
    return ex.add(*reversed(path))


def _balance(s: Setting, i: int) -> Expression:
    """Σ over all that hangs on joint i."""
    moments, forces = [], []
    for k in _subtree(s, i):
        moments += [s.spin_terms(k), ex.cross(_arm(s, i, k), s.needed(k))]
        forces.append(s.needed(k))
    if _loaded(s, i):
        moments.append(ex.neg(ex.cross(_tip_arm(s, i), vec("f"))))
        forces.append(ex.neg(vec("f")))
    return s.along(i, ex.add(*moments), ex.add(*forces))


def _loaded(s: Setting, i: int) -> bool:
    return bool(s.load) and s.tip in _subtree(s, i)


def _subtree(s: Setting, i: int) -> list[int]:
    """Body i and all that hangs on it."""
    return [i, *(k for child in s.tree.children(i) for k in _subtree(s, child))]
