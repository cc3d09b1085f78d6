"""LLVM text of the function that XLA calls: it reads a call frame, and runs a kernel's loop over
the batch, shared with XLA's threads.

Buffers come as (outer, inner, *core), each of the two leading sizes 1 or that of the outputs; where
it is 1, the one value serves all. A call of the loop takes entries of the inner axis, so that what
is uniform there may change along the outer one.

The batch is cut into parts that whoever comes next takes, the caller among them; a thread that
comes late finds nothing left, and what it looks at lives until the last one has let go of it. So
nobody waits for a thread that has not begun. A sample's numbers do not depend on the cut."""

from __future__ import annotations

from freebody.program.program import Argument, Program
from freebody.targets.llvm.lanes import Real, loaded, stored
from freebody.targets.threads import GRAIN
from freebody.targets.xla.layout import NUMBERS, OFFSETS, SIZES

_REFUSED = "freebody: a call that is laid out in another way than the interface's version says."
_DTYPE = {"float64": NUMBERS["XLA_FFI_DataType_F64"], "float32": NUMBERS["XLA_FFI_DataType_F32"]}


def text(
    program: Program, real: Real, loop: int, x86: bool, version: tuple[int, int], each: int
) -> str:
    """LLVM text of `ptr @xla(ptr frame)`, which returns null or XLA's error.

    loop: address of `void loop(ptr args, ptr dims, ptr steps, ptr data)` of the program's kernel,
    for any batch. version: of the interface, which XLA asks for. each: samples that a thread is
    woken for.
    """
    arguments = (*program.inputs, *program.outputs)
    lines = _TextLines(["define ptr @xla(ptr %frame) {", "entry:"])
    _asked(lines, version)
    _counted(lines, program)
    right = [_right(lines, k, argument, real) for k, argument in enumerate(arguments)]
    lines.append(f"  br i1 {lines.all('right', right)}, label %sized, label %refuse\nsized:")
    _sizes(lines, arguments, len(program.inputs), real)
    _refused(lines)
    words = "".join(f"\\{byte:02X}" for byte in _REFUSED.encode() + b"\0")
    lines.append(f'@message = private constant [{len(_REFUSED) + 1} x i8] c"{words}"')
    return "\n".join([*lines, _sharing(arguments, real, loop, x86, each), ""])


def _asked(lines: _TextLines, version: tuple[int, int]) -> None:
    """Emit lines that describe the function to XLA, where it asks by an extension of the frame."""
    frame, about = OFFSETS["XLA_FFI_CallFrame"], OFFSETS["XLA_FFI_Api_Version"]
    start = OFFSETS["XLA_FFI_Metadata"]["api_version"]
    extension = lines.field("extension", "ptr", "%frame", frame["extension_start"])
    lines.append(
        f"  %plain = icmp eq ptr {extension}, null\n  br i1 %plain, label %work, label %extended"
    )
    lines.append("extended:")
    kind = lines.field("kind", "i32", extension, OFFSETS["XLA_FFI_Extension_Base"]["type"])
    asks = lines.equal("asks", "i32", kind, NUMBERS["XLA_FFI_Extension_Metadata"])
    lines.append(f"  br i1 {asks}, label %tell, label %work\ntell:")
    told = lines.field("told", "ptr", extension, OFFSETS["XLA_FFI_Metadata_Extension"]["metadata"])
    lines.put("i64", SIZES["XLA_FFI_Api_Version"], told, start + about["struct_size"])
    lines.put("ptr", "null", told, start + about["extension_start"])
    lines.put("i32", version[0], told, start + about["major_version"])
    lines.put("i32", version[1], told, start + about["minor_version"])
    lines.put("i32", 0, told, OFFSETS["XLA_FFI_Metadata"]["traits"])
    lines.append("  ret ptr null\nwork:")


