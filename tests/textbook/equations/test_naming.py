"""One thing, one name: drawings call and show what the equations beside them say, by name, by value
and by sign."""

from __future__ import annotations

import re
from functools import cache

import numpy as np
import pytest

import freebody as fb
from freebody.expressions import expression as ex
from freebody.expressions.naming import Naming
from freebody.expressions.printed_names import sym
from freebody.figures.drawing import Arc, Arrow, Dimension, Drawing, Label, Turn
from freebody.figures.marked_text import canonical, label
from freebody_textbook.derivation import Derivation
from freebody_textbook.drawings import illustrate
from freebody_textbook.drawings.illustrate import illustrations
from freebody_textbook.methods import METHODS
from support.printed_values import evaluate
from support.robots import Joint, Link, Mount, Placement, Robot, loaded, shift

pytestmark = pytest.mark.usefixtures("numpy_kernels")

OPEN = {
    "newton-euler about pivots": {"route": "pivot"}, "newton-euler loaded": {"load": True},
    "recursive with weights": {"gravity": "explicit"},
    **{name: {} for name in METHODS},
}  # fmt: skip
CLOSED = tuple(name for name, method in METHODS.items() if method.closed)


HERE = Placement()


def turning(name: str, parent: str, child: str, at: Placement = HERE, **more: object) -> Joint:
    return Joint(name, "revolute", parent, child, at, (1.0,), **more)


def link(name: str, mass: str, com: str | float = 0.0, inertia: str | float = 0.0) -> Link:
    return Link(name, fb.Inertia.of(mass, (com, 0.0), inertia))


def assembled(
    name: str, links: list[Link], joints: list[Joint], mounts: list[Mount], tip: str
) -> fb.Model:
    gravity = (fb.Parameter("g"), (0.0, -1.0))
    root = Link("ground")
    return loaded(Robot(name, 2, (root, *links), tuple(joints), gravity, tuple(mounts), tip=tip))


def tree() -> fb.Model:
    """A body with the tip and two children; one slides, on a spring, the other has friction and no
    motor."""
    joints = [
        turning("pin", "ground", "trunk"),
        Joint("slide", "prismatic", "trunk", "left", shift(fb.Parameter("a"), 0.0), (1.0, 0.0),
              drive=fb.Drive(stiffness="k", rest=0.1)),
        turning("turn", "trunk", "right", shift(fb.Parameter("b"), 0.0),
                drive=fb.Drive(viscous="beta"), passive=True),
    ]  # fmt: skip
    links = [
        link("trunk", "M", "c", "Jt"),
        link("left", "ml", "cl", "Jl"),
        link("right", "mr", "cr", "Jr"),
    ]
    return assembled(
        "tree", links, joints, [Mount("tool", "trunk", shift(fb.Parameter("e"), 0.2))], "tool"
    )


def cart_and_pole() -> fb.Model:
    joints = [
        Joint("x", "prismatic", "ground", "cart", axis=(1.0, 0.0)),
        turning("pin", "cart", "pole", passive=True),
    ]
    links = [link("cart", "mc"), link("pole", "mp", "lp", "Ip")]
    return assembled(
        "cart-pole", links, joints, [Mount("end", "pole", shift(fb.Parameter("l"), 0.0))], "end"
    )


def collar() -> fb.Model:
    """A crank whose end slides on a rocker: a loop whose two ends do not coincide, and which
    transmits a moment."""
    joints = [
        turning("crank_pin", "ground", "crank"),
        turning("block_pin", "crank", "block", shift(0.3, 0.0), passive=True),
        turning("rocker_pin", "ground", "rocker", shift(-0.8, 0.0), passive=True),
    ]
    links = [
        link("crank", "m1", 0.1, "I1"),
        link("block", "m2", 0.05, "I2"),
        link("rocker", "m3", 0.4, "I3"),
    ]
    model = assembled("collar", links, joints, [Mount("end", "rocker", shift(1.2, 0.0))], "end")
    return model.with_loop("collar", "prismatic", ("rocker", "block"), axis=(1.0, 0.0))


GENERATED = {
    "cart-pole": cart_and_pole,
    "acrobot": lambda: fb.planar("RR").replace(actuated=["joint2"]),
    "tree": tree,
    "PRP": lambda: fb.planar("PRP"),
    "RPR": lambda: fb.planar("RPR"),
    "collar": collar,
}


@cache
def model_of(name: str) -> fb.Model:
    return GENERATED[name]() if name in GENERATED else fb.load(name)


@cache
def derived(name: str, method: str) -> Derivation:
    options = OPEN.get(method, {})
    return fb.derive(model_of(name), method.split(" ")[0], **options)


