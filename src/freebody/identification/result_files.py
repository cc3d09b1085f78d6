"""An identification or a calibration as files: the robot as TOML, the report as text, and all
numbers as JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from freebody.formats.writing import toml
from freebody.identification.calibration.calibration import Calibration
from freebody.identification.identification import Identification
from freebody.outputs.folder import write_folder

MODEL, REPORT = "model.toml", "report.txt"


def write_results(
    found: Identification, directory: str | os.PathLike[str], logs: Sequence[str]
) -> list[Path]:
    """The paths of the files of an identification in a folder: the robot, the report, the data; and
    the manifest. logs: names of those it was made from."""
    about = {"robot": found.model.name, "logs": ", ".join(map(str, logs))}
    return _written(found, directory, "identification.json", as_data(found), about)


def write_calibration(
    found: Calibration, directory: str | os.PathLike[str], poses: Sequence[str]
) -> list[Path]:
    """The paths of the files of a calibration in a folder: the robot, the report, the data; and the
    manifest. poses: names of the files it was made from."""
    about = {"robot": found.model.name, "poses": ", ".join(map(str, poses))}
    return _written(found, directory, "calibration.json", calibration_data(found), about)


def _written(
    found: Identification | Calibration,
    directory: str | os.PathLike[str],
    name: str,
    data: dict[str, Any],
    about: dict[str, str],
) -> list[Path]:
    makers = {
        MODEL: lambda: toml.written(found.model)[0],
        REPORT: lambda: "\n".join(found.lines()) + "\n",
        name: lambda: json.dumps(data, indent=1, ensure_ascii=False) + "\n",
    }
    return write_folder(directory, makers, about)


def as_data(found: Identification) -> dict[str, Any]:
    """The identification as numbers, texts, lists and dicts; what is not a number is null."""
    return plain(
        {
            "robot": found.model.name,
            "verdict": found.verdict,
            "outcome": found.outcome,
            "scale_known": found.scale_known,
            "notices": list(found.notices),
            "joints": [asdict(x) for x in found.joints],
            "gains": found.gains,
            "parameters": [
                asdict(x)
                | ({"combination": found.combination(x.name)} if x.kind == "inertial" else {})
                for x in found.parameters
            ],
            "prior_alone": list(found.prior_alone),
            "prior_weight": found.prior_weight,
        }
    )


def calibration_data(found: Calibration) -> dict[str, Any]:
    """The calibration as numbers, texts, lists and dicts."""
    errors = ("noise", "before", "after", "apart", "validation", "validation_before")
    return plain(
        {
            "robot": found.model.name,
            "frame": found.frame,
            "verdict": found.verdict,
            "outcome": found.outcome,
            "notices": list(found.notices),
            **{name: None if (x := getattr(found, name)) is None else asdict(x) for name in errors},
            "parameters": [asdict(x) for x in found.parameters],
            "combinations": [asdict(x) for x in found.combinations],
            "covariance": found.covariance,
            "gears": found.gears,
            "instrument": found.instrument,
            "marker": found.marker,
            "left_out": list(found.left_out),
            "misfits": list(found.misfits),
            "next_poses": found.next_poses,
        }
    )


def plain(x: Any) -> Any:
    """A value as JSON has it: arrays and tuples as lists, what is not finite as null."""
    if isinstance(x, dict):
        return {key: plain(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [plain(value) for value in x]
    if isinstance(x, np.ndarray):
        return plain(x.tolist())
    if isinstance(x, float):
        return x if np.isfinite(x) else None
    return x
