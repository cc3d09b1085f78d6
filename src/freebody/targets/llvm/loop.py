"""LLVM text of a kernel's loop: it finds out how each argument is accessed; then, round by round,
groups of samples are read, `@compute` runs on a tile of slots, and the previous round's groups are
written.

Results of one round go out after the inputs of the next one have come in, from tiles of their own:
the processor computes while its stores wait for the memory.

A tile holds one vector of lanes for each slot: lane l of slot j is scalar j of sample l. How an
argument gets there and back is chosen when the loop begins, see `sample_transfers`.

The last group may be short. Its surplus lanes take the addresses of its last sample, on the way in
and on the way out: the same code runs, the same bits come out, and the last row is written more
than once with the same values.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from freebody.program.program import Argument, Program
from freebody.program.segments import SegmentedProgram
from freebody.targets.llvm.lanes import Lanes, loaded, stored
from freebody.targets.llvm.machine import Machine
from freebody.targets.llvm.sample_transfers import check_slots, integers, one_by_one, transfers


def gufunc_loop(
    program: Program,
    every: Program,
    machine: Machine,
    layout: SegmentedProgram,
    tiles: int,
    shared: SegmentedProgram | None,
) -> str:
    """LLVM text of `void @kernel(ptr args, ptr dims, ptr steps, ptr data)` and of the functions it
    calls.

    A round takes `tiles` groups, each on a tile of its own.

    Parameters
    ----------
    program
        The whole program, whose arguments come in.
    every
        What is computed for every sample (see `hoist`), on tiles of `layout`.
    machine
        What it is compiled for, as far as the text depends on it.
    tiles
        Groups in a round.
    shared
        Where the uniform numbers are, and what is computed of them once; None if there are none.
    """
    parts = [
        transfers(program, every, layout, machine.lanes),
        _loop(program, machine, layout, tiles, shared),
        one_by_one(program) if shared else "",
        FLAGS[machine.x86]["declare"],
        "declare ptr @malloc(i64)\ndeclare void @free(ptr)\n",
    ]
    return "\n".join(parts)


_LARGEST_ON_STACK = 2**16

# NumPy turns floating-point flags into warnings; NaN in, NaN out is no reason to warn, and surplus
# lanes set them too
FLAGS = {
    True: {
        "save": "  %flags = alloca i32, align 4\n  call void @llvm.x86.sse.stmxcsr(ptr %flags)",
        "restore": "  call void @llvm.x86.sse.ldmxcsr(ptr %flags)",
        "declare": "declare void @llvm.x86.sse.stmxcsr(ptr)\n"
        "declare void @llvm.x86.sse.ldmxcsr(ptr)\n",
    },
    False: {
        "save": "",
        "restore": "  %cleared = call i32 @feclearexcept(i32 31)",
        "declare": "declare i32 @feclearexcept(i32)\n",
    },
}


def _loop(
    program: Program,
    machine: Machine,
    layout: SegmentedProgram,
    tiles: int,
    shared: SegmentedProgram | None,
) -> str:
    """LLVM text of the loop: the uniform numbers, then rounds of `tiles` groups in which all are
    read, the previous round's are written, and `@compute` runs."""
    lanes, checks = machine.lanes, check_slots(program, layout)
    arguments, slots = program.inputs + program.outputs, layout.slots + len(checks)
    tile, addresses = lanes.size * slots * tiles, 8 * machine.width * len(arguments)
    get, give_back = _workspace(
        {
            "tile.a": tile,
            "tile.b": tile,
            "lanes": addresses,
            "lanes.short": addresses,
            "offsets": 8 * sum(argument.size for argument in arguments),
            "uniform": lanes.real.size * (shared.slots + 1) if shared else 0,
        }
    )
    lines = [
        f"define {'internal void @loop' if shared else 'void @kernel'}"
        "(ptr %args, ptr %dims, ptr %steps, ptr %data) #0 {",
        "entry:",
        "  %n = load i64, ptr %dims, align 8",
        FLAGS[machine.x86]["save"],
        *get,
        *_access(arguments, lanes),
    ]
    if shared:
        lines.append("  call void @uniform.finite(ptr %uniform)\n  call void @once(ptr %uniform)")
    lines += [
        *_rounds(program, lanes, slots, tiles, checks),
        *give_back,
        FLAGS[machine.x86]["restore"],
        "  ret void",
        "}",
        *(f"@shape{k} = internal constant {integers(x.shape)}" for k, x in enumerate(arguments)),
        "",
    ]
    return "\n".join(lines)


