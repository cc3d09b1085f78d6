"""What one thread computes of a program: all of it, or where that does not fit its registers some
of the outputs.

A thread has 255 registers of 32 bits; what does not fit goes to memory and comes back (it is
spilled). Outputs computed apart repeat what they share, so a program is divided only where all
parts fit then and cost less than `LARGEST` times its operations: the derivatives of a UR5e's
dynamics are, those of a Panda's would be repeated ten times over.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from freebody.program.passes import gather_factors, share_reciprocals
from freebody.program.program import Program
from freebody.scalars.operations import ARITY

ROOM = {"float64": 156, "float32": 275}
"""Values alive at a time up to which `ptxas` spilled nothing, or in one of 60 formulas 48 bytes. It
is more than registers hold: inputs can be read again."""

MOST = 2.0
"""Values alive at a time, over the room that there is, beyond which no division was ever found that
pays."""

OUTPUTS = 1000
"""Results of one part at most: `ptxas` takes time with their square."""

FEW = 1000
"""Results that are constants, beyond which a part of their own writes them, in a loop."""

LARGEST = 2.5
"""Operations of all parts together, over those of the whole program. Not measured on a GPU: by data
sheets a spilled number costs as much as four to eight operations, so that for some programs less is
quicker; `benchmarks/on_cuda.py --whole` tells."""


@dataclass(frozen=True)
class Part:
    """Some of the results of a program, and the nodes that they need, in order."""

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


def prepared(program: Program) -> Program:
    """The program in the order in which it was traced: recursions keep few values alive.

    The order that suits a loop on the CPU (`schedule`) begins with all sines; it takes 134
    registers where this one takes 94 (inverse dynamics of a UR5e), 180 where this one takes 128
    (forward dynamics).
    """
    return gather_factors(share_reciprocals(program))


def part(program: Program, results: Collection[int]) -> Part:
    """What these results need."""
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


def alive(piece: Part) -> int:
    """The most values that are alive at a time, inputs included; a result is written when it is
    there."""
    program = piece.program
    last = {}
    for index in piece.nodes:
        for operand in program.operands(index):
            last[operand] = index
    ends = Counter[int]()
    now = most = 0
    for index in piece.nodes:
        if program.op[index] != "const" and index in last:
            now += 1
            ends[last[index]] += 1
        most = max(most, now)
        now -= ends[index]
    return most


def parts(program: Program, dtype: str) -> list[Part]:
    """Parts that write every result once: constants apart where they are many, then runs that fit
    or the whole where none do, and none of too many results."""
    every = range(len(program.results))
    constant = [i for i in every if program.op[program.results[i]] == "const"]
    if len(constant) <= FEW:
        constant = []
    apart = set(constant)
    computed = [i for i in every if i not in apart]
    made = [part(program, constant)] if constant else []
    for piece in _fitting(program, computed, dtype):
        made += _of_few_outputs(piece)
    return made


def _fitting(program: Program, results: Sequence[int], dtype: str) -> list[Part]:
    """Runs of results, output by output and column by column, that fit; the whole where none do, or
    too many."""
    whole = part(program, results)
    if alive(whole) > MOST * ROOM[dtype]:
        return [whole]
    order = sorted(results, key=_by_columns(program))
    made: list[Part] = []
    done = cost = 0
    while done < len(order):
        rest = part(program, order[done:])
        count = len(order) - done
        if alive(rest) > ROOM[dtype]:  # of runs of growing length the last that fits
            count = bisect_left(
                range(1, count),
                True,
                key=lambda n: _too_many(program, order[done : done + n], dtype),
            )
            if not count:
                return [whole]
            rest = part(program, order[done : done + count])
        made.append(rest)
        done += count
        cost += rest.operations
        if cost > LARGEST * whole.operations:
            return [whole]
    return made or [whole]


def _of_few_outputs(piece: Part) -> list[Part]:
    """The part in so many equal ones that none has too many results, direction by direction, all
    outputs of one together: these share most of their work."""
    count = -(-len(piece.results) // OUTPUTS)
    if count < 2:
        return [piece]
    order = sorted(piece.results, key=_by_directions(piece.program))
    ends = [len(order) * k // count for k in range(count + 1)]
    return [part(piece.program, order[a:b]) for a, b in pairwise(ends)]


def _too_many(program: Program, results: Sequence[int], dtype: str) -> bool:
    return alive(part(program, results)) > ROOM[dtype]


def _entries(program: Program) -> list[tuple[int, tuple[int, ...]]]:
    """Of each result its output and its index there."""
    return [(k, index) for k, a in enumerate(program.outputs) for index in a.indices()]


def _by_columns(program: Program) -> Callable[[int], Any]:
    """The order of results: output by output, its last axis slowest, as a derivative's is the
    direction."""
    entries = _entries(program)
    return lambda i: (entries[i][0], entries[i][1][-1:], entries[i][1])


def _by_directions(program: Program) -> Callable[[int], Any]:
    """The last axis slowest, then the others from behind, then the outputs."""
    entries = _entries(program)
    return lambda i: (entries[i][1][::-1], entries[i][0])
