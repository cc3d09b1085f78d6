# pyright: strict
"""Mistakes that a type checker must find, each on the line that says which."""

import freebody as fb

arm = fb.load("ur5e")
q = [0.0] * 6
fb.inverse_dynamcs(arm, q, q, q)  # error: "inverse_dynamcs" is not a known attribute
fb.inverse_dynamics("ur5e", q, q, q)  # error: "Literal['ur5e']" is not assignable to "Model"
fb.inverse_dynamics(arm, q, q, qdot=q)  # error: No parameter named "qdot"
fb.kernel(arm, "bias", dtyp="float32")  # error: No overloads for "kernel"
fb.kernel(arm, "bias", inputs=["gravity"]).paramters  # error: Cannot access attribute "paramters"
arm.with_paylod(mass=1.0)  # error: Cannot access attribute "with_paylod"
fb.inverse_kinematics(arm, q, limits="drops")  # error: "Literal['drops']" is not assignable
fb.Drive(viscosity=0.1)  # error: No parameter named "viscosity"
fb.math.sin(1.0, 2.0)  # error: Expected 1 positional argument
fb.math.sine(1.0)  # error: "sine" is not a known attribute
fb.equations(arm, number=True)  # error: No parameter named "number"