def _workspace(sizes: dict[str, int]) -> tuple[list[str], list[str]]:
    """Lines that allocate named places of `sizes` bytes, and lines that free them.

    It is on the stack unless it is large: threads may have little of it.
    """
    total, places = 0, []
    for name, size in sizes.items():
        places.append(f"  %{name} = getelementptr i8, ptr %room, i64 {total}")
        total += size
    if total <= _LARGEST_ON_STACK:
        return [f"  %room = alloca [{total} x i8], align 64", *places], []
    get = f"""\
  %raw = call ptr @malloc(i64 {total + 64})
  %raw.number = ptrtoint ptr %raw to i64
  %odd = and i64 %raw.number, 63
  %up = sub i64 64, %odd
  %room = getelementptr i8, ptr %raw, i64 %up"""
    return [get, *places], ["  call void @free(ptr %raw)"]


def _rounds(
    program: Program, lanes: Lanes, slots: int, tiles: int, checks: Mapping[int, int]
) -> list[str]:
    """Lines of the loop over rounds of samples, until the last round is written."""
    samples = lanes.width * tiles
    inputs = [(k, argument) for k, argument in enumerate(program.inputs) if not argument.uniform]
    outputs = list(enumerate(program.outputs, len(program.inputs)))
    return [
        f"""\
  br label %begin
begin:
  br label %head
head:
  %i = phi i64 [ 0, %begin ], [ %i.next, %tail ]
  %tile = phi ptr [ %tile.a, %begin ], [ %before.tile, %tail ]
  %before.tile = phi ptr [ %tile.b, %begin ], [ %tile, %tail ]
  %before = sub i64 %i, {samples}
  %more = icmp slt i64 %before, %n
  br i1 %more, label %choose, label %end""",
        *_whole_round(inputs, outputs, lanes, slots, tiles),
        *_phase("in", "%i", "%tile", inputs, lanes, slots, tiles, checks),
        "in.done:\n  %started = icmp ne i64 %i, 0\n  br i1 %started, label %out, label %out.done",
        *_phase("out", "%before", "%before.tile", outputs, lanes, slots, tiles, {}),
        f"""\
out.done:
  %some = icmp ne i64 %in.g, 0
  br i1 %some, label %run, label %tail
run:
  %groups = phi i64 [ %in.g, %out.done ], [ {tiles}, %whole ]
  call void @compute(ptr %tile, ptr %uniform, i64 %groups)
  br label %tail
tail:
  %i.next = add i64 %i, {samples}
  br label %head
end:""",
    ]


def _whole_round(
    inputs: list[tuple[int, Argument]],
    outputs: list[tuple[int, Argument]],
    lanes: Lanes,
    slots: int,
    tiles: int,
) -> list[str]:
    """Lines for a round of full groups, with the writing of the previous one, where all arguments
    are rows and nothing has to be decided."""
    lines, all_rows, width = ["choose:"], "%later", lanes.width
    lines.append("  %later = icmp ne i64 %i, 0")
    for k, _ in inputs + outputs:
        lines.append(f"  %only.rows{k} = xor i1 %addressed{k}, true")
        lines.append(f"  %all{k} = and i1 {all_rows}, %only.rows{k}")
        all_rows = f"%all{k}"
    lines += [
        f"  %i.end = add i64 %i, {width * tiles}",
        "  %fits = icmp sle i64 %i.end, %n",
        f"  %plain = and i1 {all_rows}, %fits",
        "  br i1 %plain, label %whole, label %in",
        "whole:",
    ]
    for start, tile, arguments in (("%i", "%tile", inputs), ("%before", "%before.tile", outputs)):
        for k, _ in arguments:
            lines += [
                f"  %whole.move{k} = mul i64 {start}, %step{k}",
                f"  %whole.at{k}.0 = getelementptr i8, ptr %base{k}, i64 %whole.move{k}",
                f"  %whole.lane{k} = getelementptr i64, ptr %lanes, i64 {k * width}",
                f"  %group{k} = mul i64 %step{k}, {width}",
            ]
            for g in range(tiles):
                at = f"%whole.at{k}.{g}"
                if g:
                    lines.append(
                        f"  {at} = getelementptr i8, ptr %whole.at{k}.{g - 1}, i64 %group{k}"
                    )
                lines.append(
                    f"  %whole.tile{k}.{g} = getelementptr i8, ptr {tile}, i64 "
                    f"{lanes.size * slots * g}"
                )
                lines.append(
                    f"  call void @rows{k}(ptr {at}, ptr %whole.lane{k}, ptr %whole.tile{k}.{g})"
                )
    return [*lines, "  br label %run"]


