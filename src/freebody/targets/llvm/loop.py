"""LLVM text of the gufunc loop: groups of samples in, `@compute` on a tile of slots, groups out.

Results of one round go out after the inputs of the next one have come in, from tiles of their own:
the processor computes while its stores wait for the memory.

A tile holds one vector of lanes for each slot: lane l of slot j is scalar j of sample l. How an
argument gets there and back is chosen when the loop begins, see `sample_transfers`.

The last group may be short. Its surplus lanes take the addresses of its last sample, on the way in
and on the way out: the same code runs, the same bits come out, and the last row is written more
than once with the same values.
"""

from __future__ import annotations

from freebody.program.program import Program
from freebody.program.segments import SegmentedProgram
from freebody.targets.llvm.argument_access import access
from freebody.targets.llvm.machine import Machine
from freebody.targets.llvm.rounds import rounds
from freebody.targets.llvm.sample_transfers import check_slots, integers, transfers
from freebody.targets.llvm.uniform import one_by_one


def gufunc_loop(
    program: Program,
    every: Program,
    machine: Machine,
    layout: SegmentedProgram,
    tiles: int,
    shared: SegmentedProgram | None,
) -> str:
    """`void @kernel(ptr args, ptr dims, ptr steps, ptr data)` and what it calls.

    A round takes `tiles` groups, each on a tile of its own.

    Args:
        program: the whole program, whose arguments come in.
        every: what is computed for every sample (see `hoist`), on tiles of `layout`.
        machine: what it is compiled for, as far as the text depends on it.
        tiles: groups in a round.
        shared: where the uniform numbers are, and what is computed of them once; None if there are
            none.
    """
    parts = [
        transfers(program, every, layout, machine.lanes),
        _loop(program, machine, layout, tiles, shared),
        one_by_one(program) if shared else "",
        FLAGS[machine.x86]["declare"],
        "declare ptr @malloc(i64)\ndeclare void @free(ptr)\n",
    ]
    return "\n".join(parts)


_LARGEST_ON_STACK = 2**16

# NumPy turns floating-point flags into warnings; NaN in, NaN out is no reason to warn, and surplus
# lanes set them too
FLAGS = {
    True: {
        "save": "  %flags = alloca i32, align 4\n  call void @llvm.x86.sse.stmxcsr(ptr %flags)",
        "restore": "  call void @llvm.x86.sse.ldmxcsr(ptr %flags)",
        "declare": "declare void @llvm.x86.sse.stmxcsr(ptr)\n"
        "declare void @llvm.x86.sse.ldmxcsr(ptr)\n",
    },
    False: {
        "save": "",
        "restore": "  %cleared = call i32 @feclearexcept(i32 31)",
        "declare": "declare i32 @feclearexcept(i32)\n",
    },
}


def _loop(
    program: Program,
    machine: Machine,
    layout: SegmentedProgram,
    tiles: int,
    shared: SegmentedProgram | None,
) -> str:
    """The uniform numbers, then rounds of `tiles` groups: all in, those of the round before out,
    `@compute`."""
    lanes, checks = machine.lanes, check_slots(program, layout)
    arguments, slots = program.inputs + program.outputs, layout.slots + len(checks)
    tile, addresses = lanes.size * slots * tiles, 8 * machine.width * len(arguments)
    get, give_back = _workspace(
        {
            "tile.a": tile,
            "tile.b": tile,
            "lanes": addresses,
            "lanes.short": addresses,
            "offsets": 8 * sum(argument.size for argument in arguments),
            "uniform": lanes.real.size * (shared.slots + 1) if shared else 0,
        }
    )
    lines = [
        f"define {'internal void @loop' if shared else 'void @kernel'}"
        "(ptr %args, ptr %dims, ptr %steps, ptr %data) #0 {",
        "entry:",
        "  %n = load i64, ptr %dims, align 8",
        FLAGS[machine.x86]["save"],
        *get,
        *access(arguments, lanes),
    ]
    if shared:
        lines.append("  call void @uniform.finite(ptr %uniform)\n  call void @once(ptr %uniform)")
    lines += [
        *rounds(program, lanes, slots, tiles, checks),
        *give_back,
        FLAGS[machine.x86]["restore"],
        "  ret void",
        "}",
        *(f"@shape{k} = internal constant {integers(x.shape)}" for k, x in enumerate(arguments)),
        "",
    ]
    return "\n".join(lines)


def _workspace(sizes: dict[str, int]) -> tuple[list[str], list[str]]:
    """Named places of `sizes` bytes, and what gives the room back.

    It is on the stack unless it is large: threads may have little of it.
    """
    total, places = 0, []
    for name, size in sizes.items():
        places.append(f"  %{name} = getelementptr i8, ptr %room, i64 {total}")
        total += size
    if total <= _LARGEST_ON_STACK:
        return [f"  %room = alloca [{total} x i8], align 64", *places], []
    get = f"""\
  %raw = call ptr @malloc(i64 {total + 64})
  %raw.number = ptrtoint ptr %raw to i64
  %odd = and i64 %raw.number, 63
  %up = sub i64 64, %odd
  %room = getelementptr i8, ptr %raw, i64 %up"""
    return [get, *places], ["  call void @free(ptr %raw)"]
