"""Logs as they come from robots, each broken in one way: survived with a notice, and the samples
then those of the whole log, or refused in one line that names the row and the remedy."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import freebody as fb

ARM = fb.load("ur5e")
COUNT, RATE = 600, 100.0
Lines = list[str]


def signals(t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Positions, rates and torques (n, 6) at the times t: smooth, each joint its own."""
    k = np.arange(1, 7)
    phase = 0.6 * k * t[:, None]
    return 0.8 * np.sin(phase) + 0.1, 0.48 * k * np.cos(phase), 8.0 * np.sin(phase + 0.3) + k


def rows(t: np.ndarray, signals_at: np.ndarray | None = None) -> np.ndarray:
    return np.column_stack([t, *signals(t if signals_at is None else signals_at)])


NAMES = ARM.velocity_names
HEADER = ["t", *NAMES, *(f"{n}.v" for n in NAMES), *(f"{n}.torque" for n in NAMES)]
TIMES = np.arange(COUNT) / RATE
TABLE = rows(TIMES)


def text(table: np.ndarray, header: list[str] | None = HEADER, separator: str = ",") -> Lines:
    """Lines of a CSV file."""
    head = [separator.join(header)] if header else []
    return head + [separator.join(f"{x:.6f}" for x in row) for row in table]


def written(folder: Path, lines: Lines, layout: str = "") -> Path:
    file = folder / "arm.csv"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    if layout:
        (folder / "arm.toml").write_text(layout, encoding="utf-8")
    return file


def changed(line: int, to: Callable[[str], str]) -> Lines:
    """The whole log with one line of the file (from 1) changed."""
    lines = text(TABLE)
    lines[line - 1] = to(lines[line - 1])
    return lines


def cell(column: int, to: str) -> Callable[[str], str]:
    def change(line: str) -> str:
        cells = line.split(",")
        cells[column] = to
        return ",".join(cells)

    return change


def without(*columns: int) -> Lines:
    kept = [k for k in range(19) if k not in columns]
    return text(TABLE[:, kept], [HEADER[k] for k in kept])


def scaled(factor: float, *columns: int) -> np.ndarray:
    table = TABLE.copy()
    table[:, list(columns)] *= factor
    return table


def clock(shift: np.ndarray | float) -> np.ndarray:
    """The log with other times: of each row, or from row 300 on later."""
    late = shift * (np.arange(COUNT) >= 300) if np.isscalar(shift) else shift
    return rows(TIMES + late, TIMES)


def wrapped() -> np.ndarray:
    table = TABLE.copy()
    table[:, 1] = (6.0 * table[:, 1] + np.pi) % (2 * np.pi) - np.pi
    table[:, 7] *= 6.0
    return table


rng = np.random.default_rng(7)
POSITIONS, RATES, TORQUES = range(1, 7), range(7, 13), range(13, 19)
REST = np.repeat(TABLE[:1], 400, axis=0) * np.repeat([1, 0, 1], [7, 6, 6])
AT_REST = np.concatenate([REST, TABLE, np.repeat(TABLE[-1:], 400, axis=0) * (REST[:1] != 0)])
AT_REST[:, 0] = np.arange(len(AT_REST)) / RATE

