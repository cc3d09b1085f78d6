"""Vectors whose entries carry names: put in order, or refused, by every public function."""

from __future__ import annotations

import contextlib
import inspect
import subprocess
import sys
from collections import namedtuple
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import freebody as fb
from support.child_process import environment
from support.public_calls import arguments, bits, functions_of_states, state
from support.sources import SOURCES

TAKES_NUMBERS = (
    "Vector",
    "ArrayLike",
    "Wrenches",
    "Torque",
    "Sequence[float]",
    "Sequence[Given]",
    "Array",
)
"""What stands in the annotation of an argument that takes several numbers."""

BY_NAME = {
    "q": "positions", "q0": "positions", "q1": "positions", "qd": "rates", "qdd": "rates",
    "tau": "rates", "effort": "rates",
    "q_ref": "positions", "tau_null": "rates", "integral": "rates",
    **dict.fromkeys(("qd_ref", "qdd_ref", "kp", "kd", "ko"), "rates"),
    **dict.fromkeys(("V_ref", "A_ref", "kp_task", "kd_task", "offset", "offset_rate"), "rows"),
    **dict.fromkeys(("inertia", "stiffness", "damping"), "rows"), "w_ext": "wrench",
    "v": "rates", "rates": "rates", "accelerations": "rates", "torque": "rates", "V": "rows",
    "A": "rows", "restitution": "rates", "forces": "rates",
    "waypoints": "positions", "wrenches": "wrench", "wrench_tables": "wrench",
    "point": "point", "about": "point", "motion": "positions",
}  # fmt: skip
"""Arguments whose entries have names, and which."""

OF_JOINTS = {("deflection", "stiffness"), ("natural_frequencies", "stiffness")}
"""Functions and arguments of one number for each rate, of a name that means rows elsewhere; the
others of a mapping are found."""

NAMED_ELSEWHERE = {("identify", "prior"), ("excitation", "noise")}
"""Functions and arguments whose numbers are put in order by names of bodies and of rates, and that
are too slow for this file."""

BY_POSITION = {
    "rotation": {"angles": [0.1, 0.2, 0.3]},
    "quat_wxyz": {"R": np.eye(3)},
    "sampled_trajectory": {
        "t": [0.0, 1.0, 2.0, 3.0, 4.0, 5.0],
        "points": np.arange(12.0).reshape(6, 2),
    },
    "planar": {name: [1.0, 1.0] for name in ("l", "lc", "m", "I", "angles")} | {"g": [0.0, -9.81]},
    "inertia_from": {"com": [0.1, 0.2], "about": [0.3, 0.1]},
    "simulate": {"t": [0.0, 0.01, 0.02], "breakpoints": [0.01, 0.02]},
    **{name: {"pose_ref": np.eye(3)} for name in ("operational_space_control", "impedance")},
    "calibrate": {
        "poses": np.ones((8, 3)),
        "instrument": np.eye(4),
        "marker": [0.0, 0.0, 0.1],
        "noise": [1e-4],
    },
    "excitation": {"box": [[-1.0, -1.0], [1.0, 1.0]]},
    "discrete_lqr": {"A": np.eye(2), "B": np.eye(2), "Q": np.eye(2), "R": np.eye(2)},
    "inverse_kinematics": {"target": [0.3, 0.2], "redundancy": [0.1, 0.2]},
    "workspace": {"points": [0.3, 0.2], "orientation": np.eye(2)},
    "map_diagram": {"points": np.ones((3, 2)), "values": np.ones((3, 2))},
    "dh": {"gravity": [0.0, 0.0, -9.81]},
    "payload": {"com": [0.1, 0.2], "box": [0.1, 0.2], "cylinder": [0.1, 0.2]},
    "load_diagram": {"offsets": [0.0, 0.1]},
    "line": {"target": [0.3, 0.2]},
    "arc": {"via": [0.3, 0.2], "target": [0.1, 0.2]},
    "blend": {"targets": [[0.3, 0.2], [0.1, 0.2]]},
    **{name: {"times": [0.0, 2.0]} for name in ("quintic", "trapezoid", "s_curve", "spline")},
}
"""Functions and their arguments in which a place, not a name, tells what a number is; with values
for them."""

