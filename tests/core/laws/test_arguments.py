"""What public functions and commands are given is used, or refused with what to write instead."""

import inspect
import pickle
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import KindError
from support.command import run

FUNCTIONS = {
    name: getattr(fb, name)
    for name in sorted(fb.__all__)
    if inspect.isfunction(getattr(fb, name, None))
}
OF_MODELS = [
    name
    for name, function in FUNCTIONS.items()
    if [*inspect.signature(function).parameters][:1] == ["model"]
]
KEYWORDS: dict[str, dict[str, Any]] = {"reactions": {"tau": np.zeros(6)}}


def call(name: str, first: Any) -> Any:
    """A call with a first argument, and zeros for whatever else is needed."""
    parameters = list(inspect.signature(FUNCTIONS[name]).parameters.values())[1:]
    needed = [p for p in parameters if p.default is p.empty and p.kind is p.POSITIONAL_OR_KEYWORD]
    return FUNCTIONS[name](first, *(np.zeros(6) for _ in needed), **KEYWORDS.get(name, {}))


@pytest.mark.sample(163)
@pytest.mark.parametrize(
    "first", ["ur5e", Path("arm.urdf"), None, [1.0], np.zeros(6), fb.Model], ids=repr
)
@pytest.mark.parametrize("name", OF_MODELS)
def test_what_is_no_model_is_refused_with_what_to_write(name: str, first: Any):
    with pytest.raises(KindError, match=rf"^{name}: the first argument is ") as problem:
        call(name, first)
    advice = re.search(r"Write (fb\.\w+\(.*)$", str(problem.value))
    assert advice is not None
    assert advice[1].startswith(f"fb.{name}(")
    if isinstance(first, str | Path):
        assert f"fb.load('{first}')" in advice[1]


def takes_places(function: Callable[..., Any]) -> bool:
    """Whether a function can be called with arguments in their places alone."""
    parameters = inspect.signature(function).parameters.values()
    needed = any(p.kind is p.KEYWORD_ONLY and p.default is p.empty for p in parameters)
    return bool(parameters) and not needed


@pytest.mark.sample(12)
@pytest.mark.parametrize("name", [n for n, f in FUNCTIONS.items() if takes_places(f)])
def test_what_is_nothing_at_all_is_refused_in_words(name: str):
    """As the argument behind the model, or where there is none as the first."""
    first, *others = list(inspect.signature(FUNCTIONS[name]).parameters.values())
    before = [fb.load("2R")] if first.name == "model" else []
    wrong = [first, *others][len(before) :]
    if not wrong or wrong[0].kind not in (first.POSITIONAL_OR_KEYWORD, first.POSITIONAL_ONLY):
        return  # there is no such argument
    needed = [p for p in wrong[1:] if p.default is p.empty and p.kind is p.POSITIONAL_OR_KEYWORD]
    with pytest.raises(fb.FreebodyError):
        FUNCTIONS[name](*before, object(), *(np.zeros(2) for _ in needed))


UR5E = fb.load("ur5e")
NAMED: list[tuple[Callable[[], Any], str]] = [
    (lambda: fb.payload(UR5E, 7), "payload: motion is int 7, expected a Motion"),
    (lambda: fb.payload(UR5E, [1.0]), "payload: motion: q has shape (1,)"),
    (lambda: fb.default_motion(UR5E, "x"), "default_motion: duration is 'x'"),
    (lambda: fb.default_motion(UR5E, -1), "duration is -1, expected a number of seconds above 0"),
    (lambda: fb.default_motion(UR5E, samples=7), "samples is 7, expected a whole number"),
    (lambda: fb.derive(UR5E, np.zeros(2)), "derive: method is ndarray"),
    (lambda: fb.equations(fb.planar("R"), "no"), "equations: numbers is str 'no'"),
    (lambda: fb.save(UR5E, 7), "save: path is int 7"),
    (lambda: fb.smoothed(UR5E, None), "smoothed: motion is None"),
    (lambda: fb.rotation(7, [0.0]), "rotation: axes is int 7"),
    (lambda: fb.notes_figure(3.2), "notes_figure: number is float 3.2"),
    (lambda: fb.mean_load({"a": 1}, [1], [1], 3), "mean_load: load"),
    (lambda: fb.inertia_from("x", [0, 0], 1.0, [0, 0]), "inertia_from: mass is 'x'"),
    (lambda: fb.inertia_from(1.0, [0, 0], np.eye(3), [0, 0]), "tensor has shape (3, 3)"),
    (lambda: fb.integrated_inertia(7, [(0, 1)]), "integrated_inertia: points is int 7"),
    (lambda: fb.integrated_inertia(np.sin, [0, 1]), "integrated_inertia: bounds is list"),
    (lambda: fb.vector_function("x", ["x"]), "vector_function: rows is str 'x'"),
    (lambda: fb.relation(7, "a = b"), "relation: values is int 7"),
    (lambda: fb.same_robot(UR5E, 7), "same_robot: b is int 7"),
    (lambda: fb.DutyCycle(7), "DutyCycle: segments is int 7"),
    (lambda: fb.PartCatalogue(7), "PartCatalogue: motors is int 7"),
    (lambda: fb.floor_loads(UR5E, [1.0]), "floor_loads: cycles[0] is float 1.0"),
]


