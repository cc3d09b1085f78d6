"""Whatever turns text or data into code: every place, with the reason why nothing from outside
reaches it.

Names in robot files are data. This test walks the syntax tree of every module; a new place fails it
until someone has written down here why it is safe.
"""

from __future__ import annotations

import ast
import dataclasses
import keyword
import string
import unicodedata

import numpy as np
import pytest

import freebody as fb
from freebody.identifiers import identifiers, in_words, is_identifier
from freebody.program import Argument, ProgramError, trace
from freebody.targets import compile_program
from freebody.targets.text import LANGUAGES, SourceUnit
from freebody_notes import contents, derivation_places
from support.sources import SOURCES, parsed, place

EXECUTES = {
    # Python
    "exec", "eval", "compile", "__import__", "import_module", "FunctionType", "CodeType",
    "run_path", "run_module",
    "exec_module", "execfile", "sympy.S",
    # LLVM
    "parse_assembly", "parse_bitcode", "add_object_file", "add_object_img", "add_ir", "add_module",
    "add_file",
    # NVIDIA's driver
    "bindings",
    # SymPy
    "sympify", "parse_expr", "lambdify", "autowrap", "ufuncify", "sympy.symbols", "sympy.var",
    # objects that carry code
    "pickle", "load_module", "dill", "marshal", "shelve", "joblib",
    # programs
    "subprocess", "os.system", "popen", "Popen", "run_command", "startfile", "execv", "execve",
    "spawnv", "posix_spawn",
    # templates made from strings, text that is not escaped, arrays that hold objects
    "Template", "from_string", "compile_expression", "Markup", "safe_load", "fromfile",
    "allow_pickle", "save_module",
    # the interpreter's own objects
    "make_dataclass", "setattr", "from_address", "CDLL", "PYFUNCTYPE", "CFUNCTYPE", "pythonapi",
    "cdll", "windll",
    "new_class", "InteractiveInterpreter", "runsource", "read_pickle", "nsimplify", "webbrowser",
    # readers of foreign files that are not ours
    "trimesh", "open_dataset", "ElementTree",
}  # fmt: skip

KNOWN = {
    ("formats/mjcf/compiled.py", "from_string"): "MuJoCo's parser of XML, in a process of its own",
    ("identification/calibration/chain.py", "compile"): "fb.compile of a function of our own",
    ("locks.py", "import_module"): "modules of the table of public names, and those that are there",
    ("targets/llvm/fastcall.py", "import_module"): "a constant: NumPy's own module",
    ("sweeps/run.py", "pickle"): "a sweep from the process that called it, through Dask, which "
    "pickles what it sends in the same way",
    ("model/description.py", "make_dataclass"): "the numbers of the laws of drives, by names that "
    "stand in their files",
    (
        "formats/mjcf/compilation.py",
        "subprocess",
    ): "this Python with a file of freebody's own, which "
    "has MuJoCo parse the user's; its path is an argument, never a shell's text",
    ("ways_out/fmus.py", "subprocess"): "a C compiler from the path, on text that holds words of "
    "freebody's own alone; no shell",
    ("outputs/pdf.py", "subprocess"): "a browser from the path, on a page of freebody's own whose "
    "policy lets no script run; no shell",
    ("ways_out/fmus.py", "ElementTree"): "writes XML, and reads none",
    ("formats/writing/xml.py", "ElementTree"): "writes XML, and reads none",
    ("identification/columns.py", "compile"): "formulas of scalars, by fb.compile; no text",
    ("identification/excitation/motion_limits.py", "compile"): "formulas of our own, by fb.compile",
    ("model/edits.py", "setattr"): "constant names, when the module is imported",
    ("freebody_notes/contents.py", "import_module"): "the parts that contents.toml lists",
    (
        "targets/llvm/machine.py",
        "parse_assembly",
    ): "LLVM text of a verified Program: its names are words of freebody's own",
    ("targets/cuda/ptx.py", "parse_assembly"): "the same, for GPUs",
    ("targets/cuda/driver.py", "bindings"): "assembles PTX that LLVM has made of that text",
    (
        "targets/llvm/loader.py",
        "add_object_file",
    ): "what was compiled from that text, or found in the user's own cache",
    ("targets/llvm/loader.py", "CDLL"): "constants: the C library, and on Windows the system's",
    ("targets/llvm/loader.py", "parse_assembly"): "an empty text",
    ("targets/llvm/cpu.py", "from_address"): "a field of a ufunc that was just made",
    ("targets/llvm/fastcall.py", "pythonapi"): "constant names of CPython's functions",
    ("targets/llvm/cpu.py", "pythonapi"): "constant names of CPython's functions",
    (
        "formats/meshes.py",
        "trimesh",
    ): "bytes of four formats of shapes, for estimate_inertia, of two of them for drawings",
    ("targets/llvm/cpu.py", "PYFUNCTYPE"): "functions of NumPy's table",
    (
        "targets/llvm/scan.py",
        "CFUNCTYPE",
    ): "a constant text that was compiled, code of a verified Program, and how it is called",
    (
        "freebody_notes/checks/calls.py",
        "eval",
    ): "calls that stand in freebody_notes; held to that below",
    (
        "freebody_notes/derivation_places.py",
        "eval",
    ): "calls that stand in freebody_notes; held to that below",
    ("cli/studio.py", "webbrowser"): "the address of a page that freebody has just written, whose "
    "policy lets its own script alone run",
    ("report/page.py", "Markup"): "our own style, and drawings, whose text is escaped",
    ("report/tables.py", "Markup"): "text that has just been escaped",
    ("freebody_notes/page.py", "Markup"): "formulas and drawings of the notes' own items",
    ("report/page_tables.py", "Markup"): "cells that were escaped there",
    (
        "freebody_notes/exercises.py",
        "Markup",
    ): "solutions are put together from the notes' own items",
}
"""(file, what) -> why nothing from outside reaches it."""