OTHERS = {
    "planar": {"word": "RR"},
    "rotation": {"axes": "XYZ"},
    "inertia_from": {"mass": 1.0, "tensor": 1.0},
    "dh": {"rows": [{"a": 1.0}], "convention": "standard"},
    **{
        name: {"model": fb.load("2R"), "waypoints": [[0.0, 0.0], [1.0, 1.0]]}
        for name in ("quintic", "trapezoid", "s_curve", "spline")
    },
    **{name: {"model": fb.load("2R")} for name in ("workspace", "map_diagram")},
    **{
        name: {"model": fb.load("2R"), "motion": [0.3, 1.0], "effort": [90.0, 90.0]}
        for name in ("payload", "load_diagram")
    },
    "time_optimal": {"model": fb.load("2R"), "path": [[0.0, 0.0], [1.0, 1.0]]},
    **{name: {"model": fb.load("2R"), "q0": [0.3, 1.0]} for name in ("line", "arc")},
    "excitation": {"model": fb.load("2R"), "duration": 6.0},
    "calibrate": {"model": fb.load("ur5e"), "q": np.zeros((8, 6))},
    "blend": {"model": fb.load("2R"), "q0": [0.3, 1.0], "radius": 0.1},
}


@cache
def model(name: str) -> fb.Model:
    return fb.load(name)


def names_of(arm: fb.Model, kind: str) -> tuple[str, ...]:
    if kind in ("positions", "rates"):
        return arm.position_names if kind == "positions" else arm.velocity_names
    if kind == "rows":
        return ("vx", "vy", "vz", "wx", "wy", "wz") if arm.dim == 3 else ("vx", "vy", "w")
    if kind == "wrench":
        return ("fx", "fy", "fz", "mx", "my", "mz") if arm.dim == 3 else ("fx", "fy", "m")
    return ("x", "y", "z")[: arm.dim]


def series(x: np.ndarray, names: list[str]) -> Any:
    return pd.Series(x, index=names)


def frame(x: np.ndarray, names: list[str]) -> Any:
    return pd.DataFrame(x[None], columns=names)


def data_array(x: np.ndarray, names: list[str]) -> Any:
    return xr.DataArray(x, dims="joint", coords={"joint": names})


def dataset(x: np.ndarray, names: list[str]) -> Any:
    return xr.Dataset({name: ("time", [value]) for name, value in zip(names, x, strict=True)})


def mapping(x: np.ndarray, names: list[str]) -> Any:
    return dict(zip(names, x.tolist(), strict=True))


CONTAINERS: tuple[Callable[[np.ndarray, list[str]], Any], ...] = (
    series,
    frame,
    data_array,
    dataset,
    mapping,
)
BATCHED = (frame, dataset)  # these hold a batch of one


def takes_numbers(parameter: inspect.Parameter) -> bool:
    return any(word in str(parameter.annotation) for word in TAKES_NUMBERS)


def public_arguments() -> list[tuple[str, str]]:
    """(function, argument) of every argument of a public function that takes several numbers."""
    return [
        (name, parameter.name)
        for name in fb.__all__
        if inspect.isfunction(function := getattr(fb, name))
        for parameter in inspect.signature(function).parameters.values()
        if takes_numbers(parameter)
    ]


def test_every_argument_that_takes_numbers_is_tried():
    """A new one is put into one of the tables above."""
    for function, argument in public_arguments():
        known = argument in BY_NAME or argument in BY_POSITION.get(function, {})
        known = known or (function, argument) in NAMED_ELSEWHERE
        assert known, (
            f"are the entries of {argument} of fb.{function} known by name or by position?"
        )


