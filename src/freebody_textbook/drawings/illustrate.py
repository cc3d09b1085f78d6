"""The drawings of a derivation: the robot with names, and with the steps vectors, velocities and
free bodies."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from freebody.arrays import Array
from freebody.errors import listed
from freebody.expressions.expression import Expression, Symbol, nodes
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.expressions.printed_names import sym, vec
from freebody.figures import colours
from freebody.figures.drawing import SAME, Drawing, Element, Label
from freebody.figures.drawing_names import is_letter
from freebody.figures.figure import save, to_one_scale
from freebody.figures.kinematic import VIEWS
from freebody.figures.labelling import labels_of
from freebody.figures.layers import forces, measures, motion
from freebody.figures.layers.bare_robot import Layer, drawn
from freebody.figures.marked_text import bold, canonical, label
from freebody.figures.skeleton import BodyPlace
from freebody.figures.snapshot import Snapshot, resting_pose, snapshot, with_values
from freebody.figures.svg import picture
from freebody.model.model import Model
from freebody.outputs.number_text import significant
from freebody_textbook.closed_chains.absolute import links_of
from freebody_textbook.derivation import Derivation, Drawings, Step
from freebody_textbook.living.drawn_bodies import PageFigure
from freebody_textbook.living.living import living
from freebody_textbook.methods import METHODS
from freebody_textbook.methods.free_body_steps import mass_symbol, thrusts_of
from freebody_textbook.methods.setting import LOADS
from freebody_textbook.methods.whole_bodies import are_free
from freebody_textbook.render.documents import LivingParts

WIDE, TALL = 460.0, 400.0
_FREE = "free "
"""The first word of names of drawings of bodies that nothing holds."""
_DARK = "@media screen and (prefers-color-scheme:dark)"
_LOAD = {2: (0.85, -0.53), 3: (0.5, -0.65, -0.6)}
"""Direction of the load on the tip in drawings."""


def living_parts(derivation: Derivation) -> LivingParts | None:
    """The interactive parts of a derivation's page; None if no drawing shows the robot."""
    seen = _lettered(derivation)
    drawing = _drawn(seen, "overview", forces.scales_of(seen.loads))
    return drawing and living(
        derivation, _page_figure(derivation, seen, drawing, _spoken(derivation))
    )


def drawings(derivation: Derivation, labels: str = "names") -> Drawings:
    """The drawings as SVG text: "overview", and each figure that a step refers to and that can be
    drawn."""
    shown = illustrations(derivation, labels).items()
    return Drawings(
        {name: picture(drawing, WIDE, TALL).inline() for name, drawing in shown},
        colours.style(_DARK),
    )


def write_drawings(derivation: Derivation, document: Path, labels: str = "names") -> dict[str, str]:
    """Write each drawing as an SVG file beside a document; returns the file names by figure, for
    `Derivation.markdown`."""
    names = {}
    for name, drawing in illustrations(derivation, labels).items():
        target = document.with_name(f"{document.stem}-{name.replace(' ', '-')}.svg")
        save(picture(drawing, WIDE, TALL), target, "a drawing")
        names[name] = target.name
    return names


def illustrations(derivation: Derivation, labels: str = "names") -> dict[str, Drawing]:
    """The drawings as data, by name; labels: "names", "values" or "both"."""
    labels = labels_of("a derivation's drawings", derivation.equations.symbols.model, labels)
    moving, spoken = _lettered(derivation), _spoken(derivation)
    wanted: dict[str, Step | None] = {"overview": None}
    for step in derivation.steps:
        if step.figure:
            wanted.setdefault(step.figure, step)
    found, scales = {}, forces.scales_of(moving.loads)
    for name, step in wanted.items():
        drawing = _noted(moving, name, step, scales, labels)
        if drawing is not None:
            drawing.labels = labels
            drawing.elements = [e for e in drawing.elements if _is_spoken_of(e, spoken)]
            found[name] = drawing
    single = [name for name in found if name.startswith("free-body")]
    alike = [scales[int(name.split()[1]) - 1].longest for name in single]
    to_one_scale([found[name] for name in single], WIDE, TALL, alike)
    return found


