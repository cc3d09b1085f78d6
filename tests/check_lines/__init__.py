"""Lines with which `fb.check` is examined from outside: right ones and ones with a mistake.

Every line is written from a tree of its own, in the letters of books and tools, and judged by
numbers that come from a derivation of its own: nothing here asks `check` or its tables.
"""
