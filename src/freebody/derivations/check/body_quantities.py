"""The quantities of bodies that `fb.quantities` tells and `check` checks, one record each."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from freebody.derivations.check.vocabulary import spellings


@dataclass(frozen=True)
class BodyQuantity:
    """One quantity of body n; h is the number of the body before, k that of the one behind."""

    known: str
    """Its name in `fb.quantities`."""
    names: tuple[tuple[str, int], ...]
    """Names in answers, in plain spelling, and how many dots they have."""
    title: str
    angular: bool = False
    """Whether it is one number in the plane."""
    spaces: tuple[int, ...] = (2, 3)
    turns: bool = False
    """Whether it is a matrix of rotation."""
    soft: bool = False
    """Whether the name is often one of the user's own: one number is not read as this vector."""
    own_axes: bool = True
    """Whether it is a vector that in space has the axes of its own body."""
    reaction: str = ""
    """What is said of its negative."""
    only: str = ""
    """"first" of what belongs to the ground, "last" of what belongs to the tip."""

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
        return at_end and dim in self.spaces

    def axes(self, dim: int) -> str:
        """Of a vector "xy" or "xyz", of one number ""."""
        return "" if self.angular and dim == 2 else "xyz"[:dim]


_OF_MOTION = ("omega{n}", "omega{n}_d", "vc{n}", "vc{n}_d", "rc{n}")


def numbers(n: int) -> dict[str, int]:
    """What the letters in names of body n's quantities stand for."""
    return {"h": n - 1, "n": n, "k": n + 1}


