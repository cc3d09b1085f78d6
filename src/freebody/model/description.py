"""The parts of a robot, as data: what files and builders describe, and what a `Model` is made
of."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, make_dataclass
from functools import wraps
from itertools import islice
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from freebody.errors import IncludedLine, ModelError, shown
from freebody.lazy import Keeps, cached_property
from freebody.model.drives import LAWS, NUMBERS, DriveLaw, LawNumber
from freebody.model.families import Members
from freebody.model.inertia import Inertia
from freebody.model.mimics import Mimic
from freebody.model.parameter_formulas import ParameterFormula
from freebody.model.parameters import Parameter, Quantity, quantity, real
from freebody.model.placement import Placement
from freebody.model.refusal_rules import NO_JOINT_HAS, is_not_given
from freebody.model.shapes import Shape
from freebody.model.struts import Strut

INFINITE = float("inf")
MOST_LINKS = 50_000
"""The most links of one robot; more are a mistake, or meant to fill the memory."""


@dataclass(frozen=True)
class Limits:
    """Range of a joint of one coordinate: position (rad or m), speed, effort (N m or N).

    Floats, or `Members` of a family.
    """

    lower: Any = -INFINITE
    upper: Any = INFINITE
    velocity: Any = INFINITE
    effort: Any = INFINITE

    def __post_init__(self) -> None:
        for name, value in tuple(vars(self).items()):
            if not isinstance(value, Members):
                object.__setattr__(self, name, real(value, f"Limits: {name}"))

    def fault(self) -> str | None:
        """The reason why no joint has these limits, or None; for a family, that of the first member
        with one."""
        given = (
            x.array if isinstance(x, Members) else x
            for x in (self.lower, self.upper, self.velocity, self.effort)
        )
        columns = np.broadcast_arrays(*given)
        for row in zip(*(column.ravel().tolist() for column in columns), strict=True):
            if any(x != x for x in row):
                return "a limit is not a number; correct it"
            numbers: dict[str, float] = dict(
                zip(("lower", "upper", "velocity", "effort"), row, strict=True)
            )
            for rule in NO_JOINT_HAS:
                about = [numbers[name] for name in rule.about]
                if rule.broken(*about):
                    return rule.said(*about)
        return None

    @property
    def meant(self) -> Limits:
        """The limits as they are used: a position range of no width, and a speed or effort of 0,
        which files write for "not given", count as infinite."""
        none = is_not_given(self.lower, self.upper)
        return Limits(
            -INFINITE if none else self.lower,
            INFINITE if none else self.upper,
            INFINITE if is_not_given(self.velocity) else self.velocity,
            INFINITE if is_not_given(self.effort) else self.effort,
        )

    @staticmethod
    def of(given: Sequence[float] | Limits | None, owner: str) -> Limits:
        """Limits as they are, a pair (lower, upper), or None for none; an error names the owner."""
        if given is None or isinstance(given, Limits):
            return given or Limits()
        if isinstance(given, str | Mapping) or not hasattr(given, "__len__") or len(given) != 2:
            raise ModelError(
                f"{owner}: limits must be (lower, upper), or fb.Limits(lower, upper, velocity, "
                f"effort) with those of speed and effort too; got {shown(given)}."
            )
        return Limits(*(real(x, f"{owner}: limits") for x in given))


if TYPE_CHECKING:
    from freebody.model.drives.law_numbers import LawNumbers as _LawNumbers
else:

    def _read(drive: Drive) -> None:
        for name, value in tuple(vars(drive).items()):
            object.__setattr__(drive, name, quantity(value, f"Drive: {name}"))

    _LawNumbers = make_dataclass(
        "_LawNumbers",
        [(name, Quantity, field(default=number.default)) for name, number in NUMBERS.items()],
        frozen=True,
        namespace={"__post_init__": _read},
    )
    _all_at_once = _LawNumbers.__init__

    @wraps(_all_at_once)
    def _checked(drive: Drive, *numbers: Quantity, **more: Quantity) -> None:
        _all_at_once(drive, *numbers, **more)
        if fault := drive.idle((*islice(NUMBERS, len(numbers)), *more)):
            raise ModelError(f"Drive: {fault}.")

    _LawNumbers.__init__ = _checked


@dataclass(frozen=True, init=False)
class Drive(_LawNumbers, Keeps):
    """Forces along a joint of one coordinate besides the motor's: the numbers of all laws
    (`model.drives`), 0 where a law does not act, or names of symbols.

    Among them viscous and dry friction; a rotor, whose inertia J a gear shows as J gear²; a spring.
    """

    @property
    def strengths(self) -> tuple[Quantity, ...]:
        """The strength of each law, the number without which the law does not act."""
        return tuple(getattr(self, law.strength) for law in LAWS.values())

    @cached_property
    def listed_laws(self) -> list[DriveLaw]:
        """The laws by which a joint is described: the usual ones, and all others that have a
        strength."""
        return [x for x in LAWS.values() if x.usual or _is_given(getattr(self, x.strength))]

    @property
    def listed(self) -> tuple[LawNumber, ...]:
        """The numbers of the laws by which a joint is described."""
        return tuple([number for law in self.listed_laws for number in law.numbers])

    def idle(self, given: Collection[str]) -> str | None:
        """The reason why one of the numbers given has no effect, its law's strength being 0 and not
        given, or is not enough, as another must stand beside it; or None."""
        for strength, name in _TOGETHER:
            alone = strength in given and name not in given and not _is_given(getattr(self, name))
            if alone and _is_given(getattr(self, strength)):
                return f"{strength} is given without {name}, which has no default; give both"
        for law in LAWS.values():
            if law.strength in given or _is_given(getattr(self, law.strength)):
                continue
            for number in law.numbers[1:]:
                differs = getattr(self, number.name) != number.default
                if number.name in given and differs and not number.waits:
                    return (
                        f"{number.name} is given without {law.strength}, without which it has no "
                        f"effect; give both"
                    )
        return None

    def fault(self, strict: bool = False) -> str | None:
        """The reason why no joint has this drive, or None; for a family, that of the first member
        with one.

        strict: look at those numbers alone without which a law says nothing.
        """
        for strength, name in _TOGETHER:
            if _is_given(getattr(self, name)) and not _is_given(getattr(self, strength)):
                return f"{name} is given without {strength} above 0; give both"
        for number in self.listed:
            if number.refused is not None and (number.strict or not strict):
                for x in _values(getattr(self, number.name)):
                    if fault := number.refused(x):
                        return fault
        return None


_TOGETHER = tuple(
    (law.strength, number.name)
    for law in LAWS.values()
    for number in law.numbers[1:]
    if number.below < math.inf
)
"""Pairs of a strength and a further number that is bounded, too."""


def _is_given(number: Quantity) -> bool:
    if type(number) is float:
        return number != 0.0
    return isinstance(number, Parameter) or any(_values(number))


def _values(number: Quantity) -> list[float]:
    """The values of a quantity as a list, for a family one for each member; empty where the value
    is not known."""
    known = number.value if isinstance(number, Parameter) else number
    if known is None:
        return []
    return known.array.ravel().tolist() if isinstance(known, Members) else [known]


@dataclass(frozen=True)
class Joint(Keeps):
    """A joint between two links; its frame is placed in the parent link's frame, and is the child
    link's frame at q = 0."""

    name: str
    kind: str
    parent: str
    child: str
    placement: Placement = Placement()
    axis: tuple[float, ...] = ()
    limits: Limits = Limits()
    drive: Drive = Drive()
    mimic: Mimic | None = None
    line: int | IncludedLine | None = field(default=None, compare=False)
    passive: bool = False
    """Nothing drives it: it is moved by the others, and no torque acts there but friction and a
    spring."""
    numbers: tuple[Quantity, ...] = ()
    """The numbers of its kind besides an axis (`JointKind.numbers`): of a helical joint the pitch,
    m/rad."""


