"""The core works without the packages that build on it, and says which of them something needs."""

from __future__ import annotations

import json
import subprocess
import sys

TEXTBOOK = {
    "AnswerError",
    "check",
    "derive",
    "equations",
    "loop_equations",
    "quantities",
    "relation",
    "sampled_trajectory",
    "trajectory",
    "vector_function",
}
"""Public names that need the textbook."""

ALONE = """
import json, sys, warnings
from importlib.abc import MetaPathFinder

class Absent(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        if name in ("freebody_textbook", "freebody_notes"):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
warnings.simplefilter("ignore")
import freebody as fb
from freebody.cli.app import run

missing = {}
for name in fb.__all__:
    try:
        getattr(fb, name)
    except ImportError as problem:
        assert isinstance(problem, fb.FreebodyError)
        missing[name] = str(problem)
arm, folder = fb.load("2R"), sys.argv[1]
study = fb.study(arm)
study.to_html(f"{folder}/study.html")
svg = fb.free_body_diagram(arm, [0.3, 0.4]).svg
said = str(fb.singularities(fb.planar("RR")))
runs = {
    "show": run(["show", "ur5e"]),
    "study": run(["study", "2R", "--out", f"{folder}/study"]),
    "fbd": run(["fbd", "2R", "--out", f"{folder}/bodies.svg"]),
    "export": run(["export", "2R", "inverse_dynamics", "--out", f"{folder}/c"]),
    "derive": run(["derive", "2R"]),
    "check": run(["check", "2R", "H22 = 1"]),
    "help": run(["--help"]),
}
with open(f"{folder}/found.json", "w") as file:
    json.dump({"missing": missing, "svg": svg, "said": said, "runs": runs}, file)
"""


def test_all_but_the_textbook_works_without_it(tmp_path):
    done = subprocess.run(
        [sys.executable, "-c", ALONE, str(tmp_path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found = json.loads((tmp_path / "found.json").read_text(encoding="utf-8"))
    needed = {name: text.split(": ")[1].split()[0] for name, text in found["missing"].items()}
    assert needed == dict.fromkeys(TEXTBOOK, "freebody_textbook") | {
        "notes_figure": "freebody_notes"
    }
    assert found["missing"]["derive"].startswith("fb.derive: freebody_textbook is not installed;")
    assert found["svg"].startswith("<svg")
    assert "det J = l₁ l₂ sin θ₂" in found["said"]
    page = (tmp_path / "study.html").read_text(encoding="utf-8")
    assert "equations of motion: freebody_textbook is not installed" in page
    assert found["runs"] == {
        "show": 0, "study": 0, "fbd": 0, "export": 0, "derive": 2, "check": 2, "help": 0,
    }  # fmt: skip
    assert "error: freebody derive: freebody_textbook is not installed" in done.stderr


def test_no_room_of_the_core_bears_the_name_of_a_public_function():
    """Importing such a room would put the module in the function's place."""
    import freebody as fb
    from support.sources import SRC

    rooms = {path.stem for path in (SRC / "freebody").iterdir() if path.stem[0] != "_"}
    assert rooms & {*fb.__all__} == {"math"}
