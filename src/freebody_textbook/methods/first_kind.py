"""Lagrange's equations of the first kind, with multipliers, and their reduction to the second kind
(5.21-5.29)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Words
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import entry, sym
from freebody.scalars.trig import Trig
from freebody_textbook.closed_chains.first_kind import MOST, Reduction
from freebody_textbook.closed_chains.linear import Ratio
from freebody_textbook.derivation import Meaning, Method, MethodOption, Step, Worked
from freebody_textbook.equations.closed_form import symmetric
from freebody_textbook.methods import absolute_coordinates, glossary, lagrange, modular_ring
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.cut_loops import LONG, Loops, block_system
from freebody_textbook.methods.energies import HALF, Energies, virtual_work
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import Efforts

SHORT = 14
"""Numbers and symbols up to which a denominator is written in every quotient."""


def work_out(setting: Setting, coordinates: str) -> Worked:
    """Derive Lagrange's equations of the first kind; open chains get those of the second kind, as
    they have no multipliers. coordinates: of the joints, or absolute ones, see
    `absolute_coordinates`."""
    if coordinates == "absolute":
        return absolute_coordinates.work_out(setting)
    if not setting.tree.loops:
        return _open_chain(setting)
    loops = Loops(setting)
    work = _FirstKindSteps(setting, loops)
    steps = [loops.cut(), loops.closed(), loops.freedom(), loops.rates(), *work.energy_steps]
    introduced = list(_symbols(setting, work.energies))
    seconds, together = loops.seconds(), work.together()
    if modular_ring.is_ring(setting, work.forces):
        steps += modular_ring.steps(setting)
        introduced += modular_ring.symbols(setting)
        seconds = modular_ring.without_lengths(seconds, _C)
        together = [modular_ring.without_lengths(step, _N) for step in together]
    else:
        for i in setting.order:
            steps += work.equation(i)
        steps.append(loops.wrenches())
    steps += [seconds, *together, *work.reduced()]
    sought = (
        f"{Efforts.of(setting).given} accelerations and the forces in {loops.named} are sought."
    )
    return Worked(
        tuple(steps),
        tuple(work.forces),
        list(dict.fromkeys(introduced)),
        sought=sought,
        system=loops.system,
    )


_C = "c is the second derivative of Φ where q̈ = 0, with the opposite sign"
_N = "n is τ less what the lines above give for it where q̈ = 0 and λ = 0"


def _symbols(s: Setting, energies: Energies) -> Iterator[Meaning]:
    yield from lagrange.symbols(s, energies)
    yield glossary.loop_equations(s)
    yield glossary.multipliers(s)
    yield from meanings(s, "f{h}{n}")
    yield Meaning(
        (sym("u"), sym("N")), "independent coordinates; matrix that gives all rates from theirs", ""
    )


def _open_chain(setting: Setting) -> Worked:
    """The derivation of an open chain, for which Φ is empty and (5.23) reduces to (5.24)."""
    second = lagrange.work_out(setting)
    reason = (
        "No loop is closed: there are no equations Φ(q) = 0 between the joint variables, no "
        "multipliers, and Lagrange's equations of the first kind are those of the second. The n "
        "coordinates, less m = 0 equations, are the f degrees of freedom."
    )
    step = Step(
        "No loops, no multipliers",
        reason,
        (eq("f", ex.sub("n", "m"), ex.sub(len(setting.leaders), 0)),),
        ("5.24",),
    )
    return replace(second, steps=(step, *second.steps))


class _FirstKindSteps:
    """The steps of the derivation from the energies on."""

    def __init__(self, setting: Setting, loops: Loops):
        self.s, self.loops, self.system = setting, loops, loops.system
        self.energies, self.energy_steps = lagrange.lagrangian(setting)
        self.works: dict[int, Trig] = {}
        self._common: Trig | None = None
        if setting.load:
            step, self.works = virtual_work(setting)
            self.energy_steps.append(step)

    @property
    def forces(self) -> list[Trig]:
        """Torques of the motors by joint, without the load's part; 0 for joints without motor."""
        zero = self.s.symbols.zero()
        return [self.system.forces[self.s.index(i)] - self.works.get(i, zero) for i in self.s.order]

    # ------------------------------------------------------------ one coordinate
    def equation(self, i: int) -> list[Step]:
        """Steps: the derivatives of L and the equation of one coordinate (5.23)."""
        s, energies = self.s, self.energies
        found = lagrange.derivatives(s, energies, i)
        friction = found.friction
        k = s.index(i)
        x = s.coordinate(i)
        left = ex.add(
            ex.sub(ex.d_dt(ex.partial("L", x + RATE)), ex.partial("L", x)),
            *(
                ex.mul(ex.partial(self.loops.phi(j), x), entry("lam", j))
                for j, row in enumerate(self.loops.equations.Phi_q, 1)
                if not row[k].is_zero
            ),
        )
        motor = s.motor(i) if not s.load else sym(f"Q{s.numbers[i]}")
        right = ex.add(motor, ex.neg_each(s.show(friction)))
        total = found.needed + self.system.pressed[k] - self.works.get(i, s.symbols.zero())
        own = (
            "Along the coordinate act the joint's motor"
            if s.driven(i)
            else "The joint is passive: along it act"
        )
        own += ", the load" if s.load else ""
        reason = (
            f"{own}{' and ' if s.driven(i) or s.load else ' '}the loops, whose part -Φ_qᵀ λ is "
            f"written beside the derivatives."
        )
        if not friction.is_zero:
            reason += " Friction opposes."
        lines = (eq(left, right), eq(s.motor(i), found.sources.marked(s.show(total))))
        return [found.step, Step(f"The equation of {sym(x)}", reason, lines, ("5.23",))]

    # ------------------------------------------------------------ all together
    def together(self) -> list[Step]:
        """Steps: M, n and the combined system of equations (5.25-5.27, 5.29)."""
        reason = (
            "Sorted by accelerations: M is the matrix of the kinetic energy, a quadratic form of "
            "the rates, and n holds the generalized forces less all terms without accelerations. "
            "Entries that are not listed are 0."
        )
        rate = ex.Symbol("q_d", "q", dots=1)
        rests = [self._named_rest(k, i) for k, i in self._by_coordinate()]
        first = Step(
            "Mass matrix and forces",
            reason,
            (
                eq("T", ex.mul(HALF, ex.transposed(rate), "M", rate)),
                *symmetric("M", self.system.M, self.s.show),
                *rests,
            ),
            ("5.25", "5.26", "5.27"),
        )
        n, m = len(self.s.symbols.coordinates), len(self.loops.equations.names)
        both = Step(
            "Accelerations and multipliers together",
            f"{n} equations of motion and {m} of the loops, for {n} accelerations and {m} "
            f"multipliers. The matrix can be inverted where Φ_q has full rank and M is positive "
            f"definite on the motions that the loops allow.",
            (block_system(),),
            ("5.29",),
            result=True,
        )
        return [first, both]

    def _by_coordinate(self) -> list[tuple[int, int]]:
        """Pairs (coordinate, body), sorted by coordinate."""
        return sorted((self.s.index(i), i) for i in self.s.order)

    def _named_rest(self, k: int, i: int) -> Equation:
        rest = self.system.rest[k] - self.works.get(i, self.s.symbols.zero())
        shown = self.s.show(rest)
        if isinstance(shown, Words):
            shown = ex.words(shown.text.strip("()"))  # brackets come with the sign
        return eq(entry("n", k + 1), ex.add(self.s.motor(i), ex.neg_each(shown)))

    # ------------------------------------------------------------ the second kind
    def reduced(self) -> list[Step]:
        """Steps: the equations in independent coordinates (5.24)."""
        reduction = self.system.reduction
        if reduction is None:
            reason = (
                "By this count there is no independent coordinate. If the mechanism can move "
                "nevertheless, its loop equations are dependent, and which ones depends on the "
                "position. (5.29) still holds, solved with the rank of Φ_q."
            )
            if len(self.loops.equations.names) > MOST:
                reason = (
                    f"The {len(self.loops.equations.names)} loop equations are too many to solve "
                    "for the rates in print. With numbers (5.29) is one system of linear "
                    "equations: fb.forward_dynamics and fb.reactions solve it, and "
                    "fb.loop_velocity the velocity constraints."
                )
            return [Step("No reduction", reason)]
        self._common = self._shared(reduction)
        return [self._allowed(reduction), self._drift(reduction), self._second(reduction)]

    def _shared(self, r: Reduction) -> Trig | None:
        """The common denominator of all quotients, if they share one that is too long to print
        repeatedly; None otherwise."""
        below = [
            x.below for x in (*(x for row in r.N for x in row), *r.drift) if not x.is_polynomial
        ]
        if not below or ex.size(self.loops.equations.form(below[0])) < SHORT:
            return None
        first = below[0] / below[0].leading_coefficient
        return first if all(x == first * x.leading_coefficient for x in below) else None

    def _allowed(self, r: Reduction) -> Step:
        chosen = [sym(self.s.symbols.coordinates[k]) for k in r.independent]
        names = ", ".join(map(str, chosen))
        lines = [
            eq(sym("u"), ex.Vector(tuple(chosen)) if len(chosen) > 1 else chosen[0]),
            eq(ex.Symbol("q_d", "q", dots=1), ex.mul("N", ex.Symbol("u_d", "u", dots=1))),
            eq(ex.mul(self.loops.phi_q, "N"), ex.ZERO),
            eq(
                "N",
                ex.matrix(
                    [[self._entry(r, k, j) for j in range(len(chosen))] for k in range(len(r.N))]
                ),
            ),
        ]
        lines += [
            eq(self._entry(r, k, j), self.loops.ratio(x, self._common))
            for k in r.dependent
            for j, x in enumerate(r.N[k])
            if not _is_plain(x)
        ]
        if self._common is not None:
            lines.append(eq(sym("Delta"), self.loops.equations.form(self._common)))
        reason = (
            f"The velocity constraints are solved for the rates of all coordinates but {names}: "
            f"the columns of N are the motions that the loops allow, K its entries that depend on "
            f"the position. This fails where the denominator vanishes; there {names} "
            f"{'does' if len(chosen) == 1 else 'do'} not determine the motion."
        )
        return Step("Independent coordinates", reason, tuple(lines), ("5.22",))

    def _entry(self, r: Reduction, k: int, j: int) -> Expression:
        """Printed entry of N: 0, 1 or a polynomial as it is, otherwise the name K_kj (K_k with one
        independent coordinate)."""
        x = r.N[k][j]
        if _is_plain(x):
            return ex.Number(x.above.fraction)
        return entry("K", k + 1) if len(r.independent) == 1 else entry("K", k + 1, j + 1)

    def _drift(self, r: Reduction) -> Step:
        lines = [
            eq(
                ex.Symbol("q_dd", "q", dots=2),
                ex.add(ex.mul("N", ex.Symbol("u_dd", "u", dots=2)), sym("gamma")),
            )
        ]
        lines += [
            eq(entry("gamma", k + 1), self.loops.ratio(r.drift[k], self._common))
            for k in r.dependent
            if not r.drift[k].is_zero
        ]
        reason = (
            "The acceleration constraints are solved in the same way: γ holds the terms of the "
            "dependent accelerations with products of rates; its entries for the independent "
            "coordinates are 0."
        )
        return Step("Dependent accelerations", reason, tuple(lines), ("5.28",))

    def _second(self, r: Reduction) -> Step:
        """Step: Lagrange's equations of the second kind, Nᵀ M N ü = Nᵀ (n - M γ)."""
        N_t = ex.transposed("N")
        rule = eq(
            ex.mul(N_t, "M", "N", ex.Symbol("u_dd", "u", dots=2)),
            ex.mul(N_t, ex.sub("n", ex.mul("M", "gamma"))),
        )
        zero = eq(ex.mul(N_t, ex.transposed(self.loops.phi_q)), ex.ZERO)
        lines = [zero, rule]
        written = self._written(r)
        if sum(map(ex.size, written)) <= 3 * LONG:
            lines += written
        count = len(r.independent)
        remaining = "is one equation" if count == 1 else f"are {count} equations"
        reason = (
            "The constraint forces do no work in the motions that the loops allow: multiplying by "
            f"Nᵀ eliminates the multipliers, and what remains {remaining} in independent "
            "coordinates, Lagrange's equations of the second kind."
        )
        return Step("Equations of the second kind", reason, tuple(lines), ("5.24",), result=True)

    def _written(self, r: Reduction) -> list[Equation]:
        """The reduced equations in the entries of M, n, N and γ; with several independent
        coordinates by the entries of H = NᵀM N."""
        f = len(r.independent)
        names = [self.s.symbols.coordinates[k] + SECOND for k in r.independent]
        if f == 1:
            return [eq(ex.mul(self._quadratic(r, 0, 0), names[0]), self._driving(r, 0))]
        lines = []
        for j in range(f):
            left = ex.add(*(ex.mul(entry("H", j + 1, k + 1), name) for k, name in enumerate(names)))
            lines.append(eq(left, self._driving(r, j)))
        for j in range(f):
            for k in range(j, f):
                both = entry("H", j + 1, k + 1), entry("H", k + 1, j + 1)
                lines.append(ex.chain(*both, self._quadratic(r, j, k)))
        return lines

    def _quadratic(self, r: Reduction, j: int, l: int) -> Expression:
        """The expression Σ M_ik N_ij N_kl, with equal terms combined."""
        n = len(r.N)
        terms: dict[tuple[Expression, ...], int] = {}
        for i in range(n):
            for k in range(i, n):
                if self.system.M[i][k].is_zero:
                    continue
                for a, b in {(i, k), (k, i)}:
                    factors = sorted((self._entry(r, a, j), self._entry(r, b, l)), key=str)
                    if ex.ZERO not in factors:
                        key = (entry("M", i + 1, k + 1), *(x for x in factors if x != ex.ONE))
                        terms[key] = terms.get(key, 0) + 1
        return ex.add(*(ex.mul(count, *_squared(key)) for key, count in terms.items()))

    def _driving(self, r: Reduction, j: int) -> Expression:
        """Expression Σ N_ij (n_i - Σ M_ik γ_k)."""
        total = []
        for i in range(len(r.N)):
            weight = self._entry(r, i, j)
            if weight == ex.ZERO:
                continue
            moved = [
                ex.neg(ex.mul(entry("M", min(i, k) + 1, max(i, k) + 1), entry("gamma", k + 1)))
                for k in r.dependent
                if not r.drift[k].is_zero and not self.system.M[i][k].is_zero
            ]
            total.append(ex.mul(weight, ex.add(entry("n", i + 1), *moved)))
        return ex.add(*total)


def _squared(factors: tuple[Expression, ...]) -> list[Expression]:
    """Factors with two equal ones at the end combined to a square."""
    if len(factors) == 3 and factors[1] == factors[2]:
        return [factors[0], ex.power(factors[1], 2)]
    return list(factors)


def _is_plain(x: Ratio) -> bool:
    """Whether an entry is a plain number."""
    return x.is_polynomial and x.above.is_constant


METHOD = Method(
    "lagrange-first-kind",
    "Lagrange's equations of the first kind",
    "loops as constraints with multipliers, and their reduction to independent coordinates",
    "lecture notes, section 5.4",
    work_out,
    options=(
        MethodOption(
            "coordinates",
            ("joint", "absolute"),
            "those of the joints, or in the plane x, y, φ of each body with its joints as "
            "constraints",
        ),
    ),
    closed=(2, 3),
    closed_first=True,
)
