"""A program of its own: MuJoCo parses and compiles a file, and the numbers that freebody reads are
printed as JSON.

MuJoCo is written in C, and a broken file can end its process: that is not to be the user's. Run as
`python compiled.py FILE`, or without a file with the text on standard input. It imports nothing of
freebody.
"""

import json
import sys
from typing import Any

KINDS = ("free", "ball", "slide", "hinge")
EQUALITIES = ("connect", "weld", "joint", "tendon", "flex", "distance")


def compiled(model, mujoco):
    """The parts of a compiled model, each as a dict of names, numbers and lists."""

    def name(kind, index):
        return mujoco.mj_id2name(model, kind, index) or "" if index >= 0 else ""

    def rows(count, of, **columns):
        return [
            {
                "name": name(of, i) if of is not None else "",
                **{
                    key: column[i].tolist() if hasattr(column[i], "tolist") else column[i]
                    for key, column in columns.items()
                },
            }
            for i in range(count)
        ]

    objects = mujoco.mjtObj
    m = model
    dofs, no_powers = m.jnt_dofadr, [[0.0, 0.0]] * m.njnt
    joints = rows(
        m.njnt,
        objects.mjOBJ_JOINT,
        body=m.jnt_bodyid,
        type=m.jnt_type,
        pos=m.jnt_pos,
        axis=m.jnt_axis,
        limited=m.jnt_limited,
        range=m.jnt_range,
        stiffness=m.jnt_stiffness,
        effort_limited=m.jnt_actfrclimited,
        effort=m.jnt_actfrcrange,
        armature=m.dof_armature[dofs],
        damping=m.dof_damping[dofs],
        friction=m.dof_frictionloss[dofs],
        zero=m.qpos0[m.jnt_qposadr],
        rest=m.qpos_spring[m.jnt_qposadr],
        # of the second and third power, since version 3.4
        more_stiffness=getattr(m, "jnt_stiffnesspoly", no_powers),
        more_damping=m.dof_dampingpoly[dofs] if hasattr(m, "dof_dampingpoly") else no_powers,
    )
    for joint in joints:
        joint["type"] = KINDS[joint["type"]]
    bodies = rows(
        m.nbody,
        objects.mjOBJ_BODY,
        parent=m.body_parentid,
        pos=m.body_pos,
        quat=m.body_quat,
        mass=m.body_mass,
        com=m.body_ipos,
        axes=m.body_iquat,
        inertia=m.body_inertia,
        compensated=m.body_gravcomp,
        mocap=m.body_mocapid,
    )
    sites = rows(m.nsite, objects.mjOBJ_SITE, body=m.site_bodyid, pos=m.site_pos, quat=m.site_quat)
    equalities = rows(
        m.neq,
        objects.mjOBJ_EQUALITY,
        type=m.eq_type,
        first=m.eq_obj1id,
        second=m.eq_obj2id,
        of_sites=m.eq_objtype == objects.mjOBJ_SITE,
        active=m.eq_active0,
        data=m.eq_data,
    )
    for equality in equalities:
        equality["type"] = EQUALITIES[equality["type"]]
    transmission = mujoco.mjtTrn
    actuators = rows(
        m.nu,
        objects.mjOBJ_ACTUATOR,
        joint=m.actuator_trnid[:, 0],
        gear=m.actuator_gear[:, 0],
        force_limited=m.actuator_forcelimited,
        force=m.actuator_forcerange,
        input_limited=m.actuator_ctrllimited,
        input=m.actuator_ctrlrange,
        gain=m.actuator_gainprm[:, 0],
        bias=m.actuator_biastype,
        gain_type=m.actuator_gaintype,
        transmission=m.actuator_trntype,
        armature=getattr(m, "actuator_armature", [0.0] * m.nu),
    )
    direct = (int(transmission.mjTRN_JOINT), int(transmission.mjTRN_JOINTINPARENT))
    for actuator in actuators:
        actuator["transmission"] = "joint" if actuator["transmission"] in direct else "other"
        actuator["direct"] = not (actuator.pop("bias") or actuator.pop("gain_type"))
    flags = m.opt.disableflags
    named = m.names[: m.names.index(b"\0")].decode(errors="replace")
    return {
        "name": named if named != "MuJoCo Model" else "",
        "gravity": [0.0] * 3
        if flags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
        else m.opt.gravity.tolist(),
        "bodies": bodies,
        "joints": joints,
        "sites": sites,
        "equalities": equalities,
        "actuators": actuators,
        "left_out": {
            "what tendons pull": m.ntendon,
            "what is flexible": m.nflex,
            "a fluid": int(m.opt.density > 0 or m.opt.viscosity > 0),
        },
    }


def main():
    import mujoco as library

    mujoco: Any = library
    try:
        if len(sys.argv) > 1:
            model = mujoco.MjModel.from_xml_path(sys.argv[1])
        else:
            model = mujoco.MjModel.from_xml_string(sys.stdin.read())
    except Exception as problem:
        json.dump({"problem": str(problem)}, sys.stdout)
        return
    json.dump(compiled(model, mujoco), sys.stdout)


if __name__ == "__main__":
    main()
