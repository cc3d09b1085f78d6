"""The verdict on an identification: what it predicts, what it rests on, what it does not tell."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.arrays import Array
from freebody.identification.identification import IdentificationOutcome, JointFit
from freebody.identification.priors import Prior
from freebody.outputs.display import counted

QUANTILE = 1.96
"""Standard deviations on each side of an interval of 95 %."""
_NOISY = 3.0
"""Times the inflation of white noise above which a residual is more than noise."""
_WORSE, _POINTS = 1.5, 0.01
"""Factor, and part of the torque besides, by which unseen logs may be predicted worse."""


def outcome_of(joints: Sequence[JointFit]) -> IdentificationOutcome:
    """Whether the model predicts what it has not seen about as well as what it was made from."""
    if joints[0].validation is None:
        return "not validated"
    worse = [x for x in joints if (x.validation or 0.0) > _WORSE * x.model + _POINTS]
    return "fails" if worse else "predicts"


def verdict_of(outcome: str, joints: Sequence[JointFit], scaled: bool, held: Prior) -> str:
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
    if not scaled:
        return f"{said}; the scale of torques and masses is not told."
    if held.source == "geometry":
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


def mass_doubts(held: Prior, scaled: bool) -> list[str]:
    """Doubts on its masses that the model itself carries, wherever it is saved and used."""
    if held.source == "model":
        return []
    what = "masses, centres and inertias" if held.source == "geometry" else "centres and inertias"
    scale = "" if scaled else ", and all are right up to one unknown factor"
    return [
        f"the model is identified from logs: torques of its drives follow from them, but single "
        f"{what} of links are estimated from its geometry{scale}."
    ]


def notices_of(
    held: Prior,
    scaled: bool,
    joints: Sequence[JointFit],
    untold: Sequence[str],
    gains: Array | None,
    unsure: float,
) -> list[str]:
    """Sentences on what an identification rests on and what it does not tell."""
    found = []
    if gains is not None and not scaled:
        found.append(
            "The scale is not told: the logs have currents with unknown gains, and no mass is "
            "known; gains, masses and frictions are right up to one common factor. Give masses "
            "(prior=), or a torque constant."
        )
    if gains is not None and scaled:
        found.append(
            f"Gains and masses have a common factor that the given masses alone tell, to "
            f"{100.0 * QUANTILE * unsure:.0f} % at best (95 %)."
        )
    if held.source == "geometry":
        found.append(
            "No masses were given: single masses, centres and inertias in the model are guesses "
            "from its geometry that agree with the base parameters; torques do not depend on them."
        )
    wrong = [x.joint for x in joints if not x.law_fits]
    if wrong:
        found.append(
            f"The law of friction does not fit at {', '.join(wrong)}: what is left depends on the "
            f"rate; intervals of their friction are withdrawn, those of base parameters hold "
            f"whatever odd function of the rate it is."
        )
    coloured = [x.joint for x in joints if x.independent > _NOISY]
    if coloured:
        found.append(
            f"What is left at {', '.join(coloured)} is more than noise; intervals are wider for "
            f"it, and hold as far as it is independent of the motion."
        )
    if untold:
        found.append(
            f"{counted(len(untold), 'base parameter')} that these motions do not tell: "
            f"{', '.join(untold)}."
        )
    return found
