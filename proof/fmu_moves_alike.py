"""A UR5e as a unit of co-simulation (FMI 2.0), run by FMPy, moves within half a second as
`fb.simulate` says, to 1e-8 rad."""

import fmpy
import numpy as np

import freebody as fb

arm = fb.load("ur5e")
q = np.array([0.1, -1.2, 0.8, 0.2, 0.3, -0.4])
torques = np.array([1.0, -20.0, 5.0, 0.3, -0.2, 0.1])
fb.export_fmu(arm, "ur5e.fmu", step=5e-4)
names = [f"q.{name}" for name in arm.position_names]
columns = [("time", "f8"), *((f"tau.{name}", "f8") for name in arm.velocity_names)]
run = fmpy.simulate_fmu(
    "ur5e.fmu",
    stop_time=0.5,
    output_interval=0.01,
    input=np.array([(0.0, *torques)], dtype=columns),
    start_values=dict(zip(names, q, strict=True)),
    output=names,
)
mine = fb.simulate(arm, q, np.zeros(6), [0.0, 0.5], torques, tolerance=1e-12).q.values[-1]
worst = max(abs(run[name][-1] - mine[k]) for k, name in enumerate(names))
print(f"largest difference {worst:.1e} rad")
assert worst < 1e-8
