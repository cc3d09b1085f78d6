"""Public functions run the code of a model's structure: the same values as code of fixed numbers,
compiled once.

What is compiled is noted at the entrance of the compiler; two quantities that no public function
returns are fetched as these functions do.
"""

from __future__ import annotations

import gc
import pickle
import weakref

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, MissingValueError, SingularError
from freebody.kernels.formulas import FORMULAS, Option
from freebody.kernels.structural import fetch
from freebody.model.piece_paths import get, put_at
from freebody.model.placement import Placement, Shift
from freebody.model.structure import Structure
from freebody.targets.kernel import compile_program
from support import generate

QUANTITIES = (
    "inverse_dynamics",
    "mass_matrix",
    "kinetic_energy",
    "potential_energy",
    "momentum",
    "regressor",
)
COMPILERS = "freebody.kernels.structural.compile_program", "freebody.kernels.lookup.compile_program"


@pytest.fixture
def compiled(monkeypatch) -> list[str]:
    """Names of the programs that are compiled."""
    names: list[str] = []

    def noted(program, **options):
        names.append(program.name)
        return compile_program(program, **options)

    for place in COMPILERS:
        monkeypatch.setattr(place, noted)
    return names


def state_of(model: fb.Model, name: str, seed: int = 3) -> tuple[np.ndarray, ...]:
    q, qd, qdd = fb.random_state(model, seed, 5)
    count = {"mass_matrix": 1, "potential_energy": 1, "kinetic_energy": 2, "momentum": 2}.get(
        name, 3
    )
    return (q, qd, qdd)[:count]


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(0, 24, 6))
@pytest.mark.parametrize("dim", [2, 3])
def test_the_structures_kernel_is_the_one_of_fixed_numbers(seed: int, dim: int):
    model = generate.model(seed, dim)
    for name in QUANTITIES:
        given = state_of(model, name)
        fixed = fb.kernel(model, name)(*given)
        close(getattr(fb, name)(model, *given), fixed, name)
    q, qd, qdd = state_of(model, "")
    load = np.random.default_rng(seed).normal(size=(5, 6 if dim == 3 else 3))
    fixed = fb.kernel(model, "inverse_dynamics", wrench_frames=["tool"])(q, qd, qdd, load)
    close(fb.inverse_dynamics(model, q, qd, qdd, {"tool": load}), fixed, "with a wrench")
    reactions = np.zeros((5, len(model.bodies), 6 if dim == 3 else 3))
    found = fetch(model, ("balance",), Option())(q, qd, qdd, reactions)
    for x, expected in zip(
        found[:2], fb.kernel(model, "balance")(q, qd, qdd, reactions)[:2], strict=True
    ):
        close(x, expected, "what must act on free bodies")
    for frame in ("tool", "ground"):
        close(fb.jacobian(model, q, frame), fb.kernel(model, "jacobian", frame=frame)(q), frame)


@pytest.mark.sample(1)
@pytest.mark.parametrize("closed", [False, True])
def test_every_quantity_compiled_is_what_numpy_computes(closed: bool):
    """All in one kernel, of fixed numbers and of the structure; closed forms of inverse kinematics
    have `test_branches`."""
    sizes = [0.3, 0.2, 0.1]
    arm = fb.planar("RRR", l=sizes, lc=sizes, m=sizes, I=sizes)
    model = fb.load("five_bar") if closed else arm
    fitting = {"all", "closed" if closed else "open"}
    names = tuple(x for x, formula in FORMULAS.items() if formula.chains in fitting)
    ours, theirs = (fb.kernel(model, names, target=target) for target in ("cpu", "numpy"))
    rng = np.random.default_rng(5)
    given = {x.name: rng.uniform(0.1, 1.0, size=x.shape) for x in ours.program.inputs}
    given["q"] = fb.assemble(model) if closed else given["q"]
    outputs = [x.name for x in ours.program.outputs]
    expected = dict(zip(outputs, theirs(*given.values()), strict=True))
    assert closed or all(np.isfinite(x).all() for x in expected.values())
    agree(dict(zip(outputs, ours(*given.values()), strict=True)), expected)
    # rows, and what is settled once for all positions, public functions choose
    names = tuple(x for x in names if not (FORMULAS[x].of_rows or FORMULAS[x].settled))
    shared = fetch(model, names, Option(frame=model.tip))
    *inputs, _ = shared.kernel.program.inputs
    found = shared(*(given[x.name] for x in inputs))
    agree(dict(zip((x.name for x in shared.kernel.program.outputs), found, strict=True)), expected)


def agree(found: dict, expected: dict) -> None:
    for name, x in found.items():
        np.testing.assert_allclose(x, expected[name], rtol=1e-10, atol=1e-10, err_msg=name)


def close(found, expected, what: str) -> None:
    allowed = 1e-13 * max(float(np.abs(expected).max(initial=0.0)), 1e-3)
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=allowed, err_msg=what)


