"""The command line from inside: interruptions, faults and failed checks, put in where no user can,
and the spellings for each encoding of the terminal."""

from __future__ import annotations

import sys
from contextlib import contextmanager
from importlib.abc import MetaPathFinder
from pathlib import Path

import pytest

import freebody as fb
from freebody import cli
from freebody.cli import INTERRUPTED, terminal
from freebody.cli.terminal import spelled
from freebody.motion.simulation import simulate as module
from support.command import error, run


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)


def test_the_bar_of_a_study_only_grows_and_is_not_full_before_the_files_are_written(
    monkeypatch: pytest.MonkeyPatch,
):
    told: list[tuple[str, float]] = []

    @contextmanager
    def recorded(text: str):
        yield lambda doing, done: told.append((doing, done))

    monkeypatch.setattr(terminal, "progress", recorded)
    assert run(["study", "2R"]) == 0
    parts = [done for _, done in told]
    assert parts[0] == 0.0
    assert parts == sorted(parts)
    assert told[-1][0] == "report and data files"
    assert 0.5 < parts[-1] < 1.0


def test_a_failed_check_gives_exit_code_1(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    from freebody.report import checks

    monkeypatch.setattr(
        checks, "_parts", lambda data: checks.check("equation of motion", 0.5, 1e-10, "Planted.")
    )
    assert run(["study", "pendulum"]) == 1
    assert (
        "self-check failed: equation of motion: 0.5, allowed 1e-10. Planted."
        in capsys.readouterr().out
    )


def test_an_interruption_and_a_fault_are_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    from freebody.cli import models

    def interrupted():
        raise KeyboardInterrupt

    monkeypatch.setattr("freebody.robots.models", interrupted)
    assert models.models is not None
    assert run(["models"]) == 130
    assert capsys.readouterr().err == "error: interrupted.\n"

    def broken():
        raise ZeroDivisionError("it broke")

    monkeypatch.setattr("freebody.robots.models", broken)
    assert error(capsys, "models") == (
        "ZeroDivisionError: it broke (an error in freebody, please report it; FREEBODY_TRACEBACK=1 "
        "shows where)"
    )


def test_an_interruption_while_the_program_is_imported_is_one_line(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
):
    class Interrupted(MetaPathFinder):
        def find_spec(self, name, path, target=None):
            if name == "freebody.cli.app":
                raise KeyboardInterrupt
            return None

    monkeypatch.delitem(sys.modules, "freebody.cli.app")
    monkeypatch.setattr(sys, "meta_path", [Interrupted(), *sys.meta_path])
    with pytest.raises(SystemExit) as end:
        cli.main()
    assert end.value.code == 130
    assert capsys.readouterr().err == "error: interrupted.\n"


def test_an_interrupt_writes_what_there_is(monkeypatch, capsys):
    whole = module.simulate

    def stopped(model, q, qd, t, *arguments, progress, **options):
        result = whole(model, q, qd, t[:11], *arguments, **options)
        raise module.SimulationInterrupted(result)

    monkeypatch.setattr(module, "simulate", stopped)
    assert run(["simulate", "2R", "--time", "1"]) == INTERRUPTED
    assert len(fb.read_motion(fb.load("2R"), "motion.csv").t) == 11
    assert "interrupted" in capsys.readouterr().err


SPELLINGS = {
    "θ₁ + θ₂": "theta1 + theta2",
    "θ̇₁, θ̈₂, θ̇": "theta1_d, theta2_dd, theta_d",
    "v̇c₁ = q̇₁": "vc1_d = q1_d",
    "l₁² m₂": "l1^2 m2",
    "s⁻¹, 10⁻³": "s^-1, 10^-3",
    "Jᵀ λ": "J^T lambda",
    "τ₁ − τ₂ · 3 × Ω": "tau1 - tau2 * 3 x Omega",
    "½ I ω²": "1/2 I omega^2",
    "f_ₖᵢ": "f_ki",
    "Müller, ça": "Muller, ca",
    "┌ a │ ─ ┘": "+ a | - +",
    "关节\udc80": "\\u5173\\u8282\\udc80",
}


@pytest.mark.parametrize("text", SPELLINGS)
def test_spellings(text: str):
    assert spelled(text, "ascii") == SPELLINGS[text]


def test_what_the_encoding_has_stays():
    assert spelled("l₁² = ½ Müller", "cp1252") == "l1² = ½ Müller"
    assert spelled("θ₁² θ̇₁", "utf-8") == "θ₁² θ̇₁"
