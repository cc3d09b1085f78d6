"""Right results: those that books print, and those that follow by mechanics and by identities."""

import functools
import random
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import sympy as sp

from .mechanisms import Mechanism, S
from .robots import mechanism
from .trees import INVERSE, Tree, from_sympy, keys, places, size, tree, two_valued, value

STATES = 10
TOLERANCE = 1e-8


@dataclass(frozen=True)
class Claim:
    """left = right about a robot; defined: lines before it, a name of one's own and its value."""

    robot: str
    family: str
    left: Tree
    right: Tree
    defined: tuple[tuple[str, Tree], ...] = ()


@functools.cache
def environment(robot: str) -> dict[str, np.ndarray]:
    """All quantities of the robot at random admissible states."""
    return mechanism(robot).states(STATES)


def gap(one: Claim, env: dict[str, np.ndarray], others: tuple[int, ...] = ()) -> np.ndarray:
    """How far the sides are apart at each state, relative to the size of what is compared."""
    second = iter((*others, *([0] * 20)))
    left = np.asarray(value(one.left, env, second))
    right = np.asarray(value(one.right, env, second))
    apart = left - right
    if any(x[0] == "fun" and x[1] in INVERSE for y in (one.left, one.right) for _, x in places(y)):
        apart = (apart + np.pi) % (2 * np.pi) - np.pi
    scale = np.maximum(terms(one.left, env), terms(one.right, env)) + 1e-4
    return np.abs(apart) / scale


def terms(one: Tree, env: dict[str, np.ndarray]) -> Any:
    """The sum of the magnitudes of the outermost terms."""
    parts = one[1] if one[0] == "add" else (one,)
    return sum(np.abs(value(x, env)) for x in parts)


def extended(one: Claim) -> dict[str, np.ndarray]:
    """The environment with the names that the claim's own lines define."""
    env = dict(environment(one.robot))
    for name, meant in one.defined:
        env[name] = np.asarray(value(meant, env)) * env["one"]
    return env


def holds(one: Claim) -> bool:
    """Whether the claim is right at all states: as it stands, in open chains on a branch of its
    inverse functions."""
    env = extended(one)
    count = two_valued(one.left) + two_valued(one.right)
    branched = count and not mechanism(one.robot).loops
    with np.errstate(all="ignore"):
        choices = range(2**count if branched else 1)
        gaps = [gap(one, env, tuple(c >> i & 1 for i in range(count))) for c in choices]
        return bool((np.nan_to_num(np.min(gaps, axis=0), nan=9.0) < TOLERANCE).all())


def wrong(one: Claim) -> bool:
    """Whether the claim is wrong for certain: at most states far apart on every branch of its
    functions, and not by a constant where energies may have one."""
    env = extended(one)
    count = two_valued(one.left) + two_valued(one.right)
    if count > 4:
        return False
    with np.errstate(all="ignore"):
        gaps = []
        for choice in range(2**count):
            others = tuple(choice >> i & 1 for i in range(count))
            gaps.append(np.nan_to_num(gap(one, env, others), nan=9.0))
        best = np.min(gaps, axis=0)
        if (best > 1e-4).sum() < 0.6 * best.size:
            return False
    parameters = set(mechanism(one.robot).values) - {"g"}
    if not keys(one.right) & parameters and _in_numbers(one):
        return False
    if not (keys(one.left) | keys(one.right)) & {"V", "E", "L", *(f"V{i}" for i in range(1, 7))}:
        return True
    return not _constant(one)


def _in_numbers(one: Claim) -> bool:
    """Whether a line without letters of lengths and masses is right with the values of the file."""
    env = mechanism(one.robot).states(STATES, seed=6, spread=0.0)
    if one.defined or two_valued(one.right):
        return False
    with np.errstate(all="ignore"):
        return bool((gap(one, env) < 1e-4).all())


def _constant(one: Claim) -> bool:
    """Whether the sides differ by a number of the parameters only, which a potential energy may."""
    m = mechanism(one.robot)
    same = m.states(STATES, seed=5, spread=0.0)
    for name, meant in one.defined:
        same[name] = np.asarray(value(meant, same)) * same["one"]
    with np.errstate(all="ignore"):
        apart = np.asarray(value(one.left, same)) - np.asarray(value(one.right, same))
    return bool(np.ptp(apart) < 1e-9 * (1 + np.abs(apart).max()))


def _claim(robot: str, family: str, text: str) -> Claim:
    left, _, right = text.partition(" = ")
    return Claim(robot, family, tree(left), tree(right))


