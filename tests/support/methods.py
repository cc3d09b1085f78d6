"""Names of the methods of derivation, and the ways of each to the torques."""

from __future__ import annotations

import itertools

from freebody_textbook.methods import METHODS as TABLE

METHODS = list(TABLE)
"""Names of all methods of derivation."""
_SHOWN = {"values"}
"""Options that choose only how lines are written."""
WAYS = [
    (method.name, dict(zip((option.name for option in options), chosen, strict=True)))
    for method in TABLE.values()
    if method.finds_torques and not method.at_rest and not method.closed_first
    for options in ([option for option in method.options if option.name not in _SHOWN],)
    for chosen in itertools.product(*(option.choices for option in options))
]
"""The ways from a motion to the torques: every method of open chains, with every choice of its
options that makes another way."""
