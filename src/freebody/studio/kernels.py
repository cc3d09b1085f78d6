"""The kernels of a studio: what a page computes of one robot, a record each, for those robots that
have it, as JavaScript, with Python's own results by which a page proves itself before it offers
anything."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.algorithms.crba import factor
from freebody.algorithms.kinematics import jacobian
from freebody.algorithms.loop_constraints import onto_loops
from freebody.algorithms.singular_values import singular_values
from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.inverse.problem.numerical_solver import DescentStep, NumericalSolver
from freebody.inverse.problem.task import Task, row_names
from freebody.kernels.formulas import FORMULAS, Option
from freebody.lazy import cached_property
from freebody.loops.independent_equations import counting_equations
from freebody.model.model import Model
from freebody.motion.ranges import ranges
from freebody.moving.placements import NAME as PLACED
from freebody.moving.placements import placement_program
from freebody.outputs.pages import packed_numbers
from freebody.program import Argument, Program, trace
from freebody.spatial import scale
from freebody.targets.interpreter import BlockedFunction
from freebody.targets.text import LANGUAGES, SourceUnit
from freebody.trees.positions import random_state
from freebody.ways_out.kernel import QuantityRequest, requested


@dataclass(frozen=True)
class PageKernel:
    """A program that a page runs as the JavaScript function of its name."""

    name: str
    program: Program

    @property
    def script(self) -> str:
        """The function's JavaScript text: inputs, then outputs, all arrays but single numbers among
        the inputs."""
        return LANGUAGES["javascript-script"].emit(SourceUnit(self.program, self.name))

    def __call__(self, given: Mapping[str, Array]) -> tuple[Array, ...]:
        """The outputs for inputs by name, computed by NumPy."""
        found = BlockedFunction(self.program)(*(given[x.name] for x in self.program.inputs))
        return found if isinstance(found, tuple) else (found,)

    def proof(self, given: Mapping[str, Array]) -> dict[str, Any]:
        """Python's own results at several states as a page reads them: the sizes of inputs (0: a
        single number) and outputs, and the rows of all numbers, inputs first."""
        inputs, outputs = self.program.inputs, self.program.outputs
        columns = [_rows(x, given[x.name]) for x in inputs]
        columns += [_rows(x, y) for x, y in zip(outputs, self(given), strict=True)]
        return {
            "inputs": [x.size if x.shape else 0 for x in inputs],
            "outputs": [x.size for x in outputs],
            "rows": packed_numbers(np.concatenate(columns, axis=-1)),
        }


def _rows(argument: Argument, values: Array) -> Array:
    """Values of an argument, a row for each state."""
    return np.asarray(values, dtype=float).reshape(len(values), argument.size)


LOAD = "further_load"
_UNBOUNDED = 1e6  # rad or m: no limit, in kernels, whose numbers are finite
_STILL = 1e-9  # m or rad for each unit of a coordinate that does not move the tip
_LARGE = 10
"""Coordinates beyond which a step of four accelerations is too long for a page."""


@dataclass(frozen=True)
class Studied:
    """The robot of a studio, and what its kernels are of."""

    model: Model

    @property
    def tip(self) -> str | None:
        """The frame that is pulled and loaded; None where the robot has no single one."""
        return self.model.tip

    @property
    def arm(self) -> bool:
        """Whether the robot is an open chain with a tip, whose coordinates add up."""
        return self.tip is not None and not self.model.loops and self.model.nq == self.model.nv

    @cached_property
    def loaded(self) -> Model:
        """The robot with a further mass at the tip, which kernels take as an input."""
        if self.tip is None:
            return self.model
        return self.model.with_payload(1.0, frame=self.tip, name=LOAD)

    @cached_property
    def rows(self) -> tuple[int, ...]:
        """The rows of the tip's Jacobian by which nearness to singular poses is measured: the most
        of its motion that the joints can give in a generic pose; empty where they give less than
        its position or its orientation."""
        d = self.model.dim
        six, J = 6 if d == 3 else 3, self._jacobian
        for rows in (range(six), range(d), range(d, six)):
            if len(rows) > 1 and np.linalg.matrix_rank(J[list(rows)], rtol=1e-9) == len(rows):
                return tuple(rows)
        return ()

    @property
    def moving(self) -> tuple[int, ...]:
        """The coordinates that move the tip in the counted rows."""
        largest = np.abs(self._jacobian[list(self.rows)]).max(axis=0)
        return tuple(np.flatnonzero(largest > _STILL).tolist())

    @cached_property
    def _jacobian(self) -> Array:
        """The tip's Jacobian in a generic pose."""
        q, _, _ = random_state(self.model, 0)
        return np.array(jacobian(self.model.tree, tuple(q.tolist()), str(self.tip)))

    @property
    def row_names(self) -> tuple[str, ...]:
        """Names of the rows of the tip's motion that the page counts, such as vx."""
        return tuple(row_names(self.model.dim)[row] for row in self.rows)

    @property
    def length(self) -> float:
        """The length (m) by which linear rows are divided where angular ones count too."""
        d = self.model.dim
        mixed = any(r < d for r in self.rows) and any(r >= d for r in self.rows)
        return self.solver(self.rows).length if mixed else 1.0

    def solver(self, rows: tuple[int, ...]) -> NumericalSolver:
        """The solver whose lengths and coordinates a descent in the counted rows has."""
        assert self.tip is not None
        return NumericalSolver(self.model, self.tip, Task(self.model.dim, rows))

    @property
    def stiff(self) -> bool:
        """Whether drives or struts have friction, dampers or springs, which steps have to take
        implicitly."""
        return bool(self.model.struts) or self.model != self.model.without("friction", "springs")

    @property
    def method(self) -> str:
        """The method of `fb.simulate` that the page's simulation has."""
        if self.stiff:
            return "implicit"
        return "semi-implicit" if self.model.nv > _LARGE else "rk4"


