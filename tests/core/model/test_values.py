"""Models, equations and results compare by value: structure and numbers exactly, not names of files
or notices."""

from __future__ import annotations

import dataclasses
import inspect
import pickle
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import robots
from freebody.by_value import ByValue

Q = np.array([0.3, 0.4])


def closed() -> tuple[fb.Model, np.ndarray]:
    chain = fb.load("four_bar")
    return chain, fb.assemble(chain)


def driving(torque: float) -> np.ndarray:
    chain = fb.load("four_bar")
    return np.array(
        [torque if name in chain.driven_names else 0.0 for name in chain.velocity_names]
    )


def of_closed(function: Callable[..., Any], **named: Any) -> Any:
    chain, q = closed()
    return function(chain, q, **named)


MADE: dict[str, Callable[[float], Any]] = {
    "Model": lambda g: fb.load("ur5e").replace(gravity=g),
    "a closed chain": lambda g: fb.load("four_bar").replace(gravity=g),
    "symbols": lambda g: fb.planar("RR", l=[g, "l2"]),
    "Equations": lambda g: fb.equations(fb.planar("RR", l=[g, "l2"])),
    "Equations in numbers": lambda g: fb.equations(fb.load("2R").replace(gravity=g), numbers=True),
    "LoopEquations": lambda g: fb.loop_equations(fb.load("four_bar").replace(gravity=g)),
    "Derivation": lambda g: fb.derive(fb.planar("RR", l=[g, "l2"]), "lagrange"),
    "Inertia": lambda g: fb.Inertia.box(g, (1.0, 2.0, 3.0)),
    "limits": lambda g: fb.planar("R", limits=[(-g, g)]).limits,
    "Motion": lambda g: fb.default_motion(fb.load("2R"), duration=g),
    "Solutions": lambda g: fb.inverse_kinematics(fb.load("2R"), [0.1 * g, 0.2]),
    "BaseParameters": lambda g: fb.base_parameters(
        fb.load("2R").replace(gravity=9.0 if g == 1.0 else 0.0)
    ),
    "Reactions": lambda g: of_closed(fb.reactions, qd=np.zeros(3), tau=driving(g)),
    "InputOutput": lambda g: fb.input_output(
        fb.load("five_bar"), fb.assemble(fb.load("five_bar")) * g
    ),
}
WITHOUT_OTHERS = ("InputOutput",)  # another position does not close


@pytest.mark.sample(7)
@pytest.mark.parametrize("what", MADE)
def test_made_twice_is_equal_and_made_otherwise_is_not(what):
    first, second = MADE[what](1.0), MADE[what](1.0)
    assert first is not second
    assert first == second
    assert (first != second) is False
    assert hash(first) == hash(second)
    assert len({first, second}) == 1
    if what not in WITHOUT_OTHERS:
        assert first != MADE[what](2.0)
    assert first != "anything else"


@pytest.mark.parametrize("what", MADE)
def test_a_pickle_comes_back_equal(what):
    value = MADE[what](1.0)
    found = pickle.loads(pickle.dumps(value))
    assert found == value
    assert hash(found) == hash(value)


@pytest.mark.parametrize("what", MADE)
def test_arrays_in_a_value_cannot_be_written_to(what):
    for value in (MADE[what](1.0), pickle.loads(pickle.dumps(MADE[what](1.0)))):
        for field in dataclasses.fields(value):
            held = getattr(value, field.name)
            if isinstance(held, np.ndarray):
                with pytest.raises(ValueError, match="read-only"):
                    held[...] = 0


def test_a_value_used_before_is_equal_to_a_new_one():
    """What was compiled or found for it does not count, and no pickle carries it."""
    used, new = fb.load("2R"), fb.load("2R")
    size = len(pickle.dumps(new))
    fb.forward_dynamics(used, Q, Q, Q)
    fb.equations(used).tau
    assert used == new
    assert hash(used) == hash(new)
    assert len(pickle.dumps(used)) == size
    closed_forms = fb.equations(new)
    size = len(pickle.dumps(closed_forms))
    closed_forms.text()
    assert len(pickle.dumps(closed_forms)) == size
    assert str(pickle.loads(pickle.dumps(closed_forms))) == str(closed_forms)


def test_names_of_files_and_notices_do_not_count_and_names_of_joints_do(tmp_path):
    source = Path(robots.__file__).parent / "2R.toml"
    copy = tmp_path / "another.toml"
    shutil.copy(source, copy)
    assert fb.load(copy) == fb.load("2R")
    assert fb.load("2R").replace(name="arm") == fb.load("2R")
    assert dataclasses.replace(fb.load("2R"), notices=()) == fb.load("2R")
    text = source.read_text(encoding="utf-8")
    assert (
        fb.planar("RR", passive=["joint1"])
        != fb.planar("RR", passive=["joint2"])
        != fb.planar("RR")
    )
    assert text


def test_the_last_bit_counts_and_the_sign_of_zero_does_not():
    arm = fb.planar("RR", l=[1.0, 1.0], lc=[0.5, 0.5], m=[1.0, 1.0], I=[0.1, 0.1], g=0.0)
    assert arm != fb.planar(
        "RR", l=[np.nextafter(1.0, 2), 1.0], lc=[0.5] * 2, m=[1.0] * 2, I=[0.1] * 2, g=0.0
    )
    assert arm == fb.planar("RR", l=[1, 1], lc=[0.5] * 2, m=[1] * 2, I=[0.1] * 2, g=-0.0)
    found = fb.Motion(
        np.arange(3.0), *(np.zeros((3, 1)),) * 3, "", fb.default_motion(fb.planar("R")).layout
    )
    other = fb.Motion(np.arange(3.0), *(-np.zeros((3, 1)),) * 3, "", found.layout)
    assert found == other
    assert hash(found) == hash(other)


def test_a_motion_keeps_its_numbers_when_the_arrays_it_was_made_of_change():
    q = np.zeros((8, 2))
    motion = fb.default_motion(fb.load("2R"))
    made = dataclasses.replace(motion, t=np.arange(8.0), q=q, qd=q, qdd=q)
    q[...] = 1.0
    assert not made.q.any()


def test_every_public_result_with_arrays_follows_the_one_rule():
    """A new result that holds an array takes its comparison from `ByValue` too."""
    from freebody.any_chain import reactions
    from freebody.inverse.problem import solutions
    from freebody.loops import input_output, mobility, singularity_loci
    from freebody.trees import base_parameters

    classes = [x for name in fb.__all__ if inspect.isclass(x := getattr(fb, name))]
    classes += [
        singularity_loci.Locus,
        mobility.Mobility,
        input_output.InputOutput,
        reactions.Reactions,
        solutions.Solutions,
    ]
    classes += [base_parameters.BaseParameters]
    for kind in classes:
        if dataclasses.is_dataclass(kind) and any(
            "Array" in str(f.type) for f in dataclasses.fields(kind)
        ):
            assert issubclass(kind, ByValue), kind
