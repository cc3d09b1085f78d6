"""The text before a derivation's first step: the robot in words, the goal and a table of symbols;
and omission of repeated legs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from freebody.errors import listed
from freebody.expressions.nodes import Expression, Symbol, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.typesetting.literal import literal
from freebody.model.gravity import axis_of
from freebody.model.parameters import Parameter, each_parameter
from freebody.model.single_joints import is_taken_apart
from freebody_textbook.derivation import Meaning, Method, Step, Worked
from freebody_textbook.methods.glossary import glossary
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import following
from freebody_textbook.methods.step_reasons import ABSOLUTE, Efforts

_FEW_LEGS = 3
"""Legs up to which each has lines of its own."""


_Renaming = Mapping[str, str]


def overview(s: Setting, method: Method, worked: Worked) -> tuple[str, tuple[Meaning, ...]]:
    """(paragraphs on what is given and what is sought, symbols)."""
    forces = method.finds_torques
    gravity = _gravity(s) if forces else []
    axes = _axes(s) if forces or s.planar else ["Vectors have components in the world's axes."]
    robot = worked.robot or (_arm(s), *_composed(s), *_coupled(s, forces), *_loops(s))
    told = [
        *robot,
        *gravity,
        *(() if worked.robot else axes),
        *_load(s),
        *_numbers(s),
        worked.sought or _sought(s),
    ]
    given = "\n".join([*_about(s), " ".join(told)])
    return given, worked.table or glossary(s, worked.symbols, forces, worked.steps)


def _about(s: Setting) -> list[str]:
    about = s.symbols.model.about
    other = s.symbols.turned is not None or any(s.symbols.quarters)  # angles than it speaks of
    return [literal(s.letters.words(" ".join(about.split())))] if about and not other else []


FEW = 3
"""Joints up to which each is described by itself."""


def _arm(s: Setting) -> str:
    count = len(s.order)
    robot = "closed chain" if s.tree.loops else "arm"
    kind = f"A planar {robot}" if s.planar else f"A{'n' * (robot == 'arm')} {robot} in space"
    bodies = "one moving body" if count == 1 else f"{count} moving bodies"
    if count > FEW:
        return f"{kind} with {bodies}; the ground is body 0. {_rows(s)} {_kinds(s)}"
    return (
        f"{kind} with {bodies}: {'; '.join(_joint(s, i) for i in s.order)}. The ground is body 0."
    )


def _rows(s: Setting) -> str:
    """A sentence on which bodies the joints connect, by serial chains."""
    rows: dict[int, list[list[int]]] = {}
    row: list[int] = []
    for i in s.order:
        n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
        if parent != n - 1 or not row:
            row = []
            rows.setdefault(parent, []).append(row)
        row.append(n)
    if list(rows) == [0] and len(rows[0]) == 1:
        return "Joint i joins body i to body i-1."
    starts = [
        f"at {_body(parent)} ({listed([_span(row) for row in found])})"
        for parent, found in rows.items()
    ]
    return (
        f"The bodies form rows, which begin {listed(starts)}; joint i joins body i to the one "
        f"before it in its row."
    )


def _kinds(s: Setting) -> str:
    """A sentence on the joint types, and which joints have no motor."""
    by_words: dict[tuple[str, str], list[int]] = {}
    for i in s.leaders:
        by_words.setdefault((s.words(i).joint, s.words(i).coordinate), []).append(i)
    told = []
    for (joint, coordinate), joints in by_words.items():
        numbers, many = [s.numbers[i] for i in joints], len(joints) > 1
        letters = {_coordinate(s, i).partition("_")[0] for i in joints}
        own = [_coordinate(s, i) for i in joints]
        if many and all("_" in x for x in own) and len(letters) == 1:
            own = [f"{letters.pop()}_i"]
        told.append(
            f"{_joints(numbers)} {'are' if many else 'is'} {joint} ({coordinate}{'s' * many} "
            f"{', '.join(own)})"
        )
    told += [
        f"joint {s.numbers[i]} is {s.words(i).joint} ({_follows(s, i)})"
        for i in s.order
        if s.follows(i)
    ]
    passive = [s.numbers[i] for i in s.leaders if not s.driven(i)]
    if passive:
        told.append(f"{_joints(passive)} {'are' if len(passive) > 1 else 'is'} passive")
    sentence = "; ".join(told)
    return f"{sentence[0].upper()}{sentence[1:]}."


def _joints(numbers: list[int]) -> str:
    """Phrase for joint numbers: joints 1 to 3 and 5."""
    rows: list[list[int]] = []
    for n in numbers:
        if rows and rows[-1][-1] == n - 1:
            rows[-1].append(n)
        else:
            rows.append([n])
    spans = [x for row in rows for x in ([_span(row)] if len(row) > 2 else map(str, row))]
    return f"joint{'s' * (len(numbers) > 1)} {listed(spans)}"


def _span(row: list[int]) -> str:
    return str(row[0]) if len(row) == 1 else f"{row[0]} to {row[-1]}"


def _body(n: int) -> str:
    return "the ground" if n == 0 else f"body {n}"


def _joint(s: Setting, i: int) -> str:
    n, below = s.numbers[i], _body(s.numbers[s.tree.bodies[i].parent])
    how = f"{s.words(i).coordinate} {_coordinate(s, i)}"
    if s.follows(i):
        how = _follows(s, i)
    elif not s.driven(i):
        how += ", passive"
    return f"joint {n} ({s.words(i).joint}, {how}) joins body {n} to {below}"


def _follows(s: Setting, i: int) -> str:
    """Phrase for the coordinate of a joint that follows another, with the formula."""
    leader = s.naming.leader(s.numbers[i])
    return f"{s.words(i).coordinate} {_coordinate(s, i)}, follows joint {leader}"


def _coupled(s: Setting, forces: bool) -> list[str]:
    """Sentences on joints that follow others; forces: whether the method has forces."""
    what, told = "the rate" if s.at_rest else "the rate and the acceleration", []
    for i in s.coupled:
        every = "both" if len(s.together(i)) == 2 else "all of them"
        motor = f", and one motor moves {every}" if forces and s.driven(i) else ""
        told.append(f"{following(s, i, what)}{motor}.")
    if told and forces:
        told.append("What couples such joints, gears or a belt, does no work of its own.")
    other = next((i for i in s.leaders if s.index(i) + 1 != s.numbers[i]), None)
    if other is not None:
        place = s.index(other) + 1
        motor = f" and motor {place} belong" if forces else " belongs"
        told.append(
            f"Joints that follow others are not counted: coordinate {place}{motor} to joint "
            f"{s.numbers[other]}."
        )
    return told


def _coordinate(s: Setting, i: int) -> str:
    """Text of a joint's coordinate, θ_1, d_1 or the slide's own name; of a following joint by its
    leader's."""
    name, at = s.coordinate(i), s.tree.bodies[i].coordinates
    found = re.fullmatch(r"(theta|d)(\d+)", name)
    name = f"{'θ' if found[1] == 'theta' else 'd'}_{found[2]}" if found else name
    factor = {1.0: "", -1.0: "-"}.get(at.ratio, f"{at.ratio:.15g} ")
    offset = f" {'-' if at.offset < 0.0 else '+'} {abs(at.offset):.15g}" if at.offset else ""
    return f"{factor}{name}{offset}"


