"""Doubts about a robot: one table of kinds, and the doubts that a model has.

A kind says what it touches and what weight it has: it bars the verdict, or stands beside it. What
follows from the model's numbers is found anew for each model, so that a changed copy has its own
doubts; what only its file could tell (placeholders, estimates) is a `Doubt` among `Model.notices`,
and stands for as long as the model has the numbers that it is about. A result asks for the doubts
on what it depends on (`doubts_on`) and says them in one line (`in_one_line`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import listed
from freebody.model.bodies import Body
from freebody.model.description import TIP, Limits, Notice
from freebody.model.drives import LAWS
from freebody.model.inertia import Inertia, combined
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached, parents_first
from freebody.model.usable_limits import UsableLimits, usable_limits
from freebody.spatial import Vector, add, of_dimension, times

if TYPE_CHECKING:
    from freebody.model.model import Model

MASSES, LOADS, ROTORS, FRICTION = "masses", "loads", "rotors", "friction"
EFFORTS, SPEEDS, RANGES = "effort limits", "speed limits", "position limits"
INERTIAL = (MASSES, LOADS)
DYNAMIC = (*INERTIAL, ROTORS, FRICTION)
"""All aspects that forces, and motions under forces, depend on."""
LIMITS = (EFFORTS, SPEEDS, RANGES)
ALL = (*DYNAMIC, *LIMITS)
"""All that a doubt may be about."""

NO_MASSES, IMPLAUSIBLE = "no masses", "implausible inertias"
ESTIMATED, ESTIMATED_LIMITS = "estimated inertias", "estimated limits"
PLACEHOLDERS = "placeholder limits"

_NAMES = 4
"""Joints that a sentence names before it counts the others."""
_MEMBERS = 64
"""Members of a family that are looked at."""
MEASURED = 0.15
"""Share of a body's largest principal moment by which its moments may break the triangle inequality
because they are measured, or printed with few digits."""
_SEVERAL = 3
"""Joints with the same limits that tell a placeholder, and the masses that they move."""
_APART = 1.01
"""Ratio of masses that are not the same."""
_STRONGEST = {"N m": 200.0, "N": 10_000.0}
"""For each kilogram of the whole robot, its drives included: the effort limit of no joint."""
_ON_THE_GROUND = 10.0
"""Factor on that limit where the motor stands on the ground and is no part of the robot's mass."""
_DENSEST = 75.0
"""N m for each kilogram of the whole robot: all motors together that it carries have no more. Arms
of makers have 15 to 45, legged robots 20 to 30; motors on the ground are not part of its mass."""
_FASTEST = 340.0
"""m/s: the speed of no robot's end, which is that of sound."""
_ON_AXIS = 1e-6
"""Distance in m below which a point counts as on an axis."""
_ROUNDED = 1e-9
"""Relative, or rad: what rounding leaves of 0."""


About = tuple[tuple[str, Inertia | Limits | None], ...]
"""Names of links or joints, with what is doubted."""


@dataclass(frozen=True)
class Doubt(Notice):
    """A doubt about a model: its kind (a name of `DOUBT_KINDS`) and a sentence.

    joints: the coordinates whose limits are meant; () all. about: names of links, with the inertia
    that is doubted (None: that there is none), or of joints with their limits; () of a doubt that
    the model itself shows.
    """

    joints: tuple[str, ...] = ()
    about: About = field(default=(), repr=False)

    @property
    def of(self) -> DoubtKind:
        """The record of the doubt's kind, which says what the doubt touches and how serious it
        is."""
        return DOUBT_KINDS[self.kind]

    @property
    def clause(self) -> str:
        """The sentence without its full stop, so that a text can go on."""
        return self.text.rstrip(".")


@dataclass(frozen=True)
class DoubtKind:
    """A kind of doubt.

    touches: what it is about. bars: whether nothing is called feasible; else it stands beside the
    verdict. mend: whether the file has to be corrected, which a command's exit status 1 says.
    absent: whether something is not given, so that all that is given can be judged. find: what
    finds it in a model's own numbers, if these show it, among what is asked for. key: what files in
    TOML call a list of such sentences, of a kind that only a file can tell; tied: the numbers of a
    model that such sentences are about, where the file names none (`Doubt.about`).
    """

    name: str
    touches: tuple[str, ...]
    bars: bool
    mend: bool = False
    absent: bool = False
    find: Callable[[Model, Sequence[str]], Iterator[str | Doubt]] | None = None
    key: str = ""
    tied: Callable[[Model], About] | None = None


