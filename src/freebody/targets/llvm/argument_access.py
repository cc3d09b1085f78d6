"""LLVM text that finds out, when a kernel's loop begins, how each argument is read or written."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.program.program import Argument
from freebody.targets.llvm.lanes import Lanes


def access(arguments: Sequence[Argument], lanes: Lanes) -> list[str]:
    """How each argument is read or written; uniform ones are read at once."""
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
    """Base and step of argument k, and whether the scalars of one sample lie one after the
    other."""
    lines = [
        f"  %pbase{k} = getelementptr ptr, ptr %args, i64 {k}",
        f"  %base{k} = load ptr, ptr %pbase{k}, align 8",
        f"  %pstep{k} = getelementptr i64, ptr %steps, i64 {k}",
        f"  %step{k} = load i64, ptr %pstep{k}, align 8",
        f"  %strides{k} = getelementptr i64, ptr %steps, i64 {core}",
    ]
    rows, natural = "true", size
    for d in reversed(range(len(argument.shape))):
        lines += [
            f"  %pcore{k}.{d} = getelementptr i64, ptr %steps, i64 {core + d}",
            f"  %core{k}.{d} = load i64, ptr %pcore{k}.{d}, align 8",
        ]
        if argument.shape[d] > 1:  # the stride along an axis of one entry means nothing
            lines.append(f"  %natural{k}.{d} = icmp eq i64 %core{k}.{d}, {natural}")
            lines.append(f"  %rows{k}.{d} = and i1 {rows}, %natural{k}.{d}")
            rows = f"%rows{k}.{d}"
        natural *= argument.shape[d]
    return [*lines, f"  %rows{k} = and i1 {rows}, true"]


def _gather(k: int, argument: Argument, first: int, number: int, kind: str) -> list[str]:
    """Copy uniform argument k to the uniform numbers from `number` on; `first`: of its offsets in
    their table."""
    return [
        f"  %offset{k} = getelementptr i64, ptr %offsets, i64 {first}",
        f"  %uniform{k} = getelementptr {kind}, ptr %uniform, i64 {number}",
        f"  call void @gather(ptr %base{k}, i1 %rows{k}, ptr %strides{k}, ptr @shape{k}, "
        f"i64 {len(argument.shape)}, i64 {argument.size}, ptr %offset{k}, ptr %uniform{k})",
    ]


def _prepare(k: int, argument: Argument, first: int, lanes: Lanes) -> list[str]:
    """Way of access, addresses of the scalars and lanes of argument k."""
    return [
        f"  %columns{k} = icmp eq i64 %step{k}, {lanes.real.size}",
        *lane_table(k, lanes.width, None),
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


def lane_table(k: int, width: int, last: str | None) -> list[str]:
    """Fill the table of lane addresses of argument k; of a short group, lanes beyond the `last`
    sample repeat it."""
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
        f"  %lane.at{tag} = getelementptr i64, ptr {table}, i64 {k * width}",
        f"  store {v} %lane{tag}, ptr %lane.at{tag}, align 8",
    ]


def _equal(name: str, number: str, width: int) -> list[str]:
    """%name: the number in all lanes."""
    return [
        f"  %{name}.0 = insertelement <{width} x i64> poison, i64 {number}, i64 0",
        f"  %{name} = shufflevector <{width} x i64> %{name}.0, <{width} x i64> poison, "
        f"<{width} x i32> zeroinitializer",
    ]
