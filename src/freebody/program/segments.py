"""Cut a program into segments: pieces of straight-line code, with the sines and cosines between
them.

Code generation grows faster than linearly with the length of a function, so long programs are cut;
values that cross a cut live in slots of a tile, one vector of lanes each. Constants and uniform
inputs are at hand everywhere, without a slot. Sines and cosines are computed by a
routine that reads and writes slots, so they stand between segments too: first what leads to their
arguments, then they, then the rest.
"""

from __future__ import annotations

from bisect import bisect_left
from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass, field
from itertools import accumulate, pairwise

from freebody.program.program import Program
from freebody.scalars.operations import ARITY

LONGEST = 1000
"""Weight of one segment: a node counts 1, the store of an output `_STORE`."""

_STORE = 4  # LLVM's time grows with the square of the stores in a function


@dataclass
class Segment:
    """A piece of straight-line code: nodes to compute in order, slots to load before and to store
    after."""

    nodes: list[int]
    loads: dict[int, int] = field(default_factory=dict)
    stores: dict[int, list[int]] = field(default_factory=dict)


@dataclass(frozen=True)
class SinCos:
    """Slots of an angle, of its sine and of its cosine, which are computed between segments."""

    argument: int
    sine: int
    cosine: int


@dataclass(frozen=True)
class SegmentedProgram:
    """A program as steps in order, with the slots of inputs, results and passed values.

    Inputs come first, but for the uniform ones, then each different result once, then what crosses
    cuts.
    """

    steps: tuple[Segment | SinCos, ...]
    slots: int
    results: dict[int, int]
    """Node of a result -> slot; equal entries of an output share one."""


def segment(program: Program, longest: int = LONGEST) -> SegmentedProgram:
    """The program cut into segments, in its order within each stage; its uniform inputs must be the
    last."""
    stage = _stages(program)
    last = max(stage, default=0)
    stores = Counter(program.results)
    steps: list[
        list[int]
    ] = []  # nodes of each step; a step of sines and cosines holds those of one argument
    for k in range(last + 1):
        steps += _trigonometric(
            program, [i for i, s in enumerate(stage) if s == k and program.op[i] in _TRIG]
        )
        plain = [
            i
            for i, s in enumerate(stage)
            if s == k and ARITY[program.op[i]] and program.op[i] not in _TRIG
        ]
        steps += _cut(plain, stores, longest)
    if not steps or program.op[steps[-1][0]] in _TRIG:
        steps.append([])  # somewhere to store outputs that are inputs, constants or sines
    return _allocate(program, steps)


_TRIG = ("sin", "cos")


def _stages(program: Program) -> list[int]:
    """The stage of each node: stage k is the k-th round of sines and cosines followed by
    arithmetic.

    Sines and cosines come as early as they can, arithmetic as late: before the round that needs it,
    else at the end.
    """
    depth = [0] * len(program)  # rounds of sines and cosines behind a node
    for index, op in enumerate(program.op):
        depth[index] = max((depth[i] for i in program.operands(index)), default=0) + (op in _TRIG)
    stage = [max(depth, default=0)] * len(program)
    for index in range(len(program) - 1, -1, -1):
        if program.op[index] in _TRIG:
            stage[index] = depth[index]
        needed = stage[index] - (program.op[index] in _TRIG)
        for operand in program.operands(index):
            stage[operand] = min(stage[operand], needed)
    return stage


def _cut(nodes: list[int], stores: Counter[int], longest: int) -> list[list[int]]:
    """Nodes cut into pieces of about equal weight, none heavier than `longest` (or a single
    node)."""
    ends = list(accumulate(1 + _STORE * stores[index] for index in nodes))
    pieces = -(-ends[-1] // longest) if ends else 0
    share = ends[-1] / pieces if pieces else 0.0
    cuts = [bisect_left(ends, share * k) for k in range(1, pieces)]
    return [piece for i, j in pairwise([0, *cuts, len(nodes)]) if (piece := nodes[i:j])]


def _trigonometric(program: Program, nodes: list[int]) -> list[list[int]]:
    pairs: dict[int, list[int]] = {}
    for index in nodes:
        pairs.setdefault(program.a[index], []).append(index)
    return list(pairs.values())


def _allocate(program: Program, steps: list[list[int]]) -> SegmentedProgram:
    """The segmented program with slots for values that cross steps; a slot is reused once its
    value's last reader is done."""
    sampled = program.sampled_size
    results = {index: sampled + k for k, index in enumerate(dict.fromkeys(program.results))}
    stored = _stored(program, steps, results)
    arriving = _arriving(program, steps, stored)
    slots = _Slots(
        {i: program.a[i] for i, op in enumerate(program.op) if op == "input"},
        {index: number for number, indices in enumerate(arriving) for index in indices},
        sampled + len(results),
    )
    done: list[Segment | SinCos] = []
    for number, nodes in enumerate(steps):
        if nodes and program.op[nodes[0]] in _TRIG:
            done.append(_sin_cos(program, number, nodes, slots))
        else:
            loads = {index: slots.of[index] for index in arriving[number]}
            stores = {
                index: [slots.taken(number, index)] for index in nodes if index in slots.last_reader
            }
            for index in stored[number]:
                stores[index] = [*stores.get(index, ()), results[index]]
            done.append(Segment(nodes, loads, stores))
        slots.release(number)
    return SegmentedProgram(tuple(done), slots.count, results)


def _stored(program: Program, steps: list[list[int]], results: Iterable[int]) -> list[list[int]]:
    """The results that each step stores: in the step that computes them, or in the last step where
    that one cannot."""
    producer = {
        index: number
        for number, nodes in enumerate(steps)
        for index in nodes
        if program.op[index] not in _TRIG
    }
    stored: list[list[int]] = [[] for _ in steps]
    for index in results:
        stored[producer.get(index, -1)].append(index)
    return stored


def _arriving(program: Program, steps: list[list[int]], stored: list[list[int]]) -> list[list[int]]:
    """The values that each step reads and that come from another step or from an input of every
    sample."""
    sampled = program.sampled_size
    found = []
    for nodes, results in zip(steps, stored, strict=True):
        own = set(nodes)
        read = {i for node in nodes for i in program.operands(node)} | set(results)
        found.append(
            [
                index
                for index in read
                if index not in own
                and program.op[index] != "const"
                and (program.op[index] != "input" or program.a[index] < sampled)
            ]
        )
    return found


@dataclass
class _Slots:
    """The slot of each value that crosses steps; a slot is free again after the step that reads its
    value last."""

    of: dict[int, int]
    last_reader: dict[int, int]
    count: int
    _free: list[int] = field(default_factory=list)
    _expiring: dict[int, list[int]] = field(default_factory=dict)

    def taken(self, step: int, index: int) -> int:
        """A free slot for a value that a step computes."""
        if self._free:
            slot = self._free.pop()
        else:
            slot, self.count = self.count, self.count + 1
        self.of[index] = slot
        self._expiring.setdefault(self.last_reader.get(index, step), []).append(slot)
        return slot

    def release(self, step: int) -> None:
        """Free the slots that nothing reads after a step."""
        self._free += self._expiring.pop(step, [])


def _sin_cos(program: Program, step: int, nodes: list[int], slots: _Slots) -> SinCos:
    """The step that computes sine and cosine of one argument; one that nothing reads gets a slot
    for the time being."""
    by_kind = {program.op[index]: slots.taken(step, index) for index in nodes}
    unused = -1 if len(by_kind) == 2 else slots.taken(step, -1)
    argument = slots.of[program.a[nodes[0]]]
    return SinCos(argument, by_kind.get("sin", unused), by_kind.get("cos", unused))