# ------------------------------------------------------------ what results ask
def doubts_on(model: Model, *aspects: str) -> tuple[Doubt, ...]:
    """The doubts about these aspects of a model, in the order of the table.

    Of a family those of each kind that its first member with such doubts has; of one with very many
    members, `_MEMBERS` of them from the first to the last are looked at. Of a model with parameters
    without value what its file tells.
    """
    key = f"doubts on {', '.join(aspects)}"
    if key not in model.facts:
        model.facts[key] = _doubts_on(model, aspects)
    return model.facts[key]


def in_one_line(doubts: Iterable[Doubt]) -> str:
    """All doubts in one line: those that prevent a verdict after "Not judged:", then the others; ""
    for none."""
    every = list(doubts)
    barring = "; ".join(x.clause for x in every if x.of.bars)
    beside = (capital(x.text) for x in every if not x.of.bars)
    return " ".join([*([f"Not judged: {barring}."] if barring else []), *beside])


def attribute(doubts: Iterable[Doubt]) -> dict[str, str]:
    """The doubts as an attribute of a dataset or manifest; an empty dict where there are none."""
    line = in_one_line(doubts)
    return {"doubts": line} if line else {}


def named(doubts: Iterable[Doubt]) -> str:
    """The kinds of doubts as text to follow a title, such as "; not judged: placeholders"; "" for
    none."""
    every = list(doubts)
    barring = ", ".join(dict.fromkeys(x.kind for x in every if x.of.bars))
    beside = dict.fromkeys(x.kind for x in every if not x.of.bars)
    parts = [f"not judged: {barring}"] if barring else []
    return "".join(f"; {part}" for part in (*parts, *beside))


def capital(text: str) -> str:
    """A sentence with a capital first letter, unless it starts with a name."""
    first = text.split(" ", 1)[0].rstrip(",")
    return text[:1].upper() + text[1:] if first.isalpha() and first.islower() else text


def doubts_used(model: Model, *aspects: str) -> tuple[Doubt, ...]:
    """The doubts about these aspects of a model where they are used but not judged: doubts about
    missing numbers are left out."""
    return tuple(doubt for doubt in doubts_on(model, *aspects) if not doubt.of.absent)


def readings(model: Model) -> tuple[Notice, ...]:
    """Notices on how the model's file was read, other than doubts and the choice of the tip."""
    return tuple(x for x in model.notices if not isinstance(x, Doubt) and x.kind != TIP)


def barring(doubts: Iterable[Doubt]) -> tuple[Doubt, ...]:
    """The doubts that prevent a verdict."""
    return tuple(doubt for doubt in doubts if doubt.of.bars)


# ------------------------------------------------------------ which there are
def _doubts_on(model: Model, aspects: tuple[str, ...]) -> tuple[Doubt, ...]:
    if model.family:
        count = math.prod(model.family)
        looked_at = np.unique(np.linspace(0, count - 1, min(count, _MEMBERS)).round().astype(int))
        members = (model[np.unravel_index(k, model.family)] for k in looked_at)
        every: list[Doubt] = []
        for member in members:
            known = {doubt.kind for doubt in every}
            every += [x for x in doubts_on(member, *aspects) if x.kind not in known]
        return tuple(every)
    read = read_doubts(model)
    found: list[Doubt] = []
    for kind in DOUBT_KINDS.values():
        if set(kind.touches) & set(aspects):
            own = [doubt for doubt in read if doubt.kind == kind.name]
            found += own or _found(kind, model, aspects)
    return tuple(found)


def _found(kind: DoubtKind, model: Model, aspects: Sequence[str]) -> list[Doubt]:
    if kind.find is None or model.missing:
        return []
    return [x if isinstance(x, Doubt) else Doubt(kind.name, x) for x in kind.find(model, aspects)]


def read_doubts(model: Model) -> list[Doubt]:
    """The doubts that the model's file states and that the model's numbers have not refuted
    since."""
    read = [notice for notice in model.notices if isinstance(notice, Doubt)]
    if not read or model.missing or model.family:
        return read
    links, limits = dict(_all_inertias(model)), dict(_all_limits(model))
    bare = dict(_bare_bodies(model))

    def stands(name: str, was: Inertia | Limits | None) -> bool:
        if was is None:
            return name in bare
        if isinstance(was, Limits):
            return limits.get(name) == was
        now = links.get(name)
        assert not isinstance(now, Limits)
        alike = now is not None and any(was.tensor) and now.tensor == was.tensor
        return now is not None and (alike or now.mass == was.mass)

    return [
        doubt for doubt in read if not doubt.about or any(stands(*entry) for entry in doubt.about)
    ]