@pytest.mark.parametrize("case", range(len(NAMED)))
def test_refusals_name_the_argument_as_the_signature_does(case: int):
    function, words = NAMED[case]
    with pytest.raises(fb.FreebodyError, match=re.escape(words)):
        function()


def test_most_functions_take_a_model():
    assert len(OF_MODELS) > 55


def test_public_functions_keep_name_signature_and_pickle():
    for name in OF_MODELS:
        function = FUNCTIONS[name]
        assert function.__name__ == name
        assert pickle.loads(pickle.dumps(function)) is function
    assert "tolerance" in inspect.signature(fb.simulate).parameters
    arm = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0])
    assert fb.mass_matrix(model=arm, q=[0.0]) == pytest.approx(0.25)


# ---------------------------------------------------------------- arguments that would not be used
ARM = fb.load("2R")


def call_study(motion: Any) -> Any:
    """A study along what may be no motion."""
    return fb.study(ARM, motion)


UNUSED: list[tuple[Callable[[], Any], str]] = [
    (lambda: fb.derive(ARM, "lagrange", route="x"), "route is an option of 'newton-euler'"),
    (lambda: fb.derive(ARM, "recursive", route="pivot"), "route is an option of 'newton-euler'"),
    (lambda: fb.derive(ARM, "statics", rout="pivot"), "no option 'rout' in derive 'statics'"),
    (lambda: fb.derive(ARM, "kinematics", load=True), "forces do not occur in it"),
    (lambda: call_study((np.zeros(3), np.zeros((3, 2)))), "expected a Motion, a CSV file"),
    (lambda: fb.kernel(ARM, "mass_matrix", reference="body"),
     "reference='body' has no meaning for mass_matrix"),
    (lambda: fb.kernel(ARM, "mass_matrix", frame="tip"), "frame='tip' has no meaning"),
    (lambda: fb.kernel(ARM, "mass_matrix", frame=""), "frame='' has no meaning"),
    (lambda: fb.kernel(ARM, ["jacobian", "joint_wrenches"], reference="child"),
     "no reference 'child'"),
    (lambda: fb.kernel(ARM, ["jacobian", "joint_wrenches"], reference="body"),
     "no reference 'body'"),
    (lambda: fb.kernel(ARM, "jacobian", rows=["vx"]), "has no meaning for jacobian"),
    (lambda: fb.kernel(ARM, "bias", wrench_frames=["tip"]), "has no meaning for bias"),
    (lambda: fb.load("2R", convention="standard"), "convention= is for DH tables in .csv files"),
    (lambda: fb.inverse_kinematics(ARM, [0.3, 0.2], starts=0), "starts is 0, expected at least 1"),
    (lambda: fb.kinematic_diagram(ARM, [0, 0], qd=[1, 1]),
     "qd is not drawn in geometry, vectors: say show='veloc"),
    (lambda: fb.kinematic_diagram(ARM, [0, 0], "velocities", [1, 1], [1, 1]),
     "qdd is not drawn in velocities"),
    (lambda: fb.quantities(ARM, gravity="none"), "no gravity 'none' in fb.quantities"),
]  # fmt: skip


