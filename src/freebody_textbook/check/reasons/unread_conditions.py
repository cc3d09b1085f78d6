"""Conditions in words, as for small angles: lines are judged without them; wrong ones say so."""

from __future__ import annotations

import re

from freebody_textbook.check.reading.claim import Claim

_TOLD = re.compile(
    r"(?:^|[.;]\s)\W*([^=:;]*"
    r"(?:\b(?:small|near|close to|neglect|ignor|without|horizontal|vertical|upright|hanging|"
    r"stretched|lineari|approximat|limit|first order)|[<>≈≪≫→])"
    r"[^=:;]*)[:,][^:;]*=",
    re.IGNORECASE,
)
"""What stands in front of an equation, up to its sign of equality."""


def advice(claim: Claim) -> list[str]:
    """A sentence about words in front of a claim that may be a condition."""
    at, text = claim.node.span[0], claim.source.shown
    begun = text.rfind("\n", 0, at) + 1
    found = _TOLD.search(text[begun:at])
    if found is None:
        return []
    words = claim.source[begun + found.start(1), begun + found.end(1)]
    return [f"‘{words}’ in front of it is not read as a condition: it is compared without it."]