def _bare_bodies(model: Model) -> About:
    return tuple((body.name, None) for body in model.bodies if is_bare(body))


def _all_limits(model: Model) -> About:
    return tuple((body.joint.name, body.joint.limits) for body in model.bodies)


def _all_inertias(model: Model) -> About:
    return tuple((part.link, part.inertia) for part in _parts(model) if not part.load)


def is_bare(body: Body) -> bool:
    """Whether a body has neither mass nor inertia."""
    return not any(weighs(part) for part in body.inertias)


def weighs(part: Attached) -> bool:
    """Whether a link has mass or inertia."""
    return any(VALUES.quantity(x) != 0.0 for x in (part.inertia.mass, *part.inertia.tensor))


def _parts(model: Model) -> list[Attached]:
    """The inertias of all moving links and loads of the robot."""
    return [part for body in model.bodies for part in body.inertias]


# ------------------------------------------------------------ masses
def _massless(model: Model, _: Sequence[str]) -> Iterator[str]:
    if model.bodies and all(map(is_bare, model.bodies)):
        yield "no body has any mass."


def _impossible(model: Model, _: Sequence[str]) -> Iterator[str]:
    wrong = _faults(model, lambda breach: breach > MEASURED)
    if len(wrong) == 1:
        yield f"an inertia is one that no rigid body has: {wrong[0][1]}."
    elif wrong:
        names = listed([name for name, _ in wrong], _NAMES)
        yield f"{len(wrong)} inertias are such that no rigid body has, of {names}: {wrong[0][1]}."


def _inexact(model: Model, _: Sequence[str]) -> Iterator[str]:
    off = _faults(model, lambda breach: breach <= MEASURED)
    if off:
        what = "an inertia" if len(off) == 1 else f"{len(off)} inertias"
        yield (
            f"{what} that no rigid body has {'is' if len(off) == 1 else 'are'} used as given, of "
            f"{listed([name for name, _ in off], _NAMES)}."
        )


def _faults(model: Model, wanted: Callable[[float], bool]) -> list[tuple[str, str]]:
    """Names of links whose inertia no rigid body has, with the reason, on bodies whose breach of
    the triangle inequality is `wanted`; faults that no motion feels are left out."""
    found = []
    for body, axes in zip(model.bodies, _turned_about(model), strict=True):
        faults = [
            (part.link, fault)
            for part in body.inertias
            if (fault := part.inertia.fault()) and not _unfelt(part, axes)
        ]
        if faults and wanted(_breach(body)):
            found += [(link, f"link {link!r}: {fault}") for link, fault in faults]
    return found


def unfelt_links(model: Model) -> set[str]:
    """Names of links whose impossible inertia affects no motion: those of the base, and those that
    turn only about the axis for which their inertia is given."""
    moving = {
        part.link
        for body, axes in zip(model.bodies, _turned_about(model), strict=True)
        for part in body.inertias
        if part.inertia.fault() and _unfelt(part, axes)
    }
    return moving | {part.link for part in model.base_inertias if part.inertia.fault()}


def _breach(body: Body) -> float:
    """The excess of a body's principal moments over the triangle inequality, relative to the
    largest; infinite for negative masses and moments."""
    if any(VALUES.quantity(part.inertia.mass) < 0.0 for part in body.inertias):
        return math.inf
    return excess(_whole(body))


def excess(tensor: Array) -> float:
    """The excess of a tensor's principal moments over the triangle inequality, relative to the
    largest; infinite where none is above 0."""
    if tensor.shape == (1, 1):
        return math.inf if tensor[0, 0] < 0.0 else 0.0
    a, b, c = np.linalg.eigvalsh(tensor)
    return float((c - a - b) / c) if c > 0.0 else math.inf


def _unfelt(part: Attached, axes: Array | None) -> bool:
    """Whether no motion feels the fault in a link's inertia, since its body never turns, or only
    about the axis for which its inertia is given. axes: see `_turned_about`."""
    mass, _, tensor = part.inertia.numbers()
    if axes is None or mass < 0.0:
        return False
    if not len(axes):
        return True
    R = np.array(part.placement.lower(of_dimension(3), VALUES)[0], dtype=float)
    axis = R.T @ axes[0]
    about = float(axis @ tensor @ axis)
    rest = tensor - about * np.outer(axis, axis)
    return about >= 0.0 and float(np.abs(rest).max()) <= _ROUNDED * float(np.abs(tensor).max())


