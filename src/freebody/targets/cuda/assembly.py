"""LLVM text to PTX, the assembly that NVIDIA's driver makes machine code of for the GPU that is
there."""

from __future__ import annotations

import importlib.util
from functools import cache
from typing import Any

from freebody.errors import FreebodyError
from freebody.targets.llvm.llvm_lock import library, to_compile
from freebody.targets.llvm.machine import CompileError

PROCESSOR = "sm_70"
"""The oldest GPU that the text is for: Volta, of 2017. Later ones run the same text, and offer
straight-line arithmetic nothing more."""

_TRIPLE = "nvptx64-nvidia-cuda"


def ptx(text: str) -> str:
    """PTX of LLVM text.

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
    """LLVM's code generator for these GPUs."""
    return _target().create_target_machine(cpu=PROCESSOR, opt=2)


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
