"""The last steps of the methods that find the equations of motion: these sorted, what their terms
are, and limits in which they are known."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.expressions.expression import Expression
from freebody_textbook.derivation import Step
from freebody_textbook.methods.closed_form_steps import closed_form
from freebody_textbook.methods.limits import limits
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.term_meanings import term_meanings


def ending(s: Setting, through_loops: Sequence[Expression] = ()) -> list[Step]:
    """The closed form and what follows it; through_loops: see `closed_form`."""
    closed = closed_form(s, through_loops)
    return [closed, *term_meanings(s, closed), *limits(s)]
