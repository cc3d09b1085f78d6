"""The sample of a law's cases that the suite runs: `pytest.mark.sample(n)` on a test of many cases
leaves all but n of them to `pytest -m long`."""

from __future__ import annotations

from collections import defaultdict
from hashlib import sha1
from typing import TYPE_CHECKING

import pytest

if TYPE_CHECKING:
    from collections.abc import Hashable


@pytest.hookimpl(tryfirst=True)  # before pytest deselects by marks
def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """Marks as long what is not in the samples. A test named on the command line has all cases."""
    laws: dict[tuple[str, str], list[pytest.Item]] = defaultdict(list)
    for item in items:
        if item.get_closest_marker("sample") and not item.get_closest_marker("long"):
            laws[item.nodeid.partition("[")[0], str(item.path)].append(item)
    if any("::" in argument for argument in config.args):
        return
    for cases in laws.values():
        mark = cases[0].get_closest_marker("sample")
        assert mark is not None
        kept = sample({item.nodeid: values(item) for item in cases}, *mark.args)
        for item in cases:
            if item.nodeid not in kept:
                item.add_marker(pytest.mark.long)


def values(item: pytest.Item) -> set[Hashable]:
    """The values of a case, each with its place: what stands between the hyphens of its name."""
    return set(enumerate(item.nodeid.partition("[")[2].rstrip("]").split("-")))


def sample(cases: dict[str, set[Hashable]], size: int) -> set[str]:
    """Names of `size` cases with as many different values as can be had, whatever their order: of
    those that bring equally many new ones, the first by a hash of their names."""
    left = sorted(cases, key=lambda name: sha1(name.encode()).digest())
    seen: set[Hashable] = set()
    kept: set[str] = set()
    while left and len(kept) < size:
        name = max(left, key=lambda name: len(cases[name] - seen))
        left.remove(name)
        kept.add(name)
        seen |= cases[name]
    return kept
