"""freebody beside Pinocchio, MuJoCo and Drake: the time of one sample on one thread, interleaved in
one run.

    python benchmarks/compare.py [--robots ur5 panda talos] [--batch 4096] [--repeats 9]

Every engine reads the same URDF with the same joints free (mimic joints too) and without friction,
which Pinocchio's algorithms leave out, and every result is compared with freebody's before its time
is taken. Engines that are not installed are left out. What has no batch call of its own is called
in a loop.
"""

import argparse
import os

# Before the imports: one thread each, and no kernel from an earlier run, so that compile times are
# real.
os.environ.update(
    OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", FREEBODY_CACHE="off"
)

import importlib.metadata
import platform
import time
import xml.etree.ElementTree as ET
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

import freebody as fb
import limit
import sharing
from common import processor, robots_folder

ROBOTS = {  # name: (file below robots/, tip)
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "ee_link"),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand"),
    "talos": ("talos_data/robots/talos_reduced.urdf", "gripper_left_base_link"),
}
TASKS = {  # task: quantities of the kernel
    "inverse_dynamics": "inverse_dynamics",
    "forward_dynamics": "forward_dynamics",
    "mass_matrix": "mass_matrix",
    "tip_pose_and_jacobian": ("forward_kinematics", "jacobian"),
    "inverse_dynamics_derivatives": "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives": "forward_dynamics_derivatives",
}
LOOP = 256  # samples of a batch that are put through an engine one at a time
SINGLE = 500  # calls that are timed together to get the cost of one
OTHER_TAGS = (
    "visual",
    "collision",
    "dynamics",
    "mimic",
    "safety_controller",
    "gazebo",
    "transmission",
)
AGREE = 1e-6  # relative; snapped right angles move torques by about 1e-10


@dataclass
class States:
    """Random states in freebody's order of joints, and the permutation to another engine's
    order."""

    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray
    tau: np.ndarray
    names: tuple[str, ...]

    def order(self, names) -> list[int]:
        return [self.names.index(n) for n in names]

    def arguments(self, task: str, order=slice(None)) -> tuple[np.ndarray, ...]:
        used = {
            "inverse_dynamics": (self.q, self.qd, self.qdd),
            "inverse_dynamics_derivatives": (self.q, self.qd, self.qdd),
            "forward_dynamics": (self.q, self.qd, self.tau),
            "forward_dynamics_derivatives": (self.q, self.qd, self.tau),
        }.get(task, (self.q,))
        return tuple(np.ascontiguousarray(a[:, order]) for a in used)


@dataclass
class Entry:
    """One thing that is timed: run() processes `samples` samples; result() is compared with
    freebody's."""

    engine: str
    task: str
    how: str
    samples: int
    run: Callable[[], object]
    result: Callable[[], np.ndarray] | None = None


def looped(engine: str, task: str, how: str, call, arguments, order) -> Iterator[Entry]:
    """A call that takes one sample, in a loop over some of the batch, and alone.

    The loop is the quickest that Python has: it runs no code of its own between two calls.
    """
    columns = [list(a[:LOOP]) for a in arguments]
    rows = list(zip(*columns, strict=True))

    def loop():
        deque(map(call, *columns), maxlen=0)

    def result():
        values = np.array([np.array(first(call(*row))) for row in rows])
        back = np.argsort(order)
        return values[:, back] if values.ndim == 2 else values[:, back][:, :, back]

    compare = None if task == "tip_pose_and_jacobian" else result
    yield Entry(engine, task, f"loop of {how}", len(rows), loop, compare)
    yield single(engine, task, how, call, rows[0])


def first(result):
    """The array that is compared: of several outputs the first."""
    return result[0] if isinstance(result, tuple) else result


def single(engine: str, task: str, how: str, call, row) -> Entry:
    def run():
        for _ in range(SINGLE):
            call(*row)

    return Entry(engine, f"{task}, one call", how, SINGLE, run)


