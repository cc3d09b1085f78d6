"""Exceptions that compose their own message: what was given, what was expected, what to write
instead."""

from __future__ import annotations

import difflib
import itertools
import re
import reprlib
import sys
import warnings
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple


def likely(name: str, known: Iterable[str], most: int = 1) -> list[str]:
    """Known names that a wrong one may be meant for, the likeliest first; none rather than an
    absurd one.

    They differ in capitals or underscores, in their number (link3), in what is left out behind
    (ur5), or, from three letters on, in one letter of three.
    """
    if len(name) > _LONG:
        return []
    names = [x for x in known if x != name and len(x) <= _LONG]
    same = [x for x in names if _bare(x) == _bare(name)]
    numbered = [x for x in names if _DIGITS.sub("", x) == _DIGITS.sub("", name) != ""]
    close = difflib.get_close_matches(name, names, n=8, cutoff=0.6)
    spelt = [x for x in close if min(len(x), len(name)) >= 3 and _is_misspelt(name, x)]
    rest = sorted((*numbered, *spelt), key=lambda x: _apart(x, name))
    return list(dict.fromkeys((*same, *rest)))[:most]


def did_you_mean(near: Sequence[str]) -> str:
    """The question, in the middle of a sentence, whether the likeliest of some names was meant;
    nothing of none."""
    return f"did you mean {near[0]!r}?" if near else ""


def capitalised(text: str) -> str:
    """A text that begins a sentence: its first letter is a capital, the others are as they were."""
    return f"{text[:1].upper()}{text[1:]}"


_LONG, _MOST = 80, 2000
"""Letters of a name or value, and of a file's own text, that a message shows in full; a longer name
is compared with no other."""
_DIGITS = re.compile(r"[0-9]+")


def _apart(a: str, b: str) -> tuple[float, int]:
    """The distance of two names: by their letters, then by the numbers in them."""
    numbers = zip(*([int(x) for x in _DIGITS.findall(name)] for name in (a, b)), strict=False)
    return -difflib.SequenceMatcher(None, a, b).ratio(), sum(abs(x - y) for x, y in numbers)


def _bare(name: str) -> str:
    """A name in lower case without spaces, hyphens and underscores, for comparison."""
    return re.sub(r"[_\s-]", "", name).casefold()


def _is_misspelt(a: str, b: str) -> bool:
    """Whether one name begins with the other, or few letters are wrong, missing, too many or
    swapped."""
    a, b = a.casefold(), b.casefold()
    return a.startswith(b) or b.startswith(a) or _distance(a, b) <= (max(len(a), len(b)) + 1) // 3


def _distance(a: str, b: str) -> int:
    """The number of letters to change, leave out, insert, or swap with a neighbour between two
    names (Damerau and Levenshtein)."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a, 1):
        before, last, row = row, before, [i]
        for j, y in enumerate(b, 1):
            cost = min(before[j] + 1, row[j - 1] + 1, before[j - 1] + (x != y))
            if i > 1 and j > 1 and x == b[j - 2] and a[i - 2] == y:
                cost = min(cost, last[j - 2] + 1)
            row.append(cost)
    return row[-1]


class FreebodyError(Exception):
    """The base class of freebody's errors. The message is one paragraph, written for people."""

    def __reduce__(self) -> tuple[Any, ...]:
        # an exception is rebuilt from `args`, here the message, which is not what the classes below
        # are made of; one that cannot be rebuilt blocks the process pool that it was raised in
        return _rebuilt, (type(self), self.args, self.__dict__)


class FreebodyWarning(UserWarning):
    """The input is doubtful, and used as given."""


class PhysicalWarning(FreebodyWarning):
    """A physically impossible inertia."""


class MassWarning(FreebodyWarning):
    """Masses in a file that cannot be the robot's: missing, placeholders, implausible."""


def warn(text: str, category: type[FreebodyWarning] = FreebodyWarning) -> None:
    """Warn at the line of the user's code that called freebody, however deep in freebody the doubt
    arises."""
    frame, level = sys._getframe(1), 2
    while frame is not None and frame.f_globals.get("__name__", "").partition(".")[0] == _OWN:
        frame, level = frame.f_back, level + 1
    warnings.warn(text, category, stacklevel=level)


_OWN = __name__.partition(".")[0]


