"""Exact values of answers: quotients, expression trees, polynomials, finite fields."""
