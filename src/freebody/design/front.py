"""Choices of which none is better in everything: the Pareto front of mass, price and margin."""

from __future__ import annotations

from bisect import bisect_right, insort

import numpy as np

from freebody.arrays import Array
from freebody.trees.position_rates import Index


def front(mass: Array, price: Array, margin: Array) -> Index:
    """Indices of those (k,) of which no other is at most as heavy, at most as dear and at least as
    safe, and better in one; of equal ones the first. Light ones first."""
    if len(margin) and (margin == margin[0]).all():
        return _stairs(mass, price)
    found: list[int] = []
    stairs: list[tuple[float, float]] = []
    # the safest first: what is found later is kept only where it is lighter or cheaper
    for k in np.lexsort((price, mass, -margin)):
        entry = float(mass[k]), float(price[k])
        at = bisect_right(stairs, (entry[0], np.inf))
        if at and stairs[at - 1][1] <= entry[1]:
            continue
        found.append(int(k))
        while at < len(stairs) and stairs[at][1] >= entry[1]:
            del stairs[at]
        insort(stairs, entry)
    chosen = np.array(found, dtype=np.intp)
    return chosen[np.lexsort((-margin[chosen], price[chosen], mass[chosen]))]


def _stairs(mass: Array, price: Array) -> Index:
    """The front of those that are equally safe."""
    order = np.lexsort((price, mass))
    cheapest = np.minimum.accumulate(price[order])
    return order[np.append(True, cheapest[1:] < cheapest[:-1])]
