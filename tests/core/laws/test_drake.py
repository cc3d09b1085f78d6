"""The UR5 beside Drake: mass matrix, bias, poses, and the reaction of every joint."""

from __future__ import annotations

import re

import numpy as np
import pytest

import freebody as fb
from support.extras import extra
from support.helpers import close
from support.real_files import ROBOTS

parsing, plants = (extra(f"pydrake.multibody.{name}", "Drake") for name in ("parsing", "plant"))
FILES = (
    "ur_description/urdf/ur5_robot.urdf",
    "kinova_description/robots/kinova.urdf",
    "xarm_description/urdf/xarm7.urdf",
)


def pair(name: str):
    """Our model and Drake's plant, welded to the world, without damping; both read the same
    file."""
    path = ROBOTS / name
    model = fb.load(str(path), snap_angles=0, physical="ignore").without("friction")
    bare = re.sub(r"<(visual|collision)\b.*?</\1>", "", path.read_text(), flags=re.DOTALL)
    bare = re.sub(r"<(dynamics|transmission|gazebo|safety_controller)\b[^>]*/>", "", bare)
    bare = re.sub(r"<(transmission|gazebo)\b.*?</\1>", "", bare, flags=re.DOTALL)
    plant = plants.MultibodyPlant(0.0)
    parsing.Parser(plant).AddModelsFromString(bare, "urdf")
    (root,) = (frame.name for frame in model.frames if frame.body < 0 and not frame.parent)
    if root != "world":
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
    plant.Finalize()
    assert plant.num_velocities() == model.nv
    return model, plant


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", FILES)
def test_robot(name: str):
    model, plant = pair(name)
    context = plant.CreateDefaultContext()
    joints = [plant.GetJointByName(joint) for joint in model.joint_names]
    v = [joint.velocity_start() for joint in joints]
    x = [joint.position_start() for joint in joints]
    assert sorted(v) == list(range(model.nv))
    for q, qd, tau in zip(*fb.random_state(model, 3, 3), strict=True):
        theirs_q, theirs_v, theirs_tau = (np.zeros(model.nv) for _ in range(3))
        theirs_q[x], theirs_v[v], theirs_tau[v] = q, qd, tau
        plant.SetPositions(context, theirs_q)
        plant.SetVelocities(context, theirs_v)
        M = plant.CalcMassMatrix(context)[np.ix_(v, v)]
        close(fb.mass_matrix(model, q), M, 1e-10, what="mass matrix")
        bias = plant.CalcBiasTerm(context)[v] - plant.CalcGravityGeneralizedForces(context)[v]
        close(fb.bias(model, q, qd), bias, 1e-10, what="bias")
        for frame in model.frame_names:
            if frame != "world":
                T = plant.GetFrameByName(frame).CalcPoseInWorld(context).GetAsMatrix4()
                close(fb.forward_kinematics(model, q, frame), T, 1e-10, what=frame)
        # Drake computes reactions for the accelerations that applied forces cause
        plant.get_applied_generalized_force_input_port().FixValue(context, theirs_tau)
        qdd = fb.forward_dynamics(model, q, qd, tau)
        W = fb.joint_wrenches(model, q, qd, qdd, reference="child")
        reactions = plant.get_reaction_forces_output_port().Eval(context)
        for row, joint in zip(W, joints, strict=True):
            theirs = reactions[int(joint.index())]
            found = np.concatenate([theirs.translational(), theirs.rotational()])
            close(row, found, 1e-8, float(np.abs(W).max()), joint.name())
