"""Reading URDF elements one by one: numbers, texts, and the account of everything that is not
read."""

from __future__ import annotations

from collections import Counter
from itertools import islice
from typing import NoReturn

from freebody.errors import FileError, shown
from freebody.formats import number_text
from freebody.formats.xml import Element
from freebody.model.description import Notice

_SHAPES = ("visual", "collision", "material")
_MOST_KINDS = 100
"""Of elements and attributes that are not read and yet named one by one."""


def xacro(name: str, stem: str) -> str:
    """How to expand a file of that name, with ROS and without."""
    return (
        f"expand it first, with `xacro {name} -o {stem}.urdf`; without ROS, `pip install xacro` "
        f"has this command, and each $(find PACKAGE) in the file is to be replaced by that "
        f"package's folder"
    )


class Elements:
    """A file being read: values of its elements, refusals with its name and line, and notices about
    it."""

    def __init__(self, file: str, snap: float):
        self.file, self.snap = file, snap
        self.notices: list[Notice] = []
        self.shapes: Counter[str] = Counter()
        self.ignored: dict[str, list[int]] = {}
        self.remarks: dict[str, str] = {}
        self.unknown: dict[str, list[int]] = {}
        self.changes: list[float] = []

    # ------------------------------------------------------------ values
    def text(self, element: Element, key: str, where: str) -> str:
        value = element.attributes.get(key, "").strip()
        if not value:
            self.refuse(element, f'{where}: <{element.tag}> has no {key}; add {key}="...".')
        return value

    def number(
        self,
        element: Element,
        key: str,
        where: str,
        default: float | None = None,
        infinite: bool = False,
    ) -> float:
        """A number; infinity only where asked for."""
        if key not in element.attributes and default is not None:
            return default
        return self.read(element, key, self.text(element, key, where), where, infinite)

    def vector(self, element: Element, key: str, where: str) -> tuple[float, float, float]:
        """Three numbers, zeros where the attribute is absent."""
        words = element.attributes.get(key, "0 0 0").split()
        if len(words) != 3:
            self.refuse(
                element,
                f"{where}: {key}={shown(' '.join(words))} has {len(words)} entries, expected 3 "
                f"numbers.",
            )
        x, y, z = (self.read(element, key, word, where) for word in words)
        return x, y, z

    def read(
        self, element: Element, key: str, word: str, where: str, infinite: bool = False
    ) -> float:
        value = number_text.number(word)
        problem = None if value is None else number_text.fault(value, infinite)
        if value is None or problem == number_text.NOT_FINITE:
            hint = f"; it is a xacro expression: {xacro('FILE', 'out')}" if "${" in word else ""
            kind = "number" if infinite else "finite number"
            self.refuse(
                element,
                f"{where}: {key} of <{element.tag}> is {shown(word)}, expected a {kind}{hint}.",
            )
        if problem:
            self.refuse(element, f"{where}: {key} of <{element.tag}> is {value:g}, {problem}.")
        return value

    # ------------------------------------------------------------ what is not used
    def only(self, element: Element, *known: str, owner: str | None = None) -> None:
        """Count the attributes that are not read."""
        for key in element.attributes:
            if key not in known and not key.startswith("xmlns"):
                self.count(f"attribute {key} of {owner or f'<{element.tag}>'}", element.line)

    def sort_out(self, element: Element, *known: str, owner: str | None = None) -> None:
        """Count the elements inside that are not read."""
        for child in element.children:
            if child.tag in _SHAPES:
                self.shapes[child.tag] += 1
            elif child.tag not in known:
                self.count(f"<{child.tag}> in {owner or f'<{element.tag}>'}", child.line)

    def count(self, what: str, line: int) -> None:
        self.ignored.setdefault(what, [0, line])[0] += 1

    def one(self, element: Element, tag: str, where: str) -> Element | None:
        """The only element of that tag inside, or None."""
        found = element.all(tag)
        if len(found) > 1:
            self.refuse(found[1], f"{where}: there are {len(found)} <{tag}>; keep one.")
        return found[0] if found else None

    def summary(self) -> list[Notice]:
        """Notices on the whole file: snapped angles, shapes, ignored elements and attributes."""
        notices = []
        if self.changes:
            text = (
                f"{len(self.changes)} angles within {self.snap:g} rad of a multiple of a right "
                f"angle are read as that multiple; largest change {max(self.changes):.2g} rad. "
                f"snap_angles=0 reads them as written."
            )
            notices.append(Notice("snapped", text, self.file))
        if self.shapes:
            listed = ", ".join(f"{n} <{tag}>" for tag, n in sorted(self.shapes.items()))
            notices.append(
                Notice(
                    "skipped",
                    f"shapes play no part in the dynamics: {listed} are not read.",
                    self.file,
                )
            )
        for key, (n, line) in self.unknown.items():
            text = f"{key} limits of 0 are read as no limit ({_times(n)})."
            notices.append(Notice("limits", text, self.file, line))
        if len(self.ignored) > _MOST_KINDS:
            text = (
                f"{len(self.ignored) - _MOST_KINDS} further kinds of elements and attributes "
                "are ignored."
            )
            notices.append(Notice("ignored", text, self.file))
        for what, (n, line) in islice(self.ignored.items(), _MOST_KINDS):
            notices.append(
                Notice(
                    "ignored",
                    f"{what} is ignored ({_times(n)}){self.remarks.get(what, '')}.",
                    self.file,
                    line,
                )
            )
        return notices

    def notice(self, kind: str, element: Element, text: str) -> None:
        self.notices.append(Notice(kind, text, self.file, element.line))

    def refuse(self, element: Element, problem: str) -> NoReturn:
        raise FileError(self.file, element.line, problem)


def _times(n: int) -> str:
    return "once" if n == 1 else f"{n} times, first here"
