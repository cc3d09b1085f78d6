"""Formulas of energies and momentum."""

from __future__ import annotations

from freebody.algorithms import energy
from freebody.kernels.formulas.record import Formula, one
from freebody.model.doubt_rules.aspects import INERTIAL, MASSES, ROTORS

FORMULAS = {
    "kinetic_energy": Formula(
        ("q", "qd"),
        one("T", (), "kinetic energy (J)"),
        lambda t, o, q, qd: (energy.kinetic_energy(t, q, qd),),
        touches=(*INERTIAL, ROTORS),
    ),
    "potential_energy": Formula(
        ("q",),
        one("V", (), "potential energy (J)"),
        lambda t, o, q: (energy.potential_energy(t, q),),
        touches=(MASSES,),
    ),
    "momentum": Formula(
        ("q", "qd", "point"),
        one("h", ("six",), "linear, then angular momentum (kg m/s, kg m^2/s)"),
        lambda t, o, q, qd, point=None: (energy.momentum(t, q, qd, point),),
        touches=INERTIAL,
    ),
}