def _noted(
    moving: Snapshot, name: str, step: Step | None, scales: Sequence[forces.Scale], labels: str
) -> Drawing | None:
    """The drawing that a step refers to by name (without a step: the first figure), with its
    notes."""
    weights = step is None or _has_weights(step)
    seen = replace(moving, names=replace(moving.names, weights=weights))
    drawing = _drawn(seen, name, scales)
    if drawing is None:
        return None
    loaded = name.startswith(("free-body", "carried"))
    if loaded and not weights and _is_heavy(seen, name):
        drawing.notes = ["No weights: gravity is in the accelerations"]
    drawing.notes += _vanishing(step, drawing) if step else []
    if labels != "names" and step is None:
        drawing.notes += _state(seen)
    return drawing


def _state(seen: Snapshot) -> list[str]:
    """Lines that describe the state drawn."""
    arrays = (("q", seen.q), ("q̇", seen.qd), ("q̈", seen.qdd))
    rows = [f"{name} = ({', '.join(significant(x) for x in array)})" for name, array in arrays]
    if seen.wrenches is not None:
        force = ", ".join(significant(x) for x in np.asarray(seen.wrenches)[: seen.model.dim])
        rows.append(f"f = ({force}) N at the tip")
    return [f"Values in these drawings: {rows[0]}", *rows[1:]]


def _spoken(derivation: Derivation) -> set[str]:
    """Labels of all symbols in a derivation's equations and its table of symbols."""
    printed: list[Expression] = [line for step in derivation.steps for line in step.equations]
    printed += [x for row in derivation.glossary for x in row.symbols]
    symbols = (x for line in printed for x in nodes(line) if isinstance(x, Symbol))
    return {canonical(label(symbol)) for symbol in symbols}


def _has_weights(step: Step) -> bool:
    """Whether a step's forces include weights; False if the accelerations contain gravity."""
    used = (x for line in step.equations for x in nodes(line) if isinstance(x, Symbol) and x.bold)
    return any(x.name.rstrip("0123456789") == "g" for x in used)


def _vanishing(step: Step, drawing: Drawing) -> list[str]:
    """Phrases for forces and moments that a free body's equations contain but its drawing does not,
    as they vanish."""
    if not step.operation.startswith("Free body "):
        return []
    shown = {canonical(e.name.removeprefix("−")) for e in drawing.elements}
    used = (x for line in step.equations for x in nodes(line) if isinstance(x, Symbol))
    loads = dict.fromkeys(x for x in used if x.letter in ("f", "n", "τ") and not x.dots)
    missing = [label(x) for x in loads if canonical(label(x)) not in shown]
    return [f"Zero in the drawn state: {', '.join(missing)}"] if missing else []


def _is_heavy(seen: Snapshot, name: str) -> bool:
    """Whether the body of a drawing `free-body N`, or a body that it carries, has weight."""
    alone = name.startswith("free-body") and not seen.pose.bodies[int(name.split()[1]) - 1].mass
    return bool(np.any(seen.model.gravity)) and not alone


_QUANTITIES = ("position", "velocity", "acceleration", "dimension", "angle", "z")


def _is_spoken_of(element: Element, spoken: set[str]) -> bool:
    """Whether a drawn element is kept: vectors, lengths and coordinates only if the derivation uses
    their names."""
    named = getattr(element, "label", "") and element.name not in ("X", "Y", "Z")
    free = element.role not in _QUANTITIES or not named
    return free or canonical(element.name) in spoken


def _shown(derivation: Derivation) -> Snapshot:
    """The state to be drawn, chosen to be clearly visible: in motion or at rest; with a load on the
    tip if the equations have one."""
    symbols = derivation.equations.symbols
    drawn_by = [step.figure for step in derivation.steps if step.figure]
    apart = any(not name.startswith(_FREE) for name in drawn_by)  # its joints taken apart
    free = symbols.given is not None and not apart and are_free(symbols.given)
    model = with_values(symbols.given if free and symbols.given else symbols.model)
    still = np.zeros(model.nv) if METHODS[derivation.method].at_rest else None
    load = _tip_load(model) if "fx" in symbols.extra else None
    q = None if still is None else resting_pose(model, load)
    links = set(links_of(symbols)) if symbols.model.loops else set()
    unseen = frozenset(k for k, at in enumerate(symbols.tree.body_of) if at in links)
    return replace(snapshot(model, q, still, still, load), links=unseen)


def _lettered(derivation: Derivation) -> Snapshot:
    """The drawn state with the names in the derivation's letters."""
    seen = _shown(derivation)
    naming = replace(seen.names.naming, letters=derivation.lettering)
    return replace(seen, names=replace(seen.names, naming=naming))