@cache
def drawn(name: str, method: str) -> dict[str, Drawing]:
    return illustrations(derived(name, method))


CASES = [
    *(
        (name, method)
        for name in ("2R", "3R", "RP", "pendulum", *GENERATED)
        if name != "collar"
        for method in OPEN
    ),
    *(
        (name, method)
        for name in ("four_bar", "five_bar", "five_bar_rods", "slider_crank")
        for method in CLOSED
    ),
    ("collar", "statics"),
]


def spoken(derivation: Derivation) -> set[str]:
    """Labels of the symbols in all equations, and of forces in sentences."""
    lines = [line for step in derivation.steps for line in step.equations]
    lines += [x for row in derivation.glossary for x in row.symbols]
    named = {
        canonical(label(x)) for line in lines for x in ex.nodes(line) if isinstance(x, ex.Symbol)
    }
    words = " ".join(step.reason for step in derivation.steps)
    return named | {f"{letter}_{{{low}}}" for letter, low in re.findall(r"([fn])_(\d+,\d+)", words)}


POINT = re.compile(r"[A-OP]′*|C_\{?\d+\}?|[xyzXYZ]|")


def said(drawing: Drawing) -> set[str]:
    """The names that stand beside arrows, arcs, lengths and places, without signs."""
    found = set()
    for e in drawing.elements:
        if isinstance(e, Label):
            found |= {canonical(part) for part in e.text.split(", ")}
        elif isinstance(e, Arrow | Dimension | Arc | Turn) and e.label:
            found.add(canonical(e.name).removeprefix("−"))
    return {name for name in found if not POINT.fullmatch(name)}


@pytest.mark.sample(3)
@pytest.mark.parametrize(("name", "method"), CASES)
def test_names_in_drawings_are_those_of_the_equations(name: str, method: str):
    derivation = derived(name, method)
    names = spoken(derivation) | {f"{m} g" for m in spoken(derivation)}
    for figure, drawing in drawn(name, method).items():
        assert said(drawing) <= names, (figure, said(drawing) - names)


# ---------------------------------------------------------------- by value
def values_of(derivation: Derivation) -> dict[str, object]:
    """In the state of the drawings, the values of all that the equations define, by name in code:
    read as a reader would, line by line, each right side from what is known."""
    seen = illustrate._shown(derivation)
    s = derivation.equations.symbols
    values: dict[str, object] = dict(seen.model.parameters)
    for ending, array in (("", seen.q), ("_d", seen.qd), ("_dd", seen.qdd)):
        values |= {x + ending: float(array[k]) for k, x in enumerate(s.coordinates)}
    if seen.wrenches is not None:
        values |= dict(zip(("fx", "fy"), seen.wrenches, strict=False))
    if derivation.system is not None and getattr(derivation.system, "multipliers", None):
        found = derivation.system.multipliers
        if hasattr(found[0], "below"):
            values |= {f"lam{k}": float(x.evaluate(values)) for k, x in enumerate(found, 1)}
    lines = [line for step in derivation.steps for line in step.equations]
    for line in lines * 2:
        name = line.sides[0]
        if isinstance(name, ex.Symbol) and name.name not in values:
            value = value_of(line, values, seen.model.gravity)
            if value is not None:
                values[name.name] = (
                    np.zeros(seen.model.dim) if name.bold and np.ndim(value) == 0 else value
                )
    return values


def value_of(line: ex.Equation, values: dict[str, object], gravity: np.ndarray) -> object | None:
    """Of the last side that can be evaluated; g is the field where it is bold, and its magnitude
    elsewhere."""
    for side in reversed(line.sides[1:]):
        inside = set(ex.nodes(side))
        if INVERSE not in inside:
            try:
                return evaluate(side, values | {"g": gravity} if GRAVITY in inside else values)
            except fb.FreebodyError:
                continue
    return None


GRAVITY, INVERSE = ex.Symbol("g", "g", bold=True), ex.power("J", -1)


