"""Kinds of quantities, one record each: what books and derivations call them, their units, what
their names mean in words, and in which sense two of a kind are equal."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from freebody.expressions.quantities import units
from freebody.expressions.quantities.units import Unit

OfJoints = Callable[[Sequence[bool]], Unit]
"""A unit by whether each of some joints turns."""

_EQUATION = "an equation between the robot's quantities"


@dataclass(frozen=True, eq=False)
class Kind:
    """A kind of quantities, such as all entries of the mass matrix: everything that is common to
    them."""

    name: str
    """Name in the equations of motion, such as M; of other kinds a word."""
    words: str = ""
    """Words for an entry, with places for its indices and its joint."""
    unit: Unit | OfJoints | None = None
    """Unit of the quantity; None where only its terms tell."""
    key: str = ""
    """Name of the kind in files of notations."""
    letters: tuple[str, ...] = ()
    """Letters in answers, where no notation gives others."""
    printed: tuple[str, ...] = ()
    """Letters in derivations as they are made."""
    usual: str = ""
    """The letter by which sentences name its entries."""
    shared: tuple[str, ...] = ()
    """Letters that some books have for it, and others for something else."""
    is_matrix: bool = False
    """Whether its letter without a number stands for a matrix."""
    of: Literal["joints", "bodies", ""] = ""
    """Whose equations contain it: in those of bodies g is a vector, in those of joints a
    generalized force."""
    tells: Literal["", "motion", "weight"] = ""
    """Contents that a line about a load has besides: nothing, motion or weight."""
    dots: int = 0
    """How often it is a derivative."""

    # ------------------------------------------------------------ in which sense two are equal
    up_to_a_constant: bool = False
    """Whether the level is arbitrary."""
    up_to_rows: bool = False
    """Whether each row may have a factor."""
    by_rates: bool = False
    """Whether only its product with the rates is determined."""
    is_symmetric: bool = False
    """Whether entries i, j and j, i are always equal."""
    has_branches: bool = False
    """Whether a function's second value may give it, as the other posture that reaches a point."""
    has_own_sense: bool = False
    """Whether which of two senses it has is settled apart from quantities of other kinds."""

    # ------------------------------------------------------------ where lines about it hold
    holds_by_loops: bool = False
    """Whether only closed loops can make a line about it right."""
    of_loops: Literal["", "positions", "rates", "slopes"] = ""
    """Part of loops that the kind is: their equations, the rates of these, or their slopes.
    Compared at any positions; the rates at closed positions, with any rates."""
    is_of_loop_equation: bool = False
    """Whether it has the sign of a loop equation, which is everybody's own."""
    may_be_still: bool = False
    """Whether lines about it may be meant in equilibrium."""

    # ------------------------------------------------------------ what its lines state
    is_equation: bool = False
    """Whether they state an equation, not a value."""
    may_be_zero: bool = False
    """Whether 0 is set against all of it, Φ = 0."""
    letters_of_ratios: tuple[str, ...] = ()
    """Letters of it that lines also give to ratios of their own."""
    letters_of_cosines: tuple[str, ...] = ()
    """Letters of it that others have for a cosine: C12."""
    letters_of_slides: tuple[str, ...] = ()
    """Letters of it that others have for the coordinate of a slide: x of a cart."""
    is_quotient: bool = False
    """Whether it is one by its nature."""
    takes_quotients: bool = False
    """Whether what is set against it may be one, where it is a polynomial itself."""
    is_long: bool = False
    """Whether its sides are too long to be multiplied out."""
    is_pose: bool = False
    """Whether they tell at which poses something holds."""
    is_coordinate: bool = False
    """Whether it is a coordinate or its rate."""
    is_posture: bool = False
    """Whether all its lines must be of one posture."""
    is_drive: bool = False
    """Whether a drive exerts the torque."""
    is_reaction: bool = False
    """Whether it acts in a joint: it may be 0 by chance."""
    terms: tuple[str, ...] = ()
    """Names of the quantities whose sum it is, as in the equations of motion."""
    is_load: bool = False
    """Whether it acts from outside."""
    is_given: bool = False
    """Whether a formula of the model or of its notation gives it."""
    is_coefficient: bool = False
    """Whether other lines are written with the quantity."""
    has_legs: bool = False
    """Whether the loops give it in other ways, along other legs."""
    is_velocity_term: bool = False
    of_one_body: bool = False
    is_told_by_value: bool = False
    """Whether its value tells which of several quantities with one name is meant."""
    is_defined_once: bool = False
    """Whether all entries of one answer must be by one of these definitions."""
    rates: tuple[Literal["some", "one", "none"], ...] = ()
    """Rates in answers, where two quantities share a name: one in each term, some or none."""
    has_rows_of_tip: bool = False
    """Whether its rows are those of the tip's velocity, of which the first suffice for a force."""
    has_velocity_terms: bool = False
    """Whether c_1 or V_1 may stand in it as a sum of velocity terms."""

    def titled(self, index: Sequence[int], joint: str) -> str:
        """The words for the entry with these indices, of a joint where the kind belongs to
        joints."""
        return self.words.format(*index, joint=joint)

    def unit_of(self, turns: Sequence[bool]) -> Unit | None:
        """The unit of an entry, given whether each of its joints turns."""
        return self.unit(turns) if callable(self.unit) else self.unit

    @property
    def is_energy(self) -> bool:
        """Whether quantities of this kind are measured in joules."""
        return self.unit == units.ENERGY


