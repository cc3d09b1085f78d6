"""The elementary functions of an algorithm, over any scalar.

A scalar is anything that adds, subtracts, multiplies and divides, and either has the methods `sin`, `cos`, `sqrt`
and `sign` or is understood by NumPy. So floats, NumPy arrays (one entry a sample) and traced or symbolic scalars all
run through the same text.
"""

from __future__ import annotations

from typing import Any

import numpy as np

Scalar = Any
"""A float, a NumPy array, or any object with the arithmetic above."""


def _dispatch(name: str, numeric: Any) -> Any:
    def function(x: Scalar) -> Scalar:
        method = getattr(x, name, None)
        return method() if method is not None else numeric(x)

    function.__name__ = name
    function.__doc__ = f"{name}(x) of a scalar of any kind."
    return function


sin = _dispatch("sin", np.sin)
cos = _dispatch("cos", np.cos)
sqrt = _dispatch("sqrt", np.sqrt)
sign = _dispatch("sign", np.sign)
