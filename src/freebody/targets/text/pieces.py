"""Long text cut into functions of bounded length, which hand values on in a workspace."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from freebody.targets.text.statements import Statement


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
