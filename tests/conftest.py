"""What every test file shares."""

import shutil

import pytest


def pytest_runtest_setup(item: pytest.Item) -> None:
    missing = [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]
    if missing and item.get_closest_marker("browser"):
        pytest.skip(f"needs {' and '.join(missing)} on the path")
