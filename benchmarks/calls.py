"""One call of each public function beside Pinocchio's call for the same quantity: times and their
ratio.

    python benchmarks/calls.py [--robots ur5 panda talos solo] [--rounds 15]
        [--only jacobian momentum]

Both sides are given float64 arrays of one state and called as a user calls them, in a loop that
runs no code of its own between two calls. Pinocchio has its `Data`, made before, and gives back
what its functions return: where that is a view of `Data`, nothing is copied. Poses, velocities and
accelerations are its SE3 and Motion, made from `Data` by its own calls. Solo has a free base. A
row's values are compared first. Times are CPU time, rounds interleaved; a ratio is the median of
those within a round. It exits with 1 if a ratio is above 1.
"""

import argparse
import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")

import time
from collections import deque
from collections.abc import Callable, Iterator
from itertools import repeat
from statistics import median
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

import freebody as fb
from compare import ROBOTS, bare, robots_folder

FREE = {"solo": ("solo_description/robots/solo12.urdf", "FL_FOOT")}
CALLS = 400
AGREE = 1e-7


class Row(NamedTuple):
    """A quantity, both functions with their arguments, and what makes of Pinocchio's result
    freebody's."""

    name: str
    ours: tuple[Any, ...]
    theirs: tuple[Any, ...]
    same: Callable[[Any], Any] | None = None


class Robot:
    """One robot on both sides at one state; velocities and torques in each side's order of
    joints."""

    def __init__(self, name: str):
        file, self.tip = (ROBOTS | FREE)[name]
        urdf, free = bare(robots_folder() / file), name in FREE
        base = "free" if free else "fixed"
        self.model = fb.load(
            robots_folder() / file, mimic="free", tip=self.tip, physical="ignore", base=base
        ).without("friction", "rotors", "springs")
        self.pin = pin.buildModelFromXML(urdf, *([pin.JointModelFreeFlyer()] if free else []))
        self.data = self.pin.createData()
        self.frame = self.pin.getFrameId(self.tip)
        at = {x: k for k, x in enumerate(self.model.joint_names)}
        first = 2 if free else 1
        joints = sorted(range(first, self.pin.njoints), key=lambda i: self.pin.idx_vs[i])
        turn = [at[self.pin.names[i]] for i in joints]
        extra = 1 if free else 0  # the base's joint stands first on both sides
        self.v = [*range(6 * extra), *(k - extra + 6 * extra for k in turn)]
        self.q = [*((0, 1, 2, 4, 5, 6, 3) * extra), *(k - extra + 7 * extra for k in turn)]
        self.back = np.argsort(self.v)
        rng = np.random.default_rng(20261122)
        self.states = [self._position(rng, free) for _ in range(2)]
        self.rates = rng.uniform(-1, 1, (2, self.model.nv))

    def _position(self, rng: np.random.Generator, free: bool) -> np.ndarray:
        q = rng.uniform(-1, 1, self.model.nq)
        if free:
            q[3:7] /= np.linalg.norm(q[3:7])
        return q

    def position(self, x: Any) -> np.ndarray:
        there = np.empty(self.model.nq)
        there[self.q] = x
        return there

    def vector(self, x: Any) -> np.ndarray:
        return np.asarray(x)[self.back]

    def columns(self, x: Any) -> np.ndarray:
        return np.asarray(x)[:, self.back]

    def symmetric(self, x: np.ndarray) -> np.ndarray:
        """Of a matrix of which Pinocchio fills the entries above the diagonal."""
        return (np.triu(x) + np.triu(x, 1).T)[np.ix_(self.back, self.back)]

    def squares(self, some: Any) -> np.ndarray:
        """Three matrices, of which the last is symmetric."""
        return np.stack(
            [*(x[np.ix_(self.back, self.back)] for x in some[:2]), self.symmetric(some[2])]
        )


def matrix(pose: Any) -> np.ndarray:
    return pose.homogeneous


