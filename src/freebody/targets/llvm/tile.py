"""LLVM text that moves a group of samples between an array and the tile.

There are three ways:

- rows: the scalars of a sample are contiguous. Vectors are loaded along the rows and transposed in registers;
  a mask keeps the last block of columns inside the row, so that nothing outside the array is touched.
- columns: samples are contiguous, so each scalar is one vector load.
- strided: anything else, one number at a time.

The address of scalar j of the sample in lane l is `at + offsets[j] + lanes[l]`, in bytes.
"""

from __future__ import annotations

from collections.abc import Sequence

from freebody.program.program import Program
from freebody.program.segments import Layout
from freebody.targets.llvm.lanes import Lanes, Real


def transfers(program: Program, every: Program, layout: Layout, lanes: Lanes) -> str:
    """`@places0`, `@rows0`, … for each argument that is not uniform, `@columns_in`, `@strided_out`, … and `@offsets`.

    program: whose arguments are numbered. every: what is computed on a tile of `layout`.
    """
    places: dict[int, list[int]] = {}
    first = 0
    for k, argument in enumerate(program.inputs):
        if not argument.uniform:
            places[k] = list(range(first, first + argument.size))
            first += argument.size
    first = 0
    for k, argument in enumerate(program.outputs, len(program.inputs)):
        places[k] = [layout.results[i] for i in every.results[first : first + argument.size]]
        first += argument.size
    parts = [f"@places{k} = internal constant {integers(those)}" for k, those in places.items()]
    for k, those in places.items():
        parts.append((_rows_in if k < len(program.inputs) else _rows_out)(k, those, lanes))
    parts += [write(way, lanes) for write in (_columns, _strided) for way in ("in", "out")]
    return "\n".join([*parts, _OFFSETS, _declarations(lanes)])


def integers(numbers: Sequence[int]) -> str:
    """A constant array."""
    return f"[{len(numbers)} x i64] [{', '.join(f'i64 {n}' for n in numbers)}]"


def _rows_in(k: int, places: list[int], lanes: Lanes) -> str:
    """Rows of input k to `places` of the tile: a loop over whole blocks of `width` columns, then the masked rest."""
    size, first, width = len(places), places[0] if places else 0, lanes.width
    whole = size - size % width
    lines = _begin_rows(k, width)
    if whole:
        lines.append("  br label %block\nblock:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %block ]")
        lines += _load_block("w", "%j", first, width, lanes)
        lines.append(
            f"  %j.next = add i64 %j, {width}\n  %more = icmp ult i64 %j.next, {whole}\n"
            "  br i1 %more, label %block, label %rest\nrest:"
        )
    if whole < size:
        lines += _load_block("r", str(whole), first, size - whole, lanes)
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


def _load_block(tag: str, j: str, first: int, columns: int, lanes: Lanes) -> list[str]:
    v, real, width, lines = lanes.v, lanes.real, lanes.width, list[str]()
    for lane in range(width):
        lines.append(f"  %{tag}p{lane} = getelementptr {real.name}, ptr %row{lane}, i64 {j}")
        if columns == width:
            lines.append(f"  %{tag}in{lane} = load {v}, ptr %{tag}p{lane}, align {real.size}")
        else:
            lines.append(
                f"  %{tag}in{lane} = call {v} @llvm.masked.load.{lanes.suffix}.p0(ptr %{tag}p{lane}, i32 {real.size}, "
                f"{_mask(columns, width)}, {v} zeroinitializer)"
            )
    names = _transpose(lines, tag, [f"%{tag}in{lane}" for lane in range(width)], lanes.real)
    for column in range(columns):
        lines.append(f"  %{tag}o{column} = add i64 {j}, {first + column}")
        lines.append(f"  %{tag}q{column} = getelementptr {v}, ptr %tile, i64 %{tag}o{column}")
        lines.append(f"  store {v} {names[column]}, ptr %{tag}q{column}, align {lanes.size}")
    return lines


_PANEL = 4
"""Blocks of columns that are turned together: of half the lanes, so that all fits the registers."""


