"""Right lines and mutants as text: alone, with names of one's own, in documents, at a state."""

import math
import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import sympy as sp

from .claims import (
    Claim,
    _claim,
    by_mechanics,
    derived,
    family_of,
    holds,
    solved_rates,
    with_definitions,
    wrong,
)
from .mistakes import mistaken
from .number_lines import LARGE, number_lines
from .printed import printed
from .prose import PROSE_LATEX, PROSE_MARKDOWN, PROSE_TEXT
from .robots import ROBOTS, mechanism
from .spellings import Spelling, spelling, written
from .trees import keys, two_valued
from .typed import typed


@dataclass(frozen=True)
class Line:
    """What is checked: an answer about a robot, with the options of `fb.check`."""

    robot: str
    family: str
    text: Any
    options: dict[str, Any] = field(default_factory=dict)
    kind: str = ""  # of the mistake
    source: Any = field(default=None, repr=False)  # the claim and how it is set, for mutants

    def __str__(self) -> str:
        told = "".join(f", {x}={y!r}" for x, y in self.options.items())
        return f"{self.robot}: {self.text!r}{told}"


@dataclass(frozen=True)
class Setting:
    """How a claim is set: the habits, the frame around it."""

    spelling: Spelling
    frame: int
    seed: int


ENDS = ("", "", "", "", ".", ",", ";")
WRAPS = (
    "{}",
    "{}",
    "{}",
    "${}$",
    "$${}$$",
    r"\[ {} \]",
    r"\( {} \)",
    r"\begin{{equation}} {} \end{{equation}}",
    r"\begin{{align}} {} \end{{align}}",
)


def text_of(one: Claim, s: Spelling) -> list[str]:
    """The claim's lines."""
    found = [f"{name} = {written(meant, s)}" for name, meant in one.defined]
    left = written(one.left, s)
    if one.left[0] == "mat":
        left = {"H": "M", "J": "J"}[one.left[1][0][0][1][0]]
    return [*found, f"{left} = {written(one.right, s)}"]


def set_line(one: Claim, how: Setting) -> Line:
    """The claim as text, in a setting."""
    s = how.spelling
    rng = random.Random(how.seed)
    if how.frame == OBJECT:
        return Line(one.robot, one.family, in_sympy(one, rng), source=(one, how))
    lines = text_of(one, s)
    options: dict[str, Any] = {}
    if s.own:
        options["names"] = s.names()
    prose = {1: ("markdown", PROSE_MARKDOWN), 2: ("latex", PROSE_LATEX), 3: ("text", PROSE_TEXT)}
    text = "\n".join(lines)
    if how.frame and (s.tex or how.frame == 3) and not one.defined:
        form, frames = prose[how.frame]
        text = rng.choice(frames).format(text)
        options["form"] = form
    elif s.tex and not one.defined:
        text = rng.choice(WRAPS).format(text + rng.choice(ENDS))
    elif rng.random() < 0.1 and not s.tex:
        text += rng.choice(("  # eq. 4", ";", "."))
    return Line(one.robot, one.family, text, options, source=(one, how))


def in_sympy(one: Claim, rng: random.Random) -> Any:
    """The claim as an equation in SymPy, or as an entry of a dict."""
    s = spelling(rng, rng.choice(("code", "function")))
    s = replace(s, letters=s.letters | PLAIN, rate=("{}_d", "{}_dd"), argument=False, half="1/2")
    right = sp.sympify(written(one.right, s))
    left = written(one.left, s)
    if left.isidentifier() and rng.random() < 0.5:
        return {left: right}
    return sp.Eq(
        sp.Symbol(left) if left.isidentifier() else sp.sympify(left), right, evaluate=False
    )


OWN = {
    "l": ("L#", "a#", "b#"),
    "lc": ("r#", "s#", "lg#", "k#"),
    "m": ("M#", "mu#"),
    "I": ("Iz#", "Jc#"),
    "th": ("phi#", "alpha#", "psi#", "vartheta#"),
    "d": ("rho#", "s#"),
}


def with_own_names(s: Spelling, one: Claim, rng: random.Random) -> Spelling:
    """The habits with one or two letters of one's own."""
    used = sorted(keys(one.right) | keys(one.left))
    plain = [x for x in used if x.rstrip("0123456789") in OWN and x[-1].isdigit()]
    if not plain:
        return s
    own = {}
    for key in rng.sample(plain, min(len(plain), rng.choice((1, 2)))):
        letter = key.rstrip("0123456789")
        new = rng.choice(OWN[letter]).replace("#", key[len(letter) :])
        if new not in own.values() and new not in used:
            own[key] = new
    return replace(
        s,
        own=own,
        form="code" if s.form not in ("plain", "code") else s.form,
        letters=spelling(rng, "plain").letters,
        short=False,
        functions={x: x for x in s.functions},
        argument=False,
    )


OBJECT = 4  # neither text nor a document: SymPy's objects
PLAIN = {
    "th": "theta#",
    "d": "d#",
    "H": "H#",
    "tau": "tau#",
    "G": "G#",
    "c": "c#",
    "T": "T",
    "V": "V",
}


