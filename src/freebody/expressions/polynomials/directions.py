"""A vector of the plane as parts along directions that turn: (-l₁ θ̇₁ sin θ₁, l₁ θ̇₁ cos θ₁) is
l₁ θ̇₁ across the direction θ₁."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.angle_sums import Monomial, gathered, raw
from freebody.expressions.polynomials.textbook_form import Layout, function
from freebody.scalars.trig import Trig


@dataclass(frozen=True)
class Directed:
    """along · (cos φ, sin φ) + across · (-sin φ, cos φ); angle: φ as multiples of coordinates, ()
    of the x axis."""

    angle: Monomial
    along: Trig
    across: Trig

    @property
    def square(self) -> Trig:
        """The square of its length."""
        return self.along * self.along + self.across * self.across


def directed(layout: Layout, vector: Sequence[Trig]) -> list[Directed]:
    """The parts of a vector by their angles, inner ones first; none where it does not consist of
    such parts."""
    symbols, angles = layout.symbols, layout.order.angles
    parts: defaultdict[Monomial, list[dict[str, Trig]]] = defaultdict(lambda: [{}, {}])
    for k, component in enumerate(vector):
        for (monomial, wave), coefficient in gathered(raw(component), angles, (angles,)).items():
            ((name, angle, exponent),) = wave or (("cos", (), 1),)
            assert exponent == 1, "products were gathered"
            term = symbols.ring.polynomial([(dict(monomial), coefficient)])
            row = parts[angle][k]
            row[name] = row.get(name, symbols.zero()) + term
    found = []
    for angle, (x, y) in parts.items():
        one = _turned(
            angle, *(row.get(f, symbols.zero()) for row in (x, y) for f in ("cos", "sin"))
        )
        if one is None:
            return []
        found.append(one)
    return sorted(found, key=lambda part: len(part.angle))


def _turned(angle: Monomial, xc: Trig, xs: Trig, yc: Trig, ys: Trig) -> Directed | None:
    """The part whose components are xc cos φ + xs sin φ and yc cos φ + ys sin φ."""
    if not angle or (xc == ys and xs == -yc):
        return Directed(angle, xc, yc)
    if xc == -ys and xs == yc:  # it turns the other way
        return Directed(tuple((x, -k) for x, k in angle), xc, yc)
    return None


def _both(one: Directed, other: Directed, names: tuple[str, str]) -> Expression:
    """A product of functions of the two angles, such as cos φ₁ sin φ₂."""
    return ex.mul(*(_wave(f, x.angle) for f, x in zip(names, (one, other), strict=True)))


def _wave(name: str, angle: Monomial) -> Expression:
    if not angle:
        return ex.ONE if name == "cos" else ex.ZERO
    return function(name, angle, 1)


def cosine(one: Directed, other: Directed) -> Expression:
    """cos φ₁ cos φ₂ + sin φ₁ sin φ₂, which is cos(φ₂ - φ₁)."""
    return ex.add(_both(one, other, ("cos", "cos")), _both(one, other, ("sin", "sin")))


def sine(one: Directed, other: Directed) -> Expression:
    """cos φ₁ sin φ₂ - sin φ₁ cos φ₂, which is sin(φ₂ - φ₁)."""
    return ex.sub(_both(one, other, ("cos", "sin")), _both(one, other, ("sin", "cos")))
