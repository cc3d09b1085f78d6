"""What a report prints besides time series and summary, as a dataset: masses, limits, worst poses,
checks."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from freebody.figures.skeleton import mass_and_centre
from freebody.motion.ranges import ranges
from freebody.report.variables import dataset

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.study import Study


def facts(study: Study) -> xr.Dataset:
    """Of bodies mass, centre and weight; of coordinates limits (infinite without) and the worst
    pose, NaN where gravity loads nothing; value and bar of each check."""
    model = study.model
    bodies = [model.tree.bodies[at] for at in model.tree.body_of]
    masses, centres = zip(
        *(mass_and_centre(body.masses, model.dim) for body in bodies), strict=True
    )
    allowed = ranges(model)
    worst = {pose.coordinate: pose for pose in study.static}
    found = [worst.get(name) for name in model.velocity_names]
    values = {
        "body_mass": masses,
        "body_com_local": centres,
        "body_weight": np.outer(masses, model.gravity),
        "lower_limit": allowed.lower,
        "upper_limit": allowed.upper,
        "velocity_limit": allowed.velocity,
        "effort_limit": allowed.effort,
        "worst_gravity_torque": [p.torque if p else np.nan for p in found],
        "worst_gravity_fraction": [p.fraction if p else np.nan for p in found],
        "worst_gravity_pose": [p.q if p else np.full(model.nq, np.nan) for p in found],
        "check_value": [c.value for c in study.checks],
        "check_bar": [c.bar for c in study.checks],
        "check_passed": [c.passed for c in study.checks],
    }
    axes = ("body", "coordinate", "position", "axis")
    named = {name: list(study.data[name].values) for name in axes}
    named["check"] = [c.name for c in study.checks]
    return dataset(values, named, estimated=", estimated" if model.is_estimated else "")
