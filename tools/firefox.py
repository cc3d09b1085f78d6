"""Pages that move, once in Firefox: studies and studios of some robots are opened, played and
changed, and what they compute is compared with Python's numbers.

    python tools/firefox.py [ROBOT…]

Needs Firefox (`firefox-esr` or `firefox` on the path) and the package websocket-client, which
Selenium brings; Firefox is spoken to by WebDriver BiDi, without geckodriver. The tests drive the
same pages in Chromium, and more closely.
"""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import numpy as np
import websocket

import freebody as fb
from freebody.studio.studio_page import studio_page

ROBOTS = "ur5e", "2R", "five_bar", "stewart"
CLOSE = 1e-9
THERE = """for (let n = 0; !(typeof player !== 'undefined' && player) && n < 900; n++)
  await new Promise(later => setTimeout(later, 10));
while (player.study.what && !player.what) await new Promise(later => setTimeout(later, 10));"""
PLACES = "return [[...player.t], player.stage.places(player.q, player.study.scene.tip)]"
PLAYED = """player.show(0); player.work.length = 0; find('play').click();
await new Promise(later => setTimeout(later, 1000)); find('play').click();
return [player.k, player.work.reduce((sum, x) => sum + x) / player.work.length]"""
LOADED = """const slider = find('load'), rows = [...document.querySelectorAll('[data-drive]')];
const cells = () => rows.map(row => row.cells[2].textContent).join();
if (!slider) return null;
const [before, load] = [cells(), Number(slider.max) / 2];
slider.value = load; slider.dispatchEvent(new Event('input'));
return [before !== cells(), load, player.what.compute(load, 1, 0).curves.map(x => [...x])]"""
PROVED = """for (let n = 0; !(typeof page !== 'undefined' && page) && n < 900; n++)
  await new Promise(later => setTimeout(later, 10));
return [page !== undefined, page && await unlike(page.studio.proofs)]"""
SLID = """const before = [...page.state.q], slider = document.querySelector('[data-joint] input');
slider.value = (Number(slider.min) + 2 * Number(slider.max)) / 3;
slider.dispatchEvent(new Event('input')); find('run').click();
await new Promise(later => setTimeout(later, 1000)); find('run').click();
return [page.state.q.some((x, k) => x !== before[k]), page.run.t]"""


class Firefox:
    """A page in a headless Firefox."""

    def __init__(self, address: str) -> None:
        self.socket = websocket.create_connection(f"{address}/session", suppress_origin=True)
        self.numbers, self.said = count(1), list[str]()
        found = self.call("session.new", capabilities={})["capabilities"]
        self.version = f"{found['browserName']} {found['browserVersion']}"
        self.call("session.subscribe", events=["log.entryAdded"])
        self.context = self.call("browsingContext.getTree")["contexts"][0]["context"]

    def call(self, method: str, **parameters: Any) -> Any:
        """The result of a command of BiDi; what the page says meanwhile is kept."""
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while True:
            got = json.loads(self.socket.recv())
            if got.get("method") == "log.entryAdded":
                self.said.append(got["params"]["text"])
            elif got.get("id") == number:
                if got["type"] == "error":
                    raise RuntimeError(got["message"])
                return got["result"]

    def get(self, path: Path) -> None:
        """Opens a page."""
        self.call(
            "browsingContext.navigate", context=self.context, url=path.as_uri(), wait="complete"
        )

    def run(self, body: str) -> Any:
        """What a function with this body returns in the page, by way of JSON."""
        text = f"async () => JSON.stringify(await (async () => {{ {body} }})())"
        found = self.call(
            "script.callFunction",
            functionDeclaration=text,
            awaitPromise=True,
            target={"context": self.context},
        )
        if found["type"] == "exception":
            raise RuntimeError(found["exceptionDetails"]["text"])
        return json.loads(found["result"].get("value", "null"))


@contextmanager
def firefox() -> Iterator[Firefox]:
    """A Firefox with a profile of its own."""
    program = shutil.which("firefox-esr") or shutil.which("firefox")
    if program is None:
        sys.exit("There is no firefox-esr or firefox on the path.")
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as profile:
        command = [program, "--headless", "--no-remote", "--profile", profile]
        process = subprocess.Popen(
            [*command, "--remote-debugging-port", "0"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        told = Path(profile, "WebDriverBiDiServer.json")
        try:
            for _ in range(300):
                if process.poll() is not None or (told.is_file() and told.stat().st_size):
                    break
                time.sleep(0.1)
            if not told.is_file():
                sys.exit(f"{program} did not open itself to WebDriver BiDi within 30 s.")
            at = json.loads(told.read_text(encoding="utf-8"))
            yield Firefox(f"ws://{at['ws_host']}:{at['ws_port']}")
        finally:
            process.terminate()
            process.wait()


def study_faults(page: Firefox, name: str, path: Path) -> Iterator[str]:
    """Words on what is wrong with the page of a robot's study."""
    study = fb.study(fb.load(name))
    page.get(study.to_html(path))
    page.run(THERE)
    t, places = map(np.array, page.run(PLACES))
    kept = np.isin(t, study.motion.t)
    expected = study.data["tip_position"].values[np.searchsorted(study.motion.t, t[kept])]
    if not np.abs(places[kept][:, : expected.shape[1]] - expected).max() < CLOSE:
        yield "the tip is not where Python has it"
    shown, work = page.run(PLAYED)
    if not shown:
        yield "it does not play"
    print(f"{name}: {work:.1f} ms a picture")
    loaded = page.run(LOADED)
    if loaded is None:
        return
    changed, load, curves = loaded
    if not changed:
        yield "the slider of the load changes no number"
    torques = fb.inverse_dynamics(study.model.with_payload(load), *study.motion.at(t))
    if not np.abs(np.transpose(curves) - torques).max() < CLOSE * np.abs(torques).max():
        yield "torques under another load are not Python's"


def studio_faults(page: Firefox, name: str, path: Path) -> Iterator[str]:
    """Words on what is wrong with the page of a robot's studio."""
    path.write_text(studio_page(fb.load(name)), encoding="utf-8")
    page.get(path)
    there, unlike = page.run(PROVED)
    if not there or unlike:
        yield f"the studio's kernels do not give Python's numbers: {unlike}"
        return
    moved, t = page.run(SLID)
    if not (moved and t > 0):
        yield "the studio does not move"


if __name__ == "__main__":
    with firefox() as page, tempfile.TemporaryDirectory() as folder:
        print(page.version)
        faults = [
            f"{name}: {fault}"
            for name in sys.argv[1:] or ROBOTS
            for look in (study_faults, studio_faults)
            for fault in look(page, name, Path(folder) / "index.html")
        ]
        faults += [f"in the console: {words}" for words in page.said]
    sys.exit("\n".join(faults) or 0)
