"""Steps of many arms beside MuJoCo: the time of one step of one arm on one thread, interleaved in
one run.

    python benchmarks/stepping.py [--arms 4096] [--steps 50] [--repeats 7]

A UR5e swings under torques that are held. MuJoCo reads a model that is written here from freebody's
own: the same bodies, masses and inertias, no contacts, limits, friction or sensors; the states of
both are compared after all steps. freebody calls its step kernel once a step for a block of arms;
MuJoCo's `rollout` makes all steps of all in one call.
"""

import argparse
import os

# Before the imports: one thread, and no kernel from an earlier run, so that compile times are real.
os.environ.update(OMP_NUM_THREADS="1", FREEBODY_CACHE="off")

import platform
from xml.etree.ElementTree import Element, SubElement, tostring

import mujoco
import mujoco.rollout
import numpy as np

import freebody as fb
import limit
from common import seconds

METHODS = {  # freebody's step: MuJoCo's integrator that does the same
    "semi_implicit_step": mujoco.mjtIntegrator.mjINT_EULER,
    "rk4_step": mujoco.mjtIntegrator.mjINT_RK4,
}
STEP = 1e-3
BLOCK = 1024  # arms whose states stay in the second cache from step to step
AGREE = 1e-6  # MuJoCo turns each inertia to its principal axes and back


def mjcf(model: fb.Model) -> str:
    """An arm of one-axis joints as MuJoCo's XML."""
    root = Element("mujoco")
    SubElement(
        root, "compiler", angle="radian", autolimits="false", boundmass="0", boundinertia="0"
    )
    SubElement(root, "option", gravity=_text(model.gravity), timestep=repr(STEP))
    above = {-1: SubElement(root, "worldbody")}
    for i, body in enumerate(model.tree.bodies):
        tag = above[i] = SubElement(above[body.parent], "body", name=body.name, pos=_text(body.p))
        tag.set("quat", _text(fb.quat_wxyz(np.array(body.R))))
        kind = "slide" if body.primitive.__class__.__name__ == "Sliding" else "hinge"
        armature = 0.0 if body.drive is None else body.drive.rotor
        SubElement(tag, "joint", type=kind, axis=_text(body.axis), armature=repr(float(armature)))
        (mass,) = body.masses
        I = np.array(mass.inertia)
        full = I[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        SubElement(
            tag, "inertial", mass=repr(float(mass.m)), pos=_text(mass.c), fullinertia=_text(full)
        )
    return tostring(root, encoding="unicode")


def _text(values: object) -> str:
    return " ".join(repr(float(x)) for x in np.ravel(values))


def theirs(model: fb.Model, integrator: int) -> mujoco.MjModel:
    """MuJoCo's model: forward dynamics and the integrator, nothing else."""
    found = mujoco.MjModel.from_xml_string(mjcf(model))
    off = mujoco.mjtDisableBit
    found.opt.disableflags |= off.mjDSBL_CONSTRAINT | off.mjDSBL_CONTACT | off.mjDSBL_SENSOR
    found.opt.integrator = integrator
    return found


class Arms:
    """Random states of many arms, moved on by freebody or by MuJoCo."""

    def __init__(self, model: fb.Model, method: str, arms: int, steps: int):
        self.q, self.qd, tau = fb.random_state(model, 1, (arms,))
        self.tau = 10.0 * tau
        self.steps = steps
        self.step = fb.kernel(model, method)
        self.end = np.empty_like(self.q), np.empty_like(self.qd)
        # read from the one, written to the other
        self.out = [tuple(np.empty((BLOCK, model.nv)) for _ in range(2)) for _ in range(2)]
        self.mujoco = theirs(model, METHODS[method])
        self.data = mujoco.MjData(self.mujoco)
        self.start = np.hstack([np.zeros((arms, 1)), self.q, self.qd])  # time, qpos, qvel
        self.control = np.repeat(self.tau[:, None], steps, axis=1)
        self.states = np.empty((arms, steps, self.start.shape[1]))
        self.sensors = np.empty((arms, steps, 0))

    def ours(self) -> tuple[np.ndarray, np.ndarray]:
        """All steps of all arms by freebody, a block of arms after the other."""
        for first in range(0, len(self.q), BLOCK):
            block = slice(first, first + BLOCK)
            state, tau = (self.q[block], self.qd[block]), self.tau[block]
            for k in range(self.steps):
                out = tuple(x[: len(tau)] for x in self.out[k % 2])
                state = self.step(*state, tau, STEP, out=out, threads=1)
            for end, reached in zip(self.end, state, strict=True):
                end[block] = reached
        return self.end

    def theirs(self) -> np.ndarray:
        """The same by MuJoCo."""
        states, _ = mujoco.rollout.rollout(
            self.mujoco,
            [self.data],
            self.start,
            self.control,
            control_spec=mujoco.mjtState.mjSTATE_QFRC_APPLIED,
            nstep=self.steps,
            state=self.states,
            sensordata=self.sensors,
        )
        return states[:, -1, 1:]

    def difference(self) -> float:
        """Largest difference of the two after all steps, relative to the largest rate."""
        return float(np.abs(np.hstack(self.ours()) - self.theirs()).max() / np.abs(self.qd).max())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arms", type=int, default=4096)
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--repeats", type=int, default=7)
    args = parser.parse_args()
    model = fb.load("ur5e").without("friction")
    print(
        f"{platform.processor() or platform.machine()}, freebody {fb.__version__}, MuJoCo "
        f"{mujoco.__version__}"
    )
    print(f"UR5e, {args.arms} arms, {args.steps} steps a round, {args.repeats} rounds; ns a step")
    print(
        f"{'':22}{'freebody':>22}{'MuJoCo rollout':>26}{'ratio':>8}{'of the arithmetic':>19}"
        f"{'difference':>12}"
    )
    for method in METHODS:
        arms = Arms(model, method, args.arms, args.steps)
        apart = arms.difference()
        rounds = np.array([(seconds(arms.ours), seconds(arms.theirs)) for _ in range(args.repeats)])
        ours, peer = (rounds * 1e9 / (args.arms * args.steps)).T
        rate = max(
            limit.multiplications_per_ns(arms.step.width) for _ in range(9)
        )  # where its loop lies matters
        bound = limit.nanoseconds_a_sample(
            dict(arms.step.program.operations), arms.step.width, rate
        )
        void = "" if apart < AGREE else "  the comparison is void"
        print(
            f"{method:22}{_spread(ours):>22}{_spread(peer):>26}{np.median(peer / ours):8.0f}"
            f"{bound / np.median(ours):19.2f}{apart:12.1e}{void}"
        )


def _spread(times: np.ndarray) -> str:
    return f"{np.median(times):.1f} ({times.min():.1f}-{times.max():.1f})"


if __name__ == "__main__":
    main()
