"""Ambiguous symbols: an answer that is correct under one of their readings is accepted."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.lexer import numbers
from freebody.expressions.grammar.words import spelt
from freebody.expressions.nodes import Expression, Negative, Number, Sum
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody_textbook.check.algebra.finite_field import Workspace
from freebody_textbook.check.algebra.quotients import Named, Wave
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reading.claim import Claim

GRAVITY = ("9.8", "9.81", "9.807", "9.80665", "10")


@dataclass(frozen=True)
class Misreading:
    """Another meaning of some nodes, with the sentences about it for wrong answers and for answers
    that it makes correct."""

    new: dict[Expression, Expression]
    text: str
    note: str
    is_doubtful: bool = True
    """Whether to say so also where it does not make the answer right."""
    target: AskedQuantity | None = None
    """Another quantity that the answer is then about."""


def angle_of_cosine(setting: RightEquations, name: str, target: AskedQuantity) -> tuple[str, ...]:
    """The angles whose cosine a quantity's name may also mean, as C12; empty if there are none."""
    own = atom(name)
    angles = tuple(f"theta{k}" for k in own.figures)
    meant = own.letter in target.kind.letters_of_cosines
    return angles if meant and all(x in setting.ring.angles for x in angles) else ()


def slide_meant(setting: RightEquations, name: str, target: AskedQuantity) -> str:
    """The coordinate or rate of the only slide that a quantity's name may also mean, such as x of a
    cart; "" otherwise."""
    own = atom(name)
    slides = [x for x in setting.symbols.coordinates if not setting.turns(x)]
    if len(slides) != 1 or own.index or own.letter not in target.kind.letters_of_slides:
        return ""
    return slides[0] + ("", RATE, SECOND)[target.kind.dots]


def readings(
    setting: RightEquations, targets: Targets, claim: Claim, work: Workspace
) -> Iterator[Misreading]:
    """Alternative readings of a claim's symbols, most likely first."""
    yield from _links(setting, targets, claim, work)
    yield from _velocity_terms(targets, claim, work)
    yield from _coefficients(setting, targets, claim, work)
    yield from _cosines(setting, targets, claim, work)
    yield from _slides(setting, targets, work)
    yield from _numbers(setting, claim, work)


def doubt_about(setting: RightEquations, targets: Targets, claim: Claim, work: Workspace) -> str:
    """A sentence on a symbol of a wrong answer that may have another meaning; "" if there is
    none."""
    found = readings(setting, targets, claim, work)
    return next((reading.text for reading in found if reading.is_doubtful), "")


def _links(
    setting: RightEquations, targets: Targets, claim: Claim, work: Workspace
) -> Iterator[Misreading]:
    """Alternative reading: body numbers as link numbers of the robot's file, which has no bodies
    between the axes of a joint with several coordinates."""
    symbols = setting.equations.symbols
    order = [body.name for body in symbols.model.bodies]
    own = (symbols.given or symbols.model).bodies
    numbers = {str(k): str(order.index(x.name) + 1) for k, x in enumerate(own, 1)}
    if all(k == n for k, n in numbers.items()):
        return

    def of_link(target: AskedQuantity | None, name: str) -> AskedQuantity | None:
        number = atom(name).figures
        if target is None or not target.kind.of_one_body or number not in numbers:
            return None
        return targets.single.get(name.replace(number, numbers[number]))

    what = _kind(claim.target)
    name = next((x for x, target in targets.single.items() if _kind(target) == what), "")
    found = _of_links(targets, work, of_link)
    if found is None:
        return
    target = of_link(claim.target, name)
    if target is None and claim.target.kind.of_one_body:
        return
    if target is not None:
        words = f"{claim.target.title}, counted as the links of the robot's file"
        target = replace(target, words=words)
    if found or target is not None:
        text = "Bodies are counted as the links of the robot's file."
        yield Misreading(found, text, text, False, target)


