"""The traced computations as source text, and as functions of other array libraries."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.lookup import chosen_option, program
from freebody.model.model import Model
from freebody.targets.interpret import array_function
from freebody.targets.text.python import MODULES, emit


def source(model: Model, names: str | Sequence[str], language: str = "numpy", **options: Any) -> str:
    """Python text of a pure function that computes one quantity, or several that share their work.

    names, options: as for `fb.kernel` (frame, reference, wrench_frames, rows). language: "numpy" or "jax".
    The function is called like the kernel, with arrays whose leading shapes broadcast.
    """
    if language not in MODULES:
        raise UnknownNameError("language", language, "fb.source", MODULES)
    listed, option = chosen_option(model, names, **options)
    return emit(program(model, listed, option), language)


def to_jax(model: Model, names: str | Sequence[str], **options: Any) -> Callable[..., Any]:
    """The same as a pure JAX function, which may be jitted, differentiated and mapped. Needs JAX.

    64-bit floats are the caller's choice: jax.config.update("jax_enable_x64", True).
    """
    try:
        import jax.numpy
    except ImportError:
        raise FreebodyError("to_jax: JAX is not installed; pip install 'freebody[jax]'.") from None
    listed, option = chosen_option(model, names, **options)
    return array_function(program(model, listed, option), jax.numpy)
