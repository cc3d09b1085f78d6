"""XLA's C interface to foreign functions as in its header `xla/ffi/api/c_api.h`: offsets in bytes.

A major version may move what is here; a minor one adds fields behind those that were there before.
On machines with pointers of 64 bits. The tests compile the header and compare.
"""

from __future__ import annotations

import re
import struct
from pathlib import Path

MAJOR = 0
"""Version of the interface that the offsets are of."""

OFFSETS = {
    "XLA_FFI_CallFrame": {
        "extension_start": 8,
        "api": 16,
        "ctx": 24,
        "stage": 32,
        "args": 40,
        "rets": 80,
    },
    "XLA_FFI_Args": {"struct_size": 0, "size": 16, "args": 32},
    "XLA_FFI_Rets": {"struct_size": 0, "size": 16, "rets": 32},
    "XLA_FFI_Buffer": {"dtype": 16, "data": 24, "rank": 32, "dims": 40},
    "XLA_FFI_Extension_Base": {"type": 8},
    "XLA_FFI_Metadata_Extension": {"metadata": 24},
    "XLA_FFI_Metadata": {"api_version": 8, "traits": 32},
    "XLA_FFI_Api_Version": {
        "struct_size": 0,
        "extension_start": 8,
        "major_version": 16,
        "minor_version": 20,
    },
    "XLA_FFI_Api": {
        "XLA_FFI_Error_Create": 48,
        "XLA_FFI_Error_Destroy": 64,
        "XLA_FFI_ThreadPool_Schedule": 136,
        "XLA_FFI_ThreadPool_NumThreads": 144,
    },
    "XLA_FFI_Error_Create_Args": {
        "struct_size": 0,
        "extension_start": 8,
        "message": 16,
        "errc": 24,
    },
    "XLA_FFI_Error_Destroy_Args": {"struct_size": 0, "extension_start": 8, "error": 16},
    "XLA_FFI_ThreadPool_Schedule_Args": {
        "struct_size": 0,
        "extension_start": 8,
        "ctx": 16,
        "task": 24,
        "data": 32,
    },
    "XLA_FFI_ThreadPool_NumThreads_Args": {
        "struct_size": 0,
        "extension_start": 8,
        "ctx": 16,
        "num_threads": 24,
    },
}

SIZES = {
    "XLA_FFI_Args": 40,
    "XLA_FFI_Rets": 40,
    "XLA_FFI_Api_Version": 24,
    "XLA_FFI_Error_Create_Args": 28,
    "XLA_FFI_Error_Destroy_Args": 24,
    "XLA_FFI_ThreadPool_Schedule_Args": 40,
    "XLA_FFI_ThreadPool_NumThreads_Args": 32,
}
"""The sizes that `struct_size` states. Were one of the first two larger, what lies behind it would
have moved."""

NUMBERS = {
    "XLA_FFI_Extension_Metadata": 1,
    "XLA_FFI_ExecutionStage_EXECUTE": 3,
    "XLA_FFI_DataType_F32": 11,
    "XLA_FFI_DataType_F64": 12,
    "XLA_FFI_Error_Code_INTERNAL": 13,
}


def version(folder: str) -> tuple[int, int] | None:
    """The version of XLA's interface whose header is below a folder; None where there is none."""
    try:
        text = Path(folder, "xla", "ffi", "api", "c_api.h").read_text(
            encoding="utf-8", errors="replace"
        )
    except OSError:
        return None
    found = [
        re.search(rf"#define\s+XLA_FFI_API_{part}\s+(\d{{1,6}})\b", text)
        for part in ("MAJOR", "MINOR")
    ]
    if not all(found):
        return None
    major, minor = (int(match.group(1)) for match in found if match)
    return major, minor


def fits(found: tuple[int, int] | None) -> bool:
    """Whether the known layout of XLA's interface applies to this version on this machine."""
    return found is not None and found[0] == MAJOR and struct.calcsize("P") == 8