def call(function: str, arm: fb.Model, changed: dict[str, Any]) -> Any:
    values = state(arm, 1)
    taken = {argument: values[key] for argument, key in arguments(function).items()} | changed
    if function == "reactions" and "tau" in changed:
        taken.pop("qdd")
    if function == "kinematic_diagram" and "qdd" in changed:
        taken["qd"] = values["qd"]
    found = getattr(fb, function)(arm, **taken)
    return found.to_svg() if hasattr(found, "to_svg") else found


@pytest.mark.sample(4)
@pytest.mark.filterwarnings("ignore::freebody.FreebodyWarning")
@pytest.mark.parametrize("function", functions_of_states())
def test_names_in_another_order_are_put_in_order_and_wrong_ones_refused(function):
    tried = 0
    for argument in inspect.signature(getattr(fb, function)).parameters:
        if (
            (function, argument) not in public_arguments()
            or argument not in BY_NAME
            or function == "assembly_modes"
        ):
            continue
        for arm in (model("3R"), model("four_bar")):
            kind = "rates" if (function, argument) in OF_JOINTS else BY_NAME[argument]
            names = list(names_of(arm, kind))
            plain = np.linspace(0.1, 0.2, len(names))
            if arm.loops and BY_NAME[argument] in ("positions", "rates"):
                values = state(arm, 1)
                plain = values["q"] if BY_NAME[argument] == "positions" else np.zeros(len(names))
            try:
                expected = call(function, arm, {argument: plain})
            except fb.FreebodyError:
                continue  # of the other kind of model
            _try(function, arm, argument, plain, names, expected)
            tried += 1
    assert (
        tried
        or function == "assembly_modes"
        or not any(f == function for f, _ in public_arguments())
    )


def _try(
    function: str, arm: fb.Model, argument: str, plain: np.ndarray, names: list[str], expected: Any
) -> None:
    where = f"{function}, {argument}"
    for container in CONTAINERS:
        by_frame = argument == "wrenches" and container in (
            dataset,
            mapping,
        )  # these name frames there
        wrong = ["nobody", *names[1:]]
        some = container is mapping and (
            argument in ("rates", "accelerations") or (function, argument) == ("assemble", "q")
        )  # the others are found
        some = some or (container in (mapping, dataset) and (function, argument) in OF_JOINTS)
        for labels in (wrong, names[1:])[: 1 if some else 2]:
            with pytest.raises(fb.FreebodyError):
                call(function, arm, {argument: container(plain[: len(labels)], labels)})
        if by_frame:
            continue
        with pytest.raises(fb.FreebodyError):
            call(function, arm, {argument: container(np.append(plain, 0.0), [*names, "nobody"])})
        if container in (series, frame, data_array):
            with pytest.raises(fb.FreebodyError):
                call(
                    function, arm, {argument: container(np.append(plain, 0.0), [*names, names[0]])}
                )
        turned = container(plain[::-1], names[::-1])
        if container not in BATCHED:
            found = call(function, arm, {argument: turned})
            # what is named is kept, of a whole vector the nearest is found: another way to the same
            if some:
                np.testing.assert_array_equal(found, expected)
            else:
                assert bits(found) == bits(expected), (where, container.__name__)
            continue
        with contextlib.suppress(fb.FreebodyError):  # where no batch is taken
            _agree(call(function, arm, {argument: turned}), expected, where)


def _agree(batch: Any, single: Any, where: str) -> None:
    """The one sample of a batch is the single result, wherever that is arrays alone."""
    for a, b in zip(*(x if isinstance(x, tuple) else (x,) for x in (batch, single)), strict=True):
        if isinstance(a, np.ndarray) and isinstance(b, (np.ndarray, float)):
            np.testing.assert_array_equal(a.reshape(np.shape(b)), b, err_msg=where)


@pytest.mark.parametrize("function", sorted(BY_POSITION))
def test_names_are_refused_where_a_place_tells_what_a_number_is(function):
    for argument in BY_POSITION[function]:
        given = {name: np.asarray(x) for name, x in BY_POSITION[function].items()}
        one = given[argument]
        names = [f"n{k}" for k in range(one.shape[-1])]
        for container in CONTAINERS:
            if one.ndim == 1:
                labelled = container(one, names)
            elif container is frame:
                labelled = pd.DataFrame(one, columns=names)
            else:
                continue
            now = given | {argument: labelled}
            of_states = function in functions_of_states()
            with pytest.raises(fb.FreebodyError, match=r"read by position|rates|lacks"):
                call(function, model("2R"), now) if of_states else getattr(fb, function)(
                    **OTHERS.get(function, {}), **now
                )


