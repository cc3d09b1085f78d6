"""Records of the quantities of bodies: names, words, units, existence and values. `fb.quantities`
returns them, `check` checks them, glossaries explain them and interactive pages show them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities import units
from freebody.expressions.quantities.kinds import (
    BODY_KINETIC,
    BODY_POTENTIAL,
    MASS_OF_BODY,
    OF_BODY,
    REACTION,
    Kind,
)
from freebody.expressions.quantities.units import Unit, si_text
from freebody.spatial import Vector, neg, sub, times, transposed
from freebody_textbook.derivation import Meaning
from freebody_textbook.methods.body_values import BodyValues
from freebody_textbook.methods.energies import Energies
from freebody_textbook.methods.setting import Setting

_ValueRule = Callable[[BodyValues], Any]
_EYE = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, eq=False)
class BodyQuantity:
    """The record of a quantity of body n; in names h is the number of the preceding body, k that of
    the next."""

    known: str
    """The quantity's name in `fb.quantities`."""
    words: str
    value: _ValueRule
    unit: Unit = units.NONE
    also: tuple[tuple[str, int], ...] = ()
    """Further names in answers, in plain spelling, and how many dots they have."""
    kind: Kind = OF_BODY
    is_scalar: bool = False
    """Whether it is one number in space too, which other groups of answers have."""
    angular: bool = False
    """Whether it is one number in the plane."""
    spaces: tuple[int, ...] = (2, 3)
    matrix: Literal["", "rotation", "tensor"] = ""
    """The kind of matrix that the quantity is in space."""
    soft: bool = False
    """Whether the name is often one of the user's own: one number is not read as this vector."""
    own_axes: bool = True
    """Whether it is a vector that in space has the axes of its own body."""
    framed: tuple[str, ...] | None = ()
    """Further names where a frame tells in whose axes it is, as Craig's; None of what has none."""
    is_place: bool = False
    """Whether a frame tells from whose origin it is seen, too."""
    reaction: str = ""
    """Words for the negative of the quantity."""
    only: str = ""
    """A key of `_WHERE`: of which bodies it is told."""
    of_centre: bool = False
    """Whether it is of the centre of mass: of bodies joined into one that is a fraction."""
    of_motion: bool = False
    """Whether it is told of bodies of trees and closed chains too: what moves a body alone."""
    symbol: str = ""
    """The quantity's symbol in glossaries, for body i or for bodies i and k: the letter with its
    index."""
    shown: bool = False
    """Whether living pages show the quantity."""

    @property
    def names(self) -> tuple[tuple[str, int], ...]:
        """All names in answers, first the name in `fb.quantities` without underscores."""
        plain = self.known.removesuffix("_d")
        return (plain.replace("_", ""), int(plain != self.known)), *self.also

    def spelt(self, n: int, axis: str = "") -> Iterator[str]:
        """Names of the quantity for body n, or of its component along an axis, v2x_d."""
        for name, dots in self.names:
            letter, _, ending = name.partition("{")
            yield from spellings(letter, ("{" + ending).format(**numbers(n)) + axis, dots)

    def told(self, n: int, h: int | None = None) -> str:
        """Description of the quantity for body n; h: number of the preceding body, if it is not n -
        1."""
        return self.words.format(**numbers(n, h))

    def meaning(self, planar: bool) -> Meaning:
        """The quantity's glossary entry, for a general body."""
        bold = not (planar and self.angular)
        of = {"h": "i", "n": "k"} if "{h}" in self.words else {"n": "i"}
        words = self.words.format(**of).removeprefix("the ")
        return Meaning((sym(self.symbol, bold),), words, si_text(self.unit, True))

    @property
    def has_axes_of_body(self) -> bool:
        """Whether the quantity is a spatial vector in the axes of body n."""
        told = self.own_axes and 3 in self.spaces and self.framed is not None
        return told and not self.is_scalar and not self.matrix

    def exists(self, b: BodyValues) -> bool:
        """Whether a body has the quantity; a body of several masses has none about its centre of
        mass."""
        fits = b.s.tree.space.dim in self.spaces and (b.is_whole or not self.of_centre)
        return fits and (not self.only or _WHERE[self.only](b))

    def axes(self, dim: int) -> str:
        """Axis letters of a vector, "xy" or "xyz"; "" for a scalar."""
        return "" if (self.angular and dim == 2) or self.is_scalar else "xyz"[:dim]


