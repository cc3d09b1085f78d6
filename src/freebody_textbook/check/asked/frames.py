"""Vectors of bodies in the axes of any body, as Craig writes them: {}^1v_2 is v_2 along the axes of
body 1, {}^1P_2 the origin of body 2 as seen from that of body 1."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from freebody.expressions.grammar.words import FRAMES
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.bodies import QuantitiesOfBodies
from freebody_textbook.check.asked.group import NamedTarget
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.methods.body_quantities import BODY_QUANTITIES, numbers

_WORLD = "This would be right in the world's axes; here the components are along those of body {}."


class QuantitiesInFrames(QuantitiesOfBodies):
    """Vectors of bodies with a frame: their plain names end with its mark, see `FRAMES`."""

    def single(self) -> Iterator[NamedTarget]:
        for name, table in self._framed.items():
            for (entry,) in table:
                if entry.axis or len(table) == 1:
                    yield (name[:-1] + entry.axis + name[-1],), entry

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._framed

    @cached_property
    def _framed(self) -> dict[str, QuantityTable]:
        found: dict[str, QuantityTable] = {}
        count = len(self._bodies)
        for n in range(1, count + 1):
            for record in BODY_QUANTITIES:
                own = next(iter(record.spelt(n)), "")
                table = self.vectors.get(own)
                if table is None or record.matrix or record.framed is None or record.only:
                    continue
                further = [x.format(**numbers(n)) for x in record.framed]
                for frame in range(min(count, len(FRAMES) - 1) + 1):
                    told = self._seen(table, n, frame, record.is_place)
                    for name in dict.fromkeys((*record.spelt(n), *further)):
                        found.setdefault(name + FRAMES[frame], told)
        ground = {x: y for x, y in self.vectors.items() if x.strip("˙'d") in ("v0", "omega0")}
        return found | {name + FRAMES[0]: table for name, table in ground.items()}

    def _seen(self, table: QuantityTable, n: int, frame: int, is_place: bool) -> QuantityTable:
        """A vector along the axes of a body; of a place how it lies from that body's origin."""
        if len(table) == 1 or (frame == 0 and self.setting.is_planar):
            return table
        if table[0][0].in_world is not None and frame == n:
            return table
        world = [entry.in_world or entry.compute for (entry,) in table]
        text = f"{table[0][0].words}, along the axes of body {frame}"

        def component(k: int) -> Callable[[], Trig]:
            def value() -> Trig:
                values: Sequence[Any] = [x() for x in world]
                if frame and is_place:
                    origin = [entry.compute() for (entry,) in self.vectors[f"r{frame}"]]
                    values = [a - b for a, b in zip(values, origin, strict=True)]
                terms = (self._axis_of(frame, k, i) * x for i, x in enumerate(values))
                return sum(terms, self.setting.zero)

            return value

        return [
            [
                AskedQuantity(
                    kinds.OF_BODY, (n,), component(k), axis=entry.axis, words=text,
                    thoughts=((_WORLD.format(frame), world[k]),) if frame else (),
                )
            ]
            for k, (entry,) in enumerate(table)
        ]  # fmt: skip

    def _axis_of(self, frame: int, k: int, i: int) -> Trig:
        """Component i, in the world, of the k-th axis of a body."""
        if frame == 0:
            return self.setting.zero + int(i == k)
        s = self.setting.equations.symbols
        x = self._setting.world[self._setting.order[frame - 1]][0][i][k]
        return self.setting.element(s.element(x))
