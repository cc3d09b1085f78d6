"""LLVM text of a program as entries that a GPU starts for every sample, with one thread each.

An entry is straight-line code: it reads the sample's inputs, computes, and writes each result when
it is there, so that few values are alive. It takes for each argument of the program an address and
two steps, counted in numbers: from one sample to the next (0: the same for all), and from one entry
of a sample to the next, in C order. So arrays of rows, arrays of columns and what is broadcast are
read where they are.

There is no loop over samples: its counter and what the compiler takes out of it cost up to 30
registers, and a grid has room for 2^31 blocks.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from math import nan

from freebody.program.program import Argument
from freebody.scalars.operations import OPERATIONS
from freebody.targets.cuda.parts import ProgramPart
from freebody.targets.llvm.instructions import (
    CHOICE,
    COMPARISONS,
    FUNCTIONS,
    declarations,
    instructions,
)
from freebody.targets.llvm.lanes import DOUBLE, REALS, Lanes, OneLane
from freebody.targets.llvm.shared_functions import declared_once
from freebody.targets.llvm.sincos import LARGEST, VectorCode, reduction
from freebody.targets.llvm.vector import function

_SINES = ("sin", "cos")

TOGETHER = 256
"""Entries of one argument whose addresses LLVM derives one from another: it compares all pairs of
them, so that all 6144 of a Talos's Jacobian derivatives would take it minutes, where these runs
take seconds."""

_INDEX = """\
  %thread = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()
  %threads = call i32 @llvm.nvvm.read.ptx.sreg.ntid.x()
  %block = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
  %wide.thread = zext i32 %thread to i64
  %wide.threads = zext i32 %threads to i64
  %wide.block = zext i32 %block to i64
  %before = mul i64 %wide.block, %wide.threads
  %i = add i64 %before, %wide.thread
  %there = icmp slt i64 %i, %n
  br i1 %there, label %sample, label %end