def _of_links(
    targets: Targets,
    work: Workspace,
    of_link: Callable[[AskedQuantity | None, str], AskedQuantity | None],
) -> dict[Expression, Expression] | None:
    """For an answer's quantities of bodies, the values of the links with the same numbers; None if
    a number is not that of a link."""
    found: dict[Expression, Expression] = {}
    for node in work.values:
        own_target = targets.single.get(node.name) if isinstance(node, Named) else None
        if isinstance(node, Named) and own_target and own_target.kind.of_one_body:
            new = of_link(own_target, node.name)
            if new is None:
                return None
            found[node] = replace(node, value=new.compute())
    return found


def _kind(target: AskedQuantity) -> tuple[object, ...]:
    """Key of a quantity by kind, indices, axis and words."""
    return target.kind, target.index, target.axis, target.words


def _named_velocity_terms(targets: Targets) -> tuple[dict[str, str], set[str]]:
    """(preferred name of each joint's velocity term, the names that may also be cosines)."""
    terms: dict[str, str] = {}
    own = {name: x for name, x in targets.single.items() if x.kind.is_velocity_term}

    def place(name: str) -> tuple[bool, bool, str]:
        kind, letter = own[name].kind, atom(name).letter
        return letter == kind.letters[0], letter != kind.usual, name

    for name in sorted(own, key=place):
        terms.setdefault(str(own[name].index[0]), name)
    return terms, {x.kind.letters[0] for x in own.values()}


def _velocity_terms(targets: Targets, claim: Claim, work: Workspace) -> Iterator[Misreading]:
    """Alternative reading: c1 or V1 as a term beside torques may be cos θ1 or an energy instead of
    a velocity term."""
    if not claim.target.kind.has_velocity_terms:
        return
    terms, letters = _named_velocity_terms(targets)
    found: dict[Expression, Expression] = {}
    for node in work.values:
        wave = atom(spelt(claim.source[node.span]))
        own = targets.single.get(node.name) if isinstance(node, Named) else None
        k = wave.figures if wave.letter in letters and isinstance(node, Wave) else ""
        k = str(own.index[0]) if own is not None and own.index and own.kind.up_to_a_constant else k
        if k in terms and isinstance(work.parents.get(node), Sum | Negative):
            name = terms[k]
            found[node] = Named(name, targets.single[name].compute(), span=node.span)
    if found:
        written, new = claim.source[next(iter(found)).span], next(iter(found.values()))
        assert isinstance(new, Named)
        said = "the velocity term may be meant"
        if atom(new.name).letter not in letters:
            said = f"write {new.name} for the velocity term"
        read = "a potential energy" if isinstance(next(iter(found)), Named) else "a cosine"
        text = f"‘{written}’ on the right is read as {read}; {said}."
        yield Misreading(found, text, f"‘{written}’ is read as the velocity term.")


def _coefficients(
    setting: RightEquations, targets: Targets, claim: Claim, work: Workspace
) -> Iterator[Misreading]:
    """Alternative reading: h3 as a term beside torques may be the velocity term of joint 3 instead
    of a coefficient of the closed form."""
    if not claim.target.kind.has_velocity_terms:
        return
    written = [x for x in work.values if isinstance(x, Named) and atom(x.name).letter == "h"]
    coefficients = replace(targets, velocity=True).single if written else {}
    terms, _ = _named_velocity_terms(targets)
    found: dict[Expression, Expression] = {}
    for node in written:
        own, name = coefficients.get(node.name), terms.get(atom(node.name).figures)
        is_meant = own is not None and own.kind.is_coefficient and own.compute() == node.value
        if is_meant and name and isinstance(work.parents.get(node), Sum | Negative):
            found[node] = Named(name, targets.single[name].compute(), span=node.span)
    if found:
        node, new = next(iter(found.items()))
        assert isinstance(node, Named)
        assert isinstance(new, Named)
        shown, meant = claim.source[node.span], setting.form(node.value)
        text = (
            f"‘{shown}’ on the right is read as the coefficient {meant}; write {new.name} for the "
            f"velocity term."
        )
        yield Misreading(found, text, f"‘{shown}’ is read as the velocity term.")


