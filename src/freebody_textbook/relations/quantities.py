"""Quantities of a derivation by name: positions, velocities, forces and energies of every body,
exact."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import Any

from freebody.algorithms.kinematics import frame_motion
from freebody.algorithms.rnea import Recursion
from freebody.errors import FreebodyError, UnknownNameError
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.textbook_form import Layout
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.outputs.display import Titled, counted
from freebody.scalars.trig import Trig
from freebody.spatial import Vector
from freebody_textbook.methods.body_quantities import values_of
from freebody_textbook.methods.body_values import RecursionValues
from freebody_textbook.methods.recursive import GRAVITIES
from freebody_textbook.methods.setting import LOADS, Setting
from freebody_textbook.methods.whole_bodies import symbols_of_bodies

ValuesByName = dict[str, Any]


class Quantities(Titled, ValuesByName):
    """Exact quantities by name, with their printed form."""

    def __init__(self, values: ValuesByName, layout: Layout):
        super().__init__(values)
        self.layout = layout

    def _title(self) -> str:
        return f"Quantities: {counted(len(self), 'name')}: {', '.join(self)}"

    def __or__(self, other: Any) -> Quantities:
        """The quantities with others added."""
        return Quantities({**self, **other}, self.layout)

    def form(self, x: Any) -> Expression:
        """A quantity, or a value made of quantities, as expression for print."""
        if isinstance(x, tuple) and x and isinstance(x[0], tuple):
            return ex.matrix([[self.form(y) for y in row] for row in x])
        if isinstance(x, tuple):
            return ex.vector(*map(self.form, x))
        return self.layout.form(x) if isinstance(x, Trig) else ex.num(Fraction(repr(float(x))))


def quantities(
    model: Model, *, load: bool = False, at_rest: bool = False, gravity: str = "explicit"
) -> Quantities:
    """Quantities of a serial arm by name, as exact polynomials; vectors are tuples, matrices tuples
    of rows.

    Of body i: omega1, v1, v1_d (of its joint's point), rc1, vc1, vc1_d (of its centre of mass), r1,
    s1 (joint to next joint or tip), sc1, f01 (force of body 0 on body 1), M1 in the plane and n1 in
    space (moment at the joint), fc1, Mc1 or nc1 (mass times acceleration, rate of angular
    momentum), T1, V1, tau1. Of the arm: q, qd, qdd, tau, M, H11, c, G, G1, J, J_d, x, x_d, y, r,
    r_d, r_dd, T, V, L, gravity, z; and all its symbols. In the plane vectors have world axes, in
    space those of their own body (as in chapter 6); there R2_1 takes components of body 1 to body
    2, R1 those of body 1 to the world, p1_2 is the origin of frame 2 in frame 1; w1 and z1 are the
    angular velocity and the z axis of body 1 in world axes.

    Parameters
    ----------
    model
        The robot, a serial arm.
    load
        Whether a force f = (fx, fy) acts on the tip, in space (fx, fy, fz).
    at_rest
        Whether nothing moves.
    gravity
        "explicit" counts each body's weight among its forces; "base" accelerates the base by -g
        instead, which then is in all accelerations.

    Returns
    -------
    Quantities
        Exact polynomials by name, with their printed forms.

    Raises
    ------
    FreebodyError
        A branched model, a spherical or free joint.
    """
    if gravity not in GRAVITIES:
        raise UnknownNameError("gravity", gravity, "fb.quantities", GRAVITIES)
    names = LOADS[model.dim] if load else ()
    made = symbols_of_bodies("quantities", model, names)
    setting = Setting(made, names, at_rest)
    if branches(made.tree):
        raise FreebodyError(
            f"quantities: {model.name!r} branches; names such as f12 are defined for serial chains."
        )
    return Quantities(QuantityValues(setting, gravity).all(), setting.layout)


def branches(tree: Tree) -> bool:
    """Whether some body has several children."""
    return any(len(tree.children(i)) > 1 for i in range(-1, len(tree.bodies)))


class QuantityValues:
    """The values of a derivation's quantities, one method for each group."""

    def __init__(self, setting: Setting, gravity: str):
        self.s = setting
        self.base = gravity == "base"
        self.gravity = gravity

    def all(self) -> ValuesByName:
        found = self._symbols() | self._arm()
        for i in self.s.order:
            found |= self.of_body(i)
        return found

    def of_body(self, i: int) -> ValuesByName:
        """The quantities of body i by name."""
        return values_of(RecursionValues(self.s, i, self.record, self.base))

    @cached_property
    def record(self) -> Recursion:
        """The results of one run of the recursion."""
        return self.s.recursion(self.gravity)

    def _element(self, x: Any) -> Trig:
        return self.s.symbols.element(x)

    def _vector(self, v: Vector) -> tuple[Trig, ...]:
        return tuple(map(self._element, v))

    # ------------------------------------------------------------ groups
    def _symbols(self) -> ValuesByName:
        s = self.s.symbols
        found: ValuesByName = s.followed({}) | {name: s.ring[name] for name in s.ring.names}
        q, qd, qdd = s.q, s.qd, s.qdd
        if self.s.at_rest:
            qd = qdd = tuple(s.zero() for _ in q)
        found |= {"q": q, "qd": qd, "qdd": qdd, "gravity": self._vector(self.s.tree.gravity)}
        found |= {"z": (0.0, 0.0, 1.0)}
        if self.s.load:
            found["f"] = tuple(s.ring[name] for name in self.s.load)
        return found

    def _arm(self) -> ValuesByName:
        eq, tau = self.s.equations, tuple(self._element(x) for x in self.record.tau)
        n = range(len(eq.M))
        found: ValuesByName = {
            "tau": tau, "M": tuple(map(tuple, eq.M)), "C": tuple(map(tuple, eq.C)),
            "c": tuple(eq.c),
            "G": tuple(eq.g), "T": eq.T, "V": eq.V, "L": eq.T - eq.V,
        }  # fmt: skip
        found |= {f"H{i + 1}{j + 1}": eq.M[i][j] for i in n for j in n}
        found |= {f"G{i + 1}": eq.g[i] for i in n} | {f"tau{i + 1}": tau[i] for i in n}
        return found | (self._tip() if self.s.symbols.model.tip is not None else {})

    def _tip(self) -> ValuesByName:
        s = self.s
        k = Kinematics(s.symbols, s.symbols.model.frame().name)
        dim = s.tree.space.dim
        (_, v), (_, a) = frame_motion(s.tree, s.motion, k.frame)
        found: ValuesByName = {
            "r": tuple(k.position), "r_d": self._vector(v), "r_dd": self._vector(a),
            "J": tuple(map(tuple, k.J[:dim])), "J_d": tuple(map(tuple, k.J_dot[:dim])),
        }  # fmt: skip
        axes = ("x", "y") if dim == 2 else ("x", "y", "zP")
        for dots, name in (("", "r"), ("_d", "r_d"), ("_dd", "r_dd")):
            found |= {axis + dots: x for axis, x in zip(axes, found[name], strict=True)}
        return found


def of_link(values: Mapping[str, Any], n: int) -> dict[str, Any]:
    """The quantities with letters for link numbers: omega_i is omega_n; omega_h and omega_k belong
    to the preceding and next link.

    Forces f_hi and f_ik, matrices R_i of orientation, Ri_h from link n-1 to n.
    """
    near = {str(n - 1): "h", str(n): "i", str(n + 1): "k"}
    found = dict(values)
    for name, x in values.items():
        own = atom(name)
        if not own.is_figures or not set(own.figures) <= near.keys():
            continue
        match own.index:
            case (high, low) if len(high) == len(low) == 1:
                found[f"{own.letter}{near[high]}_{near[low]}"] = x
            case (low,) if len(low) <= 2:
                found[f"{own.letter}_{''.join(near[d] for d in low)}{own.ending}"] = x
    return Quantities(found, values.layout) if isinstance(values, Quantities) else found
