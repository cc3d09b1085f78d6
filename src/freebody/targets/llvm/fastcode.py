"""LLVM text of a kernel's own C function for Python's interpreter, which makes calls with a few
samples quick (see `fastcall`)."""

from __future__ import annotations

from freebody.program.program import Argument, Program
from freebody.targets.llvm import fastchecks
from freebody.targets.llvm.lanes import DOUBLE, Real, loaded, stored

_CONTIGUOUS_ALIGNED = 0x0001 | 0x0100
_WRITEABLE = 0x0400
_TYPE, _DATA, _ND, _DIMS, _DESCR, _FLAGS = 8, 16, 24, 32, 56, 64
"""Offsets in PyObject and PyArrayObject."""
_COUNT, _ITEMS = 16, 24  # offsets in PyTupleObject
_GENERAL, _HELD, _UNITS, _MOST = (
    _ITEMS + 8 * k for k in range(4)
)  # offsets in the tuple that a function has as its self
_VALUE = 16  # offset in PyFloatObject

EXPORTS = ("fastcall", "fastcall.checked")


def text(program: Program, real: Real) -> str:
    """LLVM text of `ptr @fastcall(ptr self, ptr args, i64 nargs, ptr kwnames)`, in front of
    `@kernel`, and of `@fastcall.checked`, which also looks whether the outputs are finite and
    quaternions of unit length; `self` is the tuple that `fastcall.Definition.function` makes."""
    inputs, outputs = program.inputs, program.outputs
    entries = zip(EXPORTS, ("false", "true"), strict=True)
    lines = [
        *_EXTERNALS,
        f"@{_descr(real)} = external global i8",
        *_tables(inputs, outputs, real),
        *(_entry(name, checked) for name, checked in entries),
        "define internal ptr @fast(ptr %self, ptr %args, i64 %nargs, ptr %kwnames, i1 %checked) "
        "noinline {",
        *_counted(inputs, outputs, real),
        *_named_out(len(outputs)),
        *_inputs_seen(inputs, real),
        *_outputs_given(inputs, outputs, real),
        *_outputs_made(inputs, outputs, real),
        "general:",
        loaded("%callable", "ptr", "%self", _GENERAL, of="i8"),
        "  %result = call ptr @PyObject_Vectorcall(ptr %callable, ptr %args, i64 %nargs, ptr "
        "%kwnames)",
        "  ret ptr %result",
        "failed:",
        "  ret ptr null",
        "}",
    ]
    return "\n".join(lines) + "\n"


_EXTERNALS = (
    "@freebody.PyArray_Type = external global i8",
    "@freebody.PyFloat_Type = external global i8",
    "@freebody.PyTuple_Type = external global i8",
    "@freebody.name.out = external global i8",
    "declare ptr @PyObject_Vectorcall(ptr, ptr, i64, ptr)",
    "declare ptr @freebody.PyArray_New(ptr, i32, ptr, i32, ptr, ptr, i32, i32, ptr)",
    "declare ptr @freebody.PyArray_Scalar(ptr, ptr, ptr)",
    "declare ptr @PyTuple_New(i64)",
    "declare i32 @PyTuple_SetItem(ptr, i64, ptr)",
    "declare void @Py_IncRef(ptr)",
    "declare void @Py_DecRef(ptr)",
    "declare void @llvm.memcpy.p0.p0.i64(ptr, ptr, i64, i1)",
)
_RUN = "  call void @kernel(ptr %data, ptr %dims, ptr %steps, ptr null)"
_FastArguments = tuple[Argument, ...]


def _tables(inputs: _FastArguments, outputs: _FastArguments, real: Real) -> list[str]:
    """LLVM tables that describe one sample to the loop (with steps of 0 between samples), and the
    shapes of outputs without the batch size."""
    return [
        _numbers("fast.dims", _dims(inputs, outputs)),
        _numbers("fast.steps", _steps(inputs, outputs, real)),
        *(_numbers(f"fast.shape{k}", [1, *a.shape]) for k, a in enumerate(outputs)),
    ]


def _dims(inputs: _FastArguments, outputs: _FastArguments) -> list[int]:
    return [1, *(n for a in (*inputs, *outputs) for n in a.shape)]


def _steps(inputs: _FastArguments, outputs: _FastArguments, real: Real) -> list[int]:
    strides = [s for a in (*inputs, *outputs) for s in _strides(a, real.size)]
    return [*(0 for _ in inputs), *(real.size * a.size for a in outputs), *strides]


