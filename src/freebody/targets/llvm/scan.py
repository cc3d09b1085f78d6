"""Consecutive steps in compiled code: a recurrence of one sample number by number, since a kernel's
loop takes longer to begin a step than to compute it; and a kernel's loop called for each step."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from math import nan
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from freebody.program.passes import optimise
from freebody.program.program import Program
from freebody.targets.kernel import BatchLoop, Kernel
from freebody.targets.llvm import cache as disk
from freebody.targets.llvm.cpu import compiler_version
from freebody.targets.llvm.emit import emit_single
from freebody.targets.llvm.lanes import REALS, Real, loaded, stored
from freebody.targets.llvm.loader import load
from freebody.targets.llvm.loop import FLAGS
from freebody.targets.llvm.machine import Machine, at_level, object_code
from freebody.targets.llvm.shared_functions import declared_once, definitions

Scan = Callable[..., None]

_CHUNKS = (8, 4, 2, 1)
"""Numbers that are moved at once."""

_scans: WeakKeyDictionary[Kernel, Scan] = WeakKeyDictionary()


def scan(kernel: Kernel) -> Scan:
    """A function of (states (T + 1, …), *sequences (T, …)), with contiguous entries, that fills in
    all states after the first as repeated calls of a kernel without uniform inputs would. The GIL
    is released."""
    found = _scans.get(kernel)
    if found is None:
        found = _scans[kernel] = _compiled(kernel)
    return found


def _compiled(kernel: Kernel) -> Scan:
    here, program = at_level(kernel.target.partition(":")[2] or None), kernel.program
    machine = here.machine(1, REALS[kernel.dtype.name])
    key = disk.key("scan", program.digest, here, machine, compiler_version())
    code = disk.load(key)
    if code is None:
        code = object_code(_text(optimise(program), machine), here=here)
        disk.store(key, code)
    loaded, addresses = load([code], ("scan",), {})
    function = _PROTOTYPE(addresses["scan"])

    def scanned(states: np.ndarray, *sequences: np.ndarray, _: Any = loaded) -> None:
        arrays = (states, *sequences)
        numbers = ctypes.c_int64 * len(arrays)
        places, moves = ([x.ctypes.data for x in arrays], [x.strides[0] for x in arrays])
        function(numbers(*places), numbers(*moves), len(states) - 1)

    return scanned


_PROTOTYPE = ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64)


def _text(program: Program, machine: Machine) -> str:
    """LLVM text of `void @scan(ptr addresses, ptr moves, i64 times)`, with addresses and strides of
    the states and the sequences."""
    pieces, text, layout = emit_single(program, machine)
    real, flags, begin, step = machine.real, FLAGS[machine.x86], [], []
    for k in range(len(program.inputs)):
        begin += [
            loaded(f"%start{k}", "ptr", "%addresses", k),
            loaded(f"%move{k}", "i64", "%moves", k),
        ]
        step.append(f"  %at{k} = phi ptr [ %start{k}, %entry ], [ %next{k}, %step ]")
    for k in range(program.inputs[0].size):
        begin += [
            loaded(f"%first{k}", real.name, "%start0", k, align=real.size),
        ]
        step.append(f"  %state{k} = phi {real.name} [ %first{k}, %entry ], [ %x{k}, %step ]")
    step += [
        f"  %next{k} = getelementptr i8, ptr %at{k}, i64 %move{k}"
        for k in range(len(program.inputs))
    ]
    doubt = _inputs(step, program, real)
    step += [f"  call void {piece}(ptr %tile, ptr null)" for piece in pieces]
    for k, node in enumerate(program.results):
        step += [
            loaded(f"%found{k}", real.name, "%tile", layout.results[node], align=real.size),
            f"  %x{k} = select i1 {doubt}, {real.name} {real.constant(nan)}, {real.name} %found{k}",
            stored(f"%to{k}", real.name, f"%x{k}", "%next0", k, align=real.size),
        ]
    lines = [
        text,
        definitions(text, machine),
        flags["declare"],
        "define void @scan(ptr %addresses, ptr %moves, i64 %times) #1 {\nentry:",
        f"  %tile = alloca [{layout.slots} x {real.name}], align 64",
        flags["save"],
        *begin,
        "  br label %step\nstep:",
        "  %left = phi i64 [ %times, %entry ], [ %left.next, %step ]",
        *step,
        "  %left.next = sub i64 %left, 1",
        "  %more = icmp sgt i64 %left.next, 0",
        "  br i1 %more, label %step, label %end\nend:",
        flags["restore"],
        "  ret void\n}\n",
    ]
    return declared_once("\n".join(lines))


def _inputs(lines: list[str], program: Program, real: Real) -> str:
    """The name of the finiteness check, after lines that bring inputs to the tile: the state number
    by number, others by vectors, the last of which may overlap the one before it. 0 times a number
    that is not finite is NaN."""
    seen: dict[int, str] = {}
    place = 0
    for k, argument in enumerate(program.inputs):
        width = max(w for w in _CHUNKS if w <= argument.size) if k else 1
        v, last = f"<{width} x {real.name}>", argument.size - width
        for start in [*range(0, last, width), last]:
            name = f"%in{k}.{start}"
            if k:
                lines.append(loaded(name, v, f"%at{k}", start, of=real.name, align=real.size))
            else:
                lines.append(f"  {name} = bitcast {real.name} %state{start} to {v}")
            lines += [
                stored(f"{name}.q", v, name, "%tile", place + start, of=real.name, align=real.size),
                f"  {name}.m = fmul contract {v} {name}, zeroinitializer",
                f"  {name}.s = fadd contract {v} {name}.m, {seen.get(width, 'zeroinitializer')}",
            ]
            seen[width] = f"{name}.s"
        place += argument.size
    doubt = "false"
    for width, total in seen.items():
        lines += [
            f"  %nan{width} = fcmp uno <{width} x {real.name}> {total}, zeroinitializer",
            f"  %bits{width} = bitcast <{width} x i1> %nan{width} to i{width}",
            f"  %some{width} = icmp ne i{width} %bits{width}, 0",
            f"  %doubt{width} = or i1 {doubt}, %some{width}",
        ]
        doubt = f"%doubt{width}"
    return doubt


_TEXT = """
define void @repeat(ptr %loop, ptr %samples, i64 %times, ptr %addresses, i64 %wide,
                    ptr %strides, i64 %far) {
entry:
  br label %step
step:
  %k = phi i64 [ 0, %entry ], [ %k.next, %run ]
  %args = phi ptr [ %addresses, %entry ], [ %args.next, %run ]
  %steps = phi ptr [ %strides, %entry ], [ %steps.next, %run ]
  %more = icmp slt i64 %k, %times
  br i1 %more, label %run, label %end
run:
  call void %loop(ptr %args, ptr %samples, ptr %steps, ptr null)
  %k.next = add i64 %k, 1
  %args.next = getelementptr ptr, ptr %args, i64 %wide
  %steps.next = getelementptr i64, ptr %steps, i64 %far
  br label %step
end:
  ret void
}
"""


def repeated(
    loop: BatchLoop, samples: int, addresses: NDArray[np.int64], strides: NDArray[np.int64]
) -> None:
    """Call the loop of a kernel once for each row of `addresses` (of its arguments) and `strides`
    (between their samples, then between their entries), as of a gufunc; both (T, …) in C order,
    constant strides (1, …). The GIL is released."""
    _code, run = _repeat()  # kept while it runs: two threads may have made one each
    run(
        loop.address,
        ctypes.byref(ctypes.c_int64(samples)),
        len(addresses),
        addresses.ctypes.data,
        addresses.shape[1],
        strides.ctypes.data,
        strides.shape[1] if len(strides) > 1 else 0,
    )


@cache
def _repeat() -> tuple[Any, Any]:
    """The compiled repeating loop, as (the object that keeps the code alive, the C function)."""
    code, found = load([object_code(_TEXT)], ("repeat",), {})
    pointer, number = ctypes.c_void_p, ctypes.c_int64
    prototype = ctypes.CFUNCTYPE(None, pointer, pointer, number, pointer, number, pointer, number)
    return code, prototype(found["repeat"])