def _counted(lines: _TextLines, program: Program) -> None:
    """Emit the check that the frame has the known layout and as many buffers as the program, and
    the loads of the buffers' lists."""
    frame, right = OFFSETS["XLA_FFI_CallFrame"], []
    for part, kind, wanted in (
        ("args", "XLA_FFI_Args", len(program.inputs)),
        ("rets", "XLA_FFI_Rets", len(program.outputs)),
    ):
        size = lines.field(
            f"{part}.bytes", "i64", "%frame", frame[part] + OFFSETS[kind]["struct_size"]
        )
        right.append(lines.equal(f"{part}.known", "i64", size, SIZES[kind]))
        count = lines.field(f"{part}.count", "i64", "%frame", frame[part] + OFFSETS[kind]["size"])
        right.append(lines.equal(f"{part}.right", "i64", count, wanted))
    stage = lines.field("stage", "i32", "%frame", frame["stage"])
    right.append(lines.equal("executes", "i32", stage, NUMBERS["XLA_FFI_ExecutionStage_EXECUTE"]))
    lines.append(f"  br i1 {lines.all('framed', right)}, label %look, label %refuse\nlook:")
    lines.field("args.list", "ptr", "%frame", frame["args"] + OFFSETS["XLA_FFI_Args"]["args"])
    lines.field("rets.list", "ptr", "%frame", frame["rets"] + OFFSETS["XLA_FFI_Rets"]["rets"])
    for k in range(len(program.inputs)):
        lines.entry(f"buffer{k}", "%args.list", k)
    for k in range(len(program.outputs)):
        lines.entry(f"buffer{len(program.inputs) + k}", "%rets.list", k)


def _right(lines: _TextLines, k: int, argument: Argument, real: Real) -> str:
    """The name of a flag whether buffer k has numbers of the right type and the expected number of
    axes."""
    buffer = OFFSETS["XLA_FFI_Buffer"]
    dtype = lines.field(f"dtype{k}", "i32", f"%buffer{k}", buffer["dtype"])
    rank = lines.field(f"rank{k}", "i64", f"%buffer{k}", buffer["rank"])
    typed = lines.equal(f"typed{k}", "i32", dtype, _DTYPE[real.dtype])
    ranked = lines.equal(f"ranked{k}", "i64", rank, 2 + len(argument.shape))
    return lines.all(f"fits{k}", [typed, ranked])


def _sizes(lines: _TextLines, arguments: tuple[Argument, ...], inputs: int, real: Real) -> None:
    """Emit lines that read the buffers' addresses, the bytes between samples along both axes and
    the sizes of these; then the computation is called."""
    buffer, count = OFFSETS["XLA_FFI_Buffer"], len(arguments)
    lines.append(f"  %work.new = call ptr @malloc(i64 {_size_of(count)})")
    for k, argument in enumerate(arguments):
        size = real.size * argument.size
        base = lines.field(f"base{k}", "ptr", f"%buffer{k}", buffer["data"])
        sizes = lines.field(f"sizes{k}", "ptr", f"%buffer{k}", buffer["dims"])
        outer = lines.field(f"outer{k}", "i64", sizes, 0)
        inner = lines.field(f"inner{k}", "i64", sizes, 8)
        lines += [
            f"  %one.inner{k} = icmp eq i64 {inner}, 1",
            f"  %step{k} = select i1 %one.inner{k}, i64 0, i64 {size}",
            f"  %one.outer{k} = icmp eq i64 {outer}, 1",
            f"  %row{k} = mul i64 {inner}, {size}",
            f"  %shift{k} = select i1 %one.outer{k}, i64 0, i64 %row{k}",
        ]
        lines.put("ptr", base, "%work.new", _BASES + 8 * k)
        lines.put("i64", f"%step{k}", "%work.new", _BASES + 8 * (count + k))
        lines.put("i64", f"%shift{k}", "%work.new", _BASES + 8 * (2 * count + k))
    lines.append(
        f"  call void @share(ptr %frame, ptr %work.new, i64 %outer{inputs}, i64 %inner{inputs})\n  "
        f"ret ptr null"
    )


def _refused(lines: _TextLines) -> None:
    """Emit the return of one of XLA's errors."""
    given, kind = OFFSETS["XLA_FFI_Error_Create_Args"], "XLA_FFI_Error_Create_Args"
    lines.append("refuse:\n  %problem = alloca [32 x i8], align 8")
    lines.fill(kind, "%problem", message="@message")
    lines.put("i32", NUMBERS["XLA_FFI_Error_Code_INTERNAL"], "%problem", given["errc"])
    api = lines.field("api", "ptr", "%frame", OFFSETS["XLA_FFI_CallFrame"]["api"])
    create = lines.field("create", "ptr", api, OFFSETS["XLA_FFI_Api"]["XLA_FFI_Error_Create"])
    lines.append(f"  %error = call ptr {create}(ptr %problem)\n  ret ptr %error\n}}")