def _turned_about(model: Model) -> list[Array | None]:
    """For each body in space the axes, in its frame, about which it can turn: none (0, 3), or a
    single one (1, 3); None where there are several, and for planar models."""
    if model.dim == 2:
        return [None] * len(model.bodies)
    space = of_dimension(3)
    turned: dict[int, tuple[Array, list[Array]]] = {-1: (np.eye(3), [])}
    """Orientation of each body where all coordinates are 0, and the axes above it, seen from there,
    by body."""
    axes: list[Array | None] = [None] * len(model.bodies)
    for i in parents_first(model.bodies):
        body = model.bodies[i]
        R, above = turned[body.parent]
        R = R @ np.array(body.joint.placement.lower(space, VALUES)[0], dtype=float)
        numbers = tuple(map(VALUES.quantity, body.joint.numbers))
        own = [
            R @ np.array(angular, dtype=float)
            for primitive, axis in body.kind.primitives(space, body.joint.axis, numbers)
            for angular, _ in primitive.columns(space, axis)
            if any(angular)
        ]
        every = [*above, *own]
        turned[i] = R, every
        if all(np.allclose(np.cross(every[0], u), 0.0, atol=_ROUNDED) for u in every):
            axes[i] = np.reshape([R.T @ u for u in every[:1]], (-1, 3))
    return axes


def _whole(body: Body) -> Array:
    """The inertia of a body about its centre of mass, all links fixed to it included."""
    dim = body.inertias[0].inertia.dim
    placed = [
        part.inertia.placed(*part.placement.lower(of_dimension(dim), VALUES))
        for part in body.inertias
    ]
    return combined(placed).numbers()[2]


# ------------------------------------------------------------ drives and loads
def _no_drive(model: Model, _: Sequence[str]) -> Iterator[str]:
    wrong = [
        f"joint {body.joint.name!r}: {fault}"
        for body in model.bodies
        if (fault := body.joint.drive.fault())
    ]
    if wrong:
        more = f" ({len(wrong) - 1} more)" if len(wrong) > 1 else ""
        yield f"no motor has such a drive: {wrong[0]}{more}."


_ROTORS = tuple(law.strength for law in LAWS.values() if law.inertia is not None)


def _no_rotor(model: Model, _: Sequence[str]) -> Iterator[str]:
    """A doubt about joints without rotor inertia whose limits are otherwise given; models of
    textbooks have no such limits."""
    described_joints, without = 0, []
    for body in model.bodies:
        limits, drive = body.joint.limits.meant, body.joint.drive
        described = isfinite(limits.effort) or isfinite(limits.velocity)
        if body.joint.passive or body.joint.mimic or body.kind.nv != 1 or not described:
            continue
        described_joints += 1
        if all(VALUES.quantity(getattr(drive, name)) == 0.0 for name in _ROTORS):
            without.append(body.joint.name)
    if without:
        of = "" if len(without) == described_joints else f" of {listed(without, _NAMES)}"
        yield f"rotor inertia{of} is not given; its torque is left out."


def _point(model: Model, _: Sequence[str]) -> Iterator[str]:
    space = of_dimension(model.dim)
    for body in model.bodies:
        for part in body.inertias:
            inertia = part.inertia
            mass = VALUES.quantity(inertia.mass)
            if not part.load or not mass or any(VALUES.quantity(x) for x in inertia.tensor):
                continue
            R, p = part.placement.lower(space, VALUES)
            com = [VALUES.quantity(x) for x in inertia.com]
            at = np.array(p) + np.array(R, dtype=float) @ com
            off = at
            if model.dim == 3 and body.joint.axis:
                off = np.cross(body.joint.axis, at)
            free = body.kind.turns and float(np.linalg.norm(off)) <= _ON_AXIS
            feels = f"; {body.joint.name}, on whose axis it is, does not feel it" if free else ""
            yield f"load {part.link!r} ({mass:.4g} kg) is a point without inertia{feels}."


