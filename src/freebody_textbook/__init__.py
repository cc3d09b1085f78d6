"""The textbook: closed-form equations, their derivation step by step, quantities and relations by
name, a reader's own answers compared with the right ones, and pages that can be tried.

It builds on freebody, which works without it: `freebody.beside` says what it adds.
"""
