"""The lecture notes, item by item: what each says, the call that executes it, and the verdict that
comes out.

S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019.
"""
