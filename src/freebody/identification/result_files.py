"""An identification as files: the robot as TOML, the report as text, and all numbers as JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from freebody.formats.writing import toml
from freebody.identification.identification import Identification
from freebody.outputs.folder import write_folder

MODEL, REPORT, DATA = "model.toml", "report.txt", "identification.json"


def write_results(
    found: Identification, directory: str | os.PathLike[str], logs: Sequence[str]
) -> list[Path]:
    """The paths of the files of an identification in a folder: the robot, the report, the data; and
    the manifest. logs: names of those it was made from."""
    makers = {
        MODEL: lambda: toml.written(found.model)[0],
        REPORT: lambda: "\n".join(found.lines()) + "\n",
        DATA: lambda: json.dumps(as_data(found), indent=1, ensure_ascii=False) + "\n",
    }
    about = {"robot": found.model.name, "logs": ", ".join(map(str, logs))}
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