SURVIVED: dict[str, tuple[Lines, str]] = {
    "cut in the last row": (
        changed(601, lambda x: x[:40]),
        "Line 601 is left out: 5 values where the others have 19.",
    ),
    "cut in the middle": (
        changed(300, lambda x: x[:60]),
        "Line 300 is left out: 7 values where the others have 19.",
    ),
    "two rows in one": (
        changed(300, lambda x: x + x),
        "Line 300 is left out: 37 values where the others have 19.",
    ),
    "1e251 in the middle": (
        changed(200, cell(15, "1e251")),
        "Line 200 is left out: column 'elbow_joint.torque': 1e+251 is no quantity.",
    ),
    "NaN in the middle": (
        changed(200, cell(2, "nan")),
        "Line 200 is left out: column 'shoulder_lift_joint': the value is not a finite number.",
    ),
    "an empty cell": (
        changed(200, cell(2, "")),
        "Line 200 is left out: column 'shoulder_lift_joint': the value is not a finite number.",
    ),
    "a word in a cell": (
        changed(90, cell(18, "ERR")),
        "Line 90 is left out: column 'wrist_3_joint.torque': 'ERR' is not a number.",
    ),
    "the header again": (
        text(TABLE[:250]) + text(TABLE[250:]),
        "Line 252 is left out: column 't': 't' is not a number.",
    ),
    "a spike": (
        changed(400, cell(3, "9.0")),
        "Line 400 is left out: a spike between neighbours that agree.",
    ),
    "a huge torque": (
        changed(400, cell(13, "1e30")),
        "Line 400 is left out: a spike between neighbours that agree.",
    ),
    "jitter": (
        text(rows(TIMES + 0.003 * rng.uniform(-1, 1, COUNT))),
        "were brought to a grid of 100 Hz by straight lines between them.",
    ),
    "lost rows": (
        text(np.delete(TABLE, range(300, 330), axis=0)),
        "1 gap of up to 0.31 s (line 302 first): nothing is taken as measured there.",
    ),
    "a clock set back": (
        text(clock(-2.0)),
        "The clock goes back from 2.99 to 1 s (line 302): nothing is taken as measured "
        "around that place.",
    ),
    "a clock set forward": (
        text(clock(3600.0)),
        "1 gap of up to 3600 s (line 302 first) is shortened to 2 s.",
    ),
    "rows that overtook": (
        text(TABLE[[*range(300), 301, 300, *range(302, COUNT)]]),
        "2 rows stood in another order than their times (line 303 first) and were put in order.",
    ),
    "rows twice": (
        text(np.repeat(TABLE, 2, axis=0)),
        "600 rows repeat the time of the row before (line 3 first) and are left out. If the "
        "times are rounded",
    ),
    "rests at both ends": (
        text(AT_REST),
        "Rests of 3.01 s at the beginning and 3.01 s at the end were left out.",
    ),
    "milliseconds": (
        text(rows(1e3 * TIMES, TIMES)),
        "The times advance by 10 a row and are taken as ms; write 't (ms)' in the header",
    ),
    "nanoseconds since 1970": (
        text(rows(1.7e18 + 1e9 * TIMES, TIMES)),
        "a row and are taken as ns; write 't (ns)' in the header",
    ),
    "an encoder that starts anew": (
        text(wrapped()),
        "The positions of shoulder_pan_joint step by whole turns at",
    ),
    "no rates": (
        without(*RATES),
        "There are no rates in the log: the positions are differentiated.",
    ),
    "rates that are noise": (
        text(np.column_stack([TABLE[:, :7], rng.normal(size=(COUNT, 6)), TABLE[:, 13:]])),
        "are not those of the positions (correlation",
    ),
    "rates without numbers": (
        [
            ",".join(c if not 7 <= k < 13 or n == 0 else "nan" for k, c in enumerate(x.split(",")))
            for n, x in enumerate(text(TABLE))
        ],
        "column 'shoulder_pan_joint.v' has hardly a number: no velocity was read.",
    ),
    "a joint that never moves": (
        text(
            np.column_stack(
                [TABLE[:, :6], 0.3 + 0 * TIMES, TABLE[:, 7:12], 0 * TIMES, TABLE[:, 13:]]
            )
        ),
        "wrist_3_joint never moves: the log tells nothing of its friction",
    ),
    "a torque that was not measured": (
        text(scaled(0.0, 16)),
        "The torques of wrist_1_joint never change: they were not measured.",
    ),
    "torques in mN m": (
        text(scaled(1e3, *TORQUES)),
        "The log's torques are far beyond the effort limit of shoulder_pan_joint",
    ),
    "a few seconds": (
        text(TABLE[:150]),
        "The log is 1.49 s long: little is left without 1 s at both ends",
    ),
}


@pytest.mark.parametrize("case", SURVIVED)
def test_survived_with_a_notice(case: str, tmp_path: Path) -> None:
    lines, notice = SURVIVED[case]

    log = fb.read_log(written(tmp_path, lines), ARM)

    found = " ".join(log.notices)
    assert notice.lower() in found.lower()
    assert len(log.time) == len(log.position) == len(log.measured)
    assert log.rate == pytest.approx(RATE, rel=1e-3)


ANOTHER = {
    "rests at both ends",
    "an encoder that starts anew",
    "a joint that never moves",
    "torques in mN m",
    "a torque that was not measured",
    "a few seconds",
    "a clock set forward",
    "a clock set back",
}
"""Logs that say something else than the whole one, or of other times."""


