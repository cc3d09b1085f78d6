"""Pages as PDF, printed by a Chromium that is at hand: paper shows what the browser shows."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from freebody.errors import FreebodyError

BROWSER = "FREEBODY_BROWSER"
"""The environment variable that names the browser, where it is to be another one."""
_PROGRAMS = (
    "chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome",
    "microsoft-edge", "msedge", "brave-browser",
)  # fmt: skip
_ELSEWHERE = {
    "darwin": (
        "/Applications/Google Chrome.app/Contents/MacOS/Google Chrome",
        "/Applications/Chromium.app/Contents/MacOS/Chromium",
        "/Applications/Microsoft Edge.app/Contents/MacOS/Microsoft Edge",
    ),
    "win32": (
        r"C:\Program Files\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Google\Chrome\Application\chrome.exe",
        r"C:\Program Files (x86)\Microsoft\Edge\Application\msedge.exe",
    ),
}
"""Where the installers of a system put browsers that are not on the path."""
_PATIENCE = 180.0
"""Seconds that a page may take."""
_OPTIONS = (
    "--headless", "--disable-gpu", "--no-first-run", "--disable-extensions",
    "--disable-dev-shm-usage", "--disable-background-networking", "--no-pdf-header-footer",
)  # fmt: skip


def browser() -> str:
    """The path of the browser that prints.

    Raises FreebodyError where there is none: it says what to install.
    """
    wanted = os.environ.get(BROWSER)
    if wanted:
        found = shutil.which(wanted)
        if found is None:
            raise FreebodyError(
                f"PDF: {BROWSER} is {wanted!r}, which is no program that can be run; name the "
                f"program of a Chromium, or unset it."
            )
        return found
    found = next(_found(), None)
    if found is None:
        raise FreebodyError(
            f"PDF: no Chromium, Chrome or Edge was found, which prints the page. Install one (such "
            f"as `apt install chromium`), name its program in {BROWSER}, or open the HTML report "
            f"in any browser and print it there."
        )
    return found


def _found() -> Iterator[str]:
    yield from filter(None, map(shutil.which, _PROGRAMS))
    yield from (path for path in _ELSEWHERE.get(sys.platform, ()) if Path(path).is_file())


def pdf(page: str) -> bytes:
    """The PDF of an HTML page, as the page's own rules for paper lay it out.

    Raises FreebodyError where there is no browser, or where it fails.
    """
    program = browser()
    with tempfile.TemporaryDirectory(prefix="freebody-", ignore_cleanup_errors=True) as folder:
        source, printed = Path(folder, "page.html"), Path(folder, "page.pdf")
        source.write_text(page, encoding="utf-8")
        command = [
            program, *_OPTIONS, f"--user-data-dir={Path(folder, 'profile')}",
            f"--print-to-pdf={printed}", source.as_uri(),
        ]  # fmt: skip
        if getattr(os, "geteuid", lambda: 1)() == 0:
            # Chromium refuses to run as root with its sandbox; the page runs no script
            command.insert(1, "--no-sandbox")
        try:
            done = subprocess.run(command, capture_output=True, timeout=_PATIENCE, check=False)
        except subprocess.TimeoutExpired:
            raise FreebodyError(
                f"PDF: {program} did not print the page within {_PATIENCE:.0f} s; open the HTML "
                f"report in a browser and print it there."
            ) from None
        if not printed.is_file():
            told = done.stderr.decode(errors="replace").strip().splitlines()
            why = f": {told[-1]}" if told else ""
            raise FreebodyError(
                f"PDF: {program} printed nothing (exit status {done.returncode}){why}; open the "
                f"HTML report in a browser and print it there."
            )
        return printed.read_bytes()
