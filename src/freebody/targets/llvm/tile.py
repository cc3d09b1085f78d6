"""LLVM text that moves a group of samples between an array and the tile.

There are three ways:

- rows: the scalars of a sample are contiguous. Vectors are loaded along the rows and transposed in registers;
  a mask keeps the last block of columns inside the row, so that nothing outside the array is touched.
- columns: samples are contiguous, so each scalar is one vector load.
- strided: anything else, one double at a time.

The address of scalar j of the sample in lane l is `at + offsets[j] + lanes[l]`, in bytes.
"""

from __future__ import annotations

from collections.abc import Sequence

from freebody.program.program import Program
from freebody.program.segments import Layout


def transfers(program: Program, layout: Layout, width: int) -> str:
    """`@places0`, `@rows0`, … for each argument, `@columns_in`, `@strided_out`, … and `@offsets`."""
    places, first = [], 0
    for argument in program.inputs:
        places.append(list(range(first, first + argument.size)))
        first += argument.size
    first = 0
    for argument in program.outputs:
        places.append([layout.results[i] for i in program.results[first : first + argument.size]])
        first += argument.size
    parts = [f"@places{k} = internal constant {integers(those)}" for k, those in enumerate(places)]
    for k, those in enumerate(places):
        parts.append((_rows_in if k < len(program.inputs) else _rows_out)(k, those, width))
    parts += [write(way, width) for write in (_columns, _strided) for way in ("in", "out")]
    return "\n".join([*parts, _OFFSETS, _declarations(width)])


def integers(numbers: Sequence[int]) -> str:
    """A constant array."""
    return f"[{len(numbers)} x i64] [{', '.join(f'i64 {n}' for n in numbers)}]"


def _rows_in(k: int, places: list[int], width: int) -> str:
    """Rows of input k to `places` of the tile: a loop over whole blocks of `width` columns, then the masked rest."""
    size, first = len(places), places[0] if places else 0
    whole = size - size % width
    lines = _begin_rows(k, width)
    if whole:
        lines.append("  br label %block\nblock:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %block ]")
        lines += _load_block("w", "%j", first, width, width)
        lines.append(
            f"  %j.next = add i64 %j, {width}\n  %more = icmp ult i64 %j.next, {whole}\n"
            "  br i1 %more, label %block, label %rest\nrest:"
        )
    if whole < size:
        lines += _load_block("r", str(whole), first, size - whole, width)
    return "\n".join([*lines, "  ret void", "}", ""])


def _begin_rows(k: int, width: int) -> list[str]:
    """`@rows{k}` as far as the address of each lane's row."""
    lines = [
        f"define internal void @rows{k}(ptr noalias %at, ptr noalias %lanes, ptr noalias %tile) #0 {{",
        "entry:",
    ]
    for lane in range(width):
        lines.append(f"  %pl{lane} = getelementptr i64, ptr %lanes, i64 {lane}")
        lines.append(f"  %l{lane} = load i64, ptr %pl{lane}, align 8")
        lines.append(f"  %row{lane} = getelementptr i8, ptr %at, i64 %l{lane}")
    return lines


def _load_block(tag: str, j: str, first: int, columns: int, width: int) -> list[str]:
    v, lines = f"<{width} x double>", []
    for lane in range(width):
        lines.append(f"  %{tag}p{lane} = getelementptr double, ptr %row{lane}, i64 {j}")
        if columns == width:
            lines.append(f"  %{tag}in{lane} = load {v}, ptr %{tag}p{lane}, align 8")
        else:
            lines.append(
                f"  %{tag}in{lane} = call {v} @llvm.masked.load.v{width}f64.p0(ptr %{tag}p{lane}, i32 8, "
                f"{_mask(columns, width)}, {v} zeroinitializer)"
            )
    names = _transpose(lines, tag, [f"%{tag}in{lane}" for lane in range(width)], width)
    for column in range(columns):
        lines.append(f"  %{tag}o{column} = add i64 {j}, {first + column}")
        lines.append(f"  %{tag}q{column} = getelementptr {v}, ptr %tile, i64 %{tag}o{column}")
        lines.append(f"  store {v} {names[column]}, ptr %{tag}q{column}, align {8 * width}")
    return lines


