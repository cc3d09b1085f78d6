"""Statics: an arm that is held at rest while a force acts on its tip."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody_textbook.check.asked.bodies import QuantitiesOfBodies
from freebody_textbook.check.asked.group import NamedTarget
from freebody_textbook.check.asked.load_names import JOINT_FORCE, MOMENT, VECTORS
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.methods.body_quantities import BODY_QUANTITIES
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting
from freebody_textbook.relations.quantities import QuantityValues, branches

MOVES = LexemePattern(
    "%dotted_letter | %mark | \\dot | \\ddot | _ ~d | !-%small_letter d ~d? ~o ~t %ends"
    " | !-%latin d ~d? < ~q | ~t ~h < ~e ~t ~a >? > ~%digit | ω | \\omega"
)
"""What only lines about motions have."""


class BodiesAtRest(QuantitiesOfBodies):
    """f_12, n_12 and τ_i of an arm at rest; f is the force on its tip, from outside."""

    records = tuple(record for record in BODY_QUANTITIES if record.reaction)

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer has forces in joints, a force at the tip, and nothing that moves."""
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
        yield from self.entries_of(self.vectors)
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