def rows(r: Robot) -> Iterator[Row]:
    """Each function that Pinocchio has too."""
    m, p, d, f = r.model, r.pin, r.data, r.frame
    (q, q1), (qd, qdd) = r.states, r.rates
    a, b = q[r.q], q1[r.q]
    v, w = (np.ascontiguousarray(x[r.v]) for x in (qd, qdd))
    wrench = np.array([1.0, -2.0, 3.0, 0.4, 0.5, -0.6])
    axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
    loads = _loads(r, a, wrench)

    def pose() -> Any:
        pin.forwardKinematics(p, d, a)
        return pin.updateFramePlacement(p, d, f)

    def velocity() -> Any:
        pin.forwardKinematics(p, d, a, v)
        return pin.getFrameVelocity(p, d, f, axes)

    def acceleration() -> Any:
        pin.forwardKinematics(p, d, a, v, w)
        return pin.getFrameClassicalAcceleration(p, d, f, axes)

    def jacobian_dot() -> Any:
        pin.computeJointJacobiansTimeVariation(p, d, a, v)
        return pin.getFrameJacobianTimeVariation(p, d, f, axes)

    def regressors() -> Any:
        return pin.computeKineticEnergyRegressor(p, d, a, v), pin.computePotentialEnergyRegressor(
            p, d, a
        )

    tip, body = r.tip, pin.ReferenceFrame.LOCAL
    yield Row("neutral", (fb.neutral, m), (pin.neutral, p), r.position)
    yield Row("integrate", (fb.integrate, m, q, qd), (pin.integrate, p, a, v), r.position)
    yield Row("difference", (fb.difference, m, q, q1), (pin.difference, p, a, b), r.vector)
    yield Row("forward_kinematics", (fb.forward_kinematics, m, q), (pose,), matrix)
    yield Row(
        "forward_kinematics, frame named", (fb.forward_kinematics, m, q, tip), (pose,), matrix
    )
    yield Row("velocity", (fb.velocity, m, q, qd), (velocity,), np.asarray)
    yield Row("acceleration", (fb.acceleration, m, q, qd, qdd), (acceleration,), np.asarray)
    of_frame = pin.computeFrameJacobian, p, d, a, f
    yield Row("jacobian", (fb.jacobian, m, q), (*of_frame, axes), r.columns)
    yield Row("jacobian, frame named", (fb.jacobian, m, q, tip), (*of_frame, axes), r.columns)
    yield Row("jacobian, body axes", (fb.jacobian, m, q, tip, "body"), (*of_frame, body), r.columns)
    yield Row("jacobian_dot", (fb.jacobian_dot, m, q, qd), (jacobian_dot,), r.columns)
    yield Row("center_of_mass", (fb.center_of_mass, m, q), (pin.centerOfMass, p, d, a))
    inverse, forward = (pin.rnea, p, d, a, v, w), (pin.aba, p, d, a, v, w)
    yield Row("inverse_dynamics", (fb.inverse_dynamics, m, q, qd, qdd), inverse, r.vector)
    loaded = fb.inverse_dynamics, m, q, qd, qdd, {tip: wrench}
    yield Row("inverse_dynamics, a wrench", loaded, (*inverse, loads), r.vector)
    yield Row("forward_dynamics", (fb.forward_dynamics, m, q, qd, qdd), forward, r.vector)
    loaded = fb.forward_dynamics, m, q, qd, qdd, {tip: wrench}
    yield Row("forward_dynamics, a wrench", loaded, (*forward, loads), r.vector)
    inverse = pin.computeRNEADerivatives, p, d, a, v, w
    forward = pin.computeABADerivatives, p, d, a, v, w
    yield Row(
        "… derivatives of inverse",
        (fb.inverse_dynamics_derivatives, m, q, qd, qdd),
        inverse,
        r.squares,
    )
    yield Row(
        "… derivatives of forward",
        (fb.forward_dynamics_derivatives, m, q, qd, qdd),
        forward,
        r.squares,
    )
    yield Row("mass_matrix", (fb.mass_matrix, m, q), (pin.crba, p, d, a), r.symmetric)
    yield Row(
        "mass_matrix_inverse",
        (fb.mass_matrix_inverse, m, q),
        (pin.computeMinverse, p, d, a),
        r.symmetric,
    )
    yield Row(
        "coriolis_matrix", (fb.coriolis_matrix, m, q, qd), (pin.computeCoriolisMatrix, p, d, a, v)
    )
    yield Row("bias", (fb.bias, m, q, qd), (pin.nonLinearEffects, p, d, a, v), r.vector)
    yield Row(
        "gravity_torque",
        (fb.gravity_torque, m, q),
        (pin.computeGeneralizedGravity, p, d, a),
        r.vector,
    )
    held = fb.static_torque, m, q, {tip: wrench}
    yield Row("static_torque, a wrench", held, (pin.computeStaticTorque, p, d, a, loads), r.vector)
    yield Row(
        "kinetic_energy",
        (fb.kinetic_energy, m, q, qd),
        (pin.computeKineticEnergy, p, d, a, v),
        np.asarray,
    )
    # links that do not move count in freebody
    fixed = fb.potential_energy(m, q1) - pin.computePotentialEnergy(p, d, b)
    yield Row(
        "potential_energy",
        (fb.potential_energy, m, q),
        (pin.computePotentialEnergy, p, d, a),
        lambda x: x + fixed,
    )
    about_com = pin.computeCentroidalMomentum, p, d, a, v
    yield Row("momentum", (fb.momentum, m, q, qd), about_com)
    yield Row(
        "momentum, about a point",
        (fb.momentum, m, q, qd, pin.centerOfMass(p, d, a)),
        about_com,
        np.asarray,
    )
    centroidal = pin.computeCentroidalMap, p, d, a
    yield Row(
        "centroidal_momentum_matrix", (fb.centroidal_momentum_matrix, m, q), centroidal, r.columns
    )
    parameters = pin.computeJointTorqueRegressor, p, d, a, v, w
    yield Row("regressor", (fb.regressor, m, q, qd, qdd), parameters)
    yield Row("energy_regressor", (fb.energy_regressor, m, q, qd), (regressors,))


