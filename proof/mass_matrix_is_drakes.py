"""The mass matrix and the bias torques of an iiwa equal Drake's, to 1e-11 of their largest entry,
in 50 random states."""

from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

import freebody as fb

arm = fb.load("iiwa14").without("friction", "rotors")
fb.save(arm, "iiwa14.urdf", lossy=True)
plant = MultibodyPlant(0.0)
Parser(plant).AddModels("iiwa14.urdf")
plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(arm.bodies[0].joint.parent))
plant.Finalize()
context = plant.CreateDefaultContext()
q, qd, _ = fb.random_state(arm, seed=4, batch=50)
worst = 0.0
for k in range(50):
    plant.SetPositions(context, q[k])
    plant.SetVelocities(context, qd[k])
    M = plant.CalcMassMatrix(context)
    bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
    worst = max(worst, abs(fb.mass_matrix(arm, q[k]) - M).max() / abs(M).max())
    worst = max(worst, abs(fb.bias(arm, q[k], qd[k]) - bias).max() / abs(bias).max())
print(f"largest difference {worst:.1e} of the largest entry")
assert worst < 1e-11
