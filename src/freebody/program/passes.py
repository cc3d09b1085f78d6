"""Passes over a program: each returns one that computes the same up to rounding.

Measured and not kept: flattening sums into chains of fused multiply-adds (longer waits, 10-25 %
slower at 32 joints) and depth-first order (no gain).
"""

from __future__ import annotations

import heapq
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

from freebody.program.program import Argument, Program, verify
from freebody.scalars.operations import ARITY

SHORT = 700
"""Nodes of a program that a processor nearly has in view at once: it waits for the longest chain.
There, an order that looks at chains takes 0-8 % less time in batches, and up to 13 % less a call;
in long programs of trees 20 % more. Long ones keep near the text's own order, in which a sum is
done before the next begins: with the youngest operand instead, matrices take up to 70 % more."""

STRIDE = 4
"""Nodes of a chain that make no difference."""


def drop_dead(program: Program) -> Program:
    """The program without the nodes that no result needs."""
    live = bytearray(len(program))
    for index in program.results:
        live[index] = 1
    for index in range(len(program) - 1, -1, -1):
        if live[index]:
            for operand in program.operands(index):
                live[operand] = 1
    return _reordered(program, (index for index, alive in enumerate(live) if alive))


def without_unread(program: Program, name: str) -> tuple[Program, tuple[int, ...]]:
    """The program with its vector input of a given name reduced to the scalars that are read, and
    the indices of these.

    Where it reads none, the first stays: the input has a say in the shape of what comes out.
    """
    before = 0
    for argument in program.inputs:
        if argument.name == name:
            break
        before += argument.size
    last = before + argument.size
    places = [program.a[i] for i, op in enumerate(program.op) if op == "input"]
    read = sorted({place - before for place in places if before <= place < last}) or [0]
    new = {before + place: before + k for k, place in enumerate(read)}
    new |= {place: place - argument.size + len(read) for place in places if place >= last}
    a = tuple(
        new.get(x, x) if op == "input" else x for op, x in zip(program.op, program.a, strict=True)
    )
    shorter = replace(argument, shape=(len(read),))
    inputs = tuple(shorter if x.name == name else x for x in program.inputs)
    return verify(replace(program, inputs=inputs, a=a)), tuple(read)


def with_epsilon(program: Program, value: float) -> Program:
    """The program with the unit of rounding fixed to a value, whatever number type computes it."""
    rows = [
        ("const", len(program.constants), -1, -1) if op == "epsilon" else (op, *row)
        for op, *row in zip(program.op, program.a, program.b, program.c, strict=True)
    ]
    op, a, b, c = map(tuple, zip(*rows, strict=True)) if rows else ((), (), (), ())
    return replace(program, op=op, a=a, b=b, c=c, constants=(*program.constants, value))


def share_reciprocals(program: Program) -> Program:
    """The program with quotients by a shared denominator replaced by products with its reciprocal,
    as are quotients by a uniform denominator.

    A division costs as much as ten products.
    """
    quotients = [index for index, op in enumerate(program.op) if op == "div"]
    denominators = Counter(program.b[index] for index in quotients)
    shared = {index for index, count in denominators.items() if count > 1}
    if any(argument.uniform for argument in program.inputs):
        uniform = program.uniform
        shared |= {program.b[i] for i in quotients if uniform[program.b[i]] and not uniform[i]}
    if not shared:
        return program
    nodes = _RewrittenNodes()
    reciprocal: dict[int, int] = {}
    one = nodes.add("const", len(program.constants))
    for index, op in enumerate(program.op):
        if op == "div" and program.b[index] in shared:
            below = nodes.new[program.b[index]]
            if below not in reciprocal:
                reciprocal[below] = nodes.add("div", one, below)
            nodes.new.append(nodes.add("mul", nodes.new[program.a[index]], reciprocal[below]))
        else:
            nodes.copy(program, index)
    return drop_dead(_program(program, nodes.rows, nodes.new, (*program.constants, 1.0)))


