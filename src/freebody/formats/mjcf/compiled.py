"""A separate program in which MuJoCo parses and compiles a file, and which prints the numbers that
freebody reads as JSON.

MuJoCo is written in C, and a broken file can end its process: that is not to be the user's. Run as
`python compiled.py FILE`, or without a file with the text on standard input. It imports nothing of
freebody.
"""

import json
import math
import sys
from typing import Any

KINDS = ("free", "ball", "slide", "hinge")
_BYTES = 16 << 30
ONE_POINT = 1e-9
"""m between points that are one."""
SOLIDS = ("sphere", "capsule", "ellipsoid", "cylinder", "box")
SHOWN = 3
"""Groups of geoms that MuJoCo's viewer shows when it opens: 0, 1, 2."""
LINES = [(a, b, c) for a in (0, 1) for b in (-1, 0, 1) for c in (-1, 0, 1) if (a, b, c) > (0, 0, 0)]
"""Directions to the faces, edges and corners of a cube from its middle, one of each two opposite
ones."""
EQUALITIES = ("connect", "weld", "joint", "tendon", "flex", "distance")


def compiled(model, mujoco):
    """The parts of a compiled model, each as a dict of names, numbers and lists."""
    named = model.names[: model.names.index(b"\0")].decode(errors="replace")
    weightless = model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY
    return {
        "name": named if named != "MuJoCo Model" else "",
        "gravity": [0.0] * 3 if weightless else model.opt.gravity.tolist(),
        "bodies": bodies(model, mujoco),
        "joints": joints(model, mujoco),
        "sites": sites(model, mujoco),
        "geoms": geoms(model, mujoco),
        "equalities": equalities(model, mujoco),
        "actuators": actuators(model, mujoco),
        "tendons": tendons(model, mujoco),
        "left_out": {
            "what is flexible": model.nflex,
            "a fluid": int(model.opt.density > 0 or model.opt.viscosity > 0),
        },
    }


def rows(model, mujoco, kind, count, **columns):
    """A dict for each of the parts of a kind: its name, and its entry of each column."""
    of = getattr(mujoco.mjtObj, f"mjOBJ_{kind}")
    return [
        {
            "name": mujoco.mj_id2name(model, of, i) or "",
            **{
                key: column[i].tolist() if hasattr(column[i], "tolist") else column[i]
                for key, column in columns.items()
            },
        }
        for i in range(count)
    ]


def source_of(path, text, mujoco):
    """The source, an MjSpec, of a model in a file or else in a text; None of a file whose suffix it
    does not know, other than .xml."""
    try:
        return (
            mujoco.MjSpec.from_file(path) if path is not None else mujoco.MjSpec.from_string(text)
        )
    except ValueError:
        return None


def filled(source, m, mujoco):
    """Whether the inertia of each body is that of its geoms, by the source of the model; nowhere
    where there is none."""
    given = source.bodies if source else []
    names = [mujoco.mj_id2name(m, mujoco.mjtObj.mjOBJ_BODY, i) or "" for i in range(m.nbody)]
    if [body.name for body in given] != names:
        return [False] * m.nbody
    rule, by = source.compiler.inertiafromgeom, mujoco.mjtInertiaFromGeom
    if rule != by.mjINERTIAFROMGEOM_AUTO:
        return [rule == by.mjINERTIAFROMGEOM_TRUE] * m.nbody
    return [not body.explicitinertial for body in given]