def _tip_load(model: Model) -> list[float]:
    """A load for the tip, comparable to the robot's weight, or 10 N if it has none."""
    size = 0.6 * model.mass * float(np.linalg.norm(model.gravity)) or 10.0
    return [*(size * x for x in _LOAD[model.dim]), *[0.0] * (1 if model.dim == 2 else 3)]


def _drawn(seen: Snapshot, name: str, scales: Sequence[forces.Scale]) -> Drawing | None:
    """The drawing with a name used by a step; None if this robot has none. scales: of the force
    arrows on each free body."""
    dim = seen.model.dim
    kind, _, number = name.rpartition(" ")
    if kind == "free-body":
        body = seen.pose.bodies[int(number) - 1]
        return forces.alone(seen, body, forces.BOOK[dim], scales[body.index])
    if name.startswith(_FREE):
        return _free(seen, int(number))
    if kind in ("carried", "partial") and dim == 3:
        return None
    if kind == "carried":
        return forces.carried(seen, seen.pose.bodies[int(number) - 1])
    if kind == "partial":
        moved = [str(n) for n in seen.names.naming.together(int(number))]
        only = f"only joint {number} moves," if len(moved) == 1 else ""
        only = only or f"only joints {listed(moved)} move, joint {number}"
        note = f"Partial velocities: {only} at unit rate"
        alone = partial(motion.partial_of_centres, joint=int(number))
        layers: tuple[Layer, ...] = (*_GEOMETRY, alone)
    elif name in _RECIPES[dim]:
        note, layers = _RECIPES[dim][name]
        if name == "overview" and not any(body.kind.holds for body in seen.model.bodies):
            note = _UNHELD
    else:
        return None
    drawing = drawn(seen, note.lower(), layers, faint=name == "tip")
    drawing.notes = [note]
    return drawing


def _free(seen: Snapshot, number: int) -> Drawing:
    """Drawing of a free body with its thrusts."""
    own = {x: f.name for x, f in thrusts_of(seen.model).items() if f.body == number - 1}
    names = {canonical(label(sym(x))): frame for x, frame in own.items()}
    mass = canonical(label(mass_symbol(seen.model, number - 1)))
    return forces.pushed(seen, seen.pose.bodies[number - 1], names, mass)


def _load(drawing: Drawing, seen: Snapshot) -> None:
    """Draw the force on the tip, if there is one."""
    if seen.wrenches is not None:
        forces.act(drawing, seen, seen.pose.bodies[seen.model.frame().body], ("external",))


def _tip(*layers: Layer) -> dict[str, tuple[str, tuple[Layer, ...]]]:
    """Drawing recipes for position, velocity and acceleration of the tip, and the joint rates, with
    the given layers."""
    r, v, a = (label(vec("r_P" + ending)) for ending in ("", "_d", "_dd"))
    rates, second = motion.rates, partial(motion.rates, second=True)
    to_tip = partial(measures.to_tip, name=r)
    velocity = partial(motion.of_tip, name=v)
    acceleration = partial(motion.of_tip, name=a, second=True)
    return {
        "tip": ("Position of the tip", (*layers, measures.links, to_tip)),
        "tip velocity": ("The velocity of the tip", (*layers, rates, velocity)),
        "tip acceleration": ("The acceleration of the tip", (*layers, second, acceleration)),
    }


_LENGTHS: tuple[Layer, ...] = (
    measures.all_lengths, measures.of_the_ground, measures.of_rods,
)  # fmt: skip
_GEOMETRY: tuple[Layer, ...] = (
    measures.angles,
    measures.slides,
    measures.centres,
)
_BESIDE: tuple[Layer, ...] = (
    measures.centres, partial(measures.links, aside=measures.BESIDE),
    measures.to_centres, measures.directions,
)  # fmt: skip
_UNHELD = "The body in a pose where its axes are those of the world"
_PLANE, _SPACE = VIEWS[2], VIEWS[3]
_RECIPES: dict[int, dict[str, tuple[str, tuple[Layer, ...]]]] = {
    2: {
        "overview": (
            "Coordinates, lengths and centres of mass", (*_GEOMETRY, *_LENGTHS, _load)
        ),
        "vectors": ("The vectors, drawn beside the bodies they lie on", _BESIDE),
        "centres": ("Where the centres of mass are", _PLANE["centres"]),
        "velocities": (
            "Joint rates and velocities of the centres of mass", _PLANE["velocities"]
        ),
        "accelerations": (
            "Joint accelerations and accelerations of the centres of mass", _PLANE["accelerations"]
        ),
        **_tip(measures.angles, measures.slides),
    },
    3: {
        "overview": (
            "Joint axes and joint variables",
            (*_SPACE["frames"], measures.measured_centres, *_LENGTHS, _load),
        ),
        "vectors": ("Vectors from joint to joint, and centres of mass", _SPACE["vectors"]),
        **_tip(measures.variables),
    },
}  # fmt: skip
"""Drawings by dimension and by the name that steps give them: a line of words, and the layers."""


