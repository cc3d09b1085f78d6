"""The lecture notes, item by item: the statement of each, the call that checks it, and the verdict.

S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019.
"""