class ShapeError(FreebodyError, ValueError):
    """An array of the wrong shape."""

    def __init__(
        self, function: str, argument: str, given: tuple[int, ...], expected: str, because: str = ""
    ):
        super().__init__(
            f"{function}: {argument} has shape {given}, expected "
            f"{expected}{': ' + because if because else ''}."
        )


class KindError(FreebodyError, TypeError):
    """An argument of the wrong kind, such as a name where a model is needed."""

    def __init__(
        self, function: str, argument: str, given: object, expected: str, advice: str = ""
    ):
        what = "None" if given is None else f"{type(given).__name__} {shown(given)}"
        super().__init__(
            f"{function}: {argument} is {what}, expected {expected}.{' ' if advice else ''}{advice}"
        )


def require_kind(
    function: str, argument: str, given: object, kinds: type | tuple[type, ...], expected: str
) -> None:
    """Raise KindError for an argument that is none of some kinds; a class is an instance of
    none."""
    if not isinstance(given, kinds):
        raise KindError(function, argument, given, expected)


class NotFiniteError(FreebodyError, ValueError):
    """NaN or infinity where a number is needed."""

    def __init__(self, function: str, argument: str, value: float, where: str):
        super().__init__(
            f"{function}: {argument} is {value} {where}; every entry must be a finite number."
        )


class UnknownNameError(FreebodyError, KeyError):
    """A name that does not exist, with the nearest that does and the list of all."""

    def __init__(self, what: str, name: object, owner: str, names: Iterable[str]):
        known = sorted(names, key=lambda known: "." in known)  # l1 before joint1.friction.viscous
        hint = capitalised(did_you_mean(likely(str(name), known)))
        plural = what if what.endswith("s") else f"{what}s"
        if what.endswith("y") and what[-2:-1] not in "aeou":
            plural = f"{what[:-1]}ies"
        elif what.endswith("is"):  # axis
            plural = f"{what[:-2]}es"
        listed = f"{capitalised(plural)}: {_listing(known)}." if known else f"It has no {plural}."
        said = f"no {what} {shown(name)} in {owner}."
        super().__init__(" ".join(part for part in (said, hint, listed) if part))

    def __str__(self) -> str:  # KeyError would print the repr
        return self.args[0]


class MissingValueError(FreebodyError, ValueError):
    """Numbers were asked of a model that still has parameters without value."""

    def __init__(self, owner: str, names: Iterable[str]):
        missing = sorted(set(names))
        example = ", ".join(f"{name}=..." for name in missing[:3])
        super().__init__(
            f"{owner}: numbers need a value for {_listing(missing)}. Give them with "
            f"model.bind({example}), or below [parameters] in a TOML file."
        )


class MissingArgumentError(FreebodyError):
    """Raised where none of some arguments was given, one of which is needed; the command line words
    it with its options."""

    def __init__(self, problem: str, names: Iterable[str], remark: str = ""):
        self.problem, self.names, self.remark = problem, tuple(names), remark
        super().__init__(self.worded([f"{name}=" for name in self.names]))

    def worded(self, names: Iterable[str]) -> str:
        """The error's message, with the given names in place of the arguments' own."""
        known = list(names)
        either = " or ".join(part for part in (", ".join(known[:-1]), *known[-1:]) if part)
        return f"{self.problem}; give {either}{self.remark}."


class MissingPackageError(FreebodyError, ImportError):
    """Something whose package is not installed: that of an extra, or one that comes with
    freebody."""

    def __init__(self, what: str, package: str, extra: str = ""):
        remedy = (
            f"pip install 'freebody[{extra}]'"
            if extra
            else "it comes with freebody: pip install --force-reinstall freebody"
        )
        super().__init__(f"{what}: {package} is not installed; {remedy}.")


class ModelError(FreebodyError, ValueError):
    """A mechanism that cannot exist; the message names the body or joint and the remedy."""


class SingularError(FreebodyError, ArithmeticError):
    """A system of equations without a unique solution; the message says which body, joint or
    direction is to blame."""


class LoopError(FreebodyError, ValueError):
    """Loops of a closed chain that are open, or would not stay closed; the message names the loop
    and the gap."""


class PassiveJointError(FreebodyError, ValueError):
    """A torque at a passive joint; the message names the joint."""


