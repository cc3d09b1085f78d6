"""The last steps of the methods that find the equations of motion: these sorted, what their terms
are, and limits in which they are known."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.derivations.derivation import Step
from freebody.derivations.expressions.expression import Expression
from freebody.derivations.methods.closed_form_steps import closed_form
from freebody.derivations.methods.limits import limits
from freebody.derivations.methods.setting import Setting
from freebody.derivations.methods.term_meanings import term_meanings


def ending(s: Setting, through_loops: Sequence[Expression] = ()) -> list[Step]:
    """The closed form and what follows it; through_loops: see `closed_form`."""
    closed = closed_form(s, through_loops)
    return [closed, *term_meanings(s, closed), *limits(s)]
