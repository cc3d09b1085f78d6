"""Scalars that algorithms are traced with.

`expr`: interned nodes of a graph, from which the compiler makes kernels.
"""
