"""Recursion in modular form: each line uses the names of earlier results, so that it contains the
numbers and coordinate of only one joint.

The recursion is run over polynomials in the components of its own vectors: each vector, once
computed, is kept, and what follows from it is given names for its components.
"""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import Self

from freebody.algorithms.kinematics import BodyMotions
from freebody.algorithms.rnea import Recursion, rnea
from freebody.elementary import Scalar
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, Symbol
from freebody.expressions.polynomials.symbols import symbols
from freebody.expressions.polynomials.textbook_form import Layout, Poly, starts_with_minus
from freebody.expressions.printed_names import component, sym, vec
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting

_LETTERS = {
    "w": ("omega", ""),
    "wd": ("omega", "_d"),
    "v": ("v", ""),
    "vd": ("v", "_d"),
    "vd_com": ("vc", "_d"),
    "F": ("fc", ""),
    "N": ("nc", ""),
    "field": ("g", ""),
}
"""Letter and dots of the vectors of one body, by their names in the recursion."""
_BETWEEN = ("f", "n")
"""The vectors that have the number of the body before, too."""
AXES = "xyz"


@dataclass(frozen=True)
class _NamedLayout(Layout):
    """The layout for printing polynomials whose symbols include components of vectors."""

    names: tuple[tuple[str, Symbol], ...] = ()

    @cached_property
    def _symbol_of(self) -> dict[str, Symbol]:
        return dict(self.names)

    def symbol(self, name: str) -> Expression:
        """Symbol of a vector component as in the lines of the vector; other generators as usual."""
        return self._symbol_of.get(name) or super().symbol(name)

    @cached_property
    def _waves(self) -> dict[str, Expression]:
        """The sines and cosines by their generators."""
        ring = self.symbols.ring
        made = (f(sym(x)) for x in ring.angles for f in (ex.sin, ex.cos))
        return dict(zip(ring.index, made, strict=False))

    def form(self, x: Trig) -> Expression:
        """A polynomial printed as sums of components and rates with the joint's numbers in front;
        factors of a sine or cosine in brackets before it."""
        by_wave: dict[tuple, dict[tuple, Poly]] = {}
        for powers, coefficient in x.terms():
            wave = tuple((n, e) for n, e in powers.items() if n in self._waves)
            moving = tuple((n, e) for n, e in powers.items() if n in self.order.moving)
            rest = tuple(item for item in powers.items() if item not in (*wave, *moving))
            turned = by_wave.setdefault(wave, {}).setdefault(moving, {})
            turned[rest] = coefficient
        return ex.add(*(self._turned(w, by_wave[w]) for w in sorted(by_wave, key=self._late)))

    def _late(self, wave: tuple) -> tuple:
        """Sort key of a product of sines and cosines: those with fewer factors first, cosines
        before sines."""
        return len(wave), [list(self._waves).index(n) ^ 1 for n, _ in wave]  # cosines first

    def _turned(self, wave: tuple, parts: dict[tuple, Poly]) -> Expression:
        order = sorted(parts, key=lambda m: (sum(e for _, e in m), self.monomial_rank(m)))
        sizes = {abs(c) for part in parts.values() for c in part.values()}
        size = sizes.pop() if len(parts) > 1 and len(sizes) == 1 else Fraction(1)
        total = ex.add(*(self._moved(parts[m], m, size) for m in order))
        if (wave or size != 1) and starts_with_minus(total):
            size, total = -size, ex.neg_each(total)
        waves = (ex.power(self._waves[n], e) for n, e in wave)
        return ex.mul(self.order.number(size), total, *waves)

    def _moved(self, coefficient: Poly, moving: tuple, size: Fraction) -> Expression:
        """Printed product coefficient / size · moving."""
        front = self._plain({m: c / size for m, c in coefficient.items()})
        if moving and starts_with_minus(front):
            return ex.neg(ex.mul(ex.neg_each(front), *self._monomial(moving)))
        return ex.mul(front, *self._monomial(moving))


