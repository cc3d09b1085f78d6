"""Hostile names through every way out: they never run, never break a file's format, and come back
as they were."""

from __future__ import annotations

import builtins
import csv
import io
import json
import pickle
import re
import tomllib
import xml.etree.ElementTree as ElementTree
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from support.command import run
from support.extras import extra
from support.languages import TOOL

CODE = "__import__('builtins').__dict__.__setitem__('hacked', True)"
HOSTILE = {
    "docstring": f'tool"""\n{CODE}\nx = """',
    "quote": f"'+{CODE}+'",
    "newline": f"a\n{CODE}\n",
    "module asm": 'x\nmodule asm "ud2"\ndefine void @kernel() { ret void }',
    "backslash": '\\\\" \\n \\x00 \\N{BULLET} \\',
    "theta": "θ₁",
    "nul": "a\x00b",
    "control": "a\x0b\x1b[31m\x7fb",
    "right to left": "\u202egnp.exe\u202c",
    "long": "n" * 5000,
    "formula": "=cmd|' /C calc'!A0",
    "plus": "+1+1",
    "at": "@SUM(A1)",
    "script": "<script>hacked()</script>",
    "attribute": '"><img src=x onerror=hacked()>',
    "cdata": "]]></style></svg><script>hacked()</script>",
    "latex": r"\input{/etc/passwd}$^_%&#{}~",
    "comment": "*/ int x; /*",
    "percent": "%s %(x)s {0} {x!r} {{x}} {% raw %}",
    "slash": "left/joint1",
    "dot dot": "../../etc/passwd",
    "spaces": "  two  words  ",
    "chinese": "关节",
    "markup": "[red]x[/red] [link=file:///etc]y[/link]",
}


def text_of(name: str, planar: bool = True) -> str:
    """TOML of an arm of two joints in which everything is called so; TOML escapes as JSON does."""

    def q(ending: str) -> str:
        return json.dumps(name + ending, ensure_ascii=False).replace("\x7f", "\\u007f")

    links = "".join(
        f"[[link]]\nname = {q(f' link{k}')}\nmass = 1.5\ncom = [0.2, 0]\ninertia = 0.05\n"
        for k in (1, 2)
    )
    limits = "limits = { lower = -2, upper = 2, velocity = 4, effort = 80 }\n"
    return (
        f"name = {q('')}\nsource = {q(' source')}\ndim = 2\ntip = {q(' tip')}\n"
        f"[[link]]\nname = {q(' base')}\n{links}"
        f"[[joint]]\nname = {q(' joint1')}\nkind = 'revolute'\nparent = {q(' base')}\nchild = "
        f"{q(' link1')}\n{limits}"
        f"[[joint]]\nname = {q(' joint2')}\nkind = 'revolute'\nparent = {q(' link1')}\nchild = "
        f"{q(' link2')}\n"
        f"origin = [0.4, 0]\n{limits}"
        f"[[frame]]\nname = {q(' tip')}\nparent = {q(' link2')}\norigin = [0.4, 0]\n"
    )


def arm(name: str, folder: Path) -> fb.Model:
    path = folder / "arm.toml"
    path.write_text(text_of(name), encoding="utf-8")
    return fb.load(path)


@pytest.fixture(params=list(HOSTILE))
def hostile(request: pytest.FixtureRequest) -> str:
    return HOSTILE[request.param]


@pytest.fixture
def model(hostile: str, tmp_path: Path) -> fb.Model:
    return arm(hostile, tmp_path)


@pytest.fixture
def tame(tmp_path: Path) -> fb.Model:
    return arm("arm", tmp_path)


@pytest.fixture(autouse=True)
def nothing_ran():
    yield
    assert not hasattr(builtins, "hacked")


STATE = (np.array([0.3, -0.7]), np.array([0.5, 0.2]), np.array([-1.0, 2.0]))
LOAD = np.array([1.0, -2.0, 0.5])
QUANTITIES = ("inverse_dynamics", "forward_dynamics", "joint_wrenches", "static_torque")


# ---------------------------------------------------------------- code
@pytest.mark.sample(11)
def test_programs_and_kernels_do_not_know_names(model, tame):
    for quantity in QUANTITIES:
        made = []
        for m in (model, tame):
            made.append(fb.kernel(m, quantity, wrench_frames=[m.tip], target="numpy").program)
        assert made[0].digest == made[1].digest
        for target in ("cpu", "numpy"):
            one, two = (
                fb.kernel(m, quantity, wrench_frames=[m.tip], target=target) for m in (model, tame)
            )
            assert one is two, "a renamed robot is not compiled again"


