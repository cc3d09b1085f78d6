"""A program as statements of an infix language: a value read once is written where it is read;
inputs that are not finite are refused; a long body is cut into functions of bounded length that
pass values on in a workspace."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from freebody.identifiers import identifiers
from freebody.program.program import Argument, Program
from freebody.scalars.operations import ARITY
from freebody.targets.text.language import Section, SourceUnit, sections

_INFIX = {"add": ("{a} + {b}", 1, 1, 2), "sub": ("{a} - {b}", 1, 1, 2), "mul": ("{a}*{b}", 2, 2, 3)}
_INFIX |= {"div": ("{a}/{b}", 2, 2, 3), "neg": ("-{a}", 1, 2, 0)}
"""Template, how tightly it binds, and how tightly its operands must. A sum of a sum keeps its
brackets: rounding."""

_ATOM = 4
_LONGEST = 56
"""Letters up to which a value that is read once is written where it is read."""


@dataclass(frozen=True)
class Spelling:
    """How a language writes scalars and statements.

    functions: template of every operation that is no sum, product, quotient or negation, with {a},
    {b}, {c}. entry, result (word, argument, position): one scalar of an input, of an output, by its
    position in C order. declare, assign: templates of a statement with {word} and {text}. comment:
    template of a line with {text}.
    """

    functions: Mapping[str, str]
    number: Callable[[float], str]
    entry: Callable[[str, Argument, int], str]
    result: Callable[[str, Argument, int], str]
    declare: str
    assign: str
    comment: str
    variable: str = "{word}"
    """How a statement's word is written where it is read: "${word}" in a language that marks its
    variables."""
    inputs_first: bool = False
    """Whether entries of inputs get a word of their own before they are read."""


@dataclass(frozen=True)
class Statement:
    """A statement that assigns the value of `text` to `word`."""

    word: str
    text: str
    reads: frozenset[str]
    """Words of other statements."""
    arguments: frozenset[str]
    """Words of arguments that are read or written."""
    weight: int
    section: str
    writes: bool = False
    """Whether it writes an entry of an output."""


@dataclass(frozen=True)
class ProgramWords:
    """The identifiers in a text for the function, its inputs and its outputs, in order."""

    function: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    @property
    def all(self) -> frozenset[str]:
        """All identifiers that the program uses."""
        return frozenset((self.function, *self.inputs, *self.outputs))


def words_of(unit: SourceUnit, reserved: Collection[str]) -> ProgramWords:
    """Identifiers for a program, all different and none reserved in the language."""
    function = identifiers([unit.name], reserved)[unit.name]
    taken = {*reserved, function}
    inputs = identifiers((a.name for a in unit.program.inputs), taken)
    outputs = identifiers((a.name for a in unit.program.outputs), taken | {*inputs.values()})
    return ProgramWords(function, tuple(inputs.values()), tuple(outputs.values()))


@dataclass(frozen=True)
class _TextValue:
    text: str
    binds: int
    reads: frozenset[str] = frozenset()
    arguments: frozenset[str] = frozenset()
    weight: int = 0

    def within(self, binds: int) -> str:
        return self.text if self.binds >= binds else f"({self.text})"


def statements(
    unit: SourceUnit, words: ProgramWords, spelling: Spelling, reserved: Collection[str]
) -> list[Statement]:
    """The statements of the program, section by section, and last those that write the outputs."""
    return _StatementWriter(unit, words, spelling, reserved).run(
        sections(unit.program, unit.joints)
    )


class _StatementWriter:
    def __init__(
        self, unit: SourceUnit, words: ProgramWords, spelling: Spelling, reserved: Collection[str]
    ):
        program = unit.program
        self.program, self.spelling = program, spelling
        self.taken = {*words.all, *reserved}
        self.entries = _entries(program.inputs, words.inputs, spelling.entry)
        self.results = _entries(program.outputs, words.outputs, spelling.result)
        self.uses = Counter(i for index in range(len(program)) for i in program.operands(index))
        self.marks = {**_result_words(program), **unit.marks}
        self.kept = set(program.results)
        self.section_of: dict[int, str] = {}
        self.reader: dict[int, int] = {}
        self.values: dict[int, _TextValue] = {}
        self.done: list[Statement] = []
        self.count = 0

    def run(self, parts: Sequence[Section]) -> list[Statement]:
        program = self.program
        for part in parts:
            for index in part.nodes:
                self.section_of[index] = part.title
                for operand in program.operands(index):
                    self.reader[operand] = index
        for part in parts:
            for index in part.nodes:
                self.values[index] = self._value(index, part.title)
        for (text, argument), index in zip(self.results, program.results, strict=True):
            value = self.values[index]
            self.done.append(
                Statement(
                    text,
                    value.text,
                    value.reads,
                    value.arguments | {argument},
                    1,
                    "results",
                    writes=True,
                )
            )
        return self.done

    def _value(self, index: int, section: str) -> _TextValue:
        program, op = self.program, self.program.op[index]
        if op == "const":
            number = program.constants[program.a[index]]
            return _TextValue(self.spelling.number(number), _ATOM if number >= 0.0 else 1)
        if op == "input":
            text, argument = self.entries[program.a[index]]
            value = _TextValue(text, _ATOM, arguments=frozenset([argument]))
            # an input that is a result is read before any output is written: the two may be one
            # array
            named = self.spelling.inputs_first or index in self.kept
            return self._named(value, self._input_word(index), section) if named else value
        operands = [self.values[i] for i in program.operands(index)]
        if op in _INFIX:
            template, binds, *needed = _INFIX[op]
        else:
            template, binds, needed = self.spelling.functions[op], _ATOM, [0] * len(operands)
        texts = {k: v.within(n) for k, v, n in zip("abc", operands, needed, strict=False)}
        value = _TextValue(
            template.format(**texts),
            binds,
            frozenset().union(*(v.reads for v in operands)),
            frozenset().union(*(v.arguments for v in operands)),
            1 + sum(v.weight for v in operands),
        )
        return (
            value if self._stays(index, value) else self._named(value, self._word(index), section)
        )

    def _stays(self, index: int, value: _TextValue) -> bool:
        """Whether a value is written where it is read, since it is read once, in the same section,
        and is short."""
        return (
            self.uses[index] == 1
            and index not in self.marks
            and self.program.op[index] in _INFIX
            and len(value.text) <= _LONGEST
            and self.section_of[self.reader[index]] == self.section_of[index]
        )

    def _named(self, value: _TextValue, word: str, section: str) -> _TextValue:
        self.done.append(
            Statement(word, value.text, value.reads, value.arguments, value.weight, section)
        )
        return _TextValue(self.spelling.variable.format(word=word), _ATOM, frozenset([word]))

    def _word(self, index: int) -> str:
        """The identifier of a node's value: sin_q_2 for the sine of an input, its mark in the
        recursion or results, else the next of t1, t2, …"""
        op, operand = self.program.op[index], self.program.a[index]
        if op in ("sin", "cos") and self.program.op[operand] == "input":
            return self._fresh(f"{op}_{self._input_word(operand, fresh=False)}")
        if index in self.marks:
            return self._fresh(self.marks[index])
        self.count += 1
        return self._fresh(f"t{self.count}")

    def _input_word(self, index: int, fresh: bool = True) -> str:
        position, start = self.program.a[index], 0
        for argument in self.program.inputs:
            if position < start + argument.size:
                word = f"{argument.name}_{position - start}" if argument.shape else argument.name
                return self._fresh(word) if fresh else word
            start += argument.size
        raise AssertionError(position)

    def _fresh(self, word: str) -> str:
        while word in self.taken:
            word += "_"
        self.taken.add(word)
        return word


def _result_words(program: Program) -> dict[int, str]:
    """Identifiers such as tau_2 or M_0_1 for nodes that are results, unless these are inputs or
    numbers."""
    indices = [(a, index) for a in program.outputs for index in a.indices()]
    made: dict[int, str] = {}
    for (argument, index), node in zip(indices, program.results, strict=True):
        if ARITY[program.op[node]]:
            made.setdefault(node, "_".join([argument.name, *map(str, index)]))
    return made


def _entries(
    arguments: Sequence[Argument], words: Sequence[str], spell: Callable[[str, Argument, int], str]
) -> list[tuple[str, str]]:
    """For each scalar of the arguments its text and the argument's name."""
    return [
        (spell(word, argument, k), word)
        for argument, word in zip(arguments, words, strict=True)
        for k in range(argument.size)
    ]


