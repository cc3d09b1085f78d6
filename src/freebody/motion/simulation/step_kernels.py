"""Steps of a simulation with the course of the torque inside: a line over time, or a compiled law
of time and state. Friction is part of them: smooth, its width being an input, or dry, with the
senses in which it acts; with stops, some coordinates are held."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

from freebody.algorithms import simulation_steps
from freebody.algorithms.crba import bias
from freebody.algorithms.kinematics import position_rates
from freebody.algorithms.regrouped_parameters import lightened
from freebody.algorithms.simulation_steps import (
    HeldMotion,
    Law,
    Linearised,
    drags,
    held_motion,
    with_senses,
    with_signs,
)
from freebody.any_chain.kernel_options import chosen_option
from freebody.dual import Dual, slopes, value
from freebody.elementary import Scalar, maximum, tanh
from freebody.errors import SingularError
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.formulas.dynamics import forward
from freebody.kernels.formulas.record import external
from freebody.kernels.structural import Bound, Over, fetch_own
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.program import Argument, Program, trace
from freebody.program.program import evaluated
from freebody.spatial import Vector, add, identity, scale, sub

STATE = ("t", "q", "qd")
"""Inputs of a law that the step gives it; all others are given to the step."""


@dataclass(frozen=True)
class StepMethod:
    """A method with fixed steps.

    formula: the kernel whose method it is. order: of its error. implicit: whether it is stable
    however stiff the drives are. reach: of an explicit method, step times decay rate up to which it
    is stable. friction: what it takes for c sign(q̇), width to be filled in.
    """

    formula: str
    order: int
    implicit: bool
    reach: float
    friction: str


STEP_METHODS = {
    "rk4": StepMethod("rk4_step", 4, False, 2.78, "c tanh(q̇ / {width:g})"),
    "semi-implicit": StepMethod("semi_implicit_step", 1, False, 2.0, "c tanh(q̇ / {width:g})"),
    "implicit": StepMethod("implicit_step", 2, True, float("inf"), "c q̇ / √(q̇² + {width:g}²)"),
}

StepTorque = Callable[[float, Vector, Vector], Vector]
"""(part of the step that has passed, q, q̇) -> torque."""

FrameWrenches = tuple[Vector, ...]


def driven_step(
    model: Model,
    method: str,
    wrench_frames: Sequence[str] = (),
    varying: Sequence[bool] = (),
    law: Program | None = None,
    adds: bool = False,
    holds: bool = False,
    dry: bool = False,
) -> Bound:
    """The kernel (q, qd, h, width, t, …) -> (q1, qd1) of a step of length h from time t on.

    Then follow, without a law, two torques (nv,) and which parts of the way from the one to the
    other the step begins and ends at (2,), else the law's inputs besides `STATE` in its order;
    then, where it `adds` another line of torques, the same of that; then, where the step `holds`
    coordinates, the signs that stand for those of the rates in friction that is `dry` (nv,), and
    which coordinates are held (nv,), 1 or 0; then the wrenches, of one that is `varying` two and
    the parts, like the torques. width: of smooth friction. With the model's numbers as last input,
    as in `structural.fetch`.
    """
    record = STEP_METHODS[method]
    takes = _StepInputs(model, law, adds, holds, dry, tuple(varying))
    option = _option(model, record.formula, wrench_frames)
    reached = (Argument("q1", (model.nq,)), Argument("qd1", (model.nv,)))

    def evaluate(tree: Tree, *scalars: Any) -> tuple[Any, ...]:
        (q, qd, h, width), (torque, held, loads) = scalars[:4], takes.split(scalars)
        step = _DrivenStep(tree, option, method, width, torque, loads, dry, *held)
        end = step.implicit(q, qd, h) if record.implicit else step.explicit(q, qd, h)
        return simulation_steps.on_loops(tree, q, end, option.equations)

    key = ("driven step", method, *takes.key)
    return _fetched(model, key, option, evaluate, takes.inputs, reached)


def driven_rates(
    model: Model,
    wrench_frames: Sequence[str],
    varying: Sequence[bool],
    law: Program | None,
    adds: bool = False,
    dry: bool = False,
) -> Bound:
    """The kernel of accelerations at a state with held coordinates: inputs of a step -> (q̈ (nv,),
    holding torques (nv,), M (nv, nv), size of dry friction (nv,))."""
    takes = _StepInputs(model, law, adds, True, dry, tuple(varying))
    option, nv = _option(model, "rk4_step", wrench_frames), model.nv
    found = (Argument("qdd", (nv,)), Argument("reaction", (nv,)), Argument("M", (nv, nv)))
    found += (Argument("drag", (nv,)),)

    def evaluate(tree: Tree, *scalars: Any) -> tuple[Any, ...]:
        (q, qd, _, width), (torque, held, loads) = scalars[:4], takes.split(scalars)
        step = _DrivenStep(tree, option, "rk4", width, torque, loads, dry, *held)
        return *step.rates(q, qd), drags(tree, q, qd) if dry else (0.0,) * nv

    key = ("driven rates", *takes.key)
    return _fetched(model, key, option, evaluate, takes.inputs, found)


def smooth_kernel(model: Model, name: str, wrench_frames: Sequence[str] = ()) -> Bound:
    """The kernel (q, qd, tau or q̈, width, wrenches…) of forward or inverse dynamics with smoothed
    signs of rates, for robots with lossy joints; for others friction can be added outside."""
    evaluated_by, last, found = {
        "forward_dynamics": (forward, "tau", "qdd"),
        "inverse_dynamics": (FORMULAS["inverse_dynamics"].evaluate, "qdd", "tau"),
    }[name]
    nv, size = model.nv, 6 if model.dim == 3 else 3
    option = chosen_option(model, name, wrench_frames=wrench_frames, function="simulate")[1]
    taken = (
        Argument("q", (model.nq,)),
        Argument("qd", (nv,)),
        Argument(last, (nv,)),
        Argument("width", (), uniform=True),
        *(Argument(f"wrench{k}", (size,)) for k in range(len(wrench_frames))),
    )

    def evaluate(tree: Tree, q: Vector, qd: Vector, given: Vector, width: Scalar, *loads: Vector):
        rubbing = with_signs(tree, lambda rate: tanh(rate / width))
        return evaluated_by(rubbing, option, q, qd, given, loads)

    key = ("smooth dynamics", name)
    return _fetched(model, key, option, evaluate, taken, (Argument(found, (nv,)),))


def _option(model: Model, formula: str, wrench_frames: Sequence[str]) -> Option:
    return chosen_option(model, formula, wrench_frames=wrench_frames, function="simulate")[1]


@dataclass(frozen=True)
class _StepInputs:
    """The inputs of a step's kernel other than the model's numbers."""

    model: Model
    law: Program | None
    adds: bool
    holds: bool
    dry: bool
    varying: tuple[bool, ...]

    @property
    def key(self) -> tuple[str, ...]:
        """The part of a kernel's key that depends on these inputs."""
        law = self.law.digest if self.law else ""
        flags = self.adds, self.holds, self.dry, *self.varying
        return law, str(flags)

    @property
    def own(self) -> tuple[Argument, ...]:
        """The inputs that determine the torque: the ends of a straight line, or those of a law
        other than `STATE`."""
        if self.law is None:
            return _line_of("", self.model.nv)
        return tuple(x for x in self.law.inputs if x.name not in STATE)

    @property
    def inputs(self) -> tuple[Argument, ...]:
        """All inputs of a step's kernel, in order."""
        nv, size = self.model.nv, 6 if self.model.dim == 3 else 3
        return (
            Argument("q", (self.model.nq,)),
            Argument("qd", (nv,)),
            Argument("h", ()),
            Argument("width", (), uniform=True),
            Argument("t", ()),
            *(Argument(f"given{k}", x.shape) for k, x in enumerate(self.own)),
            *(_line_of("added", nv) if self.adds else ()),
            *(Argument(name, (nv,)) for name in ("senses", "held") if self.holds),
            *(
                x
                for k, varies in enumerate(self.varying)
                for x in (
                    _line_of(f"wrench{k}", size) if varies else [Argument(f"wrench{k}", (size,))]
                )
            ),
        )

    def split(
        self, scalars: Sequence[Any]
    ) -> tuple[StepTorque, Sequence[Vector], Callable[[float], FrameWrenches]]:
        """The torque, the senses of friction with the held coordinates, and the wrenches, from the
        scalars of all inputs."""
        _, _, h, _, t, *rest = scalars
        more = iter(rest)
        own = [*islice(more, len(self.own))]
        torque = _of_law(self.law, t, h, own) if self.law else _of_line(*own)
        if self.adds:
            torque = _sum(torque, _of_line(*islice(more, 3)))
        held = [*islice(more, 2)] if self.holds else ()
        return torque, held, _loads(self.varying, [*more])