_PANEL = 4
"""Blocks of columns that are turned together: of half the lanes, so that all fits the registers."""


def _rows_out(k: int, places: list[int], width: int) -> str:
    """Rows of output k from `places` of the tile, each row's scalars in the order of their addresses.

    The order matters: where a store crosses into the next cache line, the following one joins it there.
    """
    size, step = len(places), _PANEL * width
    looped = size - size % step if size > 2 * step else 0
    lines = _begin_rows(k, width)
    if looped:
        lines.append("  br label %panel\npanel:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %panel ]")
        lines.append(f"  %place = getelementptr i64, ptr @places{k}, i64 %j")
        for column in range(step):
            lines.append(f"  %place.at{column} = getelementptr i64, ptr %place, i64 {column}")
            lines.append(f"  %place{column} = load i64, ptr %place.at{column}, align 8")
        lines += _store_panel("p", "%j", [f"%place{column}" for column in range(step)], width)
        lines.append(
            f"  %j.next = add i64 %j, {step}\n  %more = icmp ult i64 %j.next, {looped}\n"
            "  br i1 %more, label %panel, label %rest\nrest:"
        )
    for j in range(looped, size, step):
        lines += _store_panel(f"r{j}.", str(j), [str(place) for place in places[j : j + step]], width)
    return "\n".join([*lines, "  ret void", "}", ""])


def _store_panel(tag: str, j: str, places: list[str], width: int) -> list[str]:
    """Columns from j on: half the lanes, then the others; of each the blocks of `width`, width / 2, … columns."""
    lines, half = [], width // 2
    blocks, first, columns = [], 0, width
    while first < len(places):
        while columns > len(places) - first:
            columns //= 2
        blocks.append((first, columns))
        first += columns
    for start in (0, half):
        rows: list[list[tuple[str, int, int]]] = [
            [] for _ in range(half)
        ]  # of each lane (name, first column, columns)
        for first, columns in blocks:
            turn = _turn_half if columns == width else _turn_squares
            names = turn(lines, f"{tag}{start}.{first}.", places[first : first + columns], start, width)
            for row, name in zip(rows, names, strict=True):
                row.append((name, first, columns))
        for lane, row in enumerate(rows, start):
            for name, first, columns in row:
                at = f"%{tag}{start}.{first}.p{lane}"
                lines.append(f"  {at}.j = add i64 {j}, {first}")
                lines.append(f"  {at} = getelementptr double, ptr %row{lane}, i64 {at}.j")
                lines.append(f"  store <{columns} x double> {name}, ptr {at}, align 8")
    return lines


def _turn_half(lines: list[str], tag: str, places: list[str], start: int, width: int) -> list[str]:
    """Rows of `width` columns of the lanes from `start` on, half of them.

    Halves of two columns are put side by side, which a load does, neighbours interleaved, and 128-bit lanes gathered.
    """
    half = width // 2
    parts = [
        _load_lanes(lines, f"{tag}c{column}", place, start, half, width)
        for column, place in enumerate(places)
    ]
    apart = min(2, half)
    pairs = [
        _shuffle(lines, f"{tag}a{i}", parts[i], parts[i + apart], half, list(range(width)))
        for i in range(width)
        if not i & apart
    ]
    if width == 2:
        return pairs
    low = [k + side * width for k in range(0, width, 2) for side in (0, 1)]
    rows = []
    for odd in (0, 1):
        mixed = [
            _shuffle(lines, f"{tag}b{odd}{i}", pairs[i], pairs[i + 1], width, [k + odd for k in low])
            for i in range(0, half, 2)
        ]
        if width == 4:
            rows.append(mixed)
            continue
        picks = [[2 * p + e for p in (x, x + 2, x + 4, x + 6) for e in (0, 1)] for x in (0, 1)]
        rows.append([_shuffle(lines, f"{tag}r{odd}{x}", mixed[0], mixed[1], width, picks[x]) for x in (0, 1)])
    return [name for both in zip(*rows, strict=True) for name in both]


