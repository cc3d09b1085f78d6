"""Closed chains: the equations of their loops."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from freebody.expressions.grammar.dotted_names import spellings
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable
from freebody_textbook.check.asked.right_equations import loop_equation
from freebody_textbook.closed_chains.first_kind import multiplier_names


class LoopQuantities(QuantityGroup):
    """Φ, Φ_q, their rates, what Φ_q q̈ must be, and λ."""

    def single(self) -> Iterator[NamedTarget]:
        for i, (x,) in enumerate(self._tables.get("Phi", []), 1):
            (rate,), (c,) = self._tables["Phi_d"][i - 1], self._tables["c"][i - 1]
            yield (f"Phi{i}",), x
            yield tuple(spellings("Phi", str(i), 1)), rate
            yield tuple(spellings("Phi", str(i), 2)), self._second(rate)
            yield (f"c{i}",), replace(c, also=tuple(self._velocity_term(i)))
            for j, entry in enumerate(self._tables["Phiq"][i - 1], 1):
                yield (f"Phiq{i}{j}",), entry

    def _velocity_term(self, i: int) -> Iterator[Mistaken]:
        """The velocity term of a joint, which c_i may be besides."""
        if i in self.numbers:
            note = f"It is read as the velocity term of {self.joint(i)}."
            yield note, self.entry(kinds.VELOCITY.name, i)

    def _second(self, rate: AskedQuantity) -> AskedQuantity:
        """The second derivative of a loop equation."""
        words = rate.words.replace("the rate", "the second derivative", 1)
        value = rate.polynomial().along(self.setting.symbols.rates)
        return AskedQuantity(kinds.LOOP_RATE, rate.index, lambda: value, words=words)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        found = dict(self._tables)
        found |= {"gamma": found["c"]} if found else {}
        for name, letter in (("Phi_d", "Phi"), ("Phiq_d", "Phiq")):
            if table := found.pop(name, None):
                found |= dict.fromkeys(spellings(letter, "", 1), table)
        return found

    @cached_property
    def _tables(self) -> dict[str, QuantityTable]:
        if self.setting.system is None:
            return {}
        loops, rates = self.setting.system.loops, self.setting.symbols.rates
        signs = [
            1 - 2 * (loop_equation(i) in self.setting.opposed) for i in range(1, len(loops.c) + 1)
        ]
        rows = [
            [self.setting.element(x) * sign for x in self.setting.forces(row)]
            for sign, row in zip(signs, loops.Phi_q, strict=True)
        ]
        ring = self.setting.ring
        found: dict[str, QuantityTable] = {
            name: [] for name in ("Phi", "Phi_d", "c", "Phiq", "Phiq_d", "lam")
        }
        for i, (name, lam) in enumerate(zip(loops.names, multiplier_names(loops), strict=True), 1):
            sign, row = signs[i - 1], rows[i - 1]
            phi, c = (self._element(x[i - 1]) * sign for x in (loops.Phi, loops.c))
            told = _in_words(name)
            columns = {
                "Phi": (kinds.LOOP, phi, f"the loop equation of {told}"),
                "Phi_d": (
                    kinds.LOOP_RATE,
                    phi.along(rates),
                    f"the rate of the loop equation of {told}",
                ),
                "c": (kinds.LOOP_REST, c, f"what row {i} of Φ_q q̈ must be"),
                "lam": (
                    kinds.MULTIPLIER,
                    ring[lam],
                    f"the multiplier of the loop equation of {told}",
                ),
            }
            for key, (kind, value, words) in columns.items():
                asked = AskedQuantity(kind, (i,), lambda value=value: value, words=words)
                found[key].append([asked])
            whole = "the Jacobian of the loop equations"
            for key, of in (("Phiq", whole), ("Phiq_d", f"the rate of {whole}")):
                found[key].append(
                    [
                        AskedQuantity(
                            kinds.LOOP_JACOBIAN, (i, j),
                            lambda x=x, dots=key[4:]: x.along(rates) if dots else x,
                            words=f"entry {i}, {j} of {of}",
                        )
                        for j, x in enumerate(row, 1)
                    ]
                )  # fmt: skip
        return found

    def _element(self, x: Trig) -> Trig:
        return self.setting.element(x)


def _in_words(name: str) -> str:
    """The name of a loop's equation: closing_pin.fy is that of 'closing_pin' along y."""
    loop, _, part = name.rpartition(".")
    if part in ("m", "tension"):
        return f"{loop!r} for its {'angle' if part == 'm' else 'length'}"
    return f"{loop!r} {'along' if part[0] == 'f' else 'about'} {part[1:]}"
