"""Where programs run: this CPU through LLVM, NumPy or JAX node by node, and text in other languages.

LLVM is imported when the first kernel is compiled.
"""

from freebody.targets.kernel import Kernel, KernelError, compile_program

__all__ = ["Kernel", "KernelError", "compile_program"]
