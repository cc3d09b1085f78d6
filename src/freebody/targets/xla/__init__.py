"""Compiled kernels as operations of XLA, which JAX calls inside its own programs on the CPU."""
