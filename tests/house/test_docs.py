"""The examples of the Markdown files and of the commands' help run as tests, so that none stays
wrong."""

import doctest
import itertools
import re
import runpy
import shlex
import tomllib
from pathlib import Path

import pytest
import xarray

import freebody as fb
from support.command import command_names, example, help_of, run
from support.executed_notes import executing_once
from support.listed import LOOP_KINDS
from support.robots import KINDS

ROOT = Path(__file__).parents[2]
PAGES = (
    sorted(ROOT.glob("*.md"))
    + sorted(
        set(ROOT.glob("docs/**/*.md"))
        - {ROOT / f"docs/{made}/index.md" for made in ("gallery", "notebooks")}
    )
    + sorted(ROOT.glob("benchmarks/*.md"))
    + sorted(ROOT.glob("proof/*.md"))
)
BLOCK = re.compile(r"^(<!-- no-run: .+ -->\n)?```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
FILE = re.compile(r"# ([\w-]+\.toml)\n")
"""The first line of a block that is a file, which the examples behind it read."""
FLAGS = doctest.NORMALIZE_WHITESPACE | doctest.ELLIPSIS | doctest.REPORT_NDIFF
LOCAL_LINK = re.compile(r"\]\((?!https?:|mailto:)([^)#\s]*)(?:#([^)\s]+))?\)")


NEEDS = {"torch.md": "torch", "jax.md": "jax", "derivations.md": "sympy"}
"""Pages whose examples need a package that may not be there."""


def name(page: Path) -> str:
    return page.relative_to(ROOT).as_posix()


def examples(page: Path):
    """(language, line number, text) of each block that is to run."""
    text = page.read_text(encoding="utf-8")
    for block in BLOCK.finditer(text):
        exempt, language, body = block.groups()
        runs = language in ("python", "pycon", "console") or FILE.match(body)
        if not exempt and runs:
            yield language, text.count("\n", 0, block.start(3)), body


def run_doctest(text: str, names: dict, page: str, line: int) -> None:
    said: list[str] = []
    test = doctest.DocTestParser().get_doctest(text, names, page, page, line)
    doctest.DocTestRunner(optionflags=FLAGS).run(test, out=said.append, clear_globs=False)
    names.update(test.globs)
    assert not said, "".join(said)


@pytest.mark.sample(1)
@pytest.mark.parametrize("page", [p for p in PAGES if any(examples(p))], ids=name)
def test_examples_run(
    page: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest
):
    if page.name in NEEDS:
        needed = pytest.importorskip(NEEDS[page.name])
    if page.name == "jax.md":  # its reader sets this for good
        request.addfinalizer(lambda: needed.config.update("jax_enable_x64", False))
    if page.name == "notes.md":
        executing_once(monkeypatch)
    monkeypatch.chdir(tmp_path)
    names: dict = {"__name__": "example"}
    for language, line, text in examples(page):
        if language == "pycon":
            run_doctest(text, names, page.name, line)
        elif language == "python":
            exec(compile("\n" * line + text, page, "exec"), names)
        elif file := FILE.match(text):
            Path(file[1]).write_text(text, encoding="utf-8")
        else:
            for command in re.findall(r"^\$ (freebody .*)$", text, re.MULTILINE):
                assert run(shlex.split(command)[1:]) == 0, command


def anchors(page: Path) -> set[str]:
    """What GitHub calls the headings of a page."""
    headings = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_lead_somewhere(page: Path):
    """To a file that is there, and to a heading of it."""
    wrong = []
    for path, anchor in LOCAL_LINK.findall(page.read_text(encoding="utf-8")):
        target = page.parent / path if path else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            wrong.append(f"{path}#{anchor}")
    assert wrong == []


EXTERNAL_LINK = re.compile(r"\]\((\w+:[^)]*)\)|<(\w+://[^>]*)>")
WELL_FORMED = re.compile(r"https://[\w-]+(\.[\w-]+)+(/[^\s<>]*)?")
PLACEHOLDER = re.compile(r"example\.(com|org|net)|localhost|TODO", re.IGNORECASE)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_links_to_the_web_are_well_formed(page: Path):
    """Encrypted, without blanks, and no placeholder; whether anybody answers no test asks."""
    text = re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.M | re.S)
    links = ["".join(parts) for parts in EXTERNAL_LINK.findall(text)]
    assert [x for x in links if not WELL_FORMED.fullmatch(x) or PLACEHOLDER.search(x)] == []