sample:"""

_FOOT = """\
attributes #0 = { nounwind noinline }
attributes #2 = { nounwind alwaysinline }
attributes #3 = { nounwind }
declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.ntid.x()
declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()
!0 = !{}
"""


def emit(entries: Mapping[str, ProgramPart], dtype: str) -> str:
    """The LLVM text of a module with entries by name: `void name(ptr a0, i64 step0, i64 core0, …,
    i64 n)`.

    The arguments are the inputs, then the outputs of the part's program, which are the same for all
    parts of one program; n is the number of samples. Of a uniform input, which has no steps, only
    the address is taken.
    """
    lanes = OneLane(REALS[dtype])
    used = {entry.program.op[index] for entry in entries.values() for index in entry.nodes}
    made = [reduction(), _sincos(lanes)] if used.intersection(_SINES) else []
    for name, make in FUNCTIONS.items():
        if name in used:
            made.append(
                function(
                    f"@vector.{name}.{lanes.suffix}", OPERATIONS[name].arity, make, lanes, True
                )
            )
    made += [_Entry(entry, lanes).text(name) for name, entry in entries.items()]
    return declared_once("\n".join([*made, declarations(lanes), _FOOT]))


class _Entry:
    """The LLVM text of one entry in the making, with the names of its values."""

    def __init__(self, piece: ProgramPart, lanes: Lanes):
        self.part, self.program, self.lanes = piece, piece.program, lanes
        self.lines: list[str] = []
        self.names: dict[int, str] = {}
        self.turned: set[int] = set()
        self.runs: set[tuple[str, str]] = set()
        self.table = instructions(lanes)

    def text(self, name: str) -> str:
        """The definition of the entry as LLVM text."""
        inputs, outputs = self.program.inputs, self.program.outputs
        parameters = [_parameters(k, a, "readonly ") for k, a in enumerate(inputs)]
        parameters += [_parameters(k, a) for k, a in enumerate(outputs, len(inputs))]
        scalars = self._loads()
        written = self._places()
        self._check(scalars)
        tables = self._constants(name, written) if self.part.constant else ""
        for index in self.part.nodes:
            self._node(index, scalars)
            for k, j in written.get(index, ()):
                self._store(k, j, self.names[index])
        head = f"define ptx_kernel void @{name}({', '.join(parameters)}, i64 %n) #3 {{"
        return "\n".join(
            [tables + head, _INDEX, *self.lines, "  br label %end\nend:\n  ret void\n}\n"]
        )

    def _loads(self) -> list[str]:
        """Names of all scalars of the inputs, which are loaded; scalars of uniform inputs that
        nothing reads are left out."""
        v, size = self.lanes.v, self.lanes.real.size
        read = {self.program.a[i] for i in self.part.nodes if self.program.op[i] == "input"}
        scalars: list[str] = []
        for k, argument in enumerate(self.program.inputs):
            self._row(k, argument)
            for j in range(argument.size):
                name = f"%in{len(scalars)}"
                if not argument.uniform or j == 0 or len(scalars) in read:
                    place = self._place(k, j, argument.uniform)
                    self.lines.append(
                        f"  {name} = load {v}, ptr {place}, align {size}, !invariant.load !0"
                    )
                scalars.append(name)
        return scalars

    def _check(self, scalars: Sequence[str]) -> None:
        """Emit %bad, whether an input is not finite: 0 x is NaN then, and so is the sum of such
        products.

        Uniform numbers are NaN all together, so that the first tells of all.
        """
        v, first, total = self.lanes.v, 0, self.lanes.constant(0.0)
        for argument in self.program.inputs:
            for j in range(argument.size):
                if not argument.uniform or j == 0:
                    k = first + j
                    self.lines.append(
                        f"  %zero{k} = fmul contract {v} {scalars[k]}, {self.lanes.constant(0.0)}"
                    )
                    self.lines.append(f"  %sum{k} = fadd contract {v} {total}, %zero{k}")
                    total = f"%sum{k}"
            first += argument.size
        self.lines.append(f"  %bad = fcmp uno {v} {total}, {self.lanes.constant(0.0)}")

    def _places(self) -> dict[int, list[tuple[int, int]]]:
        """For each node that is a result the outputs and their entries that it fills."""
        found: dict[int, list[tuple[int, int]]] = {}
        positions = [(k, j) for k, a in enumerate(self.program.outputs) for j in range(a.size)]
        for k in sorted({positions[at][0] for at in self.part.results}):
            self._row(len(self.program.inputs) + k, self.program.outputs[k])
        for at in self.part.results:
            k, j = positions[at]
            found.setdefault(self.program.results[at], []).append((len(self.program.inputs) + k, j))
        return found

    def _row(self, k: int, argument: Argument) -> None:
        """Emit %row, the address where the sample's entries of argument k begin."""
        if not argument.uniform:
            self.lines.append(f"  %skip{k} = mul i64 %i, %step{k}")
            self.lines.append(f"  %row{k} = getelementptr {self.lanes.v}, ptr %a{k}, i64 %skip{k}")

    def _place(self, k: int, j: int, uniform: bool = False) -> str:
        """The address of entry j of argument k, which is emitted where it is new."""
        if uniform:
            self.lines.append(f"  %p{k}.{j} = getelementptr {self.lanes.v}, ptr %a{k}, i64 {j}")
        else:
            run, within = divmod(j, TOGETHER)
            begin, step = self._run(k, run) if run else (f"%row{k}", f"%core{k}")
            self.lines.append(f"  %o{k}.{j} = mul i64 {step}, {within}")
            self.lines.append(
                f"  %p{k}.{j} = getelementptr {self.lanes.v}, ptr {begin}, i64 %o{k}.{j}"
            )
        return f"%p{k}.{j}"

    def _run(self, k: int, run: int) -> tuple[str, str]:
        """The address of a run of `TOGETHER` entries of argument k, and a stride that LLVM treats
        as a separate number.

        With the same step the runs would share their offsets, all of them alive for as long as the
        thread writes.
        """
        begin, step = names = f"%run{k}.{run}", f"%core{k}.{run}"
        if names not in self.runs:
            self.runs.add(names)
            self.lines.append(f"  %far{k}.{run} = mul i64 %core{k}, {run * TOGETHER}")
            self.lines.append(
                f"  {begin} = getelementptr {self.lanes.v}, ptr %row{k}, i64 %far{k}.{run}"
            )
            self.lines.append(f"  {step} = freeze i64 %core{k}")
        return names

    def _node(self, index: int, scalars: Sequence[str]) -> None:
        """Emit the instruction of a node; sine and cosine of one argument are emitted together."""
        program, lanes, op = self.program, self.lanes, self.program.op[index]
        if op == "input":
            self.names[index] = scalars[program.a[index]]
        elif op == "const":
            self.names[index] = lanes.constant(program.constants[program.a[index]])
        elif op in _SINES:
            self._sines(program.a[index])
            self.names[index] = f"%{op}{program.a[index]}"
        else:
            first = program.a[index]
            self.names[index] = f"%v{index}"
            operands = [self.names[i] for i in program.operands(index)]
            if op == "where" and program.op[first] in COMPARISONS:
                op = CHOICE
            self.lines.append("  " + self.table[op].format(f"%v{index}", *operands))

    def _sines(self, x: int) -> None:
        """Emit sine and cosine of a node, once."""
        if x in self.turned:
            return
        self.turned.add(x)
        pair = f"{{ {self.lanes.v}, {self.lanes.v} }}"
        self.lines.append(
            f"  %pair{x} = call {pair} @sincos.{self.lanes.suffix}({self.lanes.v} "
            f"{self.names[x]})\n"
            f"  %sin{x} = extractvalue {pair} %pair{x}, 0\n  %cos{x} = extractvalue {pair} "
            f"%pair{x}, 1"
        )

    def _constants(self, name: str, written: dict[int, list[tuple[int, int]]]) -> str:
        """The tables of places for constant results, whose loops are emitted; `written` is emptied
        of them."""
        tables: list[str] = []
        for index, places in sorted(written.items()):
            number = self.program.constants[self.program.a[index]]
            for k in sorted({k for k, _ in places}):
                value = self._valid(f"%constant{len(tables)}", self.lanes.constant(number))
                table, lines = _constants_loop(
                    name, len(tables), self.lanes, k, value, [j for at, j in places if at == k]
                )
                tables.append(table)
                self.lines.append(lines)
        written.clear()
        return "".join(tables)

    def _store(self, k: int, j: int, value: str) -> None:
        v, place = self.lanes.v, self._place(k, j)
        made = self._valid(f"%w{k}.{j}", value)
        self.lines.append(f"  store {v} {made}, ptr {place}, align {self.lanes.real.size}")

    def _valid(self, name: str, value: str) -> str:
        """The name of a value, replaced by NaN where an input is not finite."""
        v = self.lanes.v
        self.lines.append(f"  {name} = select i1 %bad, {v} {self.lanes.constant(nan)}, {v} {value}")
        return name


