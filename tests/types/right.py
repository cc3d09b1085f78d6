# pyright: strict
"""What users write, as a type checker in strict mode sees it: no word of complaint."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

import freebody as fb
from freebody.math import clip, cos

arm: fb.Model = fb.load("ur5e")
heavier = arm.with_payload(mass=2.0).bind({"gravity": 1.62})
q, qd, qdd = np.zeros(6), np.zeros(6), np.ones(6)

tau: NDArray[np.float64] = fb.inverse_dynamics(heavier, q, qd, qdd, wrenches={"frame6": [0.0] * 6})
dtau_dq, dtau_dqd, M = fb.inverse_dynamics_derivatives(arm, q, qd, qdd)
shapes: list[tuple[int, ...]] = [x.shape for x in (tau, dtau_dq, dtau_dqd, M)]

plain = fb.kernel(arm, "inverse_dynamics", dtype="float32")
plain(q, qd, qdd, threads=1)
loaded = fb.kernel(arm, ["inverse_dynamics", "mass_matrix"], inputs=["payload.mass"], by="p")
names: tuple[str, ...] = loaded.parameters


def law(x: Any) -> Any:
    return clip(cos(x[0]), 0.0, 1.0)


own = fb.compile(law, {"x": 2}, {"y": ()})
program: str = own.program.name

solutions = fb.inverse_kinematics(arm, fb.forward_kinematics(arm, q), limits="drop")
best: NDArray[np.float64] = solutions.q
verdict = fb.study(fb.load("2R")).verdict
sentence: str = str(verdict)
drive = fb.Drive(viscous=0.1, stiffness="k")
five_bar = fb.planar("RR", m=[1.0, 2.0], l=["l1", 0.3])
closed_form: str = fb.equations(five_bar).latex()

try:
    fb.load("no such robot")
except fb.FreebodyError as problem:
    message: str = str(problem)
