"""Singular values and their thresholds: below which ratio to the largest one a matrix counts as
singular, for each purpose, with the reason for the number.

Rows and columns have been scaled before, so that lengths and angles compare. A threshold is as low
as rounding allows where a result is exact above it, and higher where a kernel or a person only has
to be warned.
"""

LOST = 1e-12
"""A singular value as a result: what is smaller is rounding of the decomposition, and reads 0."""

NO_WRENCH = 1e-12
"""`tip_wrench` solves one square system, whose error is this ratio's inverse times 1e-16."""

NO_INVERSE = 1e-10
"""Inverse rates and the inertia seen from a frame have no inverse of the Jacobian: they are divided
by the smallest singular value, the inertia by its square."""

SURELY_INDEPENDENT = 1e-6
"""Kernels work with J Jᵀ, whose ratio is the square of this: above it they are right to rounding,
below it they return NaN and the sample is looked at with singular values."""

RANK = 1e-9
"""Loop equations at a position that is given or assembled: Φ_q is known there to some 1e-12."""

RANK_WHERE_FOUND = 1e-8
"""Loop equations at a position that was found by a search, which is closed to fewer digits."""

BLURRED = 1e-5
"""Loop equations for accelerations, in which rounding is divided by the square of a singular
value."""

AT_REST = 1e-6
"""Loop equations for accelerations of a mechanism at rest, where rounding in the computation may
change them by 1e-4."""

LOST_MOTION = 1e-7
"""Input and output of a parallel robot: the type of a singular position is told where a position
that is typed in with seven digits is singular, well before `RANK`, below which there is no J."""

FOUND = 1e-9
"""A search for singular positions ends by Newton steps, which get this near."""

NO_BRANCH = 1e-5
"""Motion along a path of the tip: nearer to a singular position the branches of joint positions
cannot be told apart."""

CALLED_SINGULAR = 1e-3
"""A study says that the robot passes a singular position: joint rates are a thousand times those of
its best direction."""
