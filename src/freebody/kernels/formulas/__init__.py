"""The table of what can be computed: for each name its inputs, its outputs and the algorithm that
does it.

Kernels are traced from this table and the float reference runs it as it stands, so both are the
same text. Each family of formulas has a file, and each formula one record there.
"""

from freebody.kernels.formulas import (
    controllers,
    derivatives,
    dynamics,
    energies,
    inverse,
    kinematics,
    loops,
    operational,
    regressors,
    steps,
)
from freebody.kernels.formulas.record import INPUTS, POSITIONS, Formula, Option

__all__ = ["FORMER_NAMES", "FORMULAS", "INPUTS", "POSITIONS", "Formula", "Option"]

FORMULAS: dict[str, Formula] = {
    name: formula
    for family in (
        kinematics,
        inverse,
        dynamics,
        derivatives,
        operational,
        regressors,
        steps,
        controllers,
        loops,
        energies,
    )
    for name, formula in family.FORMULAS.items()
}

FORMER_NAMES = {"closed_wrenches": "reaction_wrenches"}
"""Names that formulas had before; `fb.kernel` and all that takes names still knows them."""
