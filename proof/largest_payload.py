"""With the payload that `fb.payload` finds the study of the same motion is feasible, and with a
thousandth more it is not."""

import freebody as fb

arm = fb.load("ur5e")
move = fb.default_motion(arm)
mass = float(fb.payload(arm, move).mass)
print(f"carries {mass:.2f} kg by its effort limits")
assert fb.study(arm.with_payload(0.999 * mass), move).passed
assert not fb.study(arm.with_payload(1.001 * mass), move).passed