@pytest.mark.parametrize("target", ["cpu", "numpy"])
def test_a_wrench_at_a_tip_of_any_name(model, tame, target):
    kernels = [
        fb.kernel(m, "inverse_dynamics", wrench_frames=[m.tip], target=target)
        for m in (model, tame)
    ]
    assert np.array_equal(*(k(*STATE, LOAD) for k in kernels))
    taus = [fb.inverse_dynamics(m, *STATE, {m.tip: LOAD}) for m in (model, tame)]
    assert np.array_equal(*taus)
    assert np.array_equal(
        *(fb.joint_wrenches(m, *STATE, wrenches={m.tip: LOAD}) for m in (model, tame))
    )
    J = fb.jacobian(tame, STATE[0])
    np.testing.assert_allclose(taus[0], fb.inverse_dynamics(tame, *STATE) - J.T @ LOAD)


REMARKS = re.compile(
    r'"""[^"]*"""|/\*.*?\*/|(?://|#|%)[ A-Za-z0-9_ .,:;()\[\]/^+<>=-]*$', re.DOTALL | re.MULTILINE
)


@pytest.mark.sample(7)
@pytest.mark.parametrize("language", ["c", "matlab", "numpy"])
def test_source_text_with_numbers_as_inputs_is_that_of_a_robot_with_plain_names(
    model, tame, language
):
    """Their names hold those of bodies and joints."""
    texts = [fb.source(m, "inverse_dynamics", language, inputs=["*"]) for m in (model, tame)]
    texts += [
        fb.source(fb.kernel(m, "bias", inputs=["*"], target="numpy"), language=language)
        for m in (model, tame)
    ]
    code = [REMARKS.sub("", text) for text in texts]
    assert code[0] == code[1]
    assert code[2] == code[3]


@pytest.mark.sample(13)
@pytest.mark.parametrize("language", TOOL)
def test_source_text_is_that_of_a_robot_with_plain_names(model, tame, language):
    texts = [fb.source(m, QUANTITIES[:2], language, wrench_frames=[m.tip]) for m in (model, tame)]
    assert texts[0].isascii()
    remarks = (
        re.compile("^//.*$", re.MULTILINE) if language == "cuda" else REMARKS
    )  # % begins its registers
    code = [remarks.sub("", text) for text in texts]
    assert code[0] == code[1], "a name changes a remark, nothing else"
    assert "sin" in texts[0]
    if language == "numpy":
        scope: dict = {}
        exec(texts[0], scope)
        tau, _ = scope["_".join(QUANTITIES[:2])](*STATE, np.zeros(2), LOAD)
        np.testing.assert_allclose(tau, fb.inverse_dynamics(tame, *STATE, LOAD))


@pytest.mark.sample(19)
@pytest.mark.parametrize("language", ["numpy", "cuda"])
def test_a_package_holds_the_names_and_nothing_runs_them(model, hostile, language, tmp_path):
    before = set(tmp_path.rglob("*"))
    paths = fb.export(
        model, "inverse_dynamics", tmp_path / "out", language, wrench_frames=[model.tip]
    )
    assert set(tmp_path.rglob("*")) - before == {tmp_path / "out", *paths}
    names = json.loads((tmp_path / "out" / "names.json").read_text(encoding="utf-8"))
    assert list(names["robot"].values()) == [hostile]
    assert tuple(names["joints"].values()) == model.joint_names
    assert set(model.frame_names) <= set(names["bodies and frames"].values())
    for path in paths:
        assert path.name == "names.json" or path.read_text(encoding="utf-8").isascii()


def test_jax(tame, tmp_path):
    jax = extra("jax", "JAX", "jax")
    for name in (HOSTILE["docstring"], HOSTILE["nul"]):
        model = arm(name, tmp_path)
        with jax.enable_x64(True):
            tau = fb.to_jax(model, "inverse_dynamics", wrench_frames=[model.tip])(*STATE, LOAD)
        np.testing.assert_allclose(tau, fb.inverse_dynamics(tame, *STATE, LOAD), rtol=1e-12)


def test_equations_as_source(model, tame):
    equations = fb.equations(model)
    text = equations.python()
    scope: dict = {}
    exec(text, scope)
    M, *_ = scope["dynamics"](*(x.tolist() for x in STATE))
    np.testing.assert_allclose(M, fb.mass_matrix(tame, STATE[0]))
    assert text.splitlines()[1:] == fb.equations(tame).python().splitlines()[1:], (
        "names in the title alone"
    )
    c = equations.c_source()
    assert c.splitlines()[1:] == fb.equations(tame).c_source().splitlines()[1:]
    assert c.splitlines()[0].count("*/") == c.splitlines()[0].count("/*") == 1
    assert c.isascii()