def _rows_out(k: int, places: list[int], lanes: Lanes) -> str:
    """Rows of output k from `places` of the tile, each row's scalars in the order of their addresses.

    The order matters: where a store crosses into the next cache line, the following one joins it there.
    """
    size, width = len(places), lanes.width
    step = _PANEL * width
    looped = size - size % step if size > 2 * step else 0
    lines = _begin_rows(k, width)
    if looped:
        lines.append("  br label %panel\npanel:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %panel ]")
        lines.append(f"  %place = getelementptr i64, ptr @places{k}, i64 %j")
        for column in range(step):
            lines.append(f"  %place.at{column} = getelementptr i64, ptr %place, i64 {column}")
            lines.append(f"  %place{column} = load i64, ptr %place.at{column}, align 8")
        lines += _store_panel("p", "%j", [f"%place{column}" for column in range(step)], lanes)
        lines.append(
            f"  %j.next = add i64 %j, {step}\n  %more = icmp ult i64 %j.next, {looped}\n"
            "  br i1 %more, label %panel, label %rest\nrest:"
        )
    for j in range(looped, size, step):
        lines += _store_panel(f"r{j}.", str(j), [str(place) for place in places[j : j + step]], lanes)
    return "\n".join([*lines, "  ret void", "}", ""])


def _store_panel(tag: str, j: str, places: list[str], lanes: Lanes) -> list[str]:
    """Columns from j on: half the lanes, then the others; of each the blocks of `width`, width / 2, … columns."""
    lines, real, half = [], lanes.real, lanes.width // 2
    blocks, first, columns = [], 0, lanes.width
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
            turn = _turn_half if columns == lanes.width else _turn_squares
            names = turn(lines, f"{tag}{start}.{first}.", places[first : first + columns], start, lanes)
            for row, name in zip(rows, names, strict=True):
                row.append((name, first, columns))
        for lane, row in enumerate(rows, start):
            for name, first, columns in row:
                at = f"%{tag}{start}.{first}.p{lane}"
                lines.append(f"  {at}.j = add i64 {j}, {first}")
                lines.append(f"  {at} = getelementptr {real.name}, ptr %row{lane}, i64 {at}.j")
                lines.append(f"  store <{columns} x {real.name}> {name}, ptr {at}, align {real.size}")
    return lines


