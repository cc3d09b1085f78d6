"""LLVM text of a program, over one vector of lanes.

The text is built by hand: making it through llvmlite.ir takes longer than compiling it. A module
holds one function for each segment of the program, `@compute` that runs them on a tile of slots,
and the gufunc loop around it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import nan

from freebody.program.passes import hoist, schedule
from freebody.program.program import Program
from freebody.program.segments import Segment, SegmentedProgram, SinCos, segment
from freebody.targets.llvm.instructions import (
    CHOICE,
    COMPARISONS,
    declarations,
    functions,
    instructions,
)
from freebody.targets.llvm.lanes import Lanes, loaded, stored
from freebody.targets.llvm.loop import gufunc_loop
from freebody.targets.llvm.machine import Machine
from freebody.targets.llvm.sample_transfers import check_slots, finite
from freebody.targets.llvm.shared_functions import attributes, declared_once, definitions
from freebody.targets.llvm.sincos import sines

LONG = 700, 16 * 2**10
"""Nodes from which a program gains by two groups a round, 5 %, and bytes that their tiles may
have."""

LONGER = 3000, 36 * 2**10, 60 * 2**10
"""Nodes from which code is fetched anew for each group, so that two groups a round are 5-25 %
faster; unless the tiles of one group stay in a first cache of 48 kB, of so many bytes, and those of
two, of more bytes than these, do not."""

PIECES = 32
"""Pieces of a program that one function runs: LLVM's time grows with the square of the loops in a
function."""

TOGETHER = 8
"""Sines and cosines in one function: their arithmetic overlaps, and one branch serves all."""


def emit(program: Program, machine: Machine) -> str:
    """LLVM text of the kernel of `program`: `void @kernel(ptr args, ptr dims, ptr steps, ptr
    data)`, a gufunc loop.

    Parameters
    ----------
    program
        A verified program with at least one input and one output scalar.
    machine
        What it is compiled for, as far as the text depends on it.
    """
    own = emit_own(program, machine)
    return declared_once(f"{own}\n{definitions(own, machine)}")


def emit_own(program: Program, machine: Machine) -> str:
    """LLVM text of the kernel without the functions that all kernels of a machine share."""
    lanes, parts, shared, every = machine.lanes, [f"; {program}"], None, program
    if any(argument.uniform for argument in program.inputs):
        once, every = map(schedule, hoist(program))
        shared = segment(once)
        parts += [*_once(once, shared, machine), finite(once.input_size, shared.slots, lanes)]
    layout = segment(every)
    room = lanes.size * (layout.slots + len(check_slots(every, layout)))
    tiles = _tiles(len(every), room)
    pieces, made = _pieces("", every, layout, lanes, machine.fma)
    poison = None if shared is None else shared.slots
    parts += [*made, _finite(every, layout, poison, lanes)]
    parts.append(_compute([*pieces, "@finite"], room, tiles))
    parts.append(gufunc_loop(program, every, machine, layout, tiles, shared))
    parts.append(attributes(lanes))
    return "\n".join(parts)


def _tiles(nodes: int, room: int) -> int:
    """The number of groups of samples in a round; each has two tiles of `room` bytes, one to
    compute on and one to write out."""
    if nodes >= LONGER[0]:
        return 1 if 2 * room <= LONGER[1] and 4 * room > LONGER[2] else 2
    return 2 if nodes >= LONG[0] and 4 * room <= LONG[1] else 1


def _once(program: Program, layout: SegmentedProgram, machine: Machine) -> list[str]:
    """LLVM text of `@once`: the code of all segments for a single lane, for uniform inputs."""
    pieces, made = _pieces("once.", program, layout, Lanes(machine.real, 1), machine.fma)
    calls = "".join(f"  call void {piece}(ptr %values, ptr null)\n" for piece in pieces)
    return [*made, f"define internal void @once(ptr %values) #0 {{\n{calls}  ret void\n}}\n"]


def emit_single(program: Program, machine: Machine) -> tuple[list[str], str, SegmentedProgram]:
    """The functions that compute a program without uniform inputs for a single lane on a tile:
    their names in order, their text, and the layout of the tile."""
    layout, lanes = segment(program), Lanes(machine.real, 1)
    pieces, made = _pieces("single.", program, layout, lanes, machine.fma)
    return pieces, "\n".join([*made, attributes(lanes)]), layout


def _pieces(
    before: str, program: Program, layout: SegmentedProgram, lanes: Lanes, fma: bool
) -> tuple[list[str], list[str]]:
    """Names of the functions for a program's steps, prefixed by `before`, and the LLVM text of
    these and of their helpers."""
    pieces: list[str] = []
    table = instructions(lanes)
    parts = []
    for number, those in enumerate(_joined(layout.steps)):
        if isinstance(those, Segment):
            pieces.append(f"@{before}segment{number}")
            parts.append(_arithmetic(pieces[-1], program, those, lanes, table))
        else:
            pieces.append(f"@{before}sines{number}")
            parts.append(sines(pieces[-1], those, lanes, fma))
    return pieces, [*parts, functions(program, lanes, fma), declarations(lanes)]


def _joined(steps: Sequence[Segment | SinCos]) -> Iterator[Segment | list[SinCos]]:
    """The steps in order, with up to `TOGETHER` sines and cosines that do not depend on each other
    grouped."""
    some: list[SinCos] = []
    for step in steps:  # the last is a segment
        if some and (
            isinstance(step, Segment)
            or len(some) == TOGETHER
            or any(step.argument in (x.sine, x.cosine) for x in some)
        ):
            yield some
            some = []
        if isinstance(step, Segment):
            yield step
        else:
            some.append(step)


def _arithmetic(
    title: str, program: Program, step: Segment, lanes: Lanes, table: Mapping[str, str]
) -> str:
    """LLVM text of a segment: loads (at first use), instructions and stores."""
    v, align, sampled = lanes.v, lanes.size, program.sampled_size
    lines = [f"define internal void {title}(ptr noalias %tile, ptr noalias %uniform) #1 {{"]
    names: dict[int, str] = {}
    computed = set(step.nodes)

    def name(index: int) -> str:
        """The name of a node's value: a constant, or a name, which is loaded at its first use."""
        known = names.get(index)
        if known is None:
            if program.op[index] == "input" and program.a[index] >= sampled:
                known = _spread(lines, index, program.a[index] - sampled, lanes)
            elif program.op[index] == "const":
                known = lanes.constant(program.constants[program.a[index]])
            else:
                known = f"%v{index}"
                lines.append(loaded(known, v, "%tile", step.loads[index], align=align))
            names[index] = known
        return known

    for index in step.nodes:
        operands = [name(i) for i in program.operands(index)]
        result = names[index] = f"%v{index}"
        op, first = program.op[index], program.a[index]
        if op == "where" and first in computed and program.op[first] in COMPARISONS:
            op = CHOICE
        lines.append("  " + table[op].format(result, *operands))
        for position, slot in enumerate(step.stores.get(index, ())):
            lines.append(stored(f"%q{index}.{position}", v, result, "%tile", slot, align=align))
    for index, slots in step.stores.items():
        if index not in computed:
            for position, slot in enumerate(slots):
                at, value = f"%q{index}.{position}", name(index)
                lines.append(stored(at, v, value, "%tile", slot, align=align))
    return "\n".join([*lines, "  ret void", "}", ""])


