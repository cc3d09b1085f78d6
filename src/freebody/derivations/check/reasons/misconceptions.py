"""What a user may have thought: a single misconception that explains the whole difference.

Each is the right answer under that thought, at a point of a finite field, to be compared with the
user's.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from freebody.derivations.check.asked.asked_quantities import Targets
from freebody.derivations.check.asked.quantity import AskedQuantity
from freebody.derivations.check.reasons.planar_thoughts import PlanarThoughts
from freebody.derivations.check.reasons.thoughts import Thought
from freebody.derivations.expressions.printed_names import sym
from freebody.derivations.grammar.atoms import atom
from freebody.derivations.grammar.parser import PI
from freebody.derivations.grammar.tables.characters import DOT
from freebody.model.gravity import axis_of
from freebody.scalars.trig import Trig

_RIGHT_BESIDES = "; everything else is right."
_BY_PART: tuple[tuple[tuple[str, ...], int | Fraction, str], ...] = (
    (
        ("coriolis",),
        Fraction(1, 2),
        "Only a factor of 2 is missing: a product of two different rates, θ̇ᵢ θ̇ⱼ, occurs twice (as "
        "ij and as ji), so Coriolis terms have a factor of 2.",
    ),
    (
        ("coriolis",),
        0,
        "The Coriolis terms, with products of two different rates, are missing.",
    ),
    (("centrifugal",), 0, "The centrifugal terms, with squares of rates, are missing."),
    (
        ("coriolis", "centrifugal"),
        0,
        f"The Coriolis and centrifugal terms are missing{_RIGHT_BESIDES}",
    ),
    (
        ("coriolis", "centrifugal"),
        -1,
        f"All Coriolis and centrifugal terms have the wrong sign{_RIGHT_BESIDES}",
    ),
    (("friction",), 0, f"Friction is missing{_RIGHT_BESIDES}"),
    (
        ("friction",),
        -1,
        f"All friction terms have the wrong sign: the drive must overcome friction{_RIGHT_BESIDES}",
    ),
)
"""Parts of a torque (`_part`), what they are multiplied with under a thought, and the thought."""


@dataclass(frozen=True)
class Misconceptions(PlanarThoughts):
    """The thoughts that are tried for one quantity."""

    def explaining(self, value: Any) -> list[str]:
        """The thoughts under which the right answer is the user's."""
        if value == 0:  # of many parts it would be right that they are missing
            return []
        found = [text for text, result in self.all() if self.point.agree(result, value)]
        return list(dict.fromkeys(found))[:2]

    def all(self) -> Iterator[Thought]:
        """The thoughts, the likeliest first."""
        yield from ((text, self.point.of(value())) for text, value in self.target.thoughts)
        yield from self._others()
        yield from self._gravity()
        yield from self._velocity()
        yield from self._inertia()
        yield from self._degrees()
        if self.setting.is_planar:
            yield from self.lengths()
            yield from self.angles()

    def _others(self) -> Iterator[Thought]:
        """Another quantity of the same family."""
        for name, other in related(self.targets, self.target).items():
            text = f"What you wrote is right for {name.replace('tau', 'τ')}, not for this one."
            yield text, self.point.of(other)

    def _gravity(self) -> Iterator[Thought]:
        g = self.setting.order.gravity
        if not g or not any(g in powers for powers, _ in self.right.terms()):
            return
        axis = axis_of(self.setting.symbols.model.gravity_direction)
        energy = "the weights' potential energy is V = − m g · r, with the vector g"
        if axis:
            pull, rise = ("−", "+") if axis[0] == "-" else ("+", "−")
            energy = f"weights act along {pull}{axis[1]}, so V = {rise} m g {axis[1]}"
        opposite = (
            f"Only the sign of gravity is wrong: {energy}, and the drives must support them: "
            "g_i = + ∂V/∂q_i."
        )
        yield opposite, self.scaled(-1, lambda p: g in p)
        yield f"Gravity is missing{_RIGHT_BESIDES}", self.scaled(0, lambda p: g in p)

    def _velocity(self) -> Iterator[Thought]:
        """Mistakes in all terms with products of rates, and friction left out."""
        if self.target.family not in ("tau", "c"):
            return
        there = {_part(powers) for powers, _ in self.right.terms()}
        for parts, factor, text in _BY_PART:
            if there & set(parts):
                yield text, self.scaled(factor, lambda p, own=parts: _part(p) in own)

    def _inertia(self) -> Iterator[Thought]:
        """Bodies and accelerations left out."""
        own = self.target.index[0] - 1 if self.target.family == "tau" else None
        if own is not None:
            for name in self.setting.symbols.coordinates:
                missing = f"The terms with {sym(name + '_dd')} are missing{_RIGHT_BESIDES}"
                yield missing, self.scaled(0, lambda p, x=name + "_dd": x in p)
        inertial = self.setting.order.inertial
        bodies = {body for body, _ in inertial.values()}
        for body in bodies if len(bodies) > 1 else ():
            names = {name for name, (i, _) in inertial.items() if i == body}
            link = self.setting.symbols.model.bodies[body].name
            text = (
                f"Every term with the mass or the moment of inertia of {link} is missing; the "
                f"rest is right."
            )
            yield text, self.scaled(0, lambda p, own=names: bool(own & set(p)))
        moments = {name for name, (_, kind) in inertial.items() if kind == 1}
        yield (
            "The moments of inertia about the centres of mass are missing: right for point masses "
            "only.",
            self.scaled(0, lambda p: bool(moments & set(p))),
        )
        if self.setting.is_planar:
            yield from self._own_rates()

    def _own_rates(self) -> Iterator[Thought]:
        """ω_k = θ̇_k for θ̇_1 + … + θ̇_k."""
        for k in range(2, self.setting.joints + 1):
            if f"I{k}" not in self.setting.ring.index:
                continue

            def left_out(powers: Mapping[str, int], k: int = k) -> bool:
                moving = {x for x in powers if atom(x).dots}
                own = moving <= {f"theta{k}_d", f"theta{k}_dd"} and self._is_own(k)
                return f"I{k}" in powers and not own

            text = (
                f"This is right for ω{k} = θ̇{k}. The rate θ̇{k} is relative to the previous "
                f"link: the angular velocity of link {k} is ω{k} = θ̇1 + … + θ̇{k}."
            )
            yield text, self.scaled(0, left_out)

    def _is_own(self, k: int) -> bool:
        """Whether the quantity belongs to joint k alone."""
        return set(self.target.index) <= {k}

    def _degrees(self) -> Iterator[Thought]:
        """A derivative by an angle in degrees, or a rate in them."""
        own = self.point.of(self.right)
        text = "Angles and rates are in radians: a factor π/180 too many, or one too few."
        yield text, own * self.point.number(PI / 180)
        yield text, own * self.point.number(180 / PI)


