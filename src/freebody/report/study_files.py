"""The study as files: NetCDF with everything, CSV tables for what people open in a spreadsheet."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

import freebody
from freebody.lazy import by_field
from freebody.model.doubts import attribute
from freebody.motion.files.csv_files import motion_table
from freebody.outputs.folder import Makers, write_folder
from freebody.outputs.harmless_text import csv_text, encodable
from freebody.report import variables
from freebody.report.cycle_page import cycle_page
from freebody.report.load_case import load_case
from freebody.report.page import page
from freebody.report.page_tables import facts

if TYPE_CHECKING:
    import xarray as xr

    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study import Study

DATA, CARD, REPORT, CYCLE = "study.nc", "card.json", "report.html", "cycle.nc"

_HeadAndRows = tuple[list[str], Iterable[Iterable[Any]]]
"""Header and rows of a table."""

_DRIVES = ("tau", "tau_measured", *variables.PARTS, "power")


def save(study: Study, directory: Path, report: bool) -> list[Path]:
    """The paths of the files of a study that are written, the manifest's last."""
    about = {
        "freebody": freebody.__version__,
        "robot": study.model.name,
        "motion": study.motion.source,
        **load_case(study.model, study.wrenches, study.speed, study.parts.words),
        **({"command": study.command} if study.command else {}),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "verdict": study.verdict.text,
        **attribute(study.model.doubts),
    }
    return write_folder(directory, makers(study, report), about)


def save_cycle(study: CycleStudy, directory: Path, report: bool) -> list[Path]:
    """The paths of the files of the study of a duty cycle that are written: of each segment into a
    folder of its own, then of the whole, the manifest's last."""
    written = []
    for k, segment in enumerate(study.segments, 1):
        named = replace(segment, command=study.command)
        written += save(named, directory / f"segment-{k}", report)
    about = {
        "freebody": freebody.__version__,
        "robot": study.model.name,
        "cycle": study.cycle.source,
        **({"command": study.command} if study.command else {}),
        "written": datetime.now(UTC).isoformat(timespec="seconds"),
        "verdict": study.verdict.text,
    }
    made: dict[str, Callable[[], str | bytes]] = {
        CYCLE: lambda: bytes(_encodable(study.summary.copy()).to_netcdf(engine="scipy")),
        "summary.csv": partial(_csv, lambda: _summary(study.summary, "coordinate")),
        CARD: lambda: cycle_card_text(study),
    }
    if report:
        made[REPORT] = lambda: cycle_page(study)
    return [*written, *write_folder(directory, made, about)]


def makers(study: Study, report: bool) -> Makers:
    """Functions that make the files of a study: study.nc, motion.csv, torques.csv, reactions.csv,
    summary.csv, reactions_summary.csv, checks.csv, card.json, and report.html if asked for."""
    tables: dict[str, Callable[[], _HeadAndRows]] = {
        "motion.csv": lambda: motion_table(study.model, study.motion),
        "torques.csv": lambda: _torques(study),
        "reactions.csv": lambda: _reactions(study),
        "summary.csv": lambda: _summary(study.summary, "coordinate"),
        "reactions_summary.csv": lambda: _summary(study.summary, "joint"),
        "checks.csv": lambda: _checks(study),
    }
    made: dict[str, Callable[[], str | bytes]] = {DATA: lambda: netcdf(study)}
    made |= {name: partial(_csv, table) for name, table in tables.items()}
    made[CARD] = lambda: card_text(study)
    return made | ({REPORT: lambda: page(study)} if report else {})


def dataset(study: Study) -> xr.Dataset:
    """The time series, summary and facts of a study in one dataset."""
    import xarray as xr

    whole = xr.merge(
        [study.data, study.summary, facts(study)],
        compat="no_conflicts",
        combine_attrs="drop_conflicts",
    )
    whole.attrs.update(study.data.attrs | study.summary.attrs)
    whole.attrs["verdict"] = study.verdict.text
    whole.attrs["notices"] = "\n".join(study.notices)
    replay = study.replay
    if replay is not None:
        found = {
            "replay_edge": replay.edges,
            "replay_factor": replay.factors,
            "replay_miss": replay.misses,
            "drift": replay.drift,
        }
        times = {"drift_time": ("drift_time", replay.drift_time, {"units": "s"})}
        whole.update(variables.dataset(found, times))
    return whole


