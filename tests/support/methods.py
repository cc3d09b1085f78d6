"""Names of the methods of derivation, and the ways of each to the torques, as the documentation of
`fb.derive` tells them."""

from __future__ import annotations

import inspect
import itertools
import re
from typing import Any

import freebody as fb

_TOLD = re.compile(r"^'(?P<name>[\w-]+)': .*?(?: Options: (?P<options>.*?))?$", re.MULTILINE)
_OPTION = re.compile(r"(\w+)=('[\w-]+'(?: \| '[\w-]+')*)")
_OPTIONS = {
    told["name"]: {
        name: re.findall(r"[\w-]+", choices)
        for name, choices in _OPTION.findall(told["options"] or "")
        if name != "values"  # it chooses only how lines are written
    }
    for told in _TOLD.finditer(inspect.getdoc(fb.derive) or "")
}
"""The options of each method, with their choices."""
METHODS = list(_OPTIONS)
"""Names of all methods of derivation."""
_ENDING_ELSEWHERE = {"lagrange-first-kind", "statics", "kinematics"}
"""Methods that end in multipliers, in forces at rest or in no torques."""
WAYS = [
    (method, dict(zip(options, chosen, strict=True)))
    for method, options in _OPTIONS.items()
    if method not in _ENDING_ELSEWHERE
    for chosen in itertools.product(*options.values())
]
"""The ways from a motion to the torques: every method of open chains, with every choice of its
options that makes another way."""


def agree(first: Any, second: Any) -> bool:
    """Whether two derivations of one model end in identical polynomials for the torques."""
    assert len(first.tau) == len(second.tau) > 0
    return all((a - b).is_zero for a, b in zip(first.tau, second.tau, strict=True))
