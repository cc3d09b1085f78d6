"""LLVM text that moves numbers between arrays and the tiles on which code computes.

A group of samples goes between an array and the tile in three ways:

- rows: the scalars of a sample are contiguous. Vectors are loaded along the rows and transposed in
  registers; a mask keeps the last block of columns inside the row, so that nothing outside the
  array is touched.
- columns: samples are contiguous, so each scalar is one vector load.
- strided: anything else, one number at a time.

The address of scalar j of the sample in lane l is `at + offsets[j] + lanes[l]`, in bytes.

What brings an input in looks at its numbers too: it leaves a vector in a slot of the argument's own
that is finite only if all of them are (see `emit`).

Uniform inputs are read one array after the other, and looked at once a call: one more number,
behind them and what is computed of them, is 0, or NaN where one of them is not finite.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import nan

from freebody.program.program import Program
from freebody.program.segments import SegmentedProgram
from freebody.targets.llvm.lanes import Lanes, loaded
from freebody.targets.llvm.rows import masked_loads, rows_in, rows_out


def transfers(program: Program, every: Program, layout: SegmentedProgram, lanes: Lanes) -> str:
    """LLVM text of `@places0`, `@rows0`, … for each argument that is not uniform.

    program: whose arguments are numbered. every: what is computed on a tile of `layout`.
    """
    places: dict[int, list[int]] = {}
    first, checks = 0, check_slots(program, layout)
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
        parts.append(
            rows_in(k, those, checks[k], lanes) if k in checks else rows_out(k, those, lanes)
        )
    return "\n".join([*parts, masked_loads(lanes)])


def check_slots(program: Program, layout: SegmentedProgram) -> dict[int, int]:
    """For each input that is not uniform the slot, behind those of the layout, for the result of
    its finiteness check."""
    sampled = [k for k, argument in enumerate(program.inputs) if not argument.uniform]
    return {k: layout.slots + place for place, k in enumerate(sampled)}


def integers(numbers: Sequence[int]) -> str:
    """LLVM text of a constant array of integers."""
    return f"[{len(numbers)} x i64] [{', '.join(f'i64 {n}' for n in numbers)}]"


def transfer_functions(lanes: Lanes) -> dict[str, str]:
    """LLVM text of the functions `@columns_in`, `@strided_out`, … and `@offsets`, which serve every
    argument."""
    moves = {"columns": _columns, "strided": _strided}
    texts = {f"{name}_{way}": moves[name](way, lanes) for name in moves for way in ("in", "out")}
    return texts | {"offsets": _OFFSETS}


_MOVED = "ptr %at, ptr %lanes, ptr %tile, ptr %check, ptr %places, ptr %offsets, i64 %n"


def _columns(way: str, lanes: Lanes) -> str:
    """LLVM text that moves slots from (or to) places where samples are contiguous."""
    v = lanes.v
    source, target = ("%p", "%slot") if way == "in" else ("%slot", "%p")
    align = {"%p": lanes.real.size, "%slot": lanes.size}
    begin, look, keep = (
        ("", "", "")
        if way == "out"
        else (
            f"  %seen = phi {v} [ zeroinitializer, %entry ], [ %seen.next, %loop ]\n",
            f"  %nothing = fmul contract {v} %x, zeroinitializer\n  %seen.next = fadd contract {v} "
            f"%seen, %nothing\n",
            f"  store {v} %seen.next, ptr %check, align {lanes.size}\n",
        )
    )
    return f"""\
define internal void @columns_{way}({_MOVED}) #0 {{
entry:
  br label %loop
loop:
  %j = phi i64 [ 0, %entry ], [ %next, %loop ]
{begin}  %po = getelementptr i64, ptr %offsets, i64 %j
  %o = load i64, ptr %po, align 8
  %p = getelementptr i8, ptr %at, i64 %o
  %place.at = getelementptr i64, ptr %places, i64 %j
  %place = load i64, ptr %place.at, align 8
  %slot = getelementptr {v}, ptr %tile, i64 %place
  %x = load {v}, ptr {source}, align {align[source]}
  store {v} %x, ptr {target}, align {align[target]}
{look}  %next = add i64 %j, 1
  %more = icmp ult i64 %next, %n
  br i1 %more, label %loop, label %end
