"""Further quantities of bodies: vectors in any body's axes, Jacobians of centres of mass, Kane's
partial velocities and generalized forces, statics of an arm with a force on its tip."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.words import FRAMES, PRIME
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value, pair
from freebody_textbook.check.asked.bodies import QuantitiesOfBodies
from freebody_textbook.check.asked.group import NamedTarget, components, entries, matrix
from freebody_textbook.check.asked.loads import JOINT_FORCE, MOMENT, VECTORS
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.body_quantities import BODY_QUANTITIES, numbers
from freebody_textbook.methods.setting import Setting
from freebody_textbook.relations.quantities import QuantityValues, branches

_WORLD = "This would be right in the world's axes; here the components are along those of body {}."


class QuantitiesInFrames(QuantitiesOfBodies):
    """Vectors of bodies in the axes of a named frame; the frame's mark ends their plain names, see
    `FRAMES`."""

    def single(self) -> Iterator[NamedTarget]:
        for name, table in self._framed.items():
            for (own,), x in components({name[:-1]: table}):
                yield (own + name[-1],), x

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._framed

    @cached_property
    def _framed(self) -> dict[str, QuantityTable]:
        found: dict[str, QuantityTable] = {}
        count = len(self._bodies)
        for n in range(1, count + 1):
            for record in BODY_QUANTITIES:
                own = next(iter(record.spelt(n)), "")
                table = self.vectors.get(own)
                if table is None or record.matrix or record.framed is None or record.only:
                    continue
                further = [x.format(**numbers(n)) for x in record.framed]
                for frame in range(min(count, len(FRAMES) - 1) + 1):
                    told = self._seen(table, n, frame, record.is_place)
                    for name in dict.fromkeys((*record.spelt(n), *further)):
                        found.setdefault(name + FRAMES[frame], told)
        ground = {x: y for x, y in self.vectors.items() if x.strip("˙'d") in ("v0", "omega0")}
        return found | {name + FRAMES[0]: table for name, table in ground.items()}

    def _seen(self, table: QuantityTable, n: int, frame: int, is_place: bool) -> QuantityTable:
        """A vector of body n in the axes of another body; a position is relative to that body's
        origin."""
        if len(table) == 1 or (frame == 0 and self.setting.is_planar):
            return table
        if table[0][0].in_world is not None and frame == n:
            return table
        world = [entry.in_world or entry.compute for (entry,) in table]
        text = f"{table[0][0].words}, along the axes of body {frame}"

        def component(k: int) -> Callable[[], Trig]:
            def value() -> Trig:
                values: Sequence[Any] = [x() for x in world]
                if frame and is_place:
                    origin = [entry.compute() for (entry,) in self.vectors[f"r{frame}"]]
                    values = [a - b for a, b in zip(values, origin, strict=True)]
                terms = (self._axis_of(frame, k, i) * x for i, x in enumerate(values))
                return sum(terms, self.setting.zero)

            return value

        return [
            [
                AskedQuantity(
                    kinds.OF_BODY, (n,), component(k), axis=entry.axis, words=text,
                    thoughts=((_WORLD.format(frame), world[k]),) if frame else (),
                )
            ]
            for k, (entry,) in enumerate(table)
        ]  # fmt: skip

    def _axis_of(self, frame: int, k: int, i: int) -> Trig:
        """World component i of the k-th axis of a body."""
        return self.element(lambda: self._world(frame)[i][k] if frame else float(i == k))()


_TOLD = LexemePattern("< %fresh J | %around_letter { J } > ~_? ~{? < %letter | \\omega >")
"""A Jacobian with a letter; answers without one are not about these."""
_OF_CENTRE = ("Jc{n}", "Jv{n}", "Jvc{n}", "JG{n}", "JL{n}")
_ANGULAR = ("Jomega{n}", "Jw{n}", "JA{n}")


class CentreJacobians(QuantitiesOfBodies):
    """Jacobians of the centres of mass: J_ci or J_vi with v_ci = J_vi q̇, and J_ωi with ω_i = J_ωi
    q̇."""

    def single(self) -> Iterator[NamedTarget]:
        yield from entries(self._tables)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._tables

    @cached_property
    def _tables(self) -> dict[str, QuantityTable]:
        if not _TOLD.found_in(self.formulas):
            return {}
        found: dict[str, QuantityTable] = {}
        names = self.setting.symbols.coordinates
        for n in range(1, len(self._bodies) + 1):
            if centre := self.vectors.get(f"rc{n}"):
                rows = [entry.polynomial for (entry,) in centre]
                words = f"the Jacobian of the centre of mass of body {n}"
                table = self._slopes(rows, names, words)
                found |= {name.format(n=n): table for name in _OF_CENTRE}
            if turning := self.vectors.get(f"omega{n}"):
                rows = [entry.in_world or entry.polynomial for (entry,) in turning]
                words = f"the Jacobian of the angular velocity of body {n}"
                table = self._slopes(rows, [x + RATE for x in names], words)
                found |= {name.format(n=n): table for name in _ANGULAR}
        return found

    def _slopes(
        self, rows: list[Callable[[], Trig]], names: Sequence[str], words: str
    ) -> QuantityTable:
        """Jacobian entries: the derivatives of some values by coordinates or rates."""
        slopes = [[lambda row=row, x=x: row().derivative(x) for x in names] for row in rows]
        return matrix(kinds.OF_BODY, slopes, f"entry {{}}, {{}} of {words}")


_PARTIALS = LexemePattern(
    "!-%latin F _? {? < %digit | %low_digit >{1,2} }? %prime"
    " | < v | ω > }? _? {? < c | G > < ~%digit | ~%low_digit > _? ,? < %digit | %low_digit >"
    " | < ∂ | \\partial > < %font { >? < v | ω | \\omega >"
)
PartialRate = Callable[[], Trig]
_LETTERS = ("vc", "vG", "omega", "w")


class KaneQuantities(QuantitiesOfBodies):
    """Kane's partial velocities v_c2,1 and ω_2,1, the coefficients of a rate in velocities, and the
    generalized forces F_1 and F_1*, for open chains."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer contains v_c2,1, ∂v_c2/∂θ̇1 or F_1*. In other answers F_1 is a force,
        and ω_21 may be the angular velocity of body 2 relative to body 1."""
        return _PARTIALS.found_in(formulas)

    def single(self) -> Iterator[NamedTarget]:
        yield from components(self._partials)
        if self.setting.system is None:
            for i in self.numbers:
                yield (f"F{i}",), self._active(i)
                yield (f"F{i}{PRIME}",), self._inertia(i)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._partials

    @cached_property
    def _partials(self) -> dict[str, QuantityTable]:
        found: dict[str, QuantityTable] = {}
        for letter in _LETTERS:
            for n in range(1, len(self.setting.symbols.model.bodies) + 1):
                whole = self.vectors.get(f"{letter}{n}", [])
                for r in self.numbers if whole else ():
                    found[f"{letter}{n}{r}"] = [[self._partial(x, r)] for (x,) in whole]
        return found

    def _partial(self, entry: AskedQuantity, r: int) -> AskedQuantity:
        """The coefficient of rate r in a component of a velocity."""

        def by(ending: str, k: int, value: Callable[[], Value] = entry.compute) -> PartialRate:
            name = self.setting.symbols.coordinates[k - 1] + ending
            return lambda: pair(value())[0].derivative(name)

        thoughts: list[Mistaken] = [
            (f"This is the factor of {self.joint(k)}'s rate.", by(RATE, k))
            for k in self.numbers
            if k != r
        ]
        thoughts.append(("A partial velocity is a derivative by the rate.", by("", r)))
        return replace(
            entry,
            index=(*entry.index, r),
            compute=by(RATE, r),
            in_world=entry.in_world and by(RATE, r, entry.in_world),
            words=f"the factor of {self.joint(r)}'s rate in {entry.words}",
            thoughts=tuple(thoughts),
        )

    # ------------------------------------------------------------ generalized forces
    def _active(self, i: int) -> AskedQuantity:
        """Kane's generalized active force F_i: drive torque, friction, springs and weights."""
        tau, applied = self._parts(i)
        plain = self.setting.zero if i in self.passive else None

        def motor() -> Trig:
            return tau() if plain is None else plain

        gravity = self.entry("g", i)
        thoughts: list[Mistaken] = [
            ("The weights have the wrong sign.", lambda: motor() + applied() + gravity() * 2)
        ]
        if plain is None:
            thoughts.append(("The torque or force of the drive is missing.", applied))
        return AskedQuantity(
            kinds.ACTIVE, (i,), lambda: motor() + applied(), joint=self.joint(i),
            thoughts=tuple(thoughts),
        )  # fmt: skip

    def _inertia(self, i: int) -> AskedQuantity:
        """Kane's generalized inertia force F_i*: minus mass times acceleration."""
        tau, applied = self._parts(i)
        law = "The inertia force is the opposite: F* = −(Σ m a · ∂v/∂q̇ + …)."
        opposite = (law, lambda: tau() + applied())
        return AskedQuantity(
            kinds.INERTIA_FORCE,
            (i,),
            lambda: -tau() - applied(),
            joint=self.joint(i),
            thoughts=(opposite,),
        )

    def _parts(self, i: int) -> tuple[Callable[[], Trig], Callable[[], Trig]]:
        """Functions that return the joint torque required for the motion, and the generalized force
        of gravity, springs and friction."""
        gravity, resisting = self.entry("g", i), self.entry("drives", i)
        return self.entry("tau", i), lambda: -gravity() - resisting()


