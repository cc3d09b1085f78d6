"""The study as one HTML file that fetches neither scripts nor fonts, with inline SVG figures and
numbers that name their source."""

from __future__ import annotations

import platform
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import jinja2
import numpy as np
from markupsafe import Markup

import freebody
from freebody import beside
from freebody.errors import MissingPackageError
from freebody.figures import colours
from freebody.formats.loading import SUFFIXES
from freebody.loops.mobility import mobility
from freebody.model.doubts import readings
from freebody.model.model import Model
from freebody.motion.ranges import ranges
from freebody.outputs.harmless_text import legal
from freebody.outputs.number_text import significant
from freebody.outputs.pages import SHEETS, edged, math_style, policy
from freebody.report import page_figures as figures
from freebody.report import page_tables as tables
from freebody.report.card import needed
from freebody.report.moving_page import moving_page
from freebody.report.summary import energy_text
from freebody.report.tables import opened, typeset

if TYPE_CHECKING:
    from freebody.report.cycle_study import CycleStudy
    from freebody.report.study import Study


_CONTENTS = (
    ("verdict", "Verdict"), ("answer", "Drives"), ("motion", "Motion"), ("torques", "Torques"),
    ("power", "Power and energy"), ("gravity", "Gravity and payload"),
    ("kinematics", "Path of the tip"), ("reactions", "Joint reactions"), ("bodies", "Bodies"),
    ("diagrams", "Free-body diagrams"),
    ("equations", "Equations"), ("checks", "Self-checks"), ("method", "Method"),
)  # fmt: skip
"""Sections and what they are called in the contents."""


def page(study: Study) -> str:
    """The HTML text of a study's page."""
    diagrams, loads = figures.free_bodies(study)
    equations = _equations(study)
    plots, over_time = figures.numbered({x.__name__: list(x(study)) for x in figures.PLOTS})
    moving = moving_page(study, over_time)
    return rendered(
        "page.html",
        study=study,
        scripts=(moving.script,),
        moving=moving,
        model=study.model,
        facts=_facts(study),
        case=study.load_case,
        notices=_notices(study),
        needed=needed(study.card, study.worst, study.summary),
        robot=figures.robot(study),
        energy=energy_text(study.summary, study.motion.duration),
        **{table.__name__: table(study) for table in tables.TABLES},
        equations=equations,
        plots=plots,
        free_bodies=[
            (diagram, tables.loads(study, body))
            for diagram, body in zip(diagrams, loads, strict=True)
        ],
        math_style=Markup(math_style()) if equations else "",
        contents=[entry for entry in _CONTENTS if entry[0] != "equations" or equations],
    )


def rendered(template: str, *, study: Study | CycleStudy, **words: Any) -> str:
    """The HTML text of a page of a study, from its template."""
    doubts = {doubt.kind: doubt.of.bars for doubt in study.verdict.doubts}
    return filled(template, study=study, doubts=doubts, **words)


def filled(
    template: str, *, scripts: Sequence[str] = (), package: str = "freebody.report", **words: Any
) -> str:
    """The HTML text of a page, from its template: with the policy, colours and rules for paper that
    all pages have, and the scripts that this one runs. package: whose `templates` it is in."""
    return legal(
        _templates(package)
        .get_template(template)
        .render(
            policy=Markup(policy(scripts)),
            scripts=[Markup(script) for script in scripts],
            sheets=Markup(SHEETS + edged(".scroll,nav ol")),
            versions=_versions(),
            colours=(colours.page_colours(dark=False), colours.page_colours(dark=True)),
            figure_style=Markup(colours.style("@media screen and (prefers-color-scheme:dark)")),
            **words,
        )
    )


@cache
def _templates(package: str) -> jinja2.Environment:
    folders = dict.fromkeys((package, "freebody.report"))  # those of studies serve all
    environment = jinja2.Environment(
        loader=jinja2.ChoiceLoader([jinja2.PackageLoader(folder) for folder in folders]),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["significant"] = significant
    environment.filters["svg"] = Markup
    environment.filters["typeset"] = typeset
    environment.filters["opened"] = opened
    return environment


def _equations(study: Study) -> Any:
    """The equations of motion where they are short, or the sentence on the package that they need;
    None where they are long."""
    try:
        return beside.found(beside.EQUATIONS_OF_A_STUDY, "Equations of motion").shown(study.model)
    except MissingPackageError as problem:
        return str(problem)


def _facts(study: Study) -> dict[str, Any]:
    """Single words and numbers that the page's template puts into its text."""
    model, motion = study.model, study.motion
    name, path = source(study.model)
    failed = [check for check in study.checks if not check.passed]
    loops = study.replay
    return {
        "failed": failed,
        "source": name,
        "path": path,
        "gravity": ", ".join(significant(float(x)) for x in model.gravity),
        "freedom": mobility(model, motion.q[0]).generic,
        "drives": len(model.driven_names),
        "samples": len(motion.t),
        "parts": [words for words in figures.parts(study).values() if words != figures.TOTAL],
        "limited": bool(np.isfinite(ranges(model).effort).any()),
        "mimic": [body.joint for body in model.bodies if body.joint.mimic is not None],
        "worst_miss": float(np.nanmax(loops.misses)) if loops is not None else 0.0,
        "worst_factor": float(loops.factors.max()) if loops is not None else 0.0,
        "seconds": sum(study.seconds.values()),
    }


def _notices(study: Study) -> dict[str, list[str]]:
    """Findings about the motion, and notices on how the file was read."""
    return {"findings": list(study.warnings), "reading": how_read(study.model)}


def how_read(model: Model) -> list[str]:
    """Notices on how a robot's file was read, without the file's folder."""
    read = readings(model)
    return [str(replace(n, file=Path(n.file).name if n.file else None)) for n in read]


def source(model: Model) -> tuple[str, str]:
    """The name of the robot's source, and the full path of its file, "" where it is none."""
    given = model.source
    name = Path(given).name
    if Path(given).suffix in SUFFIXES and name != given:
        return name, given
    return given or "no source given", ""


def _versions() -> dict[str, str]:
    packages = {p: _version(p) for p in ("numpy", "scipy", "xarray", "llvmlite")}
    return {"freebody": freebody.__version__, "Python": platform.python_version(), **packages}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # LLVM; NumPy computes without it
        return "not installed"