end:
{keep}  ret void
}}
"""


def _strided(way: str, lanes: Lanes) -> str:
    """LLVM text that moves slots from (or to) arbitrary places, one number at a time, without a
    finiteness check."""
    kind, align = lanes.real.name, lanes.real.size
    source, target = ("%p", "%q") if way == "in" else ("%q", "%p")
    unseen = (
        f"  store {lanes.v} {lanes.constant(nan)}, ptr %check, align {lanes.size}\n"
        if way == "in"
        else ""
    )
    return f"""\
define internal void @strided_{way}({_MOVED}) #0 {{
entry:
{unseen}  br label %scalar
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


def gather(lanes: Lanes) -> str:
    """LLVM text of `@gather`, which copies one array: contiguous rows by vectors, the last of which
    may overlap the one before it; other arrays number by number by their offsets."""
    kind, v, size, width = lanes.real.name, lanes.v, lanes.real.size, lanes.width
    given = "ptr %at, i1 %rows, ptr %strides, ptr %shape, i64 %d, i64 %n"
    return f"""\
define internal void @gather({given}, ptr %offsets, ptr %to) #0 {{
entry:
  br i1 %rows, label %straight, label %scattered
straight:
  %last = sub i64 %n, {width}
  %few = icmp ult i64 %n, {width}
  br i1 %few, label %rest, label %blocks
blocks:
  %j = phi i64 [ 0, %straight ], [ %j.next, %block ]
  %more = icmp ult i64 %j, %last
  br i1 %more, label %block, label %end
block:
  %from = getelementptr {kind}, ptr %at, i64 %j
  %some = load {v}, ptr %from, align {size}
  %into = getelementptr {kind}, ptr %to, i64 %j
  store {v} %some, ptr %into, align {size}
  %j.next = add i64 %j, {width}
  br label %blocks
end:
  %from.end = getelementptr {kind}, ptr %at, i64 %last
  %some.end = load {v}, ptr %from.end, align {size}
  %into.end = getelementptr {kind}, ptr %to, i64 %last
  store {v} %some.end, ptr %into.end, align {size}
  br label %done
rest:
  %k = phi i64 [ 0, %straight ], [ %k.next, %single ]
  %left = icmp ult i64 %k, %n
  br i1 %left, label %single, label %done
single:
  %from.k = getelementptr {kind}, ptr %at, i64 %k
  %x.k = load {kind}, ptr %from.k, align {size}
  %into.k = getelementptr {kind}, ptr %to, i64 %k
  store {kind} %x.k, ptr %into.k, align {size}
  %k.next = add i64 %k, 1
  br label %rest
scattered:
  call void @offsets(ptr %strides, ptr %shape, i64 %d, i64 %n, ptr %offsets)
  br label %scalars
scalars:
  %l = phi i64 [ 0, %scattered ], [ %l.next, %scalar ]
  %further = icmp ult i64 %l, %n
  br i1 %further, label %scalar, label %done
scalar:
  %offset.at = getelementptr i64, ptr %offsets, i64 %l
  %offset = load i64, ptr %offset.at, align 8
  %from.l = getelementptr i8, ptr %at, i64 %offset
  %x.l = load {kind}, ptr %from.l, align {size}
  %into.l = getelementptr {kind}, ptr %to, i64 %l
  store {kind} %x.l, ptr %into.l, align {size}
  %l.next = add i64 %l, 1
  br label %scalars
done:
  ret void
}}
"""