# ---------------------------------------------------------------- files that come back
def test_toml_round_trip(model, hostile, tmp_path):
    assert (model.name, model.tip) == (hostile, hostile + " tip")
    path = tmp_path / "saved.toml"
    fb.save(model, path)
    tomllib.loads(path.read_text(encoding="utf-8"))
    again = fb.load(path)
    assert (again.name, again.joint_names, again.frame_names, again.tip) == (
        model.name, model.joint_names, model.frame_names, model.tip,
    )  # fmt: skip


def test_pickle_round_trip(model):
    again = pickle.loads(pickle.dumps(model))
    assert again.joint_names == model.joint_names
    assert np.array_equal(fb.mass_matrix(again, STATE[0]), fb.mass_matrix(model, STATE[0]))


# ---------------------------------------------------------------- what is drawn and printed
class Tags(HTMLParser):
    """Start tags with their attributes."""

    def __init__(self, text: str):
        super().__init__()
        self.tags: list[tuple[str, dict[str, str | None]]] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append((tag, dict(attrs)))


def skeleton(page: str) -> list[str]:
    """What a page is made of, without what it says: a name must add nothing to it."""
    return [tag for tag, _ in Tags(page).tags]


def inert(page: str) -> None:
    for tag, attributes in Tags(page).tags:
        assert not [name for name in attributes if name.startswith("on")], (tag, attributes)
        assert tag != "img" or (attributes.get("src") or "").startswith("data:")
        assert not (attributes.get("href") or "").lower().startswith("javascript:")
    assert "<script>hacked" not in page
    assert not set("\x00\x0b\x1b") & set(page)


@pytest.mark.sample(2)
def test_drawings_are_well_formed(model, tame):
    for draw in (
        lambda m: fb.free_body_diagram(m, STATE[0]),
        lambda m: fb.kinematic_diagram(m),
    ):
        text = draw(model).svg
        root = ElementTree.fromstring(text)
        tags = {element.tag.rpartition("}")[2] for element in root.iter()}
        plain = draw(tame).svg
        allowed = {
            element.tag.rpartition("}")[2] for element in ElementTree.fromstring(plain).iter()
        }
        assert tags <= allowed | {"tspan"}, "a name adds no element"
        inert(text)


@pytest.mark.sample(1)
def test_derivation_pages(model, tame):
    pages = [fb.derive(m, "lagrange").html() for m in (model, tame)]
    inert(pages[0])
    assert [
        x
        for x in skeleton(pages[0])
        if x in ("script", "iframe", "link", "object", "embed", "style", "svg")
    ] == [
        x
        for x in skeleton(pages[1])
        if x in ("script", "iframe", "link", "object", "embed", "style", "svg")
    ]


@pytest.mark.sample(3)
def test_latex_and_markdown_of_a_derivation_have_no_command_from_a_name(model):
    derivation = fb.derive(model, "lagrange")
    for text in (derivation.latex(), derivation.markdown()):
        assert not set("\x00\x0b\x1b\u202e") & set(text)
    assert r"\input{/etc" not in derivation.latex()


# ---------------------------------------------------------------- a study, with all its files
STUDIED = [
    "docstring",
    "nul",
    "control",
    "formula",
    "script",
    "cdata",
    "slash",
    "theta",
    "chinese",
    "long",
]


@pytest.mark.sample(1)
@pytest.mark.parametrize("which", STUDIED)
def test_a_study_with_all_its_files(which, tmp_path):
    name = HOSTILE[which]
    arm(name, tmp_path)
    before = set(tmp_path.rglob("*"))
    out = tmp_path / "out"
    run(["study", str(tmp_path / "arm.toml"), "--out", str(out)])
    made = set(tmp_path.rglob("*")) - before
    assert all(path == out or out in path.parents for path in made), "no file outside the folder"
    inert((out / "report.html").read_text(encoding="utf-8"))
    with xr.open_dataset(next(out.glob("*.nc"))) as data:
        data.load()
    for path in out.glob("*.csv"):
        for row in csv.reader(io.StringIO(path.read_text(encoding="utf-8"))):
            for cell in row:
                assert not cell.startswith(("=", "@", "\t", "\r")), (
                    "a spreadsheet would run this cell"
                )
                if cell.startswith(("+", "-")):
                    float(cell)


def test_the_command_line_shows_no_control_characters(model, hostile, tmp_path, capsys):
    assert run(["show", str(tmp_path / "arm.toml")]) == 0
    shown = capsys.readouterr().out
    assert not set("\x00\x0b\x1b\u202e") & set(shown)
    if hostile.isprintable() and len(hostile) < 30:
        assert hostile.strip() in shown, "shown as it is, not read as markup"