@pytest.mark.sample(8)
@pytest.mark.parametrize(("name", "method"), CASES)
def test_arrows_have_the_values_and_signs_of_the_equations(name: str, method: str):
    derivation = derived(name, method)
    values = values_of(derivation)
    symbols = [x for step in derivation.steps for line in step.equations for x in ex.nodes(line)]
    known = {
        canonical(label(x)): values[x.name]
        for x in symbols
        if isinstance(x, ex.Symbol) and x.name in values
    }
    compared = set()
    for figure, drawing in drawn(name, method).items():
        for e in drawing.elements:
            shown = canonical(e.name).removeprefix("−")
            if not isinstance(e, Arrow | Turn) or shown not in known or e.role in ("soft", "z"):
                continue
            sign = -1.0 if e.name.startswith("−") else 1.0
            expected = sign * np.asarray(known[shown], dtype=float)
            value = (
                e.value
                if isinstance(e, Turn) or (len(e.value) == 1 and expected.ndim == 0)
                else np.array(e.value)
            )
            np.testing.assert_allclose(
                np.squeeze(value), np.squeeze(expected), atol=1e-6, err_msg=f"{figure} {e.name}"
            )
            if isinstance(e, Arrow):
                way = np.subtract(e.end, e.start)
                along = (
                    float(expected) * way / np.linalg.norm(way) if expected.ndim == 0 else expected
                )
                if expected.ndim:
                    assert way @ along > 0.999999 * np.linalg.norm(way) * np.linalg.norm(along), (
                        e.name
                    )
            compared.add(shown)
    if "free-body 1" in drawn(name, method) and "f_{0,1}" in known:
        assert {x for x in compared if x.startswith("f_")}, "forces were compared"


@pytest.mark.parametrize("name", ["four_bar", "five_bar_rods", "slider_crank", "collar"])
def test_rows_of_reactions_are_the_values_of_the_names(name: str):
    """f_{i,k} of a loop: what the equations say, what `reactions` returns under the loop's name,
    and what is drawn."""
    values, seen = values_of(derived(name, "statics")), illustrate._shown(derived(name, "statics"))
    naming = Naming(seen.model)
    found = fb.reactions(seen.model, seen.q, seen.qd, qdd=seen.qdd, wrenches=seen.wrenches)
    for k, loop in enumerate(seen.model.loops):
        force, moment = naming.loop_force(k), naming.loop_moment(k)
        np.testing.assert_allclose(values[force.name], found[loop.name][:2], atol=1e-6)
        if isinstance(moment, ex.Symbol):
            np.testing.assert_allclose(values[moment.name], found[loop.name][2], atol=1e-6)
        loads = [x for body in seen.loads for x in body.loads]
        shown = {x.name: x.force for x in loads}
        for sign, value in (("", 1.0), ("−", -1.0)):
            if sign + label(force) in shown:
                np.testing.assert_allclose(
                    shown[sign + label(force)], value * found[loop.name][:2], atol=1e-6
                )
    for n, body in enumerate(seen.model.bodies, 1):
        force = naming.force(naming.parent(n), n)
        np.testing.assert_allclose(values[force.name], found[body.joint.name][:2], atol=1e-6)


@pytest.mark.parametrize("method", ["newton-euler", "recursive with weights"])
def test_forces_in_space_have_the_values_of_the_equations(method: str):
    """There the equations give components in each body's own axes."""
    values, seen = values_of(derived("scara", method)), illustrate._shown(derived("scara", method))
    for n, drawing in ((n, drawn("scara", method)[f"free-body {n}"]) for n in (3, 4)):
        arrow = drawing.named(f"f_{{{n - 1},{n}}}")
        assert isinstance(arrow, Arrow)
        own = seen.pose.bodies[n - 1].rotation @ np.asarray(values[f"f{n - 1}{n}"])
        np.testing.assert_allclose(arrow.value, own, atol=1e-6)


@pytest.mark.parametrize(
    "name", ["2R", "RP", "tree", "cart-pole", "four_bar", "slider_crank", "collar"]
)
@pytest.mark.parametrize("method", ["newton-euler", "statics"])
def test_free_bodies_balance_as_they_are_printed(name: str, method: str):
    """Newton's and Euler's equation of each body, with the values that the page gives all that
    stands in them."""
    if method == "newton-euler" and name in ("four_bar", "slider_crank", "collar"):
        pytest.skip("closed chains have statics only")
    derivation, model = derived(name, method), illustrate._shown(derived(name, method)).model
    values = values_of(derivation) | {"g": model.gravity}
    for step in derivation.steps:
        if step.operation.startswith("Free body"):
            for left, right in (line.sides for line in step.equations[:2]):
                np.testing.assert_allclose(
                    evaluate(left, values), evaluate(right, values), atol=1e-6
                )


