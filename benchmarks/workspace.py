"""Maps over many postures and places of a UR5 beside loops over Pinocchio, from the same URDF.

    taskset -c 0 python benchmarks/workspace.py [--postures 200000] [--places 100000]

Microseconds a posture or place and their ratio, in turns within one run, the quickest of some
rounds (Pinocchio's on a part of them): the largest payload, from Pinocchio by torques of gravity
and the Jacobian; the singular values of the Jacobian's rows of position, of all its rows, and with
their directions, by NumPy's; the wrench at the tip of some torques, by NumPy's solver; and whether
a place is reached with the gripper downwards, for which Pinocchio's loop descends from a few starts
(as its example of inverse kinematics does), so that it may miss some. Both must agree.
"""

import argparse
import warnings
from functools import partial

import numpy as np
import pinocchio as pin  # pyright: ignore[reportMissingImports]

import freebody as fb
from common import quickest, robots_folder

URDF, TIP = "ur_description/urdf/ur5_robot.urdf", "ee_link"
PART = 2000
"""Postures of Pinocchio's loop."""
PLACES = 40
STARTS, STEPS = 6, 100
ROUNDS = 5
LENGTH = 1.0
"""What a radian is worth (m)."""
EFFORT = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])


class Loops:
    """What a user of Pinocchio writes."""

    def __init__(self, path: str):
        self.model = pin.buildModelFromUrdf(path)
        self.data = self.model.createData()
        self.frame = self.model.getFrameId(TIP)

    def payload(self, q: np.ndarray) -> np.ndarray:
        field = np.append(self.model.gravity.linear, np.zeros(3))
        found = np.zeros(len(q))
        for k, x in enumerate(q):
            torque = pin.computeGeneralizedGravity(self.model, self.data, x)
            slope = -self._jacobian(x).T @ field
            with np.errstate(divide="ignore"):
                holds = (EFFORT - np.sign(slope) * torque) / np.abs(slope)
            found[k] = 0.0 if (np.abs(torque) > EFFORT).any() else holds.min()
        return found

    def singular_values(self, q: np.ndarray, units: np.ndarray) -> np.ndarray:
        """Of as many rows as there are units, which are divided by these."""
        r = len(units)
        rows = (self._jacobian(x)[:r] / units[:, None] for x in q)
        return np.array([np.linalg.svd(J, compute_uv=False) for J in rows])

    def axes(self, q: np.ndarray) -> np.ndarray:
        """Those of the velocity ellipsoid times their lengths."""
        found = (np.linalg.svd(self._jacobian(x)[:3]) for x in q)
        return np.array([(U * sizes).T for U, sizes, _ in found])

    def wrench(self, q: np.ndarray, tau: np.ndarray) -> np.ndarray:
        return np.array(
            [np.linalg.solve(self._jacobian(x).T, y) for x, y in zip(q, tau, strict=True)]
        )

    def _jacobian(self, x: np.ndarray) -> np.ndarray:
        axes = pin.LOCAL_WORLD_ALIGNED
        return pin.computeFrameJacobian(self.model, self.data, x, self.frame, axes)

    def reached(self, poses: np.ndarray) -> np.ndarray:
        starts = np.random.default_rng(0).uniform(-np.pi, np.pi, (STARTS, self.model.nq))
        return np.array([any(self._descends(pin.SE3(T), q) for q in starts) for T in poses])

    def _descends(self, goal: pin.SE3, q: np.ndarray) -> bool:
        for _ in range(STEPS):
            pin.framesForwardKinematics(self.model, self.data, q)
            way = self.data.oMf[self.frame].actInv(goal)
            error = pin.log6(way).vector
            if np.linalg.norm(error) < 1e-6:
                return True
            J = pin.computeFrameJacobian(self.model, self.data, q, self.frame)
            J = -pin.Jlog6(way.inverse()) @ J
            q = q - J.T @ np.linalg.solve(J @ J.T + 1e-8 * np.eye(6), error)
        return False


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--postures", type=int, default=200_000)
    parser.add_argument("--places", type=int, default=100_000)
    asked = parser.parse_args()
    warnings.simplefilter("ignore", fb.FreebodyWarning)
    path = str(robots_folder() / URDF)
    arm, loops = fb.load(path, tip=TIP), Loops(path)
    q, _, _ = fb.random_state(arm, 0, asked.postures)
    tau = np.random.default_rng(2).normal(size=q.shape)
    places = np.random.default_rng(1).uniform(-1.0, 1.0, (asked.places, 3))
    down = np.diag([1.0, -1.0, -1.0])
    poses = np.tile(np.eye(4), (PLACES, 1, 1))
    poses[:, :3, :3], poses[:, :3, 3] = down, places[:PLACES]
    tasks = {
        "largest payload": (
            partial(fb.payload_map, arm, q, effort=EFFORT),
            partial(loops.payload, q[:PART]),
            asked.postures,
            PART,
        ),
        "singular values": (
            partial(fb.dexterity, arm, q, task="position"),
            partial(loops.singular_values, q[:PART], np.ones(3)),
            asked.postures,
            PART,
        ),
        "of all rows": (
            partial(fb.dexterity, arm, q, length=LENGTH),
            partial(loops.singular_values, q[:PART], np.repeat([LENGTH, 1.0], 3)),
            asked.postures,
            PART,
        ),
        "ellipsoids": (
            partial(fb.ellipsoids, arm, q),
            partial(loops.axes, q[:PART]),
            asked.postures,
            PART,
        ),
        "wrench of torques": (
            partial(fb.tip_wrench, arm, q, tau),
            partial(loops.wrench, q[:PART], tau[:PART]),
            asked.postures,
            PART,
        ),
        "reached, oriented": (
            partial(fb.workspace, arm, places, orientation=down),
            partial(loops.reached, poses),
            asked.places,
            PLACES,
        ),
    }
    mass = tasks["largest payload"][0]().mass[:PART]
    assert np.allclose(mass, loops.payload(q[:PART]), rtol=1e-9), "not the same payload"
    for name in ("singular values", "of all rows"):
        own, other, *_ = tasks[name]
        assert np.allclose(own().singular_values[:PART], other(), atol=1e-9), "not the same values"
    own, other, *_ = tasks["ellipsoids"]
    size = np.abs(own().velocity[:PART]) - np.abs(other())  # each side's axes have a sense
    assert np.abs(size).max() < 1e-6, "not the same axes"
    own, other, *_ = tasks["wrench of torques"]
    assert np.allclose(own()[:PART], other(), rtol=1e-6), "not the same wrench"
    inverse = fb.inverse_kinematics(arm, poses).count > 0
    missed = int((inverse & ~loops.reached(poses)).sum())
    assert not (loops.reached(poses) & ~inverse).any(), "a place was lost"
    print(f"{'':20}{'freebody µs':>12}{'Pinocchio µs':>14}{'ratio':>9}")
    for name, (own, other, count, part) in tasks.items():
        least = quickest({"own": own, "other": other}, ROUNDS)
        mine, theirs = least["own"] / count * 1e6, least["other"] / part * 1e6
        print(f"{name:20}{mine:12.3f}{theirs:14.2f}{theirs / mine:9.0f}", flush=True)
    print(f"Pinocchio's loop misses {missed} of {int(inverse.sum())} places that are reached.")


if __name__ == "__main__":
    main()
