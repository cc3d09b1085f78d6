"""A UR5e written as URDF, MJCF, SDF and TOML and read again is the same robot each time."""

import freebody as fb

arm = fb.load("ur5e")
for suffix in ("urdf", "xml", "sdf", "toml"):
    fb.save(arm, f"ur5e.{suffix}", lossy=True)
    again = fb.load(f"ur5e.{suffix}")
    states = fb.random_state(arm, seed=16, batch=100)
    worst = abs(fb.inverse_dynamics(again, *states) - fb.inverse_dynamics(arm, *states)).max()
    print(f"{suffix}: torques differ by {worst:.1e} N m")
    assert worst < 1e-9
