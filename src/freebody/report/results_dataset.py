"""What a report prints besides time series and summary, as a dataset: masses, limits, worst poses,
checks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from freebody.motion.ranges import ranges

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.study import Study


def facts(study: Study) -> xr.Dataset:
    """(body,): body_mass. (body, axis): body_com_local, body_weight. (coordinate,): lower_limit,
    upper_limit, velocity_limit, effort_limit (infinite without), worst_gravity_torque,
    worst_gravity_fraction and (coordinate, position): worst_gravity_pose, NaN where gravity loads
    nothing. (check,): check_value, check_bar, check_passed (1 or 0)."""
    import xarray as xr

    model, axes = study.model, list(study.data["axis"].values)
    masses, centres = _inertias(study)
    allowed = ranges(model)
    worst = {pose.coordinate: pose for pose in study.static}
    found = [worst.get(name) for name in model.velocity_names]
    poses = np.array([p.q if p else np.full(model.nq, np.nan) for p in found])
    body, joint, check = ("body",), ("coordinate",), ("check",)
    rows = {
        "body_mass": (
            body,
            masses,
            "kg",
            f"mass of the body{', estimated' if model.is_estimated else ''}",
        ),
        "body_com_local": (
            ("body", "axis"),
            centres,
            "m",
            "centre of mass from the joint, the body's axes at its joint",
        ),
        "body_weight": (
            ("body", "axis"),
            masses[:, None] * model.gravity,
            "N",
            "weight, world axes",
        ),
        "lower_limit": (joint, allowed.lower, "rad|m", "lower limit of the position"),
        "upper_limit": (joint, allowed.upper, "rad|m", "upper limit of the position"),
        "velocity_limit": (joint, allowed.velocity, "rad/s|m/s", "speed limit"),
        "effort_limit": (joint, allowed.effort, "N m|N", "effort limit"),
        "worst_gravity_torque": (
            joint,
            [p.torque if p else np.nan for p in found],
            "N m|N",
            "gravity load in the worst pose",
        ),
        "worst_gravity_fraction": (
            joint,
            [p.fraction if p else np.nan for p in found],
            "1",
            "the same over the effort limit",
        ),
        "worst_gravity_pose": (
            ("coordinate", "position"),
            poses,
            "rad|m|1",
            "pose of the largest gravity load",
        ),
        "check_value": (check, [c.value for c in study.checks], "1", "value of the check"),
        "check_bar": (check, [c.bar for c in study.checks], "1", "largest value that passes"),
        "check_passed": (
            check,
            [c.passed for c in study.checks],
            "1",
            "1 if the check passed, else 0",
        ),
    }
    return xr.Dataset(
        {
            name: (dims, np.asarray(x, dtype=float), {"units": u, "long_name": text})
            for name, (dims, x, u, text) in rows.items()
        },
        {
            "body": [b.name for b in model.bodies],
            "coordinate": list(model.velocity_names),
            "position": list(model.position_names),
            "axis": axes,
            "check": [c.name for c in study.checks],
        },
    )


def _inertias(study: Study) -> tuple[np.ndarray, np.ndarray]:
    """Masses (bodies,) and centres of mass (bodies, dim), in the bodies' axes."""
    model = study.model
    masses, centres = np.zeros(len(model.bodies)), np.zeros((len(model.bodies), model.dim))
    for k, at in enumerate(model.tree.body_of):
        parts = model.tree.bodies[at].masses
        masses[k] = sum(float(part.m) for part in parts)
        if masses[k]:
            centres[k] = (
                sum(float(part.m) * np.asarray(part.c, dtype=float) for part in parts) / masses[k]
            )
    return masses, centres
