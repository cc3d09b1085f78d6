"""Advice on what to measure next, so that an identification tells what it does not tell yet."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.errors import listed
from freebody.identification.drift import FrictionDrift
from freebody.identification.identification import (
    IdentificationOutcome,
    IdentifiedParameter,
    JointFit,
)
from freebody.identification.structure import JudgedStructure
from freebody.model.drives import LAWS


def what_next(
    parameters: Sequence[IdentifiedParameter],
    joints: Sequence[JointFit],
    drift: Sequence[FrictionDrift],
    outcome: IdentificationOutcome,
    scaled: bool,
    structure: JudgedStructure,
) -> tuple[str, ...]:
    """Sentences on logs and numbers that would tell more, the most useful first."""
    found = []
    if structure.withdrawn:
        found.append(
            "Mend the geometry, the zeros or the clock that the notices name before anything is "
            "measured again: the same logs then tell what they are good for. fb.calibrate finds "
            "geometry from measured poses."
        )
    elif structure.disagreement is not None:
        found.append(
            "Log the parts that disagree by themselves, with the same load and as warm, to see "
            "which of them is another robot's."
        )
    if not scaled:
        found.append(
            "Give a mass that is known, or a torque constant: without one all masses are right up "
            "to one factor. A weight at the tip, weighed beforehand, tells it."
        )
    if outcome == "not validated":
        found.append(
            "Log one more motion, unlike these, and give it to be predicted (validate=, "
            "--validate): what a model leaves of its own logs is no proof."
        )
    if outcome == "fails":
        found.append(
            "Look whether geometry, zeros, signs and the order of the joints are the robot's, and "
            "whether it carries the same in all logs; if so, log motions that are more like those "
            "to be predicted: the same speeds, postures and temperature."
        )
    untold = [x.name for x in parameters if x.kind == "inertial" and not x.told]
    if untold:
        found.append(
            f"Log a motion of fb.excitation, which tells {', '.join(untold[:6])}"
            f"{' and others' if len(untold) > 6 else ''} as well as the limits allow."
        )
    wrong = [x.joint for x in joints if not x.law_fits]
    if wrong:
        found.append(
            f"Log slow moves both ways of {', '.join(wrong)} at many constant rates, and try other "
            f"laws of friction (friction=), such as Stribeck's."
        )
    idle = _idle_laws(parameters)
    if idle and outcome != "fails":
        found.append(
            f"Identify the same logs without the laws of friction of which every interval holds "
            f"0, {listed(idle)} (friction=, --friction). If as little of the torque is left then, "
            f"other friction is told more closely, and the model has no law that nothing shows."
        )
    warm = [x.joint for x in drift if x.significant]
    if warm:
        found.append(
            f"Log again once {', '.join(warm)} {'is' if len(warm) == 1 else 'are'} as warm as at "
            f"work: friction changed meanwhile."
        )
    return tuple(found)


def _idle_laws(parameters: Sequence[IdentifiedParameter]) -> list[str]:
    """Names of the laws besides the usual ones whose intervals hold 0 at every joint."""
    laws = {law.strength: law.name for law in LAWS.values() if not law.usual}
    holds: dict[str, bool] = {}
    for x in parameters:
        law = laws.get(x.name.rsplit(".", 1)[-1]) if x.kind == "friction" else None
        if law is not None:
            holds[law] = holds.get(law, True) and x.lower <= 0.0 <= x.upper
    return [law for law, all_zero in holds.items() if all_zero]