def names_used(tree: ast.AST) -> set[str]:
    """Names that are called, imported, read as attributes or passed by keyword; methods of `re` are
    none of them."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute):
            owner = node.value.id if isinstance(node.value, ast.Name) else ""
            if (owner, node.attr) != ("re", "compile"):
                found |= {node.attr, f"{owner}.{node.attr}"}
        elif isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.keyword) and node.arg:
            found.add(node.arg)
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            found |= {part for alias in node.names for part in alias.name.split(".")}
            found |= set((getattr(node, "module", None) or "").split("."))
    return found


def places() -> set[tuple[str, str]]:
    found = set()
    for path in SOURCES:
        tree = parsed(path)
        called = names_used(tree) & EXECUTES
        found |= {(place(path), name) for name in called}
    return found


def test_whatever_executes_or_compiles_text_is_known_with_its_reason():
    assert places() == set(KNOWN)
    assert all(KNOWN.values())


def test_the_walk_sees_what_it_looks_for():
    tree = ast.parse(
        "import subprocess\nfrom pickle import loads as l\nf = eval\nt = "
        "jinja2.Template(x)\nnp.load(f, allow_pickle=1)"
    )
    assert {"subprocess", "pickle", "eval", "Template", "allow_pickle"} <= names_used(
        tree
    ) & EXECUTES


def test_a_class_made_at_run_time_has_a_constant_name():
    for path in SOURCES:
        for node in ast.walk(parsed(path)):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Name)
                and node.func.id == "type"
            ):
                assert len(node.args) == 1 or isinstance(node.args[0], ast.Constant), path


def test_templates_are_files_and_escape():
    for path in SOURCES:
        text = path.read_text(encoding="utf-8")
        if "jinja2.Environment(" in text:
            assert "autoescape=True" in text, path


def test_calls_that_the_notes_execute_are_made_with_the_package():
    """No call stands in a data file; those of the checks name nothing but freebody and NumPy."""
    calls = [call for chapter in derivation_places._CALLS.values() for call in chapter]
    for item in contents.items():
        calls += [
            x
            for name in ("model", "values")
            if isinstance(x := getattr(item.check, name, None), str)
        ]
    assert len(calls) > 60
    for call in calls:
        tree = ast.parse(call, mode="eval")
        assert {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} <= {
            "fb",
            "np",
            "rows",
        }, call


# ---------------------------------------------------------------- a program holds no name from
# outside
@pytest.mark.parametrize(
    "name",
    ["tool tip", "a\nb", '"""', "θ", "", "lambda", "__class__", "1st", "x\x00", "a.b", "a+b"],
)
def test_a_name_from_outside_is_refused_in_a_program(name):
    inner = Argument("q", (1,))
    with pytest.raises(ProgramError, match="is not a word of letters a-z, digits and _"):
        trace("f", lambda x: ([x[0]],), [Argument(name, (1,))], [inner])
    with pytest.raises(ProgramError, match="is not a word"):
        trace(name, lambda x: ([x[0]],), [inner], [inner])
    made = trace("f", lambda x: ([x[0]],), [inner], [Argument("y", (1,))])
    for target in ("cpu", "numpy"):
        with pytest.raises(ProgramError, match="is not a word"):
            compile_program(dataclasses.replace(made, name=name), target=target)
    with pytest.raises(ProgramError, match="is not a word"):
        SourceUnit(dataclasses.replace(made, outputs=(Argument(name, (1,)),)), "f")
    with pytest.raises(ProgramError, match="is not a word"):
        SourceUnit(made, name)


