"""What may have been thought about a planar arm: other lengths, other axes, other angles."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from freebody.derivations.check.algebra.finite_field import Turn
from freebody.derivations.check.reasons.thoughts import Thought, Thoughts
from freebody.derivations.expressions.printed_names import sym
from freebody.scalars.trig import Trig

_ZEROS = {1: "the vertical (upwards)", 3: "the vertical (downwards)", 0: "the x axis"}
"""Where angles are 0, by the right angles from the x axis."""
_QUARTERS: Mapping[int, Turn] = {1: (1, 0), 2: (0, -1), 3: (-1, 0)}
"""Sines and cosines of right angles."""


@dataclass(frozen=True)
class PlanarThoughts(Thoughts):
    """Thoughts about lengths, parallel axes and angles."""

    def lengths(self) -> Iterator[Thought]:
        """Lengths of links for the distances of their centres of mass, and parallel axes."""
        v = self.point.values
        links = [k for k in self.links("lc{}") if f"l{k}" in self.setting.ring.index]
        both = set(self.links("l{}"))
        for group in [links, *([k] for k in links)] if len(links) > 1 else [links] * bool(links):
            which = " and ".join(f"lc{k}" for k in group)
            wrong = ", ".join(f"l{k} for lc{k}" for k in group)
            yield (
                f"You wrote {wrong}: masses and weights act at the centre of mass, {which} from "
                "the joint, not at the end of the link.",
                self.at({f"lc{k}": v[f"l{k}"] for k in group}),
            )
            half = self.point.number(Fraction(1, 2))
            yield (
                "This is right only if the centre of mass is at the midpoint of the link, "
                f"{', '.join(f'lc{k} = l{k}/2' for k in group)}.",
                self.at({f"lc{k}": v[f"l{k}"] * half for k in group}),
            )
            if both >= set(group):
                yield (
                    f"l and lc are swapped: l{group[0]} is the length of the link, lc{group[0]} "
                    f"the distance from its joint to the centre of mass.",
                    self.at(
                        {
                            x: v[y]
                            for k in group
                            for x, y in ((f"lc{k}", f"l{k}"), (f"l{k}", f"lc{k}"))
                        }
                    ),
                )
        yield from self._axes(v)

    def _axes(self, v: Mapping[str, int]) -> Iterator[Thought]:
        """Moments of inertia about the joint for those about the centre of mass."""
        ring = self.setting.ring.index
        links = [k for k in self.links("I{}") if f"m{k}" in ring and f"lc{k}" in ring]
        for group in [links, *([k] for k in links)] if len(links) > 1 else [links] * bool(links):
            steiner = {k: v[f"m{k}"] * v[f"lc{k}"] ** 2 for k in group}
            names, lacking = (
                " and ".join(f"I{k}" for k in group),
                " and ".join(f"m{k} lc{k}²" for k in group),
            )
            yield (
                "The parallel-axis theorem is missing: this would be right for moments of inertia "
                f"about the joints; here {names} {'is' if len(group) == 1 else 'are'} about the "
                f"centre of mass, and {lacking} must be added.",
                self.at({f"I{k}": v[f"I{k}"] - x for k, x in steiner.items()}),
            )
            yield (
                f"The parallel-axis term {lacking} is counted twice.",
                self.at({f"I{k}": v[f"I{k}"] + x for k, x in steiner.items()}),
            )

    # ------------------------------------------------------------ angles
    def angles(self) -> Iterator[Thought]:
        """Angles from the vertical, or from the x axis."""
        turning = [x for x in self.setting.symbols.coordinates if x.startswith("theta")]
        if not turning:
            return
        first = turning[0]
        coordinates = list(self.setting.symbols.coordinates)
        own = ([*self.setting.quarters, *[0] * len(coordinates)])[coordinates.index(first)] % 4
        for other in (x for x in _ZEROS if x != own):
            text = (
                f"This would be right if {sym(first)} were measured from {_ZEROS[other]}; here it "
                f"is measured from {_ZEROS.get(own, 'elsewhere')}."
            )
            quarter = _QUARTERS[(other - own) % 4]
            yield text, self.at(turns={first: self.point.plus(self.point.turns[first], quarter)})
        if len(turning) > 1:
            yield from self._absolute(turning)

    def _absolute(self, turning: list[str]) -> Iterator[Thought]:
        """Angles from the x axis for angles from the link before."""
        values, turns = dict(self.point.values), dict(self.point.turns)
        for before, x in pairwise(turning):
            s, c = self.point.turns[before]
            turns[x] = self.point.plus(self.point.turns[x], (-s, c))
            for ending in ("_d", "_dd"):
                values[x + ending] = (
                    self.point.values[x + ending] - self.point.values[before + ending]
                )
        names = ", ".join(str(sym(x)) for x in turning[1:])
        text = (
            f"This would be right if {names} were measured from the x axis; here each angle is "
            "measured from the previous link, so the direction of a link is a sum of angles."
        )
        yield text, self.point.changed(turns=turns).of(self.right)
        moved = self.point.changed(values, turns)
        yield text, moved.of(self.right)
        if len(turning) == len(self.setting.symbols.coordinates):
            yield text, sum(sign * moved.of(x) for sign, x in self._combined())

    def _combined(self) -> Iterator[tuple[int, Trig]]:
        """The quantity in coordinates φ_k = θ_1 + … + θ_k: τ_k - τ_{k+1}, and so M."""
        if not self.target.kind.turns_with_coordinates:
            yield 1, self.right
            return
        letter = self.target.kind.usual
        rows: list[tuple[int, tuple[int, ...]]] = [(1, ())]
        for i in self.target.index:
            rows = [(s * t, (*index, k)) for s, index in rows for t, k in ((1, i), (-1, i + 1))]
        for sign, index in rows:
            name = letter + "".join(map(str, index))
            if name in self.targets.single:
                yield sign, self.targets.single[name].polynomial()
