"""The study as files: NetCDF with everything, CSV tables for what people open in a spreadsheet."""

from __future__ import annotations

import csv
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.errors import FileError
from freebody.motion.ranges import position_columns
from freebody.report.facts import facts

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.study import Study

_DRIVES = (
    "tau",
    "tau_inertial",
    "tau_coriolis",
    "tau_gravity",
    "tau_friction",
    "tau_springs",
    "tau_rotors",
    "power",
)


def save(study: Study, directory: Path) -> list[Path]:
    """Write study.nc, motion.csv, torques.csv, reactions.csv, summary.csv, reactions_summary.csv and checks.csv."""
    try:
        directory.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise FileError(directory, None, "there is a file of that name; name a folder with --out.") from None
    except OSError as failure:
        raise FileError(directory, None, f"cannot be made: {failure.strerror}.") from None
    writers = {
        "study.nc": lambda path: _netcdf(study, path),
        "motion.csv": lambda path: _write(path, *_motion(study)),
        "torques.csv": lambda path: _write(path, *_torques(study)),
        "reactions.csv": lambda path: _write(path, *_reactions(study)),
        "summary.csv": lambda path: _write(path, *_table(study.summary, "coordinate")),
        "reactions_summary.csv": lambda path: _write(path, *_table(study.summary, "joint")),
        "checks.csv": lambda path: _write(path, *_checks(study)),
    }
    written = []
    for name, write in writers.items():
        path = directory / name
        try:
            write(path)
        except OSError as failure:
            raise FileError(path, None, f"cannot be written: {failure.strerror or failure}.") from None
        written.append(path)
    return written


def dataset(study: Study) -> xr.Dataset:
    """Time series, summary and facts in one dataset, with what the checks found as attributes."""
    import xarray as xr

    whole = xr.merge(
        [study.data, study.summary, facts(study)], compat="no_conflicts", combine_attrs="drop_conflicts"
    )
    whole.attrs.update(study.data.attrs)
    whole.attrs["notices"] = "\n".join(study.notices)
    for check in study.checks:
        verdict = "passed" if check.passed else "FAILED"
        whole.attrs[f"check_{check.name}".replace(" ", "_")] = (
            f"{check.value:.3g} <= {check.bar:.3g}: {verdict}"
        )
    replay = study.replay
    if replay is not None:
        whole["replay_edge"] = (
            "edge",
            replay.edges,
            {"units": "s", "long_name": "where pieces of the replay meet"},
        )
        whole["replay_factor"] = (
            "piece",
            replay.factors,
            {"units": "1", "long_name": "amplification in the piece"},
        )
        whole["replay_miss"] = (
            "piece",
            replay.misses,
            {"units": "1", "long_name": "miss over the joint range"},
        )
        whole["drift"] = (
            ("drift_time", "coordinate"),
            replay.drift,
            {"units": "rad|m", "long_name": "distance from the motion, open loop"},
        )
        whole = whole.assign_coords(drift_time=("drift_time", replay.drift_time, {"units": "s"}))
    for pose in study.static:
        whole.attrs[f"worst_pose_{pose.coordinate}"] = ", ".join(f"{x:.6g}" for x in pose.q)
    return whole


def _netcdf(study: Study, path: Path) -> None:
    dataset(study).to_netcdf(path, engine="scipy")  # NetCDF 3: read everywhere, written without HDF5


def _write(path: Path, header: list[str], rows: Iterable[Iterable[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows([_cell(value) for value in row] for row in rows)


def _cell(value: Any) -> Any:
    if isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, float | np.floating):
        return "" if np.isnan(value) else repr(float(value))
    return value


def _motion(study: Study) -> tuple[list[str], np.ndarray]:
    """The motion as the command reads it: positions, and rates and accelerations where they have a column."""
    model, motion = study.model, study.motion
    iq, iv = position_columns(model)
    names = [model.position_names[k] for k in iq]
    header = ["t", *model.position_names, *(f"{n}.v" for n in names), *(f"{n}.a" for n in names)]
    return header, np.column_stack([motion.t, motion.q, motion.qd[:, iv], motion.qdd[:, iv]])


def _torques(study: Study) -> tuple[list[str], np.ndarray]:
    data = study.data
    header, columns = ["t (s)"], [study.motion.t]
    for k, name in enumerate(study.model.velocity_names):
        unit = str(data["effort_unit"].values[k])
        for variable in _DRIVES:
            header.append(f"{name} {variable} ({'W' if variable == 'power' else unit})")
            columns.append(data[variable].values[:, k])
    return header, np.column_stack(columns)


def _reactions(study: Study) -> tuple[list[str], np.ndarray]:
    """World axes."""
    data = study.data
    header, columns = ["t (s)"], [study.motion.t]
    for k, joint in enumerate(study.model.reaction_names):
        for variable, dim, letter, unit in (
            ("reaction_force", "axis", "F", "N"),
            ("reaction_moment", "moment_axis", "M", "N m"),
        ):
            for i, axis in enumerate(data[dim].values):
                header.append(f"{joint} {letter}{axis} ({unit})")
                columns.append(data[variable].values[:, k, i])
    return header, np.column_stack(columns)


def _table(summary: xr.Dataset, dim: str) -> tuple[list[str], list[list[Any]]]:
    names = [str(name) for name in summary.data_vars if summary[name].dims == (dim,)]
    extra = ["unit", "effort_unit"] if dim == "coordinate" else []
    header = [dim, *extra, *(f"{name} ({summary[name].attrs['units']})" for name in names)]
    labels = summary[dim].values
    return header, [
        [
            str(label),
            *(str(summary[e].values[k]) for e in extra),
            *(summary[name].values[k] for name in names),
        ]
        for k, label in enumerate(labels)
    ]


def _checks(study: Study) -> tuple[list[str], list[list[Any]]]:
    return ["check", "value", "bar", "passed", "what"], [
        [check.name, check.value, check.bar, check.passed, check.text] for check in study.checks
    ]