def _turn_squares(lines: list[str], tag: str, places: list[str], start: int, width: int) -> list[str]:
    """Rows of fewer columns, a power of two, of the lanes from `start` on, half of them: square by square."""
    size, rows = len(places), []
    for first in range(start, start + width // 2, size):
        square = [
            _load_lanes(lines, f"{tag}s{first}.{column}", place, first, size, width)
            for column, place in enumerate(places)
        ]
        rows += square if size == 1 else _transpose(lines, f"{tag}t{first}.", square, size)
    return rows


def _load_lanes(lines: list[str], name: str, place: str, start: int, count: int, width: int) -> str:
    """`count` lanes of a slot from lane `start` on."""
    lines.append(f"  %{name}.s = getelementptr <{width} x double>, ptr %tile, i64 {place}")
    lines.append(f"  %{name}.p = getelementptr double, ptr %{name}.s, i64 {start}")
    lines.append(f"  %{name} = load <{count} x double>, ptr %{name}.p, align {8 * count}")
    return f"%{name}"


def _shuffle(lines: list[str], name: str, x: str, y: str, size: int, picks: list[int]) -> str:
    v, mask = f"<{size} x double>", ", ".join(f"i32 {pick}" for pick in picks)
    lines.append(f"  %{name} = shufflevector {v} {x}, {v} {y}, <{len(picks)} x i32> <{mask}>")
    return f"%{name}"


def _mask(columns: int, width: int) -> str:
    return f"<{width} x i1> <" + ", ".join(f"i1 {int(k < columns)}" for k in range(width)) + ">"


def _transpose(lines: list[str], tag: str, rows: list[str], width: int) -> list[str]:
    """Transpose a square of registers with log2(width) rounds of two-operand shuffles that x86 has as one
    instruction.

    First neighbours are interleaved; then 128-bit lanes are gathered, the even ones of a pair and the odd
    ones.
    """
    count = 0

    def shuffle(x: str, y: str, picks: list[int]) -> str:
        nonlocal count
        count += 1
        return _shuffle(lines, f"{tag}t{count}", x, y, width, picks)

    def interleave(x: str, y: str, odd: int) -> str:
        return shuffle(x, y, [k + odd + side * width for k in range(0, width, 2) for side in (0, 1)])

    def halves(x: str, y: str, odd: int) -> str:
        pairs = [p for p in range(width) if p % 2 == odd]  # 128-bit lanes of x, then of y
        return shuffle(x, y, [2 * p + e for p in pairs for e in (0, 1)])

    def gather(vectors: list[str]) -> list[str]:
        if len(vectors) == 1:
            return vectors
        pairs = list(zip(vectors[::2], vectors[1::2], strict=True))
        even, odd = (gather([halves(x, y, parity) for x, y in pairs]) for parity in (0, 1))
        return [name for both in zip(even, odd, strict=True) for name in both]

    pairs = list(zip(rows[::2], rows[1::2], strict=True))
    even, odd = (gather([interleave(x, y, parity) for x, y in pairs]) for parity in (0, 1))
    return [name for both in zip(even, odd, strict=True) for name in both]


def _columns(way: str, width: int) -> str:
    """Slots from (or to) places where the samples are contiguous."""
    v = f"<{width} x double>"
    source, target = ("%p", "%slot") if way == "in" else ("%slot", "%p")
    align = {"%p": 8, "%slot": 8 * width}
    return f"""\
define internal void @columns_{way}(ptr %at, ptr %lanes, ptr %tile, ptr %places, ptr %offsets, i64 %n) #0 {{
entry:
  br label %loop
loop:
  %j = phi i64 [ 0, %entry ], [ %next, %loop ]
  %po = getelementptr i64, ptr %offsets, i64 %j
  %o = load i64, ptr %po, align 8
  %p = getelementptr i8, ptr %at, i64 %o
  %place.at = getelementptr i64, ptr %places, i64 %j
  %place = load i64, ptr %place.at, align 8
  %slot = getelementptr {v}, ptr %tile, i64 %place
  %x = load {v}, ptr {source}, align {align[source]}
  store {v} %x, ptr {target}, align {align[target]}
  %next = add i64 %j, 1
  %more = icmp ult i64 %next, %n
  br i1 %more, label %loop, label %end
end:
  ret void
}}
"""


def _strided(way: str, width: int) -> str:
    """Slots from (or to) places anywhere, one double at a time."""
    source, target = ("%p", "%q") if way == "in" else ("%q", "%p")
    return f"""\
define internal void @strided_{way}(ptr %at, ptr %lanes, ptr %tile, ptr %places, ptr %offsets, i64 %n) #0 {{
entry:
  br label %scalar
scalar:
  %j = phi i64 [ 0, %entry ], [ %j.next, %scalar.end ]
  %po = getelementptr i64, ptr %offsets, i64 %j
  %o = load i64, ptr %po, align 8
  %pj = getelementptr i8, ptr %at, i64 %o
  %place.at = getelementptr i64, ptr %places, i64 %j
  %place = load i64, ptr %place.at, align 8
  %slot = getelementptr <{width} x double>, ptr %tile, i64 %place
  br label %lane
lane:
  %l = phi i64 [ 0, %scalar ], [ %l.next, %lane ]
  %pl = getelementptr i64, ptr %lanes, i64 %l
  %ol = load i64, ptr %pl, align 8
  %p = getelementptr i8, ptr %pj, i64 %ol
  %q = getelementptr double, ptr %slot, i64 %l
  %x = load double, ptr {source}, align 8
  store double %x, ptr {target}, align 8
  %l.next = add i64 %l, 1
  %more.lanes = icmp ult i64 %l.next, {width}
  br i1 %more.lanes, label %lane, label %scalar.end
scalar.end:
  %j.next = add i64 %j, 1
  %more = icmp ult i64 %j.next, %n
  br i1 %more, label %scalar, label %end
end:
  ret void
}}
"""


# row-major: the last axis runs fastest; the first needs no division
_OFFSETS = """\
define internal void @offsets(ptr %strides, ptr %shape, i64 %rank, i64 %count, ptr %offsets) #0 {
entry:
  br label %head
head:
  %j = phi i64 [ 0, %entry ], [ %j.next, %store ]
  %more = icmp ult i64 %j, %count
  br i1 %more, label %axis, label %end
axis:
  %d = phi i64 [ %rank, %head ], [ %d.next, %inner ]
  %rest = phi i64 [ %j, %head ], [ %rest.next, %inner ]
  %sum = phi i64 [ 0, %head ], [ %sum.next, %inner ]
  %d.next = sub i64 %d, 1
  %ps = getelementptr i64, ptr %strides, i64 %d.next
  %deeper = icmp ugt i64 %d, 1
  br i1 %deeper, label %inner, label %outer
inner:
  %pn = getelementptr i64, ptr %shape, i64 %d.next
  %size = load i64, ptr %pn, align 8
  %stride = load i64, ptr %ps, align 8
  %index = urem i64 %rest, %size
  %rest.next = udiv i64 %rest, %size
  %part = mul i64 %index, %stride
  %sum.next = add i64 %sum, %part
  br label %axis
outer:
  %scalar = icmp eq i64 %rank, 0
  br i1 %scalar, label %store, label %first
first:
  %stride0 = load i64, ptr %ps, align 8
  %part0 = mul i64 %rest, %stride0
  %sum0 = add i64 %sum, %part0
  br label %store
store:
  %offset = phi i64 [ 0, %outer ], [ %sum0, %first ]
  %po = getelementptr i64, ptr %offsets, i64 %j
  store i64 %offset, ptr %po, align 8
  %j.next = add i64 %j, 1
  br label %head
end:
  ret void
}
"""


def _declarations(width: int) -> str:
    v = f"<{width} x double>"
    return f"declare {v} @llvm.masked.load.v{width}f64.p0(ptr, i32, <{width} x i1>, {v})\n"
