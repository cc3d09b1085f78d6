"""LLVM text that reads uniform inputs, one array after the other, to where kernels look for them.

They are looked at once a call: one more number, behind them and what is computed of them, is 0, or
NaN where one of them is not finite.
"""

from __future__ import annotations

from math import nan

from freebody.program.program import Program
from freebody.targets.llvm.lanes import Lanes, loaded


def gather(lanes: Lanes) -> str:
    """`@gather`, which copies one array: rows as they stand by vectors, the last of which may
    overlap the one before it, anything else by its offsets, number by number."""
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
    """`@uniform.finite`, which looks at all of them: 0 times each number, added up, is NaN if one
    is not finite.

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
    """`@kernel`: `@loop` on the whole batch; on one sample after the other where a uniform argument
    moves after all."""
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
