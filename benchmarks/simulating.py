"""Many arms through `fb.simulate`: held by joint controllers beside MuJoCo's `rollout`, a million
different ones beside equal ones, two threads beside one, and dry friction beside smooth friction.

    python benchmarks/simulating.py [--arms 4096] [--steps 300] [--rubbing 200]
        [--different 1000000] [--rounds 3]

The controllers are -kp (q - goal) - kd q̇ with a goal for each arm: a function that `fb.compile`
compiled, in every stage of the Runge-Kutta steps; MuJoCo has position and velocity actuators of the
same gains. Both record every step's positions and rates; the states are compared at the end. Times
of one thread are CPU times of whole calls, interleaved.
"""

import argparse
import os

os.environ.update(OMP_NUM_THREADS="1")

import time
import warnings
from functools import partial
from xml.etree.ElementTree import SubElement, fromstring, tostring

import mujoco
import mujoco.rollout
import numpy as np

import freebody as fb
from common import seconds
from different import family_of
from stepping import AGREE, STEP, mjcf

KP = np.array([400.0, 400.0, 200.0, 4.0, 4.0, 0.4])
KD = np.array([40.0, 40.0, 20.0, 0.2, 0.2, 0.02])


def law(q, qd, goal):
    return [-kp * (x - g) - kd * v for x, v, g, kp, kd in zip(q, qd, goal, KP, KD, strict=True)]


CONTROL = fb.compile(law, {"q": 6, "qd": 6, "goal": 6}, {"tau": 6})


def theirs(model: fb.Model) -> mujoco.MjModel:
    """MuJoCo's arm with a position and a velocity actuator at each joint."""
    root = fromstring(mjcf(model))
    for joint, body in zip(root.iter("joint"), model.tree.bodies, strict=True):
        joint.set("name", body.name)
    actuators = SubElement(root, "actuator")
    for body, kp, kd in zip(model.tree.bodies, KP, KD, strict=True):
        SubElement(actuators, "position", joint=body.name, kp=repr(float(kp)))
        SubElement(actuators, "velocity", joint=body.name, kv=repr(float(kd)))
    found = mujoco.MjModel.from_xml_string(tostring(root, encoding="unicode"))
    off = mujoco.mjtDisableBit
    found.opt.disableflags |= off.mjDSBL_CONSTRAINT | off.mjDSBL_CONTACT | off.mjDSBL_SENSOR
    found.opt.integrator = mujoco.mjtIntegrator.mjINT_RK4
    return found


class Held:
    """Random arms that are held at random goals."""

    def __init__(self, model: fb.Model, arms: int, steps: int):
        self.model, self.steps = model, steps
        self.q, self.qd, _ = fb.random_state(model, 1, (arms,))
        self.goal = self.q + np.random.default_rng(2).uniform(-0.5, 0.5, self.q.shape)
        self.mujoco = theirs(model)
        self.data = mujoco.MjData(self.mujoco)
        control = np.zeros((arms, steps, 12))
        control[..., 0::2] = self.goal[:, None]
        self.control = control
        self.start = np.hstack([np.zeros((arms, 1)), self.q, self.qd])
        self.states = np.empty((arms, steps, self.start.shape[1]))
        self.sensors = np.empty((arms, steps, 0))

    def ours(self, threads: int = 1, steps: int | None = None) -> np.ndarray:
        found = fb.simulate(
            self.model,
            self.q,
            self.qd,
            STEP * np.arange((steps or self.steps) + 1),
            CONTROL,
            method="rk4",
            step=STEP,
            torque_inputs={"goal": self.goal},
            record=("q", "qd"),
            threads=threads,
        )
        return np.hstack([found.q.values[:, -1], found.qd.values[:, -1]])

    def peer(self) -> np.ndarray:
        states, _ = mujoco.rollout.rollout(
            self.mujoco,
            [self.data],
            self.start,
            self.control,
            control_spec=mujoco.mjtState.mjSTATE_CTRL,
            nstep=self.steps,
            state=self.states,
            sensordata=self.sensors,
        )
        return states[:, -1, 1:]