def by_mechanics(robot: str) -> Iterator[Claim]:
    """What holds between quantities of every mechanism."""
    m = mechanism(robot)
    if not m.tidied:
        return
    n, q = len(m.coordinates), m.coordinates
    span = range(1, n + 1)
    known = m.quantities

    def there(i: int, j: int) -> bool:
        return known[f"H{i}{j}"] != 0

    def claim(family: str, text: str) -> Claim:
        return _claim(robot, family, text)

    def driven(i: int) -> str:
        return "0" if q[i - 1] in m.passive else f"tau{i}"

    def multipliers(i: int) -> str:
        return "".join(
            f" + ({known[f'Phi{k}q{i}']})*lam{k}"
            for k in range(1, len(m.loops) + 1)
            if known[f"Phi{k}q{i}"] != 0
        )

    for i in span:
        row = " + ".join(f"H{i}{j}*{q[j - 1]}_dd" for j in span if there(i, j))
        rest = "".join(f" + {x}{i}" for x in "cG" if known[f"{x}{i}"] != 0)
        if not m.loops or known[f"c{i}"] == 0:  # c of a closed chain may be that of its loops
            yield claim("equation of motion", f"{driven(i)} = {row}{rest}{multipliers(i)}")
        momentum = " + ".join(f"H{i}{j}*{q[j - 1]}_d" for j in span if there(i, j))
        yield claim("momentum", f"p{i} = {momentum}")
        if not m.loops:
            yield claim("Lagrange", f"p{i}_d - dLdq{i} = {driven(i)}")
    half = " + ".join(
        f"{'1/2*' if i == j else ''}H{i}{j}*"
        + (f"{q[i - 1]}_d**2" if i == j else f"{q[i - 1]}_d*{q[j - 1]}_d")
        for i in span
        for j in span
        if i <= j and there(i, j)
    )
    yield claim("kinetic energy", f"T = {half}")
    yield claim("energy", "L = T - V")
    yield claim("energy", "E = T + V")
    power = " + ".join(f"tau{i}*{q[i - 1]}_d" for i in span if q[i - 1] not in m.passive)
    gravity = " + ".join(f"G{i}*{q[i - 1]}_d" for i in span if known[f"G{i}"] != 0)
    for text in (
        f"{power} = T_d + V_d",
        f"T_d + V_d = {power}",
        f"E_d = {power}",
        f"P = {power}",
        f"V_d = {gravity}" if gravity else "",
        f"T_d = {power} - V_d",
    ):
        if text:
            yield claim("power", text)
    if len(m.bodies) > 1:
        for letter in "TV":
            parts = [f"{letter}{i}" for i, e in enumerate(m.energies, 1) if e[letter == "V"] != 0]
            if len(parts) > 1 and (m.kinetic == 0 or letter == "V"):
                yield claim("energy", f"{letter} = {' + '.join(parts)}")
    yield from _of_bodies(m, claim)


def _of_bodies(m: Mechanism, claim: Any) -> Iterator[Claim]:
    for i, body in enumerate(m.bodies, 1):
        if body.mass == 0 or m.name == "double_four_bar":
            continue
        mass = str(body.mass) if isinstance(body.mass, sp.Symbol) else None
        if mass and m.up == 1:
            turning = f" + 1/2*I{i}*omega{i}**2" if body.inertia != 0 else ""
            yield claim("kinetic energy", f"T{i} = 1/2*{mass}*(vc{i}x**2 + vc{i}y**2){turning}")
            yield claim("potential energy", f"V{i} = {mass}*g*yc{i}")
        if mass and m.serial and m.up == 1:
            after = f"f{i}{i + 1}" if i < len(m.bodies) else ""
            x, y = (f" - {after}x", f" - {after}y") if after else ("", "")
            yield claim("force", f"f{i - 1}{i}x{x} = {mass}*ac{i}x")
            yield claim("force", f"f{i - 1}{i}y{y} - {mass}*g = {mass}*ac{i}y")
            yield claim(
                "force", f"f{i - 1}{i}y = {after + 'y + ' if after else ''}{mass}*(ac{i}y + g)"
            )


ZERO: Tree = ("num", 0)
SIMPLE = 45  # symbols and numbers in a line that somebody writes by hand


