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
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.errors import listed
from freebody.model.description import TIP, Limits, Notice
from freebody.model.doubt_rules import inertias, joints
from freebody.model.doubt_rules.aspects import (
    EFFORTS,
    FRICTION,
    LIMITS,
    LOADS,
    MASSES,
    ROTORS,
    SPEEDS,
    DoubtedJoints,
)
from freebody.model.doubt_rules.inertias import is_bare
from freebody.model.inertia import Inertia
from freebody.model.parameters import with_parameters

if TYPE_CHECKING:
    from freebody.model.model import Model

NO_MASSES, IMPLAUSIBLE = "no masses", "implausible inertias"
ESTIMATED, ESTIMATED_LIMITS = "estimated inertias", "estimated limits"
PLACEHOLDERS = "placeholder limits"
_MEMBERS = 64
"""Members of a family that are looked at."""
_NAMED = 6
"""Links or joints of a doubt that are named; more are counted."""
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
    model that such sentences are about, where the file names none (`Doubt.about`). remedy: what
    `doctor` says is to be done, of a kind that it tells of in these words.
    """

    name: str
    touches: tuple[str, ...]
    bars: bool
    mend: bool = False
    absent: bool = False
    find: Callable[[Model, Sequence[str]], Iterator[str | DoubtedJoints]] | None = None
    key: str = ""
    tied: Callable[[Model], About] | None = None
    remedy: str = ""


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
    read = [_narrowed(doubt, left) for doubt, left in _standing(model)]
    found: list[Doubt] = []
    for kind in DOUBT_KINDS.values():
        if set(kind.touches) & set(aspects):
            own = [doubt for doubt in read if doubt.kind == kind.name]
            found += own or _found(kind, model, aspects)
    return tuple(found)


def _found(kind: DoubtKind, model: Model, aspects: Sequence[str]) -> list[Doubt]:
    if kind.find is None or model.missing:
        return []
    return [
        Doubt(kind.name, x) if isinstance(x, str) else Doubt(kind.name, x.text, joints=x.joints)
        for x in kind.find(model, aspects)
    ]


def read_doubts(model: Model) -> list[Doubt]:
    """The doubts that the model's file states and that the model's numbers have not refuted
    since."""
    return [doubt for doubt, _ in _standing(model)]


def _narrowed(doubt: Doubt, left: list[str]) -> Doubt:
    """The doubt with the names of the links or joints that it is still about, where others have
    other numbers by now."""
    every = len(doubt.about)
    if len(left) == every:
        return doubt
    whom = listed(left) if len(left) <= _NAMED else f"{len(left)} of {every}"
    return replace(doubt, text=f"{doubt.clause}; still so for {whom}.")


class _Now:
    """A model's numbers as they are now, beside those that doubts were about."""

    def __init__(self, model: Model):
        self.links = dict(_in_numbers(_all_inertias(model)))
        self.limits = dict(_in_numbers(_all_limits(model)))
        self.bare = dict(_bare_bodies(model))

    def as_was(self, name: str, was: Inertia | Limits | None) -> bool:
        """Whether a link or joint still has what was doubted of it, None being no inertia."""
        if was is None:
            return name in self.bare
        if isinstance(was, Limits):
            return self.limits.get(name) == was
        now = self.links.get(name)
        assert not isinstance(now, Limits)
        alike = now is not None and any(was.tensor) and now.tensor == was.tensor
        return now is not None and (alike or now.mass == was.mass)


def _standing(model: Model) -> list[tuple[Doubt, list[str]]]:
    """The doubts that the model's file states and that the model's numbers have not refuted since,
    with the names of what each is still about."""
    read = [notice for notice in model.notices if isinstance(notice, Doubt)]
    if not read or model.missing or model.family:
        return [(doubt, [name for name, _ in doubt.about]) for doubt in read]
    now = _Now(model)
    left = [(doubt, [x[0] for x in doubt.about if now.as_was(*x)]) for doubt in read]
    return [(doubt, names) for doubt, names in left if names or not doubt.about]


def tied(notices: Sequence[Notice], model: Model) -> tuple[Notice, ...]:
    """Notices of a file, each doubt among them tied to the numbers of the file's model that it is
    about: to all numbers of that sort where the file names no links."""
    if model.missing:
        return tuple(notices)
    return tuple(
        replace(x, about=_in_numbers(x.of.tied(model)))
        if isinstance(x, Doubt) and not x.about and x.of.tied
        else x
        for x in notices
    )


def _in_numbers(about: About) -> About:
    """The same with values in the place of names, which stand for other values in other models."""
    return with_parameters(about, lambda parameter: parameter.value)


def _bare_bodies(model: Model) -> About:
    return tuple((body.name, None) for body in model.bodies if is_bare(body))


def _all_limits(model: Model) -> About:
    return tuple((body.joint.name, body.joint.limits) for body in model.bodies)


def _all_inertias(model: Model) -> About:
    parts = (part for body in model.bodies for part in body.inertias)
    return tuple((part.link, part.inertia) for part in parts if not part.load)


DOUBT_KINDS: dict[str, DoubtKind] = {
    kind.name: kind
    for kind in (
        DoubtKind(
            NO_MASSES, (MASSES,), True, True, find=inertias.massless, key="masses_missing",
            tied=_bare_bodies, remedy="give them mass, or estimate it with estimate_inertia=",
        ),
        DoubtKind(
            IMPLAUSIBLE, (MASSES,), True, True, key="masses_doubtful", tied=_all_inertias,
            remedy="give the robot's own numbers",
        ),
        DoubtKind("impossible inertias", (MASSES,), True, True, find=inertias.impossible),
        DoubtKind("impossible drives", (ROTORS, FRICTION), True, True, find=joints.no_drive),
        DoubtKind(
            PLACEHOLDERS, (EFFORTS, SPEEDS), True, True, find=joints.placeholders,
            remedy="give the motors' own limits",
        ),
        DoubtKind("missing limits", LIMITS, True, absent=True, find=joints.missing),
        DoubtKind(ESTIMATED, (MASSES,), True, key="masses_estimated", tied=_all_inertias),
        DoubtKind(ESTIMATED_LIMITS, LIMITS, True, key="limits_estimated", tied=_all_limits),
        DoubtKind("inexact inertias", (MASSES,), False, find=inertias.inexact),
        DoubtKind("no rotor inertia", (ROTORS,), False, find=joints.no_rotor),
        DoubtKind("point load", (LOADS,), False, find=inertias.point),
    )
}  # fmt: skip
"""All kinds by name, those first that a verdict names first."""
