"""Ṁ - 2C is skew-symmetric for a Panda and a UR5e, to 1e-10 of the largest entry of M, with Ṁ by
differences along the motion."""

import freebody as fb

worst = 0.0
for name in ("panda", "ur5e"):
    arm = fb.load(name)
    q, qd, _ = fb.random_state(arm, seed=8, batch=100)
    h = 1e-4
    ahead, behind = (fb.mass_matrix(arm, fb.integrate(arm, q, s * h * qd)) for s in (1, -1))
    ahead2, behind2 = (fb.mass_matrix(arm, fb.integrate(arm, q, 2 * s * h * qd)) for s in (1, -1))
    rate = (8 * (ahead - behind) - (ahead2 - behind2)) / (12 * h)
    S = rate - 2 * fb.coriolis_matrix(arm, q, qd)
    worst = max(worst, abs(S + S.swapaxes(-1, -2)).max() / abs(fb.mass_matrix(arm, q)).max())
print(f"symmetric part at most {worst:.1e}")
assert worst < 1e-10