def _spread(lines: list[str], index: int, number: int, lanes: Lanes) -> str:
    """The name of a vector with a uniform number in all lanes, whose code is emitted."""
    kind, v = lanes.real.name, lanes.v
    lines += [
        loaded(f"%u{index}", kind, "%uniform", number, align=lanes.real.size),
        f"  %u{index}.v = insertelement {v} poison, {kind} %u{index}, i64 0",
        f"  %v{index} = shufflevector {v} %u{index}.v, {v} poison, <{lanes.width} x i32> "
        f"zeroinitializer",
    ]
    return f"%v{index}"


def _compute(pieces: list[str], size: int, tiles: int) -> str:
    """LLVM text of `@compute`: each piece is run on all `count` tiles of `size` bytes before the
    next."""
    if len(pieces) <= PIECES:
        return _run("@compute", pieces, size, tiles)
    groups = [pieces[k : k + PIECES] for k in range(0, len(pieces), PIECES)]
    parts = [_run(f"@compute{k}", group, size, tiles) for k, group in enumerate(groups)]
    calls = "".join(
        f"  call void @compute{k}(ptr %tile, ptr %uniform, i64 %count)\n"
        for k in range(len(groups))
    )
    parts.append(
        f"define internal void @compute(ptr %tile, ptr %uniform, i64 %count) #0 {{\n{calls}  ret "
        f"void\n}}\n"
    )
    return "\n".join(parts)


