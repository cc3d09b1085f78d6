"""Models in which each body has a single mass, centre of mass and inertia, as derivations require.

A body and what is fixed to it, such as a payload or a link behind a fixed joint, are one rigid
body. Numbers are added up. Where there are parameters among them, the centre of mass would be a
fraction of polynomials: the whole then has parameters of its own, m_t2, c_t2x, …, I_t2, with t for
total, whose values are those of the parts together.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from freebody.elementary import Scalar
from freebody.errors import FreebodyError, listed
from freebody.expressions.polynomials.symbols import RATE, Formulas, Symbols, symbols
from freebody.expressions.typesetting.literal import literal
from freebody.model.bodies import Body
from freebody.model.inertia import Inertia, combined
from freebody.model.losses import require_lossless
from freebody.model.model import Model
from freebody.model.parameters import Parameter, Quantity, each_parameter
from freebody.model.placement import Placement
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached, Mass
from freebody.spatial import of_dimension
from freebody_textbook.methods.free_body_steps import UNITS, XYZ, mark_of, thrusts_of

_ENTRIES = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))  # of a tensor, as it is stored


def symbols_of_bodies(
    what: str,
    model: Model,
    extra: tuple[str, ...] = (),
    euler: bool = False,
    formulas: Formulas = (),
    turned: tuple[tuple[int, ...], ...] | None = None,
    quarters: tuple[int, ...] = (),
) -> Symbols:
    """The symbols of a model for a derivation body by body, with each body's parts combined; raises
    an error for models that are not supported. Arguments as for `symbols`."""
    require_lossless(what, model)
    how = {"extra": extra, "euler": euler, "formulas": formulas}
    how |= {"turned": turned, "quarters": quarters}
    made = symbols(model, **how)
    _require_single_joints(made, what)
    masses = {body.name: body.masses for body in made.tree.bodies}
    if all(len(own) < 2 for own in masses.values()):
        return made
    taken = set(model.parameters)
    numbers = {body.name: n for n, body in enumerate(made.model.bodies, 1)}
    bodies = tuple(
        _whole(body, masses[body.name], numbers[body.name], model.dim, taken)
        if len(masses[body.name]) > 1
        else body
        for body in model.bodies
    )
    return symbols(replace(model, bodies=bodies), **how)


def _require_single_joints(symbols: Symbols, what: str) -> None:
    """Raise an error for models that cannot be derived body by body: joints with several
    coordinates, and in closed chains joints that follow others."""
    model = symbols.model
    for body in model.bodies:
        follows = bool(model.loops) and body.joint.mimic is not None
        if body.kind.nv != 1 or follows:
            instead = (
                "fb.loop_equations gives those of its loops"
                if model.loops
                else "fb.equations gives the closed form"
            )
            raise FreebodyError(
                f"{what}: joint {body.joint.name!r} of {model.name!r} is {body.kind.name}"
                f"{' and follows another' if follows else ''}; derivations"
                f"{' of closed chains' if follows else ''} are written "
                f"for {'independent ' if follows else ''}joints of one coordinate: {instead}."
            )


def sentences_on_whole_bodies(model: Model, made: Symbols, apart: bool = True) -> list[str]:
    """A sentence for each body that consists of several parts; made: the symbols from
    `symbols_of_bodies`; apart: joints are counted by their single coordinates."""
    assert made.given is not None
    names = [x.name for x in (made.model if apart else model).bodies]
    sentences = []
    for body, one in zip(model.bodies, made.given.bodies, strict=True):
        if body is not one:
            own = f"Body {names.index(body.name) + 1}" if apart or len(names) > 1 else "The body"
            parts = listed([literal(part.link) for part in body.inertias])
            sentences.append(
                f"{own} is {parts} as one rigid body: its mass, centre of mass and inertia are "
                f"those of the whole."
            )
    return sentences


def _whole(body: Body, masses: Sequence[Mass], n: int, dim: int, taken: set[str]) -> Body:
    parameters = list(each_parameter(body.inertias))
    value = None if any(p.value is None for p in parameters) else _value(body, dim)
    if value is None or parameters:
        value = _named(masses, n, dim, taken, value)
    return replace(body, inertias=(Attached(body.name, value),))


def _value(body: Body, dim: int) -> Inertia:
    space = of_dimension(dim)
    return combined(
        [part.inertia.placed(*part.placement.lower(space, VALUES)) for part in body.inertias]
    )


def _named(
    masses: Sequence[Mass], n: int, dim: int, taken: set[str], value: Inertia | None
) -> Inertia:
    """Parameters for a combined body's mass, centre of mass and inertia, except entries that are
    zero for all parts."""

    def parameter(letter: str, ending: str, number: Callable[[Inertia], Quantity]) -> Parameter:
        while f"{letter}{n}{ending}" in taken:
            letter += "t"
        return Parameter(f"{letter}{n}{ending}", None if value is None else number(value))

    off = [any(not _is_zero(mass.c[k]) for mass in masses) for k in range(dim)]
    com = [
        parameter("c_t", "xyz"[k], lambda x, k=k: x.com[k]) if off[k] else 0.0 for k in range(dim)
    ]
    mass = parameter("m_t", "", lambda x: x.mass)
    if dim == 2:
        return Inertia(mass, tuple(com), (parameter("I_t", "", lambda x: x.tensor[0]),))
    tensor = [
        parameter("I_t", "xyz"[i] + "xyz"[k], lambda x, entry=entry: x.tensor[entry])
        if i == k or (off[i] and off[k]) or any(not _is_zero(m.inertia[i][k]) for m in masses)
        else 0.0
        for entry, (i, k) in enumerate(_ENTRIES)
    ]
    return Inertia(mass, tuple(com), tuple(tensor))


def _is_zero(x: Scalar) -> bool:
    return x == 0.0 if isinstance(x, float) else x.is_zero


# ---------------------------------------------------------------- bodies that nothing holds
def are_free(model: Model) -> bool:
    """Whether all bodies of a model are free, moving relative to world axes.

    It is the same of a model with loads on its bodies and of that with each load part of its body.
    """
    return model.dim == 3 and all(
        body.kind.frees(3)
        and body.kind.quaternion is not None
        and body.parent < 0
        and body.joint.placement == Placement()
        and len(body.inertias) > 0
        for body in model.bodies
    )


def velocity_names(model: Model) -> tuple[str, ...]:
    """Names of symbols that free bodies add: components of v and ω, their derivatives, and thrusts;
    empty for other models."""
    if not are_free(model):
        return ()
    moving = [
        f"{letter}{mark_of(model, k)}_{axis}{dots}"
        for dots in (RATE, "")  # accelerations stand first in equations
        for k in range(len(model.bodies))
        for letter in UNITS
        for axis in XYZ
    ]
    return (*moving, *thrusts_of(model))
