"""The entries that a program becomes: what is computed once a call, and for every sample."""

from __future__ import annotations

from dataclasses import dataclass, replace

from freebody.program.hoist import hoist
from freebody.program.program import Argument, Program
from freebody.targets.cuda.assembly import ptx
from freebody.targets.cuda.emit import emit
from freebody.targets.cuda.part import Part, part
from freebody.targets.cuda.parts import parts, prepared


@dataclass(frozen=True)
class Plan:
    """Entries by name.

    once: the entry that one thread runs before, on uniform inputs; empty where there are none. It
    writes `shared` numbers, these inputs and what follows from them, which the others take in the
    place of the uniform inputs, behind the other ones. parts: entries for every sample, in any
    order.
    """

    entries: dict[str, Part]
    dtype: str
    once: str
    shared: int

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the entries for every sample."""
        return tuple(name for name in self.entries if name != self.once)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all entries."""
        return tuple(self.entries)

    @property
    def text(self) -> str:
        """All entries as PTX."""
        return ptx(emit(self.entries, self.dtype))


def plan(program: Program, dtype: str) -> Plan:
    """The entries of a program."""
    every, entries, shared = prepared(program), {}, 0
    if any(argument.uniform for argument in program.inputs):
        before, every = hoist(every)
        before = _with_inputs(before)
        shared = before.output_size
        entries["once"] = part(before, range(shared))
    entries |= {f"part{k}": piece for k, piece in enumerate(parts(every, dtype), 1)}
    return Plan(entries, dtype, "once" if shared else "", shared)


def _with_inputs(before: Program) -> Program:
    """The program whose one output begins with its inputs."""
    count, size = len(before), before.input_size
    return replace(
        before,
        outputs=(Argument("shared", (size + before.output_size,)),),
        op=(*before.op, *["input"] * size),
        a=(*before.a, *range(size)),
        b=(*before.b, *[-1] * size),
        c=(*before.c, *[-1] * size),
        results=(*range(count, count + size), *before.results),
    )
