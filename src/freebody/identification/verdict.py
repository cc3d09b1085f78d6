"""The verdict on an identification: what it predicts, what it rests on, what it does not tell."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from freebody.identification.identification import IdentificationOutcome, JointFit, is_known
from freebody.identification.priors import Prior
from freebody.identification.structure import JudgedStructure
from freebody.outputs.display import counted

QUANTILE = 1.96
"""Standard deviations on each side of an interval of 95 %."""
_NOISY = 3.0
"""Times the inflation of white noise above which a residual is more than noise."""
_WORSE, _POINTS = 1.5, 0.01
"""Factor, and part of the torque besides, by which unseen logs may be predicted worse, or a robot
that can exist be worse than the regression."""
_NOTHING = 0.5
"""Part of a joint's torque that is left from which on it is not predicted at all."""
_BRAKES = 0.05
"""Part of a joint's torque from which on friction is large enough to have a direction."""


class ToldScale(NamedTuple):
    """The interval of 95 % of the factor that torques, masses and frictions have in common, and the
    mass (kg) of the load that told it, if one did."""

    factors: tuple[float, float]
    load: float | None

    @property
    def percent(self) -> str:
        """The interval as text, from the estimate: -20 … +25 %."""
        least, most = (100.0 * (x - 1.0) for x in self.factors)
        return f"{least:+.2g} … {most:+.2g} %".replace("-", "−")


def outcome_of(joints: Sequence[JointFit]) -> IdentificationOutcome:
    """Whether the model predicts what it has not seen about as well as what it was made from."""
    if joints[0].validation is None:
        return "not validated"
    left = [(x.validation or 0.0, x.model) for x in joints]
    worse = [x for x in left if x[0] > _NOTHING or _much_more(*x)]
    return "fails" if worse or _impossible(joints) else "predicts"


def _impossible(joints: Sequence[JointFit]) -> list[str]:
    """Joints whose torque no robot that can exist gives: the regression leaves far less, or hardly
    anything of it is predicted, or its friction pushes."""
    return [
        x.joint
        for x in joints
        if _much_more(x.model, x.regression) or x.model > _NOTHING or x.friction < -_BRAKES
    ]


def _much_more(left: float, expected: float) -> bool:
    return left > _WORSE * expected + _POINTS


def verdict_of(
    outcome: str,
    joints: Sequence[JointFit],
    scale: ToldScale,
    held: Prior,
    structure: JudgedStructure,
) -> str:
    """The verdict in one sentence, with what it rests on."""
    worst = max(joints, key=lambda x: x.model if x.validation is None else x.validation)
    if outcome == "not validated":
        said = (
            f"Not validated: it leaves at most {100.0 * worst.model:.1f} % of a joint's torque "
            f"({worst.joint}) of the logs that it was made from; give others to validate with"
        )
    else:
        known = 100.0 * (worst.validation or 0.0)
        does = "Predicts" if outcome == "predicts" else "Does not predict"
        said = (
            f"{does} logs that it has not seen: at most {known:.1f} % of a joint's torque is left "
            f"({worst.joint})"
        )
    if not structure.fits:
        return f"{said}; {structure.doubt()}."
    if scale.factors[0] == 0.0:
        return f"{said}; the scale of torques and masses is not told."
    if not is_known(scale.factors):
        return f"{said}; the scale of torques and masses is told to {scale.percent} alone."
    if held.source in ("geometry", "nothing"):
        return f"{said}; base parameters and torques are the logs', single masses are not told."
    source = "the model's" if held.source == "model" else "the given ones"
    return f"{said}; single masses are near {source}, which logs do not tell."


def definiteness(thin: Sequence[str]) -> str:
    """The sentence on whether the mass matrix is positive definite, and why. thin: bodies at the
    edge of what exists.

    M is the sum of Jᵀ I J over the bodies, and rotors that are not negative. Where a joint moves,
    so does the first body behind it, and a body with a positive definite pseudo-inertia has a
    positive definite spatial inertia I; so no rates have a kinetic energy of 0.
    """
    if thin:
        return (
            f"The base values lie at the edge of what bodies can be: {', '.join(thin)} is or are "
            f"nearly without extent in some direction. Look for a wrong sign or unit, or too "
            f"little motion."
        )
    return (
        "The mass matrix is positive definite in every posture, since the pseudo-inertia of every "
        "body is, and no rotor's inertia is negative."
    )


