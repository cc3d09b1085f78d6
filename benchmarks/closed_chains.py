"""A closed chain's forward dynamics: freebody's kernel beside Pinocchio's `constraintDynamics`, in one run, one thread.

    python benchmarks/closed_chains.py [--repeats 9]

The Stewart platform with its balls as point contacts, 24 joint coordinates and 18 equations on both sides, along its
default motion. Pinocchio has no batch call for it and is called in a loop; it iterates to 1e-10 on its multipliers.
A second table has the public functions with all their checks, CPU time a sample of a batch of 1000.
"""

import argparse
import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")

import time
from collections.abc import Callable
from functools import partial
from importlib.metadata import version

import numpy as np
import pinocchio as pin

import freebody as fb
from freebody.model.model import Model
from freebody.trees.passive import all_driven

BATCH, LOOP, SAMPLES = 4096, 256, 1000
ROBOTS = ("four_bar", "five_bar", "stewart")
KINDS = {
    "revolute": pin.JointModelRevoluteUnaligned,
    "prismatic": pin.JointModelPrismaticUnaligned,
    "free": lambda axis: pin.JointModelFreeFlyer(),
}


def main() -> None:
    """One table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=9, help="interleaved rounds")
    repeats = parser.parse_args().repeats
    model = all_driven(fb.load("stewart"))  # any torques
    motion = fb.default_motion(model, samples=BATCH)
    q, qd = motion.q, motion.qd
    tau = np.random.default_rng(0).normal(size=qd.shape)
    kernel = fb.kernel(model, "forward_dynamics")
    out = np.empty_like(tau)
    peer, order = twin(model, q[:LOOP], qd[:LOOP], tau[:LOOP])
    ours, theirs = fb.forward_dynamics(model, q[:LOOP], qd[:LOOP], tau[:LOOP]), peer()[:, order]
    print(f"freebody {fb.__version__}, Pinocchio {version('pin')}; {model.name}, batches of {BATCH}")
    print(
        f"largest difference, over the largest acceleration: {np.abs(ours - theirs).max() / np.abs(ours).max():.1e}"
    )
    rows = {
        "kernel": (lambda: kernel(q, qd, tau, out=out, threads=1), BATCH),
        "function": (lambda: fb.forward_dynamics(model, q, qd, tau), BATCH),
        "Pinocchio": (peer, LOOP),
    }
    times = {name: [] for name in rows}
    for _ in range(repeats):
        for name, (run, samples) in rows.items():
            times[name].append(timed(run) / samples)
    for name, found in times.items():
        print(
            f"{name:<10} {np.median(found) * 1e9:9.0f} ns  ({min(found) * 1e9:.0f} .. {max(found) * 1e9:.0f})"
        )
    ratio = np.array(times["Pinocchio"]) / np.array(times["kernel"])
    print(
        f"Pinocchio takes {np.median(ratio):.0f} times as long as the kernel ({ratio.min():.0f} .. {ratio.max():.0f})"
    )

    functions(repeats)


def functions(repeats: int) -> None:
    """The public functions, batches of `SAMPLES`."""
    for robot in ROBOTS:
        model = fb.load(robot)
        motion = fb.default_motion(model, samples=SAMPLES)
        state = motion.q, motion.qd
        tau = fb.inverse_dynamics(model, *state, motion.qdd)
        rows: dict[str, Callable[[], object]] = {
            "inverse_dynamics": partial(fb.inverse_dynamics, model, *state, motion.qdd),
            "static_torque": partial(fb.static_torque, model, motion.q),
            "forward_dynamics": partial(fb.forward_dynamics, model, *state, tau),
            "reactions, qdd": partial(fb.reactions, model, *state, qdd=motion.qdd),
            "reactions, tau": partial(fb.reactions, model, *state, tau=tau),
            "loop_velocity": partial(fb.loop_velocity, model, *state),
            "loop_acceleration": partial(fb.loop_acceleration, model, *state, motion.qdd),
            "assemble": partial(fb.assemble, model, motion.q),
        }
        for name, run in rows.items():
            best = min(timed(run, time.process_time) for _ in range(repeats))
            print(f"{robot:<10} {name:<18} {best / SAMPLES * 1e6:8.2f} µs a sample")


def timed(run: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Seconds of one call, after one that warms up."""
    run()
    start = clock()
    run()
    return clock() - start


def twin(
    model: Model, q: np.ndarray, qd: np.ndarray, tau: np.ndarray
) -> tuple[Callable[[], np.ndarray], np.ndarray]:
    """(Pinocchio's accelerations of all samples, where ours stand in them)."""
    built, ids = pin.Model(), {-1: 0}
    built.gravity.linear = np.array(model.gravity)
    v, p = np.zeros(model.nv, dtype=int), np.zeros(model.nq, dtype=int)
    kinds = {k: body.kind.name for k, body in zip(model.tree.body_of, model.bodies, strict=True)}
    for k in depth_first(model):  # Pinocchio's recursions need that order
        body = model.tree.bodies[k]
        joint = KINDS[kinds[k]](np.array(body.axis, dtype=float))
        ids[k] = built.addJoint(
            ids[body.parent], joint, pin.SE3(np.array(body.R), np.array(body.p)), f"joint{k}"
        )
        for mass in body.masses:
            inertia = pin.Inertia(float(mass.m), np.array(mass.c), np.array(mass.inertia))
            built.appendBodyToJoint(ids[k], inertia, pin.SE3.Identity())
        own = built.joints[ids[k]]
        v[list(body.coordinates.v)] = np.arange(own.idx_v, own.idx_v + own.nv)
        at = np.arange(own.idx_q, own.idx_q + own.nq)
        p[list(body.coordinates.q)] = at[[0, 1, 2, 6, 3, 4, 5]] if own.nq == 7 else at
    contacts, datas = pin.StdVec_RigidConstraintModel(), pin.StdVec_RigidConstraintData()
    for loop in model.loops:
        (i, A), (j, B) = (
            (ids[body], pin.SE3(np.array(R), np.array(at)))
            for body, R, at in (model.tree.frames[name] for name in loop.frames)
        )
        contacts.append(pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, built, i, A, j, B, pin.LOCAL))
    for contact in contacts:
        datas.append(contact.createData())
    data, settings = built.createData(), pin.ProximalSettings(1e-10, 1e-6, 100)
    pin.initConstraintDynamics(built, data, contacts, datas)
    states = [np.empty((len(q), n)) for n in (built.nq, built.nv, built.nv)]
    for state, order, given in zip(states, (p, v, v), (q, qd, tau), strict=True):
        state[:, order] = given

    found = np.empty((len(q), model.nv))

    def run() -> np.ndarray:
        for k, state in enumerate(zip(*states, strict=True)):
            found[k] = pin.constraintDynamics(built, data, *state, contacts, datas, settings)
        return found

    return run, v


def depth_first(model: Model, k: int = -1) -> list[int]:
    """Indices of the tree's bodies, each before what it carries, branch by branch."""
    return [i for child in model.tree.children(k) for i in (child, *depth_first(model, child))]


if __name__ == "__main__":
    main()
