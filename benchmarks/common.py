"""What several scripts share: times of calls, the processor, and the folder of robots."""

import platform
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path


def seconds(
    run: Callable[[], object], times: int = 1, clock: Callable[[], float] = time.process_time
) -> float:
    """Of one call, the mean of `times`: CPU time of all threads, or by another clock."""
    start = clock()
    for _ in range(times):
        run()
    return (clock() - start) / times


def quickest(
    runs: Mapping[str, Callable[[], object]], rounds: int, times: int = 1, warm: bool = False
) -> dict[str, float]:
    """Seconds of a call of each by the clock on the wall, the mean of `times` in the quickest of
    rounds in which all take turns, so that what else the machine does counts little.

    warm: each is called once more before, so that its arrays are in the caches.
    """
    least = dict.fromkeys(runs, float("inf"))
    for _ in range(rounds):
        for name, run in runs.items():
            if warm:
                run()
            least[name] = min(least[name], seconds(run, times, time.perf_counter))
    return least


def processor() -> str:
    """Its name, where the system tells."""
    info = Path("/proc/cpuinfo")
    lines = info.read_text(encoding="utf-8").splitlines() if info.exists() else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def robots_folder() -> Path:
    """Of the package example-robot-data."""
    for entry in sys.path:
        folder = Path(entry) / "cmeel.prefix/share/example-robot-data/robots"
        if folder.is_dir():
            return folder
    raise SystemExit(
        "The robots come from the package example-robot-data: pip install -e '.[bench]'"
    )