def mass_doubts(held: Prior, scale: ToldScale) -> list[str]:
    """Doubts on its masses that the model itself carries, wherever it is saved and used."""
    factor = ""
    if scale.factors[0] == 0.0:
        factor = "right up to one unknown factor"
    elif not is_known(scale.factors):
        factor = f"right up to one factor, told to {scale.percent}"
    if held.source == "model":
        said = "the model is identified from currents: masses, frictions and torques are"
        return [f"{said} {factor}."] if factor else []
    factor = f", and all are {factor}" if factor else ""
    what = "centres and inertias" if held.source == "masses" else "masses, centres and inertias"
    whence = "any that give them" if held.source == "nothing" else "estimated from its geometry"
    return [
        f"the model is identified from logs: torques of its drives follow from them, but single "
        f"{what} of links are {whence}{factor}."
    ]


def notices_of(
    held: Prior,
    scale: ToldScale,
    joints: Sequence[JointFit],
    untold: Sequence[str],
    structure: JudgedStructure,
) -> list[str]:
    """Sentences on what an identification rests on and what it does not tell."""
    found = structure.notices()
    if scale.factors[0] == 0.0:
        found.append(
            "The scale is not told: the logs have currents with unknown gains, and no mass is "
            "known; gains, masses and frictions are right up to one common factor. Give logs "
            "with a load of known mass (loaded=, load=), masses (prior=), or a torque constant."
        )
    elif scale.factors[1] > 1.0:
        teller = (
            "the given masses alone tell"
            if scale.load is None
            else (f"the load of {scale.load:g} kg tells")
        )
        found.append(
            f"Gains, masses and frictions have a common factor that {teller}, to "
            f"{scale.percent} (95 %); intervals are wider for it."
        )
    if held.source == "geometry":
        found.append(
            "No masses were given: single masses, centres and inertias in the model are guesses "
            "from its geometry that agree with the base parameters; torques do not depend on them."
        )
    pushing = [x.joint for x in joints if x.friction < -_BRAKES]
    if pushing:
        found.append(
            f"Friction pushes instead of braking at {', '.join(pushing)}: the torques are those of "
            f"another joint or log, or they or the positions and rates have the other sign; write "
            f"signs or columns in the table [log] of the logs' TOML file."
        )
    strange = [x for x in joints if x.joint in _impossible(joints) and x.joint not in pushing]
    if strange:
        left = ", ".join(
            f"{x.joint} ({100.0 * x.model:.0f} %; of any masses, {100.0 * x.regression:.0f} %)"
            for x in strange
        )
        found.append(
            f"No robot of this geometry gives these torques: so much of them is left at {left}. "
            f"Look whether the columns are in the joints' order, with their signs and units, and "
            f"whether geometry, zeros and gravity are the robot's."
        )
    if held.source == "nothing":
        found.append(
            "Single masses, centres and inertias in the model are any that bodies can have and "
            "that give the base parameters; nothing that was held beforehand chose them."
        )
    found += _on_residuals(joints, structure)
    if untold:
        found.append(
            f"{counted(len(untold), 'base parameter')} that these motions do not tell: "
            f"{', '.join(untold)}."
        )
    return found


def _on_residuals(joints: Sequence[JointFit], structure: JudgedStructure) -> list[str]:
    """Sentences on joints whose residual is more than noise."""
    found = []
    wrong = [x.joint for x in joints if not x.law_fits]
    if wrong:
        others = (
            ", those of base parameters hold whatever odd function of the rate it is"
            if structure.fits
            else ""
        )
        found.append(
            f"The law of friction does not fit at {', '.join(wrong)}: what is left depends on the "
            f"rate; intervals of their friction are withdrawn{others}."
        )
    coloured = [x.joint for x in joints if x.independent > _NOISY]
    if coloured and structure.fits:
        found.append(
            f"What is left at {', '.join(coloured)} is more than noise; intervals are wider for "
            f"it, and hold as far as it is independent of the motion."
        )
    return found
