"""What stands behind the name of a matrix: J⁻¹, R_1^2."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.lexer import Token


def power_behind(tokens: Sequence[Token], power: int) -> int:
    """How many tokens are the power with which they begin: ⁻¹, ^-1, ^{-1}; 0 if it is another."""
    if tokens and tokens[0].kind == "power":
        return int(tokens[0].value == power)
    texts, figures = [token.text for token in tokens], [*"-" * (power < 0), str(abs(power))]
    for written in (["^", *figures], ["^", "{", *figures, "}"], ["^", "(", *figures, ")"]):
        if texts[: len(written)] == written:
            return len(written)
    return 0


def turn_behind(name: str, tokens: Sequence[Token]) -> tuple[str, int]:
    """Of R_1 and ² or ^2 behind it the name of R_1^2, which turns components from body 1 to body 2,
    and how many tokens stand behind; of anything else "" and 0."""
    if atom(name).letter != "R" or not atom(name).is_numbered or not tokens:
        return "", 0
    if tokens[0].kind == "power":
        return f"R{tokens[0].value}{name[1:]}", 1
    braced = [token.text for token in tokens[1:2]] == ["{"]
    end = 2 + 2 * braced
    if tokens[0].text != "^" or len(tokens) < end or tokens[1 + braced].kind != "number":
        return "", 0
    return f"R{tokens[1 + braced].text}{name[1:]}", end