def held(arms: int, steps: int, rounds: int) -> None:
    pair = Held(fb.load("ur5e").without("friction"), arms, steps)
    apart = np.abs(pair.ours() - pair.peer()).max() / np.abs(pair.peer()).max()
    times = np.array([(seconds(pair.ours), seconds(pair.peer)) for _ in range(rounds)]) * 1e9
    ours, theirs_ = times.T / (arms * steps)
    print(
        f"{arms} UR5e held by joint controllers, {steps} RK4 steps of 1 ms: fb.simulate "
        f"{np.median(ours):.1f} ns a step, mujoco.rollout {np.median(theirs_):.0f} ns, ratio "
        f"{np.median(theirs_ / ours):.0f} ({(theirs_ / ours).min():.0f}-"
        f"{(theirs_ / ours).max():.0f}); difference {apart:.1e}"
        f"{'' if apart < AGREE else '  the comparison is void'}"
    )
    long = round(1.0 / STEP)
    runs = [partial(pair.ours, n, long) for n in (1, 2)]
    shared = np.array(
        [[seconds(run, clock=time.perf_counter) for run in runs] for _ in range(2 * rounds)]
    )
    ratio = shared[:, 0] / shared[:, 1]
    alone, both, begin = (
        min(seconds(run) for _ in range(2 * rounds)) for run in (*runs, partial(pair.ours, 1, 1))
    )
    serial = begin / alone - 1.0 / long  # of one thread's time: what threads do not share
    most = 1.0 / (serial + 0.5 * (both / alone - serial))
    print(
        f"a second of them, two threads beside one: {np.median(ratio):.2f} times as fast (best "
        f"{ratio.max():.2f}); "
        f"by CPU times, of which {100 * serial:.1f} % are not shared and two threads take "
        f"{100 * (both / alone - 1):+.1f} % more, {most:.2f} at most"
    )


def different(arms: int, steps: int, rounds: int) -> None:
    arm = fb.load("ur5e").without("friction")
    family = family_of(arm, arms)
    q, qd, tau = fb.random_state(arm, 1, (arms,))
    tau = 10.0 * tau[:, None]

    def run(model: fb.Model) -> float:
        return (
            seconds(
                lambda: fb.simulate(
                    model,
                    q,
                    qd,
                    [0.0, steps * STEP],
                    tau,
                    step=STEP,
                    record=("q", "qd"),
                    threads=1,
                )
            )
            * 1e9
            / (arms * steps)
        )

    for model in (arm, family):  # compiles, and puts the numbers in order
        fb.simulate(model, q, qd, [0.0, STEP], tau, step=STEP, record="q", threads=1)
    for _ in range(rounds):
        equal, unequal = run(arm), run(family)
        print(
            f"{arms} arms, {steps} steps: equal {equal:.1f} ns a step, different {unequal:.1f} ns, "
            f"ratio {unequal / equal:.2f}",
            flush=True,
        )


def rubbing(arms: int, rounds: int) -> None:
    """Arms with Coulomb friction that are drawn to goals for 0.5 s, errors controlled."""
    arm = fb.load("ur5e")
    for name, coulomb in zip(arm.joint_names, 2.5e-3 * KP, strict=True):
        arm = arm.with_drive(name, coulomb=coulomb)
    q, qd, _ = fb.random_state(arm, 1, (arms,))

    def run(friction: str, tolerance: float) -> None:
        fb.simulate(
            arm,
            q,
            0.0 * qd,
            [0.0, 0.5],
            CONTROL,
            torque_inputs={"goal": q + 0.1},
            friction=friction,
            tolerance=tolerance,
            record="q",
            threads=1,
        )

    warnings.simplefilter("ignore", fb.FreebodyWarning)  # that smooth friction keeps steps short
    for tolerance in (1e-10, 1e-6):
        for friction in ("smooth", "dry"):
            run(friction, tolerance)
        times = [
            [seconds(partial(run, friction, tolerance)) for friction in ("smooth", "dry")]
            for _ in range(rounds)
        ]
        smooth, dry = np.min(times, axis=0)
        print(
            f"{arms} UR5e with friction, tolerance {tolerance:g}: smooth {smooth:.2f} s, dry "
            f"{dry:.2f} s, ratio {dry / smooth:.2f}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arms", type=int, default=4096)
    parser.add_argument("--steps", type=int, default=300)
    parser.add_argument("--rubbing", type=int, default=200)
    parser.add_argument("--different", type=int, default=1_000_000)
    parser.add_argument("--rounds", type=int, default=3)
    args = parser.parse_args()
    held(args.arms, args.steps, args.rounds)
    rubbing(args.rubbing, args.rounds)
    if args.different:
        different(args.different, 100, args.rounds)


if __name__ == "__main__":
    main()
