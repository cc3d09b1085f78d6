"""The data and script that a page which can be tried brings, as the browser inflates them."""

from __future__ import annotations

import json
import re
import zlib
from base64 import b64decode
from typing import Any


def page_script(html: str) -> str:
    """The script that the page runs, which its policy names."""
    found = re.search(r'inflated\("([^"]*)"\)\.text', html)
    assert found, "this page has no script"
    return zlib.decompress(b64decode(found[1])).decode()


def page_data(html: str) -> dict[str, Any]:
    """Inputs, lines, words and whatever else the script reads by name."""
    found = re.search(r'inflated\("([^"]*)"\)\.json', html)
    assert found, "this page has no data"
    return json.loads(zlib.decompress(b64decode(found[1])))


def page_scene(html: str) -> dict[str, Any]:
    """The scene that a studio's page draws."""
    for pack in re.findall(r'"(eN[A-Za-z0-9+/=]{40,})"', html):
        found = json.loads(zlib.decompress(b64decode(pack)))
        if isinstance(found, dict) and "scene" in found:
            return found["scene"]
    raise AssertionError("this page has no scene")
