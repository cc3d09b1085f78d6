"""How the text for LLVM is laid out changes no bit of a result, and its length keeps pace with the
program.

No option chooses the layout, so these tests patch the emitter.
"""

from __future__ import annotations

import re

import pytest

from freebody.program.segments import LONGEST, segment
from freebody.targets import kernel
from freebody.targets.llvm import emit
from support.programs import (
    assert_close,
    direct,
    random_kernel,
    same_bits,
    samples,
)

pytestmark = pytest.mark.usefixtures("memory_only")


def test_cutting_into_segments_changes_nothing(monkeypatch):
    arrays = samples(20)
    whole = random_kernel(3, 300)(*arrays)
    for longest in (1, 7, 50):
        monkeypatch.setattr(emit, "segment", lambda p, n=longest: segment(p, n))
        monkeypatch.setattr(kernel, "_kernels", {})
        assert_close(random_kernel(3, 300)(*arrays), whole)


def test_one_or_two_groups_a_round_give_the_same_bits(monkeypatch):
    kernels = []
    for tiles in (1, 2):
        monkeypatch.setattr(emit, "_tiles", lambda nodes, room, n=tiles: n)
        monkeypatch.setattr(kernel, "_kernels", {})
        kernels.append(random_kernel(8, width=4))
    for batch in (1, 3, 4, 5, 8, 9, 12, 15, 16, 17, 100):
        x, A, s = samples(batch)
        for arrays in [(x, A, s), (x[0], A, s), (x, A[:, :, ::-1], s[0])]:
            assert same_bits(*(k(*arrays) for k in kernels))
            assert_close(kernels[0](*arrays), direct(8, arrays))


def test_long_programs_run_their_pieces_in_groups(monkeypatch):
    """As a whole and in functions of a few pieces: the same bits."""
    arrays = samples(37, 17)
    whole = random_kernel(17, 4000).ufunc(*arrays)
    monkeypatch.setattr(emit, "PIECES", 3)
    monkeypatch.setattr(kernel, "_kernels", {})
    cut = random_kernel(17, 4000)
    assert "@compute1(" in cut.source
    assert same_bits(cut.ufunc(*arrays), whole)


def test_the_text_grows_with_the_program_and_its_functions_do_not():
    """LLVM takes more than twice as long for a function twice as long: so time stays in proportion
    to the program."""

    def lengths(length):
        compiled = random_kernel(11, length, target="cpu", width=8)
        functions = re.findall(r"^define .*?^}", compiled.source, flags=re.M | re.S)
        return [text.count("\n") for text in functions], sum(compiled.program.operations.values())

    (short, few), (long, many) = lengths(1500), lengths(12000)
    assert many > 4 * few
    assert sum(long) / many < 1.2 * sum(short) / few
    assert max(long + short) < 2 * LONGEST