# ---------------------------------------------------------------- batches, and what is no name
def test_a_batch_by_names_in_any_order_of_columns_and_axes():
    arm = model("3R")
    q, qd, qdd = fb.random_state(arm, 2, 4)
    names, turned = list(arm.joint_names), list(arm.joint_names)[::-1]
    expected = fb.inverse_dynamics(arm, q, qd, qdd)
    table = pd.DataFrame(q, columns=names)[turned]
    across = xr.DataArray(qd.T[::-1], dims=("velocity", "time"), coords={"velocity": turned})
    variables = xr.Dataset({name: ("time", qdd[:, names.index(name)]) for name in turned})
    for last in (
        variables,
        dict(variables),
        {name: pd.Series(qdd[:, names.index(name)]) for name in turned},
    ):
        np.testing.assert_array_equal(fb.inverse_dynamics(arm, table, across, last), expected)
    np.testing.assert_array_equal(fb.inverse_dynamics(arm, table, across.T, qdd), expected)
    rows = [pd.Series(row, index=names)[turned] for row in q]
    np.testing.assert_array_equal(fb.inverse_dynamics(arm, rows, qd, qdd), expected)


def test_labels_that_only_count_are_none():
    arm = model("3R")
    q = np.array([0.1, 0.2, 0.3])
    expected = fb.mass_matrix(arm, q)
    for plain in (
        pd.Series(q),
        pd.DataFrame(q[None]).iloc[0],
        xr.DataArray(q),
        xr.DataArray(q, dims="joint"),
    ):
        np.testing.assert_array_equal(fb.mass_matrix(arm, plain), expected)


def test_the_order_of_a_shuffled_count_is_no_name_either():
    arm = model("3R")
    with pytest.raises(fb.FreebodyError, match="no entry 2 in mass_matrix: q"):
        fb.mass_matrix(arm, pd.Series([0.1, 0.2, 0.3], index=[2, 1, 0]))


def test_a_result_goes_back_in_as_it_came():
    arm = model("3R")
    run = fb.simulate(arm, np.zeros(3), np.zeros(3), np.linspace(0.0, 0.02, 5))
    np.testing.assert_array_equal(fb.mass_matrix(arm, run.q), fb.mass_matrix(arm, run.q.values))
    again = fb.simulate(arm, run.q[-1], run.qd[-1], run.time)
    np.testing.assert_array_equal(again.q[0], run.q[-1])
    with pytest.raises(fb.FreebodyError, match="no entry 'q' in mass_matrix: q"):
        fb.mass_matrix(arm, run)


def test_what_is_said_of_labels_that_do_not_fit():
    arm = model("2R")
    first, second = arm.joint_names
    with pytest.raises(fb.FreebodyError, match=f"mass_matrix: q lacks {second}; give every entry"):
        fb.mass_matrix(arm, pd.Series([0.1], index=[first]))
    with pytest.raises(fb.FreebodyError, match=f"mass_matrix: q has '{first}' twice"):
        fb.mass_matrix(arm, pd.Series([0.1, 0.2, 0.3], index=[first, second, first]))
    with pytest.raises(fb.FreebodyError, match=r"rows of .* are labelled otherwise"):
        fb.mass_matrix(
            arm, {first: pd.Series([1.0, 2.0], index=["a", "b"]), second: pd.Series([1.0, 2.0])}
        )
    with pytest.raises(
        fb.FreebodyError, match=r"rotation: angles is a Series with labels.*read by position"
    ):
        fb.rotation("XY", pd.Series([0.1, 0.2], index=["y", "x"]))