def derived(robot: str, rng: random.Random) -> Iterator[Claim]:
    """Each quantity with its value, rewritten."""
    m = mechanism(robot)
    for key, found in m.quantities.items():
        family = family_of(key)
        if family is None or (m.loops and key[0] in "cJ") or (m.up == 2 and key[1:2] == "c"):
            continue
        found = sp.sympify(found)
        if found == 0 or found.count_ops() > 150 or (key.startswith("Phi") and "q" in key):
            continue
        for right in forms(found, m, rng):
            if size(right) > SIMPLE:
                continue
            left: Tree = ("sym", key)
            if right == ZERO:
                continue
            if key.startswith("Phi") and rng.random() < 0.6:
                yield Claim(robot, "loop equation", right, ZERO)
                continue
            if key.startswith("tau") and m.coordinates[int(key[3:]) - 1] in m.passive:
                left = ("num", 0)
            if key in {x + y for x in m.coordinates for y in ("", "_d", "_dd")}:
                continue
            yield Claim(robot, family, left, right)


FAMILIES = (
    ("tau", "torque"),
    ("H", "mass matrix"),
    ("G", "gravity"),
    ("c", "velocity terms"),
    ("T", "kinetic energy"),
    ("V", "potential energy"),
    ("L", "energy"),
    ("E", "energy"),
    ("p", "momentum"),
    ("dLdq", "Lagrange"),
    ("det", "determinant"),
    ("J", "Jacobian"),
    ("x", "position and motion"),
    ("y", "position and motion"),
    ("z", "position and motion"),
    ("v", "position and motion"),
    ("a", "acceleration of a body"),
    ("omega", "angular velocity"),
    ("f", "force"),
    ("Phi", "loop equation"),
)


def family_of(key: str) -> str | None:
    """The family under which a quantity is counted; none where nobody writes it out."""
    if key.startswith("phi") or (key[0] in "CP" and key[:3] != "Phi"):
        return None
    return next((family for start, family in FAMILIES if key.startswith(start)), None)


def solved_rates(robot: str, rng: random.Random) -> Iterator[Claim]:
    """The dependent rates of a closed chain, and angular velocities that contain them."""
    m = mechanism(robot)
    if len(m.loops) != 2 or len(m.passive) != 2:
        return
    rates = _rates(m)
    wanted = {str(y): y for y in rates}
    wanted |= {x: y for x, y in m.quantities.items() if x.startswith("omega") and "_d" not in x}
    for key, found in wanted.items():
        reduced = sp.sympify(found).subs(rates)
        for form in (reduced, sp.together(reduced), sp.expand(reduced)):
            if form != found and size(from_sympy(form)) <= SIMPLE:
                right = shuffled(from_sympy(form), rng)
                yield Claim(robot, "rates by the loops", ("sym", key), right)


def forms(found: sp.Expr, m: Mechanism, rng: random.Random) -> Iterator[Tree]:
    """The value as it comes, sorted, expanded, factored, by angle sums, with squares replaced."""
    seen = set()
    ways = [rng.choice(WAYS) for _ in range(3)]
    for way in (_as_is, *ways):
        try:
            other = way(found, m, rng)
        except (sp.PolynomialError, NotImplementedError, RecursionError):
            continue
        if other is None or other in seen:
            continue
        seen.add(other)
        yield shuffled(from_sympy(other), rng)
    if rng.random() < 0.25:
        yield _halved(from_sympy(found), rng)


