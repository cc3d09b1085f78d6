"""What acts on a body that nothing holds, and what a student may think of it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Physics:
    """What acts on a free body, and what a student may think of it."""

    thought: str = ""
    gyroscopic: int = 1
    """The factor of ω × I ω."""
    transport: int = 1
    """The factor of ω × v."""
    weight: int = 1
    axes: str = "body"
    """How forces are turned: "body" as it must be, "" not at all, "back" by Rᵀ into the world."""
    arms: tuple[int, int] = (1, 1)
    """Factors of the thrusts' moments about x and y."""
    angular: bool = True
    """Whether the rates of the angles follow from ω; else they are taken for it."""


THOUGHTS = (
    Physics("The gyroscopic moment has the wrong sign: I ω̇ + ω × I ω = n.", gyroscopic=-1),
    Physics("The gyroscopic moment is missing: I ω̇ + ω × I ω = n.", gyroscopic=0),
    Physics(
        "The weight has the wrong direction: z points up here, and gravity acts along −z.",
        weight=-1,
    ),
    Physics("The weight is missing.", weight=0),
    Physics(
        "ω × v has the wrong sign: in axes that turn the acceleration is v̇ + ω × v.", transport=-1
    ),
    Physics("ω × v is missing: in axes that turn the acceleration is v̇ + ω × v.", transport=0),
    Physics(
        "f is all that acts besides the weight, and in axes that turn the acceleration is "
        "v̇ + ω × v.",
        transport=0,
        weight=0,
    ),
    Physics(
        "The thrust's arm has the wrong sign: a thrust T at s has the moment s × T, about x that "
        "is y T.",
        arms=(-1, 1),
    ),
    Physics(
        "The thrust's arm has the wrong sign: a thrust T at s has the moment s × T, about y that "
        "is −x T.",
        arms=(1, -1),
    ),
    Physics(
        "Forces are not rotated: the thrust acts along the body's axes, the weight along the "
        "world's.",
        axes="",
    ),
    Physics(
        "R is transposed: it takes components from the body's axes to the world's.", axes="back"
    ),
    Physics(
        "This takes the rates of the angles for ω, which is right near hover only: ω̇ is that of "
        "the body, and φ̇ = p + (q sin φ + r cos φ) tan θ.",
        angular=False,
    ),
    Physics(
        "This is right near hover only, where φ̇ = p and products of rates vanish.",
        angular=False,
        gyroscopic=0,
    ),
)
"""Single thoughts that explain a wrong equation."""
