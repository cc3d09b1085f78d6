"""LLVM text of the function that XLA calls: it takes a call frame apart, and has a kernel's loop
run.

Buffers come as (outer, inner, *core), each of the two leading sizes 1 or that of the outputs; where
it is 1, the one value serves all. A call of the loop takes entries of the inner axis, so that what
is uniform there may change along the outer one.
"""

from __future__ import annotations

from freebody.program.program import Argument, Program
from freebody.targets.llvm.lanes import Real
from freebody.targets.xla.layout import NUMBERS, OFFSETS, SIZES
from freebody.targets.xla.thread_sharing import BASES, TextLines, sharing, size_of

_REFUSED = "freebody: a call that is laid out in another way than the interface's version says."
_NUMBER = {"float64": NUMBERS["XLA_FFI_DataType_F64"], "float32": NUMBERS["XLA_FFI_DataType_F32"]}


def text(
    program: Program, real: Real, loop: int, x86: bool, version: tuple[int, int], each: int
) -> str:
    """`ptr @xla(ptr frame)`: null, or XLA's error.

    loop: address of `void loop(ptr args, ptr dims, ptr steps, ptr data)` of the program's kernel,
    for any batch. version: of the interface, which XLA asks for. each: samples that a thread is
    woken for.
    """
    arguments = (*program.inputs, *program.outputs)
    lines = TextLines(["define ptr @xla(ptr %frame) {", "entry:"])
    _asked(lines, version)
    _counted(lines, program)
    right = [_right(lines, k, argument, real) for k, argument in enumerate(arguments)]
    lines.append(f"  br i1 {lines.all('right', right)}, label %sized, label %refuse\nsized:")
    _sizes(lines, arguments, len(program.inputs), real)
    _refused(lines)
    words = "".join(f"\\{byte:02X}" for byte in _REFUSED.encode() + b"\0")
    lines.append(f'@message = private constant [{len(_REFUSED) + 1} x i8] c"{words}"')
    return "\n".join([*lines, sharing(arguments, real, loop, x86, each), ""])


def _asked(lines: TextLines, version: tuple[int, int]) -> None:
    """Lines that describe the function to XLA, where it asks with an extension of the frame."""
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


def _counted(lines: TextLines, program: Program) -> None:
    """Lines that look whether the frame is of the known layout and has as many buffers as the
    program; then the lists of them."""
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


def _right(lines: TextLines, k: int, argument: Argument, real: Real) -> str:
    """Whether buffer k has numbers of the right type and as many axes as are expected."""
    buffer = OFFSETS["XLA_FFI_Buffer"]
    dtype = lines.field(f"dtype{k}", "i32", f"%buffer{k}", buffer["dtype"])
    rank = lines.field(f"rank{k}", "i64", f"%buffer{k}", buffer["rank"])
    typed = lines.equal(f"typed{k}", "i32", dtype, _NUMBER[real.dtype])
    ranked = lines.equal(f"ranked{k}", "i64", rank, 2 + len(argument.shape))
    return lines.all(f"fits{k}", [typed, ranked])


def _sizes(lines: TextLines, arguments: tuple[Argument, ...], inputs: int, real: Real) -> None:
    """Lines that read where the buffers are, bytes between samples along both axes, and how many
    there are; then all is computed."""
    buffer, count = OFFSETS["XLA_FFI_Buffer"], len(arguments)
    lines.append(f"  %work.new = call ptr @malloc(i64 {size_of(count)})")
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
        lines.put("ptr", base, "%work.new", BASES + 8 * k)
        lines.put("i64", f"%step{k}", "%work.new", BASES + 8 * (count + k))
        lines.put("i64", f"%shift{k}", "%work.new", BASES + 8 * (2 * count + k))
    lines.append(
        f"  call void @share(ptr %frame, ptr %work.new, i64 %outer{inputs}, i64 %inner{inputs})\n  "
        f"ret ptr null"
    )


def _refused(lines: TextLines) -> None:
    """Return an error of XLA's."""
    given, kind = OFFSETS["XLA_FFI_Error_Create_Args"], "XLA_FFI_Error_Create_Args"
    lines.append("refuse:\n  %problem = alloca [32 x i8], align 8")
    lines.put("i64", SIZES[kind], "%problem", given["struct_size"])
    lines.put("ptr", "null", "%problem", given["extension_start"])
    lines.put("ptr", "@message", "%problem", given["message"])
    lines.put("i32", NUMBERS["XLA_FFI_Error_Code_INTERNAL"], "%problem", given["errc"])
    api = lines.field("api", "ptr", "%frame", OFFSETS["XLA_FFI_CallFrame"]["api"])
    create = lines.field("create", "ptr", api, OFFSETS["XLA_FFI_Api"]["XLA_FFI_Error_Create"])
    lines.append(f"  %error = call ptr {create}(ptr %problem)\n  ret ptr %error\n}}")