@dataclass(frozen=True)
class Link:
    """A rigid part with a frame; `inertia` is given in a frame placed in the link's. filled:
    whether it is that of shapes that the reader of the file has filled evenly; stated: whether a
    file in freebody's own form gives its moments, so that a mass without any is meant as a point.
    """

    name: str
    inertia: Inertia | None = None
    placement: Placement = Placement()
    line: int | IncludedLine | None = field(default=None, compare=False)
    shapes: tuple[Shape, ...] = ()
    filled: bool = False
    stated: bool = False


@dataclass(frozen=True)
class Mount:
    """A named frame fixed to a link, or to a frame mounted before, such as a tool's."""

    name: str
    link: str
    placement: Placement = Placement()


@dataclass(frozen=True)
class Payload:
    """A rigid load fixed to a frame, its inertia in that frame's axes."""

    name: str
    frame: str
    inertia: Inertia


@dataclass(frozen=True)
class Loop:
    """A closed chain: frames A and B, on two bodies, held together by a kind of joint
    (`LOOP_KINDS`).

    axis: of revolute (space) and prismatic loops, the same in the axes of A and of B. distance: of
    distance loops, m.
    """

    name: str
    kind: str
    frames: tuple[str, str]
    axis: tuple[float, ...] = ()
    distance: Quantity | None = None
    line: int | IncludedLine | None = field(default=None, compare=False)


CHANGED = "parameter"
"""Kind of the notice on numbers that are others than the file's."""
TIP = "tip"
"""Kind of the notice that says which frame is the tip and why, or why none is."""


@dataclass(frozen=True)
class Notice:
    """A remark on how a model was read: snapped angles, ignored tags, doubtful values."""

    kind: str
    text: str
    file: str | None = None
    line: int | IncludedLine | None = None

    def __post_init__(self) -> None:
        if isinstance(self.line, IncludedLine):
            file, line = self.line
            object.__setattr__(self, "file", file)
            object.__setattr__(self, "line", line)

    def __str__(self) -> str:
        place = (
            f"{self.file}:{self.line}: "
            if self.file and self.line
            else f"{self.file}: "
            if self.file
            else ""
        )
        return f"{place}{self.text}"


@dataclass(frozen=True)
class RobotDescription:
    """Links and joints as a file or a builder gives them, before assembly into a Model."""

    name: str
    dim: int
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    gravity: tuple[Quantity, tuple[float, ...]]
    mounts: tuple[Mount, ...] = ()
    loops: tuple[Loop, ...] = ()
    formulas: tuple[ParameterFormula, ...] = ()
    payloads: tuple[Payload, ...] = ()
    base: Literal["fixed", "free"] = "fixed"
    """Whether the root link is held or free, where the caller does not say."""
    tip: str | None = None
    home: tuple[tuple[str, float], ...] = ()
    """(position name, value): where closing the loops starts from; others are neutral."""
    source: str = ""
    about: str = ""
    """The robot in words, and what is worth seeing in it."""
    notices: tuple[Notice, ...] = field(default=())
    file: str | None = None
    real: bool = False
    """Whether it is to describe a machine that exists, so that its masses are held against lengths
    and shapes."""
    loop_tolerance: tuple[float, float] | None = None
    """(m, rad): by how much rounded numbers may keep loops from closing; None: the default."""
    struts: tuple[Strut, ...] = ()
