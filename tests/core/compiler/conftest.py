"""What the tests of the compiler share."""

import pytest

from freebody.targets import settings


@pytest.fixture(autouse=True)
def optimised(
    request: pytest.FixtureRequest, own_structures: None, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Code as users have it, here and in processes that are started; a test may be given another
    effort of LLVM's."""
    effort = getattr(request, "param", 2)
    monkeypatch.setenv("FREEBODY_OPTIMISE", str(effort))
    monkeypatch.setattr(settings, "OPTIMISE", effort)