def numbers(n: int, h: int | None = None) -> dict[str, int]:
    """Numbers for the letters in names of body n's quantities; h: number of the preceding body, if
    it is not n - 1."""
    return {"h": n - 1 if h is None else h, "n": n, "k": n + 1}


def values_of(b: BodyValues) -> dict[str, Any]:
    """The quantities of a body by name."""
    rows = (x for x in BODY_QUANTITIES if x.exists(b))
    return {x.known.format(**numbers(b.n)): x.value(b) for x in rows}


_WHERE: Mapping[str, Callable[[BodyValues], bool]] = {
    "first": lambda b: b.n == 1,
    "last": lambda b: not b.s.tree.children(b.i),
    "with an end": lambda b: bool(b.s.tree.children(b.i)) or b.s.ends_in_tip(b.i),
    "with the tip": lambda b: b.s.ends_in_tip(b.i),
}


def _reach(b: BodyValues) -> Vector:
    children = b.s.tree.children(b.i)
    return b.vector(b.s.to_child(b.i, children[0]) if children else b.s.to_tip(b.i))


def _tip_force(b: BodyValues) -> Vector:
    load = tuple(b.s.symbols.ring[name] for name in b.s.load)
    return b.vector(neg(load) if load else b.s.tree.space.zero)


def _no_turn(b: BodyValues) -> Any:
    return b.angular(b.s.tree.space.zero_angular)


def _nothing(b: BodyValues) -> Vector:
    return b.vector(b.s.tree.space.zero)


def _inertia(b: BodyValues) -> Any:
    found = b.s.inertia(b.i)
    return b.element(found) if b.s.planar else tuple(map(b.vector, found))


_FORCE_BEFORE = (
    "This is the reaction, the force of body {n} on body {h}; f{h}{n} is that of body {h} on body "
    "{n}."
)

