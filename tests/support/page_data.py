"""The data that a page which can be tried brings for its script, as the browser inflates it."""

from __future__ import annotations

import json
import re
import zlib
from base64 import b64decode
from typing import Any


def page_data(html: str) -> dict[str, Any]:
    """Inputs, lines, words and whatever else the script reads by name."""
    found = re.search(r'inflated\("([^"]*)"\)\.json', html)
    assert found, "this page has no data"
    return json.loads(zlib.decompress(b64decode(found[1])))
