"""A closed chain's forward dynamics: freebody's kernel beside Pinocchio's `constraintDynamics`, in
one run, one thread.

    python benchmarks/closed_chains.py [--repeats 9]

The Stewart platform with its balls as point contacts, 24 joint coordinates and 18 equations on both
sides, along its default motion. Pinocchio has no batch call for it and is called in a loop; it
iterates to 1e-10 on its multipliers. Then the public functions with all their checks: CPU time of
one call, and a sample of a batch of 1000; what a changed number costs before the first call; and a
sample near a singular position, by singular values.
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
from common import seconds
from freebody.model.model import Model
from freebody.trees.special_joints import all_driven

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
    print(
        f"freebody {fb.__version__}, Pinocchio {version('pin')}; {model.name}, batches of {BATCH}"
    )
    print(
        f"largest difference, over the largest acceleration: "
        f"{np.abs(ours - theirs).max() / np.abs(ours).max():.1e}"
    )
    alone, _ = twin(model, q[:1], qd[:1], tau[:1])
    rows = {
        "kernel": (lambda: kernel(q, qd, tau, out=out, threads=1), BATCH),
        "function": (lambda: fb.forward_dynamics(model, q, qd, tau), BATCH),
        "Pinocchio": (peer, LOOP),
        "function, one call": (partial(fb.forward_dynamics, model, q[0], qd[0], tau[0]), 1),
        "Pinocchio, one call": (alone, 1),
    }
    times = {name: [] for name in rows}
    for _ in range(repeats):
        for name, (run, samples) in rows.items():
            times[name].append(min(timed(run) for _ in range(9)) / samples)
    for name, found in times.items():
        print(
            f"{name:<20} {np.median(found) * 1e9:9.0f} ns  ({min(found) * 1e9:.0f} .. "
            f"{max(found) * 1e9:.0f})"
        )
    ratio = np.array(times["Pinocchio"]) / np.array(times["kernel"])
    print(
        f"Pinocchio takes {np.median(ratio):.0f} times as long as the kernel ({ratio.min():.0f} .. "
        f"{ratio.max():.0f})"
    )

    functions(repeats)
    changes(repeats)


State = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]
"""q, qd, qdd, tau."""


def rows_of(model: Model) -> dict[str, Callable[[State], object]]:
    """The public functions by name, of a state or many."""
    frame = model.frame_names[-1]
    return {
        "inverse_dynamics": lambda s: fb.inverse_dynamics(model, *s[:3]),
        "static_torque": lambda s: fb.static_torque(model, s[0]),
        "forward_dynamics": lambda s: fb.forward_dynamics(model, s[0], s[1], s[3]),
        "reactions, qdd": lambda s: fb.reactions(model, s[0], s[1], qdd=s[2]),
        "reactions, tau": lambda s: fb.reactions(model, s[0], s[1], tau=s[3]),
        "joint_wrenches": lambda s: fb.joint_wrenches(model, *s[:3]),
        "loop_velocity": lambda s: fb.loop_velocity(model, *s[:2]),
        "loop_acceleration": lambda s: fb.loop_acceleration(model, *s[:3]),
        "assemble": lambda s: fb.assemble(model, s[0]),
        "assemble, 0.01 rad off": lambda s: fb.assemble(
            model, fb.integrate(model, s[0], 0.01 + 0.0 * s[1])
        ),
        "jacobian": lambda s: fb.jacobian(model, s[0], frame),
        "kinetic_energy": lambda s: fb.kinetic_energy(model, *s[:2]),
    }


def functions(repeats: int) -> None:
    """The public functions, one call and batches of `SAMPLES`."""
    print(f"{'':<33} one call  a sample  (µs)")
    for robot in ROBOTS:
        model = fb.load(robot)
        motion = fb.default_motion(model, samples=SAMPLES)
        tau = fb.inverse_dynamics(model, motion.q, motion.qd, motion.qdd)
        every: State = motion.q, motion.qd, motion.qdd, tau
        first: State = tuple(x[SAMPLES // 2] for x in every)
        for name, run in rows_of(model).items():
            one = min(timed(partial(run, first)) for _ in range(20 * repeats))
            best = min(timed(partial(run, every), time.process_time) for _ in range(repeats))
            print(f"{robot:<10} {name:<22} {one * 1e6:8.1f}  {best / SAMPLES * 1e6:8.2f}")


def changes(repeats: int) -> None:
    """A changed number and one forward dynamics; a sample that takes the careful way."""
    for robot, length in ("five_bar", "l1"), ("stewart", "swing1.placement.x"):
        model = fb.load(robot)
        q, still = fb.assemble(model), np.zeros(model.nv)
        size, frame = fb.parameters(model)[length].value, model.frame_names[-1]
        loads = iter(np.linspace(0.5, 1.0, 20 * repeats + 1))
        sizes = iter(size * (1.0 + 1e-9 * np.arange(1, 2 * repeats + 2)))

        def payload(model: Model = model, loads=loads, frame=frame, q=q, still=still) -> None:
            fb.forward_dynamics(
                model.with_payload(mass=float(next(loads)), frame=frame), q, still, still
            )

        def other_length(
            model: Model = model, sizes=sizes, length=length, q=q, still=still
        ) -> None:
            fb.forward_dynamics(model.bind({length: float(next(sizes))}), q, still, still)

        for name, run, rounds in (
            ("payload", payload, 10 * repeats),
            ("length", other_length, repeats),
        ):
            best = min(timed(run) for _ in range(rounds))
            print(f"{robot:<10} new {name} and forward_dynamics {best * 1e6:8.0f} µs")
    flat = fb.load("four_bar").bind(l1=0.3, l3=0.3, l2=1.0, d=1.0)
    q = fb.assemble(flat, [1e-4, -1e-4, 1e-4], free=("coupler_pin", "rocker_pin"))
    for name, careful in (
        ("forward_dynamics", partial(fb.forward_dynamics, flat, q, np.zeros(3), np.zeros(3))),
        ("static_torque", partial(fb.static_torque, flat, q)),
        ("loop_velocity", partial(fb.loop_velocity, flat, q, np.ones(3))),
    ):
        print(
            f"near singular {name:<18} {min(timed(careful) for _ in range(repeats)) * 1e6:8.0f} µs"
        )


def timed(run: Callable[[], object], clock: Callable[[], float] = time.perf_counter) -> float:
    """Seconds of one call, after one that warms up."""
    run()
    return seconds(run, clock=clock)


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
        contacts.append(
            pin.RigidConstraintModel(pin.ContactType.CONTACT_3D, built, i, A, j, B, pin.LOCAL)
        )
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
