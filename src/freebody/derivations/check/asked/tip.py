"""The tip: its position, velocity and acceleration, and the Jacobian."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from freebody.derivations.check.asked.group import Named, QuantityGroup
from freebody.derivations.check.asked.quantity import AskedQuantity, Table
from freebody.derivations.check.vocabulary import spellings
from freebody.derivations.equations.kinematics import Kinematics
from freebody.derivations.polynomials.determinant import determinant
from freebody.lazy import cached_property

_TIP = {"x": ("x", "xP", "xp", "xE", "xtip", "px"), "y": ("y", "yP", "yp", "yE", "ytip", "py")}
_TIP["z"] = ("z", "zP", "zp", "zE", "ztip", "pz")


class TipQuantities(QuantityGroup):
    """x, y, r, J, J̇, det J."""

    def single(self) -> Iterator[Named]:
        if self._tip is not None:
            yield from self._of_tip(self._tip)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, Table]:
        if self._tip is None:
            return {}
        J = [[single[f"J{i}{j}"] for j in self.numbers] for i in self._rows]
        position = J[: self.setting.symbols.model.dim]
        return {"J": J, **self._tip_vectors(self._tip), "JP": position}

    @cached_property
    def _tip(self) -> Kinematics | None:
        symbols = self.setting.equations.symbols
        return None if symbols.model.tip is None else Kinematics(symbols, symbols.model.tip)

    def _tip_vectors(self, tip: Kinematics) -> dict[str, Table]:
        """r, ṙ, r̈ and J̇, whose rows are those of the position."""
        dim = self.setting.symbols.model.dim
        found: dict[str, Table] = {}
        for dots, vector, words in (
            (0, "position", "the position of the tip"),
            (1, "velocity", "the velocity of the tip"),
            (2, "acceleration", "the acceleration of the tip"),
        ):
            column = []
            for k in range(dim):
                value = self.element(lambda k=k, x=vector: getattr(tip, x)[k])
                column.append([AskedQuantity("tip", (), value, axis="xyz"[k], words=words)])
            for letter in ("r", "rP"):
                found |= dict.fromkeys(spellings(letter, "", dots), column)
        rows = []
        for i in range(dim):
            row = []
            for j in range(self.count):
                value = self.element(lambda i=i, j=j: self.setting.forces(tip.J_dot[i])[j])
                words = f"entry {i + 1}, {j + 1} of the rate of the tip's Jacobian"
                row.append(AskedQuantity("J_d", (i + 1, j + 1), value, words=words))
            rows.append(row)
        return found | dict.fromkeys(spellings("J", "", 1), rows)

    @property
    def _rows(self) -> range:
        """Of the Jacobian, from 1."""
        return range(1, 4 if self.setting.is_planar else 7)

    def _of_tip(self, tip: Kinematics) -> Iterator[Named]:
        for i in self._rows:
            for j in self.numbers:
                entry = self.element(lambda i=i, j=j: self.setting.forces(tip.J[i - 1])[j - 1])
                yield (f"J{i}{j}",), AskedQuantity("J", (i, j), entry)
        for k in range(self.setting.symbols.model.dim):
            names = _TIP["xyz"[k]]
            yield names, AskedQuantity("tip", (), self.element(lambda k=k: tip.position[k]))
            for dots, family, vector in ((1, "tip_d", "velocity"), (2, "tip_dd", "acceleration")):
                dotted = tuple(s for name in names[:2] for s in spellings(name, "", dots))
                dotted += ("va"[dots - 1] + "xyz"[k],)
                value = self.element(lambda k=k, vector=vector: getattr(tip, vector)[k])
                yield dotted, AskedQuantity(family, (), value)
        rows = self._square(tip)
        if rows is not None:
            value = self.element(
                lambda: determinant([tip.J[i] for i in rows], self.setting.equations.symbols)
            )
            yield ("detJ",), AskedQuantity("det", (), value)

    def _square(self, tip: Kinematics) -> range | None:
        """The rows of the Jacobian that make it square: in space of three joints those of the
        position, of a wrist those of the orientation."""
        if self.setting.is_planar:
            return range(self.count) if self.count in (2, 3) else None
        if self.count == 6:
            return range(6)
        if self.count != 3:
            return None
        moves = any(not self.setting.element(x).is_zero for row in tip.J[:3] for x in row)
        return range(3) if moves else range(3, 6)
