"""The README's picture, docs/images/study.png: parts of the report of a UR5e, as Chromium shows
them.

    python tools/study_picture.py docs/images/study.png

Needs Chromium with its driver, and selenium. Make it anew when the report or its drawings change.
"""

import shutil
import sys
import tempfile
from pathlib import Path

import freebody as fb

WIDTH = 1000  # of the page; the picture has SCALE pixels for each of its
SCALE = 1.776

PARTS = """
const one = (selector) => document.querySelector(selector);
const all = (selector) => [...document.querySelectorAll(selector)];
const row = (elements, columns) => {
  const box = document.createElement("div");
  box.style.cssText = `display:grid;gap:12px;align-items:center;margin:0 0 10px;` +
    `grid-template-columns:${columns}`;
  elements.forEach((element) => { element.style.margin = "0"; box.append(element); });
  return box;
};
const robot = one("#robot figure.hero"), body = all("#bodies figure")[2];
const verdict = one("#verdict"), answer = one("#answer p.verdict"), table = one("#answer .scroll");
all("#robot figcaption, #bodies details").forEach((element) => element.remove());
[robot, verdict, answer, table].forEach((element) => { element.style.maxWidth = "none"; });
table.style.marginTop = "0";
table.querySelector("table").style.width = "100%";
const parts = [
  one("h1"), verdict, answer, row([robot, body], "1.12fr 1fr"), table,
  row(all("#torques figure").slice(0, 3), "1fr 1fr 1fr"),
];
const main = one("main");
document.body.replaceChildren(main);
document.body.style.cssText = "display:block;margin:0;background:white";
main.replaceChildren(...parts);
main.style.cssText = "max-width:none;margin:0;padding:12px 24px 16px";
return Math.ceil(main.getBoundingClientRect().height);
"""


def picture(page: Path) -> bytes:
    """PNG of the parts of a report."""
    from selenium import webdriver
    from selenium.webdriver.chrome.service import Service

    options = webdriver.ChromeOptions()
    for argument in ("headless=new", "no-sandbox", "hide-scrollbars", f"window-size={WIDTH},1200"):
        options.add_argument(f"--{argument}")
    browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
    try:
        browser.get(page.as_uri())
        height = browser.execute_script(PARTS)
        size = {"width": WIDTH, "height": height, "deviceScaleFactor": SCALE, "mobile": False}
        browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        return browser.get_screenshot_as_png()
    finally:
        browser.quit()


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    with tempfile.TemporaryDirectory() as folder:
        report = fb.study(fb.load("ur5e")).to_html(Path(folder) / "report.html")
        Path(sys.argv[1]).write_bytes(picture(report))
