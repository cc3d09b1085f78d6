"""MuJoCo's process, started once for thousands of files: importing it takes longer than parsing.

As a program (`python mujoco_server.py COMPILED`) it answers each path on a line of its standard
input with a line of JSON, as COMPILED, the program of `freebody.formats.mjcf`, does for one file.
"""

from __future__ import annotations

import atexit
import json
import runpy
import select
import subprocess
import sys
from tempfile import TemporaryDirectory
from typing import Any

SECONDS = 20.0
"""Time that a file may take."""


class MujocoServer:
    """Stands in for `subprocess.run` where freebody has a file compiled."""

    def __init__(self) -> None:
        self.process: subprocess.Popen[bytes] | None = None
        self.folder: TemporaryDirectory[str] | None = None

    def run(self, command: list[str], **_: Any) -> subprocess.CompletedProcess[bytes]:
        """The answer for the file that a command ends with; a process that ended is replaced."""
        python, program, path = command
        if self.process is None:
            self.folder = TemporaryDirectory()  # MuJoCo writes a log where it runs
            atexit.register(self.close)
            self.process = subprocess.Popen(
                [python, "-P", __file__, program],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                cwd=self.folder.name,
            )
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(f"{path}\n".encode())
        self.process.stdin.flush()
        output: list[Any] = [self.process.stdout]
        ready = select.select(output, [], [], SECONDS)[0]
        line = self.process.stdout.readline() if ready else b""
        if line.endswith(b"\n"):
            return subprocess.CompletedProcess(command, 0, line, b"")
        code = self.close()
        if not ready:
            raise TimeoutError(f"MuJoCo took more than {SECONDS} s")
        return subprocess.CompletedProcess(command, code, b"", b"")

    def close(self) -> int:
        """End the process; how it ended."""
        process, self.process = self.process, None
        if process is None:
            return 0
        atexit.unregister(self.close)
        assert self.folder is not None
        self.folder.cleanup()
        assert process.stdin is not None
        assert process.stdout is not None
        process.kill()
        process.stdin.close()
        process.stdout.close()
        return process.wait()


def _serve(program: str) -> None:
    of = runpy.run_path(program)
    of["bound_memory"]()
    for line in sys.stdin:
        print(json.dumps(of["answer"](line.rstrip("\n"), None)), flush=True)


if __name__ == "__main__":
    _serve(sys.argv[1])
