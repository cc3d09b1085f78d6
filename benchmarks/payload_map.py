"""The largest payload at a million random postures of a UR5e, beside the same by static torques.

    python benchmarks/payload_map.py [--postures 1000000]

Seconds of `fb.payload_map`, and of `fb.static_torque` of the arm without and with a kilogram, of
which the same follows; in turns within one run, the quickest of some rounds.
"""

import argparse
from collections.abc import Callable

import freebody as fb
from common import quickest

ROUNDS = 5


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--postures", type=int, default=1_000_000)
    arm = fb.load("ur5e")
    q, _, _ = fb.random_state(arm, 0, parser.parse_args().postures)
    loaded = arm.with_payload(mass=1.0)

    def by_torques() -> None:
        fb.static_torque(arm, q)
        fb.static_torque(loaded, q)

    runs: dict[str, Callable[[], object]] = {
        "fb.payload_map": lambda: fb.payload_map(arm, q),
        "torques alone": by_torques,
    }
    for name, seconds in quickest(runs, ROUNDS).items():
        print(f"{name:16}{seconds:8.3f} s")


if __name__ == "__main__":
    main()
