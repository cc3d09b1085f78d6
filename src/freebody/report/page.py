"""The study as one HTML file that fetches neither scripts nor fonts, with inline SVG figures and
numbers that name their source."""

from __future__ import annotations

import platform
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
from freebody.motion.ranges import ranges
from freebody.outputs import files
from freebody.outputs.harmless_text import legal
from freebody.outputs.number_text import significant
from freebody.outputs.page_head import SHEETS, math_style, policy
from freebody.outputs.pdf import pdf
from freebody.report import page_figures as figures
from freebody.report import page_tables as tables
from freebody.report.summary import energy_text
from freebody.report.tables import typeset

if TYPE_CHECKING:
    from freebody.report.study import Study


def write(study: Study, path: Path) -> Path:
    """The path of the HTML page that is written."""
    return files.write(path, page(study))


def write_pdf(study: Study, path: Path) -> Path:
    """The path of the PDF of the page that is written."""
    return files.write(path, pdf(page(study)))


def page(study: Study) -> str:
    """The HTML text of a study's page."""
    diagrams, loads = figures.free_bodies(study)
    return legal(
        _templates()
        .get_template("page.html")
        .render(
            policy=Markup(policy()),
            sheets=Markup(SHEETS),
            study=study,
            model=study.model,
            facts=_facts(study),
            case=study.load_case,
            notices=_notices(study),
            doubts={doubt.kind: doubt.of.bars for doubt in study.verdict.doubts},
            robot=figures.robot(study),
            energy=energy_text(study.summary, study.motion.duration),
            **{table.__name__: table(study) for table in tables.TABLES},
            equations=_equations(study),
            plots={plots.__name__: list(plots(study)) for plots in figures.PLOTS},
            free_bodies=[
                (diagram, tables.loads(study, body))
                for diagram, body in zip(diagrams, loads, strict=True)
            ],
            versions=_versions(),
            colours=(colours.page_colours(dark=False), colours.page_colours(dark=True)),
            math_style=Markup(math_style()),
            figure_style=Markup(colours.style("@media screen and (prefers-color-scheme:dark)")),
        )
    )


@cache
def _templates() -> jinja2.Environment:
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("freebody.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=jinja2.StrictUndefined,
    )
    environment.filters["significant"] = significant
    environment.filters["svg"] = Markup
    environment.filters["typeset"] = typeset
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
    source, path = _source(study)
    failed = [check for check in study.checks if not check.passed]
    loops = study.replay
    return {
        "failed": failed,
        "source": source,
        "path": path,
        "gravity": ", ".join(significant(float(x)) for x in model.gravity),
        "freedom": mobility(model, motion.q[0]).generic,
        "samples": len(motion.t),
        "parts": [words for words in figures.parts(study).values() if words != "total"],
        "limited": bool(np.isfinite(ranges(model).effort).any()),
        "mimic": [body.joint for body in model.bodies if body.joint.mimic is not None],
        "worst_miss": float(np.nanmax(loops.misses)) if loops is not None else 0.0,
        "worst_factor": float(loops.factors.max()) if loops is not None else 0.0,
        "seconds": sum(study.seconds.values()),
    }


def _notices(study: Study) -> dict[str, list[str]]:
    """Findings about the motion, and notices on how the file was read, without the file's
    folder."""
    read = readings(study.model)
    short = [str(replace(n, file=Path(n.file).name if n.file else None)) for n in read]
    return {"findings": list(study.warnings), "reading": short}


def _source(study: Study) -> tuple[str, str]:
    """The name of the robot's source, and the full path of its file, "" where it is none."""
    source = study.model.source
    name = Path(source).name
    if Path(source).suffix in SUFFIXES and name != source:
        return name, source
    return source or "no source given", ""


def _versions() -> dict[str, str]:
    packages = {p: _version(p) for p in ("numpy", "scipy", "xarray", "llvmlite")}
    return {"freebody": freebody.__version__, "Python": platform.python_version(), **packages}


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:  # LLVM; NumPy computes without it
        return "not installed"
