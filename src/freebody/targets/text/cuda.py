"""Programs as PTX for NVIDIA's GPUs: a module of entries with one thread for each sample, loaded by
the driver alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from freebody.identifiers import word_set
from freebody.program.program import Argument, Program
from freebody.targets.cuda.emit import emit
from freebody.targets.cuda.parts import ProgramPart, parts, prepared
from freebody.targets.cuda.plan import ptx
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    SourceUnit,
    comment_block,
    largest_entries,
    number_lists,
    numbered,
)
from freebody.targets.text.statements import ProgramWords, words_of

RESERVED = word_set("WARP_SZ reduce two_over_pi") | numbered("sincos", "vector")

_USE = """\
Load this text with cuModuleLoadData (it needs an NVIDIA driver from 2017 on, and a GPU from Volta
on), and start {started} with a grid of any block size that has at least n threads: thread i takes
sample i. Each entry takes {count} 64-bit values: for each argument in the order above, inputs and
then outputs,
  its address on the device, to numbers of type {type},
  how many numbers the samples are apart (0: one value for all samples),
  how many numbers the entries of one sample are apart (1: rows; n: columns, which GPUs read best),
matrices being stored row by row; then n, the number of samples. Outputs may overlap nothing.
A sample with an input that is NaN or infinite has NaN in all outputs; no other sample is touched.
"""


def _sampled(unit: SourceUnit) -> Program:
    """The program without uniform inputs, since an input that is the same for all samples has step
    0."""
    inputs = tuple(replace(x, uniform=False) for x in unit.program.inputs)
    return prepared(replace(unit.program, inputs=inputs))


def _words(unit: SourceUnit) -> ProgramWords:
    return words_of(unit, RESERVED)


def _entries(unit: SourceUnit) -> dict[str, ProgramPart]:
    """Entries by name: the function's name, numbered where one thread does not compute all
    outputs."""
    word, made = _words(unit).function, parts(_sampled(unit), unit.dtype)
    return (
        {word: made[0]} if len(made) == 1 else {f"{word}_part{k}": x for k, x in enumerate(made, 1)}
    )


def _emit(unit: SourceUnit) -> str:
    return _text(unit, _entries(unit))


def _text(unit: SourceUnit, entries: Mapping[str, ProgramPart]) -> str:
    """The entries as PTX, under a comment that says how they are started."""
    program, names = unit.program, list(entries)
    text = ptx(emit(entries, unit.dtype))
    listed = (
        f"the entry {names[0]}" if len(names) == 1 else f"each of the entries {', '.join(names)}"
    )
    use = _USE.format(
        started=listed,
        count=3 * len(program.inputs + program.outputs) + 1,
        type="double" if unit.dtype == "float64" else "float",
    )
    return "\n".join([*comment_block(unit, use.splitlines(), "", "//", ""), text])


_DRIVER = '''\
"""Runs {word}.ptx on this machine's GPU and compares. Needs NVIDIA's driver; no package."""
import ctypes
import sys

NAMES, TYPE = {names!r}, {type}
GIVEN = [{given}]
EXPECTED = [{expected}]
LARGEST, ALLOWED = {largest!r}, {allowed!r}
COUNT, THREADS = {count}, 4

try:
    driver = ctypes.CDLL("nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1")
except OSError:
    print("not run: there is no NVIDIA driver")
    sys.exit(2)


def call(name, *arguments):
    status = getattr(driver, name)(*arguments)
    if status:
        print(f"FAILED: {{name}} returned {{status}}")
        sys.exit(1)


def device_array(numbers):
    host, address = (TYPE * max(1, len(numbers)))(*numbers), ctypes.c_uint64()
    call("cuMemAlloc_v2", ctypes.byref(address), ctypes.c_size_t(ctypes.sizeof(host)))
    call("cuMemcpyHtoD_v2", address, host, ctypes.c_size_t(ctypes.sizeof(host)))
    return address, host


device = ctypes.c_int()
context, module, entry = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_void_p()
call("cuInit", 0)
call("cuDeviceGet", ctypes.byref(device), 0)
call("cuDevicePrimaryCtxRetain", ctypes.byref(context), device)
call("cuCtxSetCurrent", context)
with open("{word}.ptx", "rb") as file:
    call("cuModuleLoadData", ctypes.byref(module), file.read())
values, results = [], []
for rows in GIVEN:  # as rows
    address, _ = device_array([x for row in rows for x in row])
    values += [address, ctypes.c_int64(len(rows[0])), ctypes.c_int64(1)]
for rows in EXPECTED:  # as columns
    results.append(device_array([0.0] * COUNT * len(rows[0])))
    values += [results[-1][0], ctypes.c_int64(1), ctypes.c_int64(COUNT)]
values.append(ctypes.c_int64(COUNT))
pointers = (ctypes.c_void_p * len(values))(*(ctypes.addressof(x) for x in values))
for name in {entries!r}:
    call("cuModuleGetFunction", ctypes.byref(entry), module, name.encode())
    blocks = -(-COUNT // THREADS)
    call("cuLaunchKernel", entry, blocks, 1, 1, THREADS, 1, 1, 0, None, pointers, None)
call("cuCtxSynchronize")
bad = False
for name, rows, (address, found), size, allowed in zip(NAMES, EXPECTED, results, LARGEST, ALLOWED):
    call("cuMemcpyDtoH_v2", found, address, ctypes.c_size_t(ctypes.sizeof(found)))
    worst = 0.0
    for i, row in enumerate(rows):
        for j, expected in enumerate(row):
            off = abs(found[j * COUNT + i] - expected) / size
            worst = off if not off <= worst else worst  # NaN counts
    print(f"{{name}}: off by at most {{worst:.2g}} of its largest entry; allowed {{allowed:.2g}}")
    bad = bad or not worst <= allowed
print("FAILED" if bad else "passed")
sys.exit(bad)
'''


def _package(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    words, entries = _words(unit), _entries(unit)
    names = words.outputs

    def tables(arguments: tuple[Argument, ...], arrays: tuple) -> str:
        listed = (
            "[" + ", ".join(f"[{row if a.size else ''}]" for row in number_lists(rows, repr)) + "]"
            for a, rows in zip(arguments, arrays, strict=True)
        )
        return "\n    " + ",\n    ".join(listed) + ",\n" if arguments else ""

    test = _DRIVER.format(
        word=words.function,
        names=list(names),
        type="ctypes.c_double" if unit.dtype == "float64" else "ctypes.c_float",
        given=tables(unit.program.inputs, vectors.inputs),
        expected=tables(unit.program.outputs, vectors.outputs),
        largest=largest_entries(vectors),
        allowed=list(vectors.tolerances),
        count=vectors.count,
        entries=list(entries),
    )
    return {f"{words.function}.ptx": _text(unit, entries), f"{words.function}_test.py": test}


CUDA = Language(
    _emit,
    _package,
    "python {name}_test.py",
    dtypes=("float64", "float32"),
    note="The self-test needs an NVIDIA GPU and its driver, nothing else.",
)