@pytest.mark.parametrize("case", sorted(set(SURVIVED) - ANOTHER))
def test_what_is_measured_is_as_in_the_whole_log(case: str, tmp_path: Path) -> None:
    log = fb.read_log(written(tmp_path, SURVIVED[case][0]), ARM)

    start = np.arcsin((log.position[0, 0] - 0.1) / 0.8) / 0.6
    q, qd, tau = signals(log.time + start)
    sure = log.measured.copy()
    sure[[0, -1]] = False  # differences are one-sided there
    assert log.torque is not None
    assert sure.mean() > 0.9
    assert np.abs(log.position - q)[sure].max() < 2e-3
    assert np.abs(log.velocity - qd)[sure].max() < 2e-2
    assert np.abs(log.torque - tau)[sure].max() < 2e-2


@pytest.mark.parametrize(("shift", "around"), [(-2.0, 3.0), (3600.0, 3.0)])
def test_a_clock_that_was_set_costs_only_what_is_near(
    shift: float, around: float, tmp_path: Path
) -> None:
    log = fb.read_log(written(tmp_path, text(clock(shift))), ARM)
    gap = np.flatnonzero(~log.measured)

    assert np.array_equal(gap, np.arange(gap[0], gap[-1] + 1))
    assert log.time[gap[0]] == pytest.approx(around, abs=0.02)
    after = log.position[gap[-1] + 1 :]
    assert np.abs(after - TABLE[COUNT - len(after) :, 1:7]).max() < 2e-6
    assert log.settled().sum() == pytest.approx(COUNT - 4 * RATE, abs=8)


