"""LLVM text of the gufunc loop: groups of samples in, `@compute` on a tile of slots, groups out.

A tile holds one vector of lanes for each slot: lane l of slot j is scalar j of sample l. Three ways lead from an array
to the tile and back, chosen for each argument when the loop begins:

- rows: the scalars of a sample are contiguous. Vectors are loaded along the rows and transposed in registers; a mask
  keeps the last block of columns inside the row, so that nothing outside the array is touched.
- columns: samples are contiguous, so each scalar is one vector load.
- strided: anything else, one double at a time.

The last group may be short. Its surplus lanes take the addresses of its last sample, on the way in and on the way
out: the same code runs, the same bits come out, and the last row is written more than once with the same values.
"""

from __future__ import annotations

from freebody.compiler.program import Argument, Program
from freebody.compiler.target import Target


def gufunc_loop(program: Program, target: Target, slots: int) -> str:
    """`void @kernel(ptr args, ptr dims, ptr steps, ptr data)` and what it calls, for a program and its tile."""
    width = target.width
    sizes_in = sorted({argument.size for argument in program.inputs})
    sizes_out = sorted({argument.size for argument in program.outputs})
    parts = [_rows_in(size, width) for size in sizes_in] + [_rows_out(size, width) for size in sizes_out]
    parts += [_columns("in", width), _columns("out", width), _strided("in", width), _strided("out", width)]
    return "\n".join([*parts, _loop(program, target, slots), _declarations(width), _FLAGS[target.x86]["declare"]])


# NumPy turns floating-point flags into warnings; NaN in, NaN out is no reason to warn, and surplus lanes set them too
_FLAGS = {
    True: {
        "save": "  %flags = alloca i32, align 4\n  call void @llvm.x86.sse.stmxcsr(ptr %flags)",
        "restore": "  call void @llvm.x86.sse.ldmxcsr(ptr %flags)",
        "declare": "declare void @llvm.x86.sse.stmxcsr(ptr)\ndeclare void @llvm.x86.sse.ldmxcsr(ptr)\n",
    },
    False: {
        "save": "",
        "restore": "  %cleared = call i32 @feclearexcept(i32 31)",
        "declare": "declare i32 @feclearexcept(i32)\n",
    },
}


def _loop(program: Program, target: Target, slots: int) -> str:
    width = target.width
    arguments = program.inputs + program.outputs
    total = sum(argument.size for argument in arguments)
    lines = [f"""\
define void @kernel(ptr %args, ptr %dims, ptr %steps, ptr %data) #0 {{
entry:
  %tile = alloca [{slots} x <{width} x double>], align {8 * width}
  %lanes = alloca [{len(arguments) * width} x i64], align 16
  %offsets = alloca [{total} x i64], align 16
  %n = load i64, ptr %dims, align 8"""]
    lines.append(_FLAGS[target.x86]["save"])
    core, first = len(arguments), 0
    for k, argument in enumerate(arguments):
        lines += _prepare(k, argument, core, first, width)
        core += len(argument.shape)
        first += argument.size
    lines.append(f"""\
  br label %head
head:
  %i = phi i64 [ 0, %entry ], [ %i.next, %tail ]
  %more = icmp slt i64 %i, %n
  br i1 %more, label %group, label %end
group:
  %rest = sub i64 %n, %i
  %full = icmp sge i64 %rest, {width}
  %last = sub i64 %rest, 1
  br i1 %full, label %begin, label %short
short:""")
    lines += [line for k in range(len(arguments)) for line in _lanes(k, width, short=True)]
    lines.append("  br label %begin\nbegin:")
    for k in range(len(arguments)):
        lines.append(f"  %move{k} = mul i64 %i, %step{k}\n  %at{k} = getelementptr i8, ptr %base{k}, i64 %move{k}")
    slot = first = 0
    for k, argument in enumerate(arguments):
        if k == len(program.inputs):
            lines.append("  call void @compute(ptr %tile)")
        lines += _transfer(k, argument, slot, first, width, "in" if k < len(program.inputs) else "out")
        slot += argument.size
        first += argument.size
    lines.append(f"  br label %tail\ntail:\n  %i.next = add i64 %i, {width}\n  br label %head\nend:")
    return "\n".join([*lines, _FLAGS[target.x86]["restore"], "  ret void", "}", ""])


def _prepare(k: int, argument: Argument, core: int, first: int, width: int) -> list[str]:
    """Base, step, way of access, addresses of the scalars and lanes of argument k."""
    lines = [
        f"  %pbase{k} = getelementptr ptr, ptr %args, i64 {k}",
        f"  %base{k} = load ptr, ptr %pbase{k}, align 8",
        f"  %pstep{k} = getelementptr i64, ptr %steps, i64 {k}",
        f"  %step{k} = load i64, ptr %pstep{k}, align 8",
        f"  %columns{k} = icmp eq i64 %step{k}, 8",
    ]
    rows, natural = "true", 8
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
    lines.append(f"  %rows{k} = and i1 {rows}, true")
    lines += _lanes(k, width, short=False)
    for j, index in enumerate(_indices(argument.shape)):
        offset = "0"
        for d, position in enumerate(index):
            lines.append(f"  %o{k}.{j}.{d}m = mul i64 %core{k}.{d}, {position}")
            lines.append(f"  %o{k}.{j}.{d} = add i64 {offset}, %o{k}.{j}.{d}m")
            offset = f"%o{k}.{j}.{d}"
        lines.append(f"  %po{k}.{j} = getelementptr i64, ptr %offsets, i64 {first + j}")
        lines.append(f"  store i64 {offset}, ptr %po{k}.{j}, align 8")
    return lines