def _fetched(
    model: Model,
    key: tuple[str, ...],
    option: Option,
    evaluate: Callable[..., tuple[Any, ...]],
    taken: tuple[Argument, ...],
    found: tuple[Argument, ...],
) -> Bound:
    """The kernel of a function of the tree and of further inputs, compiled on first use."""

    def made(p: Argument, over: Over) -> Program:
        def whole(*scalars: Any) -> tuple[Any, ...]:
            *given, numbers = scalars
            return evaluate(lightened(over(numbers)), *given)

        try:
            return trace("_".join(key[0].split()), whole, (*taken, p), found)
        except ZeroDivisionError:
            raise SingularError(
                f"simulate: {model.name!r} or its torque divides by zero in every state."
            ) from None

    return fetch_own(model, key, option, made)


def _line_of(name: str, size: int) -> tuple[Argument, ...]:
    """The inputs of a straight line: its two ends, and the fractions at which a step begins and
    ends."""
    ends = (Argument(f"{name}{end}", (size,)) for end in ("first", "last"))
    return *ends, Argument(f"{name}parts", (2,))


def _line(first: Vector, last: Vector, parts: Vector) -> Callable[[float], Vector]:
    """The straight line between two vectors as a function of the fraction of the step; parts: the
    fractions of the line at the step's ends."""
    begin, end = parts

    def at(part: float) -> Vector:
        way = begin + part * (end - begin) if 0.0 < part < 1.0 else parts[int(part)]
        return add(first, scale(way, sub(last, first)))

    return at


