"""How long the equations of motion in closed form take, by freebody and by SymPy's Lagrange method,
in one run.

The same arms on both sides, every length, mass, first moment and inertia a symbol. freebody makes
M, C (Christoffel symbols), c and g as polynomials in normal form, in which equal means identical.
SymPy makes M and the remaining terms (`LagrangesMethod.mass_matrix`, `.forcing`) from the same
energies, as it leaves them: not expanded, not simplified, and with velocity and gravity terms in
one sum.
"""

from __future__ import annotations

import argparse
import platform
import statistics
import time

import numpy as np
import sympy
from sympy.physics.mechanics import LagrangesMethod, dynamicsymbols

import freebody as fb
from common import processor, seconds
from freebody.model.model import Model

HALF = 1.5707963267948966
PUMA = (HALF, 0.0, -HALF, HALF, -HALF, 0.0)
"""Twists of a Puma's axes."""
IIWA = (-HALF, HALF, HALF, -HALF, -HALF, HALF, 0.0)
"""Twists of an iiwa's axes."""


def main() -> None:
    """A table of freebody's times, then SymPy's beside them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "--joints", type=int, default=4, help="joints up to which SymPy derives too"
    )
    parser.add_argument(
        "--repeats", type=int, default=5, help="runs of freebody, of which the median counts"
    )
    options = parser.parse_args()
    print(
        f"freebody {fb.__version__}, SymPy {sympy.__version__}, Python "
        f"{platform.python_version()}, {processor()}\n"
    )
    print("freebody: M, C, c and g in normal form")
    print(f"{'arm':34}{'median':>10}{'slowest':>10}{'terms of M':>12}{'of c':>9}{'of g':>7}")
    for name, model in ARMS.items():
        taken = [
            seconds(lambda model=model: derived(model), clock=time.perf_counter)
            for _ in range(options.repeats)
        ]
        count = fb.equations(model).count()
        print(
            f"{name:34}{statistics.median(taken):9.3f}s{max(taken):9.3f}s"
            f"{count['M']:12}{count['c']:9}{count['g']:7}"
        )
    print(
        "\nthe same arm by both: Puma-like twists, all symbols; difference of the results at one "
        "state"
    )
    heads = ("freebody", "SymPy, M and forcing", "ratio", "SymPy operations", "difference")
    print("joints" + "".join(f"{head:>{len(head) + 3}}" for head in heads))
    for n in range(1, options.joints + 1):
        model = spatial(PUMA[:n])
        mine = statistics.median(
            seconds(lambda model=model: derived(model), clock=time.perf_counter)
            for _ in range(options.repeats)
        )
        start = time.perf_counter()
        M, forcing = by_sympy(model)
        theirs = time.perf_counter() - start
        operations = int(sympy.count_ops(M) + sympy.count_ops(forcing))
        apart = difference(model, M, forcing)
        print(f"{n:6}{mine:10.4f}s{theirs:22.2f}s{theirs / mine:7.0f}x{operations:19}{apart:13.0e}")


def spatial(twists: tuple[float, ...]) -> Model:
    """An arm by its DH table: a_i and d_i by name, and ten inertial parameters a body."""
    rows = [
        {
            "alpha": alpha,
            "a": f"a{i}",
            "d": f"d{i}",
            "m": f"m{i}",
            "com": [f"c{i}{x}" for x in "xyz"],
            "I": [f"I{i}{xy}" for xy in ("xx", "xy", "xz", "yy", "yz", "zz")],
        }
        for i, alpha in enumerate(twists, 1)
    ]
    return fb.dh(rows, convention="standard", name="arm")


ARMS = {
    "planar 2R": fb.planar("RR"),
    "planar 10R": fb.planar("R" * 10),
    "6R, Puma-like": spatial(PUMA),
    "7R, iiwa-like": spatial(IIWA),
}


def derived(model: Model) -> None:
    """All of it, from the model."""
    equations = fb.equations(model)
    _ = equations.M, equations.C, equations.c, equations.g


def by_sympy(model: Model) -> tuple[sympy.Matrix, sympy.Matrix]:
    """M and forcing from kinetic and potential energy, positions and velocities put together link
    by link."""
    t = dynamicsymbols._t
    q = dynamicsymbols(f"q1:{model.nv + 1}")
    gravity = sympy.Symbol("g")
    R, p, w = sympy.eye(3), sympy.zeros(3, 1), sympy.zeros(3, 1)
    L = sympy.S.Zero
    for i, alpha in enumerate(PUMA[: model.nv], 1):
        a, d, m = sympy.symbols(f"a{i} d{i} m{i}")
        w = w + R[:, 2] * q[i - 1].diff(t)  # the axis of joint i is z of frame i-1
        c, s = sympy.cos(q[i - 1]), sympy.sin(q[i - 1])
        ca, sa = round_cos(alpha)
        p = p + R * sympy.Matrix([a * c, a * s, d])
        R = R * sympy.Matrix([[c, -s * ca, s * sa], [s, c * ca, -c * sa], [0, sa, ca]])
        centre = p + R * sympy.Matrix(sympy.symbols(f"c{i}x c{i}y c{i}z"))
        v = centre.diff(t)
        xx, xy, xz, yy, yz, zz = sympy.symbols(
            " ".join(f"I{i}{k}" for k in ("xx", "xy", "xz", "yy", "yz", "zz"))
        )
        local = R.T * w
        inertia = sympy.Matrix([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        L += m * v.dot(v) / 2 + (local.T * inertia * local)[0] / 2 - m * gravity * centre[2]
    method = LagrangesMethod(L, q)
    method.form_lagranges_equations()
    return method.mass_matrix, method.forcing


def difference(model: Model, M: sympy.Matrix, forcing: sympy.Matrix) -> float:
    """Largest deviation of SymPy's M and c + g from freebody's at one state, relative to the
    largest entry."""
    rng = np.random.default_rng(0)
    small = ("xy", "xz", "yz")
    values = {
        name: rng.uniform(0.5, 1.0) * (0.1 if name.endswith(small) else 1) for name in model.missing
    }
    equations = fb.equations(model.bind(**values))
    q, qd = rng.uniform(-1, 1, (2, model.nv))
    mine = [equations.evaluate(x, q, qd) for x in (equations.M, equations.c, equations.g)]
    names = dynamicsymbols(f"q1:{model.nv + 1}")
    known = {x.diff(dynamicsymbols._t): value for x, value in zip(names, qd, strict=True)}
    known |= dict(zip(names, q, strict=True))
    known |= {sympy.Symbol(name): value for name, value in equations.parameters.items()}
    numbers = [np.array(x.xreplace(known).evalf(), dtype=float) for x in (M, forcing)]
    expected = [mine[0], -(mine[1] + mine[2])[:, None]]
    pairs = zip(numbers, expected, strict=True)
    return max(float(np.abs(a - b).max()) for a, b in pairs) / max(
        float(np.abs(b).max()) for b in expected
    )


def round_cos(alpha: float) -> tuple[int, int]:
    """Cosine and sine of a multiple of a right angle."""
    return round(float(sympy.cos(alpha))), round(float(sympy.sin(alpha)))


if __name__ == "__main__":
    main()