def finite(inputs: int, poison: int, lanes: Lanes) -> str:
    """LLVM text of `@uniform.finite`, which checks all uniform numbers: the sum of 0 times each is
    NaN if one is not finite.

    Parameters
    ----------
    inputs
        How many numbers there are.
    poison
        Place of the further one.
    lanes
        Vectors in which they are read.
    """
    kind, size, width = lanes.real.name, lanes.real.size, lanes.width
    vectors = inputs >= width  # the last of which may overlap the one before it
    v, zero = (lanes.v, "zeroinitializer") if vectors else (kind, "0.0")
    step = width if vectors else 1
    return f"""\
define internal void @uniform.finite(ptr %values) #0 {{
entry:
  %end = getelementptr {kind}, ptr %values, i64 {inputs - step}
  %last = load {v}, ptr %end, align {size}
  %nothing.last = fmul contract {v} %last, {zero}
  br label %head
head:
  %j = phi i64 [ 0, %entry ], [ %j.next, %block ]
  %sum = phi {v} [ %nothing.last, %entry ], [ %sum.next, %block ]
  %more = icmp slt i64 %j, {inputs - step}
  br i1 %more, label %block, label %done
block:
  %from = getelementptr {kind}, ptr %values, i64 %j
  %some = load {v}, ptr %from, align {size}
  %nothing = fmul contract {v} %some, {zero}
  %sum.next = fadd contract {v} %sum, %nothing
  %j.next = add i64 %j, {step}
  br label %head
done:
  %bad = fcmp uno {v} %sum, {zero}
  {f"%bits = bitcast {lanes.mask} %bad to i{width}" if vectors else ""}
  {f"%any = icmp ne i{width} %bits, 0" if vectors else "%any = and i1 %bad, true"}
  %found = select i1 %any, {kind} {lanes.real.constant(nan)}, {kind} 0.0
  %poison = getelementptr {kind}, ptr %values, i64 {poison}
  store {kind} %found, ptr %poison, align {size}
  ret void
}}
"""


def one_by_one(program: Program) -> str:
    """LLVM text of `@kernel`, which runs `@loop` on the whole batch, or sample by sample where a
    uniform argument turns out to vary."""
    count = len(program.inputs) + len(program.outputs)
    lines = [
        "define void @kernel(ptr %args, ptr %dims, ptr %steps, ptr %data) #0 {",
        "entry:",
        f"  %own = alloca [{count} x ptr], align 8",
        "  %one = alloca i64, align 8",
        "  %n = load i64, ptr %dims, align 8",
        "  %several = icmp sgt i64 %n, 1",
    ]
    moves = "false"
    for k, argument in enumerate(program.inputs):
        if argument.uniform:
            lines += [
                loaded(f"%step{k}", "i64", "%steps", k),
                f"  %other{k} = icmp ne i64 %step{k}, 0",
                f"  %moves{k} = or i1 {moves}, %other{k}",
            ]
            moves = f"%moves{k}"
    lines.append(f"""\
  %apart = and i1 %several, {moves}
  br i1 %apart, label %begin, label %together
together:
  call void @loop(ptr %args, ptr %dims, ptr %steps, ptr %data)
  ret void
begin:
  store i64 1, ptr %one, align 8
  br label %sample
sample:
  %i = phi i64 [ 0, %begin ], [ %i.next, %run ]
  br label %argument
argument:
  %k = phi i64 [ 0, %sample ], [ %k.next, %argument ]
  %base.at = getelementptr ptr, ptr %args, i64 %k
  %base = load ptr, ptr %base.at, align 8
  %step.at = getelementptr i64, ptr %steps, i64 %k
  %step = load i64, ptr %step.at, align 8
  %skip = mul i64 %i, %step
  %at = getelementptr i8, ptr %base, i64 %skip
  %own.at = getelementptr ptr, ptr %own, i64 %k
  store ptr %at, ptr %own.at, align 8
  %k.next = add i64 %k, 1
  %more = icmp ult i64 %k.next, {count}
  br i1 %more, label %argument, label %run
run:
  call void @loop(ptr %own, ptr %one, ptr %steps, ptr %data)
  %i.next = add i64 %i, 1
  %again = icmp slt i64 %i.next, %n
  br i1 %again, label %sample, label %end
end:
  ret void
}}
""")
    return "\n".join(lines)