def lines(done: Sequence[Statement], spelling: Spelling, indent: str) -> list[str]:
    """Statements as lines, with a comment where a section begins."""
    made, section = [], ""
    for statement in done:
        if statement.section != section:
            section = statement.section
            if section:
                made += ["", indent + spelling.comment.format(text=section)]
        template = spelling.assign if statement.writes else spelling.declare
        made.append(indent + template.format(word=statement.word, text=statement.text))
    return made


@dataclass(frozen=True)
class _Piece:
    """The statements of one function of a cut body, with the (word, slot) pairs that it loads from
    the workspace and stores there."""

    statements: tuple[Statement, ...]
    loads: tuple[tuple[str, int], ...]
    stores: tuple[tuple[str, int], ...]

    def arguments(self, order: Sequence[str]) -> list[str]:
        """The names of arguments, in the given order, that the piece reads or writes."""
        used = {word for statement in self.statements for word in statement.arguments}
        return [word for word in order if word in used]


def _cut(statements: Sequence[Statement], longest: int) -> tuple[list[_Piece], int]:
    """Pieces of about `longest` operations at most, and the number of workspace slots that they
    need; a single piece needs none."""
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
        made.append(_Piece(tuple(part), loads, tuple(stores)))
    return made, slots


def _parts(statements: Sequence[Statement], longest: int) -> list[Sequence[Statement]]:
    """The statements cut into runs of about equal weight."""
    total = sum(s.weight for s in statements)
    count = max(1, -(-total // longest))
    bounds, done = [0], 0
    for k, statement in enumerate(statements):
        if done >= total * len(bounds) / count and k > bounds[-1]:
            bounds.append(k)
        done += statement.weight
    return [statements[i:j] for i, j in pairwise([*bounds, len(statements)])]


def body_in_parts(
    unit: SourceUnit,
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
    """The functions called by a body of more than `longest` operations, and the lines of the body.

    order: words of the arguments. part: the text of one of these functions, from its word, the
    arguments that it uses, its lines and the size of the workspace w. call: how it is called, with
    its word and its arguments for {}. workspace: where the body makes it, the line that does, with
    {} for the number of slots, and how it is handed on; first: the number of its first slot.
    """
    pieces, slots = _cut(statements(unit, words, spelling, reserved), longest)
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
    unit: SourceUnit,
    words: ProgramWords,
    finite: tuple[str, str],
    blank: tuple[str, str],
    around: tuple[str, str, str],
    indent: str = "    ",
) -> list[str]:
    """The statements that answer a call with an input that is not finite; none where there is no
    input.

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