def freebody_entries(model, kernels, states: States) -> Iterator[Entry]:
    for task, kernel in kernels.items():
        arguments = states.arguments(task)
        results = kernel(*arguments)
        out = (
            tuple(map(np.empty_like, results))
            if isinstance(results, tuple)
            else np.empty_like(results)
        )
        yield Entry(
            "freebody",
            task,
            "kernel",
            len(states.q),
            lambda k=kernel, a=arguments, o=out: k(*a, out=o, threads=1),
            lambda o=out: first(o),
        )
        row = tuple(a[0] for a in arguments)
        yield single("freebody", task, "kernel", kernel, row)
        if hasattr(fb, task):
            public = getattr(fb, task)
            yield single("freebody", task, f"fb.{task}", lambda *a, f=public: f(model, *a), row)


def pinocchio_entries(urdf: str, states: States, tip: str) -> Iterator[Entry]:
    import pinocchio as pin

    model = pin.buildModelFromXML(urdf)
    data, pool = model.createData(), pin.ModelPool(model, 1)
    joints = sorted(range(1, model.njoints), key=lambda i: model.idx_vs[i])
    order = states.order(model.names[i] for i in joints)
    parallel = {"inverse_dynamics": pin.rneaInParallel, "forward_dynamics": pin.abaInParallel}
    for task, call in parallel.items():
        columns = [np.asfortranarray(a.T) for a in states.arguments(task, order)]
        out = np.empty_like(columns[0])
        yield Entry(
            "Pinocchio",
            task,
            call.__name__,
            len(states.q),
            lambda f=call, c=columns, o=out: f(1, pool, *c, o),
            lambda o=out: o.T[:, np.argsort(order)],
        )
    frame = model.getFrameId(tip)

    jacobians, placement = pin.computeJointJacobians, pin.updateFramePlacement

    def pose_and_jacobian(q):
        jacobians(model, data, q)
        return placement(model, data, frame)

    functions = {
        "inverse_dynamics": pin.rnea,
        "forward_dynamics": pin.aba,
        "mass_matrix": pin.crba,
        "inverse_dynamics_derivatives": pin.computeRNEADerivatives,
        "forward_dynamics_derivatives": pin.computeABADerivatives,
    }
    calls = {task: (f.__name__, partial(f, model, data)) for task, f in functions.items()}
    calls["tip_pose_and_jacobian"] = ("computeJointJacobians, placement", pose_and_jacobian)
    for task, (how, call) in calls.items():
        for entry in looped("Pinocchio", task, how, call, states.arguments(task, order), order):
            if entry.task.endswith("one call") or task not in parallel:
                yield entry


def mujoco_entries(urdf: str, states: States, tip: str) -> Iterator[Entry]:
    import mujoco as mj

    root = ET.fromstring(urdf)
    compiler = {
        "fusestatic": "true",
        "balanceinertia": "true",
        "boundmass": "1e-9",
        "boundinertia": "1e-12",
    }
    ET.SubElement(ET.SubElement(root, "mujoco"), "compiler", compiler)
    model = mj.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    model.opt.disableflags |= int(mj.mjtDisableBit.mjDSBL_CONSTRAINT)
    data = mj.MjData(model)
    order = states.order(model.joint(i).name for i in range(model.njnt))
    mass = np.empty((model.nv, model.nv))

    def inverse(q, qd, qdd):
        data.qpos, data.qvel, data.qacc = q, qd, qdd
        mj.mj_inverse(model, data)
        return data.qfrc_inverse

    def forward(q, qd, tau):
        data.qpos, data.qvel, data.qfrc_applied = q, qd, tau
        mj.mj_forward(model, data)
        return data.qacc

    def mass_matrix(q):
        data.qpos = q
        mj.mj_kinematics(model, data)
        mj.mj_comPos(model, data)
        mj.mj_crb(model, data)
        mj.mj_fullM(model, data, mass)
        return mass

    calls = {
        "inverse_dynamics": ("mj_inverse", inverse),
        "forward_dynamics": ("mj_forward", forward),
        "mass_matrix": ("mj_crb", mass_matrix),
    }
    for task, (how, call) in calls.items():
        yield from looped("MuJoCo", task, how, call, states.arguments(task, order), order)