BODY_QUANTITIES = (
    # ------------------------------------------------------------ how it moves
    BodyQuantity(
        "omega{n}", "the angular velocity of body {n}", lambda b: b.angular(b.motion.w[b.i]),
        units.RATE, angular=True, of_motion=True, shown=True, symbol="omega_i",
    ),
    BodyQuantity(
        "omega{n}_d", "the angular acceleration of body {n}",
        lambda b: b.angular(b.motion.wd[b.i]), units.SECOND, (("alpha{n}", 0),), angular=True,
        of_motion=True, shown=True,
    ),
    BodyQuantity(
        "v{n}", "the velocity of the point of body {n} at joint {n}",
        lambda b: b.axes(b.motion.v[b.i]), units.SPEED, soft=True, of_motion=True, symbol="v_i",
    ),
    BodyQuantity(
        "v{n}_d", "the acceleration of the point of body {n} at joint {n}",
        lambda b: b.axes(b.motion.vd[b.i]), units.ACCELERATION, of_motion=True,
    ),
    BodyQuantity(
        "vc{n}", "the velocity of the centre of mass of body {n}",
        lambda b: b.vector(b.s.centre_velocity(b.i)), units.SPEED,
        (("vG{n}", 0), ("vC{n}", 0), ("rc{n}", 1), ("rG{n}", 1)), of_centre=True, of_motion=True,
        shown=True, symbol="v_ci",
    ),
    BodyQuantity(
        "vc{n}_d", "the acceleration of the centre of mass of body {n}",
        lambda b: b.vector(b.centre_acceleration), units.ACCELERATION,
        (("ac{n}", 0), ("aG{n}", 0), ("vC{n}", 1), ("rc{n}", 2), ("rG{n}", 2)), of_centre=True,
        of_motion=True, shown=True,
    ),
    # ------------------------------------------------------------ where it is
    BodyQuantity(
        "r{n}", "the position of the origin of body {n}", lambda b: b.vector(b.s.world[b.i][1]),
        units.LENGTH, soft=True, own_axes=False, shown=True, framed=("P{n}", "p{n}", "P{n}ORG"),
        is_place=True,
    ),
    BodyQuantity(
        "rc{n}", "the position of the centre of mass of body {n}",
        lambda b: b.vector(b.s.centre_position(b.i)), units.LENGTH, (("rG{n}", 0), ("pc{n}", 0)),
        own_axes=False, of_centre=True, of_motion=True, shown=True,
        framed=("PC{n}", "Pc{n}", "pc{n}", "pC{n}"), is_place=True, symbol="r_ci",
    ),
    BodyQuantity(
        "s{n}", "the vector from joint {n} to the next joint or the tip", _reach, units.LENGTH,
        (("r{h}{n}", 0),), soft=True, only="with an end", symbol="s_i",
    ),
    BodyQuantity(
        "sc{n}", "the vector from joint {n} to the centre of mass of body {n}",
        lambda b: b.vector(b.s.centre(b.i)), units.LENGTH, (("r{h}c{n}", 0),), of_centre=True,
        shown=True, symbol="s_ci",
    ),
    BodyQuantity(
        "r{n}_c{n}", "the vector from the end of body {n} to its centre of mass",
        lambda b: b.vector(sub(b.s.centre(b.i), _reach(b))), units.LENGTH,
        only="with an end", of_centre=True,
    ),
    # ------------------------------------------------------------ forces
    BodyQuantity(
        "f{h}{n}", "the force of body {h} on body {n} at their joint", lambda b: b.vector(b.force),
        units.FORCE, (("F{h}{n}", 0),), kind=REACTION, reaction=_FORCE_BEFORE, shown=True,
        framed=("f{n}",), symbol="f_i,k",
    ),
    *(
        BodyQuantity(
            f"{letter}{{n}}", "the moment of body {h} on body {n} at their joint",
            lambda b: b.angular(b.moment), units.ENERGY, (("n{h}{n}", 0), ("N{h}{n}", 0)),
            reaction="This is the reaction, the moment of body {n} on body {h}.",
            kind=REACTION, angular=True, spaces=(dim,), soft=True, shown=True,
            framed=("n{n}",) * (dim == 2), symbol="n_i,k",
        )
        for letter, dim in (("M", 2), ("n", 3))
    ),
    BodyQuantity(
        "f{n}{h}", "the force of body {n} on body {h} at their joint",
        lambda b: b.vector(neg(b.force)), units.FORCE, (("F{n}{h}", 0),),
        kind=REACTION, reaction="This is f{h}{n}, the force of body {h} on body {n}.",
    ),
    BodyQuantity(
        "n{n}{h}", "the moment of body {n} on body {h} at their joint",
        lambda b: b.angular(neg(b.moment)), units.ENERGY, (("N{n}{h}", 0),),
        kind=REACTION, reaction="This is n{h}{n}, the moment of body {h} on body {n}.",
        angular=True, soft=True,
    ),
    BodyQuantity(
        "fc{n}", "the mass of body {n} times the acceleration of its centre",
        lambda b: b.vector(b.inertia_force), units.FORCE, soft=True, of_centre=True,
        framed=("F{n}",), symbol="f_ci",
    ),
    *(
        BodyQuantity(
            f"{letter}c{{n}}", "the rate of body {n}'s angular momentum about its centre",
            lambda b: b.angular(b.inertia_moment), units.ENERGY, (("nc{n}", 0),) * (dim == 2),
            angular=True, spaces=(dim,), soft=True, of_centre=True, framed=("N{n}",),
            symbol="n_ci",
        )
        for letter, dim in (("M", 2), ("n", 3))
    ),
    BodyQuantity(
        "gravity{n}", "gravity in the axes of body {n}", lambda b: b.vector(b.s.gravity(b.i)),
        units.ACCELERATION, spaces=(3,), symbol="g_i",
    ),
    # ------------------------------------------------------------ what it is
    BodyQuantity(
        "m{n}", "the mass of body {n}", lambda b: b.element(b.s.mass(b.i)), units.MASS,
        kind=MASS_OF_BODY, is_scalar=True, of_centre=True, shown=True,
    ),
    BodyQuantity(
        "I{n}", "the inertia tensor of body {n}", _inertia, units.INERTIA, angular=True,
        matrix="tensor", soft=True, of_centre=True, shown=True,
    ),
    BodyQuantity(
        "T{n}", "the kinetic energy of body {n}", lambda b: Energies(b.s, b.s.motion).kinetic(b.i),
        units.ENERGY, kind=BODY_KINETIC, is_scalar=True,
    ),
    BodyQuantity(
        "V{n}", "the potential energy of body {n}",
        lambda b: Energies(b.s, b.s.motion).potential(b.i), units.ENERGY,
        kind=BODY_POTENTIAL, is_scalar=True,
    ),
    # ------------------------------------------------------------ frames in space
    BodyQuantity(
        "w{n}", "the angular velocity of body {n} in the world's axes",
        lambda b: b.vector(times(b.s.world[b.i][0], b.motion.w[b.i])), units.RATE, spaces=(3,),
        soft=True, own_axes=False,
    ),
    BodyQuantity(
        "z{n}", "the z axis of body {n}",
        lambda b: b.vector(tuple(row[2] for row in b.s.world[b.i][0])), spaces=(3,), soft=True,
        own_axes=False, framed=None,
    ),
    BodyQuantity(
        "p{h}_{n}", "the origin of body {n} in the previous body", lambda b: b.vector(b.joint[1]),
        units.LENGTH, spaces=(3,), soft=True, framed=None,
    ),
    BodyQuantity(
        "p{n}_{h}", "the origin of the previous body in body {n}",
        lambda b: b.vector(neg(times(transposed(b.joint[0]), b.joint[1]))), units.LENGTH,
        spaces=(3,), soft=True, framed=None,
    ),
    BodyQuantity(
        "R{n}", "the orientation of body {n}", lambda b: b.matrix(b.s.world[b.i][0]), spaces=(3,),
        matrix="rotation", soft=True, shown=True,
    ),
    BodyQuantity(
        "R{h}_{n}", "the rotation from body {n} to the previous body",
        lambda b: b.matrix(b.joint[0]), spaces=(3,), matrix="rotation", soft=True, shown=True,
    ),
    BodyQuantity(
        "R{n}_{h}", "the rotation from the previous body to body {n}",
        lambda b: b.matrix(transposed(b.joint[0])), spaces=(3,), matrix="rotation", soft=True,
        shown=True,
    ),
    # ------------------------------------------------------------ the ground and the tip
    BodyQuantity(
        "v{h}", "the velocity of the ground", _nothing, units.SPEED, soft=True, only="first",
    ),
    BodyQuantity(
        "v{h}_d", "the acceleration of the ground", lambda b: b.vector(b.start),
        units.ACCELERATION, only="first",
    ),
    BodyQuantity(
        "s{h}", "the vector from the world's origin to the first joint",
        lambda b: b.vector(b.joint[1]), units.LENGTH, only="first",
    ),
    BodyQuantity(
        "omega{h}", "the angular velocity of the ground", _no_turn, units.RATE, angular=True,
        only="first",
    ),
    BodyQuantity(
        "omega{h}_d", "the angular acceleration of the ground", _no_turn, units.SECOND,
        angular=True, only="first",
    ),
    BodyQuantity(
        "w{h}", "the angular velocity of the ground", _nothing, units.RATE, spaces=(3,),
        only="first",
    ),
    BodyQuantity(
        "R{h}", "the ground's orientation", lambda b: _EYE, spaces=(3,), matrix="rotation",
        only="first",
    ),
    BodyQuantity(
        "f{n}{k}", "the force that the tip exerts", _tip_force, units.FORCE, kind=REACTION,
        only="last",
    ),
    BodyQuantity(
        "M{k}", "the moment that the tip exerts", _no_turn, units.ENERGY, kind=REACTION,
        angular=True, spaces=(2,), soft=True, only="last",
    ),
    BodyQuantity(
        "n{k}", "the moment that the tip exerts", _no_turn, units.ENERGY, kind=REACTION,
        spaces=(3,), only="last",
    ),
    BodyQuantity(
        "R{n}_{k}", "the rotation from the tip to body {n}", lambda b: _EYE, spaces=(3,),
        matrix="rotation", only="with the tip",
    ),
    BodyQuantity(
        "p{n}_{k}", "the tip in body {n}", lambda b: b.vector(b.s.to_tip(b.i)), units.LENGTH,
        spaces=(3,), soft=True, only="with the tip", framed=None,
    ),
)  # fmt: skip

BY_NAME = {record.known: record for record in BODY_QUANTITIES}


def meanings(s: Setting, *known: str) -> Iterator[Meaning]:
    """Glossary entries, for a planar or spatial robot, of the quantities of bodies with the names
    `known`."""
    for name in known:
        yield BY_NAME[name].meaning(s.planar)


def soft_names(count: int) -> frozenset[str]:
    """Names of vectors of an arm's bodies that users often give to their own quantities."""
    soft = (record for record in BODY_QUANTITIES if record.soft)
    return frozenset(
        name for record in soft for n in range(1, count + 1) for name in record.spelt(n)
    )
