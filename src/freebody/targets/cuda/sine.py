"""LLVM text of the sine and cosine of one number, for a machine whose threads branch each for
itself."""

from __future__ import annotations

from freebody.targets.llvm.lanes import DOUBLE, Lanes
from freebody.targets.llvm.sincos import LARGEST, VectorCode


def sincos(lanes: Lanes) -> str:
    """`{ double, double } @sincos.f64(double x)`: both, as on the CPU; a large argument goes
    through `@reduce`.

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
