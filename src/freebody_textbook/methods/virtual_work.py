"""The generalized forces of a load on the tip, by virtual work."""

from __future__ import annotations

from freebody.expressions import expression as ex
from freebody.expressions.expression import eq
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.printed_names import sym, vec
from freebody.scalars.trig import Trig
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting


def virtual_work(s: Setting) -> tuple[Step, dict[int, Trig]]:
    """The step, and what the load adds to the force along each coordinate: f · ∂r_P/∂q_i."""
    tip = [s.symbols.element(x) for x in s.tip_position()]
    lines = [
        eq(vec("f"), ex.Vector(tuple(map(sym, s.load)))),
        eq(vec("r_P"), s.column(tuple(tip))),
    ]
    works: dict[int, Trig] = {}
    for i in s.leaders:
        x = s.coordinate(i)
        works[i] = inner([position.derivative(x) for position in tip], s.load_components, s.symbols)
        part = ex.dot(vec("f"), ex.partial(vec("r_P"), x))
        motor = s.motor(i)
        lines.append(eq(f"Q{s.index(i) + 1}", ex.add(motor, part), ex.add(motor, s.show(works[i]))))
    reason = (
        "The work of motors and load in a small change of the coordinates, Σ τ_i δq_i + f · δr_P, "
        "is Σ Q_i δq_i: the load adds its component along the direction in which each coordinate "
        "moves the tip."
    )
    return Step("Generalized forces by virtual work", reason, tuple(lines)), works