def _page_figure(
    derivation: Derivation, seen: Snapshot, drawing: Drawing, spoken: Collection[str]
) -> PageFigure:
    """Data of a derivation's first figure and its state, for the interactive page; spoken: names in
    the equations, the only ones used as labels."""
    written = {e.text for e in drawing.elements if isinstance(e, Label)}
    joints = {seen.names.point(seen.pose, body.number) for body in seen.pose.bodies}
    joints |= {seen.names.tip}
    rods = list(map(seen.names.rod, range(len(seen.model.loops))))
    return PageFigure(
        bodies=[_names(seen, body, written, spoken) for body in seen.pose.bodies],
        tip=seen.names.tip,
        points={x: x for x in seen.pose.frames if is_letter(x) and x in written - joints},
        rods=[x if canonical(x) in spoken else "" for x in rods],
        start=_start(derivation.plain or derivation, seen),
        view=drawing.view,
        pose=seen.pose,
        links=seen.links,
        formula=_formula,
    )


def _formula(name: Expression) -> str:
    """HTML of a name, bold for vectors."""
    vector = any(isinstance(x, Symbol) and x.bold for x in nodes(name))
    return bold(label(name)) if vector else label(name)


def _names(
    seen: Snapshot, body: BodyPlace, written: Collection[str], spoken: Collection[str]
) -> dict[str, str]:
    """Labels beside a body and its joint, by the element that they name."""
    names, n, plane = seen.names, body.number, seen.model.dim == 2
    lengths = _lengths(seen, body)
    found = {what: name for what, name in lengths.items() if canonical(name) in spoken}
    point = names.point(seen.pose, n)
    found["point"] = point if plane and point in written else ""
    centred = plane or names.naming.centre_length(n) is not None
    found["C"] = names.on("C", n) if centred and body.mass > 0 else ""
    found["q"] = names.coordinate(body) if plane or body.axis is not None else ""
    if not plane and body.axis is not None:
        found["z"] = names.axis(body) if canonical(names.axis(body)) in spoken else ""
    return {what: name for what, name in found.items() if name}


def _lengths(seen: Snapshot, body: BodyPlace) -> dict[str, str]:
    """Names of a body's lengths; "" for those that it does not have, or that share a name."""
    names = seen.names
    lengths = {
        "lc": names.centre_length(body) if body.mass > 0 else "",
        "l": names.length(body, body.ends[0]) if body.ends else "",
        "ground": names.on_the_ground(body) if body.parent < 0 and not body.kind.slides else "",
    }
    same = bool(body.ends) and np.linalg.norm(body.ends[0].place - body.com) < SAME
    if same and lengths["lc"] == lengths["l"]:
        lengths["lc"] = ""
    return lengths


# ---------------------------------------------------------------- the state
def _start(derivation: Derivation, seen: Snapshot) -> dict[str, float]:
    """Initial values of the symbols, those of the figure."""
    symbols, model = derivation.equations.symbols, seen.model
    found = {name: x for name, x in model.parameters.items() if x is not None}
    arrays = (("", seen.q), (RATE, seen.qd), (SECOND, seen.qdd))
    for ending, values in arrays:
        if len(values) == len(symbols.coordinates):
            own = _own(symbols, np.asarray(values), ending == "")
            found |= {x + ending: float(v) for x, v in zip(symbols.coordinates, own, strict=True)}
    if seen.wrenches is not None:
        found |= dict(zip(LOADS[model.dim], map(float, np.asarray(seen.wrenches)), strict=False))
    return found


def _own(symbols: Symbols, joints: Array, positions: bool) -> Array:
    """Values of the equations' coordinates, computed from those of the joints."""
    turned, quarters = symbols.turned, symbols.quarters if positions else ()
    own = joints if turned is None else np.linalg.solve(np.array(turned, dtype=float), joints)
    return np.asarray(own - math.pi / 2 * np.array(quarters or 0.0), dtype=float)
