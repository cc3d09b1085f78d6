"""A derivation as a page: every step, figures, and sliders that move the arm."""

from pathlib import Path

import freebody as fb

page = fb.derive(fb.load("2R"), "lagrange").html()
Path("derivation.html").write_text(page, encoding="utf-8")