def _as_is(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr:
    return x


def _expanded(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr:
    return sp.expand(x)


def _factored(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    return sp.factor(x) if x.count_ops() < 60 else None


def _angle_sums(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    return sp.expand_trig(x) if x.count_ops() < 60 else None


def _sums_of_products(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    from sympy.simplify.fu import TR8

    return TR8(sp.expand(x)) if x.count_ops() < 60 else None


def _squares(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    """sin² by 1 - cos² or the other way, or a parameter squared times c² + s²."""
    x = sp.expand(x)
    squares = [p for p in x.atoms(sp.Pow) if isinstance(p.base, sp.sin | sp.cos) and p.exp == 2]
    if squares:
        p = rng.choice(sorted(squares, key=str))
        other = sp.cos if isinstance(p.base, sp.sin) else sp.sin
        return x.subs(p, 1 - other(p.base.args[0]) ** 2)
    angle = S(rng.choice([c for c in m.coordinates if c.startswith("th")] or ["th1"]))
    if str(angle) not in m.coordinates or not x.is_Add:
        return None
    i = rng.randrange(len(x.args))
    return x - x.args[i] + x.args[i] * (sp.cos(angle) ** 2 + sp.sin(angle) ** 2)


def _half_angles(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    cosines = sorted(x.atoms(sp.cos), key=str)
    if not cosines:
        return None
    c = rng.choice(cosines)
    return x.subs(c, 1 - 2 * sp.sin(c.args[0] / 2) ** 2)


def _collected(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    by = sorted(x.free_symbols, key=str)
    return sp.collect(sp.expand(x), rng.sample(by, min(2, len(by)))) if by else None


def _by_loops(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    """A multiple of a loop equation, or of its rate, added."""
    if not m.loops:
        return None
    loop = rng.choice(m.loops)
    rated = m.rate(loop)
    base = sp.expand(x)
    if not base.is_Add:
        return (
            base - loop
            if base.is_Symbol and str(base)[0] in "dxy" and not base.name.endswith("_d")
            else None
        )
    by = rng.choice((loop, rated))
    for term in by.args:
        for own in base.args:
            ratio = own / term
            if ratio.free_symbols.isdisjoint(m.q) and sp.fraction(ratio)[1].is_Number:
                return sp.expand(base - ratio * by)
    return None


def _reduced(x: sp.Expr, m: Mechanism, rng: random.Random) -> sp.Expr | None:
    """The dependent rates by the independent ones, from the loops' first derivative."""
    dependent = [y for c, y in zip(m.coordinates, m.qd, strict=True) if c in m.passive]
    if len(m.loops) != 2 or len(dependent) != 2 or not x.has(*dependent):
        return None
    return x.subs(_rates(m), simultaneous=True)


@functools.cache
def _rates(m: Mechanism) -> dict[sp.Symbol, sp.Expr]:
    dependent = [y for c, y in zip(m.coordinates, m.qd, strict=True) if c in m.passive]
    rows = [sp.expand(m.rate(loop)) for loop in m.loops]
    a = sp.Matrix([[row.coeff(y) for y in dependent] for row in rows])
    rest = sp.Matrix([row.subs(dict.fromkeys(dependent, 0)) for row in rows])
    short = (lambda x: sp.factor(sp.trigsimp(x))) if len(m.q) < 4 else sp.expand
    solved = [short(-x) for x in a.adjugate() * rest]
    return {y: x / short(a.det()) for y, x in zip(dependent, solved, strict=True)}


WAYS = (
    _expanded,
    _expanded,
    _factored,
    _angle_sums,
    _sums_of_products,
    _squares,
    _half_angles,
    _collected,
    _collected,
    _by_loops,
    _by_loops,
    _by_loops,
    _reduced,
    _reduced,
)


def shuffled(one: Tree, rng: random.Random) -> Tree:
    """Terms and factors in another order, sometimes."""
    if rng.random() < 0.5:
        return one
    match one[0]:
        case "add" | "mul":
            parts = [shuffled(x, rng) for x in one[1]]
            if one[0] == "add" or rng.random() < 0.4:
                rng.shuffle(parts)
            return (one[0], tuple(parts))
        case "neg":
            return ("neg", shuffled(one[1], rng))
    return one


def _halved(one: Tree, rng: random.Random) -> Tree:
    """Twice the half, a fraction multiplied out."""
    top = ("add", one[1]) if one[0] == "add" else one
    doubled = ("add", tuple(_twice(x) for x in top[1])) if top[0] == "add" else _twice(top)
    return ("div", doubled, ("num", 2))


def _twice(one: Tree) -> Tree:
    if one[0] == "neg":
        return ("neg", _twice(one[1]))
    if one[0] == "mul":
        if one[1][0][0] == "num":
            first = one[1][0][1] * 2
            rest = one[1][1:]
            if first == 1:
                return rest[0] if len(rest) == 1 else ("mul", rest)
            return ("mul", (("num", first), *rest))
        return ("mul", (("num", 2), *one[1]))
    return ("mul", (("num", 2), one))


def with_definitions(one: Claim, rng: random.Random) -> Claim | None:
    """A product of parameters or a sine of the right side gets a name on a line before."""
    found = [
        x
        for _, x in places(one.right)
        if (x[0] == "mul" and 2 <= len(x[1]) <= 4 and all(y[0] != "num" for y in x[1]))
        or (x[0] == "fun" and x[1] in ("sin", "cos"))
    ]
    if not found:
        return None
    meant = rng.choice(found)
    name = rng.choice(("k", "kappa", "beta", "A", "B") if meant[0] == "mul" else ("S0", "sigma"))

    def swap(x: Tree) -> Tree:
        if x == meant:
            return ("sym", name)
        if x[0] in ("add", "mul"):
            return (x[0], tuple(swap(y) for y in x[1]))
        if x[0] in ("neg",):
            return ("neg", swap(x[1]))
        if x[0] == "pow":
            return ("pow", swap(x[1]), x[2])
        if x[0] == "div":
            return ("div", swap(x[1]), swap(x[2]))
        return x

    right = swap(one.right)
    if right == one.right or right == ("sym", name):
        return None
    return replace(one, right=right, defined=((name, meant),))
