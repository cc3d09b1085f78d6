"""LLVM text that moves rows (the contiguous scalars of each sample) between an array and the
tile."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from freebody.targets.llvm.lanes import Lanes, Real, loaded, stored


def rows_in(k: int, places: list[int], check: int, lanes: Lanes) -> str:
    """LLVM text that reads rows of input k into `places` of the tile: a loop over whole blocks of
    `width` columns, then the masked rest.

    To the slot `check` goes a sum of products of its numbers, each in one of them: finite only if
    all of them are.
    """
    size, first, width, v = len(places), places[0] if places else 0, lanes.width, lanes.v
    whole = size - size % width
    lines, looked = _begin_rows(k, width), "zeroinitializer"
    if whole:
        lines.append("  br label %block\nblock:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %block ]")
        begin = len(lines)
        looked = _load_block(lines, "w", "%j", first, width, "%looked", lanes)
        lines.insert(
            begin, f"  %looked = phi {v} [ zeroinitializer, %entry ], [ {looked}, %block ]"
        )
        lines.append(
            f"  %j.next = add i64 %j, {width}\n  %more = icmp ult i64 %j.next, {whole}\n"
            "  br i1 %more, label %block, label %rest\nrest:"
        )
    if whole < size:
        looked = _load_block(lines, "r", str(whole), first, size - whole, looked, lanes)
    lines.append(stored("%check", v, looked, "%tile", check, align=lanes.size))
    return "\n".join([*lines, "  ret void", "}", ""])


def _begin_rows(k: int, width: int) -> list[str]:
    """The beginning of the function `@rows{k}`, up to the address of each lane's row."""
    lines = [
        f"define internal void @rows{k}(ptr noalias %at, ptr noalias %lanes, ptr noalias %tile) #0 "
        f"{{",
        "entry:",
    ]
    for lane in range(width):
        lines.append(loaded(f"%l{lane}", "i64", "%lanes", lane))
        lines.append(f"  %row{lane} = getelementptr i8, ptr %at, i64 %l{lane}")
    return lines


def _load_block(
    lines: list[str], tag: str, j: str, first: int, columns: int, looked: str, lanes: Lanes
) -> str:
    """The name of the finiteness check after loading columns j and following into slots from
    `first` + j on; where they fill at most half a vector, it takes two rows.

    The value of what has been looked at, with products of these columns added.
    """
    v, width, part = lanes.v, lanes.width, _part_of(lanes.real, lanes.width)
    several = 2 if 2 * columns <= width and 2 * part <= width else 1
    loaded = [_load_row(lines, tag, lane, j, columns, several, lanes) for lane in range(width)]
    if several == 2:
        # side by side those rows that come out in order when 128-bit parts are gathered
        loaded = [
            _shuffle(
                lines,
                f"{tag}two{lane}",
                loaded[lane],
                loaded[lane + part],
                width // 2,
                range(width),
                lanes.real,
            )
            for lane in range(width)
            if not lane & part
        ]
    for pair, (x, y) in enumerate(zip(loaded[::2], loaded[1::2], strict=True)):
        lines.append(f"  %{tag}m{pair} = fmul contract {v} {x}, {y}")
        lines.append(f"  %{tag}a{pair} = fadd contract {v} {looked}, %{tag}m{pair}")
        looked = f"%{tag}a{pair}"
    names = _transpose(lines, tag, loaded, width, lanes.real)
    for column in range(columns):
        lines.append(f"  %{tag}o{column} = add i64 {j}, {first + column}")
        at, place = f"%{tag}q{column}", f"%{tag}o{column}"
        lines.append(stored(at, v, names[column], "%tile", place, align=lanes.size))
    return looked


def _load_row(
    lines: list[str], tag: str, lane: int, j: str, columns: int, several: int, lanes: Lanes
) -> str:
    """The name of one lane's row, loaded into a vector of which `several` make a whole one; a mask
    keeps the load inside the row."""
    real, width, name = lanes.real, lanes.width // several, f"%{tag}in{lane}"
    v = f"<{width} x {real.name}>"
    lines.append(f"  {name}.p = getelementptr {real.name}, ptr %row{lane}, i64 {j}")
    if columns == width:
        lines.append(f"  {name} = load {v}, ptr {name}.p, align {real.size}")
    else:
        mask = ", ".join(f"i1 {int(k < columns)}" for k in range(width))
        lines.append(
            f"  {name} = call {v} @llvm.masked.load.v{width}f{real.bits}.p0(ptr {name}.p, i32 "
            f"{real.size}, <{width} x i1> <{mask}>, {v} zeroinitializer)"
        )
    return name


