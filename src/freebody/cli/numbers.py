"""Numbers, and pairs of a name and a meaning, in the texts of options and arguments."""

from __future__ import annotations

import math
import re
from typing import Any

import typer

from freebody.errors import FreebodyError, shown


def number(text: str | float) -> float:
    """An option's number; the parser's own would also take 1_0 and digits of other scripts."""
    from freebody.formats import read_file

    value = read_file.number(text) if isinstance(text, str) else text
    if value is None or read_file.fault(value):
        raise typer.BadParameter(f"{shown(text)} is not a number that can be used.")
    return value


def option(words: str) -> Any:
    """An option that is one number."""
    return typer.Option(metavar="VALUE", parser=number, help=words)


def values(what: str, text: str) -> list[float]:
    """Numbers apart by commas or blanks; a number with "deg" is an angle in degrees."""
    from freebody.formats import read_file

    found = []
    for piece in re.sub(r" ?(deg|°)", r"deg", " ".join(text.split())).replace(",", " ").split():
        value = read_file.number(piece.removesuffix("deg"))
        if value is None or read_file.fault(value):
            raise FreebodyError(
                f"{what} {shown(text)}: {shown(piece)} is not a number that can be used; "
                f'write for example {what} "0.5, 30 deg".'
            )
        found.append(math.radians(value) if piece.endswith("deg") else value)
    return found


def one(what: str, text: str) -> float:
    """The only number in a text, an angle in radians."""
    found = values(what, text)
    if len(found) != 1:
        raise FreebodyError(f"{what} {shown(text)}: write one number, such as 0.02 or 30 deg.")
    return found[0]


def by_commas(text: str) -> list[float] | None:
    """Numbers apart by commas; None where one cannot be used."""
    from freebody.formats import read_file

    found = [read_file.number(piece.strip()) for piece in text.split(",")]
    usable = [x for x in found if x is not None and not read_file.fault(x)]
    return usable if len(usable) == len(found) else None


def pairs(option: str, texts: list[str] | None, example: str, equals: str = "=") -> dict[str, str]:
    """Names and values from options of the form name=value; a name that is given twice is
    refused."""
    found: dict[str, str] = {}
    for text in texts or ():
        name, sign, meaning = text.partition(equals)
        if not (name.strip() and sign and meaning.strip()):
            raise FreebodyError(
                f"{option} {text}: write a name, {equals}, and what it stands for, such as "
                f"{example}."
            )
        if name.strip() in found:
            raise FreebodyError(f"{option}: {name.strip()!r} is given twice; give it once.")
        found[name.strip()] = meaning.strip()
    return found
