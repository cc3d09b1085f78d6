"""What this core could do at best: the rate at which it finishes independent vector
multiplications."""

import ctypes
import time

import llvmlite.binding as llvm

CHAINS = 12  # independent of each other, so that latency is hidden; they fit into 16 registers
STEPS = 4_000_000
COST = {
    "sin": 17,
    "cos": 17,
    "div": 8,
    "sqrt": 8,
}  # as many multiplications; everything else counts as one


def _multiplications(width: int) -> str:
    """CHAINS chains of x = x * x. LLVM may not shorten one, since every product is rounded."""
    vector = f"<{width} x double>"
    lines = [
        "define void @chains(i64 %n, ptr %out) {",
        "start:",
        "  br label %loop",
        "loop:",
        "  %i = phi i64 [ 0, %start ], [ %next, %loop ]",
    ]
    lines += [
        f"  %x{c} = phi {vector} [ zeroinitializer, %start ], [ %y{c}, %loop ]"
        for c in range(CHAINS)
    ]
    lines += [f"  %y{c} = fmul {vector} %x{c}, %x{c}" for c in range(CHAINS)]
    lines += [
        "  %next = add i64 %i, 1",
        "  %more = icmp ult i64 %next, %n",
        "  br i1 %more, label %loop, label %end",
        "end:",
    ]
    for c in range(CHAINS):
        lines += [
            f"  %p{c} = getelementptr {vector}, ptr %out, i64 {c}",
            f"  store {vector} %y{c}, ptr %p{c}, align 8",
        ]
    return "\n".join([*lines, "  ret void", "}"])


def multiplications_per_ns(width: int) -> float:
    """How many vector multiplications of `width` lanes one core finishes in a nanosecond."""
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine(
        cpu=llvm.get_host_cpu_name(), features=llvm.get_host_cpu_features().flatten(), opt=3
    )
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(_multiplications(width)), machine)
    engine.finalize_object()
    chains = ctypes.CFUNCTYPE(None, ctypes.c_int64, ctypes.c_void_p)(
        engine.get_function_address("chains")
    )
    out = (ctypes.c_double * (width * CHAINS))()
    best = float("inf")
    for _ in range(5):
        start = time.perf_counter()
        chains(STEPS, out)
        best = min(best, time.perf_counter() - start)
    return STEPS * CHAINS / (best * 1e9)


def nanoseconds_a_sample(operations: dict[str, int], width: int, rate: float) -> float:
    """The time of a program's arithmetic, `width` samples at once, if the core never had to
    wait."""
    return sum(COST.get(op, 1) * n for op, n in operations.items()) / (width * rate)
