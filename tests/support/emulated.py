"""A plugin of pytest: NVIDIA's driver is there, and runs kernels on this processor (`-p
support.emulated`).

Everything but the driver's library is what runs on a GPU: the target, NVIDIA's binding, the
entries' LLVM text.
"""

from __future__ import annotations

import ctypes
import tempfile
from functools import cache
from pathlib import Path

from freebody.targets.cuda import ptx
from support import gpu

_texts: dict[str, str] = {}
_kept: list[object] = []


_ptx_of_llvm = ptx.ptx


def _ptx(text: str) -> str:
    made = _ptx_of_llvm(text)
    _texts[made] = text
    return made


@cache
def _emulated(text: str) -> gpu.Emulated:
    names = [
        line.split("@")[1].split("(")[0]
        for line in _texts[text].splitlines()
        if "ptx_kernel" in line
    ]
    return gpu.Emulated(_texts[text], names)


def pytest_configure() -> None:
    """Before anything asks for the driver."""
    folder = Path(tempfile.mkdtemp(prefix="freebody-driver-"))
    library = ctypes.CDLL(str(gpu.driver(folder)), mode=ctypes.RTLD_GLOBAL)
    kind = ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_char_p, ctypes.c_char_p)
    hook = kind(lambda text, name: _emulated(text.decode()).addresses.get(name.decode()))
    library.emulate(hook)
    _kept.extend([library, hook])
    ptx.ptx = _ptx