def gather_factors(program: Program) -> Program:
    """The program with u (v x) replaced by (u v) x where u and v are uniform, so that their product
    is computed once a call.

    Of constants the trace itself does so.
    """
    if not any(argument.uniform for argument in program.inputs):
        return program
    uniform, nodes = program.uniform, _RewrittenNodes()
    products: dict[tuple[int, int], int] = {}
    factors: dict[
        int, tuple[int, int]
    ] = {}  # product -> its uniform factor and the other, as new nodes
    for index, op in enumerate(program.op):
        operands = program.operands(index)
        once = [i for i in operands if uniform[i]]
        if op != "mul" or len(once) != 1:
            nodes.copy(program, index)
            continue
        factor, x = nodes.new[once[0]], operands[0] if uniform[operands[1]] else operands[1]
        rest = nodes.new[x]
        if x in factors:
            inner, rest = factors[x]
            pair = (factor, inner) if factor < inner else (inner, factor)
            if pair not in products:
                products[pair] = nodes.add("mul", *pair)
            factor = products[pair]
        nodes.new.append(nodes.add("mul", factor, rest))
        factors[index] = factor, rest
    return drop_dead(_program(program, nodes.rows, nodes.new, program.constants))


def schedule(program: Program) -> Program:
    """The program's nodes in an order in which few values are alive at a time, so that they fit the
    registers.

    Of the nodes whose operands are there, the next is the one that is the last reader of most
    operands; among equals, in a short program, the one on which the longest chain rests, then the
    one with the youngest operand; in a long one the first as traced. Inputs and constants do not
    count: they can be read again from where they are.
    """
    return _reordered(program, _NodeOrder(program).run())


class _NodeOrder:
    """A program's nodes while they are put in order: which have been placed, and which are ready to
    be.

    operands, readers: of each node, inputs and constants left out. unread: readers of each node
    that are still to come. missing: operands of each node that are not put yet. frees: operands of
    which each node is the last reader. height: see `_heights`; empty for a long program.
    """

    def __init__(self, program: Program):
        count = len(program)
        leaf = [ARITY[op] == 0 for op in program.op]
        self.operands = [
            tuple({i for i in program.operands(index) if not leaf[i]}) for index in range(count)
        ]
        self.readers: list[list[int]] = [[] for _ in range(count)]
        for index, those in enumerate(self.operands):
            for operand in those:
                self.readers[operand].append(index)
        self.unread = [len(those) for those in self.readers]
        self.missing = [len(those) for those in self.operands]
        self.frees = [sum(self.unread[i] == 1 for i in those) for those in self.operands]
        self.short = count < SHORT
        self.height = _heights(self.operands) if self.short else []
        self.place = [-1] * count
        self.order = [index for index in range(count) if leaf[index]]
        self.ready: list[tuple[int, ...]] = []
        for index in range(count):
            if not leaf[index] and not self.operands[index]:
                self._push(index)

    def run(self) -> list[int]:
        """The indices of all nodes in their final order."""
        while self.ready:
            index = heapq.heappop(self.ready)[-1]
            if self.place[index] < 0:  # else it was pushed again since with a better rank
                self._put(index)
        return self.order

    def _push(self, index: int) -> None:
        rank = -self.frees[index], index
        if self.short:
            youngest = max((self.place[i] for i in self.operands[index]), default=0)
            rank = -self.frees[index], -self.height[index], -youngest, index
        heapq.heappush(self.ready, rank)

    def _put(self, index: int) -> None:
        self.place[index] = len(self.order)
        self.order.append(index)
        for reader in self.readers[index]:
            self.missing[reader] -= 1
            if not self.missing[reader]:
                self._push(reader)
        for operand in self.operands[index]:
            self.unread[operand] -= 1
            if self.unread[operand] == 1:
                last = next(r for r in self.readers[operand] if self.place[r] < 0)
                self.frees[last] += 1
                if not self.missing[last]:
                    self._push(last)