class OutOfMemoryError(FreebodyError, MemoryError):
    """A computation that needs more memory than there is; the message says for what, and how much.

    shape: of the array that did not fit, where it was one.
    """

    def __init__(self, problem: str, shape: tuple[int, ...] | None = None):
        self.shape = shape
        super().__init__(problem)


class IncludedLine(NamedTuple):
    """A line of a file that another file includes."""

    file: str
    line: int


class FileError(FreebodyError, ValueError):
    """An error about the content of a file, with the file and, where known, the line."""

    def __init__(self, path: str | Path, line: int | IncludedLine | None, problem: str):
        if isinstance(line, IncludedLine):
            path, line = line
        if len(problem) > _MOST:  # of a file's own text
            problem = f"{problem[: _MOST // 2]} … {problem[-_MOST // 2 :]}"
        self.path, self.line, self.problem = str(path), line, problem
        place = f"{path}:{line}" if line else f"{path}"
        super().__init__(f"{place}: {problem}")


class OutputError(FreebodyError):
    """Some files of a run could not be made or written; the others are there."""

    def __init__(self, folder: str | Path, failed: dict[str, str], written: list[str]):
        self.folder, self.failed, self.written = str(folder), failed, written
        reasons = "; ".join(f"{name}: {why}" for name, why in failed.items())
        rest = f"The other {len(written)} are" if len(written) > 1 else "The other one is"
        super().__init__(f"{folder}: not written: {reasons}.{f' {rest} there.' if written else ''}")


def _rebuilt(
    kind: type[FreebodyError], args: tuple[object, ...], attributes: dict[str, Any]
) -> FreebodyError:
    """The exception that another process raised, rebuilt from its class, arguments and
    attributes."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(attributes)
    return error


def shown(value: object) -> str:
    """The repr of a value that may be of any size or depth, its middle left out where it is
    long."""
    try:
        return _SHOWN.repr(value)
    except ValueError:  # Python prints no integer of more than 4300 digits
        return "an integer of thousands of digits"


_SHOWN = reprlib.Repr()
_SHOWN.maxstring = _SHOWN.maxother = _SHOWN.maxlong = _LONG
_SHOWN.maxlist = _SHOWN.maxtuple = _SHOWN.maxdict = 12


_HELD = {
    "U": "text",
    "T": "text",
    "S": "bytes",
    "c": "complex numbers",
    "M": "dates",
    "m": "spans of time",
    "V": "records",
    "O": "objects",
}
"""Words for what an array holds that is no real number, by NumPy's letter for its kind."""


def no_real_numbers(where: str, array: Any) -> str:
    """The sentence that refuses an array, or another library's, because it does not hold real
    numbers: what it holds, from which entry on, and how to convert what can be."""
    kind = getattr(array.dtype, "kind", "V")
    wrong = _first_unreal(array) if kind in "UTSO" else None
    if wrong is None:
        said = _HELD.get(kind, f"{array.dtype} values")
        change = (
            ".real has their real parts"
            if kind == "c"
            else "convert it with numpy.asarray(…, dtype=float)"
        )
        return f"{where} holds {said}, expected real numbers; {change}."
    index, entry = wrong
    if not index:
        return f"{where} is {shown(entry)}, expected real numbers."
    place = index[0] if len(index) == 1 else index
    return f"{where} holds {shown(entry)} at index {place}, expected real numbers."


def _first_unreal(array: Any) -> tuple[tuple[int, ...], object] | None:
    for index in itertools.product(*map(range, array.shape)):
        entry = array[index].item() if array.dtype.kind != "O" else array[index]
        try:
            float(entry)
        except (TypeError, ValueError, OverflowError):
            return index, entry
    return None


def listed(names: Iterable[str], most: int | None = None) -> str:
    """`a, b and c` in a sentence; of more than `most` the first, and how many more."""
    found = list(names)
    if most is not None and len(found) > most:
        found[most - 1 :] = [f"{len(found) - most + 1} more"]
    return " and ".join(part for part in (", ".join(found[:-1]), *found[-1:]) if part)


def _listing(names: list[str]) -> str:
    """`a, b, c`, cut after 24 names."""
    first = names[:24]
    listed = ", ".join(x if len(x) <= _LONG else f"{x[: _LONG - 1]}…" for x in first)
    return listed if len(first) == len(names) else f"{listed}, … ({len(names)} in all)"
