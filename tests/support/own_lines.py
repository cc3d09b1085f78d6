"""What `fb.check` makes of the lines that a derivation prints."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import accumulate, groupby
from typing import Any

import freebody as fb

MOST = 80
"""Lines given at once: `check` reads a hundred."""
_NUMBER = re.compile(r"[mI]_?\S{1,3} = [\d./]+")
"""A mass that is a number, which other lines are written with."""


@dataclass(frozen=True)
class OwnLine:
    """One line of a derivation. kind: "right", "wrong", "unread", "name" (one that the derivation
    introduces and uses) or "unused"."""

    step: str
    text: str
    kind: str
    reason: str = ""


def own_lines(model: fb.Model, derivation: Any, latex: bool = False) -> list[OwnLine]:
    """All lines, judged together with those of the steps around them."""
    rows = [
        (step.operation, line.latex() if latex else str(line))
        for step in derivation.steps
        for line in step.equations
    ]
    found = []
    for _, piece in groupby(range(len(rows)), lambda k: k // MOST):
        some = [rows[k] for k in piece]
        lines = [text for _, text in some]
        names = [text for _, text in rows if _NUMBER.fullmatch(text)]
        names += [x.text for x in found if x.kind == "name"]
        verdicts = _judged(model, [*lines, *(x for x in names if x not in lines)], latex)
        for (step, text), (kind, reason) in zip(some, verdicts, strict=False):
            found.append(OwnLine(step, text, kind, reason))
    return found


def _judged(model: fb.Model, lines: list[str], latex: bool) -> list[tuple[str, str]]:
    written = [f"\\[{line}\\]" if latex else line for line in lines]
    starts = [1, *accumulate(line.count("\n") + 2 for line in written)]
    try:
        verdict = fb.check(model, "\n\n".join(written), form="latex" if latex else "markdown")
    except fb.FreebodyError as problem:
        return [("unread", str(problem))] * len(lines)
    told = [(x.where, "right" if x.equal else "wrong", x.text) for x in verdict.equations]
    told += [(x.where, "unread", x.reason) for x in verdict.unread]
    found = []
    for line, start, end in zip(lines, starts, starts[1:], strict=False):
        here = [row for row in told if start <= int(re.findall(r"\d+", row[0])[0]) < end]
        kinds = {kind for _, kind, _ in here}
        other = "unused" if any(map(line.startswith, verdict.unchecked)) else "name"
        kind = next((x for x in ("wrong", "unread", "right") if x in kinds), other)
        found.append((kind, next((why for _, x, why in here if x == kind), "")))
    return found
