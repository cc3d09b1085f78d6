"""Computations of a robot that leave freebody for users' own programs: kernels and formulas by
name, source text, functions of JAX and PyTorch."""
