"""The last step of every method: the equations of motion, sorted as (3.20)-(3.28)."""

from __future__ import annotations

from freebody.derivations.derivation import Step
from freebody.derivations.methods import wording
from freebody.derivations.methods.setting import Setting


def closed_form(setting: Setting) -> Step:
    """Torques sorted by accelerations, rates and gravity; with a load on the tip, those of the arm without it."""
    equations = setting.equations
    parts = ["accelerations", "products of rates", *(["gravity"] if setting.weighs else [])]
    sorting = f"Sorting by {', '.join(parts[:-1])} and {parts[-1]}"
    numbers = {"RR": tuple(f"3.{k}" for k in range(20, 29))}.get(setting.cited, ("3.28",))
    if not equations.is_short:
        counts = equations.count()
        long = (
            f"{sorting} the closed form has {counts['M']} terms in the mass matrix, {counts['c']} in the velocity "
            f"terms and {counts['g']} in gravity: too long to read, but exact; fb.equations gives it."
        )
        return Step("The closed form", long, (), numbers, result=True)
    found = ["the mass matrix H"]
    found += ["the velocity terms h"] if any(not x.is_zero for x in equations.c) else []
    found += ["gravity G"] if any(not x.is_zero for x in equations.g) else []
    reason = f"{sorting} gives {wording.listed(found)}."
    if setting.cited == "RR":
        reason += " The notes' (3.22) to (3.24) are printed with slips; these are the corrected ones."
    if setting.load:
        reason += " The load's part, found above, comes on top."
    lines = tuple(line for group in equations.groups("named") for line in group)
    return Step("The closed form", reason, lines, numbers, result=True)
