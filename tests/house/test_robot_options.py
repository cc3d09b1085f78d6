"""One set of options tells which robot: every command that takes one takes all of them, and uses
or refuses what is done to it."""

from __future__ import annotations

import re

from support.command import commands, error, run

PANEL = re.compile(r"─ The robot ─+╮\n(.*?)╰", re.DOTALL)
OPTION = re.compile(r"^│ (?:\* +)?(--[\w-]+)", re.MULTILINE)
READING = {"--convention", "--package-path", "--xacro", "--xacro-environment"}
OF_USE = {"--wrench", "--speed"}
OLD_SPELLING = ("plan", "--speed")
"""What was --tip-speed."""


def options(name: str) -> set[str]:
    """The options of a command that tell which robot, and what is done to it."""
    return {x for text in PANEL.findall(commands()[name]) for x in OPTION.findall(text)}


def required(name: str) -> list[str]:
    """The arguments that a command must be given."""
    return re.findall(r"Usage: freebody \w+ \[OPTIONS\] (.*)", commands()[name])[0].split()


def of_robots() -> set[str]:
    return {name for name in commands() if "{robot}" in required(name)}


def test_every_command_that_takes_a_robot_takes_the_same_options():
    same = options("study") - OF_USE
    assert {"--lock", "--payload", "--gravity", "--mounting", "--parameter", *READING} < same
    found = {name: options(name) - OF_USE for name in commands()}
    doctor = found.pop("doctor")  # which looks at the file, whatever is made of it
    assert doctor == READING
    assert found == {name: same if name in of_robots() else set() for name in found}
    assert {"check", "derive", "fbd", "study", "identify", "diff", "show"} <= of_robots()


def test_what_is_done_to_a_robot_is_used_or_refused_with_a_reason(capsys):
    for name in of_robots():
        for option in OF_USE - {*OPTION.findall(commands()[name])}:
            if (name, option) != OLD_SPELLING:
                arguments = ["2R", *["x=0" for _ in required(name)[1:]]]
                if name == "size":
                    arguments += ["--catalogue", "invented"]
                assert error(capsys, name, *arguments, option, "2").startswith(f"{option}: ")


def test_a_joint_is_locked_in_what_is_derived_checked_and_drawn(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    lock = ["3R", "--lock", "joint3=0"]
    assert run(["derive", *lock, "--method", "kinematics"]) == 0
    told = capsys.readouterr().out
    assert "θ₂" in told
    assert "θ₃" not in told
    assert run(["fbd", *lock, "--q", "0.1, 0.2"]) == 0
    assert run(["check", *lock, "J12 = -(l2 + l3)*sin(theta1 + theta2)"]) == 0