# ------------------------------------------------------------ limits
class _MotorLimits(NamedTuple):
    """The limits of one coordinate, with the mass that its motor moves and how far that extends
    (m)."""

    name: str
    slides: bool
    carried: bool
    """Whether the motor is part of the robot's mass, which that of its base is too; else it stands
    on the ground."""
    speed: float
    effort: float
    mass: float
    reach: float

    @property
    def most(self) -> str:
        """The effort limit as text."""
        return f"{self.effort:g} {'N' if self.slides else 'N m'}"

    @property
    def fastest(self) -> str:
        """The speed limit as text."""
        return f"{self.speed:g} {'m' if self.slides else 'rad'}/s"


def _placeholders(model: Model, _: Sequence[str]) -> Iterator[Doubt]:
    """Doubts about limits that are placeholders: equal round numbers on joints that move different
    masses, or values that no robot has."""
    motors = _motors(model)
    alike = [*_alike(motors)]
    yield from alike
    said = {name for doubt in alike for name in doubt.joints}
    mass = abs(model.mass)
    strong = [d for d in motors if _is_strong(d, mass)] or [*_overloading(motors, mass)]
    fast = [d for d in motors if isfinite(d.speed) and d.speed * (d.slides or d.reach) > _FASTEST]
    yield from _beyond_belief("effort", [(x.name, x.most) for x in strong if x.name not in said])
    yield from _beyond_belief("speed", [(x.name, x.fastest) for x in fast if x.name not in said])


def _beyond_belief(what: str, found: Sequence[tuple[str, str]]) -> Iterator[Doubt]:
    """A doubt about limits that no robot has, from the joints' names and their limits as text."""
    if found:
        names, several = tuple(name for name, _ in found), len(found) > 1
        text = (
            f"no such robot has the {what} limit{'s' if several else ''} of "
            f"{listed(names, _NAMES)}, {'such as ' if several else ''}{found[0][1]}."
        )
        yield Doubt(PLACEHOLDERS, text, joints=names)


def _motors(model: Model) -> list[_MotorLimits]:
    """The limits and moved masses of all coordinates that have a motor of their own."""
    given, moved = usable_limits(model).given, _moved(model)
    based = any(VALUES.quantity(part.inertia.mass) for part in model.base_inertias)
    return [
        _MotorLimits(
            body.joint.name,
            body.kind.slides,
            based or body.parent >= 0,
            float(given[2, at.v[0]]),
            float(given[3, at.v[0]]),
            *moves,
        )
        for body, at, moves in zip(model.bodies, model.coordinates, moved, strict=True)
        if body.joint.mimic is None and body.kind.nv == 1 and not body.joint.passive
    ]


def _alike(motors: Sequence[_MotorLimits]) -> Iterator[Doubt]:
    """Doubts about round limits that several joints share although they move different masses."""
    groups: dict[tuple[str, str], list[_MotorLimits]] = {}
    for motor in motors:
        if _is_round(motor.speed) and _is_round(motor.effort):
            groups.setdefault((motor.most, motor.fastest), []).append(motor)
    for (most, fastest), group in groups.items():
        if _different(motor.mass for motor in group) >= _SEVERAL:
            names = tuple(motor.name for motor in group)
            text = (
                f"the limits of {listed(names, _NAMES)} are placeholders, {most} and {fastest} of "
                f"each."
            )
            yield Doubt(PLACEHOLDERS, text, joints=names)


def _is_strong(drive: _MotorLimits, mass: float) -> bool:
    """Whether an effort limit is larger than any joint of a robot of this mass (kg) has."""
    strongest = _STRONGEST["N" if drive.slides else "N m"] * mass
    strongest *= 1.0 if drive.carried else _ON_THE_GROUND
    return isfinite(drive.effort) and drive.effort > strongest > 0.0


def _overloading(drives: Sequence[_MotorLimits], mass: float) -> Iterator[_MotorLimits]:
    """Motors too strong for the robot of this mass (kg) that carries them: the strongest and its
    equals, removed until the rest together is plausible."""
    carried = [d for d in drives if d.carried and not d.slides and isfinite(d.effort)]
    total, least = sum(drive.effort for drive in carried), math.inf
    for drive in sorted(carried, key=lambda drive: -drive.effort):
        if total <= _DENSEST * mass or mass == 0.0:
            break
        total, least = total - drive.effort, drive.effort
    return (drive for drive in carried if drive.effort >= least)


def _is_round(x: float) -> bool:
    """Whether a number has a single significant digit."""
    return isfinite(x) and x > 0.0 and float(f"{x:.0e}") == x


def _different(masses: Iterable[float]) -> int:
    """The number of clearly different masses."""
    count, last = 0, 0.0
    for mass in sorted(masses):
        if mass > _APART * last:
            count, last = count + 1, mass
    return count


