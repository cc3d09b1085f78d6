"""The bundled robots, derived again: Lagrange's equations from positions, in SymPy and in numbers.

A mechanism's quantities have keys such as "H12", "xc2_d", "f12x"; `states` evaluates all of them at
random admissible states: loops closed, what nothing drives obeying the equations of motion.
"""

import functools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import sympy as sp
from sympy.simplify.fu import TR8


def symbol(key: str) -> sp.Symbol:
    """The symbol of a key, real."""
    return sp.Symbol(key, real=True)


S = symbol


@dataclass(frozen=True)
class Body:
    """A body: mass, inertia (in the plane one number, else three principal moments), centre of
    mass, and its angle in the plane or its rotation."""

    mass: Any
    inertia: Any
    centre: tuple[Any, ...]
    turn: Any = 0  # angle, or a rotation matrix


@dataclass(frozen=True, eq=False)
class Mechanism:
    """A robot as its coordinates, bodies and loops."""

    name: str
    coordinates: tuple[str, ...]
    bodies: tuple[Body, ...]
    values: dict[str, float]
    passive: tuple[str, ...] = ()
    loops: tuple[sp.Expr, ...] = ()
    tip: tuple[sp.Expr, ...] = ()
    home: dict[str, float] = field(default_factory=dict)
    kinetic: sp.Expr = sp.Integer(0)  # of rotors
    serial: bool = True
    tidied: bool = True

    @functools.cached_property
    def q(self) -> list[sp.Symbol]:
        return [S(x) for x in self.coordinates]

    @functools.cached_property
    def qd(self) -> list[sp.Symbol]:
        return [S(x + "_d") for x in self.coordinates]

    @functools.cached_property
    def qdd(self) -> list[sp.Symbol]:
        return [S(x + "_dd") for x in self.coordinates]

    def rate(self, value: Any) -> sp.Expr:
        """The time derivative."""
        value = sp.sympify(value)
        return sum(
            (value.diff(x) * y for x, y in zip(self.q + self.qd, self.qd + self.qdd, strict=True)),
            sp.Integer(0),
        )

    @functools.cached_property
    def up(self) -> int:
        return len(self.bodies[0].centre) - 1

    @functools.cached_property
    def energies(self) -> list[tuple[sp.Expr, sp.Expr]]:
        """Kinetic and potential energy of each body."""
        found = []
        for body in self.bodies:
            speed = sum(self.rate(x) ** 2 for x in body.centre)
            if self.up == 1:
                turning = body.inertia * self.rate(body.turn) ** 2
            else:
                omega = self.omega(body)
                turning = sum(i * w**2 for i, w in zip(body.inertia, omega, strict=True))
            kinetic = body.mass * sp.expand(speed) / 2 + turning / 2
            found.append((self.tidy(kinetic), sp.expand(body.mass * S("g") * body.centre[self.up])))
        return found

    def tidy(self, value: Any) -> sp.Expr:
        """Expanded, with squares of sine and cosine put together where that is quick."""
        value = sp.expand(sp.sympify(value))
        if not self.tidied or len(value.args) > 60 or not value.has(sp.sin):
            return value
        shorter = sp.expand(TR8(value))
        return shorter if shorter.count_ops() < value.count_ops() else value

    def omega(self, body: Body) -> list[sp.Expr]:
        """The angular velocity in the body's axes."""
        turn = sp.Matrix(body.turn) if body.turn != 0 else sp.eye(3)
        spin = turn.T * turn.applyfunc(self.rate)
        return [self.tidy(spin[2, 1]), self.tidy(spin[0, 2]), self.tidy(spin[1, 0])]

    @functools.cached_property
    def quantities(self) -> dict[str, sp.Expr]:
        """All quantities by key, in coordinates, rates, accelerations and parameters."""
        found: dict[str, sp.Expr] = {}
        if self.tidied:
            self._dynamics(found)
        self._motions(found)
        return {x: y for x, y in found.items() if x not in self.coordinates}

    def _dynamics(self, found: dict[str, sp.Expr]) -> None:
        """Energies, momenta, mass matrix, velocity terms, gravity, forces of the drives."""
        energies = self.energies
        for i, (kinetic, potential) in enumerate(energies, 1):
            found |= {f"T{i}": kinetic, f"V{i}": potential}
        T = sum((x for x, _ in energies), sp.Integer(0)) + self.kinetic
        V = sum((x for _, x in energies), sp.Integer(0))
        found |= {"T": T, "V": V, "L": T - V, "E": T + V}
        found |= {"T_d": self.rate(T), "V_d": self.rate(V), "E_d": self.rate(T + V)}
        n = len(self.q)
        M = [[self.tidy(T.diff(x).diff(y)) for y in self.qd] for x in self.qd]
        for i in range(n):
            found[f"p{i + 1}"] = T.diff(self.qd[i])
            found[f"p{i + 1}_d"] = self.rate(T.diff(self.qd[i]))
            found[f"dLdq{i + 1}"] = (T - V).diff(self.q[i])
            found[f"G{i + 1}"] = V.diff(self.q[i])
            found[f"c{i + 1}"] = self.tidy(
                sum(
                    (M[i][j].diff(self.q[k]) - M[j][k].diff(self.q[i]) / 2)
                    * self.qd[j]
                    * self.qd[k]
                    for j in range(n)
                    for k in range(n)
                )
            )
            for j in range(n):
                found[f"H{i + 1}{j + 1}"] = M[i][j]
                found[f"H{i + 1}{j + 1}_d"] = self.rate(M[i][j])
                found[f"C{i + 1}{j + 1}"] = (
                    sum(
                        (
                            M[i][j].diff(self.q[k])
                            + M[i][k].diff(self.q[j])
                            - M[j][k].diff(self.q[i])
                        )
                        * self.qd[k]
                        for k in range(n)
                    )
                    / 2
                )
            force = sum((M[i][j] * self.qdd[j] for j in range(n)), sp.Integer(0))
            force += found[f"c{i + 1}"] + found[f"G{i + 1}"]
            for k, loop in enumerate(self.loops, 1):
                force += loop.diff(self.q[i]) * S(f"lam{k}")
            found[f"tau{i + 1}"] = force
        found["P"] = sum(
            (found[f"tau{i}"] * self.qd[i - 1] for i in range(1, n + 1)), sp.Integer(0)
        )

    def _motions(self, found: dict[str, sp.Expr]) -> None:
        """Positions, velocities and accelerations of bodies and tip; loops; forces in joints."""
        n = len(self.q)
        for i, body in enumerate(self.bodies, 1):
            for axis, x in zip("xyz", body.centre, strict=False):
                found |= {f"{axis}c{i}": sp.sympify(x), f"vc{i}{axis}": self.rate(x)}
                found[f"ac{i}{axis}"] = self.rate(self.rate(x))
            if self.up == 1:
                found |= {f"phi{i}": sp.sympify(body.turn), f"omega{i}": self.rate(body.turn)}
                found[f"omega{i}_d"] = self.rate(self.rate(body.turn))
        for axis, x in zip("xyz", self.tip, strict=False):
            found |= {axis: x, f"{axis}_d": self.rate(x), f"{axis}_dd": self.rate(self.rate(x))}
        rows = list(self.tip)
        for i, x in enumerate(rows, 1):
            for j, by in enumerate(self.q, 1):
                found[f"J{i}{j}"] = x.diff(by)
        if self.tip and len(self.tip) == n and not self.loops:
            found["detJ"] = self.tidy(sp.Matrix([[x.diff(y) for y in self.q] for x in rows]).det())
        for k, loop in enumerate(self.loops, 1):
            found |= {f"Phi{k}": loop, f"Phi{k}_d": self.rate(loop)}
            found[f"Phi{k}_dd"] = self.rate(self.rate(loop))
            for j, by in enumerate(self.q, 1):
                found[f"Phi{k}q{j}"] = loop.diff(by)
        if self.serial and self.up == 1:
            self._joint_forces(found)

    def _joint_forces(self, found: dict[str, sp.Expr]) -> None:
        """Forces of a serial arm in the plane: mass times acceleration of all that follows."""
        for axis, weight in (("x", 0), ("y", S("g"))):
            force: Any = sp.Integer(0)
            for i in range(len(self.bodies), 0, -1):
                force += self.bodies[i - 1].mass * (found[f"ac{i}{axis}"] + weight)
                found[f"f{i - 1}{i}{axis}"] = force

    def compiled(self, keys: Sequence[str]) -> Callable[[dict[str, np.ndarray]], list[Any]]:
        """The quantities as one function of an environment."""
        values = [self.quantities[x] for x in keys]
        free = sorted({str(x) for y in values for x in sp.sympify(y).free_symbols})
        function = sp.lambdify([S(x) for x in free], values, "numpy", cse=True)
        return lambda env: function(*(env[x] for x in free))

    @functools.cached_property
    def parts(self) -> dict[str, Callable[[dict[str, np.ndarray]], list[Any]]]:
        n, m = len(self.q), len(self.loops)
        span = range(1, n + 1)
        loops = range(1, m + 1)
        return {
            "loops": self.compiled([f"Phi{k}" for k in loops]),
            "slope": self.compiled([f"Phi{k}q{j}" for k in loops for j in span]),
            "mass": self.compiled([f"H{i}{j}" for i in span for j in span if self.passive]),
            "bias": self.compiled([f"{x}{i}" for i in span for x in "cG" if self.passive]),
            "drift": self.compiled([f"Phi{k}_dd" for k in loops]),
        }

    def parameters(self, rng: np.random.Generator, spread: float) -> dict[str, float]:
        """Parameters near the file's, each moved on its own."""
        moved = {}
        for key, own in self.values.items():
            moved[key] = own * (1 + spread * rng.uniform(-1, 1))
        return moved

    def state(self, rng: np.random.Generator, spread: float = 0.15) -> dict[str, Any]:
        """One admissible state: parameters, coordinates, rates, accelerations, multipliers."""
        while True:
            env: dict[str, Any] = {"one": 1.0, **self.parameters(rng, spread)}
            if self.loops:
                if not self._walk(env, rng):
                    continue
            else:
                for x in self.coordinates:
                    low, high = (0.2, 1.2) if x[0] in "dxyz" else (-3.1, 3.1)
                    env[x] = rng.uniform(low, high)
            self._motion(env, rng)
            if all(abs(v) < 1e4 for v in env.values()):
                return env

    def _walk(self, env: dict[str, Any], rng: np.random.Generator) -> bool:
        """From the home along the motions that the loops allow, in steps that stay on the
        branch."""
        env |= self.home
        if not self._close(env, 2.0):
            return False
        direction = rng.normal(size=len(self.q))
        for _ in range(int(rng.integers(3, 28))):
            slope = np.array(self.parts["slope"](env), float).reshape(len(self.loops), -1)
            free = null(slope)
            step = free @ (free.T @ direction)
            direction = step / np.linalg.norm(step)
            before = {x: env[x] for x in self.coordinates}
            for x, by in zip(self.coordinates, direction, strict=True):
                env[x] += 0.08 * by
            if not self._close(env, 0.03):
                env |= before
                return self._regular(env)
        return self._regular(env)

    def _close(self, env: dict[str, Any], most: float) -> bool:
        start = np.array([env[x] for x in self.coordinates])
        for _ in range(30):
            gap = np.array(self.parts["loops"](env), float)
            slope = np.array(self.parts["slope"](env), float).reshape(len(self.loops), -1)
            if np.abs(gap).max() < 1e-14:
                break
            step = np.linalg.lstsq(slope, -gap, rcond=None)[0]
            for x, by in zip(self.coordinates, step, strict=True):
                env[x] += by
        moved = np.linalg.norm(np.array([env[x] for x in self.coordinates]) - start)
        return np.abs(gap).max() < 1e-12 and moved < most

    def _regular(self, env: dict[str, Any]) -> bool:
        slope = np.array(self.parts["slope"](env), float).reshape(len(self.loops), -1)
        passive = [i for i, x in enumerate(self.coordinates) if x in self.passive]
        least = np.linalg.svd(slope[:, passive], compute_uv=False)[-1] if passive else 1.0
        return least > 0.08 * np.linalg.norm(slope, 2) ** 1 / max(1, len(self.loops))

    def _motion(self, env: dict[str, Any], rng: np.random.Generator) -> None:
        n, m = len(self.q), len(self.loops)
        slope = np.array(self.parts["slope"](env), float).reshape(m, n)
        free = null(slope) if m else np.eye(n)
        rates = free @ rng.normal(size=free.shape[1])
        env |= {x + "_d": v for x, v in zip(self.coordinates, rates, strict=True)}
        env |= {x + "_dd": 0.0 for x in self.coordinates}
        rows = np.hstack([slope, np.zeros((m, m))])
        right = -np.array(self.parts["drift"](env), float).reshape(m)
        passive = [i for i, x in enumerate(self.coordinates) if x in self.passive]
        if passive:
            mass = np.array(self.parts["mass"](env), float).reshape(n, n)
            bias = np.array(self.parts["bias"](env), float).reshape(n, 2).sum(axis=1)
            rows = np.vstack([rows, np.hstack([mass[passive], slope.T[passive]])])
            right = np.concatenate([right, -bias[passive]])
        point = rng.normal(size=n + m)
        if len(rows):
            point -= np.linalg.pinv(rows) @ (rows @ point - right)
        env |= {x + "_dd": v for x, v in zip(self.coordinates, point[:n], strict=True)}
        env |= {f"lam{k}": v for k, v in enumerate(point[n:], 1)}

    def states(self, count: int, seed: int = 1, spread: float = 0.15) -> dict[str, np.ndarray]:
        """The values of all quantities at random states; the last axis is the state."""
        rng = np.random.default_rng(seed)
        drawn = [self.state(rng, spread) for _ in range(count)]
        env = {x: np.array([y[x] for y in drawn]) for x in drawn[0]}
        keys = list(self.quantities)
        for key, found in zip(keys, self.compiled(keys)(env), strict=True):
            env[key] = np.broadcast_to(np.asarray(found, float), env["one"].shape)
        return env


def null(slope: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the null space; equations that depend on others count once."""
    _, sizes, right = np.linalg.svd(slope)
    rank = int((sizes > 1e-7 * max(sizes[0], 1e-12)).sum())
    return right[rank:].T
