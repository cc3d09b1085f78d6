"""Every target of kernels, with each width of its vectors."""

from __future__ import annotations

import pytest

from freebody.targets import TARGETS
from freebody.targets.target import target_named

WAYS = [
    pytest.param(name, width, marks=pytest.mark.skipif(bool(lacking), reason=f"{name}: {lacking}"))
    for name in TARGETS
    for lacking in [target_named(name).missing()]
    for width in target_named(name).widths["float64"] or (None,)
]
"""Every target with each of its widths: what there is, only the tables of targets say."""
every_target = pytest.mark.parametrize(("target", "width"), WAYS)
