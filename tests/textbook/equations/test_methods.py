"""A method of derivation is one record: what it says of itself holds, and nothing else asks for it
by name."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

import freebody as fb
from freebody_textbook import methods
from freebody_textbook.derivation import Method
from freebody_textbook.methods import METHODS
from support.command import run
from support.sources import SOURCES, place
from support.symbolic import spatial_arm

FOLDER = Path(methods.__file__).parent
DOCS = Path(__file__).parents[3] / "docs"
NAMES = {name for method in METHODS.values() for name in (method.name, *method.aliases)}


OTHERWISE = [
    (
        "freebody_textbook/commands/derive.py",
        "Example: freebody derive 2R --method lagrange",
    ),  # the help's example, which is run
    ("report/page.py", "kinematics"),  # the plot of the tip's path
    ("expressions/closed_form_kinematics.py", "kinematics"),  # the function that an error is of
]
"""Where such a word means something else, or is shown to be typed."""


def home(method: Method) -> Path:
    """The file of a method's record."""
    return Path(method.work_out.__code__.co_filename)


def literals(path: Path) -> list[ast.Constant]:
    """The strings that are no docstrings, of a file in which a method's name stands at all."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text if any(name in text for name in NAMES) else "")
    documents = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    constants = [node for node in ast.walk(tree) if isinstance(node, ast.Constant)]
    return [node for node in constants if isinstance(node.value, str) and id(node) not in documents]


def test_no_file_but_its_own_knows_a_method_by_name():
    """The course is another package: it calls fb.derive as a reader does, and names chapters."""
    homes = {
        name: home(method) for method in METHODS.values() for name in (method.name, *method.aliases)
    }
    quoted = {
        name: re.compile(rf"^{name}$|['\"]{name}['\"]|--method[ =]{name}\b") for name in NAMES
    }
    found = [
        (place(path), node.value)
        for path in SOURCES
        if not place(path).startswith("freebody_notes/")
        for node in literals(path)
        for name, pattern in quoted.items()
        if pattern.search(str(node.value)) and path != homes[name]
    ]
    assert sorted(found) == sorted(OTHERWISE), (
        "another file asks for a method by its name: ask the record"
    )


def test_every_method_has_a_file_and_a_name_of_its_own():
    assert len(NAMES) == sum(1 + len(method.aliases) for method in METHODS.values())
    assert len({home(method) for method in METHODS.values()}) == len(METHODS)
    for name, method in METHODS.items():
        assert name == method.name
        assert home(method).parent == FOLDER
        assert method.title
        assert method.words
        assert method.source


@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
def test_lists_of_the_methods_read_the_record(method: Method, capsys: pytest.CaptureFixture[str]):
    assert run(["derive", "--help"]) == 0
    said = re.sub(r"[\s│]+", " ", capsys.readouterr().out)
    assert f"{method.name}: {method.words} ({method.source})." in said
    document = fb.derive.__doc__ or ""
    assert f"{method.name!r}: {method.words}" in document
    page = (DOCS / "functions.md").read_text(encoding="utf-8")
    words = "; ".join(
        [method.words, *(f"`{option.name}`: {option.words}" for option in method.options)]
    )
    closed = {(): "", (2,): ", closed in the plane", (2, 3): ", closed"}[method.closed]
    assert f"| `{method.name}` | {words} | open{closed} | {method.source} |" in page
    for option in method.options:
        assert f"--{option.flag or option.name} " in said
        assert f"{option.name}={' | '.join(map(repr, option.choices))}: {option.words}" in document


@pytest.mark.sample(17)
@pytest.mark.parametrize("method", METHODS.values(), ids=METHODS)
@pytest.mark.parametrize(
    "model",
    [fb.planar("RP"), spatial_arm(3, 2), fb.load("four_bar"), fb.load("bricard")],
    ids=["arm in the plane", "arm in space", "loop in the plane", "loop in space"],
)
def test_a_method_serves_what_it_says(method: Method, model: fb.Model):
    if model.dim in (method.closed if model.loops else method.spaces):
        if model.name != "bricard":  # long
            derivation = fb.derive(model, method.name)
            assert derivation.method == method.name
            assert bool(derivation.tau) == method.finds_torques
    else:
        with pytest.raises(
            fb.FreebodyError, match=f"derive '{method.name}': '{model.name}' is a closed chain"
        ):
            fb.derive(model, method.name)


@pytest.mark.parametrize(
    ("alias", "method"),
    [(alias, method) for method in METHODS.values() for alias in method.aliases],
)
def test_an_alias_is_the_method(alias: str, method: Method):
    derivation = fb.derive(fb.planar("R"), alias)
    assert derivation.method == method.name
    assert derivation.text() == fb.derive(fb.planar("R"), method.name).text()
    assert run(["derive", "R", "--method", alias, "--compare", method.name]) == 0


def test_options_are_those_of_the_record(capsys: pytest.CaptureFixture[str]):
    arm = fb.planar("R")
    for method in METHODS.values():
        for option in method.options:
            default = fb.derive(arm, method.name).text()
            flag = f"--{option.flag or option.name}"
            command = ["derive", "R", "--method", method.name, flag]
            texts = [fb.derive(arm, method.name, **{option.name: x}).text() for x in option.choices]
            assert texts[0] == default
            assert len(set(texts)) == len(option.choices), "each choice makes a difference"
            for chosen, text in zip(option.choices, texts, strict=True):
                assert run([*command, chosen]) == 0
                printed = capsys.readouterr()
                assert text.strip() in printed.out
                assert not printed.err
            assert run([*command, "neither"]) == 2
            assert f"no {option.name} 'neither' in {method.name}" in capsys.readouterr().err
