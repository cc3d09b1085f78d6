"""The terminal's encoding: whatever it is, what is printed can be read."""

import io
import os
import subprocess
import sys

import pytest

from support.command import run

COMMANDS = [
    ["derive", "2R"],
    ["derive", "puma560", "--method", "kinematics"],
    ["check", "2R", "H11 = 1"],
    ["check", "2R", "θ̈₁ ="],
    ["fbd", "2R", "--q", "0.5, 60°"],
    ["show", "2R"],
    ["show", "kein_Röboter"],
    ["models"],
    ["notes", "eq-3.22"],
    ["--help"],
]


@pytest.mark.sample(1)
@pytest.mark.parametrize("encoding", ["cp1252", "ascii"])
@pytest.mark.parametrize("command", COMMANDS, ids=" ".join)
def test_every_command_prints_in_every_encoding(
    tmp_path, monkeypatch, encoding: str, command: list[str]
):
    monkeypatch.chdir(tmp_path)
    codes, texts = [], []
    for chosen in (encoding, "utf-8"):
        streams = [io.TextIOWrapper(io.BytesIO(), encoding=chosen) for _ in range(2)]
        monkeypatch.setattr(sys, "stdout", streams[0])
        monkeypatch.setattr(sys, "stderr", streams[1])
        codes.append(run(command))
        for stream in streams:
            stream.flush()
        texts.append("".join(stream.buffer.getvalue().decode(chosen) for stream in streams))
    monkeypatch.undo()
    assert codes[0] == codes[1]
    assert "fault of freebody" not in texts[0] + texts[1]
    assert texts[0].count("\n") == texts[1].count("\n")
    assert "\\u" not in texts[0]  # every letter that freebody prints has a spelling
    assert "?" * 2 not in texts[0]


def test_the_program_redirected_into_another_encoding():
    done = subprocess.run(
        [sys.executable, "-m", "freebody", "check", "2R", "H22 = I2"],
        env={**os.environ, "PYTHONIOENCODING": "cp1252"},
        capture_output=True,
    )
    assert done.returncode == 1, done.stderr
    assert b"fault" not in done.stdout + done.stderr
