"""Texts that give the reasons of derivation steps, depending on the robot's structure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from freebody.elementary import Scalar
from freebody.errors import listed
from freebody.expressions.polynomials.symbols import RATE
from freebody.model.drives import LAWS
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, dot
from freebody_textbook.methods.setting import Setting

GYROSCOPIC = (
    "ω × I ω is the gyroscopic moment: the angular momentum I ω turns with the body, and turning "
    "it takes a moment at right angles to ω, even at constant rates."
)

ABSOLUTE = (
    "The torque τ_i of such an angle is that on body i: of its joint's motor, less those of the "
    "motors of the joints that it carries."
)
"""A sentence on torques along angles of the links."""
_BURDENS = tuple(
    dict.fromkeys(law.words for law in sorted(LAWS.values(), key=lambda law: law.inertia is None))
)
"""The laws that a motor works against besides, in the order in which it is told: rotors first."""


def gyroscopic(s: Setting, i: int, moment: Vector) -> str:
    """A sentence, starting with a blank, on the moment that a bearing carries at constant rates
    though no centre of mass moves; "" if there is none."""
    moves = any(not s.symbols.element(x).is_zero for k in s.weighted for x in s.centre_velocity(k))
    if s.planar or not s.turns(i) or moves:
        return ""
    constant, axis = tuple(_at_constant_rates(s, x) for x in moment), s.tree.bodies[i].axis
    if all(s.symbols.element(x).is_zero for x in s.tree.space.cross(axis, constant)):
        return ""
    n, felt = s.numbers[i], not s.symbols.element(dot(axis, constant)).is_zero
    return (
        f" No centre of mass moves: the products of rates in n_{s.numbers[s.tree.bodies[i].parent]}"
        f",{n} are gyroscopic. The bearing carries them, at right angles to the axis of joint {n}"
        f"{'.' if felt else ', and the motor does not feel them.'}"
    )


def _at_constant_rates(s: Setting, x: Scalar) -> Trig:
    """The terms with products of two rates in a scalar."""
    rates = {name + RATE for name in s.symbols.coordinates}
    terms = s.symbols.element(x).terms()
    kept = ((m, c) for m, c in terms if sum(e for name, e in m.items() if name in rates) == 2)
    return s.symbols.ring.polynomial(kept)


@dataclass(frozen=True)
class Efforts:
    """Phrases for the motors' torques and forces, such as `motor torques and force`."""

    words: str
    count: int

    @classmethod
    def of(cls, s: Setting) -> Efforts:
        """The phrases for all joints with a motor."""
        found = Counter(s.words(i).effort for i in s.leaders if s.driven(i))
        named = [f"{effort}{'s' * (n > 1)}" for effort, n in found.items()]
        return cls(f"motor {listed(named)}" if named else "", found.total())

    @property
    def verb(self) -> str:
        """The verb for the number of efforts: is or are."""
        return "is" if self.count == 1 else "are"

    @property
    def given(self) -> str:
        """The beginning of a sentence on what is sought: "Given the motor torques, the", or "The"
        without motors."""
        return f"Given the {self.words}, the" if self.count else "The"

    @property
    def holding(self) -> str:
        """Phrase for the motor torques that hold a robot at rest, or whatever else keeps it at rest
        without motors."""
        one = "s" * (self.count == 1)
        return f"the {self.words} that hold{one}" if self.count else "the conditions that keep"


def free_body(s: Setting, i: int, more: Iterable[str] = ()) -> str:
    """The reason of a free-body step: what acts on body i, and which laws apply; more: further
    forces."""
    acting = f"On body {s.numbers[i]} act: {'; '.join([*_acting(s, i), *more])}."
    if i not in s.weighted:
        return f"{acting} It has no mass: forces, and moments about its joint, add up to zero."
    if i != s.weighted[0]:
        return acting
    about = "the moments about it" if s.planar else "the moments about it, as vectors,"
    turning = "" if s.planar or s.is_point(i) else f" {GYROSCOPIC}"
    return (
        f"{acting} The forces accelerate the centre of mass (Newton), "
        f"{about} change the angular velocity (Euler).{turning}"
    )


def _acting(s: Setting, i: int) -> list[str]:
    n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    held = (
        f"the reaction f_{parent},{n} of {'the ground' if parent == 0 else f'body {parent}'} at "
        f"joint {n}"
    )
    acting = [held] if s.is_held(i) else []
    if not s.is_pin(i):
        acting.append(f"the moment n_{parent},{n} there")
    elif s.driven(i):
        acting.append(f"the torque τ_{s.naming.place(n)}")
    for k in s.tree.children(i):
        c = s.numbers[k]
        moment = (
            f" and -n_{n},{c}"
            if not s.is_pin(k)
            else f" and -τ_{s.naming.place(c)}"
            if s.driven(k)
            else ""
        )
        acting.append(f"-f_{n},{c}{moment}, the opposite of its action on body {c} at joint {c}")
    if s.weighs and i in s.weighted:
        acting.append("its weight")
    if s.loaded(i):
        acting.append("the load f at the tip")
    return acting


