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
from dataclasses import dataclass, field
from itertools import accumulate, pairwise

from freebody.program.program import Program
from freebody.scalars.operations import ARITY

LONGEST = 1000
"""Weight of one segment: a node counts 1, the store of an output `_STORE`."""

_STORE = 4  # LLVM's time grows with the square of the stores in a function


@dataclass
class Segment:
    """Nodes to compute in order; slots to load before and to store after."""

    nodes: list[int]
    loads: dict[int, int] = field(default_factory=dict)
    stores: dict[int, list[int]] = field(default_factory=dict)


@dataclass(frozen=True)
class SinCos:
    """Slots of an argument, of its sine and of its cosine."""

    argument: int
    sine: int
    cosine: int


@dataclass(frozen=True)
class SegmentedProgram:
    """Steps in order, and what lies where.

    Inputs come first, but for the uniform ones, then each different result once, then what crosses
    cuts.
    """

    steps: tuple[Segment | SinCos, ...]
    slots: int
    results: dict[int, int]
    """Node of a result -> slot; equal entries of an output share one."""


def segment(program: Program, longest: int = LONGEST) -> SegmentedProgram:
    """Cut `program`, whose uniform inputs are the last, keeping its order within each stage."""
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
    """Stage of each node. Stage k is the k-th round of sines and cosines, then arithmetic.

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
    """Pieces of about equal weight, none heavier than `longest` (or a single node)."""
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
    """Give slots to values that cross steps, reusing those whose last reader is done."""
    sampled = program.sampled_size
    at_hand = [
        op == "const" or (op == "input" and program.a[i] >= sampled)
        for i, op in enumerate(program.op)
    ]
    producer = {index: number for number, nodes in enumerate(steps) for index in nodes}
    readers: dict[int, set[int]] = {}
    for number, nodes in enumerate(steps):
        for index in nodes:
            for operand in program.operands(index):
                if producer.get(operand, -1) != number and not at_hand[operand]:
                    readers.setdefault(operand, set()).add(number)
    distinct = dict.fromkeys(program.results)
    results = {index: sampled + k for k, index in enumerate(distinct)}
    storing: dict[int, list[int]] = {}  # step -> results it stores
    for index in results:
        trigonometric = program.op[index] in _TRIG
        number = producer.get(index, len(steps) - 1) if not trigonometric else len(steps) - 1
        storing.setdefault(number, []).append(index)
        if producer.get(index, -1) != number and not at_hand[index]:
            readers.setdefault(index, set()).add(number)

    slot = {i: program.a[i] for i, op in enumerate(program.op) if op == "input" and not at_hand[i]}
    free: list[int] = []
    expiring: dict[int, list[int]] = {}
    slots = sampled + len(results)
    done: list[Segment | SinCos] = []

    def take(step: int, index: int) -> int:
        nonlocal slots
        if free:
            slot[index] = free.pop()
        else:
            slot[index], slots = slots, slots + 1
        expiring.setdefault(max(readers.get(index, {step}), default=step), []).append(slot[index])
        return slot[index]

    for number, nodes in enumerate(steps):
        if nodes and program.op[nodes[0]] in _TRIG:
            by_kind = {program.op[index]: take(number, index) for index in nodes}
            unused = -1 if len(by_kind) == 2 else take(number, -1)
            argument = program.a[nodes[0]]
            done.append(
                SinCos(slot[argument], by_kind.get("sin", unused), by_kind.get("cos", unused))
            )
        else:
            step = Segment(nodes)
            for index in {i for node in nodes for i in program.operands(node)} | set(
                storing.get(number, [])
            ):
                if producer.get(index, -1) != number and not at_hand[index]:
                    step.loads[index] = slot[index]
            for index in nodes:
                if index in readers:
                    step.stores[index] = [take(number, index)]
            for index in storing.get(number, []):
                step.stores[index] = [*step.stores.get(index, ()), results[index]]
            done.append(step)
        free += expiring.pop(number, [])
    return SegmentedProgram(tuple(done), slots, results)
