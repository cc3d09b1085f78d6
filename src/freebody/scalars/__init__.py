"""Kinds of scalars with which algorithms are traced.

`expr`: interned nodes of a graph, from which the compiler makes kernels.
"""
