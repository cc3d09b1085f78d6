"""Logs of many forms read alike; layouts, units and gains; the grid, and the one filter."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from support.extras import extra

ARM = fb.load("ur5e")
NAMES = ARM.velocity_names
T = np.arange(400) / 125.0
K = np.arange(1, 7)
Q = 0.8 * np.sin(0.9 * K * T[:, None])
QD = 0.72 * K * np.cos(0.9 * K * T[:, None])
TAU = 3.0 * np.cos(0.5 * T[:, None] + K) + K
SORTED = [2, 1, 0, 3, 4, 5]
"""The joints as ROS lists them: by the alphabet."""


def lines(columns: list[Any], names: list[str], separator: str = ",", digits: int = 9) -> list[str]:
    table = np.column_stack(columns)
    rows = [separator.join(f"{x:.{digits}f}" for x in row) for row in table]
    return [separator.join(names), *rows]


def joint_state() -> list[str]:
    """A log as `rostopic echo -p` writes JointState."""
    names = [NAMES[k] for k in SORTED]
    head = ["%time", "field.header.seq", "field.header.stamp", "field.header.frame_id"]
    for key in ("name", "position", "velocity", "effort"):
        head += [f"field.{key}{k}" for k in range(6)]
    rows = [",".join(head)]
    for n, t in enumerate(T):
        stamp = 1_600_000_000_000_000_000 + round(1e9 * t)
        cells = [str(stamp + 4_000_000 * (n % 3)), str(n), str(stamp), "base", *names]
        cells += [f"{x[n, k]:.9f}" for x in (Q, QD, TAU) for k in SORTED]
        rows.append(",".join(cells))
    return rows


def listed_cells(opening: str, closing: str, quote: str, separator: str) -> list[str]:
    """JointState in a table of messages, a list in each cell."""

    def cell(values: list[str]) -> str:
        return f"{quote}{opening}{', '.join(values)}{closing}{quote}"

    rows = [separator.join(["Time", "header.stamp", "name", "position", "velocity", "effort"])]
    for n, t in enumerate(T):
        cells = [f"{1.6e9 + t:.4f}", f"{1.6e9 + t:.4f}", cell([f"'{NAMES[k]}'" for k in SORTED])]
        cells += [cell([f"{x[n, k]:.9f}" for k in SORTED]) for x in (Q, QD, TAU)]
        rows.append(separator.join(cells))
    return rows


def rtde() -> list[str]:
    """A log as Universal Robots' recorder writes it."""
    head = ["timestamp", *(f"target_q_{k}" for k in range(6))]
    head += [f"actual_{key}_{k}" for key in ("q", "qd", "current") for k in range(6)]
    return lines([T + 100.0, 0.0 * Q, Q, QD, TAU], head, " ")


def plotted() -> list[str]:
    """A log as PlotJuggler writes it."""
    head = ["__time"]
    for key, names in (("position", NAMES), ("velocity", NAMES), ("effort", NAMES)):
        head += [f"/joint_states/{name}/{key}" for name in names]
    return lines([T + 1.6e9, Q, QD, TAU], head)


def named(*units: str) -> list[str]:
    names = [f"{n}{e}" for e in ("", ".v", ".torque") for n in NAMES]
    return ["t", *(f"{n}{u}" for n, u in zip(names, np.repeat(units or ("",) * 3, 6), strict=True))]


FORMS = {
    "freebody's names": lines([T, Q, QD, TAU], named()),
    "in other units": lines(
        [1e3 * T, np.degrees(Q), QD * 30 / np.pi, 1e-3 * TAU],
        ["t [ms]", *named(" (deg)", " (rpm)", " (kN m)")[1:]],
    ),
    "a row of units": [
        ",".join(named()),
        ",".join(["s", *["deg"] * 6, *["deg/s"] * 6, *["N m"] * 6]),
        *lines([T, np.degrees(Q), np.degrees(QD), TAU], named())[1:],
    ],
    "semicolons and decimal commas": [
        x.replace(",", ";").replace(".", ",") if n else x.replace(",", ";")
        for n, x in enumerate(lines([T, Q, QD, TAU], named()))
    ],
    "tabs": lines([T, Q, QD, TAU], named(), "\t"),
    "a remark for a header": [
        "# robot 7, cell 3",
        *(f"# {x}" if n == 0 else x for n, x in enumerate(lines([T, Q, QD, TAU], named()))),
    ],
    "short names from 1": lines(
        [T, Q, QD, TAU], ["time", *(f"{x}{k}" for x in ("q", "dq", "tau") for k in K)]
    ),
    "ROS JointState": joint_state(),
    "ROS JointState, lists in cells": listed_cells("[", "]", '"', ","),
    "ROS JointState, tuples between semicolons": listed_cells("(", ")", "", ";"),
    "PlotJuggler": plotted(),
    "stamps in two parts": lines(
        [1.6e9 + np.floor(T), 1e9 * (T % 1.0), Q, QD, TAU],
        ["header.stamp.secs", "header.stamp.nsecs", *named()[1:]],
    ),
    "columns that are none of ours": lines(
        [T, T, Q, QD, 7 * TAU, TAU],
        ["time", "seq", *named()[1:13], *(f"tcp_force_{k}" for k in range(6)), *named()[13:]],
    ),
}


