"""Mutation testing: change the source in one place, and see whether the tests notice.

    python tools/mutants.py --seed 1 --count 60          # the drawn mutants, each with its verdict
    python tools/mutants.py --only src/freebody/spatial.py:120:8

Mutants are drawn by a seeded generator, the same share from every area, from the places that decide
something: signs, operators, comparisons, conditions, numbers, tolerances among them, indices, the
order of arguments. Each runs in a copy of the source, against the area's own tests, until the first
that fails: first those that name the file's module, then the others in the order given here. Exit
status 1 if one survives.
"""

from __future__ import annotations

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from types import UnionType
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
SOURCE = ROOT / "src"
PACKAGES = ("freebody", "freebody_textbook")
LIMIT = 1200.0
"""Seconds for one mutant's tests; one that hangs them is killed, in both senses."""


@dataclass(frozen=True)
class Area:
    """Where mutants are drawn from, and the tests that have to see them."""

    name: str
    sources: tuple[str, ...]
    tests: tuple[str, ...]

    def files(self) -> list[Path]:
        """The files of its sources, which are paths in the core unless they name a package."""
        found = set[Path]()
        for pattern in self.sources:
            package = "" if pattern.partition("/")[0] in PACKAGES else "freebody/"
            found.update(SOURCE.glob(package + pattern))
        return sorted(found)


AREAS = (
    Area(
        "algorithms",
        ("algorithms/*.py", "spatial.py", "model/joints/*.py",
         "model/drives/*.py"),
        ("yardsticks", "base_parameters", "states", "derivatives", "recursions",
         "operational", "equations", "steps", "controllers", "time_optimal",
         "laws", "drives", "pinocchio"),
    ),
    Area(
        "control laws",
        ("algorithms/controllers/*.py", "trees/controllers.py", "trees/linearization_and_lqr.py"),
        ("controllers", "linearization"),
    ),
    Area(
        "kernels",
        ("program/*.py", "targets/*.py", "targets/llvm/*.py", "scalars/*.py", "kernels/**/*.py",
         "scalar_math.py", "elementary.py", "dual.py"),
        ("program", "kernels", "threads", "vector_functions", "code_cache", "scalars", "fastcall",
         "columns", "operational", "order_of_calls", "code_from_text", "memory", "compile",
         "differentials", "parameter_derivatives", "numerics_errors", "equations", "laws"),
    ),
    Area(
        "ways out",
        ("targets/text/*.py", "targets/xla/*.py", "targets/cuda/*.py", "targets/torch_operator.py",
         "ways_out/*.py"),
        ("exports", "export_names", "jax", "xla", "cuda"),
    ),
    Area(
        "public functions",
        ("trees/*.py", "any_chain/dynamics.py", "any_chain/kernel_options.py", "arrays.py",
         "labels.py", "errors.py", "by_value.py",
         "lazy.py", "locks.py", "identifiers.py"),
        ("arguments", "labelled", "input", "values", "fastcall", "states", "operational",
         "base_parameters", "passive", "massless", "memory", "forks_and_interrupts", "warnings"),
    ),
    Area(
        "models and files",
        ("model/*.py", "model/doubt_rules/*.py", "formats/*.py", "formats/xacro/*.py",
         "formats/mjcf/*.py", "formats/writing/*.py", "diagnosis/*.py",
         "diagnosis/findings/*.py", "robots/*.py"),
        ("model", "inertia", "structure", "families", "changed_copies", "formats_toml",
         "formats_urdf", "formats_files", "xacro", "mjcf", "sdf", "masses",
         "parameter_formulas", "planar_dh", "robots",
         "joint_kinds", "pickling", "reading", "massless"),
    ),
    Area(
        "inverse and reach",
        ("inverse/**/*.py", "reach/*.py", "algorithms/closed_form_inverse/*.py"),
        ("inverse_kinematics", "inverse_velocity", "singularities", "inverse_ways", "branches",
         "calibrated_arms", "dexterity", "payload_map", "workspace", "reach_diagrams",
         "compliance", "compliant_loops"),
    ),
    Area(
        "motions",
        ("motion/*.py", "motion/files/*.py", "motion/planning/*.py", "motion/optimal/*.py"),
        ("motion", "motion_files", "planned_motions", "tip_motions", "measured",
         "planning_internals", "time_optimal", "time_optimal_closed", "closed_plans", "cli"),
    ),
    Area(
        "identification",
        (
            "identification/*.py", "identification/logs/*.py", "identification/calibration/*.py",
            "identification/excitation/*.py",
        ),
        (
            "logs",
            "broken_logs",
            "excitation",
            "identify",
            "identify_payload",
            "collisions",
            "friction_drift",
            "identify_command",
            "calibrate",
        ),
    ),
    Area(
        "design",
        ("design/*.py",),
        ("parts", "duty_cycle", "size", "size_command", "bearings", "load_tables", "stops"),
    ),
    Area(
        "simulation",
        ("motion/simulation/*.py",),
        ("simulate", "simulate_many", "simulate_torques", "simulate_wrenches", "joint_contacts",
         "simulate_command", "simulation_internals", "steps", "closed_steps"),
    ),
    Area(
        "closed chains",
        ("loops/**/*.py", "model/loop_kinds.py", "model/loops.py", "motion/closed_chain*.py",
         "motion/simulation/first_order_system.py",
         "any_chain/reactions.py", "any_chain/effort_limits.py"),
        ("closed_*", "dyads", "simulate"),
    ),
    Area(
        "studies and sweeps",
        ("capacity/*.py", "report/*.py", "sweeps/*.py", "outputs/**/*.py", "cli/*.py",
         "beside.py"),
        ("verdict", "payload", "load_case", "study", "study_internals", "report_page",
         "numbers_in_print", "print_internals", "outputs", "display", "cli", "terminal",
         "completion", "sweeps", "sweep_stores", "sweep_internals", "page_sizes"),
    ),
    Area(
        "figures",
        ("figures/**/*.py", "moving/*.py", "studio/*.py",
         "freebody_textbook/living/*.py"),
        ("figures", "diagrams", "free_bodies", "living_units", "hostile_names", "reach_diagrams",
         "moving_page_browser", "studio_browser"),
    ),
    Area(
        "derivations",
        ("freebody_textbook/*.py", "freebody_textbook/methods/*.py",
         "freebody_textbook/commands/*.py", "freebody_textbook/drawings/*.py",
         "freebody_textbook/closed_chains/*.py", "freebody_textbook/render/*.py",
         "freebody_textbook/equations/*.py", "freebody_textbook/relations/*.py",
         "expressions/**/*.py"),
        ("derivation_words", "equations", "expression", "relation", "closed_equations",
         "closed_derivations", "naming", "notations", "vector_functions", "term_sources",
         "names_in_print", "print_internals", "singularities", "diagrams", "notes",
         "zero_parameters", "derive",
         "kane", "modular", "inverse_kinematics"),
    ),
    Area(
        "check",
        ("freebody_textbook/check/**/*.py",),
        ("check", "check_other_forms", "check_numbers", "advice", "check_generated", "notes"),
    ),
)  # fmt: skip