def _indices(shape: tuple[int, ...]) -> list[tuple[int, ...]]:
    indices: list[tuple[int, ...]] = [()]
    for size in shape:
        indices = [(*index, i) for index in indices for i in range(size)]
    return indices


def _lanes(k: int, width: int, short: bool) -> list[str]:
    """Fill the table of lane addresses of argument k; in a short group lanes beyond the last sample repeat it."""
    lines, tag = [], f"{k}.{'s' if short else 'f'}"
    for lane in range(width):
        number = str(lane)
        if short:
            number = f"%n{tag}{lane}"
            lines.append(f"  %b{tag}{lane} = icmp slt i64 {lane}, %last")
            lines.append(f"  {number} = select i1 %b{tag}{lane}, i64 {lane}, i64 %last")
        lines.append(f"  %l{tag}{lane} = mul i64 %step{k}, {number}")
        lines.append(f"  %pl{tag}{lane} = getelementptr i64, ptr %lanes, i64 {k * width + lane}")
        lines.append(f"  store i64 %l{tag}{lane}, ptr %pl{tag}{lane}, align 8")
    return lines


def _transfer(k: int, argument: Argument, slot: int, first: int, width: int, way: str) -> list[str]:
    """Move one group of argument k between array and tile."""
    lines = [
        f"  %slot{k} = getelementptr <{width} x double>, ptr %tile, i64 {slot}",
        f"  %lane{k} = getelementptr i64, ptr %lanes, i64 {k * width}",
        f"  %offset{k} = getelementptr i64, ptr %offsets, i64 {first}",
    ]
    if way == "in":  # a broadcast input stays in the tile after the first group
        lines += [
            f"  %moves{k} = icmp ne i64 %step{k}, 0",
            f"  %first{k} = icmp eq i64 %i, 0",
            f"  %needed{k} = or i1 %moves{k}, %first{k}",
            f"  br i1 %needed{k}, label %load{k}, label %after{k}",
            f"load{k}:",
        ]
    call = f"ptr %at{k}, ptr %lane{k}, ptr %offset{k}, i64 {argument.size}, ptr %slot{k}"
    return [
        *lines,
        f"  %streams{k} = and i1 %full, %columns{k}",
        f"  br i1 %streams{k}, label %columns.{k}, label %other{k}",
        f"columns.{k}:",
        f"  call void @columns_{way}({call})",
        f"  br label %after{k}",
        f"other{k}:",
        f"  br i1 %rows{k}, label %rows.{k}, label %strided{k}",
        f"rows.{k}:",
        f"  call void @rows_{way}_{argument.size}(ptr %at{k}, ptr %lane{k}, ptr %slot{k})",
        f"  br label %after{k}",
        f"strided{k}:",
        f"  call void @strided_{way}({call})",
        f"  br label %after{k}",
        f"after{k}:",
    ]


def _rows_in(size: int, width: int) -> str:
    """Rows of `size` doubles to slots: a loop over whole blocks of `width` columns, then the masked rest."""
    return _rows("in", size, width, _load_block)


def _rows_out(size: int, width: int) -> str:
    return _rows("out", size, width, _store_block)


def _rows(way: str, size: int, width: int, block) -> str:  # type: ignore[no-untyped-def]
    whole, rest = size - size % width, size % width
    lines = [f"define internal void @rows_{way}_{size}(ptr noalias %at, ptr noalias %lanes, ptr noalias %slots) #0 {{", "entry:"]
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
    """Transpose a square of registers with log2(width) rounds of two-operand shuffles that x86 has as one instruction.

    First neighbours are interleaved; then 128-bit lanes are gathered, the even ones of a pair and the odd ones.
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
define internal void @columns_{way}(ptr noalias %at, ptr noalias %lanes, ptr noalias %offsets, i64 %n, ptr noalias %slots) #0 {{
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
define internal void @strided_{way}(ptr noalias %at, ptr noalias %lanes, ptr noalias %offsets, i64 %n, ptr noalias %slots) #0 {{
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


def _declarations(width: int) -> str:
    v = f"<{width} x double>"
    return (
        f"declare {v} @llvm.masked.load.v{width}f64.p0(ptr, i32, <{width} x i1>, {v})\n"
        f"declare void @llvm.masked.store.v{width}f64.p0({v}, ptr, i32, <{width} x i1>)\n"
    )
