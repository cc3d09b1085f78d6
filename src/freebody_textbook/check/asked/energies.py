"""Quantities of energy: energies of the whole robot and of each body, powers, momenta and angular
momenta."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from freebody.expressions.grammar.atoms import atom, spellings
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.tables.characters import LOW
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, sub
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.methods.energies import Energies

_OF_BODIES = (
    (kinds.KINETIC, kinds.BODY_KINETIC, Energies.kinetic),
    (kinds.POTENTIAL, kinds.BODY_POTENTIAL, Energies.potential),
)
"""Energies of the robot, of a body, and the latter's value."""


class EnergyQuantities(QuantityGroup):
    """The energies T, V, L, T_i and V_i, and the power of the drives."""

    def single(self) -> Iterator[NamedTarget]:
        eq = self.setting.equations
        bodies = len(eq.symbols.model.bodies)
        for kind, of_body, energy in _OF_BODIES:
            letters = self.letters[kind.name]
            yield letters, AskedQuantity(kind, (), self.entry(kind.name))
            for i in range(1, bodies + 1):
                names = tuple(f"{x}{i}" for x in (*letters, *of_body.letters))
                yield names, AskedQuantity(of_body, (i,), self._of_body(energy, i - 1))
        total, lagrangian = (self.element(lambda x=x: x) for x in (eq.T + eq.V, eq.T - eq.V))
        thoughts = (("L = T − V, not T + V.", total),)
        yield self.letters["L"], AskedQuantity(kinds.LAGRANGIAN, (), lagrangian, thoughts=thoughts)
        yield ("E",), AskedQuantity(kinds.ENERGY, (), total)
        for kind, value in (
            (kinds.KINETIC, eq.T), (kinds.POTENTIAL, eq.V),
            (kinds.LAGRANGIAN, eq.T - eq.V), (kinds.ENERGY, eq.T + eq.V),
        ):  # fmt: skip
            letters = (x for x in self.letters.get(kind.name, kind.letters) if x[0].isupper())
            names = tuple(name for x in letters for name in spellings(x, "", 1))
            words = f"the rate of {kind.words}"
            yield names, AskedQuantity(kinds.POWER, (), self._rate(value), words=words)
        for i, x in enumerate(self.setting.symbols.coordinates, 1):
            words = f"the momentum that belongs to {sym(x)}"
            yield (
                self._momentum_names(i, x),
                AskedQuantity(kinds.MOMENTUM, (i,), self._momentum(i), words=words, soft=True),
            )
        yield from ((("power" + number,), x) for number, x in self._powers.items())

    def namesakes(self) -> Iterator[NamedTarget]:
        yield from ((("P" + number,), x) for number, x in self._powers.items())

    @cached_property
    def _powers(self) -> dict[str, AskedQuantity]:
        """The total power of the drives, and the power of each by its number."""
        words = "the power of the drives"
        found = {"": AskedQuantity(kinds.POWER, (), self._power(*self.numbers), words=words)}
        for i in self.numbers:
            words = f"the power of the drive of {self.joint(i)}"
            found[str(i)] = AskedQuantity(kinds.POWER, (i,), self._power(i), words=words)
        return found

    def _momentum_names(self, i: int, coordinate: str) -> tuple[str, ...]:
        """Names of the momentum of coordinate i, p_θ1, p_q1, p_x, p_1; none if p is a parameter."""
        if {"p", "P"} & self.setting.ring.index.keys():
            return ()
        number = atom(coordinate).figures
        own = (coordinate, *[f"q{number}"] * bool(number))
        return (*(f"{p}{x}" for p in "pP" for x in own), f"p{i}")

    def _momentum(self, i: int) -> Callable[[], Trig]:
        """The momentum Σ M_ij q̇_j that belongs to a coordinate."""
        rates = [self.setting.ring[x + RATE] for x in self.setting.symbols.coordinates]
        row = [self.entry("M", i, j) for j in self.numbers]
        return lambda: sum((m() * v for m, v in zip(row, rates, strict=True)), self.setting.zero)

    def _power(self, *joints: int) -> Callable[[], Trig]:
        """The power Σ τ_i q̇_i of some joints' drives; joints without a drive contribute 0."""
        driven = [i for i in joints if i not in self.passive]
        rates = [self.setting.ring[x + RATE] for x in self.setting.symbols.coordinates]
        torques = [self.entry("tau", i) for i in driven]
        return lambda: sum(
            (torque() * rates[i - 1] for i, torque in zip(driven, torques, strict=True)),
            self.setting.zero,
        )

    def _rate(self, energy: Trig) -> Callable[[], Trig]:
        """Time derivative of an energy."""
        return lambda: self.setting.element(energy.along(self.setting.equations.symbols.rates))

    def _of_body(self, energy: Callable[[Energies, int], Trig], body: int) -> Callable[[], Trig]:
        """The energy of a body, including everything that is fixed to it."""

        s = self._setting
        return self.element(lambda: energy(Energies(s, s.motion), s.tree.body_of[body]))