def test_every_page_can_be_reached_from_the_readme():
    """By links from page to page."""
    reached, ahead = set(), [ROOT / "README.md"]
    while ahead:
        page = ahead.pop()
        if page in reached or page not in PAGES:
            continue
        reached.add(page)
        found = LOCAL_LINK.findall(page.read_text(encoding="utf-8"))
        ahead += [(page.parent / path).resolve() for path, _ in found if path]
    assert sorted(name(page) for page in set(PAGES) - reached) == []


COMMANDS = ["", *command_names()]


@pytest.mark.sample(4)
@pytest.mark.parametrize("command", COMMANDS)
def test_help_has_an_example_that_runs(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
):
    words = shlex.split(example(help_of(command)))
    assert words, f"freebody {command} --help shows no example"
    assert words[0] == command or not command
    monkeypatch.chdir(tmp_path)
    status = run(words)
    assert (status, capsys.readouterr().err) == (0, "")


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_help_breaks_lines_where_the_terminal_does(command: str):
    """The source's line breaks would leave one word in a line: of two lines of a paragraph the
    first is so long that the next one's first word does not fit."""
    about = help_of(command).partition("Usage:")[2].partition("╭")[0]
    _, *paragraphs = re.split(r"\n *\n", about.strip())
    assert paragraphs
    for paragraph in paragraphs:
        for line, after in itertools.pairwise(map(str.strip, paragraph.splitlines())):
            assert len(line) + 1 + len(after.split()[0]) > 76, line


def test_every_public_name_is_in_the_list_of_functions():
    listed = re.findall(
        r"^\| `fb\.(\w+)` \|",
        (ROOT / "docs/functions.md").read_text(encoding="utf-8"),
        re.MULTILINE,
    )
    assert sorted(listed) == sorted(set(fb.__all__) - {"__version__"})


def test_what_a_model_has_is_listed():
    text = (ROOT / "docs/functions.md").read_text(encoding="utf-8")
    part = text.partition("## What a model has")[2].partition("\n## ")[0]
    listed = set(re.findall(r"`\.(\w+)", part))
    assert listed == {name for name in dir(fb.load("2R")) if not name.startswith("_")}


def test_every_variable_of_a_study_is_listed(tmp_path: Path):
    """With its dimensions, unit and meaning; those of a tree with a tip, a replay and no loops."""
    page = (ROOT / "docs/study.md").read_text(encoding="utf-8")
    tables = page.partition("### The variables of study.nc")[2]
    rows = re.findall(r"^\| `(\w+)` \| ([\w, ]*) \| ([^|]+) \| (.*) \|$", tables, re.MULTILINE)
    listed = {name: (dims, unit, what) for name, dims, unit, what in rows}
    named = "the tip, which the attribute `tip` names"
    fb.study(fb.load("2R")).save(tmp_path)
    with xarray.open_dataset(tmp_path / "study.nc") as data:
        assert listed == {
            name: (
                ", ".join(x.dims),
                x.attrs["units"].replace("|", " or "),
                re.sub(
                    "^(position|velocity|angular velocity) of tip$", rf"\1 of {named}", x.long_name
                ),
            )
            for name, x in data.data_vars.items()
        }
    for path in tmp_path.iterdir():
        assert f"`{path.name}`" in page


