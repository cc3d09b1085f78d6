"""An identification or a calibration as files: the robot as TOML, the report as text, and all
numbers as JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from freebody.formats.writing import toml
from freebody.identification.calibration.calibration import Calibration
from freebody.identification.collisions import DetectedCollisions
from freebody.identification.identification import Identification
from freebody.identification.identified_payload import IdentifiedPayload
from freebody.identification.structure import JudgedStructure
from freebody.model.model import Model
from freebody.outputs.folder import write_folder

PAGE, MODEL, REPORT, DATA = "index.html", "model.toml", "report.txt", "identification.json"
LOADED = "loaded.toml"


def write_results(
    found: Identification,
    directory: str | os.PathLike[str],
    logs: Sequence[str],
    page: Callable[[], str],
    payload: IdentifiedPayload | None = None,
    collisions: DetectedCollisions | None = None,
) -> list[Path]:
    """The paths of the files of an identification in a folder: the page, the robot, the report, the
    data; of a load that was looked for the robot that carries it; and the manifest. logs: names of
    those it was made from."""
    more = [x for x in (payload, collisions) if x is not None]
    data = as_data(found)
    if payload is not None:
        data["payload"] = payload_data(payload)
    if collisions is not None:
        data["collisions"] = collision_data(collisions)

    def report() -> str:
        return "\n\n".join(map(str, (found, *more))) + "\n"

    makers: dict[str, Callable[[], str | bytes]] = {
        PAGE: page,
        **_made(found.model, report, DATA, data),
    }
    if payload is not None:
        makers[LOADED] = lambda: toml.written(payload.model)[0]
    about = {"robot": found.model.name, "logs": ", ".join(map(str, logs))}
    return write_folder(directory, makers, about)


def write_calibration(
    found: Calibration, directory: str | os.PathLike[str], poses: Sequence[str]
) -> list[Path]:
    """The paths of the files of a calibration in a folder: the robot, the report, the data; and the
    manifest. poses: names of the files it was made from."""
    about = {"robot": found.model.name, "poses": ", ".join(map(str, poses))}

    def report() -> str:
        return f"{found}\n"

    makers = _made(found.model, report, "calibration.json", calibration_data(found))
    return write_folder(directory, makers, about)


def _made(
    model: Model, report: Callable[[], str], name: str, data: dict[str, Any]
) -> dict[str, Callable[[], str | bytes]]:
    """Makers of the files: the robot, the report, and the data in a file of that name."""
    return {
        MODEL: lambda: toml.written(model)[0],
        REPORT: report,
        name: lambda: json.dumps(data, indent=1, ensure_ascii=False) + "\n",
    }


def as_data(found: Identification) -> dict[str, Any]:
    """The identification as numbers, texts, lists and dicts; what is not a number is null."""
    return plain(
        {
            "robot": found.model.name,
            "verdict": found.verdict,
            "outcome": found.outcome,
            "scale_known": found.scale_known,
            "scale": list(found.scale),
            "trusted": found.trusted,
            "structure": _structure_data(found.structure),
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
            "drift": [asdict(x) for x in found.drift],
            "next": list(found.next),
        }
    )


def _structure_data(found: JudgedStructure) -> dict[str, Any]:
    """The judgement of logs on a structure, null where they say nothing against it."""
    delay, misplaced, other = found.delay, found.misplaced, found.disagreement
    of_joint = (
        None
        if misplaced is None
        else misplaced._asdict()
        | {"displacement": misplaced.displacement._asdict(), "said": misplaced.text()}
    )
    return {
        "fits": found.fits,
        "delay": None if delay is None else delay._asdict(),
        "misplaced": of_joint,
        "disagreement": None if other is None else other._asdict(),
    }


def payload_data(found: IdentifiedPayload) -> dict[str, Any]:
    """An identified load as numbers, texts, lists and dicts."""
    return plain(
        {
            "frame": found.frame,
            "verdict": found.verdict,
            "outcome": found.outcome,
            "numbers": [asdict(x) for x in found.numbers],
            "friction": [asdict(x) for x in found.friction],
            "unexplained": found.unexplained,
            "notices": list(found.notices),
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


def collision_data(found: DetectedCollisions) -> dict[str, Any]:
    """Collisions as numbers, texts, lists and dicts."""
    return plain(
        {
            "verdict": found.verdict,
            "joints": list(found.names),
            "threshold": found.threshold,
            "collisions": [asdict(x) for x in found.collisions],
            "notices": list(found.notices),
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
