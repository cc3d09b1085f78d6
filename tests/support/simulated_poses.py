"""Robots that are off their models in a known way, and poses that an instrument sees of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

import freebody as fb

LOCAL = ("x", "y", "z", "rx", "ry", "rz", "offset")


def turned(vector) -> np.ndarray:
    """The rotation of a rotation vector, or of each of several."""
    return Rotation.from_rotvec(vector).as_matrix()


class Displaced:
    """A robot whose joints' frames and zeros are off its model's: behind the placement P of each
    joint stands a displacement D, so that with its motion M the tip is at the product of
    P D M(q + offset). Of the model only public positions of links are asked."""

    def __init__(self, model: fb.Model, rng: np.random.Generator, size: float = 1e-3):
        self.model, self.bodies, at = model, [], model.frame(None).body
        while at >= 0:
            self.bodies.insert(0, at)
            at = model.bodies[at].parent
        self.off = size * rng.normal(size=(len(self.bodies), 7))
        self.truth = {
            f"{model.bodies[i].joint.name}.{name}": x
            for i, row in zip(self.bodies, self.off, strict=True)
            for name, x in zip(LOCAL, row, strict=True)
        }

    def between(self, q) -> list[np.ndarray]:
        """The pose of each link on the way in the one before, and of the tip in the last."""
        links = [self.model.bodies[i].joint.child for i in self.bodies]
        poses = [fb.forward_kinematics(self.model, q, frame) for frame in (*links, None)]
        first = np.broadcast_to(np.eye(4), poses[0].shape)
        return [np.linalg.inv(a) @ b for a, b in zip((first, *poses), poses, strict=False)]

    def forward(self, q) -> np.ndarray:
        """Poses (n, 4, 4) of the tip at readings (n, nq)."""
        shifted = np.array(q)
        columns = [self.model.coordinates[i].q[0] for i in self.bodies]
        shifted[:, columns] += self.off[:, 6]
        *placed, _ = self.between(np.zeros_like(shifted))
        *moved, end = self.between(shifted)
        T = np.broadcast_to(np.eye(4), end.shape)
        for P, PM, off in zip(placed, moved, self.off, strict=True):
            D = np.eye(4)
            D[:3, :3], D[:3, 3] = turned(off[3:6]), off[:3]
            T = T @ P @ D @ np.linalg.inv(P) @ PM
        return T @ end


def random_arm(seed: int) -> fb.Model:
    """An arm of 3 to 7 joints by a random DH table, some of whose axes are parallel, nearly so, or
    at right angles."""
    rng = np.random.default_rng(seed)
    rows = [
        {
            "joint": "P" if rng.random() < 0.15 else "R",
            "theta": rng.uniform(-1.0, 1.0),
            "d": rng.choice([0.0, 0.1, 0.3]),
            "a": rng.choice([0.0, 0.2, 0.4]),
            "alpha": rng.choice([0.0, 1e-3, np.pi / 2, -np.pi / 2, rng.uniform(-3.0, 3.0)]),
        }
        for _ in range(rng.integers(3, 8))
    ]
    return fb.dh(rows, convention="standard", name=f"arm{seed}")


class Seen(NamedTuple):
    """Readings of joints and poses of the marker, with the poses of instrument and marker."""

    q: np.ndarray
    T: np.ndarray
    instrument: np.ndarray
    marker: np.ndarray

    @property
    def points(self) -> np.ndarray:
        return self.T[:, :3, 3]


def pose(rng: np.random.Generator, turn: float, away: float) -> np.ndarray:
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = turned(turn * rng.normal(size=3)), away * rng.normal(size=3)
    return T


def seen(real: Displaced, rng: np.random.Generator, count: int = 60, noise: float = 0.0) -> Seen:
    """Random poses of a robot, with noise on each coordinate (m, rad)."""
    q, _, _ = fb.random_state(real.model, int(rng.integers(1_000_000)), count)
    T_WI, T_EM = pose(rng, 1.0, 1.0), pose(rng, 1.0, 0.1)
    T = np.linalg.inv(T_WI) @ real.forward(q) @ T_EM
    T[:, :3, :3] = T[:, :3, :3] @ turned(noise * rng.normal(size=(count, 3)))
    T[:, :3, 3] += noise * rng.normal(size=(count, 3))
    return Seen(q, T, T_WI, T_EM)