def written(folder: Path, text: list[str], layout: str = "") -> Path:
    file = folder / "run.csv"
    file.write_text("\r\n".join(text) + "\r\n", encoding="utf-8")
    if layout:
        (folder / "log.toml").write_text(layout, encoding="utf-8")
    return file


def check(log: fb.Log, torque: bool = True) -> None:
    assert log.names == NAMES
    assert log.rate == pytest.approx(125.0, rel=1e-6)
    assert log.measured.all()
    assert np.abs(log.time - T).max() < 1e-6
    assert np.abs(log.position - Q).max() < 1e-8
    assert np.abs(log.velocity - QD).max() < 1e-7
    given = log.torque if torque else log.current
    assert given is not None
    assert np.abs(given - TAU).max() < 2e-6


@pytest.mark.parametrize("form", FORMS)
def test_forms_of_logs(form: str, tmp_path: Path) -> None:
    log = fb.read_log(written(tmp_path, FORMS[form]), ARM)

    check(log)
    assert form.startswith("ROS JointState") or not log.notices
    assert log.rates_measured


def test_currents_of_a_recorder_have_unknown_gains(tmp_path: Path) -> None:
    log = fb.read_log(written(tmp_path, rtde()), ARM)

    assert log.torque is None
    check(log, torque=False)
    assert "currents" in repr(log)


def test_tables_in_memory_are_logs() -> None:
    names, table = named(), np.column_stack([T, Q, QD, TAU])

    check(fb.read_log(dict(zip(names, table.T, strict=True)), ARM))
    frame = extra("pandas").DataFrame(table, columns=names)
    check(fb.read_log(frame, ARM))
    frame.iloc[50, 3] = np.nan
    (notice,) = fb.read_log(frame, ARM).notices
    assert notice.startswith("Row 51 is left out: column 'elbow_joint'")
    with pytest.raises(fb.KindError, match="the path of a CSV or Parquet file, or a table"):
        fb.read_log(3.0)


def test_parquet(tmp_path: Path) -> None:
    reason = "pyarrow is not installed: pip install 'freebody[parquet]'"
    arrow = pytest.importorskip("pyarrow", reason=reason)
    parquet = pytest.importorskip("pyarrow.parquet", reason=reason)
    table = np.column_stack([T, Q, QD, TAU])
    columns = dict(zip(named(), table.T, strict=True))
    parquet.write_table(arrow.table(columns), tmp_path / "run.parquet")

    check(fb.read_log(tmp_path / "run.parquet", ARM))

    (tmp_path / "no.parquet").write_bytes(b"PAR1 not")
    with pytest.raises(fb.FileError, match="this is not a Parquet file"):
        fb.read_log(tmp_path / "no.parquet", ARM)


def test_without_a_model_joints_are_those_of_the_header(tmp_path: Path) -> None:
    assert fb.read_log(written(tmp_path, FORMS["freebody's names"])).names == NAMES
    log = fb.read_log(written(tmp_path, FORMS["short names from 1"]))
    assert log.names == tuple(f"joint{k}" for k in K)
    log = fb.read_log(written(tmp_path, joint_state()))
    assert log.names == tuple(NAMES[k] for k in SORTED)
    assert np.abs(log.position - Q[:, SORTED]).max() < 1e-8


def test_one_joint_needs_no_number() -> None:
    table = {"t": T, "q": Q[:, 0], "qd": QD[:, 0], "tau": TAU[:, 0]}

    for log in (fb.read_log(table, fb.load("pendulum")), fb.read_log(table)):
        assert log.names == ("joint1",)
        assert np.array_equal(log.position, Q[:, :1])


NUMBERED = '[log]\ntime = 1\nposition = "2-7"\nvelocity = "8-13"\n'


def test_layouts_say_what_the_columns_are(tmp_path: Path) -> None:
    signs = np.array([1, -1, 1, 1, -1, 1])
    offsets = np.array([0.0, 0.1, -0.2, 0.0, np.pi / 2, 0.0])
    constants, gears = np.array([0.12, 0.12, 0.1, 0.09, 0.09, 0.09]), np.full(6, 101.0)
    current = TAU * signs / (constants * gears)
    table = [1e3 * T, np.degrees((Q - offsets) * signs), QD * signs, 1e3 * current]
    layout = NUMBERED + (
        'current = ["14", "c2", "c3", "c4", "c5", "c6"]\n'.replace('"14"', "14")
        + f"signs = {signs.tolist()}\n"
        + 'offsets = [0, 0.1, -0.2, 0, "90 deg", 0]\n'
        + f"torque_constants = {constants.tolist()}\ngears = {gears.tolist()}\n"
        + 'units = { time = "ms", position = "deg", current = "mA" }\n'
    )
    head = ["clock", *(f"p{k}" for k in K), *(f"s{k}" for k in K), *(f"c{k}" for k in K)]

    log = fb.read_log(written(tmp_path, lines(table, head), layout), ARM)

    check(log)
    assert log.current is not None
    assert np.abs(log.current - current * signs).max() < 1e-9
    assert not log.notices