def _copied(name: str, source: str, count: int) -> list[str]:
    """Lines that allocate numbers on the stack and copy them from a table."""
    return [
        f"  %{name} = alloca [{count} x i64], align 16",
        f"  call void @llvm.memcpy.p0.p0.i64(ptr %{name}, ptr @{source}, i64 {8 * count}, "
        "i1 false)",
    ]


def _counted(inputs: _FastArguments, outputs: _FastArguments, real: Real) -> list[str]:
    """Lines that allocate the loop's arguments, and continue at `counted` where the call has as
    many arguments as inputs, or one fewer."""
    cells = [k for k, a in enumerate(outputs) if not a.shape]
    return [
        "entry:",
        f"  %data = alloca [{len(inputs) + len(outputs)} x ptr], align 16",
        *(f"  %cell{k} = alloca {real.name}, align 8" for k in cells),
        *(f"  %row{k} = alloca ptr, align 8" for k in cells),
        *(f"  store ptr null, ptr %row{k}, align 8" for k in cells),
        *_copied("dims", "fast.dims", len(_dims(inputs, outputs))),
        *_copied("steps", "fast.steps", len(_steps(inputs, outputs, real))),
        *(
            line
            for k, a in enumerate(outputs)
            for line in _copied(f"shape.of{k}", f"fast.shape{k}", 1 + len(a.shape))
        ),
        "  %batch = alloca i64, align 8",
        "  store i64 0, ptr %batch, align 8",
        loaded("%most.bytes", "ptr", "%self", _MOST, of="i8"),
        loaded("%most", "i64", "%most.bytes", fastchecks.BYTES, of="i8"),
        f"  %all = icmp eq i64 %nargs, {len(inputs)}",
        f"  %but.last = icmp eq i64 %nargs, {len(inputs) - 1}",
        "  %right.count = or i1 %all, %but.last",
        f"  %held.at = getelementptr i8, ptr %self, i64 {_HELD}",
        "  %no.names = icmp eq ptr %kwnames, null",
        "  br i1 %right.count, label %counted, label %general",
    ]


def _inputs_seen(inputs: _FastArguments, real: Real) -> list[str]:
    """Lines that examine the inputs in turn and check quaternions; they continue at `taken` where
    `out` is given, else at `make`."""
    lines = []
    for k, argument in enumerate(inputs):
        is_number = not argument.shape and real is DOUBLE
        otherwise = f"float{k}" if is_number else "general"
        last = k == len(inputs) - 1
        place = f"%args, i64 {k}"
        rows = "general" if argument.uniform else _counts(k, argument, real)
        lines += _look(k, argument, real, place, _CONTIGUOUS_ALIGNED, rows, 0, otherwise, last)
        lines += _float(k) if is_number else []
    return [
        *lines,
        f"look{len(inputs)}:",
        "  %given.count = load i64, ptr %batch, align 8",
        "  %is.batch = icmp ne i64 %given.count, 0",
        "  %count = select i1 %is.batch, i64 %given.count, i64 1",
        "  store i64 %count, ptr %dims, align 8",
        "  br i1 %checked, label %lengths, label %looked",
        "lengths:",
        loaded("%units", "ptr", "%self", _UNITS, of="i8"),
        "  %are.unit = call i1 @fast.unit(ptr %units, ptr %data, ptr %steps, i64 %count)",
        "  br i1 %are.unit, label %looked, label %general",
        "looked:",
        "  br i1 %no.names, label %make, label %taken",
    ]


def _outputs_given(inputs: _FastArguments, outputs: _FastArguments, real: Real) -> list[str]:
    """Lines from `taken` on: run into the arrays given as `out`, and return these."""
    lines = [*_taken(len(outputs)), f"  br label %look{len(inputs) + 1}"]
    flags = _CONTIGUOUS_ALIGNED | _WRITEABLE
    for k, argument in enumerate(outputs):
        at = len(inputs) + 1 + k
        lines += _look(at, argument, real, f"%outs, i64 {k}", flags, _agrees(at), -1)
    return [
        *lines,
        f"look{len(inputs) + len(outputs) + 1}:",
        *_apart((*inputs, *outputs), len(inputs), real.size),
        "run:",
        _RUN,
        "  call void @Py_IncRef(ptr %given)",
        "  ret ptr %given",
    ]


def _outputs_made(inputs: _FastArguments, outputs: _FastArguments, real: Real) -> list[str]:
    """Lines from `make` on: run into new arrays and return them; for a checked call only if all is
    finite."""
    lines = ["make:"]
    for k, argument in enumerate(outputs):
        lines += (_make if argument.shape else _cell)(k, len(inputs) + k, argument, real)
    lines += [_RUN, *fastchecks.checked(outputs)]
    for k, argument in enumerate(outputs):
        lines += [] if argument.shape else _scalar(k, real)
    return [*lines, "  ret ptr %out0"] if len(outputs) == 1 else [*lines, *_tuple(len(outputs))]


