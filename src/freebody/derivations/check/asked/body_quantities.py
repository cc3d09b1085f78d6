"""The quantities of bodies that `fb.quantities` tells and `check` checks, one record each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from freebody.derivations.check.asked.dotted_names import spellings


@dataclass(frozen=True)
class BodyQuantity:
    """One quantity of body n; h is the number of the body before, k that of the one behind."""

    known: str
    """Its name in `fb.quantities`."""
    title: str
    also: tuple[tuple[str, int], ...] = ()
    """Further names in answers, in plain spelling, and how many dots they have."""
    angular: bool = False
    """Whether it is one number in the plane."""
    spaces: tuple[int, ...] = (2, 3)
    turns: bool = False
    """Whether it is a matrix of rotation or inertia, which only bodies in space have."""
    soft: bool = False
    """Whether the name is often one of the user's own: one number is not read as this vector."""
    own_axes: bool = True
    """Whether it is a vector that in space has the axes of its own body."""
    reaction: str = ""
    """What is said of its negative."""
    only: str = ""
    """"first" of what belongs to the ground, "last" of what belongs to the tip."""

    @property
    def names(self) -> tuple[tuple[str, int], ...]:
        """All names in answers, its own first: that of `fb.quantities` without its underscores."""
        plain = self.known.removesuffix("_d")
        return (plain.replace("_", ""), int(plain != self.known)), *self.also

    def spelt(self, n: int) -> Iterator[str]:
        """The names of body n's."""
        for name, dots in self.names:
            letter, _, ending = name.partition("{")
            yield from spellings(letter, ("{" + ending).format(**numbers(n)), dots)

    @property
    def of_centre(self) -> bool:
        """Whether it is of the centre of mass; of bodies joined into one that is a fraction."""
        return "c{" in self.known or self.known == "I{n}"

    @property
    def of_motion(self) -> bool:
        """Whether it is told of bodies of trees and closed chains too: what moves a body alone."""
        return self.known in _OF_MOTION

    def exists(self, n: int, count: int, dim: int) -> bool:
        """Whether body n of an arm of `count` bodies has it."""
        at_end = {"first": n == 1, "last": n == count, "": True}[self.only]
        return at_end and dim in self.spaces and (dim == 3 or not self.turns)

    def axes(self, dim: int) -> str:
        """Of a vector "xy" or "xyz", of one number ""."""
        return "" if self.angular and dim == 2 else "xyz"[:dim]


_OF_MOTION = ("omega{n}", "omega{n}_d", "vc{n}", "vc{n}_d", "rc{n}")


def numbers(n: int) -> dict[str, int]:
    """What the letters in names of body n's quantities stand for."""
    return {"h": n - 1, "n": n, "k": n + 1}