def _force(turns: Sequence[bool]) -> Unit:
    return 1, 1 + turns[0], -2


def _mass(turns: Sequence[bool]) -> Unit:
    return 1, sum(turns), 0


def _momentum(turns: Sequence[bool]) -> Unit:
    return 1, 1 + turns[0], -1


def _of_rates(turns: Sequence[bool]) -> Unit:
    return 1, sum(turns), -1


# ---------------------------------------------------------------- equations of motion
TORQUE = Kind(
    "tau", "the drive's torque or force at {joint}", _force,
    "torque", ("tau", "Q", "Gamma"), ("tau", "Q"), "tau", of="joints",
    may_be_still=True, is_drive=True, is_reaction=True, has_velocity_terms=True,
)  # fmt: skip
MASS = Kind(
    "M", "entry {}, {} of the mass matrix", _mass,
    "mass", ("M", "H", "m", "D", "d", "B", "b"), ("H", "M"), "H", is_matrix=True, of="joints",
    shared=("B", "D", "b", "d"), tells="motion", is_symmetric=True,
)  # fmt: skip
CORIOLIS = Kind(
    "C", "entry {}, {} of the Coriolis matrix of Christoffel symbols", _of_rates,
    "coriolis", ("C",), ("C",), is_matrix=True, of="joints", tells="motion", by_rates=True,
    letters_of_cosines=("C",),
)  # fmt: skip
VELOCITY = Kind(
    "c", "the velocity term of {joint}", _force,
    "velocity", ("c", "C", "v", "b"), ("velocity",), "v", of="joints",
    shared=("b", "v"), tells="motion", is_velocity_term=True, letters_of_cosines=("C",),
)  # fmt: skip
GRAVITY = Kind(
    "g", "the gravity term of {joint}", _force,
    "gravity", ("g", "G", "phi"), ("G",), "G", ("phi",), of="joints",
    tells="weight",
)  # fmt: skip
BIAS = Kind(
    "bias", "the velocity and gravity terms of {joint}", _force,
    "bias", (), ("bias",), of="joints", tells="motion", terms=("c", "g", "drives"),
)  # fmt: skip
COEFFICIENT = Kind("h", "the velocity coefficient", is_coefficient=True)
COEFFICIENT_OF_RATES = Kind(
    "h_ijk", "the coefficient of the rates {1} and {2} in the velocity term of joint {0}",
    is_coefficient=True, is_told_by_value=True, is_defined_once=True,
)  # fmt: skip
CHRISTOFFEL = Kind(
    "christoffel", "the Christoffel symbol of the mass matrix of row {}, column {} and rate {}"
)
MASS_RATE = Kind("M_d", "entry {}, {} of the rate of the mass matrix", _of_rates, of="joints")
MASS_DETERMINANT = Kind("det M", "the determinant of the mass matrix")
INVERSE_ENTRY = Kind("inverse", "entry {}, {} of the inverse of {joint}", of="joints")
ACTIVE = Kind("active", "the generalized active force of {joint}", _force, of="bodies")
INERTIA_FORCE = Kind(
    "inertia", "the generalized inertia force of {joint}", _force, of="bodies",
    has_velocity_terms=True,
)  # fmt: skip
UNDRIVEN = Kind("0", "which nothing drives", _force, is_equation=True, has_velocity_terms=True)
COORDINATE = Kind(
    "q", "one of the coordinates and their rates",
    tells="motion", holds_by_loops=True, is_coordinate=True, takes_quotients=True,
    has_branches=True,
)  # fmt: skip

# ---------------------------------------------------------------- energies
KINETIC = Kind(
    "T", "the kinetic energy", units.ENERGY,
    "kinetic", ("T", "K", "KE", "Ek", "Ekin"), ("T",), of="bodies", tells="motion",
    letters_of_ratios=("K",),
)  # fmt: skip
POTENTIAL = Kind(
    "V", "the potential energy", units.ENERGY,
    "potential", ("V", "U", "P", "PE", "Ep", "Epot"), ("V",), of="bodies", tells="weight",
    up_to_a_constant=True,
)  # fmt: skip
LAGRANGIAN = Kind(
    "L", "the Lagrangian", units.ENERGY,
    "lagrangian", ("L",), ("L",), of="bodies", up_to_a_constant=True,
)  # fmt: skip
ENERGY = Kind(
    "E",
    "the total energy",
    units.ENERGY,
    letters=("E",),
    shared=("E",),
    of="bodies",
    up_to_a_constant=True,
)
BODY_KINETIC = Kind(
    "T_i", "the kinetic energy of body {}", units.ENERGY, letters=("k",), shared=("k",),
    of="bodies", of_one_body=True, letters_of_ratios=("K",),
)  # fmt: skip
BODY_POTENTIAL = Kind(
    "V_i",
    "the potential energy of body {}",
    units.ENERGY,
    of="bodies",
    up_to_a_constant=True,
    of_one_body=True,
)
POWER = Kind("power", unit=units.POWER, tells="motion", rates=("one", "some"))
MOMENTUM = Kind("momentum", unit=_momentum)

