"""Closed chains: the equations of their loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from freebody.derivations.check.asked.group import Named, QuantityGroup
from freebody.derivations.check.asked.quantity import AskedQuantity, Table


class LoopQuantities(QuantityGroup):
    """Φ, Φ_q, and what Φ_q q̈ must be."""

    def single(self) -> Iterator[Named]:
        if self.setting.system is None:
            return
        loops = self.setting.system.loops
        for i, name in enumerate(loops.names, 1):
            value = self.element(lambda i=i: loops.Phi[i - 1])
            words = f"the loop equation of {_in_words(name)}"
            yield (f"Phi{i}",), AskedQuantity("Phi", (i,), value, words=words)
            value = self.element(lambda i=i: loops.c[i - 1])
            words = f"what row {i} of Φ_q q̈ must be"
            yield (f"c{i}", f"gamma{i}"), AskedQuantity("closing", (i,), value, words=words)
            for j in self.numbers:
                value = self.element(
                    lambda i=i, j=j: self.setting.forces(loops.Phi_q[i - 1])[j - 1]
                )
                words = f"entry {i}, {j} of the Jacobian of the loop equations"
                yield (f"Phiq{i}{j}",), AskedQuantity("Phi_q", (i, j), value, words=words)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, Table]:
        if self.setting.system is None:
            return {}
        asked = {(target.family, target.index): target for target in single.values()}
        rows = range(1, len(self.setting.system.loops.names) + 1)
        return {
            "gamma": [[asked["closing", (i,)]] for i in rows],
            "Phi": [[asked["Phi", (i,)]] for i in rows],
            "Phiq": [[asked["Phi_q", (i, j)] for j in self.numbers] for i in rows],
        }


def _in_words(name: str) -> str:
    """The name of a loop's equation: closing_pin.fy is that of 'closing_pin' along y."""
    loop, _, part = name.rpartition(".")
    if part in ("m", "tension"):
        return f"{loop!r} for its {'angle' if part == 'm' else 'length'}"
    return f"{loop!r} {'along' if part[0] == 'f' else 'about'} {part[1:]}"
