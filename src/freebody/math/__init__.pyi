"""What type checkers read of `freebody.math`: the names of `scalar_math.py`. A file math.py would
hide the standard library's from a Python that is started in its folder; this folder hides nothing,
since an interpreter finds no module in it."""

from freebody.scalar_math import *
