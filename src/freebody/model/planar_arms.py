"""Planar arms from a word over R and P, with the notes' names and geometry.

Frame i is fixed to link i at joint i, x along the link; the next joint sits at x = l_i, the centre
of mass at x = lc_i. R turns by θ_i. P slides by d_i along its own x.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from freebody.errors import ModelError, UnknownNameError, shown
from freebody.labels import refuse_labelled
from freebody.model.build import Policy, build_model
from freebody.model.description import (
    MOST_LINKS,
    Drive,
    Joint,
    Limits,
    Link,
    Mount,
    RobotDescription,
)
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia
from freebody.model.joints import BY_LETTER
from freebody.model.model import Model
from freebody.model.parameters import Parameter, Quantity, finite, quantity
from freebody.model.placement import shift, turn

GivenNumber = float | str | Parameter | None


def planar(
    word: str,
    *,
    l: Sequence[GivenNumber] | None = None,
    lc: Sequence[GivenNumber] | None = None,
    m: Sequence[GivenNumber] | None = None,
    I: Sequence[GivenNumber] | None = None,
    g: float | str | Sequence[float] = 9.81,
    angles: Sequence[float] | None = None,
    limits: Sequence[tuple[float, float] | Limits | None] | None = None,
    drives: Sequence[Drive | None] | None = None,
    passive: Sequence[str] = (),
    name: str | None = None,
    physical: Policy = "refuse",
) -> Model:
    """A planar serial arm: planar("RR") is the notes' 2R, planar("PR") a cart with a pendulum.

    Parameters
    ----------
    word
        Letters R and P from the base outward.
    l, lc, m, I
        Length and distance of the centre of mass (m), mass (kg) and inertia about the centre of
        mass (kg m²): one entry per link, a number, a name or None. Without them parameters l1, lc1,
        m1, I1, … that have no value yet (a P link has l = 0 unless given).
    g
        Gravity along -y (m/s²), a name, or a vector.
    angles
        Constant rotation of each joint's frame relative to the previous frame (rad); default 0 for
        R, 0 for P after an R or at the base, +π/2 for P after a P.
    limits
        (lower, upper) or Limits a joint.
    drives
        Friction, rotors and springs a joint.
    passive
        Names of the joints that nothing drives, such as ["joint2"] of a cart with a pendulum.
    name
        The model's name; default: the word.
    physical
        "warn" about, "refuse" or "ignore" numbers that no rigid body or motor has.

    Raises
    ------
    ModelError
        A word of other letters, numbers too few or too many, or such as no robot has.
    """
    description = describe(
        word,
        l=l,
        lc=lc,
        m=m,
        I=I,
        g=g,
        angles=angles,
        limits=limits,
        drives=drives,
        passive=passive,
        name=name,
    )
    return build_model(description, physical=physical)


def describe(
    word: str,
    *,
    l: Sequence[GivenNumber] | None = None,
    lc: Sequence[GivenNumber] | None = None,
    m: Sequence[GivenNumber] | None = None,
    I: Sequence[GivenNumber] | None = None,
    g: float | str | Parameter | Sequence[float] = 9.81,
    angles: Sequence[float] | None = None,
    limits: Sequence[tuple[float, float] | Limits | None] | None = None,
    drives: Sequence[Drive | None] | None = None,
    passive: Sequence[str] = (),
    name: str | None = None,
) -> RobotDescription:
    """The links and joints of a planar word; arguments as in `planar`."""
    if not isinstance(word, str) or not word or set(word) - set("RP"):
        raise ModelError(
            f"planar: the word {shown(word)} must be made of the letters R and P, such as 'RR' or "
            f"'RP'."
        )
    if len(word) > MOST_LINKS:
        raise ModelError(
            f"planar: the word has {len(word)} letters, one per link; at most {MOST_LINKS} are "
            f"read."
        )
    n = len(word)
    lengths = _entries("l", l, n, word)
    centres, masses, inertias = _entries("lc", lc, n), _entries("m", m, n), _entries("I", I, n)
    turns = _constant_turns(word, angles)
    ranges = _optional("limits", limits, n)
    drives_ = _optional("drives", drives, n)
    names = [f"joint{i + 1}" for i in range(n)]
    idle = (passive,) if isinstance(passive, str) else tuple(passive)
    for joint in idle:
        if joint not in names:
            raise ModelError(str(UnknownNameError("joint", joint, "planar: passive", names)))
    links, joints = [Link("base")], []
    reach: Quantity = 0.0
    for i, letter in enumerate(word):
        drive = drives_[i] or Drive()
        if not isinstance(drive, Drive):
            raise ModelError(
                f"planar: drives[{i}] is {drive!r}, expected a Drive such as Drive(viscous=0.1)."
            )
        links.append(Link(f"link{i + 1}", Inertia(masses[i], (centres[i], 0.0), (inertias[i],))))
        joints.append(
            Joint(
                names[i],
                BY_LETTER[letter],
                links[i].name,
                links[i + 1].name,
                shift(reach, 0.0).then(turn("z", turns[i])),
                (1.0,) if letter == "R" else (1.0, 0.0),
                Limits.of(ranges[i], f"planar: limits[{i}]"),
                drive,
                passive=names[i] in idle,
            )
        )
        reach = lengths[i]
    tip = Mount("tip", links[-1].name, shift(reach, 0.0))
    gravity = gravity_of(g, 2, name="g")
    return RobotDescription(
        name or word, 2, tuple(links), tuple(joints), gravity, (tip,), tip="tip"
    )


def _entries(
    letter: str, given: Sequence[GivenNumber] | None, n: int, word: str = ""
) -> list[Quantity]:
    """The quantities letter1, letter2, … for n joints; where a word is given, the default of a P is
    0."""
    values = _optional(letter, given, n)
    return [
        0.0
        if value is None and word and word[i] == "P"
        else quantity(value, f"planar: {letter}[{i}]", f"{letter}{i + 1}")
        for i, value in enumerate(values)
    ]


def _optional(name: str, given: Sequence | None, n: int) -> list:
    """The given values, or n times None where none are given; refuses another number of them."""
    refuse_labelled(f"planar: {name}", given)
    if given is None:
        return [None] * n
    if isinstance(given, str) or not hasattr(given, "__len__") or len(given) != n:
        raise ModelError(
            f"planar: {name} must have {n} entries, one per joint; got {shown(given)}."
        )
    return list(given)


def _constant_turns(word: str, angles: Sequence[float] | None) -> list[float]:
    if angles is not None:
        return [
            finite(a, f"planar: angles[{i}]")
            for i, a in enumerate(_optional("angles", angles, len(word)))
        ]
    return [
        math.pi / 2 if letter == "P" and i and word[i - 1] == "P" else 0.0
        for i, letter in enumerate(word)
    ]
