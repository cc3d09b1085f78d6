"""The step that lists the arm's vectors: what every later equation multiplies."""

from __future__ import annotations

from freebody.elementary import Scalar
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import vec
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting


def geometry(setting: Setting, rotations: bool = False, inertias: bool = True) -> Step:
    """Vectors along the bodies, directions of the joints, in space also inertias and, if asked for,
    rotations."""
    lines: list[Equation] = []
    for i in setting.order:
        lines += _vectors(setting, i)
        if not setting.planar:
            lines += _in_space(setting, i, rotations)
        lines += measured(setting, i, inertias)
    reach = (
        "s_i points from joint i to the next joint (or the tip), "
        "s_ci from joint i to the centre of mass of body i"
    )
    if setting.planar:
        slides = any(map(setting.slides, setting.order))
        along = ", and u_i is the direction in which joint i slides" if slides else ""
        reason = f"{reach}{along}; components are along x and y."
    else:
        turned = "; R takes components from one body's axes to another's" if rotations else ""
        if setting.weighs and not rotations:
            turned = ", and so is gravity, R turning it from the world's axes"
        still = (
            "each is given in the axes of body i, in which it does not change unless a joint slides"
        )
        reason = f"{reach}; {still}{turned}."
    return Step("The vectors", reason, tuple(lines), figure="vectors")


def _vectors(s: Setting, i: int) -> list[Equation]:
    children = s.tree.children(i)
    lines = [eq(s.reach_name(i, k), s.column(s.to_child(i, k))) for k in children]
    if s.loaded(i):
        lines.append(eq(s.tip_name(), s.column(s.to_tip(i))))
    if i in s.weighted:
        lines.append(eq(s.centre_name(i), s.column(s.centre(i))))
    if not s.turns(i) or not s.planar:
        lines.append(eq(s.axis_name(i), s.column(s.axis(i))))
    return lines


def measured(s: Setting, i: int, inertia: bool) -> list[Equation]:
    """The mass of body i and, if asked for, its inertia, where these are numbers; in space the
    matrix of the inertia anyway."""
    if i not in s.weighted:
        return []
    rows = [(s.mass_name(i), s.show(s.mass(i)))]
    if inertia and not s.is_point(i):
        value = s.show(s.inertia(i)) if s.planar else _matrix(s, s.inertia(i))
        rows.append((s.inertia_name(i), value))
    names = set(s.symbols.ring.names)
    return [
        eq(name, value)
        for name, value in rows
        if isinstance(value, ex.Matrix) or not (isinstance(name, ex.Symbol) and name.name in names)
    ]


def _in_space(s: Setting, i: int, rotations: bool) -> list[Equation]:
    lines = []
    if rotations:
        R = s.motion.joints[i][0]
        back = [[R[c][r] for c in range(3)] for r in range(3)]
        lines.append(eq(rotation_name(s, s.tree.bodies[i].parent, i), _matrix(s, back)))
    elif s.weighs:
        field = ex.mul(rotation_name(s, -1, i), vec("g"))
        lines.append(eq(field, s.column(s.gravity(i))))
    return lines


def rotation_name(s: Setting, source: int, target: int) -> ex.Symbol:
    """R^target_source, which takes components from the axes of one body to those of another."""
    a, b = s.numbers[source], s.numbers[target]
    return ex.Symbol(f"R{a}_{b}", "R", (str(a),), high=str(b))


def _matrix(s: Setting, rows: list[list[Scalar]] | tuple) -> Expression:
    return ex.matrix([[s.show(x) for x in row] for row in rows])


def moment_of(force: Expression, arm: Expression) -> Expression:
    """arm × force, their signs in front."""
    for x, rest in ((force, arm), (arm, force)):
        if isinstance(x, ex.Negative):
            one, other = (x.operand, rest) if x is force else (rest, x.operand)
            return ex.neg(moment_of(one, other))
    return ex.cross(arm, force)
