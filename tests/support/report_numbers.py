"""Compares what a report prints with the data file."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from html.parser import HTMLParser
from pathlib import Path

import xarray as xr

_RAISED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


class Cells(HTMLParser):
    """Number cells of a page, and every address that it names."""

    def __init__(self, page: str):
        super().__init__()
        self.cells, self.addresses, self.ids, self.tags = [], [], [], []
        self.feed(page)

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.tags.append(tag)
        self.addresses += [
            given[k] for k in ("href", "src", "srcset", "action", "data") if k in given
        ]
        self.ids += [given["id"]] if "id" in given else []
        if "data-var" in given:
            self.cells.append({"var": given["data-var"], "at": given["data-at"],
                               "value": given["data-value"],
                               "scale": given.get("data-scale", "1"), "text": ""})  # fmt: skip
        self.inside = tag == "span" and bool(self.cells)

    def handle_data(self, data):
        if getattr(self, "inside", False):
            self.cells[-1]["text"] += data

    def handle_endtag(self, tag):
        self.inside = False


@contextmanager
def data_file(study, folder: Path) -> Iterator[xr.Dataset]:
    """What `save` wrote, read back."""
    study.save(folder)
    with xr.open_dataset(folder / "study.nc", engine="scipy") as data:
        yield data


def compare(cells: Sequence[Mapping[str, str]], data: xr.Dataset) -> list[str]:
    """One line for each cell that differs from the data; cells have text, var, at (JSON), value and
    scale."""
    wrong = []
    for cell in cells:
        at = json.loads(cell["at"])
        array = data[cell["var"]]
        if "time" in at:
            array = array.isel(time=at.pop("time"))
        value = float(array.sel(at))
        same = float(cell["value"]) == value or (
            math.isnan(float(cell["value"])) and math.isnan(value)
        )
        if not same or not _prints(cell["text"], value * float(cell["scale"])):
            wrong.append(f"{cell['var']} {cell['at']}: printed {cell['text']!r}, data {value!r}")
    return wrong


def _prints(text: str, value: float) -> bool:
    """Whether the printed number is the value rounded to the digits that are printed."""
    if text in ("–", "∞", "−∞"):
        return {"–": math.isnan(value), "∞": value == math.inf, "−∞": value == -math.inf}[text]
    mantissa, _, exponent = text.replace("−", "-").partition("·10")
    power = int(exponent.translate(_RAISED)) if exponent else 0
    decimals = len(mantissa.partition(".")[2])
    half = 0.5 * 10.0 ** (power - decimals)
    return abs(float(mantissa) * 10.0**power - value) <= half * (1 + 1e-9)