class _TextLines(list[str]):
    """Lines of LLVM text in the making that read and write fields at offsets."""

    def field(self, name: str, kind: str, base: str, offset: int) -> str:
        """The name of a field that is loaded from an offset."""
        align = 4 if kind == "i32" else 8
        self.append(loaded(f"%{name}", kind, base, offset, of="i8", align=align))
        return f"%{name}"

    def entry(self, name: str, base: str, index: int) -> str:
        """The name of a pointer or size that is loaded from an array."""
        return self.field(name, "ptr", base, 8 * index)

    def put(self, kind: str, value: str | int, base: str, offset: int) -> None:
        """Emit the store of a value at an offset."""
        at, align = f"%put{len(self)}", 4 if kind == "i32" else 8
        self.append(stored(at, kind, str(value), base, offset, of="i8", align=align))

    def fill(self, kind: str, base: str, **pointers: str) -> None:
        """Emit the stores of a structure's fields: its size, no extension, and pointers."""
        fields = OFFSETS[kind]
        self.put("i64", SIZES[kind], base, fields["struct_size"])
        for name, pointer in {"extension_start": "null", **pointers}.items():
            self.put("ptr", pointer, base, fields[name])

    def equal(self, name: str, kind: str, value: str, other: str | int) -> str:
        """The name of a flag whether two numbers are equal."""
        self.append(f"  %{name} = icmp eq {kind} {value}, {other}")
        return f"%{name}"

    def all(self, name: str, flags: list[str]) -> str:
        """The name of the conjunction of flags."""
        known = "true"
        for k, flag in enumerate(flags):
            self.append(f"  %{name}.{k} = and i1 {known}, {flag}")
            known = f"%{name}.{k}"
        return known


_NEXT, _LEFT, _HOLDERS, _PARTS, _IN_ROW, _SIZE, _INNER = range(0, 56, 8)
"""Offsets in the record of a call's work: the next part, those that are not done, who holds the
record; how many parts there are, how many of them in a row of the outer axis, samples of one;
samples in a row."""

_BASES = 56
"""Offset in the record at which addresses of all arguments begin, then bytes from sample to sample,
and from row to row."""

_NUMBER, _SCHEDULE = "XLA_FFI_ThreadPool_NumThreads_Args", "XLA_FFI_ThreadPool_Schedule_Args"
_MODES = 0x1F80
"""The modes of SSE: no traps, to nearest, tiny numbers as they are, which XLA makes zero
elsewhere."""


def _size_of(arguments: int) -> int:
    """The size in bytes of a call's record of shared work."""
    return _BASES + 24 * arguments


def _sharing(arguments: tuple[Argument, ...], real: Real, loop: int, x86: bool, each: int) -> str:
    """LLVM text of `void @share(ptr frame, ptr work, i64 outer, i64 inner)`, which frees the record
    of the work when all is done.

    loop: address of the kernel's loop. each: samples that a thread is woken for.
    """
    parts = [
        _share(each, x86),
        _work(arguments, real, loop, x86),
        "define internal void @task(ptr %work) {\n"
        "  call void @parts(ptr %work)\n  call void @let.go(ptr %work)\n  ret void\n}",
        f"""\
define internal void @let.go(ptr %work) {{
  %at = getelementptr i8, ptr %work, i64 {_HOLDERS}
  %before = atomicrmw sub ptr %at, i64 1 acq_rel
  %last = icmp eq i64 %before, 1
  br i1 %last, label %end, label %done
end:
  call void @free(ptr %work)
  br label %done
done:
  ret void
}}
declare ptr @malloc(i64)
declare void @free(ptr)""",
    ]
    if x86:
        parts.append(
            "declare void @llvm.x86.sse.stmxcsr(ptr)\n"
            "declare void @llvm.x86.sse.ldmxcsr(ptr)\n"
            "declare void @llvm.x86.sse2.pause()"
        )
    return "\n".join(parts)


def _share(each: int, x86: bool) -> str:
    """LLVM text of `@share`'s body: it cuts the batch, asks for threads where that is worthwhile,
    takes parts itself, and waits for threads still at work."""
    lines = _TextLines(
        [
            "define internal void @share(ptr %frame, ptr %work, i64 %outer, i64 %inner) {",
            "entry:",
            f"  %asked = alloca [{SIZES[_NUMBER]} x i8], align 8",
            f"  %given = alloca [{SIZES[_SCHEDULE]} x i8], align 8",
            "  %found = alloca i64, align 8",
            "  store i64 1, ptr %found, align 8",
            "  %samples = mul i64 %outer, %inner",
            f"  %worth = udiv i64 %samples, {each}",
        ]
    )
    frame = OFFSETS["XLA_FFI_CallFrame"]
    lines.field("context", "ptr", "%frame", frame["ctx"])
    lines.field("api", "ptr", "%frame", frame["api"])
    _ask(lines)
    _cut(lines)
    _wake(lines)
    lines += [
        "begin:",
        "  call void @parts(ptr %work)",
        f"  %left.at = getelementptr i8, ptr %work, i64 {_LEFT}",
        "  br label %wait",
        "wait:",
        "  %left = load atomic i64, ptr %left.at acquire, align 8",
        "  %over = icmp eq i64 %left, 0",
        "  br i1 %over, label %done, label %rest",
        "rest:",
        *(["  call void @llvm.x86.sse2.pause()"] if x86 else []),
        "  br label %wait",
        "done:",
        "  call void @let.go(ptr %work)",
        "  ret void",
        "}",
        _forget(),
    ]
    return "\n".join(lines)