def drake_entries(urdf: str, states: States, tip: str) -> Iterator[Entry]:
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import JacobianWrtVariable, MultibodyForces

    plant = MultibodyPlant(time_step=0.0)
    Parser(plant).AddModelsFromString(urdf, "urdf")
    base = ET.fromstring(urdf)
    children = {
        j.find("child").get("link") for j in base.iter("joint") if j.find("child") is not None
    }
    root = next(
        link.get("name") for link in base.findall("link") if link.get("name") not in children
    )
    if root != "world":
        plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(root))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    zero = MultibodyForces(plant)
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    joints = sorted((j for j in joints if j.num_velocities()), key=lambda j: j.velocity_start())
    order = states.order(j.name() for j in joints)
    world = plant.world_frame()
    frame = plant.GetFrameByName(tip)
    applied = plant.get_applied_generalized_force_input_port()
    acceleration = plant.get_generalized_acceleration_output_port()

    def inverse(q, qd, qdd):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, qd)
        zero.SetZero()
        plant.CalcForceElementsContribution(context, zero)
        return plant.CalcInverseDynamics(context, qdd, zero)

    def forward(q, qd, tau):
        plant.SetPositions(context, q)
        plant.SetVelocities(context, qd)
        applied.FixValue(context, tau)
        return acceleration.Eval(context)

    def mass_matrix(q):
        plant.SetPositions(context, q)
        return plant.CalcMassMatrix(context)

    def jacobian(q):
        plant.SetPositions(context, q)
        return plant.CalcJacobianSpatialVelocity(
            context, JacobianWrtVariable.kV, frame, np.zeros(3), world, world
        )

    calls = {
        "inverse_dynamics": ("CalcInverseDynamics", inverse),
        "forward_dynamics": ("acceleration port", forward),
        "mass_matrix": ("CalcMassMatrix", mass_matrix),
        "tip_pose_and_jacobian": ("CalcJacobianSpatialVelocity", jacobian),
    }
    for task, (how, call) in calls.items():
        yield from looped("Drake", task, how, call, states.arguments(task, order), order)


PEERS = {  # distribution: (name, entries)
    "pin": ("Pinocchio", pinocchio_entries),
    "mujoco": ("MuJoCo", mujoco_entries),
    "drake": ("Drake", drake_entries),
}


def bare(path: Path) -> str:
    """The URDF without meshes, friction and mimic, for the engines that cannot be told to leave
    them out."""
    root = ET.parse(path).getroot()
    for parent in list(root.iter()):
        for child in list(parent):
            if child.tag in OTHER_TAGS:
                parent.remove(child)
    return ET.tostring(root, encoding="unicode")


def vector_width() -> str:
    import llvmlite.binding as llvm

    has = llvm.get_host_cpu_features()
    name, lanes = next(
        ((f, n) for f, n in (("avx512f", 8), ("avx2", 4)) if has.get(f)), ("128-bit vectors", 2)
    )
    return f"{name}, {lanes} lanes of float64, LLVM calls it {llvm.get_host_cpu_name()}"


def measure(entries: list[Entry], repeats: int) -> list[np.ndarray]:
    """Nanoseconds a sample of each entry, one a round; each round times all, so that noise meets
    all."""
    passes = []
    for entry in entries:
        entry.run()
        start = time.perf_counter()
        entry.run()
        passes.append(max(1, int(0.02 / (time.perf_counter() - start))))
    times = [np.empty(repeats) for _ in entries]
    for r in range(repeats):
        for entry, n, into in zip(entries, passes, times, strict=True):
            start = time.perf_counter()
            for _ in range(n):
                entry.run()
            into[r] = (time.perf_counter() - start) * 1e9 / (n * entry.samples)
    return times


def disagreement(entry: Entry, reference: dict[str, np.ndarray]) -> float | None:
    if entry.result is None:
        return None
    entry.run()
    mine = reference[entry.task][: entry.samples]
    return float(np.abs(entry.result() - mine).max() / np.abs(mine).max())