BODY_QUANTITIES = (
    BodyQuantity("omega{n}", (("omega{n}", 0),), "the angular velocity of body {n}", angular=True),
    BodyQuantity(
        "omega{n}_d", (("omega{n}", 1),), "the angular acceleration of body {n}", angular=True
    ),
    BodyQuantity("v{n}", (("v{n}", 0),), "the velocity of the origin of body {n}", soft=True),
    BodyQuantity("v{n}_d", (("v{n}", 1),), "the acceleration of the origin of body {n}"),
    BodyQuantity(
        "vc{n}",
        (("vc{n}", 0), ("vG{n}", 0), ("rc{n}", 1), ("rG{n}", 1)),
        "the velocity of the centre of mass of body {n}",
    ),
    BodyQuantity(
        "vc{n}_d",
        (("vc{n}", 1), ("ac{n}", 0), ("aG{n}", 0), ("rc{n}", 2), ("rG{n}", 2)),
        "the acceleration of the centre of mass of body {n}",
    ),
    BodyQuantity(
        "r{n}", (("r{n}", 0),), "the position of the origin of body {n}", own_axes=False, soft=True
    ),
    BodyQuantity(
        "rc{n}",
        (("rc{n}", 0), ("rG{n}", 0), ("pc{n}", 0)),
        "the centre of mass of body {n}",
        own_axes=False,
    ),
    BodyQuantity("s{n}", (("s{n}", 0),), "the vector along body {n}", soft=True),
    BodyQuantity("sc{n}", (("sc{n}", 0),), "the vector to the centre of mass of body {n}"),
    BodyQuantity(
        "f{h}{n}",
        (("f{h}{n}", 0), ("F{h}{n}", 0)),
        "the force on body {n} at its joint",
        reaction="This is the reaction, the force of body {n} on body {h}; f{h}{n} is that of body "
        "{h} on body {n}.",
    ),
    BodyQuantity(
        "M{n}",
        (("M{n}", 0), ("n{h}{n}", 0)),
        "the moment on body {n} at its joint",
        reaction="This is the reaction, the moment of body {n} on body {h}.",
        angular=True,
        spaces=(2,),
        soft=True,
    ),
    BodyQuantity(
        "n{n}",
        (("n{n}", 0), ("n{h}{n}", 0)),
        "the moment on body {n} at its joint",
        reaction="This is the reaction, the moment of body {n} on body {h}.",
        spaces=(3,),
        soft=True,
    ),
    BodyQuantity("fc{n}", (("fc{n}", 0),), "mass times acceleration of body {n}", soft=True),
    BodyQuantity(
        "Mc{n}",
        (("Mc{n}", 0), ("nc{n}", 0)),
        "the rate of spin of body {n}",
        angular=True,
        spaces=(2,),
        soft=True,
    ),
    BodyQuantity("nc{n}", (("nc{n}", 0),), "the rate of spin of body {n}", spaces=(3,), soft=True),
    BodyQuantity(
        "gravity{n}", (("gravity{n}", 0),), "gravity in the axes of body {n}", spaces=(3,)
    ),
    BodyQuantity(
        "w{n}",
        (("w{n}", 0),),
        "the angular velocity of body {n} in the world's axes",
        own_axes=False,
        spaces=(3,),
        soft=True,
    ),
    BodyQuantity(
        "z{n}", (("z{n}", 0),), "the z axis of body {n}", own_axes=False, spaces=(3,), soft=True
    ),
    BodyQuantity(
        "p{h}_{n}",
        (("p{h}{n}", 0),),
        "the origin of body {n} in the body before",
        spaces=(3,),
        soft=True,
    ),
    BodyQuantity(
        "p{n}_{h}",
        (("p{n}{h}", 0),),
        "the origin of the body before in body {n}",
        spaces=(3,),
        soft=True,
    ),
    BodyQuantity(
        "R{n}", (("R{n}", 0),), "the orientation of body {n}", spaces=(3,), turns=True, soft=True
    ),
    BodyQuantity(
        "R{h}_{n}",
        (("R{h}{n}", 0),),
        "the rotation from body {n} to the body before",
        spaces=(3,),
        turns=True,
        soft=True,
    ),
    BodyQuantity(
        "R{n}_{h}",
        (("R{n}{h}", 0),),
        "the rotation from the body before to body {n}",
        spaces=(3,),
        turns=True,
        soft=True,
    ),
    BodyQuantity(
        "I{n}",
        (("I{n}", 0),),
        "the inertia tensor of body {n}",
        spaces=(3,),
        turns=True,
        soft=True,
    ),
    BodyQuantity("v{h}", (("v{h}", 0),), "the velocity of the ground", soft=True, only="first"),
    BodyQuantity("v{h}_d", (("v{h}", 1),), "the acceleration of the ground", only="first"),
    BodyQuantity("s{h}", (("s{h}", 0),), "from the world to the first joint", only="first"),
    BodyQuantity(
        "omega{h}",
        (("omega{h}", 0),),
        "the angular velocity of the ground",
        angular=True,
        only="first",
    ),
    BodyQuantity(
        "omega{h}_d",
        (("omega{h}", 1),),
        "the angular acceleration of the ground",
        angular=True,
        only="first",
    ),
    BodyQuantity(
        "w{h}", (("w{h}", 0),), "the angular velocity of the ground", spaces=(3,), only="first"
    ),
    BodyQuantity(
        "R{h}", (("R{h}", 0),), "the ground's orientation", spaces=(3,), turns=True, only="first"
    ),
    BodyQuantity("f{n}{k}", (("f{n}{k}", 0),), "the force that the tip exerts", only="last"),
    BodyQuantity(
        "M{k}",
        (("M{k}", 0),),
        "the moment that the tip exerts",
        angular=True,
        spaces=(2,),
        soft=True,
        only="last",
    ),
    BodyQuantity(
        "n{k}", (("n{k}", 0),), "the moment that the tip exerts", spaces=(3,), only="last"
    ),
    BodyQuantity(
        "R{n}_{k}",
        (("R{n}{k}", 0),),
        "the rotation from the tip to body {n}",
        spaces=(3,),
        turns=True,
        only="last",
    ),
    BodyQuantity(
        "p{n}_{k}", (("p{n}{k}", 0),), "the tip in body {n}", spaces=(3,), soft=True, only="last"
    ),
)


def soft_names(count: int) -> frozenset[str]:
    """Names of vectors of an arm's bodies that users often give to things of their own."""
    soft = (record for record in BODY_QUANTITIES if record.soft)
    return frozenset(
        name for record in soft for n in range(1, count + 1) for name in record.spelt(n)
    )