@pytest.mark.parametrize(
    "remark", ["*/ int x;", '"""', "a\nb", "\\", "θ", "%{", "${x}", "#{x}", "`"]
)
def test_a_remark_that_could_end_a_comment_is_refused(remark):
    made = trace("f", lambda x: ([x[0]],), [Argument("q", (1,))], [Argument("y", (1,))])
    with pytest.raises(ProgramError, match="a comment must not contain"):
        SourceUnit(made, "f", (remark,))


def test_inputs_that_are_called_like_the_emitted_texts_own_words_are_renamed():
    inputs = [Argument(x, (1,)) for x in ("batch", "xp", "sin", "v0", "f", "q")]
    program = trace("f", lambda *x: ([sum(y[0] for y in x)],), inputs, [Argument("y", (1,))])
    scope: dict = {}
    exec(LANGUAGES["numpy"].emit(SourceUnit(program, "f")), scope)
    assert scope["f"](*(np.array([float(k)]) for k in range(6))).tolist() == [15.0]


# ---------------------------------------------------------------- words from names
NAMES = [
    "tool0", "tool0 ", "tool-0", "θ₁", "θ1", "关节", "left/joint1", "left_joint1", "lambda",
    "__debug__", "_Bool", "",
    "\x00", "2nd", '"""\nimport os', "é", "e", "\u202eevil", "a" * 5000, "a" * 4999, "Ω", "ω",
    "self", "𝐪", "q",
    "__class__", "if", "{}", "%s", "\\",
]  # fmt: skip


def test_words_made_from_names_are_identifiers_and_unique():
    words = identifiers(NAMES, {"self", "left_joint1"})
    assert list(words) == NAMES
    assert all(
        is_identifier(word) and word.isascii() and word.isidentifier() for word in words.values()
    )
    assert len(set(words.values())) == len(NAMES)
    assert not {"self", "left_joint1"} & set(words.values())
    assert all(not keyword.iskeyword(word) and len(word) < 300 for word in words.values())
    assert (words["tool0"], words["θ₁"], words["q"], words["lambda"]) == (
        "tool0",
        "theta1",
        "q",
        "lambda_",
    )
    assert words["θ1"] == "theta1_2"
    # what Python makes of an identifier before it compares
    assert len({unicodedata.normalize("NFKC", word) for word in words.values()}) == len(NAMES)


def test_ten_thousand_equal_words_take_no_time():
    assert len(set(identifiers(("关" * n for n in range(1, 10_000)), ()).values())) == 9_999


def test_comments_hold_words_only():
    for name in NAMES:
        assert set(in_words(f"{name} */ {name}")) <= set(
            string.ascii_letters + string.digits + "_ "
        )


def test_parameters_of_emitted_equations_are_words():
    model = fb.planar("RR", l=["θ", "l2"], lc=["q", "lambda_"], m=["关", "m2"], I=["cos_1", "q_"])
    values = {
        "θ": 0.4,
        "q": 0.2,
        "关": 1.5,
        "cos_1": 0.1,
        "l2": 0.3,
        "lambda_": 0.1,
        "m2": 0.7,
        "q_": 0.05,
    }
    bound = model.bind(**values)
    scope: dict = {}
    text = fb.equations(bound).python()
    exec(text, scope)
    M, *_ = scope["dynamics"]([0.3, -0.4], [0.0, 0.0], [0.0, 0.0])
    np.testing.assert_allclose(M, fb.mass_matrix(bound, [0.3, -0.4]), rtol=1e-14)
    assert text.isascii()