def cycle_card_text(study: CycleStudy) -> str:
    """Verdict, card and load cases of a duty cycle as JSON, as of `card_text`."""
    cases = {"load_cases": [by_field(case) for case in study.load_cases]}
    return _verdict_and_card(study, cases, study.card.rows)


def card_text(study: Study) -> str:
    """Verdict, card and load case as JSON: numbers in SI units, null where one is not known or has
    no end, and the rows of both as texts."""
    rows = [*study.card.rows, *study.load_case.rows]
    return _verdict_and_card(study, {"load_case": by_field(study.load_case)}, rows)


def _verdict_and_card(study: Study | CycleStudy, cases: dict[str, Any], rows: Any) -> str:
    """Verdict and card of a study, with its load cases by name and rows of text, as JSON."""
    told = {
        "robot": study.model.name,
        "verdict": {"outcome": study.verdict.outcome, "reason": study.verdict.reason},
        "card": by_field(study.card),
        **cases,
        "rows": rows,
    }
    return json.dumps(_plain(told), indent=1) + "\n"


def _plain(value: Any) -> Any:
    """A value as JSON has it."""
    if isinstance(value, Mapping):
        return {key: _plain(x) for key, x in value.items()}
    if isinstance(value, np.ndarray | list | tuple):
        return [_plain(x) for x in value]
    if dataclasses.is_dataclass(value):
        return _plain(by_field(value))
    return None if isinstance(value, float) and not math.isfinite(value) else value


def netcdf(study: Study) -> bytes:
    """The dataset as NetCDF 3: read everywhere, written without HDF5.

    Names of joints stand in it as values, never as names of its own, which could not hold all of
    them.
    """
    return bytes(_encodable(dataset(study)).to_netcdf(engine="scipy"))


def _encodable(whole: xr.Dataset) -> xr.Dataset:
    for held in (whole, *whole.variables.values()):
        held.attrs = {k: encodable(v) if isinstance(v, str) else v for k, v in held.attrs.items()}
    labels = {
        name: (labelled.dims, [encodable(str(label)) for label in labelled.values])
        for name, labelled in whole.coords.items()
        if labelled.dtype.kind in "UO"
    }
    return whole.assign_coords(labels)


def _csv(table: Callable[[], _HeadAndRows]) -> str:
    header, rows = table()
    return csv_text([header, *rows])


def _torques(study: Study) -> _HeadAndRows:
    data = study.data
    header, columns = ["t (s)"], [study.motion.t]
    for k, name in enumerate(study.model.velocity_names):
        unit = str(data["effort_unit"].values[k])
        for variable in (x for x in _DRIVES if x in data):
            header.append(f"{name} {variable} ({'W' if variable == 'power' else unit})")
            columns.append(data[variable].values[:, k])
    return header, np.column_stack(columns)


def _reactions(study: Study) -> _HeadAndRows:
    """Table of reactions.csv: force and moment of each joint and loop over time, world axes."""
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


def _summary(summary: xr.Dataset, dim: str) -> _HeadAndRows:
    names = [str(name) for name in summary.data_vars if summary[name].dims == (dim,)]
    extra = ["unit", "effort_unit"] if dim == "coordinate" else []
    header = [dim, *extra, *(f"{name} ({summary[name].attrs['units']})" for name in names)]
    words = [map(str, summary[name].values) for name in (dim, *extra)]
    return header, zip(*words, *(summary[name].values for name in names), strict=True)


def _checks(study: Study) -> _HeadAndRows:
    return ["check", "value", "bar", "passed", "what"], [
        [check.name, check.value, check.bar, check.passed, check.text] for check in study.checks
    ]