def related(targets: Targets, target: AskedQuantity) -> dict[str, Trig]:
    """The other entries of a quantity's family, by name."""
    letter = {"tau": "tau", "M": "H", "c": "v", "g": "G", "J": "J"}.get(target.family)
    others = [
        (name, other)
        for name, other in targets.single.items()
        if letter and other.family == target.family and other.index != target.index
    ]
    usual = [row for row in others if row[0].startswith(letter or "")]
    found: dict[str, Trig] = {}
    seen = set()
    for name, other in usual or others:
        if other.index not in seen:
            seen.add(other.index)
            found[name] = other.polynomial()
    return found or _of_the_same_table(targets, target)


def _of_the_same_table(targets: Targets, target: AskedQuantity) -> dict[str, Trig]:
    """The other entries of a matrix, such as an orientation."""
    if len(target.index) != 2 or not target.words:
        return {}
    for name, table in targets.tables.items():
        entries = {entry.index: entry for row in table for entry in row}
        own = entries.get(target.index)
        if own is not None and own.words == target.words:
            bare = name.lstrip(DOT)
            dots = "\u0307" * (len(name) - len(bare))
            shown = bare[:1] + dots + bare[1:]
            others = (entry for index, entry in entries.items() if index != target.index)
            return {f"{shown} {x.index[0]}, {x.index[1]}": x.polynomial() for x in others}
    return {}


def _part(powers: Mapping[str, int]) -> str:
    """What a term of a torque is by its first rates: of second degree "coriolis" or "centrifugal",
    of first degree, or with a rate's sign, "friction", else ""."""
    if any(x.startswith("sgn_") for x in powers):
        return "friction"
    rates = {x: k for x, k in powers.items() if x.endswith("_d")}
    if sum(rates.values()) == 1:
        return "friction"
    return "coriolis" if len(rates) > 1 else "centrifugal" if rates else ""
