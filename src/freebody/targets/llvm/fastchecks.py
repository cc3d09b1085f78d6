"""LLVM text of the checks of a kernel's call: quaternions among the inputs, and all outputs."""

from __future__ import annotations

import struct

from freebody.program.program import Argument
from freebody.targets.finite_check import UNIT
from freebody.targets.llvm.lanes import DOUBLE, Real, loaded

_COUNT = 16  # offset in PyBytesObject of its length
BYTES = 32
"""Offset of the bytes in PyBytesObject."""

PAIR = "qq"
"""The form in bytes of a place of unit length: an input, and the entry of it where its four numbers
begin."""


def are_unit(real: Real) -> str:
    """LLVM text of a function whether four entries have unit length (NaN has not), for each pair in
    `units` (argument, first entry) in each of `count` samples."""
    widened = "" if real is DOUBLE else "w"
    lines = [
        "define internal i1 @fast.unit(ptr %units, ptr %data, ptr %steps, i64 %count) {",
        "entry:",
        loaded("%bytes", "i64", "%units", _COUNT, of="i8"),
        f"  %first = getelementptr i8, ptr %units, i64 {BYTES}",
        "  %end = getelementptr i8, ptr %first, i64 %bytes",
        "  br label %more",
        "more:",
        "  %pair = phi ptr [%first, %entry], [%next, %sample]",
        "  %is.end = icmp eq ptr %pair, %end",
        "  br i1 %is.end, label %good, label %one",
        "one:",
        f"  %next = getelementptr i8, ptr %pair, i64 {struct.calcsize(PAIR)}",
        "  %argument = load i64, ptr %pair, align 8",
        loaded("%offset", "i64", "%pair", 1),
        loaded("%array.first", "ptr", "%data", "%argument"),
        loaded("%step", "i64", "%steps", "%argument"),
        "  br label %sample",
        "sample:",
        "  %array = phi ptr [%array.first, %one], [%array.next, %another]",
        "  %left = phi i64 [%count, %one], [%fewer, %another]",
        "  %is.over = icmp eq i64 %left, 0",
        "  br i1 %is.over, label %more, label %another",
        "another:",
        "  %array.next = getelementptr i8, ptr %array, i64 %step",
        "  %fewer = sub i64 %left, 1",
    ]
    for k in range(4):
        lines += [
            f"  %at{k} = getelementptr {real.name}, ptr %array, i64 %offset",
            loaded(f"%{widened}x{k}", real.name, f"%at{k}", k, align=real.size),
            *([f"  %x{k} = fpext {real.name} %wx{k} to double"] if widened else []),
            f"  %xx{k} = fmul double %x{k}, %x{k}",
            *([f"  %sum{k} = fadd double %{'sum' if k > 1 else 'xx'}{k - 1}, %xx{k}"] if k else []),
        ]
    return "\n".join(
        [
            *lines,
            f"  %off = fsub double %sum3, {DOUBLE.constant(1.0)}",
            f"  %below = fcmp olt double %off, {DOUBLE.constant(UNIT)}",
            f"  %above = fcmp ogt double %off, {DOUBLE.constant(-UNIT)}",
            "  %close = and i1 %below, %above",
            "  br i1 %close, label %sample, label %bad",
            "good:",
            "  ret i1 true",
            "bad:",
            "  ret i1 false",
            "}",
        ]
    )


_TOGETHER = 8  # entries that are looked at in one step


def finite(real: Real) -> str:
    """LLVM text of a function whether all entries are finite: eight at a time, then the rest."""
    exponent = {64: 0x7FF << 52, 32: 0xFF << 23}[real.bits]
    block = f"<{_TOGETHER} x {real.integer}>"
    mask = "<" + ", ".join([f"{real.integer} {exponent}"] * _TOGETHER) + ">"
    return f"""\
define internal i1 @fast.finite(ptr %values, i64 %count) {{
entry:
  %whole = and i64 %count, -{_TOGETHER}
  br label %blocks
blocks:
  %k = phi i64 [0, %entry], [%next, %block]
  %wrong = phi <{_TOGETHER} x i1> [zeroinitializer, %entry], [%wronger, %block]
  %in.blocks = icmp ult i64 %k, %whole
  br i1 %in.blocks, label %block, label %rest
block:
  %at = getelementptr {real.integer}, ptr %values, i64 %k
  %bits = load {block}, ptr %at, align {real.size}
  %exponents = and {block} %bits, {mask}
  %these = icmp eq {block} %exponents, {mask}
  %wronger = or <{_TOGETHER} x i1> %wrong, %these
  %next = add i64 %k, {_TOGETHER}
  br label %blocks
rest:
  %flags = bitcast <{_TOGETHER} x i1> %wrong to i{_TOGETHER}
  %blocks.fine = icmp eq i{_TOGETHER} %flags, 0
  br label %left
left:
  %j = phi i64 [%whole, %rest], [%j.next, %one]
  %fine = phi i1 [%blocks.fine, %rest], [%both, %one]
  %is.left = icmp ult i64 %j, %count
  br i1 %is.left, label %one, label %done
one:
  %one.at = getelementptr {real.integer}, ptr %values, i64 %j
  %one.bits = load {real.integer}, ptr %one.at, align {real.size}
  %one.exponent = and {real.integer} %one.bits, {exponent}
  %one.fine = icmp ne {real.integer} %one.exponent, {exponent}
  %both = and i1 %fine, %one.fine
  %j.next = add i64 %j, 1
  br label %left
done:
  ret i1 %fine
}}"""


def checked(outputs: tuple[Argument, ...]) -> list[str]:
    """Lines that check, where a call asks for it, that all entries of the outputs are finite, and
    otherwise release the outputs and take the general way."""
    lines = [
        "  br i1 %checked, label %check, label %good",
        "check:",
    ]
    fine = "true"
    for k, argument in enumerate(outputs):
        lines += [
            f"  %entries{k} = mul i64 %count, {argument.size}",
            f"  %finite{k} = call i1 @fast.finite(ptr %out.data{k}, i64 %entries{k})",
            f"  %fine{k} = and i1 {fine}, %finite{k}",
        ]
        fine = f"%fine{k}"
    return [
        *lines,
        f"  br i1 {fine}, label %good, label %bad",
        "bad:",
        *(
            line
            for k, argument in enumerate(outputs)
            for line in (
                [f"  call void @Py_DecRef(ptr %out{k})"]
                if argument.shape
                else [
                    f"  %gone{k} = load ptr, ptr %row{k}, align 8",
                    f"  call void @Py_DecRef(ptr %gone{k})",
                ]
            )
        ),
        "  br label %general",
        "good:",
    ]
