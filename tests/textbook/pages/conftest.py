"""One browser for all tests of pages that a process runs."""

from __future__ import annotations

import pytest

from support.browser import browser


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