@pytest.mark.sample(9)
@pytest.mark.parametrize(
    ("name", "method"), [case for case in CASES if case[1] in ("newton-euler", "statics")]
)
def test_the_second_body_in_a_forces_name_is_the_one_it_acts_on(name: str, method: str):
    """f_{i,k} stands on body k, its opposite on body i; and a weight is the mass of that name,
    times g."""
    masses = {
        label(Naming(model_of(name)).mass(n)): n for n in range(1, len(model_of(name).bodies) + 1)
    }
    known = illustrate._shown(derived(name, method)).model.parameters
    for figure, drawing in drawn(name, method).items():
        for e in drawing.elements if figure.startswith("free-body") else ():
            n = figure.split()[1]
            pair = re.fullmatch(r"(−?)[fn]′*_\{(\d+),(\d+)\}", e.name)
            if pair:
                assert pair[2 if pair[1] else 3] == n, f"{e.name} on body {n}"
            if isinstance(e, Arrow) and e.role == "weight":
                mass = next(x for x in known if label(sym(x)) == e.name.removesuffix(" g"))
                assert masses[e.name.removesuffix(" g")] == int(n)
                assert np.linalg.norm(e.value) == pytest.approx(known[mass] * 9.81)


# ---------------------------------------------------------------- joints without motor
PASSIVE = {"cart-pole": 2, "acrobot": 1}


@pytest.mark.parametrize("name", PASSIVE)
@pytest.mark.parametrize("method", [m for m in OPEN if m != "kinematics"])
def test_no_motor_is_derived_or_drawn_in_a_passive_joint(name: str, method: str):
    derivation, torque = derived(name, method), f"τ_{PASSIVE[name]}"
    assert torque not in spoken(derivation)
    for drawing in drawn(name, method).values():
        assert torque not in said(drawing)
    zeros = [
        line for step in derivation.steps for line in step.equations if line.sides[0] == ex.ZERO
    ]
    assert zeros, "0 = … in its place"
    assert "passive" in derivation.given


@pytest.mark.parametrize("name", PASSIVE)
def test_free_bodies_and_equations_show_no_motor_in_a_passive_joint(name: str):
    model, torque = model_of(name), f"τ_{PASSIVE[name]}"
    seen = illustrate._shown(derived(name, "newton-euler"))
    loads = [x for body in seen.loads for x in body.loads]
    assert torque not in {x.moment_name.removeprefix("−") for x in loads}
    lines = str(fb.equations(model)).splitlines()
    assert (
        [line.split(" = ")[0] for line in lines[:2]] == ["τ₁", "0"]
        if name == "cart-pole"
        else ["0", "τ₂"]
    )
    for view in ("expanded", "intermediates", "base"):
        text = fb.equations(model).text(view)
        assert "0 = " in text
        assert f"τ{'₁₂'[PASSIVE[name] - 1]}" not in text


def test_a_moment_that_a_pin_cannot_give_is_not_hidden():
    """A pole held out level: what its pin would have to give stands in the free body, not as its
    motor's."""
    figure = fb.free_body_diagram(
        cart_and_pole().bind(mc=1, mp=1, lp=0.5, Ip=0.1, l=1, g=9.81), [0.0, 0.0]
    )
    pole = figure.bodies[1]
    assert pole.loads[0].moment_name == "n_{1,2}"
    assert pole.loads[0].moment[0] == pytest.approx(9.81 * 0.5)


def test_weights_are_drawn_where_the_equations_have_them():
    for method, drawn_there in (
        ("recursive", False),
        ("recursive with weights", True),
        ("newton-euler", True),
    ):
        drawing = drawn("2R", method)["free-body 2"]
        assert ("m_2 g" in {e.name for e in drawing.elements}) is drawn_there
        assert (
            any("gravity is in the accelerations" in note for note in drawing.notes)
            is not drawn_there
        )


def test_kinematics_draws_the_motion_of_the_tip():
    figures = drawn("2R", "kinematics")
    assert figures["tip"].named("r_P")
    assert figures["tip velocity"].named("ṙ_P")
    assert figures["tip acceleration"].named("r̈_P")
    assert not any("c" in e.name for e in figures["tip velocity"].arrows)


def test_a_body_without_mass_is_not_said_to_have_its_weight_elsewhere():
    assert not drawn("gyro", "newton-euler")["free-body 1"].notes
    assert drawn("gyro", "recursive")["free-body 2"].notes


@pytest.mark.parametrize(
    ("name", "figure", "missing"),
    [("cart_pole", "free-body 1", "n_{0,1}"), ("slider_crank", "free-body 3", "n_{0,3}")],
)
def test_forces_that_are_not_drawn_are_said_to_be_zero(name, figure, missing):
    assert drawn(name, "newton-euler")[figure].notes == [f"Zero in the drawn state: {missing}"]
    assert not drawn("2R", "newton-euler")["free-body 1"].notes


def test_the_page_of_a_closed_chain_can_be_tried_where_no_loop_slides():
    """Rods and pins transmit forces at points, of which the page tells where they act."""
    for name, tried in (("five_bar_rods", True), ("slider_crank", True), ("collar", False)):
        assert ('class="slider"' in derived(name, "newton-euler").html()) is tried, name
