"""Exceptions that compose their own message: what was given, what was expected, what to write instead."""

from __future__ import annotations

import difflib
from collections.abc import Iterable
from pathlib import Path
from typing import Any


class FreebodyError(Exception):
    """Whatever freebody refuses. The message is one paragraph meant for a person."""

    def __reduce__(self) -> tuple[Any, ...]:
        # an exception is rebuilt from `args`, here the message, which is not what the classes below are made of; one
        # that cannot be rebuilt blocks the process pool that it was raised in
        return _rebuilt, (type(self), self.args, self.__dict__)


class FreebodyWarning(UserWarning):
    """Doubtful input that is used as given."""


class PhysicalWarning(FreebodyWarning):
    """An inertia that no rigid body can have."""


class ShapeError(FreebodyError, ValueError):
    """An array of the wrong shape."""

    def __init__(
        self, function: str, argument: str, given: tuple[int, ...], expected: str, because: str = ""
    ):
        super().__init__(
            f"{function}: {argument} has shape {given}, expected {expected}{': ' + because if because else ''}."
        )


class NotFiniteError(FreebodyError, ValueError):
    """NaN or infinity where a number is needed."""

    def __init__(self, function: str, argument: str, value: float, where: str):
        super().__init__(f"{function}: {argument} is {value} {where}; every entry must be a finite number.")


class UnknownNameError(FreebodyError, KeyError):
    """A name that does not exist, with the nearest that does and the list of all."""

    def __init__(self, what: str, name: object, owner: str, names: Iterable[str]):
        known = list(names)
        near = difflib.get_close_matches(str(name), known, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        plural = f"{what[:-1]}ies" if what.endswith("y") and what[-2:-1] not in "aeou" else f"{what}s"
        listed = f" {plural[0].upper()}{plural[1:]}: {_listing(known)}." if known else f" It has no {plural}."
        super().__init__(f"no {what} {name!r} in {owner}.{hint}{listed}")

    def __str__(self) -> str:  # KeyError would print the repr
        return self.args[0]


class MissingValueError(FreebodyError, ValueError):
    """Numbers were asked of a model that still has parameters without value."""

    def __init__(self, owner: str, names: Iterable[str]):
        missing = sorted(set(names))
        example = ", ".join(f"{name}=..." for name in missing[:3])
        super().__init__(
            f"{owner}: numbers need a value for {_listing(missing)}. Give them with model.bind({example})."
        )


class ModelError(FreebodyError, ValueError):
    """A mechanism that cannot be: names the body or joint and the remedy."""


class SingularError(FreebodyError, ArithmeticError):
    """A system of equations without a unique solution; says which body, joint or direction is to blame."""


class LoopError(FreebodyError, ValueError):
    """A closed chain that does not close, or would not stay closed; names the loop and the gap."""


class PassiveJointError(FreebodyError, ValueError):
    """A torque at a joint that nothing drives; names the joint."""


class FileError(FreebodyError, ValueError):
    """Something in a file, with the file and, where known, the line."""

    def __init__(self, path: str | Path, line: int | None, problem: str):
        self.path, self.line, self.problem = str(path), line, problem
        place = f"{path}:{line}" if line else f"{path}"
        super().__init__(f"{place}: {problem}")


def _rebuilt(
    kind: type[FreebodyError], args: tuple[object, ...], attributes: dict[str, Any]
) -> FreebodyError:
    """The exception that another process sent."""
    error = kind.__new__(kind, *args)
    error.__dict__.update(attributes)
    return error


def _listing(names: list[str], most: int = 24) -> str:
    """`a, b, c`, cut after `most` names."""
    shown = ", ".join(names[:most])
    return f"{shown}, … ({len(names)} in all)" if len(names) > most else shown
