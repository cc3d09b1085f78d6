"""From absolute coordinates back to those of the joints: the forces in the joints leave (5.24)."""

from __future__ import annotations

import math
from fractions import Fraction

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, eq
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.parameters import Parameter
from freebody.model.placement import AxisRotation, Rotate
from freebody.scalars.trig import Trig
from freebody.spatial import dot
from freebody_textbook.closed_chains.absolute import AbsoluteCoordinates
from freebody_textbook.derivation import Step
from freebody_textbook.methods.cut_loops import Loops, dotted
from freebody_textbook.methods.reactions import drive_part
from freebody_textbook.methods.setting import Setting


class BackToJoints:
    """The absolute coordinates as functions of those of the joints, and the equations of these."""

    def __init__(self, s: Setting, given: AbsoluteCoordinates, loops: Loops):
        self.s, self.given, self.loops = s, given, loops

    @cached_property
    def placed(self) -> list[Trig]:
        """The absolute coordinates by those of the joints."""
        s, found = self.s, []
        for i in self.given.bodies:
            found += [*map(s.symbols.element, s.centre_position(i)), self._angle(i)]
        return found

    def _angle(self, i: int) -> Trig:
        """φ as a sum of the joints' angles, constant turns left out."""
        s, total = self.s, self.s.symbols.zero()
        while i >= 0:
            if s.turns(i):
                total = total + s.symbols.ring[s.coordinate(i)]
            i = s.tree.bodies[i].parent
        return total

    def _before(self, i: int) -> list[int]:
        """Numbers of the joints from that of body i to the ground."""
        found = []
        while i >= 0:
            found.append(self.s.numbers[i])
            i = self.s.tree.bodies[i].parent
        return found

    @cached_property
    def N(self) -> list[list[Trig]]:
        """∂q/∂u, u being the joints' coordinates."""
        return [[x.derivative(name) for name in self.s.symbols.coordinates] for x in self.placed]

    @property
    def tau(self) -> list[Trig]:
        """Nᵀ (M q̈ - weights - load) with the loops' part: the joints' multipliers leave."""
        s, zero = self.s, self.s.symbols.zero()
        needed: list[Trig] = []
        for i, k in zip(self.given.bodies, range(0, len(self.placed), 3), strict=True):
            second = [
                x.along(s.symbols.rates).along(s.symbols.rates) for x in self.placed[k : k + 3]
            ]
            m = s.mass(i)
            needed += [m * (a - g) for a, g in zip(second[:2], s.tree.gravity, strict=True)]
            needed.append(s.inertia(i) * second[2])
        tip = [s.symbols.element(x) for x in s.tip_position()] if s.load else []
        found = []
        for i in s.order:
            j = s.index(i)
            total = sum((row[j] * x for row, x in zip(self.N, needed, strict=True)), zero)
            total = total + drive_part(s, i)
            if s.tree.loops:
                total = total + self.loops.system.pressed[j]
            if tip:
                slopes = tuple(x.derivative(s.coordinate(i)) for x in tip)
                total = total - dot(slopes, s.load_components)
            found.append(s.symbols.element(total))
        return found

    def step(self) -> Step:
        """q by the joints' coordinates, and N."""
        s = self.s
        names = self.given.names
        lines = []
        for i, k in zip(self.given.bodies, range(0, len(names), 3), strict=True):
            x, y, phi = map(s.show_moved, self.placed[k : k + 3])
            turn = turn_of(s.symbols.model, *self._before(i))
            rows = zip(names[k : k + 3], (x, y, ex.add(phi, turn)), strict=True)
            lines += [eq(name, value) for name, value in rows]
        u = ex.Vector(tuple(map(sym, s.symbols.coordinates)))
        lines += [eq("u", u), eq(dotted("q", 1), ex.mul("N", dotted("u", 1)))]
        lines += self.loops.matrix(sym("N"), self.N)
        reason = (
            "The coordinates of the joints, u, satisfy the constraints of the joints by "
            "themselves. N holds the derivatives of q by them."
        )
        return Step(
            "Back to the coordinates of the joints",
            reason + self.loops.unlisted(self.N),
            tuple(lines),
        )

    def result(self) -> Step:
        """Nᵀ times the equations."""
        s = self.s
        N_t = ex.transposed("N")
        loops = s.tree.loops
        pressed = ex.mul(N_t, ex.transposed(self.loops.phi_q))
        needed, given = ex.mul(N_t, "M", dotted("q", 2)), ex.mul(N_t, "n")
        if loops:
            lines = [eq(ex.add(needed, ex.mul(pressed, "lam")), given)]
        else:
            lines = [eq(pressed, ex.ZERO), eq(needed, given)]
        lines += [eq(s.motor(i), s.show(x)) for i, x in zip(s.order, self.tau, strict=True)]
        reason = (
            "The forces in the joints do no work in the motions that the joints allow: multiplied "
            f"by Nᵀ, {'their multipliers' if loops else 'all multipliers'} leave, with q̈ = N ü + "
            "Ṅ u̇ put in. What remains are "
        )
        reason += (
            "the equations of the first kind in the coordinates of the joints, with the forces in "
            "the loops alone."
            if loops
            else "Lagrange's equations of the second kind."
        )
        return Step(
            "Without the forces in the joints", reason, tuple(lines), ("5.24",), result=True
        )


def turn_of(model: Model, *joints: int) -> Expression:
    """The angle by which the placements of joints (their numbers) turn, whole turns left out."""
    number, named = 0.0, []
    for n in joints:
        for step in model.bodies[n - 1].joint.placement.steps:
            if isinstance(step, Rotate):
                number += math.atan2(step.matrix[1][0], step.matrix[0][0])
            elif isinstance(step, AxisRotation):
                if isinstance(step.angle, Parameter):
                    named.append(sym(step.angle.name))
                elif isinstance(step.angle, int | float):
                    number += step.angle
    return ex.add(_as_angle(math.remainder(number, 2 * math.pi)), *named)


def _as_angle(x: float) -> Expression:
    """A number of radians, as a part of π where it is one."""
    part = Fraction(x / math.pi).limit_denominator(12)
    if abs(x - part * math.pi) > 1e-9:
        return ex.num(Fraction(x), decimal=True)
    above = ex.mul(part.numerator, sym("pi"))
    return ex.div(above, part.denominator)