def _composed(s: Setting) -> list[str]:
    """Sentences on joints that were replaced by several single ones."""
    told, n = [], 0
    given = s.symbols.given
    for body in given.bodies if given else ():
        taken_apart = is_taken_apart(body, s.symbols.euler)
        first, n = n + 1, n + (body.kind.nv if taken_apart else 1)
        if taken_apart:
            one, links = n == first + 1, _joints(list(range(first, n))).removeprefix("joint")
            told.append(
                f"The {body.kind.name} joint {literal(body.joint.name)} is replaced by "
                f"{_joints(list(range(first, n + 1)))}; between them "
                f"{'is body' if one else 'are bodies'}{links.removeprefix('s')}, without mass."
            )
        if taken_apart and body.joint.passive and body.kind.frees(s.symbols.model.dim):
            borne = f": body {n} is supported by the loops alone" if s.tree.loops else ""
            told.append(f"These joints carry no load{borne}.")
        elif taken_apart and body.kind.frees(s.symbols.model.dim):
            told.append(
                "Nothing holds the body: the motors of these joints stand for the forces and "
                "torques along them that it needs from outside, such as thrusts."
            )
        if taken_apart and body.kind.quaternion is not None:
            told.append(
                f"θ_{n - 2}, θ_{n - 1} and θ_{n} are yaw, pitch and roll; the equations are "
                f"singular where the cosine of θ_{n - 1} vanishes."
            )
    return told