def _entry(name: str, checked: str) -> str:
    return f"""\
define ptr @{name}(ptr %self, ptr %args, i64 %nargs, ptr %kwnames) {{
  %result = tail call ptr @fast(ptr %self, ptr %args, i64 %nargs, ptr %kwnames, i1 {checked})
  ret ptr %result
}}"""


def _descr(real: Real) -> str:
    return f"freebody.descr.{real.dtype}"


def _numbers(name: str, values: list[int]) -> str:
    entries = ", ".join(f"i64 {value}" for value in values)
    return f"@{name} = private constant [{len(values)} x i64] [{entries}], align 8"


def _strides(argument: Argument, step: int) -> list[int]:
    """Distances in bytes between neighbours along each core axis in C order; step: the size of one
    number."""
    strides = []
    for size in reversed(argument.shape):
        strides.append(step)
        step *= size
    return strides[::-1]


def _named_out(outputs: int) -> list[str]:
    """Lines for a call without keywords, or with `out` alone: its value `%given`, and the address
    of its arrays, `%outs`."""
    lines = [
        "counted:",
        "  %given.at = getelementptr ptr, ptr %args, i64 %nargs",
        "  br i1 %no.names, label %look0, label %named",
        "named:",
        loaded("%names", "i64", "%kwnames", _COUNT, of="i8"),
        "  %one.name = icmp eq i64 %names, 1",
        loaded("%name", "ptr", "%kwnames", _ITEMS, of="i8"),
        "  %is.out = icmp eq ptr %name, @freebody.name.out",
        "  %only.out = and i1 %one.name, %is.out",
    ]
    if outputs == 1:
        lines.append("  br i1 %only.out, label %look0, label %general")
    else:
        lines += [
            "  br i1 %only.out, label %several, label %general",
            "several:",
            "  %tuple.given = load ptr, ptr %given.at, align 8",
            loaded("%kind", "ptr", "%tuple.given", _TYPE, of="i8"),
            "  %is.tuple = icmp eq ptr %kind, @freebody.PyTuple_Type",
            "  br i1 %is.tuple, label %counting, label %general",
            "counting:",
            loaded("%length", "i64", "%tuple.given", _COUNT, of="i8"),
            f"  %as.many = icmp eq i64 %length, {outputs}",
            "  br i1 %as.many, label %look0, label %general",
        ]
    return lines


def _taken(outputs: int) -> list[str]:
    """Lines that take the arrays given as `out`."""
    lines = ["taken:", "  %given = load ptr, ptr %given.at, align 8"]
    if outputs == 1:
        return [*lines, "  %outs = getelementptr ptr, ptr %given.at, i64 0"]
    return [*lines, f"  %outs = getelementptr i8, ptr %given, i64 {_ITEMS}"]


def _apart(arguments: tuple[Argument, ...], inputs: int, size: int) -> list[str]:
    """Lines that continue at `run` if no output overlaps another argument, else take the general
    way."""
    lines, apart = ["  %others = sub i64 %count, 1"], "true"
    for k, argument in enumerate(arguments):
        lines += [
            loaded(f"%start{k}", "ptr", "%data", k),
            loaded(f"%way{k}", "i64", "%steps", k),
            f"  %to.last{k} = mul i64 %way{k}, %others",
            f"  %last{k} = getelementptr i8, ptr %start{k}, i64 %to.last{k}",
            f"  %stop{k} = getelementptr i8, ptr %last{k}, i64 {size * argument.size}",
        ]
    for k in range(inputs, len(arguments)):
        for other in range(k):
            pair = f"{k}.{other}"
            lines += [
                f"  %before{pair} = icmp ule ptr %stop{k}, %start{other}",
                f"  %after{pair} = icmp uge ptr %start{k}, %stop{other}",
                f"  %beside{pair} = or i1 %before{pair}, %after{pair}",
                f"  %apart{pair} = and i1 {apart}, %beside{pair}",
            ]
            apart = f"%apart{pair}"
    return [*lines, f"  br i1 {apart}, label %run, label %general"]


