"""Parameters that formulas give, as I = m l²/12 of uniform rods: an answer may begin with them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

from freebody.expressions.printed_names import sym
from freebody.expressions.quantities import kinds
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken

_ABOUT_THE_JOINT = (
    "That is the moment of inertia about the joint, {} + {} {}²; {} is about the centre of mass."
)


class FormulaParameters(QuantityGroup):
    """lc1, I1, … where formulas give them."""

    def single(self) -> Iterator[NamedTarget]:
        for name, value in self.setting.given.items():
            thoughts = self._thoughts(name)
            yield (name,), AskedQuantity(kinds.PARAMETER, (), lambda x=value: x, thoughts=thoughts)

    def _thoughts(self, name: str) -> tuple[Mistaken, ...]:
        """Of a link's moment of inertia: that about its joint."""
        lc, m = (letter + name[1:] for letter in ("lc", "m"))
        if name[0] != "I" or not {lc, m} <= self.setting.ring.index.keys():
            return ()
        words = _ABOUT_THE_JOINT.format(*map(sym, (name, m, lc, name)))
        return ((words, partial(self._about_the_joint, name, lc, m)),)

    def _about_the_joint(self, name: str, lc: str, m: str) -> Trig:
        I_c, arm, mass = (self.setting.given.get(x, self.setting.ring[x]) for x in (name, lc, m))
        return I_c + mass * arm * arm