def _ask(lines: _TextLines) -> None:
    """Emit the question to XLA for its number of threads, where there is work for more than one; it
    continues at `cut`."""
    lines.append("  %long = icmp ugt i64 %worth, 1\n  br i1 %long, label %ask, label %cut\nask:")
    lines.fill(_NUMBER, "%asked", ctx="%context", num_threads="%found")
    lines.field("number", "ptr", "%api", OFFSETS["XLA_FFI_Api"]["XLA_FFI_ThreadPool_NumThreads"])
    lines += [
        "  %no.number = call ptr %number(ptr %asked)",
        "  call void @forget(ptr %api, ptr %no.number)",
        "  br label %cut",
    ]


def _cut(lines: _TextLines) -> None:
    """Emit the cut of the samples into two parts for each thread, so that a slow thread delays
    others less; with one thread each row is a part."""
    lines += [
        "cut:",
        "  %threads.found = load i64, ptr %found, align 8",
        "  %few = icmp ult i64 %worth, %threads.found",
        "  %threads.most = select i1 %few, i64 %worth, i64 %threads.found",
        "  %none = icmp ult i64 %threads.most, 1",
        "  %threads = select i1 %none, i64 1, i64 %threads.most",
        "  %alone = icmp eq i64 %threads, 1",
        "  %pieces = mul i64 %threads, 2",
        "  %piece.down = udiv i64 %samples, %pieces",
        f"  %piece.grains = udiv i64 %piece.down, {GRAIN}",
        "  %piece.more = add i64 %piece.grains, 1",
        f"  %piece = mul i64 %piece.more, {GRAIN}",
        "  %short.row = icmp ult i64 %inner, %piece",
        "  %whole.row = or i1 %alone, %short.row",
        "  %size = select i1 %whole.row, i64 %inner, i64 %piece",
        "  %up = add i64 %inner, %size",
        "  %up.less = sub i64 %up, 1",
        "  %in.row = udiv i64 %up.less, %size",
        "  %parts.all = mul i64 %in.row, %outer",
    ]
    record = {
        _NEXT: "0",
        _LEFT: "%parts.all",
        _HOLDERS: "1",
        _PARTS: "%parts.all",
        _IN_ROW: "%in.row",
        _SIZE: "%size",
        _INNER: "%inner",
    }
    for offset, value in record.items():
        lines.put("i64", value, "%work", offset)


def _wake(lines: _TextLines) -> None:
    """Emit the start of `@task` on further threads, each of which holds the work; it continues at
    `begin`."""
    lines.append("  br i1 %alone, label %begin, label %call\ncall:")
    lines.fill(_SCHEDULE, "%given", ctx="%context", task="@task", data="%work")
    lines.field("plan", "ptr", "%api", OFFSETS["XLA_FFI_Api"]["XLA_FFI_ThreadPool_Schedule"])
    lines += [
        f"  %holders = getelementptr i8, ptr %work, i64 {_HOLDERS}",
        "  br label %another",
        "another:",
        "  %k = phi i64 [ 1, %call ], [ %k.next, %planned ]",
        "  %enough = icmp uge i64 %k, %threads",
        "  br i1 %enough, label %begin, label %wake",
        "wake:",
        "  %held = atomicrmw add ptr %holders, i64 1 acq_rel",
        "  %no.thread = call ptr %plan(ptr %given)",
        "  %planned.well = icmp eq ptr %no.thread, null",
        "  br i1 %planned.well, label %planned, label %refused",
        "planned:",
        "  %k.next = add i64 %k, 1",
        "  br label %another",
        "refused:",
        "  %back = atomicrmw sub ptr %holders, i64 1 acq_rel",
        "  call void @forget(ptr %api, ptr %no.thread)",
        "  br label %begin",
    ]