def _look(
    k: int,
    argument: Argument,
    real: Real,
    place: str,
    flags: int,
    rows: str | list[str],
    shift: int = 0,
    otherwise: str = "general",
    last: bool = False,
) -> list[str]:
    """Lines that examine argument k at `place`, and continue with the next if it is a plain array
    of its core shape, or a batch of them, else take the general way.

    Its data become entry k + shift of those that the loop takes. rows: what is done about whether
    it is a batch, up to `core{k}`, or "general" where it must be none. otherwise: where what is no
    array goes. last: whether it is the input that a function may hold.
    """
    nd = len(argument.shape)
    lines = [
        f"look{k}:",
        f"  %{'given.' if last else ''}slot{k} = getelementptr ptr, ptr {place}",
        *([f"  %slot{k} = select i1 %but.last, ptr %held.at, ptr %given.slot{k}"] if last else []),
        f"  %object{k} = load ptr, ptr %slot{k}, align 8",
        _field(k, "type", _TYPE, "ptr"),
        f"  %is{k} = icmp eq ptr %type{k}, @freebody.PyArray_Type",
        f"  br i1 %is{k}, label %array{k}, label %{otherwise}",
        f"array{k}:",
        _field(k, "nd", _ND, "i32"),
        _field(k, "descr", _DESCR, "ptr"),
        _field(k, "flags", _FLAGS, "i32"),
        f"  %masked{k} = and i32 %flags{k}, {flags}",
        f"  %is.one{k} = icmp eq i32 %nd{k}, {nd}",
        f"  %is.rows{k} = icmp eq i32 %nd{k}, {nd + 1}",
        f"  %a{k} = or i1 %is.one{k}, %is.rows{k}",
        f"  %b{k} = icmp eq ptr %descr{k}, @{_descr(real)}",
        f"  %c{k} = icmp eq i32 %masked{k}, {flags}",
        f"  %ab{k} = and i1 %a{k}, %b{k}",
        f"  %abc{k} = and i1 %ab{k}, %c{k}",
        f"  br i1 %abc{k}, label %shape{k}, label %general",
        f"shape{k}:",
        _field(k, "dims", _DIMS, "ptr"),
        f"  %axes{k} = zext i1 %is.rows{k} to i64",
        f"  %core.dims{k} = getelementptr i64, ptr %dims{k}, i64 %axes{k}",
        *([f"  br i1 %is.one{k}, label %core{k}, label %general"] if rows == "general" else rows),
        f"core{k}:",
    ]
    fits = "true"
    for axis, size in enumerate(argument.shape):
        lines += [
            loaded(f"%size{k}.{axis}", "i64", f"%core.dims{k}", axis),
            f"  %same{k}.{axis} = icmp eq i64 %size{k}.{axis}, {size}",
            f"  %fits{k}.{axis} = and i1 {fits}, %same{k}.{axis}",
        ]
        fits = f"%fits{k}.{axis}"
    return [
        *lines,
        _field(k, "buffer", _DATA, "ptr"),
        stored(f"%entry{k}", "ptr", f"%buffer{k}", "%data", k + shift),
        f"  br i1 {fits}, label %look{k + 1}, label %general",
    ]


def _counts(k: int, argument: Argument, real: Real) -> list[str]:
    """Lines for input k being a batch: it must have as many samples as earlier ones and few enough,
    and the loop will step through it."""
    return [
        f"  br i1 %is.rows{k}, label %rows{k}, label %core{k}",
        f"rows{k}:",
        f"  %n{k} = load i64, ptr %dims{k}, align 8",
        f"  %before{k} = load i64, ptr %batch, align 8",
        f"  %is.first{k} = icmp eq i64 %before{k}, 0",
        f"  %is.alike{k} = icmp eq i64 %before{k}, %n{k}",
        f"  %agrees{k} = or i1 %is.first{k}, %is.alike{k}",
        f"  %is.any{k} = icmp sgt i64 %n{k}, 0",
        f"  %is.few{k} = icmp sle i64 %n{k}, %most",
        f"  %is.some{k} = and i1 %is.any{k}, %is.few{k}",
        f"  %good{k} = and i1 %agrees{k}, %is.some{k}",
        f"  store i64 %n{k}, ptr %batch, align 8",
        stored(f"%step.at{k}", "i64", str(real.size * argument.size), "%steps", k),
        f"  br i1 %good{k}, label %core{k}, label %general",
    ]


def _agrees(k: int) -> list[str]:
    """Lines for argument k, a given output, which must have as many samples as the call."""
    return [
        f"  %is.due{k} = icmp eq i1 %is.rows{k}, %is.batch",
        f"  br i1 %is.due{k}, label %due{k}, label %general",
        f"due{k}:",
        f"  br i1 %is.batch, label %rows{k}, label %core{k}",
        f"rows{k}:",
        f"  %n{k} = load i64, ptr %dims{k}, align 8",
        f"  %good{k} = icmp eq i64 %n{k}, %count",
        f"  br i1 %good{k}, label %core{k}, label %general",
    ]


