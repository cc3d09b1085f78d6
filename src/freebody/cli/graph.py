"""The programs behind the numbers, for `freebody show --graph`: one after tracing, and one after
each pass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from freebody.model.model import Model


def programs(model: Model, quantity: str) -> Iterator[str]:
    """A heading and the listing for each stage of a quantity's program."""
    from freebody.any_chain.kernel_options import chosen_option
    from freebody.kernels.tracing import program
    from freebody.program.passes import PASSES

    names, option = chosen_option(model, quantity, function="freebody show --graph")
    stage = program(model, names, option)
    yield f"# traced: {stage}"
    yield stage.listing()
    for name, apply in PASSES.items():
        stage = apply(stage)
        yield f"\n# after {name!r}: {stage}"
        yield stage.listing()