def bodies(m, mujoco):
    """Each body's parent, pose in it, and inertia in principal axes."""
    return rows(
        m,
        mujoco,
        "BODY",
        m.nbody,
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


def joints(m, mujoco):
    """Each joint's body, kind, axis, limits, and what acts on it."""
    dofs, no_powers = m.jnt_dofadr, [[0.0, 0.0]] * m.njnt
    return rows(
        m,
        mujoco,
        "JOINT",
        m.njnt,
        body=m.jnt_bodyid,
        type=[KINDS[kind] for kind in m.jnt_type],
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


def sites(m, mujoco):
    """Each site's body and pose there."""
    return rows(m, mujoco, "SITE", m.nsite, body=m.site_bodyid, pos=m.site_pos, quat=m.site_quat)


def geoms(m, mujoco):
    """Each geom's body and pose there, its form, half sizes (m), the outermost points of a mesh
    (m), and whether it is seen in MuJoCo's viewer as that opens."""
    kinds = mujoco.mjtGeom
    names = {int(getattr(kinds, f"mjGEOM_{x.upper()}")): x for x in SOLIDS}
    mesh, seen, points = int(kinds.mjGEOM_MESH), {}, []
    for kind, data in zip(m.geom_type.tolist(), m.geom_dataid.tolist(), strict=True):
        if kind == mesh and data >= 0 and data not in seen:
            start = m.mesh_vertadr[data]
            corners = m.mesh_vert[start : start + m.mesh_vertnum[data]]
            seen[data] = outermost(corners.astype(float)).tolist()
        points.append(seen[data] if kind == mesh and data >= 0 else [])
    return rows(
        m,
        mujoco,
        "GEOM",
        m.ngeom,
        body=m.geom_bodyid,
        type=[names.get(kind, "mesh" if kind == mesh else "other") for kind in m.geom_type],
        size=m.geom_size,
        pos=m.geom_pos,
        quat=m.geom_quat,
        seen=[bool(x) for x in (m.geom_group < SHOWN) & (m.geom_rgba[:, 3] > 0.0)],
        points=points,
    )


def outermost(points):
    """The points, of some (n, 3), that lie farthest out in fixed directions, each once: the hull
    of these is nearly that of all."""
    x, y, z = points.T
    found = set()
    for a, b, c in LINES:
        far = a * x + b * y + c * z  # sums alone, which are rounded alike everywhere
        found |= {int(far.argmin()), int(far.argmax())}
    return points[sorted(found)]


def equalities(m, mujoco):
    """The equality constraints: their kind, the two objects that each joins, its numbers."""
    return rows(
        m,
        mujoco,
        "EQUALITY",
        m.neq,
        type=[EQUALITIES[kind] for kind in m.eq_type],
        first=m.eq_obj1id,
        second=m.eq_obj2id,
        of_sites=m.eq_objtype == mujoco.mjtObj.mjOBJ_SITE,
        active=m.eq_active0,
        data=m.eq_data,
    )


def actuators(m, mujoco):
    """The actuators: the joint that each drives, its limits, whether its input is a force."""
    found = rows(
        m,
        mujoco,
        "ACTUATOR",
        m.nu,
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
    at_joints = (mujoco.mjtTrn.mjTRN_JOINT, mujoco.mjtTrn.mjTRN_JOINTINPARENT)
    for actuator in found:
        direct = actuator["transmission"] in map(int, at_joints)
        actuator["transmission"] = "joint" if direct else "other"
        actuator["direct"] = not (actuator.pop("bias") or actuator.pop("gain_type"))
    return found


def tendons(m, mujoco):
    """Each tendon's spring and damper; the two sites between which it runs, none of one that runs
    otherwise, and whether these are at one point; the joints that a fixed one adds up, with their
    factors; and whether it has limits of its length, and anything more."""
    found = rows(
        m,
        mujoco,
        "TENDON",
        m.ntendon,
        start=m.tendon_adr,
        points=m.tendon_num,
        stiffness=m.tendon_stiffness,
        damping=m.tendon_damping,
        rest=m.tendon_lengthspring,
        limited=m.tendon_limited,
    )
    # partly in later versions alone
    keys = ("actfrclimited", "frictionloss", "armature", "stiffnesspoly", "dampingpoly")
    more = [getattr(m, f"tendon_{key}") for key in keys if hasattr(m, f"tendon_{key}")]
    site, joint = mujoco.mjtWrap.mjWRAP_SITE, mujoco.mjtWrap.mjWRAP_JOINT
    for i, tendon in enumerate(found):
        start, points = tendon.pop("start"), tendon.pop("points")
        through = range(start, start + points)
        straight = points == 2 and all(m.wrap_type[k] == site for k in through)
        tendon["ends"] = [int(m.wrap_objid[k]) for k in through] if straight else []
        tendon["joints"] = [
            [int(m.wrap_objid[k]), float(m.wrap_prm[k])] for k in through if m.wrap_type[k] == joint
        ]
        tendon["more"] = any(bool(x[i].any()) for x in more)
    points = sites_anywhere(m, mujoco) if any(tendon["ends"] for tendon in found) else None
    for tendon in found:
        ends = tendon["ends"]
        apart = 1.0 if points is None or not ends else abs(points[ends[0]] - points[ends[1]]).max()
        tendon["is_point"] = bool(apart <= ONE_POINT)
    return found


def sites_anywhere(m, mujoco):
    """The positions of all sites where all coordinates are some irrational numbers, which no
    mechanism singles out."""
    data = mujoco.MjData(m)
    data.qpos[:] = [math.sqrt(2.0 + 3.0 * k) for k in range(m.nq)]
    mujoco.mj_kinematics(m, data)
    return data.site_xpos


def answer(path, text):
    """The parts of the model in a file, or in a text where the path is None; or the problem that
    MuJoCo has with it."""
    import mujoco as library

    mujoco: Any = library
    try:
        if path is not None:
            model = mujoco.MjModel.from_xml_path(path)
        else:
            model = mujoco.MjModel.from_xml_string(text)
    except Exception as problem:
        return {"problem": str(problem)}
    found = compiled(model, mujoco)
    told = filled(source_of(path, text, mujoco), model, mujoco)
    for body, value in zip(found["bodies"], told, strict=True):
        body["filled"] = value
    return found


def bound_memory():
    """Bound what this process may allocate, where the system can: a file may ask for a texture of
    any size."""
    try:
        import resource
    except ImportError:  # Windows
        return
    _, most = resource.getrlimit(resource.RLIMIT_AS)
    bound = _BYTES if most == resource.RLIM_INFINITY else min(most, _BYTES)
    resource.setrlimit(resource.RLIMIT_AS, (bound, most))


def main():
    bound_memory()
    path = sys.argv[1] if len(sys.argv) > 1 else None
    json.dump(answer(path, None if path else sys.stdin.read()), sys.stdout)


if __name__ == "__main__":
    main()
