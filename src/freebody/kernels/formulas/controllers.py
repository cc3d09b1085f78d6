"""Control laws and observers: a record each. What one remembers is an input and an output."""

from __future__ import annotations

from typing import Any

from freebody.algorithms.controllers.admittance import admittance
from freebody.algorithms.controllers.computed_torque import computed_torque
from freebody.algorithms.controllers.impedance import impedance
from freebody.algorithms.controllers.momentum_observer import momentum_observer
from freebody.algorithms.controllers.operational_space_control import operational_space_control
from freebody.algorithms.controllers.pd_gravity import pd_gravity
from freebody.kernels.formulas.record import Formula, Option, Output, frame_of, one
from freebody.model.doubt_rules.aspects import MASSES
from freebody.model.tree import Tree

_TORQUE = one("tau", ("nv",), "torques and forces of the drives (N m, N)")


def _operational(tree: Tree, o: Option, **inputs: Any) -> tuple[Any, ...]:
    return (operational_space_control(tree, frame_of(o), o.rows, **inputs),)


FORMULAS = {
    "pd_gravity": Formula(
        ("q", "qd", "q_ref", "kp", "kd"),
        _TORQUE,
        lambda t, o, **inputs: (pd_gravity(t, **inputs),),
        chains="open",
        touches=(MASSES,),
    ),
    "computed_torque": Formula(
        ("q", "qd", "q_ref", "qd_ref", "qdd_ref", "kp", "kd"),
        _TORQUE,
        lambda t, o, **inputs: (computed_torque(t, **inputs),),
        chains="open",
    ),
    "operational_space_control": Formula(
        ("q", "qd", "pose_ref", "V_ref", "A_ref", "kp_task", "kd_task", "tau_null"),
        _TORQUE,
        _operational,
        of_frame=True,
        of_rows=True,
        chains="open",
        cannot_take=frozenset(("losses",)),
    ),
    "impedance": Formula(
        ("q", "qd", "pose_ref", "V_ref", "stiffness", "damping"),
        _TORQUE,
        lambda t, o, **inputs: (impedance(t, frame_of(o), o.rows, **inputs),),
        of_frame=True,
        of_rows=True,
        chains="open",
        touches=(MASSES,),
    ),
    "admittance": Formula(
        ("h", "offset", "offset_rate", "w_ext", "inertia", "stiffness", "damping"),
        {
            "offset1": Output(("rows",), "displacement h later (m, rad)"),
            "offset_rate1": Output(("rows",), "its rate (m/s, rad/s)"),
        },
        lambda t, o, **inputs: admittance(**inputs),
        of_rows=True,
        touches=(),
    ),
    "momentum_observer": Formula(
        ("q", "qd", "tau", "h", "integral", "ko"),
        {
            "r": Output(("nv",), "torque that acts besides tau, low-pass filtered (N m, N)"),
            "integral1": Output(("nv",), "integral for the next call (kg m^2/s, kg m/s)"),
        },
        lambda t, o, **inputs: momentum_observer(t, **inputs),
        chains="open",
        cannot_take=frozenset(("losses",)),
    ),
}
