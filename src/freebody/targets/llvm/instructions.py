"""A table of LLVM instructions: each operation of a program over a vector of lanes.

Sine and cosine are not among them: they stand between segments, see `sincos`.
"""

from __future__ import annotations

from freebody.program.program import Program
from freebody.scalars.operations import OPERATIONS
from freebody.targets.llvm.lanes import Lanes
from freebody.targets.llvm.vector import function
from freebody.targets.llvm.vector_functions import FUNCTIONS

COMPARISONS = ("less", "less_equal", "equal")
CHOICE = "where by a comparison"
"""The choice by a comparison that stands in the same function: its truth values, `.c`, choose
themselves."""

_FLAG = (
    "{r}.c = fcmp ORDER {v} {a}, {b}\n  {r} = select {mask} {r}.c, {v} {one}, {v} zeroinitializer"
)

# the machine's own minimum and maximum give their second operand where one is NaN
_EXTREMUM = (
    "{r}.c = fcmp ORDER {v} {b}, {a}\n"
    "  {r}.m = select {mask} {r}.c, {v} {b}, {v} {a}\n"
    "  {r}.n = fcmp uno {v} {b}, zeroinitializer\n"
    "  {r} = select {mask} {r}.n, {v} {b}, {v} {r}.m"
)


def _call(name: str) -> str:
    operands = ", ".join(f"{{v}} {{{x}}}" for x in "ab"[: OPERATIONS[name].arity])
    return f"{{r}} = call {{v}} @vector.{name}.{{n}}({operands})"


INSTRUCTION = {
    "add": "{r} = fadd contract {v} {a}, {b}",
    "sub": "{r} = fsub contract {v} {a}, {b}",
    "mul": "{r} = fmul contract {v} {a}, {b}",
    "div": "{r} = fdiv {v} {a}, {b}",
    "neg": "{r} = fneg contract {v} {a}",
    "sqrt": "{r} = call {v} @llvm.sqrt.{n}({v} {a})",
    "sign": (
        "{r}.u = call {v} @llvm.copysign.{n}({v} {one}, {v} {a})\n"
        "  {r}.c = fcmp one {v} {a}, zeroinitializer\n"
        "  {r}.z = fadd {v} {a}, zeroinitializer\n"
        "  {r} = select {mask} {r}.c, {v} {r}.u, {v} {r}.z"
    ),
    "absolute": "{r} = call {v} @llvm.fabs.{n}({v} {a})",
    "less": _FLAG.replace("ORDER", "olt"),
    "less_equal": _FLAG.replace("ORDER", "ole"),
    "equal": _FLAG.replace("ORDER", "oeq"),
    "where": "{r}.c = fcmp une {v} {a}, zeroinitializer\n  {r} = select {mask} {r}.c, {v} {b}, "
    "{v} {c}",
    "minimum": _EXTREMUM.replace("ORDER", "olt"),
    "maximum": _EXTREMUM.replace("ORDER", "ogt"),
    "epsilon": "{r} = fadd {v} {epsilon}, zeroinitializer",
    CHOICE: "{r} = select {mask} {a}.c, {v} {b}, {v} {c}",
} | {name: _call(name) for name in FUNCTIONS}
"""Only contraction to fused multiply-add is allowed: other fast-math flags break range reduction
and NaN."""


def instructions(lanes: Lanes) -> dict[str, str]:
    """The table for such vectors; what is left to say is {0}, the name of the result, and {1}, … of
    the operands."""
    words = {"v": lanes.v, "n": lanes.suffix, "mask": lanes.mask, "one": lanes.constant(1.0)}
    words["epsilon"] = lanes.constant(lanes.real.epsilon)
    places = {"r": "{0}", "a": "{1}", "b": "{2}", "c": "{3}"}
    return {op: text.format(**words, **places) for op, text in INSTRUCTION.items()}


def functions(program: Program, lanes: Lanes, fma: bool) -> str:
    """The functions that a program's operations call."""
    return "\n".join(
        function(f"@vector.{name}.{lanes.suffix}", OPERATIONS[name].arity, make, lanes, fma)
        for name, make in FUNCTIONS.items()
        if name in program.operations
    )


def declarations(lanes: Lanes) -> str:
    """Declarations of LLVM's own functions that the instructions call."""
    v, n = lanes.v, lanes.suffix
    return (
        f"declare {v} @llvm.sqrt.{n}({v})\n"
        f"declare {v} @llvm.fabs.{n}({v})\n"
        f"declare {v} @llvm.copysign.{n}({v}, {v})\n"
    )