def test_layouts_without_a_header_and_without_times(tmp_path: Path) -> None:
    body = lines([Q, QD, TAU], named())[1:]
    layout = '[log]\nrate = 125\nposition = "1-6"\nvelocity = "7-12"\ntorque = "13-18"\n'

    check(fb.read_log(written(tmp_path, body, layout), ARM))
    assert fb.read_log(tmp_path / "run.csv").names == tuple(f"joint{k}" for k in K)


def test_layouts_put_joints_into_the_models_order(tmp_path: Path) -> None:
    body = lines([T, Q[:, SORTED], QD[:, SORTED], TAU[:, SORTED]], named())[1:]
    names = [NAMES[k] for k in SORTED]
    factor = [2.0 + k for k in range(6)]
    layout = f'{NUMBERED}current = "14-19"\njoints = {names}\ngains = {factor}\n'.replace("'", '"')

    log = fb.read_log(written(tmp_path, body, layout), ARM)

    assert log.names == NAMES
    assert np.abs(log.position - Q).max() < 1e-8
    assert log.torque is not None
    assert np.abs(log.torque - TAU * np.array(factor)[SORTED]).max() < 1e-7


def test_temperatures_that_are_told_now_and_then(tmp_path: Path) -> None:
    warm = 30.0 + T
    text = lines([T, Q, QD, TAU, *([warm] * 6)], [*named(), *(f"temperature_{k}" for k in K)])
    text[1:] = [
        x if n % 10 == 0 else ",".join(x.split(",")[:19] + [""] * 6) for n, x in enumerate(text[1:])
    ]

    log = fb.read_log(written(tmp_path, text), ARM)

    assert log.temperature is None  # most rows have none
    text[1:] = [
        ",".join([*x.split(",")[:19], *[f"{w:.6f}"] * 6])
        for x, w in zip(text[1:], warm, strict=True)
    ]
    for k in (50, 51, 52):
        text[k] = ",".join(text[k].split(",")[:19] + [""] * 6)
    log = fb.read_log(written(tmp_path, text), ARM)
    assert log.temperature is not None
    assert np.abs(log.temperature - warm[:, None]).max() < 1e-5


@pytest.mark.parametrize("rate", [50.0, 100.0, 250.0])
def test_the_grid_may_be_chosen(rate: float, tmp_path: Path) -> None:
    log = fb.read_log(written(tmp_path, FORMS["freebody's names"]), ARM, rate=rate)

    assert log.rate == pytest.approx(rate)
    assert np.allclose(np.diff(log.time), 1.0 / rate)
    assert np.abs(log.position - 0.8 * np.sin(0.9 * K * log.time[:, None])).max() < 2e-4
    assert f"brought to a grid of {rate:g} Hz" in log.notices[0]


def test_the_filter_is_butterworths_forward_and_back() -> None:
    rate, cutoff = 200.0, 8.0
    t = np.arange(4000) / rate
    f = np.array([0.5, 4.0, 8.0, 12.0])
    x = np.cos(2 * np.pi * f * t[:, None])
    every = np.ones(4000, dtype=bool)
    log = fb.Log(t, x, x, x, None, ("a", "b", "c", "d"), every)
    warped = np.tan(np.pi * f / rate) / np.tan(np.pi * cutoff / rate)

    found = log.states(cutoff)

    for filtered in (found.q, found.qd):
        assert np.abs(filtered - x / (1.0 + warped**8))[1000:3000].max() < 1e-6
    with pytest.raises(fb.FreebodyError, match="half the sampling rate, 100 Hz"):
        log.states(120.0)
    short = fb.Log(t[:20], x[:20], x[:20], x[:20], None, log.names, every[:20])
    with pytest.raises(fb.FreebodyError, match=r"20 samples at 200 Hz are too few.* it needs 38"):
        short.states(cutoff)


def test_states_of_a_log_and_where_they_are_settled() -> None:
    t = np.arange(2000) / 200.0
    q, qd = np.sin(t)[:, None], np.cos(t)[:, None]
    measured = np.ones(2000, dtype=bool)
    measured[900:950] = False
    log = fb.Log(t, q, qd, q, None, ("a",), measured)

    states, sure = log.states(), log.settled(0.5)

    assert np.array_equal(np.flatnonzero(np.diff(sure)), [99, 799, 1049, 1899])
    assert np.abs(states.q - q)[sure].max() < 1e-6
    assert np.abs(states.qd - qd)[sure].max() < 1e-6
    assert np.abs(states.qdd + q)[sure].max() < 1e-5
    assert log == fb.Log(t, q, qd, q, None, ("a",), measured, source="another file")
    assert "a" in log._repr_html_()


def test_what_has_no_columns_is_refused(tmp_path: Path) -> None:
    with pytest.raises(fb.FreebodyError, match="joints with quaternions"):
        fb.read_log(written(tmp_path, FORMS["freebody's names"]), fb.load("quadrotor"))
    with pytest.raises(fb.KindError):
        fb.read_log(written(tmp_path, FORMS["freebody's names"]), "ur5e")  # type: ignore[arg-type]
