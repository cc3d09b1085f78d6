"""An identification as files: the robot as TOML, the report as text, and all numbers as JSON."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from freebody.formats.writing import toml
from freebody.identification.collisions import DetectedCollisions
from freebody.identification.identification import Identification, aligned_rows
from freebody.identification.identified_payload import IdentifiedPayload
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
        texts = ["\n".join([*found.lines()]), *map(text_of, more)]
        return "\n\n".join(texts) + "\n"

    makers: dict[str, Callable[[], str | bytes]] = {
        PAGE: page,
        MODEL: lambda: toml.written(found.model)[0],
        REPORT: report,
        DATA: lambda: json.dumps(data, indent=1, ensure_ascii=False) + "\n",
    }
    if payload is not None:
        makers[LOADED] = lambda: toml.written(payload.model)[0]
    about = {"robot": found.model.name, "logs": ", ".join(map(str, logs))}
    return write_folder(directory, makers, about)


def as_data(found: Identification) -> dict[str, Any]:
    """The identification as numbers, texts, lists and dicts; what is not a number is null."""
    return _plain(
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
            "drift": [asdict(x) for x in found.drift],
            "next": list(found.next),
        }
    )


def payload_data(found: IdentifiedPayload) -> dict[str, Any]:
    """An identified load as numbers, texts, lists and dicts."""
    return _plain(
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


def collision_data(found: DetectedCollisions) -> dict[str, Any]:
    """Collisions as numbers, texts, lists and dicts."""
    return _plain(
        {
            "verdict": found.verdict,
            "joints": list(found.names),
            "threshold": found.threshold,
            "collisions": [asdict(x) for x in found.collisions],
            "notices": list(found.notices),
        }
    )


def text_of(found: IdentifiedPayload | DetectedCollisions) -> str:
    """A load or collisions in words and a table."""
    own = found._table()
    return "\n".join([*aligned_rows([own.head, *own.rows]), "", *own.notes])


def _plain(x: Any) -> Any:
    if isinstance(x, dict):
        return {key: _plain(value) for key, value in x.items()}
    if isinstance(x, list | tuple):
        return [_plain(value) for value in x]
    if isinstance(x, np.ndarray):
        return _plain(x.tolist())
    if isinstance(x, float):
        return x if np.isfinite(x) else None
    return x