@pytest.mark.parametrize(
    ("kinds", "text"),
    [
        (KINDS, ROOT / "docs/formats.md"),
        (LOOP_KINDS, ROOT / "docs/formats.md"),
        (LOOP_KINDS, ROOT / "docs/closed-chains.md"),
        (LOOP_KINDS, fb.Model.with_loop.__doc__),
    ],
)
def test_every_kind_of_joint_and_loop_is_named_where_people_look(kinds, text):
    """The tables of kinds, which only the model's inside knows."""
    text = text.read_text(encoding="utf-8") if isinstance(text, Path) else text
    assert [kind for kind in kinds if not re.search(rf'[`"]{kind}[`"]', text)] == []


def test_files_that_the_architecture_sends_to_are_there():
    """In the table of what to change, each path below the package; a bare name is beside the one
    before it."""
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8").partition("| to change |")[2]
    folder, found = Path(), 0
    for path in re.findall(r"`([\w/]+(?:/|\.py))`", text):
        full = Path(path) if "/" in path else folder / path
        folder = full if path.endswith("/") else full.parent
        package = "src" if full.parts[0].startswith("freebody_") else "src/freebody"
        assert (ROOT / package / full).exists(), full
        found += 1
    assert found > 15


def layers() -> list[str]:
    """Of the contract in pyproject, from the top."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = settings["tool"]["importlinter"]["contracts"]
    return next(c["layers"] for c in contracts if c["id"] == "layers")


def test_the_architecture_describes_every_layer_and_folder():
    """Its table has a row for each layer, in their order; each row names the folders inside,
    and the picture each layer from the model upwards."""
    text = (ROOT / "docs/architecture.md").read_text(encoding="utf-8")
    table = text.partition("| layer |")[2].partition("\n\n")[0]
    rows = dict(re.findall(r"^\| `(\w+)` \|(.*)$", table, re.MULTILINE))
    assert list(rows) == layers()
    for folder in (ROOT / "src/freebody").glob("*/*"):
        if folder.is_dir() and not folder.name.startswith("_"):
            assert f"`{folder.name}`" in rows[folder.parent.name], folder
    picture = text.partition("## From a file to a number")[2].partition("## ")[0]
    shown = layers()[: layers().index("spatial")]
    assert [layer for layer in shown if layer not in picture] == []


@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize("robot", ["ur5e", pytest.param("five_bar", marks=pytest.mark.long)])
def test_the_pictures_that_move_are_what_their_script_makes(robot: str):
    """Apart from rounding; small enough for the README, which shows both."""
    made = runpy.run_path(str(ROOT / "tools/moving_pictures.py"))["picture"](robot)
    file = f"docs/images/{robot}_moving.svg"
    kept = (ROOT / file).read_text(encoding="utf-8")
    assert f'src="{file}"' in (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(kept) < 150_000
    number = re.compile(r"-?\d*\.?\d+")
    assert number.sub("", made).split() == number.sub("", kept).split()
    pairs = zip(number.findall(made), number.findall(kept), strict=True)
    assert all(abs(float(a) - float(b)) < 0.25 for a, b in pairs)


def test_what_contributing_names_is_there():
    """Files, by their path or its end, tables in capitals, and the layers in their order."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    files = [
        p
        for part in ("src", "tests", "tools", "benchmarks", "docs", ".ci")
        for p in (ROOT / part).rglob("*")
    ]
    parts = [path.relative_to(ROOT).parts for path in files]
    ends = {"/".join(way[k:]) for way in parts for k in range(len(way))}
    named = set(re.findall(r"[\w/.]+\.(?:py|toml)\b", text)) - {"tests/test_x.py", "pyproject.toml"}
    assert named - ends == set()
    code = "".join(p.read_text(encoding="utf-8") for p in files if p.suffix == ".py")
    tables = set(re.findall(r"`(_?[A-Z]{3,}[A-Z_]*)`", text))
    assert len(tables) > 10
    assert tables - set(re.findall(r"\b_?[A-Z]{3,}[A-Z_]*\b", code)) == set()
    assert " · ".join(layers()) in text
