"""The largest payload of a UR5e along a thousand motions.

    python benchmarks/payload.py [--motions 1000]

Seconds on the clock and of the processor of `fb.payload` along so many quintic motions of 401
samples between random postures, which it has not seen before.
"""

import argparse
import time

import numpy as np

import freebody as fb


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--motions", type=int, default=1000)
    count = parser.parse_args().motions
    arm = fb.load("ur5e")
    q, _, _ = fb.random_state(arm, 1, (count, 2))
    motions = [fb.quintic(arm, ends, [0.0, 9.0]) for ends in q]
    fb.payload(arm, motions[0])
    start, used = time.perf_counter(), time.process_time()
    found = fb.payload(arm, motions)
    clock, processor = time.perf_counter() - start, time.process_time() - used
    print(f"{count} motions: {clock:.3f} s, {processor:.3f} s of the processor")
    print(f"payloads from {np.min(found.mass):.3g} to {np.max(found.mass):.3g} kg")


if __name__ == "__main__":
    main()
