"""A function over arrays as text: what refuses inputs that are not finite, and long bodies cut into
functions of bounded length, which hand values on in a workspace."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

from freebody.targets.text.statements import ProgramWords, Spelling, Statement, lines, statements
from freebody.targets.text.unit import Unit


@dataclass(frozen=True)
class Piece:
    """Statements of one function; (word, slot) of what it reads from the workspace before and puts
    there after."""

    statements: tuple[Statement, ...]
    loads: tuple[tuple[str, int], ...]
    stores: tuple[tuple[str, int], ...]

    def arguments(self, order: Sequence[str]) -> list[str]:
        """Of the arguments those that it reads or writes."""
        used = {word for statement in self.statements for word in statement.arguments}
        return [word for word in order if word in used]


def cut(statements: Sequence[Statement], longest: int) -> tuple[list[Piece], int]:
    """Pieces of at most about `longest` operations, and how many slots they need; one piece needs
    none."""
    parts = _parts(statements, longest)
    home = {s.word: k for k, part in enumerate(parts) for s in part if not s.writes}
    last = {word: k for k, part in enumerate(parts) for s in part for word in s.reads}
    slot: dict[str, int] = {}
    free: list[int] = []
    slots = 0
    made = []
    for k, part in enumerate(parts):
        read = dict.fromkeys(word for s in part for word in sorted(s.reads) if home[word] < k)
        loads = tuple((word, slot[word]) for word in read)
        free += sorted((slot[word] for word in read if last[word] == k), reverse=True)
        stores = []
        for statement in part:
            if not statement.writes and last.get(statement.word, k) > k:
                if not free:
                    free.append(slots)
                    slots += 1
                slot[statement.word] = free.pop()
                stores.append((statement.word, slot[statement.word]))
        made.append(Piece(tuple(part), loads, tuple(stores)))
    return made, slots


def _parts(statements: Sequence[Statement], longest: int) -> list[Sequence[Statement]]:
    """Runs of about equal weight."""
    total = sum(s.weight for s in statements)
    count = max(1, -(-total // longest))
    bounds, done = [0], 0
    for k, statement in enumerate(statements):
        if done >= total * len(bounds) / count and k > bounds[-1]:
            bounds.append(k)
        done += statement.weight
    return [statements[i:j] for i, j in pairwise([*bounds, len(statements)])]


def body_in_parts(
    unit: Unit,
    words: ProgramWords,
    spelling: Spelling,
    reserved: Collection[str],
    longest: int,
    order: Sequence[str],
    part: Callable[[str, list[str], list[str], int], str],
    call: str,
    workspace: tuple[str, str] | None = None,
    *,
    indent: str = "    ",
    first: int = 0,
) -> tuple[list[str], list[str]]:
    """The functions that a body of more than `longest` operations calls, and the lines of the body.

    order: words of the arguments. part: the text of one of these functions, from its word, the
    arguments that it uses, its lines and the size of the workspace w. call: how it is called, with
    its word and its arguments for {}. workspace: where the body makes it, the line that does, with
    {} for the number of slots, and how it is handed on; first: the number of its first slot.
    """
    pieces, slots = cut(statements(unit, words, spelling, reserved), longest)
    if len(pieces) == 1:
        return [], lines(pieces[0].statements, spelling, indent)
    slots = max(slots, 1)
    declare, assign = (indent + template for template in (spelling.declare, spelling.assign))
    made, body = [], [indent + workspace[0].format(slots)] if workspace else []
    handed = [workspace[1]] if workspace else []
    for k, piece in enumerate(pieces, 1):
        name, used = f"{words.function}_part{k}", piece.arguments(order)
        loads = [declare.format(word=x, text=f"w[{n + first}]") for x, n in piece.loads]
        stores = [assign.format(word=f"w[{n + first}]", text=x) for x, n in piece.stores]
        inner = [*loads, *lines(piece.statements, spelling, indent), *stores]
        made.append(part(name, used, inner, slots))
        body.append(indent + call.format(name, ", ".join([*used, *handed])))
    return made, body


def refusal(
    unit: Unit,
    words: ProgramWords,
    finite: tuple[str, str],
    blank: tuple[str, str],
    around: tuple[str, str, str],
    indent: str = "    ",
) -> list[str]:
    """What answers a call with an input that is not finite; nothing where there is no input.

    finite, blank: of an array and of a scalar, with {word} and {size}, the test of an input and the
    statement that makes an output NaN. around: the lines before, with {} for the tests, and after.
    """
    tests, blanks = (
        [pair[not a.shape].format(word=word, size=a.size) for word, a in zip(*named, strict=True)]
        for pair, named in (
            (finite, (words.inputs, unit.program.inputs)),
            (blank, (words.outputs, unit.program.outputs)),
        )
    )
    opening, refused, end = around
    inner = [indent + text for text in (*blanks, refused)]
    made = [opening.format(" && ".join(tests)), *inner, end]
    return [indent + text for text in made] if tests else []
