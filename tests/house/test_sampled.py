"""The samples of laws that the suite runs hold all values that there is room for."""

from itertools import product

import pytest

from support.sampled import sample, values


@pytest.mark.parametrize("size", [1, 2, 4, 7, 12, 40])
def test_a_sample_has_each_value_before_any_twice(size: int) -> None:
    sides = "abcd", "xyz"
    cases = {f"{a}-{b}": set(enumerate((a, b))) for a, b in product(*sides)}
    kept = sample(cases, size)
    assert len(kept) == min(size, len(cases))
    assert kept == sample(dict(reversed(cases.items())), size)
    for place, side in enumerate(sides):
        assert len({name.split("-")[place] for name in kept}) == min(size, len(side))


def test_values_are_told_from_names(request: pytest.FixtureRequest) -> None:
    assert values(request.node) == {(0, "")}
