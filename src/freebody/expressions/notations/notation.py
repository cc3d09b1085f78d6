"""A notation: which letters stand for what, from where angles are measured, and which parameters
are given by formulas. The presets are TOML files beside this one, and so are a user's own."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib import resources
from os import PathLike, fspath
from pathlib import Path

from freebody.errors import FreebodyError, UnknownNameError, listed, shown
from freebody.expressions.grammar.words import spelt
from freebody.expressions.quantities.kinds import (
    BIAS,
    CORIOLIS,
    GRAVITY,
    LETTERED,
    USUAL_LETTERS,
    VELOCITY,
)
from freebody.formats import read_file
from freebody.formats.toml_table import TomlTable, table_of
from freebody.model.bodies import Body
from freebody.model.model import Model
from freebody.values import ByValue

PRESETS = (
    "notes", "craig", "spong", "siciliano", "murray-li-sastry", "lynch-park", "featherstone",
)  # fmt: skip
"""Names of the notations that come with freebody, each a file."""

TERMS = ("coefficients", "vector", "matrix", "bias")
"""Forms of the terms of torques without accelerations: by coefficients h of products of rates, a
vector of velocity terms, the matrix C times the rates, or a vector with gravity in it."""

_PRINTED = {
    "vector": (VELOCITY, GRAVITY), "matrix": (CORIOLIS, GRAVITY), "bias": (BIAS,),
}  # fmt: skip
_KEYS = {kind.key: kind for kind in LETTERED}

ZEROS = {"x axis": 0, "down": -1, "up": 1}
"""The direction in which angles are 0, and by how many right angles it is turned from x."""

LARGEST_FILE = 100_000


Weights = tuple[tuple[int, ...], ...]
"""A matrix of whole numbers."""


@dataclass(frozen=True, eq=False)
class BookNotation(ByValue):
    """A course's or book's notation: letters, names, angles and parameters."""

    name: str
    title: str = ""
    source: str = ""
    absolute: bool = False
    """Whether angles are those of the links themselves, all from one direction."""
    zero: str = "x axis"
    """The direction in which angles are 0, a key of `ZEROS`."""
    names: Mapping[str, str] = field(default_factory=dict[str, str])
    """Names and what they stand for: {"a": "l"} for all that are numbered, {"C": "cos"}."""
    parameters: Mapping[str, str | float] = field(default_factory=dict[str, str | float])
    """Parameters given by formulas, {"lc": "l/2"} for all links or {"lc1": "l1/2"}."""
    letters: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])
    """Letters of quantities by the names of kinds; what is not given has the usual ones."""

    terms: str = "coefficients"
    """The form in which terms are printed, one of `TERMS`."""

    def __post_init__(self) -> None:
        """Refuse letters that cannot be both printed and read."""
        for letter in (letter for letters in self.letters.values() for letter in letters):
            if not (letter.isalpha() and spelt(letter)):
                raise FreebodyError(
                    f"the notation {self.name!r}: {shown(letter)} is not a letter; write Latin "
                    "letters, or a Greek one by its name."
                )
        plain = {family: tuple(map(spelt, letters)) for family, letters in self.letters.items()}
        object.__setattr__(self, "letters", plain)

    @property
    def all_letters(self) -> Mapping[str, tuple[str, ...]]:
        """The letters of every kind of quantity; a letter assigned to one kind is removed from the
        others."""
        taken = {letter for letters in self.letters.values() for letter in letters}
        usual = {
            family: tuple(letter for letter in letters if letter not in taken)
            for family, letters in USUAL_LETTERS.items()
        }
        return {**usual, **self.letters}

    @property
    def printed_kinds(self) -> tuple[str, ...]:
        """The kinds whose letters this notation prints for terms without accelerations."""
        own = _PRINTED.get(self.terms, ())
        return tuple(kind.name for kind in own if kind.name in self.letters)

    @property
    def quarter_turns(self) -> int:
        """The number of right angles by which the zero direction of angles is turned from the x
        axis."""
        return ZEROS[self.zero]


def read(file: str, text: str, name: str = "") -> BookNotation:
    """The notation in a TOML text; raises FileError with the line."""
    top = table_of(file, text)
    top.only("title", "source", "angles", "zero", "names", "parameters", "letters", "terms")
    letters: dict[str, tuple[str, ...]] = {}
    if "letters" in top:
        table = _part(top, "letters").only(*_KEYS)
        given: dict[str, str] = {}
        for key in table.data:
            letters[_KEYS[key].name] = tuple(table.text(key).split())
            for letter in letters[_KEYS[key].name]:
                if given.setdefault(letter, key) != key:
                    table.refuse(f"{letter} stands for {given[letter]} and {key}.", key)
    return BookNotation(
        name or Path(file).stem,
        top.text("title", name or Path(file).stem),
        top.text("source", ""),
        top.choice("angles", ("relative", "absolute"), "relative") == "absolute",
        top.choice("zero", tuple(ZEROS), "x axis"),
        _texts(top, "names"),
        _texts(top, "parameters"),
        letters,
        top.choice("terms", TERMS, "vector" if "c" in letters else "coefficients"),
    )


def _part(top: TomlTable, key: str) -> TomlTable:
    found = top.data[key]
    if not isinstance(found, dict):
        top.refuse(f"{key} is a table, [{key}].", key)
    return TomlTable(top.file, top.lines, (*top.path, key), found, f"[{key}]")


def _texts(top: TomlTable, key: str) -> Mapping[str, str]:
    if key not in top:
        return {}
    table = _part(top, key)
    return {name: table.text(name) for name in table.data}


@lru_cache(maxsize=32)
def preset(name: str) -> BookNotation:
    """The bundled notation of that name; raises UnknownNameError."""
    if name not in PRESETS:
        raise UnknownNameError("notation", name, "the notations", PRESETS)
    folder = resources.files("freebody.expressions.notations")
    file = f"{name.replace('-', '_')}.toml"
    return read(file, folder.joinpath(file).read_text(encoding="utf-8"), name)


def notation_of(
    given: str | PathLike[str] | BookNotation | None,
    parameters: Mapping[str, str | float] | None = None,
) -> BookNotation:
    """A notation by name, from a user's file, or as given; None for that of the notes. parameters:
    further parameters that are given by formulas or numbers."""
    is_dict = isinstance(parameters, Mapping) and all(isinstance(x, str) for x in parameters)
    if parameters is not None and not is_dict:
        raise FreebodyError(
            f"parameters: {shown(parameters)} is no dict of names with formulas, "
            'such as {"lc": "l/2"}.'
        )
    if parameters:
        style = notation_of(given)
        return replace(style, parameters={**style.parameters, **parameters})
    if given is None:
        return preset("notes")
    if isinstance(given, BookNotation):
        return given
    if not isinstance(given, str | PathLike):
        raise FreebodyError(
            f"notation: {shown(given)} is none; give one of {listed(PRESETS)}, or a file's path."
        )
    path = fspath(given)
    if isinstance(given, str) and not path.endswith(".toml"):
        return preset(path)
    data = read_file.read(path, LARGEST_FILE, "a notation")
    return read(path, read_file.decoded(path, data))


def angles_of(
    caller: str, notation: BookNotation, model: Model, absolute: bool = False
) -> tuple[Weights | None, tuple[int, ...]]:
    """(B, turns) with θ = B φ between the model's coordinates θ and the notation's φ, B None where
    they are equal; turns: right angles by which each φ has another zero, or ().

    Raises FreebodyError for robots whose angles are not written so.
    """
    turned = turned_by(caller, model) if absolute or notation.absolute else None
    if not notation.quarter_turns:
        return turned, ()
    first = [not any(row[:i]) for i, row in enumerate(turned_by(caller, model))]
    return turned, tuple(
        notation.quarter_turns * _sense(body) * int(alone or turned is not None)
        for body, alone in zip(model.bodies, first, strict=True)
    )


def turned_by(caller: str, model: Model) -> Weights:
    """The matrix B of θ = B φ for absolute angles φ of a planar tree: each joint's angle is that of
    its body minus that of the body before, each counted in the sense of its own joint."""
    if model.dim != 2:
        raise FreebodyError(
            f"{caller}: absolute angles belong to robots in the plane; {model.name!r} is in space."
        )
    rows: list[list[int]] = []
    for i, body in enumerate(model.bodies):
        row = [int(i == k) for k in range(len(model.bodies))]
        above = body.parent
        while above >= 0 and not model.bodies[above].kind.turns:
            above = model.bodies[above].parent
        if body.kind.turns and above >= 0:
            row[above] = -_sense(body) * _sense(model.bodies[above])
        if body.joint.mimic is not None or (caller != "check" and _sense(body) < 0):
            raise FreebodyError(
                f"{caller}: absolute angles are not written where a joint follows another or turns "
                f"clockwise, as {body.joint.name!r} of {model.name!r} does."
            )
        rows.append(row)
    return tuple(map(tuple, rows))


def _sense(body: Body) -> int:
    """Sense of a turn: 1 of a body that turns anticlockwise, -1 clockwise, 0 of one that does not
    turn."""
    return int(body.kind.turns and math.copysign(1, body.joint.axis[0]))
