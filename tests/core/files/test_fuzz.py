"""Every parser under wrong input: some cases of each always; with -m long ten thousand of each
format of robots, a minute of the others. See tests/support/fuzz.py."""

import time
from pathlib import Path

import pytest

import freebody as fb
from support import fuzz
from support.extras import extra

pytestmark = pytest.mark.skipif(not hasattr(__import__("signal"), "SIGPROF"), reason="no CPU timer")


def told(wrong: list[tuple[str, bytes]]) -> str:
    return "\n".join(f"{problem}: {data[:300]!r}" for problem, data in wrong[:5])


def some(kind: str, seed: int, most: int) -> None:
    """Check that so many cases are right."""
    if kind == "mjcf":
        extra("mujoco", name="mjcf")
    count, wrong = fuzz.run(kind, seed, lambda n: n < most)
    assert count == most
    assert not wrong, told(wrong)


@pytest.mark.sample(2)
@pytest.mark.parametrize("kind", fuzz.KINDS)
def test_the_corpus_and_some_wrong_cases(kind: str):
    some(kind, 1, 100 if kind in fuzz.ROBOTS else 40)


@pytest.mark.long
@pytest.mark.parametrize("kind", fuzz.ROBOTS)
def test_ten_thousand_wrong_cases_of_a_format(kind: str):
    some(kind, 3, 10_000)


@pytest.mark.long
@pytest.mark.parametrize("kind", [kind for kind in fuzz.KINDS if kind not in fuzz.ROBOTS])
def test_a_minute_of_wrong_cases(kind: str):
    end = time.monotonic() + 60.0
    count, wrong = fuzz.run(kind, 2, lambda n: time.monotonic() < end)
    print(f"{kind}: {count} cases")
    assert count > 500
    assert not wrong, told(wrong)


def test_cases_are_the_same_for_the_same_seed():
    first, again = (fuzz.cases("toml", 3) for _ in range(2))
    assert [next(first) for _ in range(50)] == [next(again) for _ in range(50)]


# ---------------------------------------------------------------- the watch itself
def _hangs(path: Path, data: bytes) -> None:
    while True:
        pass


def _writes(path: Path, data: bytes) -> None:
    path.with_name("other.txt").write_text("x")


def _raises(path: Path, data: bytes) -> None:
    raise ValueError("foreign")


def _talks(path: Path, data: bytes) -> None:
    raise fb.FreebodyError("x" * 6000)


@pytest.mark.parametrize(
    ("read", "problem"),
    [
        (_hangs, "more than"),
        (_writes, "touched"),
        (_raises, "ValueError in"),
        (_talks, "an error of 6000"),
    ],
)
def test_what_is_wrong_is_seen(tmp_path, monkeypatch, read, problem: str):
    monkeypatch.setattr(fuzz, "SECONDS", 0.1)
    assert (fuzz.fault("word", b"x", tmp_path / "a.txt", read) or "").startswith(problem)


@pytest.mark.sample(2)
@pytest.mark.filterwarnings("ignore::freebody.errors.FreebodyWarning")
@pytest.mark.parametrize("kind", [*fuzz.ROBOTS, "motion", "check", "word"])
def test_some_cases_are_right_and_most_are_not(kind: str, tmp_path):
    """Neither are all refused at the door, nor is what the changes make still right."""
    if kind == "mjcf":
        extra("mujoco", name="mjcf")
    suffix, read = fuzz.readers()[kind]
    path, taken = tmp_path / f"a{suffix}", 0
    for data, _ in zip(fuzz.cases(kind, 4), range(40), strict=False):
        path.write_bytes(data)
        try:
            read(path, data)
            taken += 1
        except fb.FreebodyError:
            pass
    assert 1 <= taken <= 36
