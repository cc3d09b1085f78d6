"""Ends before the end that keep what was computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

from freebody.errors import FreebodyError

if TYPE_CHECKING:
    import xarray as xr


class SimulationInterrupted(KeyboardInterrupt):
    """Ctrl-C during `simulate`; `result` is the dataset of what there was."""

    def __init__(self, result: xr.Dataset):
        last = float(result["time"].values[-1])
        super().__init__(
            f"simulate: interrupted; what was computed, up to t = {last:.6g} s, is the `result` of "
            f"this exception."
        )
        self.result = result


class SimulationStopped(FreebodyError):
    """A motion of `simulate` that cannot go on, or would not end; `result` is the dataset of what
    there was, up to the last of the times t that was reached."""

    result: xr.Dataset | None = None