def _phase(
    way: str,
    start: str,
    tile: str,
    arguments: list[tuple[int, Argument]],
    lanes: Lanes,
    slots: int,
    tiles: int,
    checks: Mapping[int, int],
) -> list[str]:
    """Lines that read or write the groups of the round that begins with sample `start`; afterwards
    `%in.g` is their number."""
    before, width = {"in": "choose", "out": "in.done"}[way], lanes.width
    lines = [
        f"{way}:",
        f"  %{way}.g = phi i64 [ 0, %{before} ], [ %{way}.next, %{way}.end ]",
        f"  %{way}.skip = mul i64 %{way}.g, {width}",
        f"  %{way}.at = add i64 {start}, %{way}.skip",
        f"  %{way}.rest = sub i64 %n, %{way}.at",
        f"  %{way}.some = icmp sgt i64 %{way}.rest, 0",
        f"  %{way}.room = icmp ult i64 %{way}.g, {tiles}",
        f"  %{way}.more = and i1 %{way}.some, %{way}.room",
        f"  br i1 %{way}.more, label %{way}.group, label %{way}.done",
        f"{way}.group:",
        f"  %{way}.full = icmp sge i64 %{way}.rest, {width}",
        f"  %{way}.last = sub i64 %{way}.rest, 1",
        f"  %{way}.lanes = select i1 %{way}.full, ptr %lanes, ptr %lanes.short",
        f"  %{way}.skipped = mul i64 %{way}.g, {lanes.size * slots}",
        f"  %{way}.tile = getelementptr i8, ptr {tile}, i64 %{way}.skipped",
        f"  br i1 %{way}.full, label %{way}.begin, label %{way}.short",
        f"{way}.short:",
    ]
    for k, _ in arguments:
        lines += _lane_table(k, width, f"%{way}.last")
    lines.append(f"  br label %{way}.begin\n{way}.begin:")
    for k, argument in arguments:
        lines += _transfer(k, argument, lanes, tiles, way, checks.get(k))
    return [
        *lines,
        f"  br label %{way}.end",
        f"{way}.end:",
        f"  %{way}.next = add i64 %{way}.g, 1",
        f"  br label %{way}",
    ]


def _transfer(
    k: int, argument: Argument, lanes: Lanes, tiles: int, way: str, check: int | None
) -> list[str]:
    """Lines that move one group of argument k between its array and the tile; for an input, the
    result of the finiteness check goes to the slot `check`."""
    width = lanes.width
    lines = [
        f"  %move{k} = mul i64 %{way}.at, %step{k}",
        f"  %at{k} = getelementptr i8, ptr %base{k}, i64 %move{k}",
        f"  %lane{k} = getelementptr i64, ptr %{way}.lanes, i64 {k * width}",
    ]
    if way == "in":  # a broadcast input stays in the tiles, of which two rounds have their own
        lines += [
            f"  %moves{k} = icmp ne i64 %step{k}, 0",
            f"  %first{k} = icmp ult i64 %i, {2 * width * tiles}",
            f"  %needed{k} = or i1 %moves{k}, %first{k}",
            f"  br i1 %needed{k}, label %load{k}, label %after{k}",
            f"load{k}:",
        ]
    at, seen = f"ptr %at{k}, ptr %lane{k}, ptr %{way}.tile", "null"
    if check is not None:
        seen = f"%check{k}"
        lines.append(f"  {seen} = getelementptr {lanes.v}, ptr %{way}.tile, i64 {check}")
    call = f"{at}, ptr {seen}, ptr @places{k}, ptr %offset{k}, i64 {argument.size}"
    return [
        *lines,
        f"  %streams{k} = and i1 %{way}.full, %columns{k}",
        f"  br i1 %streams{k}, label %columns.{k}, label %other{k}",
        f"columns.{k}:",
        f"  call void @columns_{way}({call})",
        f"  br label %after{k}",
        f"other{k}:",
        f"  br i1 %rows{k}, label %rows.{k}, label %strided{k}",
        f"rows.{k}:",
        f"  call void @rows{k}({at})",
        f"  br label %after{k}",
        f"strided{k}:",
        f"  call void @strided_{way}({call})",
        f"  br label %after{k}",
        f"after{k}:",
    ]