BINARY = {
    ast.Add: "-",
    ast.Sub: "+",
    ast.Mult: "/",
    ast.Div: "*",
    ast.FloorDiv: "*",
    ast.Mod: "*",
    ast.MatMult: "@ -",
}
COMPARED = {
    ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "==",
    ast.Is: "is not", ast.IsNot: "is", ast.In: "not in", ast.NotIn: "in",
}  # fmt: skip


@dataclass(frozen=True)
class Mutant:
    """Text that replaces a span of a file."""

    path: Path
    line: int
    column: int
    start: int
    stop: int
    text: str
    was: str

    def __str__(self) -> str:
        place = f"{self.path.relative_to(ROOT)}:{self.line}:{self.column}"
        return f"{place}  {self.was!r} -> {self.text!r}"


def mutants(path: Path) -> Iterator[Mutant]:
    """Every mutant of a file."""
    source = path.read_text(encoding="utf-8")
    offsets = [0]
    for line in source.splitlines(keepends=True):
        offsets.append(offsets[-1] + len(line.encode()))
    raw = source.encode()

    def span(node: ast.AST) -> tuple[int, int]:
        return (
            offsets[node.lineno - 1] + node.col_offset,
            offsets[node.end_lineno - 1] + node.end_col_offset,
        )

    for node in ast.walk(ast.parse(source)):
        for kind, change in CHANGES.items():
            if isinstance(node, kind):
                found = change(node, span, raw)
                if found is not None:
                    start, stop, text = found
                    was = raw[start:stop].decode()
                    yield Mutant(path, node.lineno, node.col_offset, start, stop, text, was)