_STEPS = {"rk4": "rk4_step", "implicit": "implicit_step", "semi-implicit": "semi_implicit_step"}


def kernels(robot: Studied) -> Iterator[PageKernel]:
    """All kernels that a robot has."""
    for name, made in _KERNELS.items():
        program = made(robot)
        if program is not None:
            yield PageKernel(name, program)


def _placed(robot: Studied) -> Program:
    """The program that computes the placements of all bodies."""
    return placement_program(robot.model)


def _of(*names: str) -> Callable[[Studied], Program]:
    """A function that makes the program of quantities of the robot with its load."""

    def made(robot: Studied) -> Program:
        inputs = [f"{LOAD}.mass"] if robot.tip is not None else []
        return _requested(robot.loaded, names, inputs=inputs)

    return made


def _requested(model: Model, names: Any, **options: Any) -> Program:
    request = requested("freebody studio", model, names, options)
    assert isinstance(request, QuantityRequest)
    return request.program()


def _stepped(robot: Studied) -> Program:
    """The program that computes a step of the page's simulation."""
    return _of(_STEPS[robot.method])(robot)


def _looked(robot: Studied) -> Program | None:
    """The tip's pose, the linear rows of its Jacobian, and singular values of the counted rows."""
    if not robot.arm:
        return None
    model, rows, length, d = robot.model, robot.rows, robot.length, robot.model.dim
    tree, tip = model.tree, robot.tip
    assert tip is not None

    def looked(q: Any) -> tuple[Any, ...]:
        (T,) = FORMULAS["forward_kinematics"].evaluate(tree, Option(tip), q=tuple(q))
        J = jacobian(tree, tuple(q), tip)
        counted = tuple(scale(1.0 / length if r < d else 1.0, J[r]) for r in rows)
        sizes = singular_values(counted)[0][0] if rows else ()
        return T, J[:d], sizes

    outputs = (
        Argument("T", (d + 1, d + 1)),
        Argument("J", (d, model.nv)),
        Argument("sizes", (min(len(rows), model.nv),)),
    )
    return trace("looked", looked, (Argument("q", (model.nq,)),), outputs)


def _descent(name: str, whole: bool) -> Callable[[Studied], Program | None]:
    """A step of the joints, within their limits, that brings the tip nearer to a pose."""

    def made(robot: Studied) -> Program | None:
        d, n = robot.model.dim, robot.model.nq
        rows = tuple(range((6 if d == 3 else 3) if whole else d))
        if not robot.arm:
            return None
        solver, model, allowed = robot.solver(rows), robot.model, ranges(robot.model)
        limits = (
            tuple(map(float, np.maximum(allowed.lower, -_UNBOUNDED))),
            tuple(map(float, np.minimum(allowed.upper, _UNBOUNDED))),
        )
        step = DescentStep(model.tree, solver.frame, rows, tuple(solver.columns))
        scales = 1.0 / solver.length, 1.0

        def pulled(q: Any, damping: Any, target: Any) -> tuple[Any, ...]:
            return step(tuple(q), damping, target, scales, limits)

        inputs = Argument("q", (n,)), Argument("damping", ()), Argument("target", (d + 1, d + 1))
        outputs = [Argument("q1", (n,)), *(Argument(x, ()) for x in ("damped", "left", "longest"))]
        return trace(name, pulled, inputs, outputs)

    return made


def _branches(robot: Studied) -> Program | None:
    """All branches of the inverse kinematics of a pose, of arms that have a closed form and no
    joint to spare."""
    if not robot.arm:
        return None
    rows = robot.row_names
    try:
        program = _requested(robot.model, "inverse_kinematics", rows=rows or None)
    except FreebodyError:  # no closed form: the page searches
        return None
    return program if len(program.inputs) == 1 else None


def _closed(robot: Studied) -> Program | None:
    """The loops of a closed chain closed by a Newton step; the weights tell how hard a coordinate
    is to move."""
    model = robot.model
    if not model.loops:
        return None
    tree, counting = model.tree, counting_equations(model)

    def closed(q: Any, weights: Any) -> tuple[Any, ...]:
        n = range(model.nv)
        metric = tuple(tuple(weights[i] if i == j else 0.0 for j in n) for i in n)
        return onto_loops(tree, tuple(q), (0.0,) * model.nv, factor(tree, metric), counting)[:1]

    inputs = Argument("q", (model.nq,)), Argument("weights", (model.nv,))
    return trace("closed", closed, inputs, (Argument("q1", (model.nq,)),))


_KERNELS: dict[str, Callable[[Studied], Program | None]] = {
    PLACED: _placed,
    "held": _of("static_torque"),
    "stepped": _stepped,
    "energies": _of("kinetic_energy", "potential_energy"),
    "looked": _looked,
    "pulled": _descent("pulled", whole=False),
    "turned": _descent("turned", whole=True),
    "branches": _branches,
    "closed": _closed,
}
