"""Robots as units of co-simulation (FMI 2.0, `fb.export_fmu`): the exported step of a simulation in
C, the functions that the standard asks for around it, and a description in XML."""

from __future__ import annotations

import hashlib
import io
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import zipfile
from collections.abc import Iterator
from importlib.resources import files
from pathlib import Path
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

from freebody import __version__
from freebody.arrays import above_zero
from freebody.errors import FreebodyError, require_kind, warn
from freebody.formats.writing.format_contents import kept_name
from freebody.identifiers import identifiers
from freebody.loops.assembly import assemble
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.outputs.files import write
from freebody.trees.positions import neutral
from freebody.ways_out.exports import source

_COMPILERS = ("cc", "gcc", "clang")
_SECONDS = 300.0
_MADE = (1980, 1, 1, 0, 0, 0)
"""The time of every file in the archive, so that the same robot gives the same bytes."""
_PLATFORMS = {"linux": ("linux64", ".so"), "darwin": ("darwin64", ".dylib")}


def export_fmu(model: Model, path: str | os.PathLike[str], *, step: float = 1e-3) -> Path:
    """Write the robot's motion as an FMU, a unit of co-simulation of FMI 2.0 for other simulators.

    Its inputs are the torques and forces of the driven joints, `tau.NAME`, held over each
    communication step; its outputs positions `q.NAME` and rates `qd.NAME`, whose start values may
    be set. Inside are equal steps of the classical Runge-Kutta method, `rk4_step`: Coulomb friction
    acts by the sign of the rate, and loops drift open as slowly as the step is fine. The C sources
    go along, and their library for this machine where it has a C compiler (cc, gcc or clang).

    Parameters
    ----------
    model
        The model, all of whose numbers have values; its numbers are constants of the unit.
    path
        The file, which ends in .fmu.
    step
        s, the longest step of the integration; the unit's parameter `step`.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    FreebodyError
        A path with another ending, a step that is not positive, a robot that cannot move, or a
        compiler that fails.
    FileError
        A file that cannot be written.

    Warns
    -----
    FreebodyWarning
        Where no compiler is found: the unit then has sources only.
    """
    require_model("export_fmu", model)
    require_kind("fb.export_fmu", "path", path, (str, os.PathLike), "the name of a file")
    target = Path(path)
    if target.suffix.lower() != ".fmu":
        raise FreebodyError(f"export_fmu: {os.fspath(path)!r} must end in .fmu.")
    step = above_zero("export_fmu", "step", step, "seconds")
    if not model.nv:
        raise FreebodyError(f"export_fmu: nothing of {model.name!r} moves.")
    word = identifiers([model.name])[model.name]
    variables = list(_variables(model, step))
    text = _unit_text(model, word, [start for *_, start in variables])
    guid = hashlib.sha256(text.encode()).hexdigest()[:32]
    text = text.replace("GUID_OF_THIS", guid)
    parts: dict[str, bytes] = {
        "modelDescription.xml": _description(model, word, guid, variables),
        f"sources/{word}.c": text.encode(),
    }
    parts |= _binary(word, text)
    write(target, _archive(parts))
    return target


# ---------------------------------------------------------------- contents
def _variables(model: Model, step: float) -> Iterator[tuple[str, str, float]]:
    """Name, causality and start value of each variable, in the order of value references; without
    causality those that a simulator is not told of: torques of passive joints, which have none."""
    q = assemble(model) if model.loops else neutral(model)
    yield "step", "parameter", float(step)
    for name, value in zip(model.position_names, q, strict=True):
        yield f"q.{name}", "output", float(value)
    for name in model.velocity_names:
        yield f"qd.{name}", "output", 0.0
    for k, name in enumerate(model.velocity_names):
        yield f"tau.{name}", "" if k in model.passive else "input", 0.0


