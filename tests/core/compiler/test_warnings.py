"""Warnings stand at the user's line, however deep in freebody they are found out."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest

import freebody as fb

ARM = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
Q = np.zeros(2)
CALLS: dict[str, Callable[[], object]] = {
    "a body that no rigid body is": lambda: fb.planar(
        "R", l=[1], lc=[0], m=[-1], I=[1], physical="warn"
    ),
    "damped rates": lambda: fb.inverse_velocity(ARM, Q, [1.0, 0.0], damping=0.05),
    "points without a value": lambda: fb.sweep(
        ARM, lambda model, q: np.where(q[..., 0] > 0, q[..., 0], np.nan), over={"q": [Q, Q + 1]}
    ),
    "a table that is doubtful": lambda: fb.simulate(
        ARM, np.zeros((2, 2)), Q, [0.0, 0.1], np.zeros((2, 2)), method="rk4"
    ),
    "steps that are too long": lambda: fb.simulate(
        ARM.with_drive("joint1", viscous=1e4), Q, Q, [0.0, 1.0], method="rk4"
    ),
}


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", CALLS)
def test_a_warning_names_the_line_that_called(name):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        CALLS[name]()
    assert [x.filename for x in told] == [__file__]
    assert issubclass(told[0].category, fb.FreebodyWarning)