def _float(k: int) -> list[str]:
    """Lines for input k being no array: a Python float is read, anything else takes the general
    way."""
    return [
        f"float{k}:",
        f"  %is.float{k} = icmp eq ptr %type{k}, @freebody.PyFloat_Type",
        f"  br i1 %is.float{k}, label %number{k}, label %general",
        f"number{k}:",
        f"  %value{k} = getelementptr i8, ptr %object{k}, i64 {_VALUE}",
        stored(f"%value.entry{k}", "ptr", f"%value{k}", "%data", k),
        f"  br label %look{k + 1}",
    ]


def _field(k: int, name: str, offset: int, kind: str) -> str:
    align = 8 if kind == "ptr" else 4
    return loaded(f"%{name}{k}", kind, f"%object{k}", offset, of="i8", align=align)


def _new(k: int, axes: str, shape: str, real: Real) -> list[str]:
    """Lines that make a new array for output k."""
    return [
        f"  %new{k} = call ptr @freebody.PyArray_New(ptr @freebody.PyArray_Type, i32 {axes}, "
        f"ptr {shape}, i32 {real.number}, ptr null, ptr null, i32 0, i32 0, ptr null)",
        f"  %is.new{k} = icmp ne ptr %new{k}, null",
        f"  br i1 %is.new{k}, label %new.{k}, label %failed",
        f"new.{k}:",
        f"  %out.at{k} = getelementptr i8, ptr %new{k}, i64 {_DATA}",
    ]


def _make(k: int, position: int, argument: Argument, real: Real) -> list[str]:
    """Lines that make a new array for output k; position: its number among all arguments."""
    nd = len(argument.shape)
    return [
        f"  store i64 %count, ptr %shape.of{k}, align 8",
        f"  %shape.core{k} = getelementptr i64, ptr %shape.of{k}, i64 1",
        f"  %shape{k}.made = select i1 %is.batch, ptr %shape.of{k}, ptr %shape.core{k}",
        f"  %nd{k}.made = select i1 %is.batch, i32 {nd + 1}, i32 {nd}",
        *_new(k, f"%nd{k}.made", f"%shape{k}.made", real),
        f"  %out{k} = getelementptr i8, ptr %new{k}, i64 0",
        f"  %out.data{k} = load ptr, ptr %out.at{k}, align 8",
        stored(f"%out.entry{k}", "ptr", f"%out.data{k}", "%data", position),
    ]


def _cell(k: int, position: int, argument: Argument, real: Real) -> list[str]:
    """Lines for output k, one number a sample: a place for the number until it becomes an object,
    or an array for a batch."""
    return [
        f"  br i1 %is.batch, label %many{k}, label %single{k}",
        f"many{k}:",
        f"  store i64 %count, ptr %shape.of{k}, align 8",
        *_new(k, "1", f"%shape.of{k}", real),
        f"  store ptr %new{k}, ptr %row{k}, align 8",
        f"  %row.data{k} = load ptr, ptr %out.at{k}, align 8",
        f"  br label %placed{k}",
        f"single{k}:",
        f"  br label %placed{k}",
        f"placed{k}:",
        f"  %out.data{k} = phi ptr [%row.data{k}, %new.{k}], [%cell{k}, %single{k}]",
        stored(f"%out.entry{k}", "ptr", f"%out.data{k}", "%data", position),
    ]


def _scalar(k: int, real: Real) -> list[str]:
    """Lines that turn output k of a single sample into a NumPy scalar."""
    return [
        f"  br i1 %is.batch, label %whole{k}, label %object.{k}",
        f"object.{k}:",
        f"  %number.{k} = call ptr @freebody.PyArray_Scalar(ptr %cell{k}, ptr @{_descr(real)}, ptr "
        f"null)",
        f"  store ptr %number.{k}, ptr %row{k}, align 8",
        f"  br label %whole{k}",
        f"whole{k}:",
        f"  %out{k} = load ptr, ptr %row{k}, align 8",
        f"  %made{k} = icmp ne ptr %out{k}, null",
        f"  br i1 %made{k}, label %made.{k}, label %failed",
        f"made.{k}:",
    ]


def _tuple(count: int) -> list[str]:
    """Lines that return the outputs as a tuple, which takes over their references."""
    return [
        f"  %tuple = call ptr @PyTuple_New(i64 {count})",
        "  %tupled = icmp ne ptr %tuple, null",
        "  br i1 %tupled, label %fill, label %failed",
        "fill:",
        *(
            f"  %set{k} = call i32 @PyTuple_SetItem(ptr %tuple, i64 {k}, ptr %out{k})"
            for k in range(count)
        ),
        "  ret ptr %tuple",
    ]
