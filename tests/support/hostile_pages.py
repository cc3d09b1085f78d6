"""Every page about an arm whose names mean something to whatever reads them."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import freebody as fb

LIVING = ("chapter", "kinematics", "statics")
"""Pages with a script: the drawing follows its sliders."""


@cache
def pages(arm: fb.Study) -> dict[str, str]:
    from freebody_notes.contents import items
    from freebody_notes.item import run_all
    from freebody_notes.page import pages as notes_pages

    notes, chapter, *_ = notes_pages(run_all(items()[:3]), "notes.html").values()
    with TemporaryDirectory() as folder:
        study = arm.to_html(Path(folder) / "study.html").read_text(encoding="utf-8")
    made = {"study": study, "notes": notes(), "chapter": chapter()}
    return made | {m: fb.derive(arm.model, m).html() for m in ("kinematics", "statics")}
