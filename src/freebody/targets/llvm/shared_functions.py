"""Functions that are the same in all kernels of a machine: moving samples, sines of large
arguments, checks of calls from Python. They take as long to compile as a small robot's kernel.

So a process compiles them once, and their object is loaded beside each kernel's own.
"""

from __future__ import annotations

import re
from functools import cache

from freebody.targets.llvm import fastchecks
from freebody.targets.llvm.lanes import Lanes
from freebody.targets.llvm.machine import Host, Machine, object_code
from freebody.targets.llvm.sample_transfers import gather, transfer_functions
from freebody.targets.llvm.sincos import reduction, sincos


@cache
def object_beside(machine: Machine, here: Host) -> bytes:
    """The compiled object of all shared functions, for kernels whose text contains
    `declarations`."""
    text = "\n".join([*_functions(machine).values(), attributes(machine.lanes)])
    return object_code(declared_once(text.replace("define internal", "define")), here=here)


def definitions(text: str, machine: Machine) -> str:
    """LLVM definitions of the shared functions that a text calls, and of those that these call."""
    functions = _functions(machine)
    return "\n".join(functions[name] for name in _called(text, functions))


def declarations(text: str, machine: Machine) -> str:
    """LLVM declarations of the shared functions that a text calls and `object_beside` defines."""
    functions = _functions(machine)
    found = []
    for name in _called(text, functions):
        (head,) = re.findall(
            rf"^define internal (.*@{re.escape(name)}\(.*\))", functions[name], re.M
        )
        found.append(f"declare {re.sub(r' %[a-z0-9.]+', '', head)}\n")
    return "".join(found)


def _called(text: str, functions: dict[str, str]) -> list[str]:
    """Names of the functions that a text calls, in the order of the table."""
    names, texts = set(), [text]
    while texts:
        new = set(re.findall(r"call [^@]*@([\w.]+)\(", texts.pop())) & functions.keys() - names
        names |= new
        texts += [functions[name] for name in new]
    return [name for name in functions if name in names]


@cache
def _functions(machine: Machine) -> dict[str, str]:
    lanes, one = machine.lanes, Lanes(machine.real, 1)
    return {
        "reduce": reduction(),
        **{f"sincos.{some.suffix}": sincos(some, machine.fma) for some in (lanes, one)},
        **transfer_functions(lanes),
        "gather": gather(lanes),
        "fast.finite": fastchecks.finite(machine.real),
        "fast.unit": fastchecks.are_unit(machine.real),
    }


def declared_once(text: str) -> str:
    """The text with each declaration once: every piece declares what it calls, and LLVM refuses a
    second declaration."""
    lines = text.split("\n")
    declared = dict.fromkeys(line for line in lines if line.startswith("declare "))
    return "\n".join([*(line for line in lines if line not in declared), *declared, ""])


def attributes(lanes: Lanes) -> str:
    """LLVM attributes of all functions, of those that keep many vectors on the stack (with a frame,
    which aligns them), and of the short ones that operations call."""
    vectors = (
        f'"min-legal-vector-width"="{8 * lanes.size}" "prefer-vector-width"="{8 * lanes.size}"'
    )
    return (
        f"attributes #0 = {{ nounwind {vectors} }}\n"
        f'attributes #1 = {{ nounwind "frame-pointer"="all" {vectors} }}\n'
        f"attributes #2 = {{ nounwind {vectors} }}\n"
    )
