"""The policy of pages in a real browser: no page of ours offends it; nothing that is put into one
runs or fetches."""

from __future__ import annotations

import re
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

import freebody as fb
from freebody.outputs.pages import policy
from support.browser import browser
from support.hostile import hostile_study
from support.hostile_pages import LIVING, pages

pytestmark = pytest.mark.browser

INJECTED = """<script>document.title = "run"</script><img src="x:" onerror="document.title = 'run'">
<svg onload="document.title = 'run'"></svg><base href="{at}/base/">
<img src="{at}/img"><script src="{at}/js"></script><link rel="stylesheet" href="{at}/css">
<iframe src="{at}/frame"></iframe>
<object data="{at}/object"></object>
<style>@font-face{{font-family:f;src:url({at}/font)}} h1{{font-family:f}}</style>
<form id="leak" action="{at}/form"></form>"""
FETCH = """const done = arguments[0];
fetch('{at}/fetch', {{mode: 'no-cors'}}).then(() => done('out'), () => done('held'))"""


@pytest.fixture(scope="module")
def arm(tmp_path_factory) -> fb.Study:
    return hostile_study(tmp_path_factory)


@pytest.fixture(scope="module")
def chromium(tmp_path_factory):
    with browser(tmp_path_factory.mktemp("profile")) as driver:
        driver.set_page_load_timeout(30)
        yield driver


@pytest.fixture
def server():
    """An address, and the paths that were asked of it."""
    asked: list[str] = []

    class Asked(BaseHTTPRequestHandler):
        def do_GET(self):
            asked.append(self.path)
            self.send_response(204)
            self.end_headers()

        def log_message(self, *arguments):
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Asked) as serving:
        threading.Thread(target=serving.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{serving.server_port}", asked
        serving.shutdown()


def test_no_page_offends_its_policy(arm: fb.Study, chromium, tmp_path):
    for name, text in pages(arm).items():
        path = tmp_path / f"{name}.html"
        path.write_text(text, encoding="utf-8")
        chromium.get(path.as_uri())
        assert chromium.get_log("browser") == [], name
        scripts = chromium.execute_script("return document.scripts.length")
        # those of derivations inflate another
        assert scripts == (1 if name == "study" else 2 * (name in LIVING)), name
        titles = {"notes": "Dynamics of", "chapter": "1 Motion"}
        assert chromium.title.startswith(titles.get(name, "<script>alert(2)</script>: "))


def test_nothing_that_is_put_into_a_page_runs_or_fetches(arm: fb.Study, chromium, tmp_path, server):
    address, asked = server
    page = pages(arm)["study"].replace("</body>", INJECTED.format(at=address) + "</body>")
    path = tmp_path / "page.html"

    def tried(text: str) -> tuple[str, str]:
        path.write_text(text, encoding="utf-8")
        chromium.get(path.as_uri())
        fetched = chromium.execute_async_script(FETCH.format(at=address))
        chromium.execute_script("document.getElementById('leak').submit()")
        chromium.get("about:blank")
        return fetched, chromium.title

    assert tried(page)[0] == "held"
    assert asked == []
    log = "\n".join(entry["message"] for entry in chromium.get_log("browser"))
    for rule in (
        "script-src",
        "img-src",
        "style-src",
        "default-src",
        "base-uri",
        "form-action",
        "font-src",
    ):
        assert rule in log, rule
    path.write_text(page, encoding="utf-8")
    chromium.get(path.as_uri())
    assert chromium.title == "<script>alert(2)</script>: dynamic study"

    free = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', "", page)
    tried(free)  # what the policy is good for
    assert len(set(asked)) > 5
    path.write_text(free, encoding="utf-8")
    chromium.get(path.as_uri())
    assert chromium.title == "run"


def test_a_script_of_our_own_runs_by_its_hash(chromium, tmp_path):
    ours = "document.title = 'ours: θ'"
    head = f'<!doctype html><html><head><meta charset="utf-8">{policy([ours])}</head><body>'
    path = tmp_path / "page.html"
    path.write_text(
        f"{head}<script>{ours}</script><script>document.title = 'theirs'</script>", encoding="utf-8"
    )
    chromium.get(path.as_uri())
    assert chromium.title == "ours: θ"
