"""A program as PTX entries, from which NVIDIA's driver makes machine code: one for values computed
once a call, others for every sample."""

from __future__ import annotations

import importlib.util
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

from freebody.errors import FreebodyError
from freebody.program.passes import hoist
from freebody.program.program import Argument, Program
from freebody.targets.cuda.emit import emit
from freebody.targets.cuda.parts import ProgramPart, part, parts, prepared
from freebody.targets.llvm.machine import CompileError, library, to_compile


@dataclass(frozen=True)
class Plan:
    """A program's PTX entries by name.

    once: the entry that one thread runs before, on uniform inputs; empty where there are none. It
    writes `shared` numbers, these inputs and what follows from them, which the others take in the
    place of the uniform inputs, behind the other ones. parts: entries for every sample, in any
    order.
    """

    entries: dict[str, ProgramPart]
    dtype: str
    once: str
    shared: int

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the entries for every sample."""
        return tuple(name for name in self.entries if name != self.once)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all entries of the plan."""
        return tuple(self.entries)

    @property
    def text(self) -> str:
        """PTX text of all entries."""
        return ptx(emit(self.entries, self.dtype))


def plan(program: Program, dtype: str) -> Plan:
    """The plan of PTX entries for a program."""
    every, entries, shared = prepared(program), {}, 0
    if any(argument.uniform for argument in program.inputs):
        before, every = hoist(every)
        before = _with_inputs(before)
        shared = before.output_size
        entries["once"] = part(before, range(shared))
    entries |= {f"part{k}": piece for k, piece in enumerate(parts(every, dtype), 1)}
    return Plan(entries, dtype, "once" if shared else "", shared)


def _with_inputs(before: Program) -> Program:
    """The program with a single output that begins with its inputs."""
    count, size = len(before), before.input_size
    return replace(
        before,
        outputs=(Argument("shared", (size + before.output_size,)),),
        op=(*before.op, *["input"] * size),
        a=(*before.a, *range(size)),
        b=(*before.b, *[-1] * size),
        c=(*before.c, *[-1] * size),
        results=(*range(count, count + size), *before.results),
    )


_PROCESSOR = "sm_70"
"""The oldest GPU that the text is for: Volta, of 2017. Later ones run the same text, and offer
straight-line arithmetic nothing more."""

_TRIPLE = "nvptx64-nvidia-cuda"


def ptx(text: str) -> str:
    """The PTX that LLVM generates from its text.

    Raises FreebodyError where llvmlite is not installed or was built without this target.
    """
    if importlib.util.find_spec("llvmlite") is None:
        raise FreebodyError(
            "PTX is made by LLVM, and llvmlite is not installed; pip install llvmlite."
        )
    llvm = library()
    with to_compile(text), _machine() as machine, llvm.create_context() as context:
        try:
            module = llvm.parse_assembly(text, context)
        except RuntimeError as problem:
            raise CompileError(f"LLVM refused the text of a GPU kernel: {problem}") from None
        with module:
            module.triple, module.data_layout = _TRIPLE, str(machine.target_data)
            # a call costs a thread its registers, so functions become part of who calls them
            passes = llvm.create_new_module_pass_manager()
            passes.add_always_inliner_pass()
            passes.run(
                module, llvm.create_pass_builder(machine, llvm.create_pipeline_tuning_options(2))
            )
            return machine.emit_assembly(module)


def _machine() -> Any:
    """LLVM's code generator for NVIDIA's GPUs."""
    return _target().create_target_machine(cpu=_PROCESSOR, opt=2)


@cache
def _target() -> Any:
    llvm = library()
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    try:
        return llvm.Target.from_triple(_TRIPLE)
    except RuntimeError as problem:
        raise FreebodyError(
            f"this llvmlite was built without LLVM's target for NVIDIA's GPUs: {problem}."
        ) from None
