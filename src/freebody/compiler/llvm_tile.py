"""LLVM text that moves a group of samples between an array and the tile.

There are three ways:

- rows: the scalars of a sample are contiguous. Vectors are loaded along the rows and transposed in registers;
  a mask keeps the last block of columns inside the row, so that nothing outside the array is touched.
- columns: samples are contiguous, so each scalar is one vector load.
- strided: anything else, one double at a time.

The address of scalar j of the sample in lane l is `at + offsets[j] + lanes[l]`, in bytes.
"""

from __future__ import annotations

from collections.abc import Callable

from freebody.compiler.program import Program


def transfers(program: Program, width: int) -> str:
    """`@rows_in_6`, `@columns_out`, …: all that a program's arguments need, and `@offsets`."""
    sizes_in = sorted({argument.size for argument in program.inputs})
    sizes_out = sorted({argument.size for argument in program.outputs})
    parts = [_rows("in", size, width, _load_block) for size in sizes_in]
    parts += [_rows("out", size, width, _store_block) for size in sizes_out]
    parts += [write(way, width) for write in (_columns, _strided) for way in ("in", "out")]
    return "\n".join([*parts, _OFFSETS, _declarations(width)])


_Block = Callable[[str, str, int, int], list[str]]


def _rows(way: str, size: int, width: int, block: _Block) -> str:
    """Rows of `size` doubles: a loop over whole blocks of `width` columns, then the masked rest."""
    whole, rest = size - size % width, size % width
    lines = [f"define internal void @rows_{way}_{size}(ptr %at, ptr %lanes, ptr %slots) #0 {{", "entry:"]
    for lane in range(width):
        lines.append(f"  %pl{lane} = getelementptr i64, ptr %lanes, i64 {lane}")
        lines.append(f"  %l{lane} = load i64, ptr %pl{lane}, align 8")
        lines.append(f"  %row{lane} = getelementptr i8, ptr %at, i64 %l{lane}")
    if whole:
        lines.append("  br label %block\nblock:\n  %j = phi i64 [ 0, %entry ], [ %j.next, %block ]")
        lines += block("w", "%j", width, width)
        lines.append(
            f"  %j.next = add i64 %j, {width}\n  %more = icmp ult i64 %j.next, {whole}\n"
            "  br i1 %more, label %block, label %rest\nrest:"
        )
    if rest:
        lines += block("r", str(whole), rest, width)
    return "\n".join([*lines, "  ret void", "}", ""])


def _load_block(tag: str, j: str, columns: int, width: int) -> list[str]:
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
        lines.append(f"  %{tag}o{column} = add i64 {j}, {column}")
        lines.append(f"  %{tag}q{column} = getelementptr {v}, ptr %slots, i64 %{tag}o{column}")
        lines.append(f"  store {v} {names[column]}, ptr %{tag}q{column}, align {8 * width}")
    return lines


def _store_block(tag: str, j: str, columns: int, width: int) -> list[str]:
    v, lines = f"<{width} x double>", []
    for column in range(columns):
        lines.append(f"  %{tag}o{column} = add i64 {j}, {column}")
        lines.append(f"  %{tag}q{column} = getelementptr {v}, ptr %slots, i64 %{tag}o{column}")
        lines.append(f"  %{tag}in{column} = load {v}, ptr %{tag}q{column}, align {8 * width}")
    sources = [f"%{tag}in{column}" if column < columns else "zeroinitializer" for column in range(width)]
    names = _transpose(lines, tag, sources, width)
    for lane in range(width):
        lines.append(f"  %{tag}p{lane} = getelementptr double, ptr %row{lane}, i64 {j}")
        if columns == width:
            lines.append(f"  store {v} {names[lane]}, ptr %{tag}p{lane}, align 8")
        else:
            lines.append(
                f"  call void @llvm.masked.store.v{width}f64.p0({v} {names[lane]}, ptr %{tag}p{lane}, i32 8, "
                f"{_mask(columns, width)})"
            )
    return lines


def _mask(columns: int, width: int) -> str:
    return f"<{width} x i1> <" + ", ".join(f"i1 {int(k < columns)}" for k in range(width)) + ">"


def _transpose(lines: list[str], tag: str, rows: list[str], width: int) -> list[str]:
    """Transpose a square of registers with log2(width) rounds of two-operand shuffles that x86 has as one
    instruction.

    First neighbours are interleaved; then 128-bit lanes are gathered, the even ones of a pair and the odd
    ones.
    """
    v, count = f"<{width} x double>", 0

    def shuffle(x: str, y: str, picks: list[int]) -> str:
        nonlocal count
        count += 1
        name = f"%{tag}t{count}"
        mask = ", ".join(f"i32 {pick}" for pick in picks)
        lines.append(f"  {name} = shufflevector {v} {x}, {v} {y}, <{width} x i32> <{mask}>")
        return name

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
define internal void @columns_{way}(ptr %at, ptr %lanes, ptr %offsets, i64 %n, ptr %slots) #0 {{
entry:
  br label %loop
loop:
  %j = phi i64 [ 0, %entry ], [ %next, %loop ]
  %po = getelementptr i64, ptr %offsets, i64 %j
  %o = load i64, ptr %po, align 8
  %p = getelementptr i8, ptr %at, i64 %o
  %slot = getelementptr {v}, ptr %slots, i64 %j
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
define internal void @strided_{way}(ptr %at, ptr %lanes, ptr %offsets, i64 %n, ptr %slots) #0 {{
entry:
  br label %scalar
scalar:
  %j = phi i64 [ 0, %entry ], [ %j.next, %scalar.end ]
  %po = getelementptr i64, ptr %offsets, i64 %j
  %o = load i64, ptr %po, align 8
  %pj = getelementptr i8, ptr %at, i64 %o
  %slot = getelementptr <{width} x double>, ptr %slots, i64 %j
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
    return (
        f"declare {v} @llvm.masked.load.v{width}f64.p0(ptr, i32, <{width} x i1>, {v})\n"
        f"declare void @llvm.masked.store.v{width}f64.p0({v}, ptr, i32, <{width} x i1>)\n"
    )
