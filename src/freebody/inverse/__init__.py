"""Positions and rates that bring a frame to a target.

In front the public functions: `inverse_kinematics`, `inverse_rates`, `singularities`. Behind them
the `ways` to solutions: by a closed form, from an arm nearby, from many starts, and for closed
chains. At the back the `problem`: task, solver, closed form of an arm, and the record of what was
found.
"""