MOVES = LexemePattern(
    "%dotted_letter | %mark | \\dot | \\ddot | _ ~d | !-%small_letter d ~d? ~o ~t %ends"
    " | !-%latin d ~d? < ~q | ~t ~h < ~e ~t ~a >? > ~%digit | ω | \\omega"
)
"""Signs that only lines about motions have."""


class BodiesAtRest(QuantitiesOfBodies):
    """The joint forces f_12, n_12 and the torques τ_i of an arm at rest; f is the external force on
    its tip."""

    records = tuple(record for record in BODY_QUANTITIES if record.reaction)

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer has joint forces, a force at the tip, and no motion."""
        forces = JOINT_FORCE.found_in(formulas) and not MOMENT.found_in(formulas)
        return forces and not MOVES.found_in(formulas)

    @cached_property
    def _is_known(self) -> bool:
        plain = self.setting.system is None and self.setting.turned is None
        return bool(self.setting.loads) and plain and not branches(self._setting.tree)

    @cached_property
    def _setting(self) -> Setting:
        symbols = self.setting.equations.symbols
        force = self.setting.force_at_tip
        return Setting(symbols, force, at_rest=True)

    @cached_property
    def _bodies(self) -> list[dict[str, Any]]:
        values = QuantityValues(self._setting, "explicit")
        return [values.of_body(i) for i in self._setting.order]

    def single(self) -> Iterator[NamedTarget]:
        if not self._is_known:
            return
        yield from components(self.vectors)
        reactions = SolvedReactions(self._setting)
        for i in self._setting.leaders:
            k = self._setting.index(i) + 1
            asked = AskedQuantity(
                kinds.LOAD, (k,), self.element(lambda i=i: reactions.motor(i)), k in self.passive,
                words=f"the torque or force at joint {k} that holds the arm at rest",
            )  # fmt: skip
            yield (f"tau{k}",), asked

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        if not self._is_known:
            return {}
        asked = AskedQuantity(kinds.LOAD, (), lambda: self.setting.zero, words="the load")
        ring = self.setting.ring
        force = [
            [replace(asked, compute=lambda x=x: ring[x], axis=x[1])]
            for x in self.setting.force_at_tip
        ]
        return {**self.vectors, **dict.fromkeys(VECTORS, force)}
