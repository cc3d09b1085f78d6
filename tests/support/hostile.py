"""An arm whose names mean something to whatever reads them, and every page about it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

import freebody as fb

JOINTS = [
    "θ1",
    "关节",
    "left/joint1",
    "=cmd|' /C calc'!A0",
    "<script>alert(1)</script>",
    '"]]></script>\u202e',
]
LINKS = [
    "base",
    "@SUM(1)",
    "<img src=x onerror=alert(1)>",
    "]]>\u000b",
    "关\u2067节",
    "-1;=2",
    "'+3",
]


def hostile() -> fb.Model:
    """An arm whose names mean something to whatever reads them."""
    rows = [
        f"name = {json.dumps('<script>alert(2)</script>')}\nsource = "
        f"{json.dumps('=1+1 & </style>')}"
    ]
    rows += [
        f"[[link]]\nname = {json.dumps(name)}\nmass = 1\ncom = [0.1, 0, 0]\ninertia = [0.1, 0, 0, "
        f"0.1, 0, 0.1]"
        for name in LINKS
    ]
    for name, parent, child in zip(JOINTS, LINKS, LINKS[1:], strict=False):
        ends = f"parent = {json.dumps(parent)}\nchild = {json.dumps(child)}"
        rows.append(
            f'[[joint]]\nname = {json.dumps(name)}\nkind = "revolute"\n{ends}\n'
            'origin = [0.2, 0, 0]\naxis = "y"'
        )
    Path("hostile.toml").write_text("\n".join(rows), encoding="utf-8")
    return fb.load("hostile.toml")


def hostile_study(tmp_path_factory: pytest.TempPathFactory) -> fb.Study:
    """Its study, read from a file in a folder of its own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(tmp_path_factory.mktemp("hostile"))
        return fb.study(hostile())


SPECIAL = r"\_%#&${}~^<>|\"'`*[]" + "\u202e\x1b\n"
NAMES = (
    "θ1",
    "left/joint1",
    "n" * 40,
    "<b>",
    "关节",
    "a_1",
    "50%_of#1&co$",
    r"\input{x}",
    "x^2~y",
    "}",
    "`*_[]|",
    SPECIAL,
)
"""What parts of a robot may be called in a file."""


def balanced(document: str) -> bool:
    """Whether every brace that groups is closed."""
    depth = 0
    for brace in re.findall(r"(?<!\\)(?:\\\\)*([{}])", re.sub(r"\\[{}]", "", document)):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    return depth == 0
