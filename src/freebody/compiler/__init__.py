"""From a function over scalars to machine code that runs on batches.

trace -> Program -> passes -> LLVM text, or NumPy node by node -> Kernel. LLVM is imported when the first kernel is
compiled.
"""

from freebody.compiler.kernel import Kernel, KernelError, compile_program
from freebody.compiler.program import Argument, Program, ProgramError, verify
from freebody.compiler.trace import trace

__all__ = [
    "Argument",
    "Kernel",
    "KernelError",
    "Program",
    "ProgramError",
    "compile_program",
    "trace",
    "verify",
]
