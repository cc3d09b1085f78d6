"""What the tests of the compiler share."""

import pytest

from freebody.targets import settings


@pytest.fixture(autouse=True)
def optimised(own_structures: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Code as users have it, here and in processes that are started."""
    monkeypatch.setenv("FREEBODY_OPTIMISE", "2")
    monkeypatch.setattr(settings, "OPTIMISE", 2)
