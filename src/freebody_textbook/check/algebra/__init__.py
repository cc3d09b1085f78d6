"""Exact values of answers: quotients, trees of terms, polynomials, finite fields."""