def test_names_of_a_tuple_count():
    arm = model("2R")
    first, second = arm.joint_names
    Turned = namedtuple("Turned", [second, first])
    np.testing.assert_array_equal(
        fb.mass_matrix(arm, Turned(0.2, 0.1)), fb.mass_matrix(arm, [0.1, 0.2])
    )


def test_a_torque_by_names_drives_the_joints_that_are_named():
    arm = model("2R")
    t, (first, second) = np.linspace(0.0, 0.02, 3), arm.joint_names
    expected = fb.simulate(arm, np.zeros(2), np.zeros(2), t, torque=np.array([1.0, 2.0]))
    for torque in (
        {second: 2.0, first: 1.0},
        pd.Series([2.0, 1.0], index=[second, first]),
        pd.DataFrame([[2.0, 1.0]] * 3, columns=[second, first], index=t),
        xr.DataArray(
            [[2.0] * 3, [1.0] * 3], dims=("velocity", "time"), coords={"velocity": [second, first]}
        ),
        lambda now, q, qd: {second: 2.0, first: 1.0},
    ):
        found = fb.simulate(arm, np.zeros(2), np.zeros(2), t, torque=torque)
        np.testing.assert_allclose(found.q, expected.q, rtol=0, atol=1e-12)


def test_freebody_does_not_import_pandas():
    assert "pandas" in sys.modules  # by this file
    assert not [p for p in SOURCES if "import pandas" in p.read_text(encoding="utf-8")]
    program = (
        "import sys, numpy, freebody as fb; fb.mass_matrix(fb.load('2R'), numpy.zeros(2)); "
        "print('pandas' in sys.modules)"
    )
    child = {**environment(), "FREEBODY_TARGET": "numpy"}
    done = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, env=child
    )
    assert done.stdout == "False\n", done.stderr


@pytest.mark.parametrize("name", functions_of_states())
def test_a_masked_entry_is_missing_and_never_read_as_the_number_under_its_mask(name: str):
    call, taken = getattr(fb, name), arguments(name)
    closed = "loop" in name or name in ("input_output", "parallel_jacobians", "assembly_modes")
    arm = model("five_bar" if closed else "3R" if "operational" in name else "2R")
    values = {argument: state(arm, 3)[key] for argument, key in taken.items()}
    for argument in taken:
        kind = BY_NAME.get(argument)
        if kind not in ("positions", "rates"):
            continue
        hidden = np.ma.array(values[argument], mask=np.arange(len(values[argument])) == 0)
        by_name = dict(zip(names_of(arm, kind), hidden, strict=True))
        for form in (hidden, [hidden, hidden], by_name):
            with pytest.raises(fb.FreebodyError, match="masked"):
                call(arm, **{**values, argument: form})


def test_a_masked_array_that_hides_nothing_is_a_plain_one():
    arm = model("2R")
    q = np.ma.array([0.1, 0.2], mask=False)
    assert type(M := fb.mass_matrix(arm, q)) is np.ndarray
    assert M.tobytes() == fb.mass_matrix(arm, [0.1, 0.2]).tobytes()
    with pytest.raises(fb.FreebodyError, match="masked"):
        fb.planar("RR", l=np.ma.array([1.0, 2.0], mask=[False, True]))


def test_rows_that_are_labelled_with_other_times_are_refused():
    import xarray as xr

    model = fb.load("2R")
    t = np.linspace(0.0, 1.0, 5)
    rows = np.random.default_rng(1).normal(size=(5, 2))
    here, later = (xr.DataArray(rows, {"time": x}, ("time", "joint")) for x in (t, t + 0.5))
    frame = pd.DataFrame(rows, index=t + 0.5, columns=list(model.joint_names))
    for other in (later, frame):
        with pytest.raises(
            fb.FreebodyError, match="the rows of qdd are labelled with other times than those of q"
        ):
            fb.inverse_dynamics(model, here, here, other)
    same = fb.inverse_dynamics(model, here, rows, here)
    assert np.array_equal(same, fb.inverse_dynamics(model, rows, rows, rows))