_NAMED = LexemePattern(
    "%fresh < letter:< H | L > | %around_letter { letter:< H | L > } > ~_? ~{?"
    " point:< ~C | ~c | ~G | ~O >? number:< ~%digit | ~%low_digit >? ~}? &< &? = >"
)
_CENTRE, _ORIGIN, _JOINT = (
    "It is read as that about the centre of mass.",
    "It is read as that about the base's origin.",
    "It is read as that about its own joint.",
)

_USUAL = {"H": kinds.MASS, "L": kinds.LAGRANGIAN}
"""The kinds for which the letters of angular momenta stand elsewhere."""


class AngularMomenta(QuantityGroup):
    """Angular momenta: H_i and L_i of body i about its centre of mass, its joint or the base's
    origin; H_Gi about the centre of mass, H_O of the whole robot."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer contains an angular momentum; in other answers its names often mean
        lengths."""
        return _NAMED.found_in(formulas)

    @property
    def _is_known(self) -> bool:
        has_rotors = Energies(self._setting, self._setting.motion).has_rotors
        return self.setting.is_planar and not has_rotors

    def namesakes(self) -> Iterator[NamedTarget]:
        if self._is_known:
            yield tuple(_USUAL), self._whole

    def single(self) -> Iterator[NamedTarget]:
        if not self._is_known:
            return
        told = dict.fromkeys(
            (x["letter"], x["point"].upper(), LOW.get(x["number"], x["number"]))
            for x in _NAMED.all(self.formulas)
        )
        for letter, point, number in told:
            name = f"{letter}{point}{number}"
            if name in self.setting.ring.index or self._is_given(letter):
                continue
            if (point, number) == ("O", ""):
                yield (name,), replace(self._whole, also=())
            elif point and not number and len(self._bodies) == 1:
                (own,) = self._bodies
                yield (name, f"{letter}{point.lower()}"), self._of_body(own, True)
            elif number in self._bodies and point != "O":
                yield (name, f"{letter}{point.lower()}{number}"), self._of_body(number, bool(point))

    def _is_given(self, letter: str) -> bool:
        """Whether the notation uses a letter for an unusual quantity."""
        return letter not in self.letters[_USUAL[letter].name]

    @cached_property
    def _whole(self) -> AskedQuantity:
        """The angular momentum of all bodies about the base's origin; of a single body also about
        its centre of mass."""
        words = "the angular momentum"
        value, bodies = self._sum(*self._bodies.values()), list(self._bodies.values())
        also = ((_CENTRE, self._about_centre(bodies[0])),) if len(bodies) == 1 else ()
        return AskedQuantity(
            kinds.ANGULAR_MOMENTUM, (), value, words=words, note=_ORIGIN, also=also
        )

    def _of_body(self, number: str, is_about_centre: bool) -> AskedQuantity:
        i = self._bodies[number]
        centre, words = self._about_centre(i), f"the angular momentum of body {number}"
        if is_about_centre:
            words += " about its centre of mass"
            return AskedQuantity(kinds.ANGULAR_MOMENTUM, (), centre, words=words, soft=True)
        ways = {_ORIGIN: (0.0, 0.0), _JOINT: self._setting.world[i][1]}
        also = tuple((note, self._about(i, point)) for note, point in ways.items())
        return AskedQuantity(
            kinds.ANGULAR_MOMENTUM, (), centre, words=words, note=_CENTRE, soft=True, also=also
        )

    @cached_property
    def _bodies(self) -> dict[str, int]:
        """Names of the bodies with mass, and their indices."""
        s = self._setting
        single = (i for i in s.order if len(s.tree.bodies[i].masses) == 1)
        return {str(s.numbers[i]): i for i in single}

    def _about_centre(self, i: int) -> Callable[[], Trig]:
        """The angular momentum I ω of a body about its centre of mass."""
        return self.element(lambda: self._spin(i))

    def _about(self, i: int, point: Vector) -> Callable[[], Trig]:
        """The angular momentum I ω + m r × v of a body about a point in the plane."""
        return self.element(lambda: self._moment(i, point))

    def _sum(self, *bodies: int) -> Callable[[], Trig]:
        """The total angular momentum of some bodies about the base's origin."""
        zero = self._setting.symbols.zero
        return self.element(lambda: sum((self._moment(i, (0.0, 0.0)) for i in bodies), zero()))

    def _spin(self, i: int) -> Trig:
        s = self._setting
        (part,) = s.tree.bodies[i].masses
        (spin,) = s.tree.space.inertia_times(part.inertia, s.motion.w[i])
        return s.symbols.element(spin)

    def _moment(self, i: int, point: Vector) -> Trig:
        s = self._setting
        x, y = sub(s.centre_position(i), point)
        vx, vy = s.centre_velocity(i)
        return self._spin(i) + s.symbols.element(s.mass(i) * (x * vy - y * vx))