def _of_line(*own: Vector) -> StepTorque:
    line = _line(*own)
    return lambda part, q, qd: line(part)


def _sum(one: StepTorque, other: StepTorque) -> StepTorque:
    return lambda part, q, qd: add(one(part, q, qd), other(part, q, qd))


def _loads(varying: Sequence[bool], given: Sequence[Vector]) -> Callable[[float], FrameWrenches]:
    """The wrenches on frames as a function of the fraction of the step; varying: which of them are
    straight lines."""
    rest = iter(given)
    lines = [_line(*islice(rest, 3)) if varies else next(rest) for varies in varying]
    return lambda part: tuple(x(part) if callable(x) else x for x in lines)


def _of_law(law: Program, t: Scalar, h: Scalar, own: Sequence[Any]) -> StepTorque:
    def at(part: float, q: Vector, qd: Vector) -> Vector:
        state = {"t": t + part * h if part else t, "q": q, "qd": qd}
        (tau,) = evaluated(law, law_inputs(law, state, own))
        return tau

    return at


def both_laws(law: Program, other: Program) -> Program:
    """The program of the sum of two laws, the second of which has no inputs but `STATE`."""
    taken = {x.name: x for x in (*law.inputs, *other.inputs)}

    def tau(*scalars: Any) -> tuple[Vector]:
        given = dict(zip(taken, scalars, strict=True))
        (one,), (more,) = (evaluated(x, [given[i.name] for i in x.inputs]) for x in (law, other))
        return (add(one, more),)

    return trace("both_laws", tau, tuple(taken.values()), law.outputs)


