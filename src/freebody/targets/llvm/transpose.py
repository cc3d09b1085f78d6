"""LLVM text that transposes squares of registers, by two-operand shuffles that x86 has as one
instruction each.

First what lies in 128 bits is turned; then 128-bit parts are gathered.
"""

from __future__ import annotations

from collections.abc import Sequence

from freebody.targets.llvm.lanes import Real


def part_of(real: Real, width: int) -> int:
    """Numbers in 128 bits, or in a vector of `width` if that is shorter."""
    return min(128 // real.bits, width)


def shuffle(
    lines: list[str], name: str, x: str, y: str, size: int, picks: Sequence[int], real: Real
) -> str:
    """Entries of two vectors of `size`, of x and then of y."""
    v, mask = f"<{size} x {real.name}>", ", ".join(f"i32 {pick}" for pick in picks)
    lines.append(f"  %{name} = shufflevector {v} {x}, {v} {y}, <{len(picks)} x i32> <{mask}>")
    return f"%{name}"


def transpose(lines: list[str], tag: str, rows: list[str], width: int, real: Real) -> list[str]:
    """The columns of a square of `width` rows.

    Half as many vectors hold two rows of half the width each, side by side: k and k + p with p
    numbers in 128 bits, for every k without the bit p.
    """
    part, count = part_of(real, width), 0

    def halves(x: str, y: str, odd: int) -> str:
        nonlocal count
        count += 1
        return shuffle(lines, f"{tag}t{count}", x, y, width, gathered(width, part, odd), real)

    def gather(vectors: list[str]) -> list[str]:
        if len(vectors) == 1:
            return vectors
        pairs = list(zip(vectors[::2], vectors[1::2], strict=True))
        even, odd = (gather([halves(x, y, parity) for x, y in pairs]) for parity in (0, 1))
        return [name for both in zip(even, odd, strict=True) for name in both]

    turned = [
        turn_parts(lines, f"{tag}p{k}.", rows[k : k + part], part, width, real)
        for k in range(0, len(rows), part)
    ]
    columns = [gather([those[j] for those in turned]) for j in range(part)]
    return [name for several in zip(*columns, strict=True) for name in several]


def gathered(width: int, part: int, odd: int) -> list[int]:
    """The even (or odd) ones of the parts of two vectors."""
    return [part * p + e for p in range(odd, 2 * width // part, 2) for e in range(part)]


def turn_parts(
    lines: list[str], tag: str, rows: list[str], part: int, width: int, real: Real
) -> list[str]:
    """Transpose what lies in parts of 1, 2 or 4 numbers in so many rows or fewer: interleave
    neighbours, then pairs."""

    def interleaved(x: str, y: str, high: int, of: int) -> str:
        """Of each part the lower (or higher) half of x and y, `of` entries of one and of the other
        by turns."""
        picks = [
            start + high * part // 2 + k + side * width + e
            for start in range(0, width, part)
            for k in range(0, part // 2, of)
            for side in (0, 1)
            for e in range(of)
        ]
        return shuffle(lines, f"{tag}{len(lines)}", x, y, width, picks, real)

    if len(rows) == 1:
        return rows
    if len(rows) == 2:
        return [interleaved(rows[0], rows[1], high, 1) for high in (0, 1)]
    one, other = ([interleaved(rows[k], rows[k + 1], high, 1) for high in (0, 1)] for k in (0, 2))
    return [interleaved(x, y, high, 2) for x, y in zip(one, other, strict=True) for high in (0, 1)]
