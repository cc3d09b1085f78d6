"""The table of targets on which programs run: this CPU through LLVM, NumPy node by node, NVIDIA's
GPUs; besides, ways into JAX and PyTorch, and text in other languages.

A target's module is imported when its first kernel is compiled, and LLVM with the CPU's.
"""

from freebody.targets.kernel import Kernel, compile_program
from freebody.targets.target import TARGETS, KernelError, Target

__all__ = ["TARGETS", "Kernel", "KernelError", "compile_program"]


def _cpu() -> Target:
    from freebody.targets.llvm.cpu import TARGET

    return TARGET


def _numpy() -> Target:
    from freebody.targets.interpreter import TARGET

    return TARGET


def _cuda() -> Target:
    from freebody.targets.cuda.kernel import TARGET

    return TARGET


TARGETS.update(cpu=_cpu, numpy=_numpy, cuda=_cuda)
