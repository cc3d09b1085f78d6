"""Which joints of a compiled MJCF model follow others: by equalities of joints, and by those of
fixed tendons, which add up positions of joints."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, NoReturn

from freebody.model.mimics import Mimic

_JointFactors = dict[int, float]


def followers(
    given: Mapping[str, Any], names: Sequence[str], refuse: Callable[[str], NoReturn]
) -> dict[int, Mimic]:
    """The mimics of followers, by the index of the joint. names: of the joints; refuse raises with
    what is wrong in the file."""
    found: dict[int, Mimic] = {}
    for equality in given["equalities"]:
        if not equality["active"] or not is_coupling(equality, given):
            continue
        constant, *terms = equality["data"][:5]
        follower: int = equality["first"]
        other: int = equality["second"]
        bent = equality["type"] == "joint" and other >= 0 and any(terms[1:])
        if bent and follower not in found:
            zeros = [given["joints"][i]["zero"] for i in (follower, other)]
            at_zero = Mimic.of_terms([(names[other], (*terms,))], zeros[0] + constant)
            found[follower] = at_zero.seen_at(1.0, -zeros[1])
            continue
        factors = _factors(equality, given)
        free = [joint for joint in factors if joint not in found]
        if bent or len(factors) < 2 or not free:
            fault = "is held in its place" if len(factors) < 2 and not bent else "follows twice"
            refuse(
                f"joint {names[next(iter(factors), follower)]!r} {fault} by equalities, which "
                f"freebody does not know; remove one."
            )
        found[free[0]] = _mimic(free[0], factors, constant, given, names)
    return found


def is_coupling(equality: Mapping[str, Any], given: Mapping[str, Any]) -> bool:
    """Whether an equality joins positions of joints and nothing else."""
    if equality["type"] == "joint":
        return True
    ends = [given["tendons"][i] for i in _ends(equality)] if equality["type"] == "tendon" else []
    return bool(ends) and all(tendon["joints"] for tendon in ends)


def _ends(equality: Mapping[str, Any]) -> list[int]:
    return [i for i in (equality["first"], equality["second"]) if i >= 0]


def _factors(equality: Mapping[str, Any], given: Mapping[str, Any]) -> _JointFactors:
    """Factors of joints whose shifts from their zeros, times these, add up to the equality's
    constant. The one that follows comes first: the joint that the equality names first; of a tendon
    the last in the tree."""
    factors: _JointFactors = {}
    for joint, factor in _added(equality, given):
        factors[joint] = factors.get(joint, 0.0) + factor
    joints = sorted(factors, reverse=True) if equality["type"] == "tendon" else factors
    return {joint: factors[joint] for joint in joints if factors[joint]}


def _added(equality: Mapping[str, Any], given: Mapping[str, Any]) -> Iterator[tuple[int, float]]:
    for end, factor in zip(_ends(equality), (1.0, -equality["data"][1]), strict=False):
        if equality["type"] == "joint":
            yield end, factor
        else:
            for joint, by in given["tendons"][end]["joints"]:
                yield joint, by * factor


def _mimic(
    follower: int,
    factors: _JointFactors,
    constant: float,
    given: Mapping[str, Any],
    names: Sequence[str],
) -> Mimic:
    zeros = [joint["zero"] for joint in given["joints"]]
    ratios = {
        joint: -factor / factors[follower] for joint, factor in factors.items() if joint != follower
    }
    offset = zeros[follower] + constant / factors[follower]
    offset -= sum(ratio * zeros[joint] for joint, ratio in ratios.items())
    terms = [(names[joint], (ratio,)) for joint, ratio in ratios.items()]
    return Mimic.of_terms(terms, offset)
