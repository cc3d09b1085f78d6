"""Forward dynamics in an interactive page: accelerations of a free body with thrusts, such as a
quadrotor, and of joints without motor in an open chain."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.notations.lettering import Lettering
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.spatial import add, scale, sub, times
from freebody_textbook.derivation import Derivation
from freebody_textbook.living.body_quantities import vector
from freebody_textbook.living.drawn_bodies import Labels
from freebody_textbook.living.page_frames import PageFrames
from freebody_textbook.living.page_program import PageProgram
from freebody_textbook.methods import METHODS
from freebody_textbook.methods.free_body_steps import mass_symbol, part_with_mass, thrusts_of
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.whole_bodies import velocity_names

_AXES = "xyz"


class FreeFlight:
    """Flight of a single free body with velocities in body axes. setting: over a program's
    scalars."""

    key = "free"
    why = "by the thrusts"

    def __init__(self, setting: Setting):
        self.s = setting
        given = setting.symbols.given or setting.symbols.model
        self._thrusts = thrusts_of(given)
        self._moving = [x for x in velocity_names(given) if x not in self._thrusts]
        self.is_served = len(given.bodies) == 1 and bool(self._thrusts)
        self._missing: Any = ()

    @property
    def _body(self) -> int:
        return self.s.order[-1]

    @property
    def solved_names(self) -> tuple[str, ...]:
        """Names of the accelerations, which the page solves for."""
        return tuple(x for x in self._moving if atom(x).dots)

    @property
    def names(self) -> tuple[str, ...]:
        """Symbols that the page needs for the motion of a free body."""
        return self.solved_names

    def start(self) -> dict[str, float]:
        """The initial state: level at the origin, with thrusts that balance the weight."""
        given = self.s.symbols.given or self.s.symbols.model
        mass = part_with_mass(given.bodies[0]).inertia.mass
        weight = 9.81 * (mass if isinstance(mass, float) else 1.0)
        level = dict.fromkeys(self.s.symbols.coordinates, 0.0)
        return level | dict.fromkeys(self._thrusts, weight / len(self._thrusts))

    def quantities(self) -> dict[str, Any]:
        """Quantities that no line of the derivation defines: symbols, velocity vectors, gravity."""
        ring = self.s.symbols.ring
        own = (*self.s.symbols.coordinates, *self._moving, *self._thrusts)
        found: dict[str, Any] = {x: ring[x] for x in ring.names if x in own or "_" not in x}
        for letter in ("v", "omega"):
            for dots in ("", RATE):
                found[letter + dots] = tuple(ring[f"{letter}_{x}{dots}"] for x in _AXES)
        return found | {"gravity": vector(self.s, self.s.tree.gravity)}

    def _pushes(self) -> list[tuple[str, Any, Any]]:
        """Name, force and place of each thrust, in the body's axes."""
        found = []
        for name, frame in self._thrusts.items():
            _, R, p = self.s.tree.frames[frame.name]
            along = tuple(row[2] for row in R)
            found.append((name, scale(self.s.symbols.ring[name], along), p))
        return found

    def frames(self, kernel: PageProgram) -> PageFrames:
        """The frames of the drawing, relative to the body's origin."""
        given = self.s.symbols.given or self.s.symbols.model
        _, origin = self.s.world[self._body]
        return PageFrames(kernel, self.s, given, (self._body,), origin)

    def body(
        self, kernel: PageProgram, frames: PageFrames, labels: Labels, letters: Lettering
    ) -> dict[str, Any]:
        """Drawing data of the body, its weight and the thrusts."""
        R, origin = self.s.world[self._body]
        centre = self.s.centre_position(self._body)
        weight = scale(self.s.mass(self._body), self.s.tree.gravity)
        given = self.s.symbols.given or self.s.symbols.model
        mass = labels.figure.formula(letters(mass_symbol(given, 0)))
        acting = [("weight", labels.number(f"{mass} *g*"), weight, centre)]
        acting += [
            ("external", labels.of(letters(sym(name))), times(R, force), add(origin, times(R, p)))
            for name, force, p in self._pushes()
        ]
        (place,) = labels.figure.pose.bodies
        at = frames.origin(place).place().data
        return {
            "joint": at, "from": at, "centre": frames.end(place, None).place().data,
            "ends": [frames.end(place, end).place().data for end in place.ends],
            "parent": -1, "slides": False, "alone": True, "link": False, "heavy": True,
            "moments": [], "names": {},
            "forces": [
                {"kind": kind, "at": frames.point(place),
                 "is": kernel.places(vector(self.s, force)), "sign": 1, "name": name}
                for kind, name, force, place in acting
            ],
        }  # fmt: skip

    def page(self, kernel: PageProgram, inputs: Mapping[str, int]) -> dict[str, Any]:
        """Data for solving the accelerations in the script: their inputs, and places of the missing
        force and moment, which are linear in them."""
        return {
            "accelerations": [inputs[name] for name in self.solved_names],
            "needs": kernel.places(self._missing),
        }

    def need(self, quantities: Mapping[str, Any]) -> bool:
        """Store the missing force and moment, from the lines that define f and n; returns whether
        there are such lines."""
        force = moment = vector(self.s, (0.0, 0.0, 0.0))
        for _, push, p in self._pushes():
            force, moment = add(force, push), add(moment, self.s.tree.space.moment(p, push))
        needed = tuple(quantities.get(f"{letter}_{x}") for letter in "fn" for x in _AXES)
        if any(x is None for x in needed):
            return False
        self._missing = sub(needed, (*force, *moment))
        return True


class FreeJoints:
    """Motion of the joints without motor, whose accelerations make their torques vanish; values:
    the chain's quantities."""

    key = "free"
    why = "no motor"

    def __init__(self, derivation: Derivation, values: Mapping[str, Any]):
        model = derivation.equations.symbols.model
        moving = bool(derivation.tau) and not METHODS[derivation.method].at_rest
        coordinates = derivation.equations.symbols.coordinates
        self.solved_names = tuple(coordinates[k] + SECOND for k in model.passive if moving)
        self._needed = [values[f"tau{k + 1}"] for k in model.passive if moving]

    @property
    def names(self) -> tuple[str, ...]:
        """Symbols that the page needs for the motion of joints without motor."""
        return self.solved_names

    def page(self, kernel: PageProgram, inputs: Mapping[str, int]) -> dict[str, Any]:
        """Data for solving the accelerations in the script: their inputs, and places of the joints'
        torques, which are linear in them."""
        return {
            "accelerations": [inputs[name] for name in self.solved_names],
            "needs": [kernel.places(tau)[0] for tau in self._needed],
        }
