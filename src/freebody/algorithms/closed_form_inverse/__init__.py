"""Every closed-form inverse kinematics branch side by side, as arithmetic over scalars.

Which recipe fits an arm is decided by how its lines lie, which is told by numbers, once; what a
recipe does to a target has no branch on a value.
"""
