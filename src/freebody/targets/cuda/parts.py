"""Parts of a program, each computed by one thread: the whole program, or, where that does not fit a
thread's registers, some of its outputs.

A thread has 255 registers of 32 bits; what does not fit goes to memory and comes back (it is
spilled). Outputs computed apart repeat what they share, so a program is divided only where all
parts fit then and cost less than `LARGEST` times its operations: the derivatives of a UR5e's
dynamics are, those of a Panda's would be repeated ten times over. Where nothing fits anyway, a
program is divided as far as it must be to be assembled in seconds.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import Any

from freebody.lazy import cached_property
from freebody.program.passes import gather_factors, share_reciprocals
from freebody.program.program import Program
from freebody.scalars.operations import ARITY


@dataclass(frozen=True)
class ProgramPart:
    """Some results of a program with the nodes that they need, operands before their readers."""

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
        """The number of operations."""
        return sum(1 for index in self.nodes if ARITY[self.program.op[index]])

    @cached_property
    def alive(self) -> int:
        """The largest number of values that are alive at once, inputs included; results are written
        as soon as they are computed."""
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


def part(program: Program, results: Collection[int]) -> ProgramPart:
    """The part for given results: the nodes they need, in the program's order."""
    live = bytearray(len(program))
    for position in results:
        live[program.results[position]] = 1
    for index in range(len(program) - 1, -1, -1):
        if live[index]:
            for operand in program.operands(index):
                live[operand] = 1
    return ProgramPart(
        program, tuple(sorted(results)), tuple(i for i, needed in enumerate(live) if needed)
    )


def _one_by_one(piece: ProgramPart, results: Sequence[int]) -> ProgramPart:
    """The part reordered: all nodes that its first result needs, then those that the second needs
    in addition, and so on.

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


ROOM = {"float64": 156, "float32": 275}
"""Values alive at a time up to which `ptxas` spilled nothing, or in one of 60 formulas 48 bytes. It
is more than registers hold: inputs can be read again."""

_MOST = 2.0
"""Values alive at a time, over the room that there is, beyond which no division was ever found that
pays."""

OUTPUTS, ALIVE, FEWEST = 1024, 800, 200
"""Results, and values alive at a time, of one part at most: `ptxas` takes time with the square of
both. Parts of fewer results than the third are not divided for the values."""

_QUIETER = 0.875
"""Values alive one result after the other, over those in the traced order, up to which a whole
program is computed so: most then spilled less, some half as much; above, as many spilled more."""

FEW = 1000
"""Results that are constants, beyond which a part of their own writes them, in a loop."""

LARGEST = 2.5
"""Operations of all parts together, over those of the whole program. Not measured on a GPU: by data
sheets a spilled number costs as much as four to eight operations, so that for some programs less is
quicker; `benchmarks/on_cuda.py --whole` tells."""


def prepared(program: Program) -> Program:
    """The program in the order in which it was traced, in which recursions keep few values alive.

    The order that suits a loop on the CPU (`schedule`) begins with all sines; it takes 134
    registers where this one takes 94 (inverse dynamics of a UR5e), 180 where this one takes 128
    (forward dynamics).
    """
    return gather_factors(share_reciprocals(program))


def parts(program: Program, dtype: str) -> list[ProgramPart]:
    """Parts that together write every result once: constants apart where there are many, then runs
    of results that fit a thread, or the whole where none do; parts that would take an assembler
    minutes are split."""
    every = range(len(program.results))
    constant = [i for i in every if program.op[program.results[i]] == "const"]
    if len(constant) <= FEW:
        constant = []
    apart = set(constant)
    computed = [i for i in every if i not in apart]
    made = [part(program, constant)] if constant else []
    for piece in _fitting(program, computed, dtype):
        made += _assembled(piece)
    return made


def _fitting(program: Program, results: Sequence[int], dtype: str) -> list[ProgramPart]:
    """Runs of results, output by output and column by column, that fit a thread; the whole where
    none fit, or too many runs would be needed."""
    order, room = sorted(results, key=_by_columns(program)), ROOM[dtype]
    whole = part(program, order)
    if whole.alive > _MOST * room:
        return [_quiet(whole, order, _QUIETER)]
    made: list[ProgramPart] = []
    done = cost = 0
    while done < len(order):
        rest = part(program, order[done:])
        count = len(order) - done
        if rest.alive > room:  # of runs of growing length the last that fits
            count = bisect_left(
                range(1, count),
                True,
                key=lambda n: part(program, order[done : done + n]).alive > room,
            )
            if not count:
                return [_quiet(whole, order, _QUIETER)]
            rest = part(program, order[done : done + count])
        made.append(rest)
        done += count
        cost += rest.operations
        if cost > LARGEST * whole.operations:
            return [_quiet(whole, order, _QUIETER)]
    return made or [whole]


def _assembled(piece: ProgramPart) -> list[ProgramPart]:
    """The part, or its halves where these are quicker to assemble: split by directions of
    derivatives, with all outputs of one direction together, since they share most of their work."""
    program = piece.program
    order = sorted(piece.results, key=_by_directions(program))
    if len(order) <= OUTPUTS and (piece.alive <= ALIVE or len(order) < FEWEST):
        return [piece]
    middle = len(order) // 2
    halves = [_quiet(part(program, some), some) for some in (order[:middle], order[middle:])]
    return [piece for half in halves for piece in _assembled(half)]


def _quiet(piece: ProgramPart, results: Sequence[int], most: float = 1.0) -> ProgramPart:
    """The part as it was traced, or reordered result by result where that keeps at most the given
    fraction of its values alive."""
    other = _one_by_one(piece, results)
    return other if other.alive <= most * piece.alive else piece


def _entries(program: Program) -> list[tuple[int, tuple[int, ...]]]:
    """For each result its output, and its index in that output."""
    return [(k, index) for k, a in enumerate(program.outputs) for index in a.indices()]


def _by_columns(program: Program) -> Callable[[int], Any]:
    """Sort key of results: by output, then by the last axis, which is a derivative's direction."""
    entries = _entries(program)
    return lambda i: (entries[i][0], entries[i][1][-1:], entries[i][1])


def _by_directions(program: Program) -> Callable[[int], Any]:
    """A sort key of results: by the last axis, then by the axes before it from the last to the
    first, then by output."""
    entries = _entries(program)
    return lambda i: (entries[i][1][::-1], entries[i][0])
