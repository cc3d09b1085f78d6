"""The modes of a UR5e with compliant joints at a million random postures, beside SciPy's `eigh`.

    python benchmarks/natural_frequencies.py [--postures 1000000]

Seconds on the clock and of the processor of `fb.natural_frequencies`, the quickest of some rounds,
and the largest relative difference of its ω² from those of `scipy.linalg.eigh` at a thousand of the
postures, by the mass matrix and the derivatives of `fb.inverse_dynamics`.
"""

import argparse
import time

import numpy as np
from scipy.linalg import eigh

import freebody as fb

ROUNDS = 3
SPRINGS = np.array([3e4, 3e4, 2e4, 8e3, 8e3, 8e3])  # N m/rad, invented


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--postures", type=int, default=1_000_000)
    arm = fb.load("ur5e")
    q, _, _ = fb.random_state(arm, 0, parser.parse_args().postures)
    fb.natural_frequencies(arm, q[:1], SPRINGS)
    clock, processor = [], []
    for _ in range(ROUNDS):
        start, used = time.perf_counter(), time.process_time()
        found = fb.natural_frequencies(arm, q, SPRINGS)
        clock.append(time.perf_counter() - start)
        processor.append(time.process_time() - used)
    print(f"fb.natural_frequencies  {min(clock):.3f} s, {min(processor):.3f} s of the processor")
    bare, rest, off = arm.without("rotors", "friction"), np.zeros(arm.nv), 0.0
    for at, squares in zip(q[:1000], found.squares, strict=False):
        K = np.diag(SPRINGS) + fb.inverse_dynamics_derivatives(bare, at, rest, rest)[0]
        theirs = np.asarray(eigh(K, fb.mass_matrix(bare, at), eigvals_only=True))
        off = max(off, float(np.abs(squares / theirs - 1.0).max()))
    print(f"largest difference      {off:.1e}")


if __name__ == "__main__":
    main()