def _access(arguments: Sequence[Argument], lanes: Lanes) -> list[str]:
    """Lines that find out how each argument is accessed; uniform ones are read at once."""
    lines: list[str] = []
    core, first, number = len(arguments), 0, 0
    for k, argument in enumerate(arguments):
        lines += _contiguous(k, argument, core, lanes.real.size)
        if argument.uniform:
            lines += _gather(k, argument, first, number, lanes.real.name)
            number += argument.size
        else:
            lines += _prepare(k, argument, first, lanes)
        core += len(argument.shape)
        first += argument.size
    return lines


def _contiguous(k: int, argument: Argument, core: int, size: int) -> list[str]:
    """Lines that load base and step of argument k, and find out whether the scalars of one sample
    are contiguous."""
    lines = [
        loaded(f"%base{k}", "ptr", "%args", k),
        loaded(f"%step{k}", "i64", "%steps", k),
        f"  %strides{k} = getelementptr i64, ptr %steps, i64 {core}",
    ]
    rows, natural = "true", size
    for d in reversed(range(len(argument.shape))):
        lines += [
            loaded(f"%core{k}.{d}", "i64", "%steps", core + d),
        ]
        if argument.shape[d] > 1:  # the stride along an axis of one entry means nothing
            lines.append(f"  %natural{k}.{d} = icmp eq i64 %core{k}.{d}, {natural}")
            lines.append(f"  %rows{k}.{d} = and i1 {rows}, %natural{k}.{d}")
            rows = f"%rows{k}.{d}"
        natural *= argument.shape[d]
    return [*lines, f"  %rows{k} = and i1 {rows}, true"]


def _gather(k: int, argument: Argument, first: int, number: int, kind: str) -> list[str]:
    """Lines that copy uniform argument k to the uniform numbers from `number` on; first: the index
    of its offsets in their table."""
    return [
        f"  %offset{k} = getelementptr i64, ptr %offsets, i64 {first}",
        f"  %uniform{k} = getelementptr {kind}, ptr %uniform, i64 {number}",
        f"  call void @gather(ptr %base{k}, i1 %rows{k}, ptr %strides{k}, ptr @shape{k}, "
        f"i64 {len(argument.shape)}, i64 {argument.size}, ptr %offset{k}, ptr %uniform{k})",
    ]


def _prepare(k: int, argument: Argument, first: int, lanes: Lanes) -> list[str]:
    """Lines that determine how argument k is accessed, with the addresses of its scalars and
    lanes."""
    return [
        f"  %columns{k} = icmp eq i64 %step{k}, {lanes.real.size}",
        *_lane_table(k, lanes.width, None),
        f"  %blocks{k} = xor i1 %rows{k}, true",
        f"  %addressed{k} = or i1 %blocks{k}, %columns{k}",
        f"  %offset{k} = getelementptr i64, ptr %offsets, i64 {first}",
        f"  br i1 %addressed{k}, label %address{k}, label %prepared{k}",
        f"address{k}:",
        f"  call void @offsets(ptr %strides{k}, ptr @shape{k}, i64 {len(argument.shape)}, "
        f"i64 {argument.size}, ptr %offset{k})",
        f"  br label %prepared{k}",
        f"prepared{k}:",
    ]


def _lane_table(k: int, width: int, last: str | None) -> list[str]:
    """Lines that fill the table of lane addresses of argument k; in a short group, lanes beyond the
    `last` sample repeat it."""
    tag, table = f"{k}.{'s' if last else 'f'}", "%lanes.short" if last else "%lanes"
    v, numbers = f"<{width} x i64>", "<" + ", ".join(f"i64 {n}" for n in range(width)) + ">"
    lines = _equal(f"step{tag}", f"%step{k}", width)
    if last:
        lines += [
            *_equal(f"last{tag}", last, width),
            f"  %before{tag} = icmp slt {v} {numbers}, %last{tag}",
            f"  %number{tag} = select <{width} x i1> %before{tag}, {v} {numbers}, {v} %last{tag}",
        ]
        numbers = f"%number{tag}"
    return [
        *lines,
        f"  %lane{tag} = mul {v} {numbers}, %step{tag}",
        stored(f"%lane.at{tag}", v, f"%lane{tag}", table, k * width, of="i64"),
    ]


def _equal(name: str, number: str, width: int) -> list[str]:
    """Lines that define a vector %name with the number in all lanes."""
    return [
        f"  %{name}.0 = insertelement <{width} x i64> poison, i64 {number}, i64 0",
        f"  %{name} = shufflevector <{width} x i64> %{name}.0, <{width} x i64> poison, "
        f"<{width} x i32> zeroinitializer",
    ]
