"""Some of the results of a program, what they need, and in which order that keeps few values
alive."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from freebody.lazy import cached_property
from freebody.program.program import Program
from freebody.scalars.operations import ARITY


@dataclass(frozen=True)
class Part:
    """Some of the results of a program, and the nodes that they need, in an order in which operands
    precede."""

    program: Program
    results: tuple[int, ...]
    """Positions among the scalars of all outputs."""
    nodes: tuple[int, ...]

    @property
    def constant(self) -> bool:
        """Whether all results are constants."""
        return all(self.program.op[index] == "const" for index in self.nodes)

    @property
    def operations(self) -> int:
        """How many there are."""
        return sum(1 for index in self.nodes if ARITY[self.program.op[index]])

    @cached_property
    def alive(self) -> int:
        """The most values that are alive at a time, inputs included; a result is written when it is
        there."""
        program = self.program
        last = {
            operand: index
            for index in self.nodes
            for operand in program.operands(index)
            if program.op[operand] != "const"
        }
        ends = Counter(last.values())
        now = most = 0
        for index in self.nodes:
            now += index in last
            most = max(most, now)
            now -= ends[index]
        return most


def part(program: Program, results: Collection[int]) -> Part:
    """What these results need, in the program's order."""
    live = bytearray(len(program))
    for position in results:
        live[program.results[position]] = 1
    for index in range(len(program) - 1, -1, -1):
        if live[index]:
            for operand in program.operands(index):
                live[operand] = 1
    return Part(
        program, tuple(sorted(results)), tuple(i for i, needed in enumerate(live) if needed)
    )


def one_by_one(piece: Part, results: Sequence[int]) -> Part:
    """The part in another order: all that its first result needs, then what the second needs
    besides, and so on.

    A recursion over a tree with many branches does one branch after the other then, where as
    traced it does all of them outward and then all inward.
    """
    program = piece.program
    nodes: list[int] = []
    begun = bytearray(len(program))
    for position in results:
        waiting = [program.results[position]]
        while waiting:
            index = waiting[-1]
            missing = [i for i in program.operands(index) if not begun[i]]
            if missing:
                waiting.append(missing[0])
                continue
            waiting.pop()
            if not begun[index]:
                begun[index] = 1
                nodes.append(index)
    return replace(piece, nodes=tuple(nodes))
