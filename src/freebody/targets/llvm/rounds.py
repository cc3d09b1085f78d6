"""LLVM text of the rounds of a kernel's loop: groups of samples in, those of the round before out,
`@compute`."""

from __future__ import annotations

from collections.abc import Mapping

from freebody.program.program import Argument, Program
from freebody.targets.llvm.argument_access import lane_table
from freebody.targets.llvm.lanes import Lanes


def rounds(
    program: Program, lanes: Lanes, slots: int, tiles: int, checks: Mapping[int, int]
) -> list[str]:
    """Until the last round is out."""
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
    """A round of full groups whose arguments are all rows, and the one before it, with nothing to
    be decided."""
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
    """Move the groups of the round that begins with sample `start` in or out; afterwards `%in.g` is
    their number."""
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
        lines += lane_table(k, width, f"%{way}.last")
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
    """Move one group of argument k between array and tile; of an input, what was seen of it to the
    slot `check`."""
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