def _moved(model: Model) -> list[tuple[float, float]]:
    """For each joint the mass that it moves (kg), and the largest distance of that mass from it
    (m)."""
    space = of_dimension(model.dim)

    def far(placement: Placement, beyond: Vector = ()) -> float:
        R, p = placement.lower(space, VALUES)
        return math.hypot(*(add(p, times(R, beyond)) if beyond else p))

    count = len(model.bodies)
    masses, reaches = [0.0] * count, [0.0] * count
    for frame in model.frames:
        if frame.body >= 0:
            reaches[frame.body] = max(reaches[frame.body], far(frame.placement))
    for i, body in enumerate(model.bodies):
        for part in body.inertias:
            mass, com, _ = part.inertia.lower(VALUES)
            masses[i] += mass
            reaches[i] = max(reaches[i], far(part.placement, com) if mass else 0.0)
    for i in reversed(parents_first(model.bodies)):
        body = model.bodies[i]
        if body.parent >= 0:
            masses[body.parent] += masses[i]
            beyond = far(body.joint.placement) + reaches[i]
            reaches[body.parent] = max(reaches[body.parent], beyond)
    return list(zip(masses, reaches, strict=True))


def _missing(model: Model, aspects: Sequence[str]) -> Iterator[str]:
    """A doubt about limits that the description does not give, and about joints of several
    coordinates without motors."""
    allowed = usable_limits(model)
    found = _absent_limits(model, allowed, aspects)
    if allowed.apart and RANGES in aspects:
        found.append(f"a range that suits {listed(allowed.apart, _NAMES)}")
    several = [b.joint.name for b in model.bodies if b.kind.nv > 1 and not b.joint.passive]
    if several and not model.loops and EFFORTS in aspects:
        have = "has no motor of its" if len(several) == 1 else "have no motors of their"
        found.append(f"what moves {listed(several, _NAMES)}, which {have} own")
    if found:
        yield f"the description lacks {'; '.join(found)}."


def _absent_limits(model: Model, allowed: UsableLimits, aspects: Sequence[str]) -> list[str]:
    """The missing limits of driven joints in words, with joints that lack the same limits
    together."""
    driven = [
        (body, at.v[0])
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None and body.kind.nv == 1 and not body.joint.passive
    ]
    ranged = [(body, k) for body, k in driven if body.kind.ranged]
    bounded = np.isfinite(allowed.lower) & np.isfinite(allowed.upper)
    absent: dict[tuple[str, ...], list[str]] = {}
    """All that is not given, by the names of joints."""
    for aspect, what, joints, given in (
        (EFFORTS, "an effort limit", driven, np.isfinite(allowed.effort)),
        (SPEEDS, "a speed limit", driven, np.isfinite(allowed.velocity)),
        (RANGES, "a position range", ranged, bounded),
    ):
        names = tuple(body.joint.name for body, k in joints if not given[k])
        if names and aspect in aspects:
            absent.setdefault(names, []).append(what)
    return [f"{listed(parts)} of {listed(names, _NAMES)}" for names, parts in absent.items()]


DOUBT_KINDS: dict[str, DoubtKind] = {
    kind.name: kind
    for kind in (
        DoubtKind(
            NO_MASSES, (MASSES,), True, True, find=_massless, key="masses_missing",
            tied=_bare_bodies,
        ),
        DoubtKind(IMPLAUSIBLE, (MASSES,), True, True, key="masses_doubtful", tied=_all_inertias),
        DoubtKind("impossible inertias", (MASSES,), True, True, find=_impossible),
        DoubtKind("impossible drives", (ROTORS, FRICTION), True, True, find=_no_drive),
        DoubtKind(PLACEHOLDERS, (EFFORTS, SPEEDS), True, True, find=_placeholders),
        DoubtKind("missing limits", LIMITS, True, absent=True, find=_missing),
        DoubtKind(ESTIMATED, (MASSES,), True, key="masses_estimated", tied=_all_inertias),
        DoubtKind(ESTIMATED_LIMITS, LIMITS, True, key="limits_estimated", tied=_all_limits),
        DoubtKind("inexact inertias", (MASSES,), False, find=_inexact),
        DoubtKind("no rotor inertia", (ROTORS,), False, find=_no_rotor),
        DoubtKind("point load", (LOADS,), False, find=_point),
    )
}  # fmt: skip
"""All kinds by name, those first that a verdict names first."""