def _parameters(k: int, argument: Argument, access: str = "") -> str:
    address = f"ptr noalias {access}%a{k}"
    return address if argument.uniform else f"{address}, i64 %step{k}, i64 %core{k}"


_LOOP = """\
  br label %runs{s}
runs{s}:
  %r{s} = phi i64 [ 0, %{before} ], [ %r{s}.next, %done{s} ]
  %at{s} = getelementptr {{ i32, i32 }}, ptr {table}, i64 %r{s}
  %to.at{s} = getelementptr i32, ptr %at{s}, i64 1
  %from32.{s} = load i32, ptr %at{s}, align 4, !invariant.load !0
  %to32.{s} = load i32, ptr %to.at{s}, align 4, !invariant.load !0
  %from{s} = zext i32 %from32.{s} to i64
  %to{s} = zext i32 %to32.{s} to i64
  br label %entry{s}
entry{s}:
  %j{s} = phi i64 [ %from{s}, %runs{s} ], [ %j{s}.next, %entry{s} ]
  %offset{s} = mul i64 %core{k}, %j{s}
  %place{s} = getelementptr {v}, ptr %row{k}, i64 %offset{s}
  store {v} {value}, ptr %place{s}, align {size}
  %j{s}.next = add i64 %j{s}, 1
  %more{s} = icmp ult i64 %j{s}.next, %to{s}
  br i1 %more{s}, label %entry{s}, label %done{s}
done{s}:
  %r{s}.next = add i64 %r{s}, 1
  %again{s} = icmp ult i64 %r{s}.next, {count}
  br i1 %again{s}, label %runs{s}, label %after{s}
after{s}:"""


