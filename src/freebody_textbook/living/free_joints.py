"""Joints without motor of an open chain in a page: their accelerations follow from the others."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from freebody.expressions.polynomials.symbols import SECOND
from freebody_textbook.derivation import Derivation
from freebody_textbook.living.kernel import PageProgram
from freebody_textbook.methods import METHODS


class FreeJoints:
    """The accelerations for which these joints need no torque; values: the chain's quantities."""

    key = "free"
    why = "no motor"

    def __init__(self, derivation: Derivation, values: Mapping[str, Any]):
        model = derivation.equations.symbols.model
        moving = bool(derivation.tau) and not METHODS[derivation.method].at_rest
        coordinates = derivation.equations.symbols.coordinates
        self.solved_names = tuple(coordinates[k] + SECOND for k in model.passive if moving)
        self._needed = [values[f"tau{k + 1}"] for k in model.passive if moving]

    @property
    def names(self) -> tuple[str, ...]:
        """Symbols that the page needs for it."""
        return self.solved_names

    def page(self, kernel: PageProgram, inputs: Mapping[str, int]) -> dict[str, Any]:
        """The accelerations and places of what the joints need, which is linear in them."""
        return {
            "accelerations": [inputs[name] for name in self.solved_names],
            "needs": [kernel.places(tau)[0] for tau in self._needed],
        }