@pytest.mark.parametrize("case", range(len(UNUSED)))
def test_arguments_that_would_not_be_used_are_refused(case: int):
    function, words = UNUSED[case]
    with pytest.raises(fb.FreebodyError, match=re.escape(words)):
        function()


@pytest.mark.parametrize(
    "arguments",
    [
        ("--out", "x.md"), ("--out", "x.md", "--chapter", "3"), ("eq-3.22", "--errata"),
        ("eq-3.22", "--chapter", "3"),
        ("eq-3.22", "--html", "x.html"), ("--errata", "--verdict", "holds"),
        ("--errata", "--html", "x.html"),
        ("--html", "x.html", "--out", "y.md"), ("--html", "x.html", "--chapter", "2"),
    ],
)  # fmt: skip
def test_options_of_notes_that_would_not_be_used_are_refused(
    arguments: tuple[str, ...],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
):
    monkeypatch.chdir(tmp_path)
    assert run(["notes", *arguments]) == 2
    assert re.search(
        r"error: notes: .*(needs something to write|is not used with)", capsys.readouterr().err
    )
    assert not list(tmp_path.iterdir())


def test_a_closed_chain_is_derived_by_a_method_that_applies(capsys: pytest.CaptureFixture[str]):
    assert fb.derive(fb.load("four_bar")).method == "lagrange-first-kind"
    assert fb.derive(ARM).method == "newton-euler"
    assert run(["derive", "four_bar"]) == 0
    assert "Lagrange" in capsys.readouterr().out.splitlines()[0]


def test_warnings_point_at_the_caller():
    still, along = [0.0, 0.0], [1.0, 0.0]
    near = [0.0, 1e-6]
    with pytest.warns(fb.FreebodyWarning) as first:
        fb.inverse_velocity(ARM, near, along, damping=0.05)
    with pytest.warns(fb.FreebodyWarning) as second:
        fb.inverse_acceleration(ARM, near, still, along, damping=0.05)
    assert [warning.filename for warning in (*first, *second)] == [__file__] * 2


# ---------------------------------------------------------------- arguments of another kind
OF_ANOTHER_KIND: list[tuple[Callable[[Any], Any], str]] = [
    (lambda x: fb.catalogue(x), "catalogue: path is {}, expected the path of a TOML file"),
    (lambda x: fb.doctor(x), "doctor: path is {}, expected the path of a robot's file"),
    (lambda x: fb.load(x), "load: source is {}, expected the path of a robot's file"),
    (lambda x: fb.read_motion(ARM, x), "read_motion: path is {}, expected the path of a CSV file"),
    (lambda x: fb.read_waypoints(ARM, x), "read_waypoints: path is {}, expected the path of a CSV"),
    (
        lambda x: fb.DutyCycle.read(ARM, x),
        "DutyCycle.read: path is {}, expected the path of a TOML",
    ),
    (lambda x: fb.identify(ARM, x), "identify: logs is {}, expected logs of fb.read_log"),
    (lambda x: fb.size(ARM, x, fb.catalogue("invented")), "size: cycles is {}, expected a DutyCyc"),
    (lambda x: fb.random_state(ARM, x), "random_state: seed is {}, expected a whole number from 0"),
    (lambda x: fb.kernel(ARM, x), "fb.kernel: names is {}, expected a name or a list of names"),
]


@pytest.mark.parametrize("case", range(len(OF_ANOTHER_KIND)))
def test_another_kind_of_argument_is_named_with_what_is_expected(case: int):
    function, words = OF_ANOTHER_KIND[case]
    for given, what in ((-0.5, "float -0.5"), (ARM, f"Model {ARM!r}")):
        with pytest.raises(KindError, match=re.escape(words.format(what))):
            function(given)


def test_what_is_no_motion_is_not_taken_for_positions():
    with pytest.raises(KindError, match="payload: motion is None, expected a Motion"):
        fb.payload(ARM, None, effort=[50.0, 20.0])  # pyright: ignore[reportArgumentType]