def _forget() -> str:
    """LLVM text of `@forget`, which destroys an error of XLA's, if there is one."""
    kind = "XLA_FFI_Error_Destroy_Args"
    lines = _TextLines(
        [
            "define internal void @forget(ptr %api, ptr %error) {",
            "entry:",
            f"  %given = alloca [{SIZES[kind]} x i8], align 8",
            "  %fine = icmp eq ptr %error, null",
            "  br i1 %fine, label %done, label %drop",
            "drop:",
        ]
    )
    lines.fill(kind, "%given", error="%error")
    lines.field("destroy", "ptr", "%api", OFFSETS["XLA_FFI_Api"]["XLA_FFI_Error_Destroy"])
    lines += ["  call void %destroy(ptr %given)", "  br label %done", "done:", "  ret void", "}"]
    return "\n".join(lines)


def _work(arguments: tuple[Argument, ...], real: Real, loop: int, x86: bool) -> str:
    """LLVM text of the function that takes parts of the work until none is left, with the processor
    in its usual mode."""
    count, axes = len(arguments), sum(len(argument.shape) for argument in arguments)
    lines = _TextLines(
        [
            "define internal void @parts(ptr %work) {",
            "entry:",
            f"  %data = alloca [{count} x ptr], align 16",
            f"  %dims = alloca [{1 + axes} x i64], align 16",
            f"  %steps = alloca [{count + axes} x i64], align 16",
        ]
    )
    if x86:
        lines += [
            "  %flags = alloca i32, align 4",
            "  %modes = alloca i32, align 4",
            "  call void @llvm.x86.sse.stmxcsr(ptr %flags)",
            f"  store i32 {_MODES}, ptr %modes, align 4",
            "  call void @llvm.x86.sse.ldmxcsr(ptr %modes)",
        ]
    _read_arrays(lines, arguments, real)
    for name, offset in (("all", _PARTS), ("in.row", _IN_ROW), ("size", _SIZE), ("inner", _INNER)):
        lines.field(name, "i64", "%work", offset)
    lines += [
        f"  %next.at = getelementptr i8, ptr %work, i64 {_NEXT}",
        f"  %left.at = getelementptr i8, ptr %work, i64 {_LEFT}",
        "  br label %take",
        "take:",
        "  %part = atomicrmw add ptr %next.at, i64 1 acq_rel",
        "  %some = icmp ult i64 %part, %all",
        "  br i1 %some, label %run, label %done",
        "run:",
        "  %row = udiv i64 %part, %in.row",
        "  %in = urem i64 %part, %in.row",
        "  %start = mul i64 %in, %size",
        "  %rest = sub i64 %inner, %start",
        "  %last = icmp ult i64 %rest, %size",
        "  %n = select i1 %last, i64 %rest, i64 %size",
        "  store i64 %n, ptr %dims, align 8",
    ]
    for k in range(count):
        lines += [
            f"  %down{k} = mul i64 %row, %shift{k}",
            f"  %along{k} = mul i64 %start, %step{k}",
            f"  %moved{k} = add i64 %down{k}, %along{k}",
            f"  %now{k} = getelementptr i8, ptr %base{k}, i64 %moved{k}",
        ]
        lines.put("ptr", f"%now{k}", "%data", 8 * k)
    lines += [
        f"  %loop = inttoptr i64 {loop} to ptr",
        "  call void %loop(ptr %data, ptr %dims, ptr %steps, ptr null)",
        "  %before = atomicrmw sub ptr %left.at, i64 1 acq_rel",
        "  br label %take",
        "done:",
        *(["  call void @llvm.x86.sse.ldmxcsr(ptr %flags)"] if x86 else []),
        "  ret void",
        "}",
    ]
    return "\n".join(lines)


def _read_arrays(lines: _TextLines, arguments: tuple[Argument, ...], real: Real) -> None:
    """Emit lines that read each array's address and distance between samples, and sizes and strides
    of its core."""
    count, axis = len(arguments), 0
    for k, argument in enumerate(arguments):
        lines.field(f"base{k}", "ptr", "%work", _BASES + 8 * k)
        step = lines.field(f"step{k}", "i64", "%work", _BASES + 8 * (count + k))
        lines.field(f"shift{k}", "i64", "%work", _BASES + 8 * (2 * count + k))
        lines.put("i64", step, "%steps", 8 * k)
        size = real.size * argument.size
        for length in argument.shape:
            size //= length
            lines.put("i64", length, "%dims", 8 * (1 + axis))
            lines.put("i64", size, "%steps", 8 * (count + axis))
            axis += 1