def law_inputs(law: Program, state: Mapping[str, Any], own: Sequence[Any]) -> list[Any]:
    """The inputs of a law in its order: t, q and qd by name, the others in the order given."""
    rest = iter(own)
    return [state[x.name] if x.name in state else next(rest) for x in law.inputs]


@dataclass(frozen=True)
class _DrivenStep:
    """A step with everything that drives it: width of smooth friction, torque and wrenches; and
    where friction is dry, its senses and the held coordinates."""

    tree: Tree
    option: Option
    method: str
    width: Scalar
    torque: StepTorque
    loads: Callable[[float], FrameWrenches]
    dry: bool = False
    senses: Vector = ()
    held: Vector = ()

    @property
    def rubbing(self) -> Tree:
        """The tree in which smooth or given signs replace those of its rates."""
        if self.dry:
            return with_senses(self.tree, self.senses, self._smooth)
        return with_signs(self.tree, self._smooth)

    def _smooth(self, rate: Scalar) -> Scalar:
        return tanh(rate / self.width)

    def explicit(self, q: Vector, qd: Vector, h: Scalar) -> simulation_steps.MotionState:
        rk4 = self.method == "rk4"
        advance = simulation_steps.runge_kutta if rk4 else simulation_steps.semi_implicit
        return advance(self.tree, q, qd, h, self._holding if self.held else self._free)

    def implicit(self, q: Vector, qd: Vector, h: Scalar) -> simulation_steps.MotionState:
        def on_bodies(part: float, q: Vector) -> Any:
            return external(self.tree, self.option, q, self.loads(part))

        law, counting = _linearised(self.tree, self.torque), self.option.equations
        return simulation_steps.implicit(self.tree, q, qd, h, on_bodies, law, counting, self.width)

    def rates(self, q: Vector, qd: Vector, part: float = 0.0) -> HeldMotion:
        """Accelerations and reactions in a state, at a fraction of the step."""
        loads = external(self.tree, self.option, q, self.loads(part))
        forces = sub(self.torque(part, q, qd), bias(self.rubbing, q, qd, loads))
        return held_motion(self.tree, q, forces, self.held)

    def _holding(self, part: float, q: Vector, qd: Vector) -> Vector:
        return self.rates(q, qd, part).qdd

    def _free(self, part: float, q: Vector, qd: Vector) -> Vector:
        tau = self.torque(part, q, qd)
        return forward(self.rubbing, self.option, q, qd, tau, self.loads(part))[0]


def _linearised(tree: Tree, torque: StepTorque) -> Law:
    """The torque at the end of a stage, linearised about the state at its beginning: with the
    slopes of each joint's torque by its own position and rate, as far as they resist motion."""
    nv = tree.nv

    def at(start: float, end: float, q: Vector, qd: Vector) -> Linearised:
        along = [position_rates(tree, q, unit) for unit in identity(nv)]
        seeded = tuple(Dual(x, {k: along[k][i] for k in range(nv)}) for i, x in enumerate(q))
        rates = tuple(Dual(x, {nv + k: 1.0}) for k, x in enumerate(qd))
        found = torque(end, seeded, rates)
        rows = [slopes(x, 2 * nv) for x in found]
        moving = tuple(_times(row[:nv], qd) for row in rows)
        stiffness = tuple(maximum(-row[k], 0.0) for k, row in enumerate(rows))
        damping = tuple(maximum(-row[nv + k], 0.0) for k, row in enumerate(rows))
        return Linearised(tuple(map(value, found)), scale(-1.0, moving), stiffness, damping)

    return at


def _times(row: Sequence[Scalar], qd: Vector) -> Scalar:
    total: Scalar = 0.0
    for slope, rate in zip(row, qd, strict=True):
        total = total + slope * rate
    return total