def test_closed_chains_too():
    model = fb.load("five_bar")
    assembled = fb.assemble(model)
    q, still = np.asarray(assembled, dtype=float), np.zeros(model.nv)
    fixed = fb.kernel(model, "constraint_jacobian")(q)
    close(fetch(model, ("constraint_jacobian",), Option())(q), fixed, "Φ_q")
    tau = fb.inverse_dynamics(model, q, still, still)
    heavier = model.with_payload(mass=1.0, frame=model.loops[0].frames[0])
    assert heavier.structure is model.structure
    assert np.abs(fb.inverse_dynamics(heavier, q, still, still) - tau).max() > 0.1


def test_other_numbers_and_names_share_a_structure():
    ur5e = fb.load("ur5e")
    payload = ur5e.with_payload(mass=2.0)
    assert payload.structure is ur5e.structure
    assert ur5e.replace(gravity=1.6, name="elsewhere").structure is ur5e.structure
    assert fb.dh([{"a": 0.3, "m": 1.0}], convention="standard").structure is not ur5e.structure
    sideways = ur5e.replace(gravity=(0.0, 9.81, 0.0))
    assert sideways.structure is not ur5e.structure, (
        "the zeros of gravity's direction are structure"
    )


def test_a_zero_of_a_placement_is_structure_and_a_zero_mass_is_not():
    def arm(d: float, mass: float) -> fb.Model:
        rows = [
            {
                "a": 0.3,
                "d": d,
                "alpha": 0.2,
                "m": mass,
                "com": (0.1, 0, 0),
                "I": (0.01,) * 3 + (0,) * 3,
            }
        ] * 2
        return fb.dh(rows, convention="standard", physical="ignore")

    assert arm(0.1, 1.0).structure is arm(0.2, 0.0).structure
    assert arm(0.1, 1.0).structure is not arm(0.0, 1.0).structure


def test_many_models_of_one_structure_are_compiled_once(compiled: list[str]):
    rng, q = np.random.default_rng(1), np.array([0.3, -0.4, 0.5])
    structures = set()
    for k in range(60):
        zero = k % 10 == 0
        masses = rng.uniform(0.5, 2.0, size=3) * (0.0 if zero else 1.0)
        rows = [
            {
                "a": x,
                "m": m,
                "com": (-x / 2, 0.0, 0.0),
                "I": (0.0, 0.01, 0.01, 0.0, 0.0, 0.0),
                "rotor": 1e-3,
            }
            | ({} if zero else {"friction": (0.1, 0.2)})
            for x, m in zip(rng.uniform(0.2, 0.5, size=3), masses, strict=True)
        ]
        model = fb.dh(rows, convention="standard", physical="ignore")
        structures.add(id(model.structure))
        qd = rng.normal(size=3)
        tau = fb.inverse_dynamics(model, q, qd, qd)
        M = fb.mass_matrix(model, q)
        bias = fb.bias(model, q, qd)
        np.testing.assert_allclose(tau, M @ qd + bias, rtol=1e-12, atol=1e-12)
    assert len(structures) == 1
    assert sorted(set(compiled)) == sorted(compiled), compiled
    assert set(compiled) <= {"inverse_dynamics", "mass_matrix", "bias"}


def test_what_was_called_before_changes_no_bit():
    model = fb.load("panda") if "panda" in fb.models() else fb.load("ur5e")
    state = fb.random_state(model, 2)
    alone = fb.inverse_dynamics(model, *state)
    other = model.with_payload(mass=3.0)
    fb.kernel(model, "inverse_dynamics")(*state)
    fb.inverse_dynamics(other, *state)
    again = pickle.loads(pickle.dumps(model))
    assert fb.inverse_dynamics(again, *state).tobytes() == alone.tobytes()
    assert fb.inverse_dynamics(model, *state).tobytes() == alone.tobytes()


@pytest.mark.parametrize(
    "change",
    [
        lambda m: m.bind({"forearm_link.mass": 2.5}),
        lambda m: m.bind(
            {"forearm_link.com.x": 0.1, "wrist_1_link.scale": 1.5, "elbow_joint.a": -0.5}
        ),
        lambda m: m.bind({"elbow_joint.alpha": 0.1}),
        lambda m: m.bind({"elbow_joint.a": 0.0}),
        lambda m: m.bind({"gravity": 1.62}),
        lambda m: m.bind({"gravity": [1.62, 9.81]}),
        lambda m: m.bind({"forearm_link.mass": [2.5, 3.0]}),
        lambda m: m.with_payload(mass=2.0, com=(0.01, 0.02, 0.1)),
        lambda m: m.with_payload(Inertia.box(2.0, (0.1, 0.2, 0.3)), frame="frame3").bind(
            gravity=1.0
        ),
        lambda m: m.with_drive("elbow_joint", viscous=2.0),
        lambda m: m.with_drive("elbow_joint", stiffness=3.0, rest=2.0),
    ],
)
@pytest.mark.parametrize("driven", [False, True])
def test_a_changed_copy_has_the_structure_and_numbers_of_one_made_anew(change, driven: bool):
    """It takes over what it shares with the model that it is made from."""
    model = fb.load("ur5e")
    model = model.with_drive("wrist_1_joint", coulomb=0.1) if driven else model
    before = model.numbers.copy()
    changed = change(model)
    anew = pickle.loads(pickle.dumps(changed))
    assert changed.structure is anew.structure
    assert changed.numbers.shape == anew.numbers.shape
    assert changed.numbers.tobytes() == anew.numbers.tobytes()
    again = change(changed)
    assert again.numbers.tobytes() == pickle.loads(pickle.dumps(again)).numbers.tobytes()
    assert model.numbers.tobytes() == before.tobytes()
    assert not changed.numbers.flags.writeable