# ---------------------------------------------------------------- tip and bodies
JACOBIAN = Kind(
    "J", "entry {}, {} of the tip's Jacobian", None,
    "jacobian", ("J",), ("J",), "J", is_matrix=True, of="joints", has_rows_of_tip=True,
)  # fmt: skip
TWIST_JACOBIAN = Kind("J_s", is_matrix=True, of="joints")
JACOBIAN_RATE = Kind("J_d", of="bodies")
DETERMINANT = Kind("det", "the determinant of the tip's Jacobian", may_be_zero=True)
TIP = Kind(
    "tip", "a coordinate of the tip", units.LENGTH, of="bodies", has_legs=True,
    letters_of_slides=("x",),
)  # fmt: skip
TIP_VELOCITY = Kind(
    "tip_d", "a velocity of the tip", units.SPEED, of="bodies", dots=1, letters_of_slides=("x",)
)
TIP_ACCELERATION = Kind(
    "tip_dd", "an acceleration of the tip", units.ACCELERATION, of="bodies", dots=2,
    letters_of_slides=("x",),
)  # fmt: skip
TIP_TWIST = Kind("twist", "a velocity of the tip", of="bodies", dots=1)
MASS_OF_BODY = Kind("m", unit=units.MASS)
OF_BODY = Kind("of body", of="bodies", of_one_body=True, has_own_sense=True, may_be_still=True)
REACTION = replace(OF_BODY, name="reaction", is_reaction=True)
HAND_AXIS = replace(OF_BODY, name="axis", rates=("none",))
ANGULAR_MOMENTUM = Kind("angular momentum", unit=units.SPIN, is_told_by_value=True, rates=("one",))
HELD = Kind("held", unit=_force, of="joints", holds_by_loops=True)
"""The torque that a drive of a closed chain gives while a force from outside acts."""
LOAD = Kind("load", shared=("f",), is_load=True)

# ---------------------------------------------------------------- closed chains
LOOP = Kind("Phi", of="joints", of_loops="positions", may_be_zero=True, is_of_loop_equation=True)
LOOP_RATE = Kind("Phi_d", of="joints", of_loops="rates", may_be_zero=True, is_of_loop_equation=True)
LOOP_JACOBIAN = Kind("Phi_q", of="joints", of_loops="slopes", is_of_loop_equation=True)
LOOP_REST = Kind(
    "closing", of="joints", is_of_loop_equation=True, is_told_by_value=True,
    letters_of_ratios=("gamma",),
)  # fmt: skip
MULTIPLIER = Kind("lam", of="joints")
APPLIED = Kind("applied", unit=_force, of="joints")
OF_INDEPENDENT = Kind("N", of="joints", holds_by_loops=True)
DRIFT = Kind(
    "drift", of="joints", holds_by_loops=True, is_quotient=True, letters_of_ratios=("gamma",)
)
INPUT_OUTPUT = Kind("input-output", of="joints", up_to_rows=True)
LOOP_EQUATION = Kind("closed", holds_by_loops=True, is_equation=True)

# ---------------------------------------------------------------- what lines themselves tell
SOLVED = Kind(
    "solved", "solved for it", holds_by_loops=True, takes_quotients=True, has_velocity_terms=True,
    has_branches=True,
)  # fmt: skip
POSTURE = Kind("posture", is_posture=True, has_branches=True)
DERIVATIVE = Kind("derivative", "a derivative of the robot's quantities")
PARAMETER = Kind("parameter", "which a formula gives", is_given=True)
IDENTITY = Kind(
    "identity", _EQUATION, may_be_still=True, is_equation=True, takes_quotients=True,
    has_velocity_terms=True, has_branches=True,
)  # fmt: skip
LONG_EQUATION = Kind("long", _EQUATION, holds_by_loops=True, is_long=True, has_branches=True)
"""Kind of a closed chain's equation that is too long to be multiplied out: its sides are compared
in numbers."""
OWN = Kind("own")
SINGULAR = Kind("singular", is_pose=True)

LETTERED = (
    TORQUE, MASS, CORIOLIS, VELOCITY, GRAVITY, BIAS, JACOBIAN, KINETIC, POTENTIAL, LAGRANGIAN,
)  # fmt: skip
"""Kinds to which a notation may give letters."""
SHARED_LETTERS = frozenset(
    letter
    for kind in (MASS, VELOCITY, GRAVITY, ENERGY, BODY_KINETIC, LOAD)
    for letter in kind.shared
)
"""Letters that may be meant for something else than the quantities that have them."""
USUAL_LETTERS = {kind.name: kind.letters for kind in LETTERED}
"""Letters that `check` reads where a notation gives none."""
SUMS = {kind.name: kind.terms for kind in LETTERED if kind.terms}
"""Names of quantities that are sums, with the names of their terms."""
