"""Numbers of equations as a text cites them: (3.20)-(3.28), runs drawn together."""

from __future__ import annotations

from collections.abc import Sequence


def cited(numbers: Sequence[str]) -> str:
    """`("3.16", "3.17", "4.1")` as (3.16), (3.17), (4.1); three and more in a row as a range."""
    runs: list[list[str]] = []
    for number in sorted(dict.fromkeys(numbers), key=_place):
        if runs and _place(number) == _next(runs[-1][-1]):
            runs[-1].append(number)
        else:
            runs.append([number])
    return ", ".join(part for run in runs for part in _run(run))


def _run(run: list[str]) -> list[str]:
    if len(run) < 3:
        return [f"({number})" for number in run]
    return [f"({run[0]})–({run[-1]})"]


def _place(number: str) -> tuple[int, ...]:
    return tuple(map(int, number.split(".")))


def _next(number: str) -> tuple[int, ...]:
    *chapter, last = _place(number)
    return (*chapter, last + 1)
