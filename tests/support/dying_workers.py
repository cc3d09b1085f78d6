"""What a worker of pytest-xdist wrote to standard error before it died stands in the report of the
test that it ran: the last words of a library that ends the process, and Python's own of where it
was."""

from __future__ import annotations

import faulthandler
import os
import shutil
import tempfile
from pathlib import Path
from typing import Any

import pytest

_KEY = "freebody_standard_error"


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node: Any) -> None:
    """In the main process, of a worker that is about to start: where its standard error goes."""
    folder = tempfile.mkdtemp(prefix="freebody-worker-")
    node.config.add_cleanup(lambda: shutil.rmtree(folder, ignore_errors=True))
    node.workerinput[_KEY] = str(Path(folder) / "stderr")


@pytest.hookimpl(trylast=True)  # when pytest has set up Python's own handler of faults
def pytest_configure(config: pytest.Config) -> None:
    """In a worker: what pytest captures lies in a file that stays when the process ends."""
    path = getattr(config, "workerinput", {}).get(_KEY)
    capture = config.pluginmanager.getplugin("capturemanager")
    captured = getattr(getattr(capture, "_global_capturing", None), "err", None)
    file = getattr(captured, "tmpfile", None)
    if path is None or file is None:
        return
    with open(path, "w+b") as kept:
        os.dup2(kept.fileno(), file.fileno(), inheritable=False)
    faulthandler.enable(file.fileno())


@pytest.hookimpl(optionalhook=True)
def pytest_handlecrashitem(report: Any) -> None:
    """In the main process, of the report of a test whose worker died."""
    path = report.node.workerinput.get(_KEY)
    if path is not None and Path(path).exists():
        said = Path(path).read_text(encoding="utf-8", errors="replace").strip("\0")
        report.sections.append(("Captured stderr of the worker that died", said))
