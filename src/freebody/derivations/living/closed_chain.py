"""Planar closed chains in a page: exact quantities by name, with the forces in the loops as the
multipliers make them, and the equations by which the page closes the loops."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from freebody.algorithms.kinematics import frame_pose
from freebody.derivations.closed_chains.first_kind import multiplier_names
from freebody.derivations.derivation import Derivation
from freebody.derivations.derive import LOADS
from freebody.derivations.living.kernel import PageProgram
from freebody.derivations.methods import METHODS
from freebody.derivations.methods.cut_loops import Loops
from freebody.derivations.methods.energies import Energies
from freebody.derivations.methods.loop_forces import LoopReactions
from freebody.derivations.methods.setting import Setting
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.derivations.relations.quantities import Quantities
from freebody.lazy import cached_property
from freebody.model.tree import TreeLoop
from freebody.scalars.trig import Trig


@dataclass(frozen=True)
class LoopEnd:
    """Where a loop acts on a body: the point, the force, and what it is called."""

    place: Any
    force: Any
    sign: int
    name: str


class ClosedChain:
    """The closed chain of a derivation, in its symbols."""

    key = "loop"
    why = "by the loops"

    def __init__(self, derivation: Derivation):
        symbols = derivation.equations.symbols
        load = LOADS[2] if "fx" in symbols.extra else ()
        self.at_rest = METHODS[derivation.method].at_rest
        self.s = Setting(symbols, load, self.at_rest)
        self.loops = Loops(self.s)
        self.reactions = LoopReactions(self.s, self.loops)

    @property
    def passive(self) -> tuple[int, ...]:
        """Bodies whose joints have no motor: as many as loop equations, which determine their
        coordinates."""
        return tuple(i for i in self.s.order if not self.s.driven(i))

    @cached_property
    def is_served(self) -> bool:
        """Whether the drives determine the motion, and every loop transmits a force alone."""
        forces = all(
            not loop.closure.turns and not loop.closure.slides for loop in self.s.tree.loops
        )
        return forces and len(self.passive) == len(self.loops.equations.names)

    # ------------------------------------------------------------ what the lines speak of
    def quantities(self) -> Quantities:
        """By the names that the derivation gives them; others it defines itself."""
        s, ring = self.s, self.s.symbols.ring
        energies = Energies(s, s.motion)
        found: dict[str, Any] = {name: ring[name] for name in ring.names}
        found["gravity"] = self._vector(s.tree.gravity)
        found["V"], found["T"] = energies.total_potential, energies.rotors
        for i in s.order:
            found |= self._of_body(i)
            if i in s.weighted:
                found["T"] = found["T"] + energies.kinetic(i)
                found |= {f"T{s.numbers[i]}": energies.kinetic(i)}
                found |= {f"V{s.numbers[i]}": energies.potential(i)}
        found["L"] = found["T"] - found["V"]
        if s.load:
            found |= {"f": self._vector(s.load_components), "r": self._vector(s.tip_position())}
        return Quantities(found, s.layout)

    def _of_body(self, i: int) -> dict[str, Any]:
        s, n = self.s, self.s.numbers[i]
        above = s.numbers[s.tree.bodies[i].parent]
        (turn,), (turning,) = s.motion.w[i], s.motion.wd[i]
        (moment,) = self.reactions.n[i]
        return {
            f"m{n}": s.symbols.element(s.mass(i)), f"I{n}": s.symbols.element(s.inertia(i)),
            f"r{n}": self._vector(s.world[i][1]), f"rc{n}": self._vector(s.centre_position(i)),
            f"vc{n}": self._vector(s.centre_velocity(i)),
            f"vc{n}_d": self._vector(s.centre_acceleration(i)),
            f"omega{n}": s.symbols.element(turn), f"omega{n}_d": s.symbols.element(turning),
            f"sc{n}": self._vector(s.centre(i)),
            f"f{above}{n}": self._vector(self.reactions.f[i]), f"M{n}": s.symbols.element(moment),
        }  # fmt: skip

    def _vector(self, v: Any) -> tuple[Trig, ...]:
        return tuple(map(self.s.symbols.element, v))

    # ------------------------------------------------------------ what is drawn
    def ends(self, n: int) -> list[LoopEnd]:
        """Where loops act on body n."""
        i = self.s.order[n - 1]
        return [
            LoopEnd(
                self._place(frame),
                self._vector(self.loops.wrench(loop)[0]),
                1 if self.loops.acts(loop, i) else -1,
                str(self.loops.force_name(loop)),
            )
            for loop, frame in self._acting(i)
        ]

    def _place(self, frame: str) -> tuple[Trig, ...]:
        return self._vector(frame_pose(self.s.tree, self.s.world, frame)[1])

    def _acting(self, i: int) -> list[tuple[TreeLoop, str]]:
        return [
            (loop, frame)
            for loop in self.s.tree.loops
            for frame, k in zip(loop.frames, self.loops.ends(loop), strict=True)
            if k == i
        ]

    # ------------------------------------------------------------ what closes it
    @property
    def solved_names(self) -> tuple[str, ...]:
        """Symbols that the page computes from the others."""
        names = [self.s.coordinate(i) for i in self.passive]
        dots = ("",) if self.at_rest else ("", RATE, SECOND)
        multipliers = multiplier_names(self.loops.equations)
        return (*(name + dot for dot in dots for name in names), *multipliers)

    @property
    def names(self) -> tuple[str, ...]:
        """Symbols that the page needs for it."""
        dots = ("",) if self.at_rest else ("", RATE, SECOND)
        coordinates = [self.s.coordinate(i) for i in self.s.order]
        multipliers = multiplier_names(self.loops.equations)
        return (*(name + dot for dot in dots for name in coordinates), *multipliers)

    def page(self, kernel: PageProgram, inputs: Mapping[str, int]) -> dict[str, Any]:
        """Places of Φ, Φ_q, c and of what joints without motor would have to give without the
        loops; which inputs are found from these; and where massless rods reach from and to."""
        equations, s = self.loops.equations, self.s
        pressed = self.loops.system.pressed
        free = [self.reactions.motor(i) - pressed[s.index(i)] for i in self.passive]
        dots = {"q": ""} | ({} if self.at_rest else {"qd": RATE, "qdd": SECOND})
        return {
            "rods": [
                [kernel.places(self._place(frame)) for frame in loop.frames]
                for loop in s.tree.loops
                if loop.closure.distance
            ],
            "phi": [kernel.places(x)[0] for x in equations.Phi],
            "jacobian": [kernel.places(tuple(row)) for row in equations.Phi_q],
            "c": [] if self.at_rest else [kernel.places(x)[0] for x in equations.c],
            "need": [kernel.places(x)[0] for x in free],
            "solved": [s.index(i) for i in self.passive],
            "multipliers": [inputs[name] for name in multiplier_names(equations)],
            **{key: [inputs[x + dot] for x in s.symbols.coordinates] for key, dot in dots.items()},
        }
