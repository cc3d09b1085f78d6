"""An interrupt that keeps what was computed."""

from __future__ import annotations

from typing import TYPE_CHECKING

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