def _turn_half(lines: list[str], tag: str, places: list[str], start: int, lanes: Lanes) -> list[str]:
    """Rows of `width` columns of the lanes from `start` on, half of them.

    Halves of two columns are put side by side, which a load does; what lies in 128 bits is turned, and 128-bit parts
    gathered.
    """
    real, width = lanes.real, lanes.width
    half = width // 2
    parts = [
        _load_lanes(lines, f"{tag}c{column}", place, start, half, lanes)
        for column, place in enumerate(places)
    ]
    apart = min(128 // real.bits, half)
    pairs = [
        _shuffle(lines, f"{tag}a{i}", parts[i], parts[i + apart], half, list(range(width)), real)
        for i in range(width)
        if not i & apart
    ]
    turned = [
        _turn_parts(lines, f"{tag}b{i}.", pairs[i : i + apart], width, real) for i in range(0, half, apart)
    ]
    if half == apart:
        return turned[0]
    picks = [_gathered(width, apart, odd) for odd in (0, 1)]
    return [
        _shuffle(lines, f"{tag}r{j}.{odd}", turned[0][j], turned[1][j], width, picks[odd], real)
        for odd in (0, 1)
        for j in range(apart)
    ]


def _turn_squares(lines: list[str], tag: str, places: list[str], start: int, lanes: Lanes) -> list[str]:
    """Rows of fewer columns, a power of two, of the lanes from `start` on, half of them: square by square."""
    size, rows = len(places), []
    for first in range(start, start + lanes.width // 2, size):
        square = [
            _load_lanes(lines, f"{tag}s{first}.{column}", place, first, size, lanes)
            for column, place in enumerate(places)
        ]
        rows += square if size == 1 else _transpose(lines, f"{tag}t{first}.", square, lanes.real)
    return rows


def _load_lanes(lines: list[str], name: str, place: str, start: int, count: int, lanes: Lanes) -> str:
    """`count` lanes of a slot from lane `start` on."""
    kind = lanes.real.name
    lines.append(f"  %{name}.s = getelementptr {lanes.v}, ptr %tile, i64 {place}")
    lines.append(f"  %{name}.p = getelementptr {kind}, ptr %{name}.s, i64 {start}")
    lines.append(f"  %{name} = load <{count} x {kind}>, ptr %{name}.p, align {lanes.real.size * count}")
    return f"%{name}"


def _shuffle(lines: list[str], name: str, x: str, y: str, size: int, picks: list[int], real: Real) -> str:
    v, mask = f"<{size} x {real.name}>", ", ".join(f"i32 {pick}" for pick in picks)
    lines.append(f"  %{name} = shufflevector {v} {x}, {v} {y}, <{len(picks)} x i32> <{mask}>")
    return f"%{name}"


def _mask(columns: int, width: int) -> str:
    return f"<{width} x i1> <" + ", ".join(f"i1 {int(k < columns)}" for k in range(width)) + ">"


def _transpose(lines: list[str], tag: str, rows: list[str], real: Real) -> list[str]:
    """Transpose a square of registers with log2(width) rounds of two-operand shuffles that x86 has as one
    instruction.

    First what lies in 128 bits is turned; then 128-bit parts are gathered, the even ones of a pair and the odd
    ones.
    """
    width, count = len(rows), 0
    part = min(128 // real.bits, width)

    def halves(x: str, y: str, odd: int) -> str:
        nonlocal count
        count += 1
        return _shuffle(lines, f"{tag}t{count}", x, y, width, _gathered(width, part, odd), real)

    def gather(vectors: list[str]) -> list[str]:
        if len(vectors) == 1:
            return vectors
        pairs = list(zip(vectors[::2], vectors[1::2], strict=True))
        even, odd = (gather([halves(x, y, parity) for x, y in pairs]) for parity in (0, 1))
        return [name for both in zip(even, odd, strict=True) for name in both]

    turned = [
        _turn_parts(lines, f"{tag}p{k}.", rows[k : k + part], width, real) for k in range(0, width, part)
    ]
    columns = [gather([those[j] for those in turned]) for j in range(part)]
    return [name for several in zip(*columns, strict=True) for name in several]


def _gathered(width: int, part: int, odd: int) -> list[int]:
    """The even (or odd) ones of the parts of two vectors."""
    return [part * p + e for p in range(odd, 2 * width // part, 2) for e in range(part)]


def _turn_parts(lines: list[str], tag: str, rows: list[str], width: int, real: Real) -> list[str]:
    """Transpose the squares that lie side by side in 1, 2 or 4 rows: neighbours are interleaved, then pairs."""

    def interleaved(x: str, y: str, high: int, of: int) -> str:
        """Of each square the lower (or higher) half of x and y, `of` entries of one and of the other by turns."""
        picks = [
            start + high * size // 2 + k + side * width + e
            for start in range(0, width, size)
            for k in range(0, size // 2, of)
            for side in (0, 1)
            for e in range(of)
        ]
        return _shuffle(lines, f"{tag}{len(lines)}", x, y, width, picks, real)

    size = len(rows)
    if size == 1:
        return rows
    if size == 2:
        return [interleaved(rows[0], rows[1], high, 1) for high in (0, 1)]
    one, other = ([interleaved(rows[k], rows[k + 1], high, 1) for high in (0, 1)] for k in (0, 2))
    return [interleaved(x, y, high, 2) for x, y in zip(one, other, strict=True) for high in (0, 1)]


def _columns(way: str, lanes: Lanes) -> str:
    """Slots from (or to) places where the samples are contiguous."""
    v = lanes.v
    source, target = ("%p", "%slot") if way == "in" else ("%slot", "%p")
    align = {"%p": lanes.real.size, "%slot": lanes.size}
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


def _strided(way: str, lanes: Lanes) -> str:
    """Slots from (or to) places anywhere, one number at a time."""
    kind, align = lanes.real.name, lanes.real.size
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
  %slot = getelementptr {lanes.v}, ptr %tile, i64 %place
  br label %lane
lane:
  %l = phi i64 [ 0, %scalar ], [ %l.next, %lane ]
  %pl = getelementptr i64, ptr %lanes, i64 %l
  %ol = load i64, ptr %pl, align 8
  %p = getelementptr i8, ptr %pj, i64 %ol
  %q = getelementptr {kind}, ptr %slot, i64 %l
  %x = load {kind}, ptr {source}, align {align}
  store {kind} %x, ptr {target}, align {align}
  %l.next = add i64 %l, 1
  %more.lanes = icmp ult i64 %l.next, {lanes.width}
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


def _declarations(lanes: Lanes) -> str:
    return f"declare {lanes.v} @llvm.masked.load.{lanes.suffix}.p0(ptr, i32, {lanes.mask}, {lanes.v})\n"