def _run(title: str, pieces: list[str], size: int, tiles: int) -> str:
    lines = [f"define internal void {title}(ptr %tile, ptr %uniform, i64 %count) #0 {{", "entry:"]
    if tiles == 1:
        return "\n".join(
            [
                *lines,
                *(f"  call void {piece}(ptr %tile, ptr %uniform)" for piece in pieces),
                "  ret void",
                "}",
                "",
            ]
        )
    for k, piece in enumerate(pieces):
        before = f"leave{k - 1}" if k else "entry"
        lines.append(f"""\
  br label %piece{k}
piece{k}:
  %g{k} = phi i64 [ 0, %{before} ], [ %next{k}, %piece{k} ]
  %skip{k} = mul i64 %g{k}, {size}
  %tile{k} = getelementptr i8, ptr %tile, i64 %skip{k}
  call void {piece}(ptr %tile{k}, ptr %uniform)
  %next{k} = add i64 %g{k}, 1
  %more{k} = icmp ult i64 %next{k}, %count
  br i1 %more{k}, label %piece{k}, label %leave{k}
leave{k}:""")
    return "\n".join([*lines, "  ret void", "}", ""])


def _finite(every: Program, layout: SegmentedProgram, poison: int | None, lanes: Lanes) -> str:
    """LLVM text that makes every result NaN in lanes with an input that is not finite.

    What brought the inputs in left a vector for each that is finite only if they are (see
    `sample_transfers`). Where one is not, the numbers themselves are looked at: 0 * x is NaN for
    NaN and infinite x, so the sum of these products tells. It begins with the uniform number at
    `poison`, if there is one: 0, or NaN for all lanes.
    """
    v, align, width, inputs = lanes.v, lanes.size, lanes.width, every.sampled_size
    lines = ["define internal void @finite(ptr noalias %tile, ptr noalias %uniform) #0 {", "entry:"]
    begin = "zeroinitializer" if poison is None else _spread(lines, 0, poison, lanes)
    seen = begin
    for k, slot in enumerate(check_slots(every, layout).values()):
        lines += [
            loaded(f"%check{k}", v, "%tile", slot, align=align),
            f"  %nothing{k} = fmul contract {v} %check{k}, zeroinitializer",
            f"  %seen{k} = fadd contract {v} {seen}, %nothing{k}",
        ]
        seen = f"%seen{k}"
    lines.append(f"""\
  %doubt = fcmp uno {v} {seen}, zeroinitializer
  %doubt.bits = bitcast {lanes.mask} %doubt to i{width}
  %doubtful = icmp ne i{width} %doubt.bits, 0
  br i1 %doubtful, label %look, label %done
look:
  %j = phi i64 [ 0, %entry ], [ %j.next, %input ]
  %sum = phi {v} [ {begin}, %entry ], [ %sum.next, %input ]
  %left = icmp ult i64 %j, {inputs}
  br i1 %left, label %input, label %judge
input:
  %in = getelementptr {v}, ptr %tile, i64 %j
  %x = load {v}, ptr %in, align {align}
  %nothing = fmul contract {v} %x, zeroinitializer
  %sum.next = fadd contract {v} %sum, %nothing
  %j.next = add i64 %j, 1
  br label %look
judge:
  %bad = fcmp uno {v} %sum, zeroinitializer
  %bits = bitcast {lanes.mask} %bad to i{width}
  %any = icmp ne i{width} %bits, 0
  br i1 %any, label %poison, label %done
poison:
  %k = phi i64 [ {inputs}, %judge ], [ %k.next, %poison ]
  %out = getelementptr {v}, ptr %tile, i64 %k
  %old = load {v}, ptr %out, align {align}
  %new = select {lanes.mask} %bad, {v} {lanes.constant(nan)}, {v} %old
  store {v} %new, ptr %out, align {align}
  %k.next = add i64 %k, 1
  %more = icmp ult i64 %k.next, {inputs + len(layout.results)}
  br i1 %more, label %poison, label %done
done:
  ret void
}}
""")
    return "\n".join(lines)
