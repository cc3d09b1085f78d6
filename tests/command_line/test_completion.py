"""What the Tab key offers in Python's own shell and in IPython, of models with and without
numbers."""

from __future__ import annotations

import rlcompleter

import numpy as np
import pytest

import freebody as fb
from support.extras import extra

MODELS = {
    "numbers": lambda: fb.load("ur5e"),
    "symbols": lambda: fb.planar("RR"),
    "loops": lambda: fb.load("five_bar"),
    "family": lambda: fb.load("2R").with_payload(mass=[1.0, 2.0]),
    "changed": lambda: fb.load("2R").with_payload(mass=1.0).with_payload(mass=2.0),
}


def public(value):
    return sorted(name for name in dir(value) if not name.startswith("_"))


def offered(value):
    """What rlcompleter writes behind `value.`; of methods without their bracket."""
    found = rlcompleter.Completer({"value": value}).attr_matches("value.")
    return sorted(match.removeprefix("value.").rstrip("()") for match in found)


def test_the_package_completes_in_a_plain_shell():
    assert offered(fb) == sorted(set(fb.__all__) - {"__version__"})


@pytest.mark.parametrize("kind", MODELS)
def test_models_complete_in_a_plain_shell(kind):
    model = MODELS[kind]()
    fb.neutral(model)
    assert {"bind", "mass", "gravity", "tree", "structure"} <= set(offered(model))
    assert offered(model) == public(model)
    assert all(name.isidentifier() for name in dir(model))


def test_completion_computes_nothing():
    model = fb.planar("RRR")
    before = set(model.__dict__)
    offered(model)
    assert set(model.__dict__) == before


def test_results_complete_in_a_plain_shell():
    arm = fb.load("2R")
    study = fb.study(arm)
    for result in (study, study.motion, study.verdict, fb.equations(fb.planar("RR"))):
        assert offered(result) == public(result)


def test_the_class_shows_kept_properties_as_properties():
    assert isinstance(fb.Model.mass, property)
    assert "Total mass (kg)" in (fb.Model.mass.__doc__ or "")
    assert fb.load("2R").mass == np.float64(fb.load("2R").mass)


@pytest.mark.parametrize("jedi", [False, True])
def test_ipython_completes(jedi):
    shell = extra("IPython.core.interactiveshell", "ipython")
    completer = extra("IPython.core.completer", "ipython")
    names = {kind: make() for kind, make in MODELS.items()}
    own = completer.IPCompleter(
        shell=shell.InteractiveShell(), namespace={"fb": fb, **names}, use_jedi=jedi
    )

    def words(text):
        with completer.provisionalcompleter():
            return {c.text.removeprefix(".") for c in own.completions(text, len(text))}

    assert words("fb.inv") >= {"inverse_dynamics", "inverse_kinematics"}
    for kind in names:
        assert words(f"{kind}.with_") >= {"with_payload", "with_drive"}, kind
        assert words(f"{kind}.ma") == {"mass"}, kind
