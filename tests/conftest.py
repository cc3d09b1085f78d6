"""What every test file shares."""

import atexit
import gc
import os
import re
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from weakref import WeakValueDictionary

import pytest
from hypothesis import settings

import freebody as fb
from freebody.model import kept_facts, structure
from freebody.targets import settings as targets
from support import generate
from support.dying_workers import (  # noqa: F401 - hooks, which pytest finds here
    pytest_configure,
    pytest_configure_node,
    pytest_handlecrashitem,
)
from support.extras import extra
from support.sampled import pytest_collection_modifyitems  # noqa: F401 - a hook as well

# the same examples everywhere, however slow the machine is
settings.register_profile("freebody", deadline=None, derandomize=True, database=None)
settings.load_profile("freebody")

for threads in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    # workers inherit it: threads of theirs that wait for each other on the same cores cost minutes
    os.environ.setdefault(threads, "1")

# by Python's own thresholds a tenth of the time goes into looking for rubbish and finding none
gc.set_threshold(20_000, 20, 20)

# every worker, and each of some eighty processes that tests start, would compile all modules anew
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

if "FREEBODY_OPTIMISE" not in os.environ:
    # most of the suite's time is LLVM's, most of which is its work on the speed of code that is
    # called once; the compiler's own tests have it do all (tests/core/compiler/conftest.py)
    os.environ["FREEBODY_OPTIMISE"], targets.OPTIMISE = "0", 0

if "FREEBODY_CACHE" not in os.environ:
    # one folder for all workers of a run, which inherit it: the user's own cache is neither trusted
    # nor filled
    os.environ["FREEBODY_CACHE"] = tempfile.mkdtemp(prefix="freebody-tests-")
    atexit.register(shutil.rmtree, os.environ["FREEBODY_CACHE"], ignore_errors=True)


def pytest_collection_finish() -> None:
    """What is known before the first test, all tests and modules, stays: to look through it for
    rubbish again and again takes longer than some tests."""
    gc.collect()
    gc.freeze()


def pytest_runtest_setup(item: pytest.Item) -> None:
    if not item.get_closest_marker("browser"):
        return
    missing = [name for name in ("chromium", "chromedriver") if shutil.which(name) is None]
    if missing:
        pytest.skip(f"needs {' and '.join(missing)} on the path")
    extra("selenium", "Selenium")


@pytest.fixture(scope="session")
def page_of(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """The file with the page of a bundled robot's derivation, by the robot's name, a method and
    other options of `fb.derive`; whichever process of the run needs it first builds it. Not for
    tests with `numpy_kernels`, whose pages may differ in a last digit."""
    own = tmp_path_factory.getbasetemp()
    folder = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "derivations"
    folder.mkdir(exist_ok=True)

    def page_of(name: str, method: str | None = None, **options: Any) -> Path:
        words = re.sub(r"[^\w.-]+", "_", f"{name} {method} {options}")
        page = folder / f"{words}.html"
        if not page.exists():
            made = own / page.name
            text = fb.derive(fb.load(name), method, **options).html()
            made.write_text(text, encoding="utf-8")
            made.replace(page)
        return page

    return page_of


@pytest.fixture
def numpy_kernels(own_structures: None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Public functions compile nothing, for tests of mechanics on many mechanisms: compiling each
    is most of their time, and other tests compare what is compiled."""
    monkeypatch.setattr(targets, "TARGET", "numpy")
    monkeypatch.setattr(generate, "made", _uncompiled)


_uncompiled: dict[tuple[int, int], fb.Model] = {}
"""The random trees of all tests in which nothing is compiled."""


@pytest.fixture
def own_structures(monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing that is kept with a model's structure is shared with other tests."""
    monkeypatch.setattr(structure, "_structures", WeakValueDictionary())
    monkeypatch.setattr(kept_facts, "_known", WeakValueDictionary())
    monkeypatch.setattr(generate, "made", {})


@pytest.fixture
def memory_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each test compiles what it runs, for this machine's own target and width."""
    monkeypatch.setenv("FREEBODY_CACHE", "off")
    monkeypatch.setattr(targets, "TARGET", None)
    monkeypatch.setattr(targets, "WIDTH", None)
