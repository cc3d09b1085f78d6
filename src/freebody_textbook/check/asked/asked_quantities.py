"""All quantities of a model that answers may be about, by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

from freebody.expressions.grammar.atoms import numbered, spellings
from freebody.expressions.grammar.lexemes import NOTHING, Lexemes
from freebody.expressions.grammar.tables.characters import DOT
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities import kinds
from freebody.expressions.quantities.kinds import USUAL_LETTERS
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked import loads
from freebody_textbook.check.asked.bodies import QuantitiesOfBodies
from freebody_textbook.check.asked.energies import AngularMomenta, EnergyQuantities
from freebody_textbook.check.asked.free_body import FreeBodyQuantities
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.joints import JointQuantities, VelocityCoefficients
from freebody_textbook.check.asked.loops import (
    BodiesOfTrees,
    LoopForceSystem,
    LoopQuantities,
    ReducedMass,
    ReducedQuantities,
)
from freebody_textbook.check.asked.more_of_bodies import (
    BodiesAtRest,
    CentreJacobians,
    KaneQuantities,
    QuantitiesInFrames,
)
from freebody_textbook.check.asked.parallel import ParallelQuantities
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.asked.tip import TipQuantities
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.methods.body_quantities import soft_names

_ABOUT_THE_JOINT = (
    "That is the moment of inertia about the joint, {} + {} {}²; {} is about the centre of mass."
)


class FormulaParameters(QuantityGroup):
    """The parameters lc1, I1, … that the model gives by formulas."""

    def single(self) -> Iterator[NamedTarget]:
        for name, value in self.setting.given.items():
            thoughts = self._thoughts(name)
            yield (name,), AskedQuantity(kinds.PARAMETER, (), lambda x=value: x, thoughts=thoughts)

    def _thoughts(self, name: str) -> tuple[Mistaken, ...]:
        """The mistake of using a link's moment of inertia about its joint instead of its centre of
        mass."""
        lc, m = (letter + name[1:] for letter in ("lc", "m"))
        if name[0] != "I" or not {lc, m} <= self.setting.ring.index.keys():
            return ()
        words = _ABOUT_THE_JOINT.format(*map(sym, (name, m, lc, name)))
        return ((words, partial(self._about_the_joint, name, lc, m)),)

    def _about_the_joint(self, name: str, lc: str, m: str) -> Trig:
        I_c, arm, mass = (self.setting.given.get(x, self.setting.ring[x]) for x in (name, lc, m))
        return I_c + mass * arm * arm


_GROUPS: tuple[type[QuantityGroup], ...] = (
    LoopQuantities,
    JointQuantities,
    EnergyQuantities,
    QuantitiesOfBodies,
    BodiesOfTrees,
    CentreJacobians,
    TipQuantities,
    ReducedQuantities,
    FormulaParameters,
)
"""The groups in their order: where two give a name to one number the first has it, of vectors and
matrices the last."""

_SPECIAL: tuple[type[QuantityGroup], ...] = (
    KaneQuantities,
    ParallelQuantities,
    ReducedMass,
    LoopForceSystem,
    BodiesAtRest,
    AngularMomenta,
)
"""Groups whose names mean other things in answers that are not about them."""


@dataclass(frozen=True)
class Targets:
    """The quantities of a model that answers may be about, by name; `velocity`: includes h, h1, …
    as in the lecture notes."""

    setting: RightEquations
    velocity: bool = False
    letters: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: USUAL_LETTERS)
    """Letters of the kinds, by their names."""
    based: bool = False
    """Whether the base is accelerated by -g, which then is in all accelerations."""
    framed: bool = False
    """Whether vectors are told in the axes of any body, {}^1v_2."""
    formulas: Lexemes = NOTHING
    """The formulas of the answer, which tell what it is about."""
    dotted: frozenset[str] = frozenset()
    """The words of the answer that have dots."""

    @cached_property
    def names(self) -> frozenset[str]:
        """Names of all quantities, in plain spelling."""
        return frozenset([*self.single, *self.tables])

    @cached_property
    def alone(self) -> frozenset[str]:
        """Names that stand only for vectors and matrices, never for one polynomial."""
        return frozenset(name for name in self.tables if name not in self.single)

    @cached_property
    def _groups(self) -> list[QuantityGroup]:
        if self.setting.is_free_body:
            return [FreeBodyQuantities(self.setting, self.letters, self.based)]
        in_frames = [QuantitiesInFrames] * self.framed
        kinds = (*_GROUPS, *in_frames, *[VelocityCoefficients] * self.velocity)
        return [kind(self.setting, self.letters, self.based, self.formulas) for kind in kinds]

    @cached_property
    def _special(self) -> list[QuantityGroup]:
        """Groups of quantities of special kinds of answers, which take precedence over the
        others."""
        kinds = [kind for kind in _SPECIAL if kind.is_told(self.formulas)]
        kinds = [] if self.setting.is_free_body else kinds
        return [kind(self.setting, self.letters, self.based, self.formulas) for kind in kinds]

    @cached_property
    def single(self) -> dict[str, AskedQuantity]:
        """Quantities with one polynomial as value by name, including rates that the answer
        names."""
        return self._of_groups | {
            name: target
            for name, target in self._rates()
            if name not in self._of_groups and name not in self.tables
        }

    def _rates(self) -> Iterator[tuple[str, AskedQuantity]]:
        """Rates of quantities, Ṫ1 and v̇_c2x, if the answer contains their names."""
        bare = [x.replace(DOT, "").replace("dot", "") for x in self.dotted]
        for name, target in self._of_groups.items() if bare else ():
            written = self._dotted(name) if any(name in x for x in bare) else ()
            if not written or target.in_world is not None:  # rates there are those of vectors
                continue
            try:
                rate = self.setting.rate(target.compute())
            except AnswerError:  # it is not known how that changes
                continue
            asked = AskedQuantity(
                kinds.DERIVATIVE, (), lambda x=rate: x, words=f"the rate of {target.title}"
            )
            yield from ((x, asked) for x in written)

    def _dotted(self, name: str) -> list[str]:
        """Spellings of a name with one dot that occur in the answer."""
        return [x for x in spellings(*numbered(name), 1) if any(x in y for y in self.dotted)]

    @cached_property
    def _of_groups(self) -> dict[str, AskedQuantity]:
        """Quantities by the names that their groups give them."""
        found: dict[str, AskedQuantity] = {}
        for group in (*self._special, *self._groups):
            for names, target in group.single():
                for name in names:
                    found.setdefault(name, target)
        return found

    @cached_property
    def namesakes(self) -> dict[str, AskedQuantity]:
        """Quantities by names that other quantities have too."""
        groups = (*self._special, *self._groups)
        return {name: x for group in groups for names, x in group.namesakes() for name in names}

    @cached_property
    def of_bodies(self) -> dict[str, str]:
        """Vectors and matrices that names stand for in equations of bodies."""
        groups = (x.in_equations_of_bodies for x in self._groups)
        return {name: meant for x in groups for name, meant in x.items() if meant in self.tables}

    @cached_property
    def tables(self) -> dict[str, QuantityTable]:
        """Vectors (as one column) and matrices of quantities, by name."""
        found: dict[str, QuantityTable] = {}
        for group in (*self._groups, *self._special):
            found |= group.tables(self._of_groups)
        return found

    @property
    def undriven(self) -> list[AskedQuantity]:
        """The torques, equal to 0, of the joints without a drive."""
        found: dict[tuple[int, ...], AskedQuantity] = {}
        for target in self.single.values():
            if target.idle:
                found.setdefault(target.index, target)
        return [found[index] for index in sorted(found)]

    @cached_property
    def soft(self) -> frozenset[str]:
        """Names of bodies' vectors that users often give to quantities of their own."""
        return soft_names(len(self.setting.symbols.model.bodies)) | {*loads.VECTORS, "W", "r"}
