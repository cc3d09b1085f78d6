"""A method of derivation as one record, which the command line, errors, pages and documents
read."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from freebody.scalars.trig import Trig
from freebody_textbook.closed_chains.first_kind import FirstKind
from freebody_textbook.closed_chains.statics import LoopStatics
from freebody_textbook.derivation import Meaning, Step

LOADS = {2: ("fx", "fy"), 3: ("fx", "fy", "fz")}
"""Names of the components of the force on the tip."""


@dataclass(frozen=True)
class Worked:
    """A worked derivation: the steps of a method for a setting, and its results.

    steps: in order. tau: the motors' torques as this method finds them, in the order of the joints;
    none where it finds none. symbols: the meanings of what it introduces. title: where options
    change the method's. sought: a sentence that says what is sought, where it is not the motors'
    torques for a given motion. system: of a closed chain, as polynomials. robot, table: sentences
    about the robot and its axes, and the whole table of symbols, where these are not the usual ones
    of joints and bodies.
    """

    steps: tuple[Step, ...]
    tau: tuple[Trig, ...]
    symbols: Iterable[Meaning]
    title: str = ""
    sought: str = ""
    system: FirstKind | LoopStatics | None = None
    robot: tuple[str, ...] = ()
    table: tuple[Meaning, ...] = ()


@dataclass(frozen=True)
class MethodOption:
    """An option that one method has: its name, its choices, the default first, and what it chooses,
    in words."""

    name: str
    choices: tuple[str, ...]
    words: str


@dataclass(frozen=True)
class Method:
    """A way to the equations of a robot.

    name: what users write, as they may each of the aliases. title: heading of a derivation. words:
    what is done, for lists of the methods. source: where the method is described. work_out: from a
    setting and the options to the steps. reference: the source in full, for the foot of a
    derivation, where it is not the lecture notes. spaces, closed: the numbers of dimensions in
    which it serves open and closed chains; closed_first: whether closed chains are derived by it
    where no method is asked for; elsewhere: the functions that give numbers for closed
    chains which it does not serve. at_rest: whether the robot stands still, and a force acts on the
    tip unless it is left out. absolute: whether it can be told in angles of the links themselves.
    finds_torques: whether it ends in the torques of the motors; forces
    do not occur in one that does not.
    """

    name: str
    title: str
    words: str
    source: str
    work_out: Callable[..., Worked]
    reference: str = ""
    aliases: tuple[str, ...] = ()
    options: tuple[MethodOption, ...] = ()
    spaces: tuple[int, ...] = (2, 3)
    closed: tuple[int, ...] = ()
    closed_first: bool = False
    elsewhere: str = ""
    at_rest: bool = False
    finds_torques: bool = True
    absolute: bool = False
