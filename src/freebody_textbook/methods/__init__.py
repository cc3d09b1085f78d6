"""Methods of deriving the equations of motion, one file each, and their table."""

from freebody_textbook.derivation import Method
from freebody_textbook.methods import (
    first_kind,
    kane,
    kinematics,
    lagrange,
    newton_euler,
    recursive,
    statics,
)

METHODS: dict[str, Method] = {
    module.METHOD.name: module.METHOD
    for module in (
        newton_euler,
        recursive,
        lagrange,
        first_kind,
        kane,
        statics,
        kinematics,
    )
}
"""The methods by name; where none is asked for, the first that serves the robot is taken."""