class ModularSetting(Setting):
    """A derivation's setting for spatial robots in modular form: vectors are expressed in
    components of others."""

    @classmethod
    def of(cls, s: Setting) -> Self:
        """The setting of a robot extended by symbols of vector components."""
        given, count = s.symbols.given or s.symbols.model, len(s.symbols.model.bodies)
        names = (
            generator(quantity, n, axis)
            for n in range(1, count + 1)
            for quantity in (*_LETTERS, *_BETWEEN)
            for axis in AXES
        )
        extra = (*s.symbols.extra, *names, *cls.more_names(count))
        how = {"euler": s.symbols.euler, "formulas": s.symbols.formulas}
        made = symbols(given, s.symbols.reader.numbers, extra, **how)
        return cls(made, s.load, s.at_rest)

    @classmethod
    def more_names(cls, count: int) -> Iterable[str]:
        """Names of further ring generators, for a robot with `count` bodies."""
        return ()

    @cached_property
    def components(self) -> dict[str, Symbol]:
        """Symbols of the vector components, by generator name."""
        return {
            generator(quantity, self.numbers[i], axis): component(self.vector(quantity, i), axis)
            for quantity, i in self.vectors()
            for axis in AXES
        }

    def vectors(self) -> Iterator[tuple[str, int]]:
        """The vectors whose components have names, with their body."""
        yield from itertools.product((*_LETTERS, *_BETWEEN), self.order)

    def vector(self, quantity: str, i: int) -> Symbol:
        """The symbol of a vector of body i."""
        n, parent = self.numbers[i], self.numbers[self.tree.bodies[i].parent]
        if quantity in _BETWEEN:
            return (self.naming.force if quantity == "f" else self.naming.moment)(parent, n)
        letter, dots = _LETTERS[quantity]
        return vec(f"{letter}{n}{dots}")

    @cached_property
    def _layout(self) -> Layout:
        return _NamedLayout(self.symbols, tuple(self.components.items()))

    @property
    def layout(self) -> Layout:
        """The layout for printing polynomials, with components by their symbols."""
        return self._layout

    def show_moved(self, x: Scalar) -> Expression:
        """Printed component of a velocity, acceleration or force, which a modular derivation prints
        as any other polynomial."""
        return self.show(x)

    # ------------------------------------------------------------ the recursion
    def _component(self, quantity: str, i: int, axis: str) -> Scalar:
        return self.symbols.ring[generator(quantity, self.numbers[i], axis)]

    def named(self, quantity: str, i: int, value: Vector) -> Vector:
        """A vector with its components replaced by names, except those that are zero, a rate or a
        parameter."""
        return tuple(
            x if self._is_plain(x) else self._component(quantity, i, axis)
            for axis, x in zip(AXES, value, strict=True)
        )

    def _is_plain(self, x: Scalar) -> bool:
        element, ring = self.symbols.element(x), self.symbols.ring
        if element.is_zero:
            return True
        if len(element) > 1 or abs(element.leading_coefficient) != 1:
            return False
        waves = list(ring.index)[: 2 * len(ring.angles)]
        ((powers, _),) = element.terms()
        return sum(powers.values()) == 1 and not set(powers) & {*waves, *self.components}

    @cached_property
    def _runs(self) -> dict[str, tuple[Recursion, BodyMotions]]:
        return {}

    @cached_property
    def _fields(self) -> dict[int, Vector]:
        return {}

    def _run(self, gravity: str) -> tuple[Recursion, BodyMotions]:
        """The recursion run once: (computed vectors, vectors replaced by names)."""
        if gravity not in self._runs:
            values: dict[tuple[str, int], Vector] = {}

            def keep(quantity: str, i: int, value: Vector) -> Vector:
                values[quantity, i] = value
                return self.named(quantity, i, value)

            tree, q = self.tree, self.symbols.q
            run = rnea(tree, q, *self._rates, self.tip_load(), gravity, keep)
            each = range(len(tree.bodies))
            w, wd, v, vd, f, n = (
                [values[x, i] for i in each] for x in ("w", "wd", "v", "vd", *_BETWEEN)
            )
            centres, F, N = (
                [[values[x, i]] if (x, i) in values else [] for i in each]
                for x in ("vd_com", "F", "N")
            )
            motion = BodyMotions(run.motion.joints, w, wd, v, vd, run.motion.rates)
            self._fields.update({i: x for (name, i), x in values.items() if name == "field"})
            told = Recursion(motion, centres, F, N, f, n, run.tau)
            self._runs[gravity] = told, run.motion
        return self._runs[gravity]

    def recursion(self, gravity: str) -> Recursion:
        """The recursion of a robot, each vector expressed in the components of earlier ones."""
        return self._run(gravity)[0]

    def field_name(self, i: int) -> Expression:
        """g_i: gravity in the axes of body i."""
        return self.vector("field", i)

    def gravity(self, i: int) -> Vector:
        """Components of gravity in the axes of body i, expressed in those in the preceding body's
        axes."""
        self._run("explicit")
        return self._fields[i]

    @cached_property
    def motion(self) -> BodyMotions:
        """The motion in the recursion, with vectors replaced by names."""
        return self._run("base")[1]


def generator(quantity: str, n: int, axis: str) -> str:
    """A generator name for a vector component, different from all parameters."""
    return f"{quantity}.{n}.{axis}"


def last_step(steps: Iterable[Step], full: str) -> Step:
    """Step: the statement that the lines together are the equations; full: phrase for the length of
    the closed form."""
    lines = [line for step in steps for line in step.equations]
    total = Counter[str]()
    for line in lines:
        total.update(ex.operations(line.sides[-1]))
    return Step(
        "All together",
        f"The closed form is too long to read: {full}. The lines above are the same equations, "
        "exactly: from the first to the last, "
        f"{total['multiplications']} products and {total['additions']} sums give the torques, and "
        "this is also how programs compute them; fb.equations gives the closed form.",
        result=True,
    )