def _runs(places: Iterable[int]) -> list[tuple[int, int]]:
    """The first place of each run of consecutive places, and the one behind its last."""
    found: list[tuple[int, int]] = []
    for place in sorted(places):
        if found and found[-1][1] == place:
            found[-1] = found[-1][0], place + 1
        else:
            found.append((place, place + 1))
    return found


def _constants_loop(
    name: str, s: int, lanes: Lanes, k: int, value: str, places: Sequence[int]
) -> tuple[str, str]:
    """(table of runs, lines) of a loop that writes one constant, such as the zeros of a tree's
    derivatives, to many entries of argument k; s: the loop's number in the entry."""
    found, table = _runs(places), f"@{name}.runs{s}"
    rows = ", ".join(f"{{ i32, i32 }} {{ i32 {a}, i32 {b} }}" for a, b in found)
    declared = f"{table} = internal constant [{len(found)} x {{ i32, i32 }}] [{rows}], align 4\n"
    before = f"after{s - 1}" if s else "sample"
    return declared, _LOOP.format(
        s=s, before=before, table=table, k=k, v=lanes.v, value=value, size=lanes.real.size,
        count=len(found),
    )  # fmt: skip


def _sincos(lanes: Lanes) -> str:
    """LLVM text of `{ double, double } @sincos.f64(double x)` for a machine whose threads branch
    separately; large arguments go through `@reduce`.

    lanes: of single numbers.
    """
    v, i = lanes.v, lanes.i
    code = VectorCode(lanes, fma=True)
    code.lines.append(
        f"define internal {{ {v}, {v} }} @sincos.{lanes.suffix}({v} %x0) #2 {{\nentry:"
    )
    code.reduce(0)
    wide = "%a0"
    code.lines.append(
        f"  %large = fcmp ugt {v} %a0, {lanes.constant(LARGEST)}\n  br i1 %large, label %slow, "
        f"label %fast\nslow:"
    )
    if lanes.real != DOUBLE:
        wide = "%wide.a0"
        code.lines.append(f"  {wide} = fpext {v} %a0 to double")
    r, q = "%both.r", "%both.q"
    code.lines.append(f"""\
  %both = call {{ double, i64 }} @reduce(double {wide})
  {r} = extractvalue {{ double, i64 }} %both, 0
  {q} = extractvalue {{ double, i64 }} %both, 1""")
    if lanes.real != DOUBLE:
        r, q = "%short.r", "%short.q"
        code.lines.append(
            f"  {r} = fptrunc double %both.r to {v}\n  {q} = trunc i64 %both.q to {i}"
        )
    code.lines.append(f"""\
  br label %fast
fast:
  %r = phi {v} [ %r0, %entry ], [ {r}, %slow ]
  %q = phi {i} [ %quadrant0, %entry ], [ {q}, %slow ]""")
    code.polynomials(0, "%r", "%q")
    code.lines.append(f"""\
  %only.sine = insertvalue {{ {v}, {v} }} poison, {v} %sine0, 0
  %result = insertvalue {{ {v}, {v} }} %only.sine, {v} %cosine0, 1
  ret {{ {v}, {v} }} %result
}}
declare {v} @llvm.fma.{lanes.suffix}({v}, {v}, {v})
""")
    return "\n".join(code.lines)
