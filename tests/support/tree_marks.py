"""Random trees that laws are tried on: some in the suite, all among the long tests."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

TREES = range(200)
FLAT_TREES = range(60)
CASES = [(seed, 3) for seed in TREES] + [(seed, 2) for seed in FLAT_TREES]


def trees(cases: Sequence[tuple[int, int]]) -> pytest.MarkDecorator:
    """A test of these seeds and dimensions: of every fourth soon, of the others where there is
    time."""
    return pytest.mark.parametrize(
        ("seed", "dim"),
        [pytest.param(*x, marks=() if k % 4 == 1 else LONG) for k, x in enumerate(cases)],
        ids=[f"{dim}D-{seed}" for seed, dim in cases],
    )


LONG = pytest.mark.long
every_tree = trees(CASES)
every_other = trees(CASES[::2])
