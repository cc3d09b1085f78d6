"""What the page on releases, the changelog and the metadata say of the version holds."""

import re
import tomllib
from pathlib import Path

import freebody as fb

ROOT = Path(__file__).parents[2]


def text(path: str) -> str:
    return (ROOT / path).read_text(encoding="utf-8")


def test_experimental_names_are_public():
    part = text("docs/releases.md").partition("## Experimental names")[2].partition("\n## ")[0]
    names = re.findall(r"^\| `fb\.(\w+)` \| .+ \|$", part, re.MULTILINE)
    assert names
    assert set(names) <= set(fb.__all__)


def test_the_version_is_one_and_has_a_heading():
    assert f"\n## {fb.__version__}\n" in text("CHANGELOG.md")
    assert re.findall(r"^version: (.*)$", text("CITATION.cff"), re.MULTILINE) == [fb.__version__]


def test_every_font_and_copied_robot_is_among_the_parts_of_others():
    """Fonts, and robots whose file names a licence."""
    listed = text("THIRD-PARTY.md")
    fonts = [path.name for path in (ROOT / "src").rglob("*.woff2")]
    robots = [
        path.name
        for path in (ROOT / "src/freebody/robots").glob("*.toml")
        if re.search(
            r"Apache|BSD|\bMIT\b|Toolbox", tomllib.loads(path.read_text("utf-8"))["source"]
        )
    ]
    assert len(robots) >= 4
    assert [name for name in fonts + robots if name not in listed] == []


def test_the_release_checks_the_pythons_of_the_classifiers():
    """And no other: what is said of a Python was tried on it."""
    said = re.findall(r"Python :: (3\.\d+)", text("pyproject.toml"))
    tried = re.search(r"python: \[(.*)\]", text(".github/workflows/release.yml"))
    assert tried is not None
    assert re.findall(r"3\.\d+", tried[1]) == said
