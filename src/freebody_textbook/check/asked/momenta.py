"""Angular momenta of bodies that move in the plane."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.tables.characters import LOW
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, sub
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.methods.energies import Energies
from freebody_textbook.methods.setting import Setting

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
"""What its letters stand for elsewhere."""


class AngularMomenta(QuantityGroup):
    """H_i and L_i of body i, about its centre of mass, its joint or the base's origin; H_Gi about
    its centre of mass, H_O of the whole robot."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer gives one: elsewhere the names are often those of lengths."""
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
        told = {
            (x["letter"], x["point"].upper(), LOW.get(x["number"], x["number"]))
            for x in _NAMED.all(self.formulas)
        }
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
        """Whether a notation has a letter for another quantity than usual."""
        return letter not in self.letters[_USUAL[letter].name]

    @cached_property
    def _whole(self) -> AskedQuantity:
        """The momentum of all bodies about the base's origin; of one body also about its centre."""
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
    def _setting(self) -> Setting:
        return Setting(self.setting.equations.symbols)

    @cached_property
    def _bodies(self) -> dict[str, int]:
        """The bodies that have a mass, by their numbers."""
        s = self._setting
        single = (i for i in s.order if len(s.tree.bodies[i].masses) == 1)
        return {str(s.numbers[i]): i for i in single}

    def _about_centre(self, i: int) -> Callable[[], Trig]:
        """I ω."""
        return self.element(lambda: self._spin(i))

    def _about(self, i: int, point: Vector) -> Callable[[], Trig]:
        """I ω + m r × v, from a point of the plane."""
        return self.element(lambda: self._moment(i, point))

    def _sum(self, *bodies: int) -> Callable[[], Trig]:
        """The sum over bodies about the base's origin."""
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
