"""Where programs run: this CPU through LLVM, NumPy or JAX node by node, and text in other
languages.

LLVM is imported when the first kernel is compiled.
"""

from freebody.targets.kernel import Kernel, compile_program
from freebody.targets.target import TARGETS, KernelError

__all__ = ["TARGETS", "Kernel", "KernelError", "compile_program"]