def _heights(operands: Sequence[Sequence[int]]) -> list[int]:
    """The length of the longest chain of nodes that depends on each node, in units of `STRIDE`."""
    height = [0] * len(operands)
    for index in range(len(operands) - 1, -1, -1):
        for operand in operands[index]:
            height[operand] = max(height[operand], height[index] + 1)
    return [h // STRIDE for h in height]


PASSES: dict[str, Callable[[Program], Program]] = {
    "share reciprocals": share_reciprocals,
    "gather factors": gather_factors,
    "schedule": schedule,
}
"""Passes by name, in the order in which they run."""


def optimise(program: Program) -> Program:
    """The program after all passes, verified."""
    for apply in PASSES.values():
        program = apply(program)
    return verify(program)


def hoist(program: Program) -> tuple[Program, Program]:
    """The program cut in two: the first part computes once a call what depends on uniform inputs
    alone, the second part everything else for every sample.

    The first part has what were the uniform inputs, and one output: what it computes of them. The
    second has the other inputs, and one uniform input, the last: the scalars of the uniform ones,
    then that output.
    """
    place = _places(program)
    known = sum(x.size for x in program.inputs if x.uniform)
    handed = _handed(program)
    once = replace(
        program,
        name=f"{program.name}_once",
        inputs=tuple(replace(x, uniform=False) for x in program.inputs if x.uniform),
        outputs=(Argument("computed", (len(handed),)),),
        a=tuple(
            place[a] if op == "input" else a for op, a in zip(program.op, program.a, strict=True)
        ),
        results=tuple(handed),
    )
    sampled = [x for x in program.inputs if not x.uniform]
    first = sum(x.size for x in sampled)
    number = {index: first + known + k for k, index in enumerate(handed)}
    uniform = program.uniform
    op, a, b, c = list(program.op), list(program.a), list(program.b), list(program.c)
    for index in range(len(program)):
        if index in number:
            op[index], a[index], b[index], c[index] = "input", number[index], -1, -1
        elif op[index] == "input":
            a[index] = place[a[index]] + first * uniform[index]
    every = replace(
        program,
        inputs=(*sampled, Argument("uniform", (known + len(handed),), uniform=True)),
        op=tuple(op),
        a=tuple(a),
        b=tuple(b),
        c=tuple(c),
    )
    return drop_dead(once), drop_dead(every)


def _handed(program: Program) -> list[int]:
    """The nodes computed once a call that are read for every sample or are results."""
    uniform = program.uniform
    read = set(program.results)
    for index, once in enumerate(uniform):
        if not once:
            read.update(program.operands(index))
    return [
        index
        for index, op in enumerate(program.op)
        if uniform[index] and ARITY[op] and index in read
    ]


def _places(program: Program) -> list[int]:
    """For each scalar of the inputs its position among the uniform scalars, or among the others."""
    sizes, places = {False: 0, True: 0}, []
    for argument in program.inputs:
        for _ in range(argument.size):
            places.append(sizes[argument.uniform])
            sizes[argument.uniform] += 1
    return places


class _RewrittenNodes:
    """Nodes of a rewritten program as rows, and for each node of the old program its new index."""

    def __init__(self) -> None:
        self.rows: list[tuple[str, int, int, int]] = []
        self.new: list[int] = []

    def add(self, op: str, a: int, b: int = -1, c: int = -1) -> int:
        self.rows.append((op, a, b, c))
        return len(self.rows) - 1

    def copy(self, program: Program, index: int) -> None:
        operands = [self.new[i] for i in program.operands(index)] or [program.a[index]]
        self.new.append(self.add(program.op[index], *operands))


def _reordered(program: Program, order: Iterable[int]) -> Program:
    """The program with its nodes in `order`, renumbered, and its constants renumbered."""
    new = [-1] * len(program)
    rows: list[tuple[str, int, int, int]] = []
    constants: list[float] = []
    given = list(zip(program.op, program.a, program.b, program.c, strict=True))
    for index in order:
        op, a, b, c = given[index]
        new[index] = len(rows)
        if arity := ARITY[op]:
            rows.append((op, new[a], new[b] if arity > 1 else -1, new[c] if arity > 2 else -1))
        elif op == "const":
            rows.append((op, len(constants), -1, -1))
            constants.append(program.constants[a])
        else:
            rows.append((op, a, -1, -1))
    return _program(program, rows, new, constants)


def _program(
    old: Program, rows: list[tuple[str, int, int, int]], new: list[int], constants: Iterable[float]
) -> Program:
    """The program made of new rows; new: the new index of each node of the old program."""
    op, a, b, c = zip(*rows, strict=True) if rows else ((), (), (), ())
    results = tuple(new[index] for index in old.results)
    return replace(old, op=op, a=a, b=b, c=c, constants=tuple(constants), results=results)
