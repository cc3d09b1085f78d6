"""Records of what a designer buys: motors, gears and bearings.

Their numbers are those that makers' data sheets print, each a row of a table that the reader of
files, the checks and the documentation follow.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np

from freebody.arrays import Array
from freebody.design.data_sheets import Curve, DataSheet, PartNumber, mean_load, sure
from freebody.errors import shown
from freebody.outputs.number_text import compared


@dataclass(frozen=True, eq=False)
class Motor(DataSheet):
    """A motor as its data sheet has it; torques and speeds are those of its shaft.

    The curve of peak torque and that of continuous torque are pairs (speed in rad/s, torque in
    N m), straight between; beyond their last point there is no torque. Without a curve the torque
    is the same up to the highest speed.
    """

    inertia: float
    """The rotor's, with brake and encoder, kg m²."""
    continuous_torque: float
    peak_torque: float
    max_speed: float
    mass: float
    price: float | None = None
    torque_constant: float | None = None
    brake_torque: float | None = None
    brake_delay: float | None = None
    peak_curve: Curve = ()
    continuous_curve: Curve = ()

    WHAT: ClassVar[str] = "motor"
    CURVES: ClassVar[tuple[str, ...]] = ("peak_curve", "continuous_curve")
    NUMBERS: ClassVar[tuple[PartNumber, ...]] = (
        PartNumber("inertia", "kg m²", "inertia of the rotor, brake and encoder included",
                   "0 or more", True),
        PartNumber("continuous_torque", "N m", "torque that it gives for ever", needed=True),
        PartNumber("peak_torque", "N m", "torque that it gives for a moment", needed=True),
        PartNumber("max_speed", "rad/s", "highest speed", needed=True),
        PartNumber("mass", "kg", "mass, brake included", "0 or more", True),
        PartNumber("price", "", "price, in any one currency", "0 or more"),
        PartNumber("torque_constant", "N m/A", "torque for each ampere"),
        PartNumber("brake_torque", "N m", "torque that its brake holds"),
        PartNumber("brake_delay", "s", "time until its brake acts", "0 or more"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.peak_torque < self.continuous_torque:
            peak, most = compared(self.peak_torque, self.continuous_torque)
            raise self.refusal(f"peak_torque {peak} N m is below continuous_torque {most} N m")

    def peak_at(self, speed: Any) -> Array:
        """The peak torque (...) in N m at motor speeds (...) in rad/s, of any sign."""
        return self._limit(speed, self.peak_curve, self.peak_torque)

    def continuous_at(self, speed: Any) -> Array:
        """The continuous torque (...) in N m at motor speeds (...) in rad/s, of any sign."""
        return self._limit(speed, self.continuous_curve, self.continuous_torque)

    def _limit(self, speed: Any, curve: Curve, flat: float) -> Array:
        v = np.abs(np.asarray(speed, dtype=float))
        if not curve:
            return np.where(v <= self.max_speed * (1.0 + _ROUNDING), flat, 0.0)
        speeds, torques = np.array(curve).T
        return np.minimum(np.interp(v, speeds, torques, right=0.0), flat)


_ROUNDING = 1e-12


@dataclass(frozen=True)
class GearKind:
    """A kind of gear by how its life falls with its load: the exponent that its makers print, and
    where."""

    exponent: float
    source: str


GEAR_KINDS: dict[str, GearKind] = {
    "strain wave": GearKind(
        3.0,
        "Harmonic Drive AG, Engineering Data HFUC/CSD-2A, 1019659 11/2014, equations 18.2, 20.2",
    ),
    "cycloidal": GearKind(
        10.0 / 3.0, "Nabtesco, Precision Reduction Gear RV, E and N series, rated life"
    ),
}
"""Kinds of gears whose makers print how long they live."""


@dataclass(frozen=True, eq=False)
class Gear(DataSheet):
    """A gear as its data sheet has it: speeds and inertia at its input, torques at its output.

    Of a screw or a rack `lead` (m a turn of the input) stands in the place of `ratio`, and forces
    (N) in the place of torques. The life is what 90 % of gears reach at rated load and speed; of
    makers that print the mean life, a fifth of it (Harmonic Drive AG, equation 20.3).
    """

    efficiency: float
    """While the motor drives."""
    inertia: float
    mass: float
    ratio: float | None = None
    lead: float | None = None
    back_efficiency: float | None = None
    """While the joint drives; default: by the same loss, 2 - 1/efficiency."""
    price: float | None = None
    peak_torque: float | None = None
    """The torque that it bears at each start and stop."""
    average_torque: float | None = None
    momentary_torque: float | None = None
    max_speed: float | None = None
    average_speed: float | None = None
    rated_torque: float | None = None
    rated_speed: float | None = None
    rated_life: float | None = None
    life_exponent: float | None = None
    stiffness: float | None = None
    kind: str = ""
    """A key of `GEAR_KINDS`, or any other words."""
    fits: tuple[str, ...] = ()
    """Names of the motors that it can be mounted on; empty: all."""

    WHAT: ClassVar[str] = "gear"
    NUMBERS: ClassVar[tuple[PartNumber, ...]] = (
        PartNumber("efficiency", "", "efficiency, the motor driving", "above 0, up to 1", True),
        PartNumber("inertia", "kg m²", "inertia, at its input", "0 or more", True),
        PartNumber("mass", "kg", "mass", "0 or more", True),
        PartNumber("ratio", "", "motor speed over joint speed"),
        PartNumber("lead", "m", "way of a screw for each turn, in the place of a ratio"),
        PartNumber("back_efficiency", "", "efficiency, the joint driving", "above 0, up to 1"),
        PartNumber("price", "", "price, in the motors' currency", "0 or more"),
        PartNumber("peak_torque", "N m", "torque that it bears at starts and stops"),
        PartNumber("average_torque", "N m", "largest mean torque"),
        PartNumber("momentary_torque", "N m", "torque that it bears in an emergency"),
        PartNumber("max_speed", "rad/s", "highest speed of its input"),
        PartNumber("average_speed", "rad/s", "largest mean speed of its input"),
        PartNumber("rated_torque", "N m", "torque at which it lives as long as rated"),
        PartNumber("rated_speed", "rad/s", "speed of its input at which it lives as long as rated"),
        PartNumber("rated_life", "h", "life that 90 % of gears reach at rated torque and speed"),
        PartNumber("life_exponent", "", "power by which its life falls with the torque"),
        PartNumber("stiffness", "N m/rad", "torsional stiffness, at its output"),
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.ratio is None) == (self.lead is None):
            raise self.refusal("it needs a ratio, or the lead of a screw, and not both")
        if self.back_efficiency is None:
            back = 2.0 - 1.0 / self.efficiency
            if back <= 0.0:
                raise self.refusal(
                    f"with an efficiency of {self.efficiency:g} it may lock itself; give its "
                    f"back_efficiency, above 0, up to 1"
                )
            object.__setattr__(self, "back_efficiency", back)
        if self.life_exponent is None and self.kind in GEAR_KINDS:
            object.__setattr__(self, "life_exponent", GEAR_KINDS[self.kind].exponent)
        rated = [getattr(self, name) is not None for name in _RATED]
        if any(rated) and not all(rated):
            raise self.refusal(f"{', '.join(_RATED)} belong together; give all of them or none")
        if all(rated) and self.life_exponent is None:
            kinds = ", ".join(map(repr, GEAR_KINDS))
            raise self.refusal(
                f"its life has no life_exponent; give it, or a kind that is known by one: {kinds}"
            )
        if isinstance(self.fits, str):
            raise self.refusal("fits must be a list of names of motors")
        object.__setattr__(self, "fits", tuple(self.fits))

    @property
    def factor(self) -> float:
        """Motor speed over joint speed: the ratio, of a screw in rad/m."""
        return 2.0 * math.pi / self.lead if self.lead is not None else sure(self.ratio)

    @property
    def efficiencies(self) -> tuple[float, float]:
        """(efficiency while the motor drives, efficiency while the joint drives)."""
        return self.efficiency, sure(self.back_efficiency)

    def mean_torque(self, torque: Any, speed: Any, time: Any) -> float:
        """The torque that would wear the gear as its torques (k,) N m do at speeds (k,) rad/s
        during times (k,) s: (Σ n t |T|^p / Σ n t)^(1/p), p its life exponent (3 where none is
        given)."""
        return mean_load(torque, speed, time, self.life_exponent or 3.0)

    def life(self, mean_torque: float, mean_speed: float) -> float:
        """The life in h that 90 % of gears reach, at a mean torque at the output (N m) and a mean
        speed of the input (rad/s): L n_r/n (T_r/T)^p. NaN where it is not rated."""
        if self.rated_life is None:
            return math.nan
        if mean_torque == 0.0 or mean_speed == 0.0:
            return math.inf
        load = (sure(self.rated_torque) / mean_torque) ** sure(self.life_exponent)
        return self.rated_life * sure(self.rated_speed) / mean_speed * load


_RATED = ("rated_torque", "rated_speed", "rated_life")


BearingKind = Literal["crossed roller", "radial"]

CROSSED_STATIC_AXIAL = 0.44
"""Y₀, by which axial forces count in the static equivalent load of a crossed roller bearing."""


@dataclass(frozen=True, eq=False)
class Bearing(DataSheet):
    """A bearing as its data sheet has it.

    A crossed roller bearing carries radial force F_r, axial force F_a and tilting moment M as
    P = X (F_r + 2 M/d) + Y F_a with X = 1, Y = 0.45 where F_a ≤ 1.5 (F_r + 2 M/d), else 0.67 both
    (Harmonic Drive, CSF/CSG catalogue, equation 16 and list 2; IKO, Crossed Roller Bearings,
    equation 1 and table 5). A radial one carries no moment: P = F_r where F_a ≤ e F_r, else
    X F_r + Y F_a (ISO 281), by its maker's X, Y and e.
    """

    kind: BearingKind
    dynamic_load: float
    """C, N."""
    static_load: float | None = None
    """C₀, N."""
    pitch_diameter: float | None = None
    x: float | None = None
    y: float | None = None
    e: float | None = None
    life_exponent: float | None = None
    """Default: 10/3 of rollers; of radial bearings 3, that of balls."""
    load_factor: float = 1.0
    """f_w, by which impacts make loads count for more: 1 to 1.2 without, 1.2 to 1.5 normally, 1.5
    to 3 with impacts (Harmonic Drive AG, 1021387 12/2018, table 42.3)."""
    moment_limit: float | None = None
    mass: float | None = None
    price: float | None = None
    static_factor: float = 1.0
    """f_s, by which static equivalent loads are to stay below C₀ (ISO 76); makers ask for more than
    1 where the bearing has to run smoothly, or meets impacts."""

    WHAT: ClassVar[str] = "bearing"
    NUMBERS: ClassVar[tuple[PartNumber, ...]] = (
        PartNumber("dynamic_load", "N", "basic dynamic load rating C", needed=True),
        PartNumber("static_load", "N", "basic static load rating C₀"),
        PartNumber("pitch_diameter", "m", "pitch circle of the rollers, of a crossed roller one"),
        PartNumber("x", "", "radial factor X, of a radial one", "0 or more"),
        PartNumber("y", "", "axial factor Y, of a radial one", "0 or more"),
        PartNumber("e", "", "axial over radial force from which X and Y count", "0 or more"),
        PartNumber("life_exponent", "", "power by which its life falls with the load"),
        PartNumber("load_factor", "", "factor for impacts", needed=True),
        PartNumber("static_factor", "", "factor by which static loads stay below C₀", needed=True),
        PartNumber("moment_limit", "N m", "largest tilting moment"),
        PartNumber("mass", "kg", "mass", "0 or more"),
        PartNumber("price", "", "price", "0 or more"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.kind not in get_args(BearingKind):
            kinds = " or ".join(map(repr, get_args(BearingKind)))
            raise self.refusal(f"its kind is {shown(self.kind)}, expected {kinds}")
        crossed = self.kind == "crossed roller"
        needed = ("pitch_diameter",) if crossed else ("x", "y", "e")
        for name in needed:
            if getattr(self, name) is None:
                raise self.refusal(f"a {self.kind} bearing needs {name}")
        if self.life_exponent is None:
            object.__setattr__(self, "life_exponent", 10.0 / 3.0 if crossed else 3.0)

    def equivalent_load(self, radial: Any, axial: Any, moment: Any = 0.0) -> Array:
        """The dynamic equivalent load P (...) in N of radial and axial forces (...) in N and
        tilting moments (...) in N m about the bearing's centre."""
        Fr, Fa, M = (np.abs(np.asarray(x, dtype=float)) for x in (radial, axial, moment))
        if self.kind == "radial":
            if np.any(M > 0.0):
                raise self.refusal(
                    "a single radial bearing carries no tilting moment; give the forces of each "
                    "of two, or a crossed roller bearing"
                )
            x, y, e = sure(self.x), sure(self.y), sure(self.e)
            return np.where(Fa <= e * Fr, Fr, x * Fr + y * Fa)
        across = Fr + 2.0 * M / sure(self.pitch_diameter)
        light = Fa <= 1.5 * across
        return np.where(light, across + 0.45 * Fa, 0.67 * (across + Fa))

    def static_equivalent_load(self, radial: Any, axial: Any, moment: Any = 0.0) -> Array:
        """The static equivalent load P₀ (...) in N of a crossed roller bearing,
        F_r + 2 M/d + 0.44 F_a (IKO, equation 2; THK, Cross-Roller Ring)."""
        if self.kind != "crossed roller":
            raise self.refusal("static equivalent loads are told of crossed roller bearings alone")
        Fr, Fa, M = (np.abs(np.asarray(x, dtype=float)) for x in (radial, axial, moment))
        return Fr + 2.0 * M / sure(self.pitch_diameter) + CROSSED_STATIC_AXIAL * Fa

    def life(self, equivalent_load: float, mean_speed: float) -> float:
        """The life in h that 90 % of bearings reach under an equivalent load (N) at a mean speed
        (rad/s): 10⁶/(60 n) (C/(f_w P))^p, n in rpm (ISO 281)."""
        if equivalent_load == 0.0 or mean_speed == 0.0:
            return math.inf
        rpm = mean_speed * 30.0 / math.pi
        ratio = self.dynamic_load / (self.load_factor * equivalent_load)
        return 1e6 / (60.0 * rpm) * ratio ** sure(self.life_exponent)