Span = Callable[[ast.AST], tuple[int, int]]
Change = tuple[int, int, str] | None
"""The span of the file that is replaced, and by what; None where nothing is."""


def _other_operation(node: ast.BinOp, span: Span, raw: bytes) -> Change:
    between = span(node.left)[1], span(node.right)[0]
    plain = raw[slice(*between)].strip().decode() in ("+", "-", "*", "/", "//", "%", "@")
    return (*between, f" {BINARY[type(node.op)]} ") if plain and type(node.op) in BINARY else None


def _other_comparison(node: ast.Compare, span: Span, raw: bytes) -> Change:
    if len(node.ops) != 1:
        return None
    return _between(node.left, node.comparators[0], COMPARED[type(node.ops[0])], span, raw)


def _other_junction(node: ast.BoolOp, span: Span, raw: bytes) -> Change:
    word = "or" if isinstance(node.op, ast.And) else "and"
    return _between(node.values[0], node.values[1], word, span, raw)


def _between(left: ast.AST, right: ast.AST, text: str, span: Span, raw: bytes) -> Change:
    """What stands between two nodes, if no bracket does."""
    between = span(left)[1], span(right)[0]
    return None if {*b"()"} & {*raw[slice(*between)]} else (*between, f" {text} ")


def _without_sign(node: ast.UnaryOp, span: Span, raw: bytes) -> Change:
    signed = isinstance(node.op, ast.Not | ast.USub)
    return (span(node)[0], span(node.operand)[0], "") if signed else None


def _other_constant(node: ast.Constant, span: Span, raw: bytes) -> Change:
    value = node.value
    if isinstance(value, bool) or (isinstance(value, int | float) and value in (0, 1, 2)):
        return *span(node), str(not value if isinstance(value, bool) else value + 1)
    if isinstance(value, float) and isfinite(value):  # a tolerance is tried two powers of ten off
        return *span(node), repr(value * (100.0 if abs(value) < 0.02 else 1.5))
    return None


_ONE_WAY = ("isinstance", "map", "getattr", "cast", "add", "dot", "maximum", "minimum")
"""Functions that do not run with their arguments the other way round, or do the same."""


def _swapped_arguments(node: ast.Call, span: Span, raw: bytes) -> Change:
    """The first two arguments, in the other order."""
    if len(node.args) < 2 or any(isinstance(x, ast.Starred) for x in node.args[:2]):
        return None
    if isinstance(node.func, ast.Name) and node.func.id in _ONE_WAY:
        return None
    (start, end), (begin, stop) = map(span, node.args[:2])
    one, between, other = raw[start:end], raw[end:begin], raw[begin:stop]
    if one == other:
        return None
    return start, stop, (other + between + one).decode()


def _other_branch(node: ast.If | ast.IfExp, span: Span, raw: bytes) -> Change:
    start, stop = span(node.test)
    return start, stop, f"not ({raw[start:stop].decode()})"


CHANGES: dict[type[ast.AST] | UnionType, Callable[[Any, Span, bytes], Change]] = {
    ast.BinOp: _other_operation,
    ast.Compare: _other_comparison,
    ast.BoolOp: _other_junction,
    ast.UnaryOp: _without_sign,
    ast.Constant: _other_constant,
    ast.If | ast.IfExp: _other_branch,
    ast.Call: _swapped_arguments,
}


def drawn(seed: int, count: int, only: str | None) -> list[tuple[Area, Mutant]]:
    """The same number from each area, drawn without replacement."""
    generator = random.Random(seed)
    found = []
    for k, area in enumerate(AREAS):
        files = area.files()
        every = [mutant for path in files for mutant in mutants(path)]
        share = count // len(AREAS) + (k < count % len(AREAS))
        some = generator.sample(every, share)
        found += [(area, mutant) for mutant in some if only in (None, area.name)]
    return found


