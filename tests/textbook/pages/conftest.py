"""One browser for all tests of pages that a process runs, and each page built once a run."""

from __future__ import annotations

import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import freebody as fb
from support.browser import browser

PageOf = Callable[..., Path]


@pytest.fixture(scope="session")
def page_of(tmp_path_factory: pytest.TempPathFactory) -> PageOf:
    """The file with the page of a bundled robot's derivation, by the robot's name, a method and
    other options of `fb.derive`; whichever process of the run needs it first builds it."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "derivations"
    folder.mkdir(exist_ok=True)

    def page_of(name: str, method: str | None = None, **options: Any) -> Path:
        words = re.sub(r"[^\w.-]+", "_", f"{name} {method} {options}")
        page = folder / f"{words}.html"
        if not page.exists():
            made = own / page.name
            text = fb.derive(fb.load(name), method, **options).html()
            made.write_text(text, encoding="utf-8")
            made.replace(page)
        return page

    return page_of


@pytest.fixture(scope="session")
def session_browser(tmp_path_factory: pytest.TempPathFactory):
    with browser(tmp_path_factory.mktemp("profile")) as opened:
        opened.set_script_timeout(300)
        yield opened


@pytest.fixture
def driver(session_browser, request: pytest.FixtureRequest):
    """The browser, its window as large as the test's file says in WINDOW, without the page and the
    messages of the test before."""
    session_browser.execute("get", {"url": "about:blank"})
    session_browser.set_window_size(*request.module.WINDOW)
    session_browser.get_log("browser")
    return session_browser
