"""Two unknown joints of a planar loop in closed form: triangles and circles, each with its two
solutions.

A loop is cut at its pin. Seen from a joint in it, everything on the way to one end of the cut
turns, or slides, against everything on the way to the other; what lies between two unknown joints
is rigid, whatever its links. So two unknown pins and the cut make a triangle with known sides: R R
R. Vectors are complex numbers, arrays (N, K) of samples and solutions. A further kind is a class
here and a line in a table.
"""

from freebody.loops.dyads.chain import (
    Chain,
    Crossing,
    Posture,
    chain,
    coordinate,
    coordinates,
    is_turning,
)
from freebody.loops.dyads.rods import STRETCH, SWING
from freebody.loops.dyads.slides import SLIDE_AND_TURN, TURN_AND_SLIDE, TWO_SLIDES
from freebody.loops.dyads.step import ConstructionStep, OfOne, OfTwo, heading
from freebody.loops.dyads.triangle import TRIANGLE
from freebody.loops.dyads.two_circles import two_circles

__all__ = [
    "OF_ONE",
    "OF_TWO",
    "Chain",
    "ConstructionStep",
    "Crossing",
    "Posture",
    "chain",
    "coordinate",
    "coordinates",
    "heading",
    "is_turning",
]

OF_ONE: dict[tuple[bool, str], OfOne] = {
    (kind.rod, kind.joints): kind
    for kind in (TRIANGLE, TURN_AND_SLIDE, SLIDE_AND_TURN, TWO_SLIDES, SWING, STRETCH)
}
"""Kinds that close one chain, by whether its ends stay a distance apart, and its unknown joints in
their order."""

OF_TWO: tuple[OfTwo, ...] = (two_circles,)
"""Constructions of two unknown joints, in the order in which they are tried."""
