"""What axe-core finds on pages: opens each in headless Chromium and prints what is serious or
critical; the exit status is 1 if anything is.

    npm install --prefix FOLDER axe-core@4
    python tools/accessible.py FOLDER/node_modules/axe-core/axe.min.js PAGE.html SITE/ ...

Of a folder all pages are judged, the first whole, the others without the frame that they share.
Needs selenium, Chromium and chromedriver. Pages whose policy allows no scripts are judged as well:
the browser's driver puts axe into them.
"""

import shutil
import sys
from collections.abc import Iterable
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.chrome.service import Service

RUN = """
const [whole, done] = arguments;
const judged = (!whole && document.querySelector("article[role=main]")) || document;
axe.run(judged, {resultTypes: ["violations"]}).then(found => done(found.violations));
"""
SERIOUS = ("serious", "critical")
LEFT_TO_BROWSERS = ("scrollable-region-focusable",)
"""Chromium (130) and Firefox give the keyboard's focus to what can be scrolled by themselves; a tab
stop at each of hundreds of equations, most of which fit, would be in the way."""


def browser() -> webdriver.Chrome:
    """A headless Chromium."""
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1280,900"):
        options.add_argument(argument)
    return webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))


def listed(pages: Iterable[str]) -> dict[Path, bool]:
    """The pages, those of folders for them, and whether each is judged whole."""
    judged: dict[Path, bool] = {}
    for page in map(Path, pages):
        if page.is_dir():
            first, *others = sorted(page.rglob("*.html"), key=lambda p: (len(p.parts), p))
            judged |= {first: True} | dict.fromkeys(others, False)
        else:
            judged[page] = True
    return judged


def found(driver: webdriver.Chrome, axe: str, page: Path, whole: bool) -> list[str]:
    """A line for each serious rule that the page breaks, with the first places."""
    driver.get(page.resolve().as_uri())
    driver.execute_script(axe)
    return [
        f"{page}: {rule['impact']}: {rule['id']}: {rule['help']} ({len(rule['nodes'])} places, "
        f"the first: {rule['nodes'][0]['html'][:160]})"
        for rule in driver.execute_async_script(RUN, whole)
        if rule["impact"] in SERIOUS and rule["id"] not in LEFT_TO_BROWSERS
    ]


def main(axe: str, *pages: str) -> int:
    """Judge all pages; 1 if one has a serious fault."""
    script = Path(axe).read_text(encoding="utf-8")
    judged = listed(pages)
    driver = browser()
    try:
        driver.set_script_timeout(120)
        lines = [
            line for page, whole in judged.items() for line in found(driver, script, page, whole)
        ]
    finally:
        driver.quit()
    print("\n".join(lines) or f"{len(judged)} pages: nothing serious")
    return min(len(lines), 1)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