def _cosines(
    setting: RightEquations, targets: Targets, claim: Claim, work: Workspace
) -> Iterator[Misreading]:
    """Alternative reading: C2 or C12 on the right side may be a cosine instead of a quantity of
    dynamics."""
    found: dict[Expression, Expression] = {}
    for node in work.values:
        if not isinstance(node, Named) or node.name not in targets.single:
            continue
        if not any(c.isdigit() for c in claim.source[node.span]):  # of the matrix C
            continue
        angles = angle_of_cosine(setting, node.name, targets.single[node.name])
        if angles:
            found[node] = Wave("cos", tuple((x, 1) for x in angles), span=node.span)
    if found:
        node = next(iter(found))
        assert isinstance(node, Named)
        written, letter = claim.source[node.span], atom(node.name).letter
        right = written.replace(letter, letter.lower(), 1)
        title = targets.single[node.name].title
        text = f"‘{written}’ on the right is read as {title}; write {right} for the cosine."
        yield Misreading(found, text, f"‘{written}’ is read as a cosine.")


def _slides(setting: RightEquations, targets: Targets, work: Workspace) -> Iterator[Misreading]:
    """Alternative reading: x may be a cart's coordinate instead of the tip's."""
    found: dict[Expression, Expression] = {}
    for node in work.values:
        target = targets.single.get(node.name) if isinstance(node, Named) else None
        if target is None or not isinstance(node, Named):
            continue
        name = slide_meant(setting, node.name, target)
        if name:
            found[node] = Named(name, setting.ring[name], span=node.span)
    if found:
        (slide,) = (x for x in setting.symbols.coordinates if not setting.turns(x))
        node = next(iter(found))
        assert isinstance(node, Named)
        x = atom(node.name).letter
        text = (
            f"{x} is read as the tip's coordinate; for the slide write {slide}, "
            f"or say names={{'{x}': '{slide}'}}."
        )
        yield Misreading(found, text, f"{x} is read as the slide's coordinate {slide}.")


def is_value(value: float, written: str) -> bool:
    """Whether a decimal number equals a value to the written digits."""
    ((_, figures),) = numbers(Lexemes.of(written))
    return figures.decimals > 0 and round(value, figures.decimals) == float(written)


def _numbers(setting: RightEquations, claim: Claim, work: Workspace) -> Iterator[Misreading]:
    """Alternative reading: a number such as 9.81 as g, if that is its value."""
    g = setting.order.gravity
    value = setting.symbols.model.parameters.get(g or "")
    found: dict[Expression, Expression] = {}
    for node in work.values:
        written = claim.source[node.span]
        if g and isinstance(node, Number) and written in GRAVITY:
            found[node] = Named(g, setting.ring[g], span=node.span)
    if not found:
        return
    written = claim.source[next(iter(found)).span]
    text = f"‘{written}’ must be the symbol {g}: its value is not known here."
    if value is None:
        yield Misreading({}, text, "")
    elif is_value(value, written):
        yield Misreading(found, text, f"‘{written}’ is read as {g}.", False)


_TOLD = re.compile(
    r"(?:^|[.;]\s)\W*([^=:;]*"
    r"(?:\b(?:small|near|close to|neglect|ignor|without|horizontal|vertical|upright|hanging|"
    r"stretched|lineari|approximat|limit|first order)|[<>≈≪≫→])"
    r"[^=:;]*)[:,][^:;]*=",
    re.IGNORECASE,
)
"""Words in front of an equation, up to its sign of equality, that may be a condition."""


def unread_condition(claim: Claim) -> list[str]:
    """A sentence on words before a claim that may be a condition; empty if there are none."""
    at, text = claim.node.span[0], claim.source.shown
    begun = text.rfind("\n", 0, at) + 1
    found = _TOLD.search(text[begun:at])
    if found is None:
        return []
    words = claim.source[begun + found.start(1), begun + found.end(1)]
    return [f"‘{words}’ in front of it is not read as a condition: it is compared without it."]
