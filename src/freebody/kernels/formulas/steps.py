"""One step of a simulation: a formula like any other, for a whole tree or closed chain."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from freebody.algorithms import simulation_steps
from freebody.algorithms.regrouped_parameters import lightened
from freebody.algorithms.rnea import External
from freebody.elementary import Scalar
from freebody.kernels.formulas.dynamics import forward
from freebody.kernels.formulas.record import Evaluation, Formula, Option, Output, external
from freebody.model.tree import Tree
from freebody.spatial import Vector


def _explicit(method: Callable[..., simulation_steps.MotionState]) -> Evaluation:
    """The evaluation of one simulation step by an explicit method, with torque and wrenches
    constant."""

    def evaluate(
        tree: Tree, o: Option, q: Vector, qd: Vector, tau: Vector, h: Scalar, wrenches: Any = ()
    ) -> tuple[Any, ...]:
        tree = lightened(tree)

        def acceleration(part: float, q: Vector, qd: Vector) -> Vector:
            return forward(tree, o, q, qd, tau, wrenches)[0]

        return simulation_steps.on_loops(tree, q, method(tree, q, qd, h, acceleration), o.equations)

    return evaluate


def _implicit(
    tree: Tree,
    o: Option,
    q: Vector,
    qd: Vector,
    tau: Vector,
    h: Scalar,
    wrenches: Any = (),
    **feedback: Vector,
) -> tuple[Any, ...]:
    def loads(part: float, q: Vector) -> list[External]:
        return external(tree, o, q, wrenches)

    tree = lightened(tree)
    if feedback:
        law = simulation_steps.Feedback(**feedback).law(tree, tau, h)
    else:
        law = simulation_steps.held(tau)
    reached = simulation_steps.implicit(tree, q, qd, h, loads, law, o.equations)
    return simulation_steps.on_loops(tree, q, reached, o.equations)


def _step(evaluate: Evaluation, *more: str) -> Formula:
    return Formula(
        ("q", "qd", "tau", "h", "wrenches", *more),
        {
            "q1": Output(("nq",), "positions at the end of the step, as q"),
            "qd1": Output(("nv",), "rates at the end of the step, as qd"),
        },
        evaluate,
        settled="equations",
    )


FORMULAS = {
    "semi_implicit_step": _step(_explicit(simulation_steps.semi_implicit)),
    "rk4_step": _step(_explicit(simulation_steps.runge_kutta)),
    "implicit_step": _step(_implicit),
    "implicit_feedback_step": _step(_implicit, "q_ref", "qd_ref", "kp", "kd"),
}
