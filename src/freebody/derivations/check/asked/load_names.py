"""What answers call a force and a moment at the tip."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator

from freebody.derivations.check.asked.right_equations import RightEquations
from freebody.derivations.polynomials.symbols import symbols as symbols_of
from freebody.model.model import Model
from freebody.scalars.trig import Trig

LOADS = {2: ("fx", "fy", "nz"), 3: ("fx", "fy", "fz", "nx", "ny", "nz")}
"""Force and moment at the tip, in the order of the Jacobian's rows."""
_COMPONENT = re.compile(r"(?<![A-Za-z\\])(?:[Ff]_?\{?(?:[PpEe]|tip)?_?\{?[xyz]|[MnN]_?\{?[xyz])")
_HAND = re.compile(r"(?<![A-Za-z\\])[aos]_?\{?[xyz]\}?\s{0,3}&?=")
"""An axis of the hand: n_x beside it is one too."""
_VECTOR = re.compile(r"(?<![A-Za-z\\])(?:[Ff](?:_?\{?(?:[PpEe]|tip)\}?)?|W)(?!\w)")
"""A force without its components: in an answer with the Jacobian."""
JOINT_FORCE = re.compile(r"(?<![A-Za-z\\])(?:f|\\(?:mathbf|boldsymbol|vec)\{f\})_?\{?[0-9₀-₉]")
"""The force in a joint, f_12."""
MOMENT = re.compile(r"(?<![A-Za-z\\])[MnN]_?\{?[xyz]")
"""A moment at the tip."""
_SPELT = {"f": ("f", "F", "fP", "FP", "fE", "FE", "fe", "Fe", "ftip", "Ftip"), "n": ("n", "M", "N")}
VECTORS = tuple(name for name in _SPELT["f"] if not name.endswith("tip"))


def named_in(model: Model, text: str) -> tuple[str, ...]:
    """Symbols for the load on the tip, where a text has one."""
    names = LOADS[model.dim]
    if model.tip is None or model.loops or any(body.kind.quaternion for body in model.bodies):
        return ()
    components = (x[0] for x in _COMPONENT.finditer(text))
    beside = "J" in text or JOINT_FORCE.search(text)
    if not any(x[0] != "n" or not _HAND.search(text) for x in components) and not (
        beside and _VECTOR.search(text)
    ):
        return ()
    slides = {f"f{x}" for x in symbols_of(model).coordinates}  # of a cart the drive's own force
    return () if set(names) & {*slides, *model.parameters} else names


def symbols(setting: RightEquations, taken: Collection[str]) -> Iterator[tuple[str, Trig]]:
    """Spellings of the load's components, with their values; none that is taken."""
    for name in setting.loads:
        letter, axis = name
        for spelling in (f"{x}{axis}" for x in _SPELT[letter]):
            if spelling not in taken:
                yield spelling, setting.ring[name]
