"""Constants among many results, such as the zeros of a tree's derivatives: written in loops over
runs of equal ones, whose places are a table of the module."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from freebody.targets.llvm.lanes import Lanes

_LOOP = """\
  br label %runs{s}
runs{s}:
  %r{s} = phi i64 [ 0, %{before} ], [ %r{s}.next, %done{s} ]
  %at{s} = getelementptr {{ i32, i32 }}, ptr {table}, i64 %r{s}
  %to.at{s} = getelementptr i32, ptr %at{s}, i64 1
  %from32.{s} = load i32, ptr %at{s}, align 4, !invariant.load !0
  %to32.{s} = load i32, ptr %to.at{s}, align 4, !invariant.load !0
  %from{s} = zext i32 %from32.{s} to i64
  %to{s} = zext i32 %to32.{s} to i64
  br label %entry{s}
entry{s}:
  %j{s} = phi i64 [ %from{s}, %runs{s} ], [ %j{s}.next, %entry{s} ]
  %offset{s} = mul i64 %core{k}, %j{s}
  %place{s} = getelementptr {v}, ptr %row{k}, i64 %offset{s}
  store {v} {value}, ptr %place{s}, align {size}
  %j{s}.next = add i64 %j{s}, 1
  %more{s} = icmp ult i64 %j{s}.next, %to{s}
  br i1 %more{s}, label %entry{s}, label %done{s}
done{s}:
  %r{s}.next = add i64 %r{s}, 1
  %again{s} = icmp ult i64 %r{s}.next, {count}
  br i1 %again{s}, label %runs{s}, label %after{s}
after{s}:"""


def runs(places: Iterable[int]) -> list[tuple[int, int]]:
    """First place and the one after the last of each run of neighbours."""
    found: list[tuple[int, int]] = []
    for place in sorted(places):
        if found and found[-1][1] == place:
            found[-1] = found[-1][0], place + 1
        else:
            found.append((place, place + 1))
    return found


def loop(
    name: str, s: int, lanes: Lanes, k: int, value: str, places: Sequence[int]
) -> tuple[str, str]:
    """(a table, lines) that write a value to these entries of argument k; s: the loop's number in
    the entry of that name, in which they follow each other."""
    found, table = runs(places), f"@{name}.runs{s}"
    rows = ", ".join(f"{{ i32, i32 }} {{ i32 {a}, i32 {b} }}" for a, b in found)
    declared = f"{table} = internal constant [{len(found)} x {{ i32, i32 }}] [{rows}], align 4\n"
    before = f"after{s - 1}" if s else "sample"
    return declared, _LOOP.format(
        s=s, before=before, table=table, k=k, v=lanes.v, value=value, size=lanes.real.size,
        count=len(found),
    )  # fmt: skip