def masked_loads(lanes: Lanes) -> str:
    """The LLVM declarations of masked loads, which read rows."""
    return "".join(
        f"declare {some.v} @llvm.masked.load.{some.suffix}.p0(ptr, i32, {some.mask}, {some.v})\n"
        for some in (lanes, Lanes(lanes.real, lanes.width // 2))
    )


_PANEL = 4
"""Blocks of columns that are turned together: of half the lanes, so that all fits the registers."""


def rows_out(k: int, places: list[int], lanes: Lanes) -> str:
    """LLVM text that writes rows of output k from `places` of the tile, each row's scalars in the
    order of their addresses.

    The order matters: where a store crosses into the next cache line, the following one joins it
    there.
    """
    size, width = len(places), lanes.width
    step = _PANEL * width
    looped = size - size % step if size > 2 * step else 0
    lines = _begin_rows(k, width)
    if looped:
        lines.append("  br label %panel\npanel:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %panel ]")
        lines.append(f"  %place = getelementptr i64, ptr @places{k}, i64 %j")
        for column in range(step):
            lines.append(loaded(f"%place{column}", "i64", "%place", column))
        lines += _store_panel("p", "%j", [f"%place{column}" for column in range(step)], lanes)
        lines.append(
            f"  %j.next = add i64 %j, {step}\n  %more = icmp ult i64 %j.next, {looped}\n"
            "  br i1 %more, label %panel, label %rest\nrest:"
        )
    for j in range(looped, size, step):
        lines += _store_panel(
            f"r{j}.", str(j), [str(place) for place in places[j : j + step]], lanes
        )
    return "\n".join([*lines, "  ret void", "}", ""])


def _store_panel(tag: str, j: str, places: list[str], lanes: Lanes) -> list[str]:
    """Lines that write columns from j on, for half of the lanes and then the others, in blocks of
    `width`, width / 2, … columns."""
    lines, kind, half = [], lanes.real.name, lanes.width // 2
    part = _part_of(lanes.real, lanes.width)
    blocks, first, columns = [], 0, lanes.width
    while first < len(places):
        while columns > len(places) - first:
            columns //= 2
        blocks.append((first, columns))
        first += columns
    whole: dict[
        int, list[_Entries]
    ] = {}  # of narrow blocks, by their first column: where each lane's row is
    for start in (0, half):
        rows: list[list[tuple[_Entries, int, int]]] = [
            [] for _ in range(half)
        ]  # (…, first column, columns)
        for first, columns in blocks:
            name, those = f"{tag}{start}.{first}.", places[first : first + columns]
            if 1 < columns <= part and columns < lanes.width:
                if first not in whole:
                    whole[first] = _turn_narrow(lines, name, those, lanes)
                found = whole[first][start : start + half]
            else:
                turn = _turn_half if columns == lanes.width else _turn_squares
                found = [_Entries(x, columns, 0) for x in turn(lines, name, those, start, lanes)]
            for row, entries in zip(rows, found, strict=True):
                row.append((entries, first, columns))
        for lane, row in enumerate(rows, start):
            for entries, first, columns in row:
                at = f"%{tag}{start}.{first}.p{lane}"
                value = entries.taken(lines, f"{at[1:]}.v", columns, lanes.real)
                lines.append(f"  {at}.j = add i64 {j}, {first}")
                lines.append(f"  {at} = getelementptr {kind}, ptr %row{lane}, i64 {at}.j")
                lines.append(
                    f"  store <{columns} x {kind}> {value}, ptr {at}, align {lanes.real.size}"
                )
    return lines


@dataclass(frozen=True)
class _Entries:
    """Neighbouring entries of a vector of `width`, from entry `first` on."""

    name: str
    width: int
    first: int

    def taken(self, lines: list[str], name: str, count: int, real: Real) -> str:
        """The name of a vector of the first `count` of these entries."""
        if count == self.width:
            return self.name
        picks = range(self.first, self.first + count)
        return _shuffle(lines, name, self.name, "poison", self.width, picks, real)


def _turn_narrow(lines: list[str], tag: str, places: list[str], lanes: Lanes) -> list[_Entries]:
    """The entries that hold each lane's row, after transposing columns that fill 128 bits or half
    of that."""
    columns, width = len(places), lanes.width
    part = _part_of(lanes.real, width)
    loaded = [
        _load_lanes(lines, f"{tag}w{column}", place, 0, width, lanes)
        for column, place in enumerate(places)
    ]
    turned = _turn_parts(lines, f"{tag}n", loaded, part, width, lanes.real)
    # of each part its first lanes are in the first vector, …
    each = part // len(turned)
    return [
        _Entries(turned[lane % part // each], width, lane - lane % part + lane % each * columns)
        for lane in range(width)
    ]


def _turn_half(
    lines: list[str], tag: str, places: list[str], start: int, lanes: Lanes
) -> list[str]:
    """Names of rows of `width` columns, for half of the lanes from `start` on.

    Halves of two columns are put side by side, which a load does; what lies in 128 bits is turned,
    and 128-bit parts gathered.
    """
    real, width = lanes.real, lanes.width
    half = width // 2
    parts = [
        _load_lanes(lines, f"{tag}c{column}", place, start, half, lanes)
        for column, place in enumerate(places)
    ]
    apart = _part_of(real, half)
    pairs = [
        _shuffle(lines, f"{tag}a{i}", parts[i], parts[i + apart], half, list(range(width)), real)
        for i in range(width)
        if not i & apart
    ]
    turned = [
        _turn_parts(lines, f"{tag}b{i}.", pairs[i : i + apart], apart, width, real)
        for i in range(0, half, apart)
    ]
    if half == apart:
        return turned[0]
    picks = [_gathered(width, apart, odd) for odd in (0, 1)]
    return [
        _shuffle(lines, f"{tag}r{j}.{odd}", turned[0][j], turned[1][j], width, picks[odd], real)
        for odd in (0, 1)
        for j in range(apart)
    ]


def _turn_squares(
    lines: list[str], tag: str, places: list[str], start: int, lanes: Lanes
) -> list[str]:
    """Names of rows of fewer columns (a power of two), for half of the lanes from `start` on,
    transposed square by square."""
    size, rows = len(places), []
    for first in range(start, start + lanes.width // 2, size):
        square = [
            _load_lanes(lines, f"{tag}s{first}.{column}", place, first, size, lanes)
            for column, place in enumerate(places)
        ]
        rows += (
            square if size == 1 else _transpose(lines, f"{tag}t{first}.", square, size, lanes.real)
        )
    return rows


def _load_lanes(
    lines: list[str], name: str, place: str, start: int, count: int, lanes: Lanes
) -> str:
    """The name of `count` lanes of a slot, loaded from lane `start` on."""
    kind = lanes.real.name
    lines.append(f"  %{name}.s = getelementptr {lanes.v}, ptr %tile, i64 {place}")
    v, align = f"<{count} x {kind}>", lanes.real.size * count
    lines.append(loaded(f"%{name}", v, f"%{name}.s", start, of=kind, align=align))
    return f"%{name}"


def _part_of(real: Real, width: int) -> int:
    """The number of entries in 128 bits, or in a vector of `width` if that is shorter."""
    return min(128 // real.bits, width)


def _shuffle(
    lines: list[str], name: str, x: str, y: str, size: int, picks: Sequence[int], real: Real
) -> str:
    """The name of a vector of picked entries of two vectors of `size`, counted through x and then
    y."""
    v, mask = f"<{size} x {real.name}>", ", ".join(f"i32 {pick}" for pick in picks)
    lines.append(f"  %{name} = shufflevector {v} {x}, {v} {y}, <{len(picks)} x i32> <{mask}>")
    return f"%{name}"


def _transpose(lines: list[str], tag: str, rows: list[str], width: int, real: Real) -> list[str]:
    """Names of the columns of a square of `width` rows, transposed by two-operand shuffles that are
    single instructions on x86: first within 128 bits, then 128-bit parts are gathered.

    Half as many vectors hold two rows of half the width each, side by side: k and k + p with p
    numbers in 128 bits, for every k without the bit p.
    """
    part, count = _part_of(real, width), 0

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
        _turn_parts(lines, f"{tag}p{k}.", rows[k : k + part], part, width, real)
        for k in range(0, len(rows), part)
    ]
    columns = [gather([those[j] for those in turned]) for j in range(part)]
    return [name for several in zip(*columns, strict=True) for name in several]


def _gathered(width: int, part: int, odd: int) -> list[int]:
    """Indices that pick the even (or odd) parts of two vectors."""
    return [part * p + e for p in range(odd, 2 * width // part, 2) for e in range(part)]


def _turn_parts(
    lines: list[str], tag: str, rows: list[str], part: int, width: int, real: Real
) -> list[str]:
    """Names of vectors in which parts of 1, 2 or 4 numbers are transposed, of at most as many rows:
    neighbours are interleaved, then pairs."""

    def interleaved(x: str, y: str, high: int, of: int) -> str:
        """The name of a vector that interleaves the lower (or higher) halves of each part of x and
        y, `of` entries of each in turn."""
        picks = [
            start + high * part // 2 + k + side * width + e
            for start in range(0, width, part)
            for k in range(0, part // 2, of)
            for side in (0, 1)
            for e in range(of)
        ]
        return _shuffle(lines, f"{tag}{len(lines)}", x, y, width, picks, real)

    if len(rows) == 1:
        return rows
    if len(rows) == 2:
        return [interleaved(rows[0], rows[1], high, 1) for high in (0, 1)]
    one, other = ([interleaved(rows[k], rows[k + 1], high, 1) for high in (0, 1)] for k in (0, 2))
    return [interleaved(x, y, high, 2) for x, y in zip(one, other, strict=True) for high in (0, 1)]