def _loops(s: Setting) -> list[str]:
    model = s.symbols.model
    if not model.loops:
        return []
    ends = {frame.name: frame.body for frame in model.frames}

    def end(frame: str) -> str:
        return (
            f"{literal(frame)} of {'the ground' if ends[frame] < 0 else f'body {ends[frame] + 1}'}"
        )

    rows = [
        f"{literal(loop.name)} ({loop.kind}) between {end(loop.frames[0])} and "
        f"{end(loop.frames[1])}"
        for loop in model.loops
    ]
    return [f"{'A loop closes' if len(rows) == 1 else 'Loops close'} it: {'; '.join(rows)}."]


def _gravity(s: Setting) -> list[str]:
    if not s.weighs:
        return ["There is no gravity."]
    model = s.symbols.model
    name = (
        "of magnitude g" if isinstance(model.gravity_size, Parameter) else "of the given magnitude"
    )
    axis = axis_of(model.gravity_direction)
    return [f"Gravity {name} acts {f'along {axis}' if axis else 'in a given direction'}."]


def _axes(s: Setting) -> list[str]:
    if s.planar:
        return _angles(s)
    return [
        "Each body has a frame of its own, fixed to it; its vectors are given by their components "
        "in that frame (the notes mark them with a prime)."
    ]


def _angles(s: Setting) -> list[str]:
    """A sentence on the directions from which a planar robot's angles are measured."""
    turning = [i for i in s.order if s.turns(i)]
    if not turning:
        return []
    zero = {"down": "downward vertical", "up": "upward vertical"}
    zero = zero.get(s.letters.notation.zero, "x axis")
    subject = "The angle is" if len(turning) == 1 else "Angles are"
    if not all(_begins_along(s, i) for i in turning):
        where = "; the drawing and the vectors show from which line"
    elif s.symbols.turned:
        where = f", those of the links themselves, all measured from the {zero}"
    elif all(s.tree.bodies[i].parent < 0 for i in turning):
        where = f", measured from the {zero}"
    else:
        where = f", each measured from the previous link, at the ground from the {zero}"
    forces = f" {ABSOLUTE}" if s.symbols.turned else ""
    return [f"{subject} positive anticlockwise{where}.{forces}"]


def _begins_along(s: Setting, i: int) -> bool:
    """Whether body i lies along the preceding link, or the x axis, when its angle is 0."""
    tree = s.tree
    turned = tree.bodies[i].R[0] != (1.0, 0.0)
    along = [tree.bodies[k].p for k in tree.children(i)]
    along += [part.c for part in tree.bodies[i].masses]
    return not turned and all(s.symbols.element(p[1]).is_zero for p in along)


def _numbers(s: Setting) -> list[str]:
    """A sentence on the units of numbers, if masses are values instead of symbols."""
    parts = (part for body in s.symbols.model.bodies for part in body.inertias)
    valued = any(not list(each_parameter(part.inertia.mass)) for part in parts)
    return ["Numbers without a unit are in SI units."] if valued else []


def _load(s: Setting) -> list[str]:
    axes = "" if s.planar else ", with components in the world's axes"
    return (
        [f"A force f acts on the {'robot' if s.tree.loops else 'arm'} at its tip P{axes}."]
        if s.load
        else []
    )


def _sought(s: Setting) -> str:
    efforts, free = Efforts.of(s), [s.numbers[i] for i in s.leaders if not s.driven(i)]
    condition = (
        f"{_joints(free)} {'has' if len(free) == 1 else 'have'} no motor, and the motion must "
        f"satisfy {'its equation' if len(free) == 1 else 'their equations'}"
    )
    if not efforts.count:
        return f"The equations of motion are sought: {condition}."
    if s.symbols.turned is not None:
        return "Given a motion, the torques and forces along the coordinates are sought."
    told = f"Given a motion of the joints, the {efforts.words} {efforts.verb} sought"
    return f"{told}; {condition}." if free else f"{told}."