def working_part(s: Setting, i: int) -> str:
    """Phrase for the component of force and moment at joint i that does work along its
    coordinate."""
    n = s.numbers[i]
    if not s.turns(i):
        return f"the force along the slide u_{n}"
    moment = f"the moment about the axis of joint {n}"
    return f"{moment} and pitch times the force along it" if s.slides(i) else moment


def joints_that(s: Setting, turn: bool) -> str:
    """Phrase for the types of joints that turn (or do not turn) their bodies, `revolute or
    helical`; "" if none."""
    return " or ".join(dict.fromkeys(s.words(i).joint for i in s.order if s.turns(i) == turn))


def added_rates(s: Setting) -> str:
    """A clause on the joints' contributions to the angular velocities."""
    turning, others = joints_that(s, turn=True), joints_that(s, turn=False)
    if not turning:
        return f"No joint turns a body; a {others} joint adds nothing"
    axis = "" if s.planar else ", about its axis,"
    added = f"A {turning} joint adds its rate{axis} to the angular velocity of the previous body"
    return f"{added}; a {others} joint adds nothing" if others else added


def coriolis(s: Setting, joints: Iterable[int]) -> str:
    """A sentence on the Coriolis acceleration 2 ω × ḋ u of joints sliding on a turning body; "" if
    there are none."""
    sliding = sorted({s.turns(i) for i in joints if s.slides(i) and _carried_round(s, i)})
    ways = {False: "2 ω × ḋ u (ḋ: the speed of sliding)", True: "2 ω × h θ̇ z (h: the pitch)"}
    return " or ".join(ways[turns] for turns in sliding)


def _carried_round(s: Setting, i: int) -> bool:
    """Whether joint i is on a body that turns."""
    parent = s.tree.bodies[i].parent
    return parent >= 0 and (s.turns(parent) or _carried_round(s, parent))


def motorless(s: Setting) -> str:
    """A sentence, starting with a blank, on the joints without motor; "" if there are none."""
    joints = [f"joint {s.numbers[i]}" for i in s.leaders if not s.driven(i)]
    return (
        f" {listed(joints).capitalize()} {'has' if len(joints) == 1 else 'have'} no motor."
        if joints
        else ""
    )


def eliminated(s: Setting, i: int, rest: str = "nothing unknown") -> str:
    """The reason of an elimination: how the reaction at joint i is eliminated; rest: remaining
    unknowns besides the motor."""
    n, torque = s.numbers[i], f"τ_{s.naming.place(s.numbers[i])}"
    first = f"Newton's equation of body {n} gives the force at joint {n}"
    if s.tree.children(i):
        first += ", the forces on the next bodies being known"
    if not s.is_alone(i):
        last = "; the motor follows, when all reactions are known" if s.driven(i) else ""
        return f"{first}; Euler's equation gives the moment{last}."
    if not s.turns(i):
        force = f"f_{s.numbers[s.tree.bodies[i].parent]},{n}"
        along = f"the part of {force} along the slide u_{n}"
        motor = f"the motor's force is {along}" if s.driven(i) else f"{along} has no motor"
        return f"{first}; Euler's equation gives the moment of the guide; {motor}."
    into = f"{first}; substituted into Euler's equation, it"
    if s.is_pin(i):
        left = (
            f"the torque {torque} and {rest}" if s.driven(i) else f"{rest}, for there is no motor"
        )
        return f"{into} leaves {left}."
    if not s.driven(i):
        return f"{into} gives the moment; there is no motor to give {working_part(s, i)}."
    if s.slides(i):
        return f"{into} gives the moment; the torque {torque} is {working_part(s, i)}."
    return f"{into} gives the moment, whose part about the axis is the torque {torque}."


def substituted(s: Setting, i: int, reactions: bool) -> str:
    """The reason of a substitution: which values are inserted into which equation."""
    motor = f"the {s.words(i).effort} of motor {s.numbers[i]}"
    if not s.driven(i):
        motor = f"the equation of motion of joint {s.numbers[i]}, which has no motor"
    what = "force" if s.is_pin(i) else "force and the moment"
    carried = f"the {what} that the {s.words(i).bearing} of joint {s.numbers[i]} passes on, and "
    told = f"{carried if reactions else ''}{motor}"
    if not s.is_alone(i):
        told = f"the force and the moment that joint {s.numbers[i]} passes on"
    return f"With the vectors substituted: {told}, sorted by accelerations and rates."


def drive(s: Setting, i: int) -> str:
    """A sentence, starting with a blank, on friction and springs that the motor of joint i must
    overcome; "" if there are none."""
    moved = s.together(i)
    drives = [own for k in moved if (own := s.tree.bodies[k].drive) is not None]
    acting = {
        x.law.words
        for own in drives
        for x in own.laws
        if not s.symbols.element(x.p[0]).is_zero and not (s.at_rest and x.law.only_moving)
    }
    found = [words for words in _BURDENS if words in acting]
    whose = "joint's" if len(moved) == 1 else "joints'"
    return f" The other terms are those of the {whose} {listed(found)}." if found else ""