def _unit_text(model: Model, word: str, starts: list[float]) -> str:
    """The C of the unit, in one file: the robot's step, and the standard's functions."""
    name = f"{word}_rk4_step"[-60:].lstrip("_0123456789")
    head = {
        "NQ": str(model.nq),
        "NV": str(model.nv),
        "STEP": name,
        "GUID": '"GUID_OF_THIS"',
        "STARTS": ", ".join(map(repr, starts)),
    }
    defined = "\n".join(f"#define {key} {value}" for key, value in head.items())
    around = (files("freebody.ways_out") / "fmu_unit.c").read_text(encoding="utf-8")
    return "\n".join([source(model, "rk4_step", "c", name=name), defined, around])


def _description(
    model: Model, word: str, guid: str, variables: list[tuple[str, str, float]]
) -> bytes:
    """The unit's modelDescription.xml."""
    root = Element(
        "fmiModelDescription",
        {
            "fmiVersion": "2.0",
            "modelName": kept_name(model.name, "an FMU"),
            "guid": guid,
            "description": f"Forward dynamics of {model.name}, SI units",
            "generationTool": f"freebody {__version__}",
            "variableNamingConvention": "flat",
        },
    )
    unit = SubElement(
        root,
        "CoSimulation",
        {
            "modelIdentifier": word,
            "canHandleVariableCommunicationStepSize": "true",
            "canGetAndSetFMUstate": "true",
            "canSerializeFMUstate": "true",
        },
    )
    SubElement(SubElement(unit, "SourceFiles"), "File", {"name": f"{word}.c"})
    listed = SubElement(root, "ModelVariables")
    structure = SubElement(root, "ModelStructure")
    outputs = SubElement(structure, "Outputs")
    for index, (name, causality, start) in enumerate(variables):
        if not causality:
            continue
        given = {
            "name": kept_name(name, "an FMU"),
            "valueReference": str(index),
            "causality": causality,
        }
        given["variability"] = "fixed" if causality == "parameter" else "continuous"
        if causality == "output":
            given["initial"] = "exact"
            SubElement(outputs, "Unknown", {"index": str(index + 1)})
        SubElement(SubElement(listed, "ScalarVariable", given), "Real", {"start": repr(start)})
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)


# ---------------------------------------------------------------- the library
def _binary(word: str, text: str) -> dict[str, bytes]:
    """The compiled library for this machine by its path in the archive; {}, with a warning, if
    there is no compiler for it here. Raises FreebodyError if the compiler fails."""
    place = _PLATFORMS.get(sys.platform)
    compiler = next(filter(None, map(shutil.which, _COMPILERS)), None)
    if place is None or compiler is None or platform.machine() not in ("x86_64", "AMD64"):
        warn(
            "export_fmu: there is no C compiler (cc, gcc, clang) for a 64-bit x86 machine here, so "
            "that the FMU has sources only; compile them where it shall run."
        )
        return {}
    folder, suffix = place
    with tempfile.TemporaryDirectory() as inside:
        unit, library = Path(inside, f"{word}.c"), Path(inside, f"{word}{suffix}")
        unit.write_text(text, encoding="utf-8")
        flags = ("-std=c99", "-O2", "-fPIC", "-shared", "-fvisibility=hidden")
        command = [compiler, *flags, "-o", str(library), str(unit), "-lm"]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=_SECONDS, check=False
            )
        except subprocess.TimeoutExpired:
            raise FreebodyError(
                f"export_fmu: {compiler} did not end within {_SECONDS:g} s."
            ) from None
        if done.returncode:
            raise FreebodyError(f"export_fmu: {compiler} failed: {done.stderr.strip()[:300]}")
        return {f"binaries/{folder}/{word}{suffix}": library.read_bytes()}


def _archive(parts: dict[str, bytes]) -> bytes:
    """The files of the unit as one zip archive."""
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in parts.items():
            info = zipfile.ZipInfo(name, _MADE)
            info.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(info, content)
    return held.getvalue()