# ---------------------------------------------------------------- legs that are alike
def without_repeated_legs(s: Setting, steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """The steps without lines that repeat the first leg's lines under the names of other legs;
    empty steps are dropped."""
    first, *others = _legs(s)
    if len(others) < _FEW_LEGS:
        return steps
    renamings = [_renaming(s, first, leg) for leg in others]
    known = {x for names in renamings for x in names}
    model = [
        (k, line)
        for k, step in enumerate(steps)
        for line in step.equations
        if known & set(_names(line))
    ]
    told: set[int] = set()
    found = []
    for step in steps:
        kept = []
        for line in step.equations:
            like = _model_of(line, model, renamings)
            if like is None:
                kept.append(line)
            else:
                told.add(like)
        found.append(replace(step, equations=tuple(kept)))
    reasons = _reasons_of_legs(s, first, others)
    return tuple(
        replace(new, reason=new.reason + next(reasons)) if k in told else new
        for k, (old, new) in enumerate(zip(steps, found, strict=True))
        if new.equations or not old.equations
    )


def _legs(s: Setting) -> list[list[int]]:
    """The largest set of chains from the ground with the same sequence of joints."""
    groups: dict[tuple[tuple[bool, bool], ...], list[list[int]]] = {(): [[]]}
    for root in s.tree.children(-1):
        leg = [root]
        while len(below := s.tree.children(leg[-1])) == 1:
            leg.append(below[0])
        if not below and not set(leg) & s.links:
            joints = tuple((s.turns(i), s.slides(i)) for i in leg)
            groups.setdefault(joints, []).append(leg)
    return max(groups.values(), key=len)


def _renaming(s: Setting, first: list[int], leg: list[int]) -> _Renaming:
    """Names of coordinates and rates of one leg, by those of the first leg."""
    return {
        s.coordinate(a) + dots: s.coordinate(b) + dots
        for a, b in zip(first, leg, strict=True)
        for dots in ("", RATE, SECOND)
    }


def _names(line: Expression) -> Iterator[str]:
    return (x.name for x in nodes(line) if isinstance(x, Symbol))


def _model_of(
    line: Expression, model: Iterable[tuple[int, Expression]], renamings: Iterable[_Renaming]
) -> int | None:
    """The step of the first leg's line that equals a given line up to the names of its leg; None if
    there is none."""
    own = set(_names(line))
    for names in renamings:
        if own & set(names.values()):
            for k, other in model:
                if _same(other, line, dict(names), {b: a for a, b in names.items()}):
                    return k
    return None


def _same(a: Any, b: Any, there: dict[str, str], back: dict[str, str]) -> bool:
    """Whether two expression trees are equal up to a one-to-one renaming."""
    if isinstance(a, Symbol) and isinstance(b, Symbol):
        look = [(x.letter, x.dots, x.high, x.bold) for x in (a, b)]
        given = there.setdefault(a.name, b.name) == b.name
        return look[0] == look[1] and given and back.setdefault(b.name, a.name) == a.name
    if type(a) is not type(b):
        return False
    if isinstance(a, tuple):
        return len(a) == len(b) and all(_same(x, y, there, back) for x, y in zip(a, b, strict=True))
    if isinstance(a, Expression):
        one, other = (tuple([getattr(x, name) for name in x.__match_args__]) for x in (a, b))
        return _same(one, other, there, back)
    return a == b


def _reasons_of_legs(s: Setting, first: list[int], others: list[list[int]]) -> Iterator[str]:
    def span(leg: list[int]) -> str:
        return f"{s.numbers[leg[0]]} to {s.numbers[leg[-1]]}"

    yield (
        f" The lines are those of the first leg, bodies {span(first)}; for bodies "
        f"{listed(list(map(span, others)))} they are the same, with other numbers."
    )
    while True:
        yield " The lines of the other legs are the same, with other numbers."
