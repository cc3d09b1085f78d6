"""Nanoseconds that each function of `freebody.math` takes inside a kernel, beside NumPy's function
over an array.

Of a kernel that adds the function of 24 inputs, the time less that of one which adds the inputs;
one thread, batches of 4096 that stay in the cache, CPU time, medians of rounds that take turns.
"""

from statistics import median

import numpy as np

import freebody as fb
from common import seconds
from freebody import math as fm

COUNT, BATCH, ROUNDS, CALLS = 24, 4096, 15, 10
NUMPY = {"atan2": "arctan2", "asin": "arcsin", "acos": "arccos"}
TWO = ("atan2", "minimum", "maximum", "less", "less_equal", "equal")
NAMES = (
    "sin",
    "exp",
    "log",
    "tanh",
    "asin",
    "acos",
    "atan2",
    "sqrt",
    "sign",
    "absolute",
    "minimum",
    "less",
    "where",
)


def kernel(name: str | None):
    """The sum of the function of the inputs, of neighbours where it takes two or three."""

    def added(x):
        function = getattr(fm, name) if name else lambda a: a
        arity = 3 if name == "where" else 2 if name in TWO else 1
        return sum(function(*(x[(k + i) % COUNT] for i in range(arity))) for k in range(COUNT))

    return fb.compile(added, {"x": COUNT}, {"r": ()})


def main() -> None:
    """One line a function."""
    x = np.random.default_rng(0).uniform(0.05, 0.95, (BATCH, COUNT))
    columns, out, flat = np.ascontiguousarray(x.T), np.empty(BATCH), np.empty(BATCH * COUNT)
    plain = kernel(None)
    print(f"{'':12}{'in a kernel':>14}{'NumPy':>10}   ns")
    for name in NAMES:
        made, array = kernel(name), getattr(np, NUMPY.get(name, name))
        arity = 3 if name == "where" else 2 if name in TWO else 1
        operands = [columns.ravel()] * arity
        places = {} if name in ("where", "less") else {"out": flat}
        rounds = [
            (
                seconds(lambda made=made: made(x, out=out, threads=1), CALLS),
                seconds(lambda: plain(x, out=out, threads=1), CALLS),
                seconds(
                    lambda array=array, operands=operands, places=places: array(
                        *operands, **places
                    ),
                    CALLS,
                ),
            )
            for _ in range(ROUNDS)
        ]
        ours, theirs = median(a - b for a, b, _ in rounds), median(c for *_, c in rounds)
        print(f"{name:12}{ours / BATCH / COUNT * 1e9:14.2f}{theirs / BATCH / COUNT * 1e9:10.2f}")


if __name__ == "__main__":
    main()
