"""The equations of motion in closed form: M(q) q̈ + c(q, q̇) + g(q) + friction and springs = tau."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from html import escape
from typing import Any

from freebody.algorithms.crba import crba
from freebody.algorithms.energy import potential_energy
from freebody.algorithms.rnea import drive_torque
from freebody.arrays import Array
from freebody.derivations import source, views
from freebody.derivations.expression import Equation, Expression, operations, size
from freebody.derivations.forms import Layout
from freebody.derivations.intermediates import intermediates
from freebody.derivations.render import page
from freebody.derivations.render.sympy import to_sympy
from freebody.derivations.symbols import Symbols, symbols
from freebody.errors import UnknownNameError
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.parameters import finite, with_parameters
from freebody.model.tree import Tree
from freebody.scalars.trig import Trig
from freebody.values import ByValue

VIEWS = ("auto", "named", "expanded", "intermediates", "base")
SHORT = 700
"""Numbers and symbols that fit on about a page."""
MOST = 2000
"""Terms of M, c and g that will not fit whatever their form."""


@dataclass(frozen=True, eq=False)
class Equations(ByValue):
    """Closed forms of a model, exact polynomials in normal form: equal means identical."""

    symbols: Symbols

    @cached_property
    def M(self) -> list[list[Trig]]:
        """Mass matrix, rotors included."""
        s = self.symbols
        return [[s.element(x) for x in row] for row in crba(s.tree, s.q)]

    @cached_property
    def christoffel(self) -> list[list[list[Trig]]]:
        """[i][j][k] = ½ (∂M_ij/∂q_k + ∂M_ik/∂q_j - ∂M_jk/∂q_i)."""
        n, names = len(self.symbols.coordinates), self.symbols.coordinates
        slope = [
            [[self.M[i][j].derivative(x) for x in names] if j >= i else [] for j in range(n)]
            for i in range(n)
        ]

        def dM(i: int, j: int, k: int) -> Trig:
            return slope[min(i, j)][max(i, j)][k]

        table: list[list[list[Trig]]] = [[[self.symbols.zero()] * n for _ in range(n)] for _ in range(n)]
        for i in range(n):
            for j in range(n):
                for k in range(j, n):
                    value = (dM(i, j, k) + dM(i, k, j) - dM(j, k, i)) * 0.5
                    table[i][j][k] = table[i][k][j] = value
        return table

    @cached_property
    def C(self) -> list[list[Trig]]:
        """Coriolis matrix of Christoffel's symbols: C q̇ = c and Ṁ - 2C is skew-symmetric."""
        return [[self._along_rates(row) for row in plane] for plane in self.christoffel]

    @cached_property
    def c(self) -> list[Trig]:
        """Coriolis and centrifugal terms."""
        return [self._along_rates(row) for row in self.C]

    def _along_rates(self, row: list[Trig]) -> Trig:
        total = self.symbols.zero()
        for x, rate in zip(row, self.symbols.qd, strict=True):
            if not x.is_zero:
                total = total + x * rate
        return total

    @cached_property
    def g(self) -> list[Trig]:
        """Gravity terms."""
        s = self.symbols
        tree = s.tree
        weight = s.element(potential_energy(_without_drives(tree), s.q))
        return [weight.derivative(x) for x in s.coordinates]

    @cached_property
    def drives(self) -> list[Trig]:
        """Friction and springs."""
        s = self.symbols
        total = [s.zero() for _ in s.coordinates]
        for body in s.tree.bodies:
            if body.drive is not None:
                k = body.coordinates.v[0]
                total[k] = total[k] + body.coordinates.ratio * drive_torque(body, s.q, s.qd)
        return total

    @cached_property
    def tau(self) -> list[Trig]:
        """Joint torques M q̈ + c + g + friction and springs."""
        rows = []
        for row, c, g, drive in zip(self.M, self.c, self.g, self.drives, strict=True):
            total = c + g + drive
            for x, second in zip(row, self.symbols.qdd, strict=True):
                total = total + x * second
            rows.append(total)
        return rows

    @cached_property
    def T(self) -> Trig:
        """Kinetic energy ½ q̇ᵀ M q̇."""
        total = self.symbols.zero()
        for row, rate in zip(self.M, self.symbols.qd, strict=True):
            total = total + rate * self._along_rates(row)
        return total * 0.5

    @cached_property
    def V(self) -> Trig:
        """Potential energy: gravity, zero at the world's origin, and springs."""
        s = self.symbols
        return s.element(potential_energy(s.tree, s.q))

    def evaluate(self, quantity: Any, q: Any, qd: Any = None, qdd: Any = None) -> Array:
        """Numbers of one of the above at q, qd, qdd (..., n), with the model's parameter values."""
        return self.symbols.evaluate(quantity, q, qd, qdd)

    # ------------------------------------------------------------ for the reader
    @cached_property
    def layout(self) -> Layout:
        """How polynomials of this model are printed: `layout.form(x)` is an expression."""
        return Layout(self.symbols)

    def form(self, x: Trig) -> Expression:
        """A polynomial as it is printed; it has text, LaTeX and MathML of its own."""
        return self.layout.form(x)

    @property
    def parameters(self) -> dict[str, float | None]:
        """The parameters that the equations hold by name, with their values where they have one."""
        used = set(self.symbols.ring.names)
        return {name: value for name, value in self.symbols.model.parameters.items() if name in used}

    def intermediates(self) -> list[Equation]:
        """Inverse dynamics by named intermediates, each line in terms of those before: see `intermediates`."""
        return intermediates(self.symbols)

    def groups(self, view: str = "named", names: str = "notes") -> list[list[Equation]]:
        """The equations of a view: "named", "expanded", "intermediates" or "base"."""
        if names not in views.NAMES:
            raise UnknownNameError("naming", names, "Equations", views.NAMES)
        if view == "intermediates":
            return [self.intermediates()]
        if view == "expanded":
            return views.expanded(self, self.layout)
        if view == "base":
            return self._by_base_parameters(names)
        if view in ("named", "auto"):
            return views.named(self, self.layout, views.NAMES[names])
        raise UnknownNameError("view", view, "Equations", VIEWS)

    def _by_base_parameters(self, names: str) -> list[list[Equation]]:
        """The named view in base parameters, and what these are."""
        from freebody.derivations.base import by_base_parameters

        short = by_base_parameters(self)
        return [*views.named(short, short.layout, views.NAMES[names]), short.definitions(self)]

    def count(self) -> dict[str, int]:
        """Number of terms of M (upper triangle), c and g, as exact polynomials."""
        return {
            "M": sum(len(x) for i, row in enumerate(self.M) for x in row[i:]),
            "c": sum(map(len, self.c)),
            "g": sum(map(len, self.g)),
        }

    def operations(self, view: str = "named") -> dict[str, int]:
        """Additions, multiplications and functions that a view takes, line by line as printed."""
        total: Counter[str] = Counter(additions=0, multiplications=0, functions=0)
        for line in (line for group in self.groups(view) for line in group):
            total.update(operations(line))
        return dict(total)

    @cached_property
    def is_vast(self) -> bool:
        """Whether the mass matrix alone is too long; looked at from the tip inward, before anything else is worked out.

        The rows and columns of a chain's last joints are the mass matrix of what they carry, the rest held still.
        """
        tree, terms = self.symbols.tree, 0
        for first in reversed(range(len(tree.bodies))):
            M = crba(_from_body(tree, first), self.symbols.q)
            terms = sum(len(x) for i, row in enumerate(M) for x in row[i:] if isinstance(x, Trig))
            if terms > MOST:
                return True
        return False

    @cached_property
    def is_short(self) -> bool:
        """Whether the named view fits on about a page."""
        if self.is_vast or sum(self.count().values()) > MOST:
            return False
        return sum(size(line) for group in self.groups("named") for line in group) <= SHORT

    def text(self, view: str = "auto", names: str = "notes", width: int = 100) -> str:
        """The equations for a terminal.

        view: "named" (τ by H, h, G and what these are), "expanded" (τ written out), "intermediates" (the recursion
        line by line), "base" (named, by the fewest combinations of masses and inertias), "auto"
        (named where that is short, else how long it is).
        names: "notes" (H_ij, h, G_i) or "standard" (M_ij, c_i, g_i).
        """
        if view == "auto" and not self.is_short:
            return self._too_long()
        return page.text(self.groups(view, names), width)

    def latex(self, view: str = "auto", names: str = "notes", environment: str = "aligned") -> str:
        """The same as an amsmath environment, without dollar signs; "align*" in a document breaks across pages."""
        if view == "auto" and not self.is_short:
            lines = " \\\\ ".join(
                f"\\text{{{line}}}" for line in self._too_long().replace("_", "\\_").splitlines()
            )
            return f"\\begin{{gathered}} {lines} \\end{{gathered}}"
        return page.latex(self.groups(view, names), environment)

    def mathml(self, view: str = "auto", names: str = "notes") -> str:
        """The same as one `<math>` element."""
        if view == "auto" and not self.is_short:
            lines = "".join(
                f"<mtr><mtd><mtext>{escape(line)}</mtext></mtd></mtr>"
                for line in self._too_long().splitlines()
            )
            return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block"><mtable>{lines}</mtable></math>'
        return page.html(self.groups(view, names))

    @property
    def length(self) -> str:
        """How many terms there are, in words; of what is vast only that."""
        if self.is_vast:
            return f"M alone has more than {MOST} terms"
        terms = self.count()
        return f"M has {terms['M']} terms, c {terms['c']}, g {terms['g']}"

    def _too_long(self) -> str:
        return (
            f"{self.symbols.model.name}: {self.length}: too long to read.\n"
            f'view="intermediates": the recursion, in {len(self.intermediates())} lines; '
            'view="named" or "expanded": all terms.'
        )

    def __str__(self) -> str:
        return self.text()

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    # ------------------------------------------------------------ for other programs
    def to_sympy(self) -> dict[str, Any]:
        """SymPy matrices M, C, c, g, drives, tau and expressions T, V; symbols are named as in code and real."""
        import sympy

        def convert(x: Any) -> Any:
            return to_sympy(self.form(x)) if isinstance(x, Trig) else sympy.Matrix(_nested(x, convert))

        names = ("M", "C", "c", "g", "drives", "tau", "T", "V")
        return {name: convert(getattr(self, name)) for name in names}

    def python(self) -> str:
        """Source of a Python function dynamics(q, qd, qdd, parameters…) that returns M, c, G, tau."""
        return source.python(self)

    def c_source(self) -> str:
        """Source of a C function of the same, the closed form term by term; long arms are shorter with `fb.source`."""
        return source.c(self)

    def substitute(self, **numbers: float) -> Equations:
        """The equations with numbers in place of some parameters."""
        known = self.parameters
        for name in numbers:
            if name not in known:
                raise UnknownNameError("parameter", name, "the equations", known)
        model = with_parameters(
            self.symbols.model, lambda p: finite(numbers[p.name], p.name) if p.name in numbers else p
        )
        return equations(model, self.symbols.reader.numbers)


def _nested(x: Any, convert: Any) -> Any:
    """Rows of rows converted, a vector as it stands."""
    return [[convert(entry) for entry in row] if isinstance(row, list) else convert(row) for row in x]


def _from_body(tree: Tree, first: int) -> Tree:
    """The bodies from one on (whatever they carry is among them), each whose parent is left out held by the base."""
    bodies = (replace(body, parent=max(body.parent - first, -1)) for body in tree.bodies[first:])
    return replace(tree, bodies=tuple(bodies))


def _without_drives(tree: Tree) -> Tree:
    return replace(tree, bodies=tuple(replace(body, drive=None) for body in tree.bodies))


def equations(model: Model, numbers: bool = False) -> Equations:
    """The closed-form equations of a model; `numbers` puts in the values of its parameters.

    Raises FreebodyError for spherical and free joints, and for joints that follow another by a ratio that is not whole.
    """
    model.require_tree("equations")
    if numbers:
        model.require_values("equations in numbers")
    return Equations(symbols(model, numbers))