def survives(
    area: Area, mutant: Mutant, first: int | None = None, named: str | None = None
) -> tuple[bool, str]:
    """Whether all tests of the area, of its first files, or of those that are named, pass with the
    mutant, and the first that does not."""
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder) / "tree"
        shutil.copytree(ROOT, work, ignore=_ignored())
        target = work / mutant.path.relative_to(ROOT)
        raw = target.read_bytes()
        target.write_bytes(raw[: mutant.start] + mutant.text.encode() + raw[mutant.stop :])
        if named is None:
            tests = list(map(str, _tests(area, mutant.path, work / "tests")))[:first]
        else:
            tests = [
                str(path)
                for name in named.split(",")
                for path in (work / "tests").rglob(f"test_{name}.py")
            ]
        environment = {
            **os.environ,
            "PYTHONPATH": str(work / "src"),
            "FREEBODY_CACHE": str(Path(folder) / "cache"),
        }
        command = [
            sys.executable,
            "-m",
            "pytest",
            "-x",
            "-q",
            "-rfE",  # a line for each that fails, which says its name
            "-n0",
            "--no-header",
            "-p",
            "no:cacheprovider",
            *tests,
        ]
        try:
            run = subprocess.run(
                command,
                cwd=work,
                env=environment,
                capture_output=True,
                text=True,
                timeout=LIMIT,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return False, "the tests hang"
        failed = [x for x in run.stdout.splitlines() if x.startswith(("FAILED", "ERROR"))]
        return run.returncode == 0, failed[0][:150] if failed else run.stdout[-150:].strip()


def _ignored() -> Callable[..., set[str]]:
    """What is not copied: the history, and what git ignores. Tests read documentation, tools and
    benchmarks too: a mutant whose tests lack a file would count as killed."""
    lines = (ROOT / ".gitignore").read_text(encoding="utf-8").splitlines()
    patterns = [line.strip("/") for line in lines if line and not line.startswith("#")]
    return shutil.ignore_patterns(".git", *patterns)


def _tests(area: Area, path: Path, folder: Path) -> list[Path]:
    """The area's test files, first those that name the file's module or a public name of its own;
    each once."""
    found = [file for name in area.tests for file in sorted(folder.rglob(f"test_{name}.py"))]
    words = {path.stem, *(f"fb.{name}" for name in _public(path))}
    named = re.compile(rf"\b({'|'.join(map(re.escape, sorted(words)))})\b")
    return sorted(
        dict.fromkeys(found), key=lambda file: not named.search(file.read_text(encoding="utf-8"))
    )


def _public(path: Path) -> list[str]:
    """Functions and classes that a file defines under names without underscore."""
    return [
        node.name
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_")
    ]


def outside() -> list[Path]:
    """Files of the source in no area, but those that hold no more than a list of names."""
    inside = {file for area in AREAS for file in area.files()}
    return [
        file
        for package in PACKAGES
        for file in sorted((SOURCE / package).glob("**/*.py"))
        if file not in inside and next(mutants(file), None) and file.stem[:2] != "__"
    ]


def main() -> int:
    """Draw, run, tell."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=60)
    parser.add_argument(
        "--area", choices=[area.name for area in AREAS], help="of those drawn, this area's"
    )
    parser.add_argument("--only", help="FILE:LINE:COLUMN of one mutant")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--list", action="store_true", help="say what would be run")
    parser.add_argument("--first", type=int, help="of each mutant's test files only so many")
    parser.add_argument("--tests", help="test files instead of the area's: closed_dynamics,laws")
    options = parser.parse_args()
    if left_out := outside():
        parser.error(f"in no area: {', '.join(map(str, left_out))}")
    chosen = drawn(options.seed, options.count, options.area)
    if options.only:
        files = [(a, f) for a in AREAS for f in a.files()]
        chosen = [
            (area, m)
            for area, f in files
            for m in mutants(f)
            if str(m).startswith(options.only + " ")
        ]
    if options.list:
        print("\n".join(f"{area.name}: {mutant}" for area, mutant in chosen))
        return 0
    alive = 0
    with ThreadPoolExecutor(options.jobs) as pool:
        for (area, mutant), (lives, why) in zip(
            chosen,
            pool.map(lambda x: survives(*x, options.first, options.tests), chosen),
            strict=True,
        ):
            alive += lives
            print(
                f"{'SURVIVES' if lives else 'killed  '}  {area.name}: {mutant}   "
                f"{'' if lives else why}",
                flush=True,
            )
    print(f"{len(chosen) - alive} of {len(chosen)} killed")
    return 1 if alive else 0


if __name__ == "__main__":
    raise SystemExit(main())