def test_a_family_is_its_members_one_by_one():
    ur5e = fb.load("ur5e")
    masses = np.array([0.0, 1.0, 2.5])
    family = ur5e.with_payload(mass=masses[:, None], com=(0.0, 0.0, 0.1))
    q, qd, qdd = fb.random_state(ur5e, 4, 7)
    tau = fb.inverse_dynamics(family, q, qd, qdd)
    assert tau.shape == (3, 7, 6)
    for k, mass in enumerate(masses):
        close(
            tau[k],
            fb.inverse_dynamics(ur5e.with_payload(mass=mass, com=(0.0, 0.0, 0.1)), q, qd, qdd),
            "member",
        )


def test_a_pickle_carries_numbers_and_no_code():
    model = fb.load("ur5e")
    bare = len(pickle.dumps(fb.load("ur5e")))
    fb.inverse_dynamics(model, *fb.random_state(model, 1))
    assert len(pickle.dumps(model)) == bare


def test_a_structure_goes_when_its_models_and_newer_ones_are_gone():
    gone = weakref.ref(_chain(0).structure)
    for k in range(1, 20):
        assert isinstance(_chain(k).structure, Structure)
    gc.collect()
    assert gone() is None


def _chain(k: int) -> fb.Model:
    return fb.dh(
        [{"a": 0.3, "joint": "RP"[int(x)], "m": 1.0} for x in f"{k:05b}"], convention="standard"
    )


@pytest.mark.sample(119)
@pytest.mark.parametrize("seed", range(300))
def test_quick_verdicts_on_inertias_agree_with_eigenvalues(seed: int):
    rng = np.random.default_rng(seed)
    principal = rng.uniform(0.0, 1.0, size=3)
    if seed % 3 == 0:
        principal[2] = principal[0] + principal[1] + rng.choice([0.0, 1e-15, -1e-12, 1e-8, -1e-8])
    R = generate.random_rotation(rng)
    tensor = R @ np.diag(principal) @ R.T
    body = Inertia.of(1e-3, (0.0, 0.0, 0.0), 0.5 * (tensor + tensor.T))
    found = np.linalg.eigvalsh(body.numbers()[2])
    sigma = found.sum() / 2 - found
    physical = sigma.min() >= -1e-9 * max(abs(sigma).max(), 1e-3)
    assert (body.fault() is None) == physical


def test_missing_values_are_named():
    with pytest.raises(MissingValueError, match="l1"):
        fb.inverse_dynamics(fb.planar("RR"), [0.1, 0.2], [0.0, 0.0], [0.0, 0.0])


def test_no_centre_of_mass_is_said():
    model = fb.dh([{"a": 0.3}], convention="standard")
    with pytest.raises(SingularError, match="no link that moves has a mass"):
        fb.centroidal_momentum_matrix(model, [0.1])


def test_what_was_one_object_at_several_places_is_one_again():
    twice = Shift((1.0, 2.0, 3.0))
    things = (Placement((twice,)), (Placement((twice, twice)), twice), Shift((1.0, 5.0, 6.0)))
    first, again, other = (0, "steps", 0, "by", 0), (1, 1, "by", 0), (2, "by", 0)
    found = put_at(things, (first, (1, 0, "steps", 1, "by", 0), again, other), 7.0)
    assert found == (
        Placement((Shift((7.0, 2.0, 3.0)),)),
        (Placement((twice, Shift((7.0, 2.0, 3.0)))), Shift((7.0, 2.0, 3.0))),
        Shift((7.0, 5.0, 6.0)),
    )
    assert get(found, first[:3]) is get(found, again[:2])
    assert things[0].steps[0] is twice
    assert twice.by == (1.0, 2.0, 3.0)


def test_one_object_reached_in_two_ways_is_changed_in_each_way():
    shared = Shift((1.0, 2.0, 3.0))
    found = put_at((shared, shared), ((0, "by", 0), (1, "by", 1)), 7.0)
    assert found == (Shift((7.0, 2.0, 3.0)), Shift((1.0, 7.0, 3.0)))


def test_kernels_get_the_numbers_of_a_member_side_by_side():
    """In columns a batch takes twice the time."""
    family = fb.load("ur5e").bind(
        {"forearm_link.mass": np.linspace(2.0, 3.0, 4), "wrist_3_joint.d": 0.1}
    )
    for name in ("inverse_dynamics", "mass_matrix", "gravity_torque"):
        (numbers,) = fetch(family, (name,), Option()).numbers
        assert numbers.shape[0] == 4
        assert numbers.strides[-1] == numbers.itemsize
