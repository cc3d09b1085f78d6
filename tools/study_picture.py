"""The README's picture, docs/images/study.png: the first screen of a UR5e's study, as Chromium
shows it.

    python tools/study_picture.py docs/images/study.png

Needs Chromium with its driver, and selenium. Make it anew when the report or its drawings change.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import freebody as fb

WIDTH, HEIGHT = 1120, 842  # of the window
SCALE = 1.6  # pixels of the picture for each of the window's


def picture(page: Path) -> bytes:
    """PNG of the first screen of a page."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service
    from selenium.webdriver.support.ui import WebDriverWait

    options = webdriver.ChromeOptions()
    for argument in ("headless=new", "no-sandbox", "hide-scrollbars"):
        options.add_argument(f"--{argument}")
    browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        size = {"width": WIDTH, "height": HEIGHT, "deviceScaleFactor": SCALE, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        browser.get(page.as_uri())
        WebDriverWait(browser, 20).until(lambda page: page.execute_script("return !!player"))
        return browser.get_screenshot_as_png()
    finally:
        browser.quit()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        report = fb.study(fb.load("ur5e")).to_html(Path(folder) / "report.html")
        Path(sys.argv[1]).write_bytes(picture(report))