def plain_names(one: Claim) -> bool:
    """Whether all names are letters and digits, which SymPy has as symbols."""
    used = keys(one.left) | keys(one.right)
    if any(x.endswith("_d") and x[0] in "TVEH" for x in used):
        return False
    return one.left[0] != "mat" and all(x.rstrip("0123456789_d")[:3] in PLAIN_KEYS for x in used)


PLAIN_KEYS = ("th", "", "l", "lc", "m", "I", "tau", "H", "G", "c", "T", "V", "L", "g", "J")


def setting(one: Claim, rng: random.Random) -> Setting:
    """A setting, drawn."""
    s = spelling(rng, "plain" if one.defined and rng.random() < 0.5 else None)
    if not one.defined and rng.random() < 0.1:
        s = with_own_names(s, one, rng)
    s = replace(s, coordinates=mechanism(one.robot).coordinates)
    drawn = rng.random()
    symbolic = not one.defined and not s.own and not two_valued(one.right) and plain_names(one)
    if symbolic and rng.random() < 0.06:
        return Setting(s, OBJECT, rng.randrange(10**9))
    frame = 1 if drawn < 0.12 else 2 if drawn < 0.2 else 3 if drawn < 0.24 else 0
    return Setting(s, frame, rng.randrange(10**9))


def claims(robot: str, rng: random.Random) -> list[Claim]:
    """The robot's right claims: printed ones, those by mechanics, and each quantity rewritten."""
    found = [_claim(robot, _family(x), x) for x in printed(robot)]
    found += by_mechanics(robot)
    found += derived(robot, rng)
    found += solved_rates(robot, rng)
    good, seen = [], set()
    for one in found:
        if (one.left, one.right) in seen or one.left == one.right:
            continue
        seen.add((one.left, one.right))
        if holds(one):
            good.append(one)
    return good


def _family(text: str) -> str:
    left = text.partition(" = ")[0]
    if text.startswith("[["):
        return "whole matrix"
    if any(x in text for x in ("acos", "atan", "asin", "sqrt")):
        return "inverse position"
    if left.endswith("_dd") and left.startswith(("th", "d", "x")):
        return "acceleration solved for"
    if ("_d" in text and "T_d" in text) or left == "E_d":
        return "power"
    if not left.isidentifier():
        return "relation"
    return family_of(left) or "relation"


SHARES = {
    "2R": 3,
    "3R": 2,
    "four_bar": 4,
    "slider_crank": 4,
    "five_bar": 3,
    "five_bar_rods": 2,
    "double_four_bar": 1.5,
    "3RRR": 1,
    "gyro": 0.4,
    "pendulum": 0.8,
}


def right_lines(count: int, seed: int = 28) -> list[Line]:
    """Right lines of all robots, drawn."""
    return of_these((*ROBOTS, *LARGE, "quadrotor", "bricard"), count, seed)


def of_these(robots: Sequence[str], count: int, seed: int = 28) -> list[Line]:
    """Right lines of some robots, drawn; the closed chains of books come more often."""
    rng = random.Random(seed)
    total = sum(SHARES.get(x, 1) for x in robots)
    found: list[Line] = []
    for robot in robots:
        found += of_robot(robot, math.ceil(count * SHARES.get(robot, 1) / total), rng)
    while len(found) < count:
        found += of_robot(rng.choice([x for x in robots if x in ROBOTS]), 20, rng)
    rng.shuffle(found)
    return found[:count]


def _numbers(robot: str, rng: random.Random, count: int) -> Iterator[Line]:
    for text, options in number_lines(robot, rng, count):
        yield Line(robot, "numbers", text, options)


def of_robot(robot: str, count: int, rng: random.Random) -> list[Line]:
    """Right lines of one robot: families in turn, so that small ones come too."""
    numbers = list(_numbers(robot, rng, count if robot in LARGE else max(1, count // 12)))
    families: dict[str, list[Claim]] = {}
    if robot not in ROBOTS:
        return (numbers + [Line(robot, x.family, x.answer, x.options) for x in typed(robot)])[
            :count
        ]
    for one in claims(robot, rng):
        families.setdefault(one.family, []).append(one)
    for own in families.values():
        rng.shuffle(own)
    found = numbers[: max(1, count // 12)]
    own = [Line(robot, x.family, x.answer, x.options) for x in typed(robot)]
    found += rng.sample(own, min(len(own), max(1, count // 5)))
    taken = dict.fromkeys(families, 0)
    while len(found) < count:
        family = rng.choice(sorted(families))
        own = families[family]
        one = own[taken[family] % len(own)]
        taken[family] += 1
        if rng.random() < 0.06:
            named_ = with_definitions(one, rng)
            one = named_ if named_ and holds(named_) else one
        found.append(set_line(one, setting(one, rng)))
    return found


def mutants(lines: Sequence[Line], count: int, seed: int = 82) -> Iterator[Line]:
    """Lines with one mistake, each wrong for certain, in the setting of its right line."""
    rng = random.Random(seed)
    sources = [x for x in lines if x.source]
    made, tries = 0, 0
    while made < count and tries < 20 * count:
        one, how = sources[tries % len(sources)].source
        tries += 1
        edit = mistaken(one.right, one.robot, rng)
        if edit is None:
            continue
        kind, right = edit
        changed = replace(one, right=right)
        if right == one.right or not wrong(changed):
            continue
        made += 1
        yield replace(set_line(changed, how), kind=kind)