LAYOUT = '[log]\ntime = 1\nposition = "2-7"\nvelocity = "8-13"\ntorque = "14-19"\n'
REFUSED: dict[str, tuple[Lines, str, str]] = {
    "empty": ([""], "", "arm.csv: the file is empty."),
    "separators alone": ([",,;", ";"], "", "there is no row of numbers in the first 0 lines"),
    "a header alone": (
        text(TABLE[:0]),
        "",
        "there is no row of numbers in the first 1 lines; a log has a header",
    ),
    "no header": (
        text(TABLE, None),
        "",
        "Write into a TOML file beside the log, of the same name: [log], time = 1, position "
        '= "2-7", velocity = "8-13", torque = "14-19"',
    ),
    "a joint too few": (
        without(6, 12, 18),
        "",
        "arm.csv:1: there is no position of 'wrist_3_joint'; it has",
    ),
    "no torques": (
        without(*TORQUES),
        "",
        "arm.csv:1: no column holds torques or currents of the joints",
    ),
    "no time": (without(0), "", "arm.csv:1: no column holds the time; it has 'shoulder_pan_joint'"),
    "times that stand still": (
        text(scaled(0.0, 0)),
        "",
        "arm.csv:2: the times do not advance: all rows have t = 0",
    ),
    "times that go back at every fifth row": (
        text(rows(TIMES - 0.5 * (np.arange(COUNT) % 5 == 4) * (TIMES > 1), TIMES)),
        "",
        "sort the rows, or give a file for each run.",
    ),
    "degrees": (
        text(scaled(180 / np.pi, *POSITIONS, *RATES)),
        "",
        "shoulder_pan_joint goes to 51.57 rad, where its range ends at 6.283 rad: if these "
        'are deg, write units = { position = "deg" }',
    ),
    "rates in degrees": (
        text(scaled(180 / np.pi, *RATES)),
        "",
        "the positions are in rad where the rates are in deg/s; write units = { velocity = "
        '"deg/s" }',
    ),
    "rates in rpm": (text(scaled(30 / np.pi, *RATES)), "", 'write units = { velocity = "rpm" }'),
    "rates of the other sign": (
        text(scaled(-1.0, 9)),
        "",
        "the positions of elbow_joint change -1 times as fast as its rates say: the "
        "positions have the other sign",
    ),
    "rates of the motors": (
        text(scaled(100.0, 9)),
        "",
        "the positions of elbow_joint change 0.01 times as fast",
    ),
    "torques all zero": (
        text(scaled(0.0, *TORQUES)),
        "",
        "all torques are constant (0): they were not measured",
    ),
    "positions all alike": (
        text(scaled(0.0, *POSITIONS, *RATES)),
        "",
        "no joint moves in this log; log a motion.",
    ),
    "decimal commas between commas": (
        [",".join(HEADER), *(x.replace(".", ",") for x in text(TABLE, None))],
        "",
        "arm.csv:1: the header names 19 columns, the rows have 38; with decimal commas, "
        "separate the columns by semicolons.",
    ),
    "every third row cut": (
        [x if k % 3 else x[:50] for k, x in enumerate(text(TABLE), 1)],
        "",
        "arm.csv:3: 6 values where the others have 19; 200 of 600 rows are broken",
    ),
    "a torque without numbers": (
        [
            ",".join(c if k != 15 or n == 0 else "nan" for k, c in enumerate(x.split(",")))
            for n, x in enumerate(text(TABLE))
        ],
        "",
        "column 'elbow_joint.torque' has no number in 600 of 600 rows, and holds a torque "
        "that is needed.",
    ),
    "twenty rows": (text(TABLE[:20]), "", "20 samples; a log needs at least 30."),
    "two columns of one quantity": (
        text(np.column_stack([TABLE, TABLE[:, 13]]), [*HEADER, "shoulder_pan_joint_effort"]),
        "",
        "columns 'shoulder_pan_joint.torque' and 'shoulder_pan_joint_effort' both look like "
        "the torque of joint shoulder_pan_joint; remove one",
    ),
    "a unit of something else": (
        text(TABLE, [*HEADER[:13], "shoulder_pan_joint.torque (deg)", *HEADER[14:]]),
        "",
        "'deg' is not a unit of the torque of 'shoulder_pan_joint'; units: N m",
    ),
    "a layout beyond the columns": (
        text(TABLE, None),
        LAYOUT.replace("14-19", "15-20"),
        "arm.toml names column 20, and there are 19 columns.",
    ),
    "a layout of five joints": (
        text(TABLE, None),
        LAYOUT.replace("14-19", "14-18"),
        "arm.toml:5: [log]: torque has 5 entries, position has 6; give one for each joint.",
    ),
    "a layout with a key too many": (
        text(TABLE, None),
        LAYOUT + "torgue = 3\n",
        "arm.toml:6: no key 'torgue' in [log]. Did you mean 'torque'?",
    ),
    "a layout without a unit": (
        text(TABLE, None),
        LAYOUT + 'units = { position = "degree" }\n',
        "no unit 'degree' in [log]. Did you mean 'deg'?",
    ),
    "a layout with a range that ends before it begins": (
        text(TABLE, None),
        LAYOUT.replace("2-7", "7-2"),
        'position is "7-2", expected a range such as "2-7".',
    ),
    "signs that are none": (
        text(TABLE, None),
        LAYOUT + "signs = [1, 1, 2, 1, 1, 1]\n",
        "arm.toml:6: [log]: signs[2] is 2, expected 1 or -1.",
    ),
    "constants without gears": (
        text(TABLE, None),
        LAYOUT.replace("torque", "current") + "torque_constants = [1, 1, 1, 1, 1, 1]\n",
        "torque_constants (N m/A of the motor) and gears",
    ),
    "joints of another robot": (
        text(TABLE, None),
        LAYOUT + 'joints = ["a", "b", "c", "d", "e", "f"]\n',
        "no joint 'a' in 'ur5e'",
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused_in_one_line(case: str, tmp_path: Path) -> None:
    lines, layout, problem = REFUSED[case]

    with pytest.raises(fb.FileError) as refused:
        fb.read_log(written(tmp_path, lines, layout), ARM)

    assert problem in str(refused.value)
    assert "\n" not in str(refused.value)


def test_files_that_are_none(tmp_path: Path) -> None:
    with pytest.raises(fb.FileError, match="there is no such file"):
        fb.read_log(tmp_path / "none.csv")
    with pytest.raises(fb.FileError, match="this is a folder"):
        fb.read_log(tmp_path)
    binary = tmp_path / "arm.csv"
    binary.write_bytes(b"t,q\n\0\1\2\3,4\n")
    with pytest.raises(fb.FileError, match="binary"):
        fb.read_log(binary)
    binary.write_bytes("t,joint_é\n1,2\n".encode("latin-1"))
    with pytest.raises(fb.FileError, match=r"arm.csv:1: the text is not UTF-8; save it as UTF-8"):
        fb.read_log(binary)
