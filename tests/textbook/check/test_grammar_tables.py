"""The tables of the grammar are data, and long texts of any kind are read in bounded time."""

from __future__ import annotations

import time

import pytest

import freebody as fb

ARM = fb.planar("RR")


@pytest.mark.parametrize(
    "answer",
    [
        r"H22 = m_2 {l}_{c2}^2 + I_2",
        "H22 = m2 lc2² + I2, where m2 = m2",
        r"\mathrm{H}_{22}(q) = m_2 \, l_{c2}^{2} + I_{2}",
        "H[2,2] = m2 lc2**2 + I2",
        "H(2,2) = m₂·l_{c2}² + I₂",
        r"\frac{d}{dt} \frac{\partial T}{\partial \dot{\theta}_1} - ∂T/∂θ1 + dV/dθ1 = \tau_1",
        "d/dt(dT/dq1dot) - dT/dq1 + dV/dq1 = tau1",
        r"τ₂ = H_{12} \frac{d^2 {\theta}_1}{dt^2} + H_22 d²θ2/dt² + m2 l1 lc2 s2 (dθ1/dt)^2 + G2",
        "singular at θ2 = 0, ±180°",
    ],
)
def test_spellings_mean_the_same(answer: str):
    assert fb.check(ARM, answer), fb.check(ARM, answer)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "piece",
    [" ", "(", "[", "{", "^{", "_{", ".", "1", "a", "d", "θ̈", "\\", "|", "=", "M(q,", "d/dt ",
     "\\frac{d", "at ", "singular ", "1,", "1.5 N m ", "θ1 = 1, ", "and θ1 = 1 ", "〖", "{}^1",
     "# "],
)  # fmt: skip
def test_long_texts_are_read_in_bounded_time(piece: str):
    begun = time.process_time()
    with pytest.raises(fb.FreebodyError):
        fb.check(ARM, piece * (19_000 // max(1, len(piece.strip()))))
    assert time.process_time() - begun < 20.0