BODY_QUANTITIES = (
    BodyQuantity("omega{n}", "the angular velocity of body {n}", angular=True),
    BodyQuantity(
        "omega{n}_d", "the angular acceleration of body {n}", also=(("alpha{n}", 0),), angular=True
    ),
    BodyQuantity("v{n}", "the velocity of the origin of body {n}", soft=True),
    BodyQuantity("v{n}_d", "the acceleration of the origin of body {n}"),
    BodyQuantity(
        "vc{n}",
        "the velocity of the centre of mass of body {n}",
        also=(("vG{n}", 0), ("vC{n}", 0), ("rc{n}", 1), ("rG{n}", 1)),
    ),
    BodyQuantity(
        "vc{n}_d",
        "the acceleration of the centre of mass of body {n}",
        also=(("ac{n}", 0), ("aG{n}", 0), ("vC{n}", 1), ("rc{n}", 2), ("rG{n}", 2)),
    ),
    BodyQuantity("r{n}", "the position of the origin of body {n}", soft=True, own_axes=False),
    BodyQuantity(
        "rc{n}", "the centre of mass of body {n}", also=(("rG{n}", 0), ("pc{n}", 0)), own_axes=False
    ),
    BodyQuantity("s{n}", "the vector along body {n}", also=(("r{h}{n}", 0),), soft=True),
    BodyQuantity("sc{n}", "the vector to the centre of mass of body {n}", also=(("r{h}c{n}", 0),)),
    BodyQuantity(
        "f{h}{n}",
        "the force on body {n} at its joint",
        also=(("F{h}{n}", 0),),
        reaction="This is the reaction, the force of body {n} on body {h}; f{h}{n} is that of body "
        "{h} on body {n}.",
    ),
    BodyQuantity(
        "M{n}",
        "the moment on body {n} at its joint",
        also=(("n{h}{n}", 0), ("N{h}{n}", 0)),
        reaction="This is the reaction, the moment of body {n} on body {h}.",
        angular=True,
        spaces=(2,),
        soft=True,
    ),
    BodyQuantity(
        "n{n}",
        "the moment on body {n} at its joint",
        also=(("n{h}{n}", 0), ("N{h}{n}", 0)),
        reaction="This is the reaction, the moment of body {n} on body {h}.",
        spaces=(3,),
        soft=True,
    ),
    BodyQuantity("fc{n}", "mass times acceleration of body {n}", soft=True),
    BodyQuantity(
        "Mc{n}",
        "the rate of angular momentum of body {n}",
        also=(("nc{n}", 0),),
        angular=True,
        spaces=(2,),
        soft=True,
    ),
    BodyQuantity("nc{n}", "the rate of angular momentum of body {n}", spaces=(3,), soft=True),
    BodyQuantity("gravity{n}", "gravity in the axes of body {n}", spaces=(3,)),
    BodyQuantity(
        "w{n}",
        "the angular velocity of body {n} in the world's axes",
        spaces=(3,),
        soft=True,
        own_axes=False,
    ),
    BodyQuantity("z{n}", "the z axis of body {n}", spaces=(3,), soft=True, own_axes=False),
    BodyQuantity("p{h}_{n}", "the origin of body {n} in the previous body", spaces=(3,), soft=True),
    BodyQuantity("p{n}_{h}", "the origin of the previous body in body {n}", spaces=(3,), soft=True),
    BodyQuantity("R{n}", "the orientation of body {n}", turns=True, soft=True),
    BodyQuantity(
        "R{h}_{n}", "the rotation from body {n} to the previous body", turns=True, soft=True
    ),
    BodyQuantity(
        "R{n}_{h}", "the rotation from the previous body to body {n}", turns=True, soft=True
    ),
    BodyQuantity("I{n}", "the inertia tensor of body {n}", turns=True, soft=True),
    BodyQuantity("v{h}", "the velocity of the ground", soft=True, only="first"),
    BodyQuantity("v{h}_d", "the acceleration of the ground", only="first"),
    BodyQuantity("s{h}", "the vector from the world's origin to the first joint", only="first"),
    BodyQuantity("omega{h}", "the angular velocity of the ground", angular=True, only="first"),
    BodyQuantity(
        "omega{h}_d", "the angular acceleration of the ground", angular=True, only="first"
    ),
    BodyQuantity("w{h}", "the angular velocity of the ground", spaces=(3,), only="first"),
    BodyQuantity("R{h}", "the ground's orientation", turns=True, only="first"),
    BodyQuantity("f{n}{k}", "the force that the tip exerts", only="last"),
    BodyQuantity(
        "M{k}", "the moment that the tip exerts", angular=True, spaces=(2,), soft=True, only="last"
    ),
    BodyQuantity("n{k}", "the moment that the tip exerts", spaces=(3,), only="last"),
    BodyQuantity("R{n}_{k}", "the rotation from the tip to body {n}", turns=True, only="last"),
    BodyQuantity("p{n}_{k}", "the tip in body {n}", spaces=(3,), soft=True, only="last"),
)


def soft_names(count: int) -> frozenset[str]:
    """Names of vectors of an arm's bodies that users often give to things of their own."""
    soft = (record for record in BODY_QUANTITIES if record.soft)
    return frozenset(
        name for record in soft for n in range(1, count + 1) for name in record.spelt(n)
    )