def _loads(r: Robot, q: np.ndarray, wrench: np.ndarray) -> Any:
    """A wrench at the tip, in world axes, as Pinocchio takes it: for each joint in its own frame,
    made before."""
    pin.forwardKinematics(r.pin, r.data, q)
    tip = pin.updateFramePlacement(r.pin, r.data, r.frame)
    joint = r.pin.frames[r.frame].parentJoint
    there = pin.SE3(np.eye(3), tip.translation).act(pin.Force(wrench))
    loads = pin.StdVec_Force()
    for k in range(r.pin.njoints):
        loads.append(r.data.oMi[k].actInv(there) if k == joint else pin.Force.Zero())
    return loads


def microseconds(call: tuple[Any, ...]) -> float:
    """Of one call, its arguments given as they are."""
    function, *arguments = call
    columns = [repeat(x, CALLS) for x in arguments] or None
    start = time.process_time()
    if columns is None:
        for _ in range(CALLS):
            function()
    else:
        deque(map(function, *columns), maxlen=0)
    return (time.process_time() - start) / CALLS * 1e6


def difference(row: Row) -> float:
    """Between both results, relative to the largest entry; 0 where they are not the same thing."""
    if row.same is None:
        return 0.0
    (f, *x), (g, *y) = row.ours, row.theirs
    ours, theirs = np.asarray(f(*x)), np.asarray(row.same(g(*y)))
    return float(np.abs(ours - theirs).max() / max(np.abs(theirs).max(), 1e-12))


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", nargs="+", choices=[*ROBOTS, *FREE], default=[*ROBOTS, *FREE])
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--only", nargs="+", default=[])
    given = parser.parse_args()
    table: dict[str, list[str]] = {}
    slower = 0
    for name in given.robots:
        chosen = [
            x
            for x in rows(Robot(name))
            if not given.only or any(x.name.startswith(y) for y in given.only)
        ]
        for row in chosen:
            if not difference(row) <= AGREE:
                raise SystemExit(f"{name}, {row.name}: the results differ by {difference(row):.1e}")
        times: dict[str, list[tuple[float, float]]] = {row.name: [] for row in chosen}
        for _ in range(given.rounds + 1):
            for row in chosen:
                times[row.name].append((microseconds(row.ours), microseconds(row.theirs)))
        for title, rounds in times.items():
            ratio = median(a / b for a, b in rounds[1:])
            slower += ratio > 1.0
            ours, theirs = (median(x) for x in zip(*rounds[1:], strict=True))
            table.setdefault(title, []).append(
                f"{ours:.2f} / {theirs:.2f} {ratio:5.2f}{'*' * (ratio > 1.0):1}"
            )
    print(f"{'µs, ours / theirs, ratio':<34}" + "".join(f"{name:>24}" for name in given.robots))
    for title, cells in table.items():
        print(f"{title:<34}" + "".join(f"{cell:>24}" for cell in cells))
    print(f"{slower} above 1 (marked *)")
    return int(slower > 0)


if __name__ == "__main__":
    raise SystemExit(main())
