"""A block of 2 kg that slides at 3 m/s against 5 N of dry friction comes to rest after v² m / 2F,
and stays there: to 1e-9 m."""

import freebody as fb

slide = fb.planar("P", lc=[0.0], m=[2.0], I=[0.0]).replace(gravity=[0.0, 0.0])
block = slide.with_drive(slide.joint_names[0], coulomb=5.0)
run = fb.simulate(block, [0.0], [3.0], [0.0, 1.2, 2.0], friction="dry")
expected = 3.0**2 * 2.0 / (2 * 5.0)
found = run.q.values[1:, 0]
print(f"{found[-1]:.12f} m, closed form {expected:.12f} m")
assert abs(found - expected).max() < 1e-9
