"""Headless Chromium, as the tests of pages drive it."""

from __future__ import annotations

import shutil
import time
import warnings
from contextlib import contextmanager

FRESH = """const predict = document.getElementById('predict');
for (const on of [false, true]) {
  predict.checked = on;
  predict.dispatchEvent(new Event('change'));
}
return [...document.querySelectorAll('.answer')].map(field =>
  [field.dataset.name, field.querySelector('input').placeholder])"""
"""Hides what can be asked for, and tells its boxes: names and what their entries are called."""
ANSWER = """const [k, text] = arguments, field = document.querySelectorAll('.answer')[k];
field.querySelector('input').value = text; field.querySelector('button').click();
return field.querySelector('p').textContent"""
"""Types an answer into a box, and tells what is said of it."""
SAID = {"Right": "right", "Not r": "wrong", "Canno": "unread", "Not d": "undecided"}
"""What is said, by its first letters."""


@contextmanager
def touched(driver):
    """touch(places, places, …) with a browser that has a touch screen: fingers at places of the
    window, then at others, then lifted. They rest before, as a page that they fling scrolls on, and
    the next tap only stops it."""
    driver.execute_cdp_cmd(
        "Emulation.setTouchEmulationEnabled", {"enabled": True, "maxTouchPoints": 2}
    )

    def touch(*moves):
        kinds = ["touchStart", *["touchMove"] * (len(moves) - 1), "touchEnd"]
        for kind, fingers in zip(kinds, [*moves, []], strict=True):
            if kind == "touchEnd" and len(moves) > 1:
                time.sleep(0.2)
            points = [{"x": float(x), "y": float(y), "id": k} for k, (x, y) in enumerate(fingers)]
            driver.execute_cdp_cmd(
                "Input.dispatchTouchEvent", {"type": kind, "touchPoints": points}
            )

    try:
        yield touch
    finally:
        driver.execute_cdp_cmd("Emulation.setTouchEmulationEnabled", {"enabled": False})


@contextmanager
def browser(profile):
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.support.ui import WebDriverWait

    options = webdriver.ChromeOptions()
    quiet = ("background-networking", "component-update", "sync", "default-apps", "gpu")
    for argument in (
        "--headless=new",
        "--no-sandbox",
        "--no-first-run",
        "--disable-dev-shm-usage",
        f"--user-data-dir={profile}",
        *(f"--disable-{feature}" for feature in quiet),
    ):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # selenium's own
        driver = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    get = driver.get

    def whole(url: str) -> None:
        """Chromedriver may come back while a page is still read, or before its data is inflated."""
        get(url)
        there = """return document.readyState === 'complete'
            && !document.querySelector('#try[hidden]') && location.href.split('#')[0]"""
        WebDriverWait(driver, 30, poll_frequency=0.02).until(
            lambda opened: opened.execute_script(there) == url.split("#")[0]
        )

    driver.get = whole
    try:
        yield driver
    finally:
        driver.quit()