def table(
    robot: str, entries: list[Entry], times: list[np.ndarray], errors: list[float | None]
) -> None:
    print(
        f"\n{robot:<30}{'':40}{'ns a sample':>12}{'min .. max':>20}{'freebody is':>14}"
        f"{'difference':>13}"
    )
    for task in dict.fromkeys(e.task for e in entries):
        rows = [i for i, e in enumerate(entries) if e.task == task]
        ours = next(times[i] for i in rows if entries[i].engine == "freebody")
        for i in rows:
            entry, t, error = entries[i], times[i], errors[i]
            digits = 1 if np.median(t) < 1000 else 0
            spread = f"{t.min():,.{digits}f} .. {t.max():,.{digits}f}"
            ratio = f"{np.median(t / ours):.1f} x" if entry.engine != "freebody" else ""
            agreed = f"{error:.0e}" if error is not None and entry.engine != "freebody" else ""
            print(
                f"{task:<30}{entry.engine + ' ' + entry.how:<40.40}"
                f"{np.median(t):>12,.{digits}f}{spread:>20}{ratio:>14}{agreed:>13}"
            )


def print_limits(kernels, entries: list[Entry], times: list[np.ndarray]) -> None:
    """How near each kernel comes to the time of its multiplications and additions alone."""
    width = next(iter(kernels.values())).width
    rate = limit.multiplications_per_ns(width)
    print(
        f"\n{rate:.1f} independent vector multiplications of {width} lanes a ns; were the kernels "
        f"that quick:"
    )
    for entry, t in zip(entries, times, strict=True):
        if entry.engine == "freebody" and entry.task in kernels:
            best = limit.nanoseconds_a_sample(kernels[entry.task].program.operations, width, rate)
            print(
                f"  {entry.task:<28}{best:8.1f} ns a sample, {best / np.median(t):4.0%} of that "
                f"reached"
            )


def compare(robot: str, batch: int, repeats: int) -> None:
    file, tip = ROBOTS[robot]
    path = robots_folder() / file
    model = fb.load(path, mimic="free", tip=tip).without("friction")
    rng = np.random.default_rng(20261101)
    q, qd, qdd, tau = rng.uniform(-1, 1, (4, batch, model.nv))
    states = States(q, qd, qdd, 10 * tau, tuple(model.joint_names))

    kernels, notes = {}, []
    for task in TASKS:
        start = time.perf_counter()
        kernels[task] = fb.kernel(model, TASKS[task])
        kernels[task](*(a[0] for a in states.arguments(task)))
        notes.append(f"{task} {time.perf_counter() - start:.2f} s")
    print(f"\n{robot}: {model.nv} joints; trace and compile: {', '.join(notes)}")

    entries = list(freebody_entries(model, kernels, states))
    for distribution, (engine, make) in PEERS.items():
        try:
            importlib.metadata.version(distribution)
        except importlib.metadata.PackageNotFoundError:
            continue
        try:
            entries += make(bare(path), states, tip)
        except (RuntimeError, ValueError) as error:
            print(f"{engine} does not take {robot}: {error}")

    reference = {}
    for entry in entries:
        if entry.engine == "freebody" and entry.result:
            entry.run()
            reference[entry.task] = entry.result().copy()
    errors = [disagreement(e, reference) for e in entries]
    times = measure(entries, repeats)
    table(robot, entries, times, errors)
    print_limits(kernels, entries, times)
    wrong = [
        f"{e.engine} {e.how}"
        for e, error in zip(entries, errors, strict=True)
        if error and error > AGREE
    ]
    if wrong:
        print(
            f"These do not compute the same as freebody, so their times say nothing: "
            f"{', '.join(wrong)}"
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", nargs="+", choices=ROBOTS, default=list(ROBOTS))
    parser.add_argument("--batch", type=int, default=4096)
    parser.add_argument("--repeats", type=int, default=9)
    options = parser.parse_args()

    versions = []
    for distribution in ("freebody", "numpy", "llvmlite", *PEERS):
        try:
            versions.append(f"{distribution} {importlib.metadata.version(distribution)}")
        except importlib.metadata.PackageNotFoundError:
            versions.append(f"{distribution} not installed")
    print(f"{processor()}, {os.cpu_count()} cores; {vector_width()}")
    print(f"Python {platform.python_version()}, {', '.join(versions)}")
    print(
        f"batch {options.batch}, median of {options.repeats} interleaved rounds, one thread, "
        f"float64"
    )
    for robot in options.robots:
        compare(robot, options.batch, options.repeats)
    file, tip = ROBOTS[options.robots[0]]
    sharing.print_sharing(str(robots_folder() / file), tip, 100_000, options.repeats)


if __name__ == "__main__":
    main()
