"""Motion files as other programs write them: units, separators, decimal commas; and doubtful
magnitudes."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import freebody as fb
from freebody import FileError, FreebodyError, read_motion

ARM = fb.planar(
    "RP", l=[0.5, 0], lc=[0.2, 0.1], m=[2, 1], I=[0.1, 0.1], limits=[(-3.2, 3.2), (0.0, 0.9)]
)
T = np.linspace(0.0, 1.0, 6)
Q = np.stack([1.0 - T, 0.2 + 0.5 * T**2], axis=-1)


def written(
    path: Path, header: str, columns: list[np.ndarray], separator: str = ",", comma: str = "."
) -> Path:
    rows = [
        separator.join(f"{x:.12g}".replace(".", comma) for x in row)
        for row in zip(*columns, strict=True)
    ]
    path.write_text("\n".join([header, *rows, ""]), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    ("header", "factors"),
    [
        ("t,joint1,joint2", (1, 1, 1)),
        ("time,joint1,joint2", (1, 1, 1)),
        ("Time (s),joint1 (rad),joint2 [m]", (1, 1, 1)),
        ("time [ms],joint1 (deg),joint2 (mm)", (1e3, 180 / np.pi, 1e3)),
        ("t,joint1 [°],joint2 (cm)", (1, 180 / np.pi, 1e2)),
        ('"t" , "joint1[deg]",joint2', (1, 180 / np.pi, 1)),
        ("t,joint1,joint2,", (1, 1, 1)),
    ],
)
def test_units_and_names_of_time_in_a_header(
    tmp_path: Path, header: str, factors: tuple[float, ...]
):
    columns = [factors[0] * T, factors[1] * Q[:, 0], factors[2] * Q[:, 1]]
    motion = read_motion(ARM, written(tmp_path / "m.csv", header, columns))
    np.testing.assert_allclose(motion.t, T, rtol=1e-11)
    np.testing.assert_allclose(motion.q, Q, rtol=1e-11)
    assert motion.notices == ()


@pytest.mark.parametrize(("separator", "comma"), [(";", "."), (";", ","), ("\t", "."), ("\t", ",")])
def test_other_separators_and_decimal_commas(tmp_path: Path, separator: str, comma: str):
    header = separator.join(
        ["t", "joint1 (deg)", "joint1.v (deg/s)", "joint2", "joint2.v", "joint2.a [m/s²]"]
    )
    deg = 180 / np.pi
    columns = [T, deg * Q[:, 0], -deg + 0 * T, Q[:, 1], T, 1 + 0 * T]
    motion = read_motion(ARM, written(tmp_path / "m.csv", header, columns, separator, comma))
    np.testing.assert_allclose(motion.q, Q, rtol=1e-10)
    np.testing.assert_allclose(motion.qd, np.stack([-1 + 0 * T, T], axis=-1), rtol=1e-10)


def test_comments_in_a_table(tmp_path: Path):
    text = "# a log\nt,joint1,joint2\n\n0,0,0.1 # start\n  # later\n1,1,0.1\n2,2,0.1#x\n3,3,0.1\n"
    (tmp_path / "m.csv").write_text(text)
    np.testing.assert_array_equal(read_motion(ARM, tmp_path / "m.csv").q[:, 0], [0, 1, 2, 3])


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "t,joint1 (m),joint2\n",
            ":1: column 'joint1 (m)': 'm' is not a unit of an angle; units: rad, deg, °.",
        ),
        (
            "t,joint1,joint2 [deg]\n",
            ":1: column 'joint2 [deg]': 'deg' is not a unit of a length; units: m, cm, mm.",
        ),
        (
            "t,joint1,joint2,joint9 (deg)\n",
            "; a column that is not part of the motion must be removed.",
        ),
        (
            "t (min),joint1,joint2\n",
            ":1: column 't (min)': 'min' is not a unit of a time; units: s, ms, us, µs, ns.",
        ),
        (
            "t,joint1,joint2,current1\n",
            "; a column that is not part of the motion must be removed.",
        ),
        ("t joint1 joint2\n", "separate the columns by commas, semicolons or tabs."),
        ("% t,joint1,joint2\n", "a line that is not part of the table starts with #."),
        ("t,joint1,time,joint2\n", ":1: columns 't' and 'time' are the same; remove one."),
        (
            "t,joint1,joint2\n0,0,0,0,0,1\n",
            ":2: 6 values, the header names 3 columns; with decimal commas, separate the columns "
            "by semicolons.",
        ),
        (
            "t,joint1,joint2\ns,deg,m\n",
            ":2: column 't': 's' is not a number; write a unit after the name in the header, as "
            "in 'joint1 (deg)'.",
        ),
    ],
)
def test_what_is_not_read_says_what_to_write(tmp_path: Path, text: str, problem: str):
    rows = "".join(f"{k},0,0.1\n" for k in range(6))
    (tmp_path / "m.csv").write_text(text + rows)
    with pytest.raises(FileError) as caught:
        read_motion(ARM, tmp_path / "m.csv")
    assert str(caught.value).endswith(problem)


def test_degrees_read_as_radians_are_said(tmp_path: Path):
    motion = read_motion(
        ARM, written(tmp_path / "m.csv", "t,joint1,joint2", [T, 120 * Q[:, 0], Q[:, 1]])
    )
    assert motion.notices == (
        "joint1 goes to 120 rad, 19.1 turns, where its range ends at 3.2 rad. If these are "
        "degrees, write "
        "'joint1 (deg)' in the header.",
    )
    told = written(tmp_path / "n.csv", "t,joint1 (rad),joint2", [T, 120 * Q[:, 0], Q[:, 1]])
    assert read_motion(ARM, told).notices == ()
    free = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    both = read_motion(free, written(tmp_path / "o.csv", "t,joint1,joint2", [T, 90 * T, -45 * T]))
    assert both.notices == (
        "joint1 goes to 90 rad, 14.3 turns (joint2 likewise). If these are degrees, write 'joint1 "
        "(deg)' in the "
        "header.",
    )


def test_millimetres_and_milliseconds_are_said(tmp_path: Path):
    file = written(tmp_path / "m.csv", "t,joint1,joint2", [T, Q[:, 0], 1e3 * Q[:, 1]])
    assert read_motion(ARM, file).notices == (
        "joint2 goes to 700 m, where its range ends at 0.9 m. If these are millimetres, write "
        "'joint2 (mm)' in the "
        "header.",
    )
    t = 10.0 * np.arange(200)
    slow = written(
        tmp_path / "n.csv", "t,joint1,joint2", [t, np.sin(0.02 * np.arange(200)), 0.1 + 0 * t]
    )
    assert read_motion(ARM, slow).notices == (
        "The samples are 10 s apart. If t is in milliseconds, write 't (ms)' in the header.",
    )


def test_the_units_of_a_dataset_count():
    def data(unit: str) -> xr.Dataset:
        angle = ("time", np.degrees(Q[:, 0]), {"units": unit})
        return xr.Dataset({"joint1": angle, "joint2": ("time", Q[:, 1])}, {"time": T})

    np.testing.assert_allclose(fb.Motion.of(ARM, data("deg")).q, Q, rtol=1e-12)
    with pytest.raises(
        FreebodyError, match=r"motion: the table: 'joint1': 'furlong' is not a unit of an angle"
    ):
        fb.Motion.of(ARM, data("furlong"))


def test_what_is_advised_for_arrays_works():
    model, t = fb.load("2R"), np.linspace(0, 1, 21)
    q = np.stack([np.sin(t), np.cos(t)], axis=-1)
    with pytest.raises(
        FreebodyError, match="expected a Motion, a CSV file or a table by names"
    ) as refused:
        fb.study(model, (t, q))
    advice = str(refused.value).split("(T, nq): ")[1].rstrip(".")
    data = eval(advice, {"fb": fb, "model": model, "q": q, "t": t})
    np.testing.assert_allclose(fb.study(model, data).motion.q, q)


def test_a_header_of_ten_thousands_of_columns_is_refused_in_time_that_grows_with_it(tmp_path: Path):
    """Each name was looked for in the list of those before it: twice the columns took four times as
    long."""
    taken = []
    for count in (20_000, 80_000):
        path = tmp_path / f"{count}.csv"
        path.write_text("t," + ",".join(f"c{k}" for k in range(count)) + "\n0\n")
        start = time.process_time()
        with pytest.raises(FileError, match="no column 'c0'"):
            read_motion(ARM, path)
        taken.append(time.process_time() - start)
    assert taken[1] < 8 * taken[0] + 0.2
