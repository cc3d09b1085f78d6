"""How to call each public function that takes a model and vectors; a new one has to be added
here."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any

import numpy as np

import freebody as fb

NOT_OF_STATES = frozenset(
    {
        "arc",
        "base_parameters",
        "bearing_loads",
        "blend",
        "calibrate",
        "check",
        "default_motion",
        "derive",
        "detect_collisions",
        "drive_loads",
        "dwell",
        "emergency_stops",
        "equations",
        "exceeded_limits",
        "excitation",
        "export_fmu",
        "floor_loads",
        "formula",
        "identify",
        "identify_payload",
        "inertial_parameters",
        "kernel",
        "line",
        "loop_equations",
        "losses",
        "notes_figure",
        "load_diagram",
        "load_table",
        "parameters",
        "payload",
        "quantities",
        "quintic",
        "read_motion",
        "read_poses",
        "read_waypoints",
        "relation",
        "s_curve",
        "save",
        "singularities",
        "size",
        "singularity_diagram",
        "singularity_loci",
        "smoothed",
        "source",
        "spline",
        "study",
        "sweep",
        "time_optimal",
        "to_jax",
        "trapezoid",
        "ellipsoid_diagram",
        "map_diagram",
        "workspace",
        "write_motion",
    }
)
"""Public functions of a model that take no vector of its coordinates, or several in a row."""

LONG = frozenset({"assembly_modes", "simulate"})
DRAWINGS = frozenset({"free_body_diagram", "kinematic_diagram"})

VECTORS = {  # which vector of a state an argument takes
    "q": "q", "q0": "q", "q1": "q1", "qd": "qd", "qdd": "qdd", "tau": "tau", "v": "qd",
    "rates": "qd",
    "accelerations": "qdd", "V": "V", "A": "V", "target": "pose", "t": "t",
    "q_ref": "q1", "qd_ref": "qd", "qdd_ref": "qdd", "kp": "gain", "kd": "gain", "ko": "gain",
    "integral": "tau", "h": "h", "pose_ref": "pose",
    **dict.fromkeys(("V_ref", "A_ref", "offset", "offset_rate", "w_ext"), "V"),
    **dict.fromkeys(("kp_task", "kd_task", "inertia", "stiffness", "damping"), "V"),
}  # fmt: skip

NAMED = {
    "random_state": {"seed": "seed"},
    "reactions": {"qdd": "qdd"},
    "free_body_diagram": {"qd": "qd", "qdd": "qdd"},
    "kinematic_diagram": {"q": "q"},
    **{name: {"stiffness": "gain"} for name in ("deflection", "natural_frequencies")},
}
"""Arguments beyond those without default."""


def public_calls() -> dict[str, Callable[..., Any]]:
    """For each public function of a state: call(model, state) -> result."""
    return {name: _call(getattr(fb, name), arguments(name)) for name in functions_of_states()}


def functions_of_states() -> list[str]:
    """Names of public functions whose first argument is a model and which are not said to take no
    vector."""
    return [
        name
        for name in fb.__all__
        if inspect.isfunction(function := getattr(fb, name))
        and next(iter(inspect.signature(function).parameters), "") == "model"
        and name not in NOT_OF_STATES
    ]


def arguments(name: str) -> dict[str, str]:
    """Argument -> vector of the state, of all that have no default and of some that have."""
    parameters = inspect.signature(getattr(fb, name)).parameters.values()
    needed = {p.name for p in parameters if p.default is p.empty} - {"model"}
    unknown = needed - set(VECTORS)
    assert not unknown, (
        f"say in tests/support/public_calls.py which vectors fb.{name} takes: {unknown}"
    )
    return {p.name: VECTORS[p.name] for p in parameters if p.name in needed} | NAMED.get(name, {})


def _call(function: Callable[..., Any], taken: dict[str, str]) -> Callable[..., Any]:
    return lambda model, state: function(model, **{name: state[key] for name, key in taken.items()})


def state(model: fb.Model, seed: int, batch: tuple[int, ...] = ()) -> dict[str, Any]:
    """Vectors of a state, closed and at rest where the model has loops."""
    q, qd, qdd = fb.random_state(model, seed, batch)
    if model.loops:
        q = np.broadcast_to(fb.assemble(model), q.shape).copy()
        qd, qdd = np.zeros_like(qd), np.zeros_like(qdd)
    V = np.full((*batch, 6 if model.dim == 3 else 3), 0.1)
    pose = fb.forward_kinematics(model, q) if model.tip else np.eye(model.dim + 1)
    return {
        "q": q, "qd": qd, "qdd": qdd, "tau": qdd + 1.0, "V": V, "pose": pose,
        "t": np.linspace(0.0, 0.01, 3), "seed": 7, "h": np.full(batch, 0.01),
        "gain": 0.1 + np.abs(qd),
        "q1": q[..., ::-1] * 0.5 if model.nq == model.nv else q,
    }  # fmt: skip


def bits(value: Any) -> Any:
    """All bits of a result, as something that compares."""
    if isinstance(value, (np.ndarray, float)):
        return np.shape(value), np.asarray(value).tobytes()
    if hasattr(value, "__dataclass_fields__"):
        return tuple(
            (name, bits(getattr(value, name)))
            for name in value.__dataclass_fields__
            if name != "model"
        )
    if isinstance(value, (tuple, list)):
        return tuple(map(bits, value))
    if hasattr(value, "data_vars"):
        return tuple((name, bits(array.values)) for name, array in value.data_vars.items())
    return repr(value) if not isinstance(value, fb.Model) else value.name
