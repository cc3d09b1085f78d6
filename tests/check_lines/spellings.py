"""How people and programs write formulas: letters, rates, products, functions, by books and tools.

A `Spelling` draws one writer's habits; `written` writes a tree in them.
"""

import random
import re
from dataclasses import dataclass, field, replace
from fractions import Fraction

from .trees import Tree

GREEK_NAMES = ("kappa", "beta", "sigma")
SUBSCRIPTS = str.maketrans("0123456789xy", "₀₁₂₃₄₅₆₇₈₉ₓᵧ")
POWERS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")

# kind: (plain text, Unicode, LaTeX), "#" is the index; each a list of equally likely habits
LETTERS: dict[str, tuple[list[str], list[str], list[str]]] = {
    "th": (["theta#", "theta_#", "q#", "th#"], ["θ#", "q#"], [r"\theta_#", r"q_#", r"\theta_{#}"]),
    "d": (["d#", "d_#", "q#"], ["d#"], [r"d_#", r"d_{#}", r"q_#"]),
    "l": (["l#", "l_#"], ["l#"], [r"l_#", r"l_{#}", r"\ell_#"]),
    "lc": (["lc#", "l_c#"], ["lc#", "l_c#"], [r"l_{c#}", r"l_{c_#}", r"\ell_{c#}"]),
    "m": (["m#", "m_#"], ["m#"], [r"m_#", r"m_{#}"]),
    "I": (["I#", "I_#"], ["I#"], [r"I_#", r"I_{#}"]),
    "J2": (["J2"], ["J₂"], ["J_2"]),
    "tau": (["tau#", "tau_#"], ["τ#"], [r"\tau_#", r"\tau_{#}", r"\Gamma_#"]),
    "H": (["H#", "M#", "D#", "H_#", "M(#)"], ["H#", "M#"], ["H_{#}", "M_{#}", "D_{#}"]),
    "H_d": (["H#_dot"], ["Ḣ#", "Ṁ#"], [r"\dot H_{#}", r"\dot{M}_{#}"]),
    "C": (["C#"], ["C#"], ["C_{#}", "c_{#}"]),
    "c": (["c#", "c_#"], ["c#"], ["c_#", "c_{#}"]),
    "G": (["G#", "g#", "G_#"], ["G#", "g#"], ["G_#", "g_#", r"g_{#}"]),
    "T": (["T", "K"], ["T", "K"], ["T", "K", r"\mathcal{T}"]),
    "V": (["V", "U"], ["V", "U"], ["V", "U", r"\mathcal{U}"]),
    "L": (["L"], ["L"], ["L", r"\mathcal{L}"]),
    "E": (["E"], ["E"], ["E"]),
    "P": (["P"], ["P"], ["P"]),
    "Ti": (["T_#", "K_#", "T#"], ["T#", "K#"], ["T_#", "K_{#}"]),
    "Vi": (["V_#", "U_#", "V#"], ["V#", "U#"], ["V_#", "U_{#}"]),
    "p": (["p_#"], ["∂T/∂@"], [r"\frac{\partial T}{\partial @}", r"\frac{\partial L}{\partial @}"]),
    "p_d": (
        ["d/dt(dL/d@)"],
        ["d/dt(∂L/∂@)"],
        [
            r"\frac{d}{dt}\frac{\partial L}{\partial @}",
            r"\frac{d}{dt}\left(\frac{\partial T}{\partial @}\right)",
        ],
    ),
    "dLdq": (
        ["∂L/∂@"],
        ["∂L/∂@"],
        [r"\frac{\partial L}{\partial @}", r"\dfrac{\partial L}{\partial @}"],
    ),
    "T_d": (
        ["dT/dt"],
        ["dT/dt", "Ṫ"],
        [r"\dot T", r"\frac{dT}{dt}", r"\frac{\mathrm{d}T}{\mathrm{d}t}"],
    ),
    "V_d": (
        ["dV/dt"],
        ["dV/dt", "V̇"],
        [r"\dot V", r"\frac{dV}{dt}", r"\frac{\mathrm{d}V}{\mathrm{d}t}"],
    ),
    "E_d": (["dE/dt"], ["dE/dt", "Ė"], [r"\dot E", r"\frac{dE}{dt}"]),
    "J": (["J#", "J_#"], ["J#"], ["J_{#}"]),
    "detJ": (["det(J)", "det J", "detJ"], ["det J", "det(J)"], [r"\det J", r"\det(J)", "|J|"]),
    "omega": (["omega_#", "omega#"], ["ω#"], [r"\omega_#", r"\omega_{#}"]),
    "omega_d": (
        ["omega_#_dot", "alpha_#"],
        ["ω̇#", "α#"],
        [r"\dot\omega_#", r"\dot{\omega}_{#}", r"\alpha_#"],
    ),
    "xc": (["@_c#", "@c#"], ["@_c#"], ["@_{c#}", "@_{C_#}", "@_{c_#}"]),
    "xc_d": (
        ["v_c#@"],
        ["ẋ_c#", "v_c#@"],
        [r"\dot @_{c#}", r"\dot{@}_{c#}", "v_{c#@}", "v_{c_#,@}"],
    ),
    "xc_dd": (["a_c#@"], ["a_c#@"], [r"\ddot @_{c#}", r"\ddot{@}_{c#}", "a_{c#@}"]),
    "f": (["f_#@", "F_#@", "f#@"], ["f_#@"], ["f_{#@}", "F_{#@}", "f_{#,@}"]),
    "lam": (["lambda_#", "lambda#"], ["λ#"], [r"\lambda_#", r"\lambda_{#}"]),
    "Phi": (["Phi_#"], ["Φ#"], [r"\Phi_#", r"\Phi_{#}"]),
    "Phi_d": (["Phi_#_dot"], ["Φ̇#"], [r"\dot\Phi_#"]),
    "Phi_dd": (["Phi_#_ddot"], ["Φ̈#"], [r"\ddot\Phi_#"]),
}
RATES = [
    ("d{}", "dd{}"),
    ("{}_d", "{}_dd"),
    ("{}_dot", "{}_ddot"),
    ("{}dot", "{}ddot"),
    ("{}_p", "{}_pp"),
]
FUNCTIONS = {
    "acos": (["acos", "arccos"], [r"\arccos", r"\cos^{-1}"]),
    "asin": (["asin", "arcsin"], [r"\arcsin", r"\sin^{-1}"]),
    "atan": (["atan", "arctan"], [r"\arctan", r"\tan^{-1}"]),
    "atan2": (["atan2", "arctan2"], [r"\operatorname{atan2}", r"\mathrm{atan2}", r"\text{atan2}"]),
}


@dataclass
class Spelling:
    """One writer's habits: form is "plain", "code", "unicode", "tex", "function" (theta1(t)),
    "sympy" or "sympytex" (what these print)."""

    form: str
    letters: dict[str, str]
    rate: tuple[str, str]
    short: bool  # c12 for cos(θ1 + θ2)
    argument: bool  # M_{12}(q)
    functions: dict[str, str]
    power: str = "^"
    half: str = "1/2"
    own: dict[str, str] = field(default_factory=dict)  # key: a name of one's own
    frac: str = r"\frac"
    dot: str = " "
    coordinates: tuple[str, ...] = ()

    @property
    def tex(self) -> bool:
        return self.form in ("tex", "sympytex")

    def names(self) -> dict[str, str] | None:
        """What `names=` takes for the names of one's own."""
        return {spelled: key for key, spelled in self.own.items()} or None


FORMS = ("plain", "code", "unicode", "tex", "tex", "tex", "function", "sympy", "sympytex", "matlab")


def spelling(rng: random.Random, form: str | None = None) -> Spelling:
    """One writer's habits, drawn."""
    form = form or rng.choice(FORMS)
    column = 2 if form in ("tex", "sympytex") else 1 if form == "unicode" else 0
    letters = {kind: rng.choice(options[column]) for kind, options in LETTERS.items()}
    functions = {
        name: rng.choice(options[1 if column == 2 else 0]) for name, options in FUNCTIONS.items()
    }
    rate = rng.choices(RATES[:5], [5, 3, 3, 2, 0])[0]
    if form in ("function", "sympy", "sympytex", "matlab", "code"):
        letters |= {x: LETTERS[x][column][0] for x in ("th", "l", "lc", "m", "I", "d")}
        letters["H"] = rng.choice(("H#", "M#")) if column == 0 else letters["H"]
    if form == "sympytex":
        letters |= {"th": r"\theta_{#}", "l": "l_{#}", "lc": "l_{c#}", "m": "m_{#}", "I": "I_{#}"}
        letters["d"] = "d_{#}"
    if rng.random() < 0.5 and "q#" not in letters["th"]:
        letters["d"] = letters["d"].replace("q", "d")
    if "q" in letters["th"] or "q" in letters["d"]:
        letters["d"] = letters["th"] = letters["th"] if "q" in letters["th"] else letters["d"]
    short = form in ("plain", "tex", "unicode") and rng.random() < 0.35
    return Spelling(
        form,
        letters,
        rate,
        short,
        rng.random() < 0.08 and form in ("tex", "plain"),
        functions,
        "**" if form in ("code", "sympy", "function") else "^",
        rng.choice(("1/2", "0.5")),
        frac=rng.choice((r"\frac", r"\frac", r"\dfrac")),
        dot=rng.choice((" ", " ", r"\,", r"\cdot ")),
    )


KEY = re.compile(
    r"(?:(?P<kind>th|d|l|lc|m|I|tau|H|C|c|G|p|dLdq|omega|phi|J|lam|Phi)(?P<index>\d+)"
    r"|(?P<kind2>[TV])(?P<index2>\d+)"
    r"|(?P<axis>[xyz])c(?P<body>\d+)|(?P<va>[va])c(?P<body2>\d+)(?P<axis2>[xyz])"
    r"|f(?P<between>\d\d)(?P<axis3>[xy]))(?P<dots>_dd?)?"
)


def named(key: str, s: Spelling) -> str:
    """A quantity's name in these habits."""
    if key in s.own:
        return s.own[key]
    base, dots = re.fullmatch(r"(.*?)(_dd?)?", key).groups()  # type: ignore[union-attr]
    if base in s.own and dots:
        return _dotted(s.own[base], dots, s)
    column = 2 if s.tex else 1 if s.form == "unicode" else 0
    found = KEY.fullmatch(key)
    if found is None:
        if "#" not in s.letters.get(key, "#"):
            return s.letters[key]
        if key in GREEK_NAMES and s.tex:
            return "\\" + key
        return _dotted(base, dots, s) if dots else key
    part = found.groupdict()
    dots = part["dots"]
    if part["kind"]:
        kind, index = part["kind"], part["index"]
        if kind in ("H", "omega", "Phi", "p") and dots:
            kind, dots = kind + dots, None
        if kind in ("p", "p_d", "dLdq"):
            return _derivative(kind, int(index), s)
        name = _indexed(s.letters[kind], index, column)
        if kind == "H" and "(" in name:
            name = f"M({index[0]},{index[1]})"
        if s.argument and kind in ("H", "G", "c"):
            name += r"(q, \dot q)" if kind == "c" and s.tex else "(q)"
        return _dotted(name, dots, s) if dots else name
    if part["kind2"]:
        return _indexed(s.letters[part["kind2"] + "i"], part["index2"], column)
    if part["axis"]:
        kind, body, axis = "xc", part["body"], part["axis"]
    elif part["va"]:
        kind = "xc_d" if part["va"] == "v" else "xc_dd"
        body, axis = part["body2"], part["axis2"]
    else:
        body, axis = part["between"], part["axis3"]
        return s.letters["f"].replace("#", body).replace("@", axis)
    form = s.letters[kind]
    if "ẋ" in form:
        form = form.replace("ẋ", axis + "\u0307")
    return form.replace("#", body).replace("@", axis)


def _derivative(kind: str, index: int, s: Spelling) -> str:
    plain = s if s.form in ("tex", "unicode", "sympytex") else replace(s, form="plain")
    by = named(s.coordinates[index - 1] + ("" if kind == "dLdq" else "_d"), plain)
    return s.letters[kind].replace("@", by).replace("#", str(index))


def _indexed(form: str, index: str, column: int) -> str:
    if column == 1 and "_" not in form:
        return form.replace("#", index.translate(SUBSCRIPTS))
    return form.replace("#", index)


def _dotted(name: str, dots: str, s: Spelling) -> str:
    twice = dots == "_dd"
    if s.tex:
        letter, _, index = name.partition("_")
        if s.form == "sympytex":
            return rf"\{'d' * (1 + twice)}ot{{{letter}}}" + (f"_{index}" if index else "")
        mark = r"\ddot" if twice else r"\dot"
        joined = f"{mark}{letter}" if letter.startswith("\\") else f"{mark} {letter}"
        if s.frac == r"\dfrac":
            joined = f"{mark}{{{letter}}}"
        return joined + (f"_{index}" if index else "")
    if s.form == "unicode":
        return name[0] + ("\u0308" if twice else "\u0307") + name[1:]
    if s.form in ("function", "sympy"):
        return f"Derivative({name}(t), {'(t, 2)' if twice else 't'})"
    if s.form == "matlab":
        return (
            f"diff({name}(t), t{', 2' if twice else ''})"
            if s.rate[0] == "d{}"
            else s.rate[twice].format(name)
        )
    return s.rate[twice].format(name)


SUM, PRODUCT, POWER = 1, 2, 3


def written(one: Tree, s: Spelling, level: int = 0) -> str:
    """The formula as this writer writes it."""
    match one[0]:
        case "num":
            return _number(one[1], s, level)
        case "sym":
            return _symbol(one[1], s)
        case "add":
            return _bracket(_sum(one[1], s), level >= PRODUCT, s)
        case "neg":
            return _bracket("-" + written(one[1], s, PRODUCT), level >= SUM, s)
        case "mul":
            return _bracket(_product(one[1], s), level >= POWER, s)
        case "div":
            return _quotient(one, s, level)
        case "pow":
            return _power(one, s)
        case "mat":
            return _matrix(one, s)
    return _function(one, s, level)


def _bracket(text: str, needed: bool, s: Spelling) -> str:
    if not needed:
        return text
    return (
        rf"\left({text}\right)"
        if s.form == "sympytex" or (s.frac == r"\dfrac" and s.tex)
        else f"({text})"
    )


def _number(number: Fraction, s: Spelling, level: int) -> str:
    if number.denominator == 1:
        return str(number.numerator)
    if set(_factors(number.denominator)) <= {2, 5} and number.denominator not in (2, 4, 8):
        return (
            f"{float(number):g}"
            if float(f"{float(number):g}") == float(number)
            else str(float(number))
        )
    if s.tex:
        return rf"{s.frac}{{{number.numerator}}}{{{number.denominator}}}"
    if number == Fraction(1, 2) and s.half == "0.5":
        return "0.5"
    text = f"{number.numerator}/{number.denominator}"
    return f"({text})" if (level >= PRODUCT and s.form != "plain") or level >= POWER else text


def _factors(number: int) -> list[int]:
    found = []
    for p in (2, 3, 5, 7, 11):
        while number % p == 0:
            number //= p
            found.append(p)
    return [*found, number] if number > 1 else found


def _symbol(key: str, s: Spelling) -> str:
    name = named(key, s)
    if s.form in ("function", "sympy", "matlab") and re.fullmatch(r"(th|d)\d", key):
        plain = s.form == "matlab" and s.rate[0] != "d{}"
        return name if plain else f"{name}(t)"
    return name


def _sum(terms: tuple[Tree, ...], s: Spelling) -> str:
    text = written(terms[0], s, 0 if terms[0][0] == "neg" else SUM)
    for term in terms[1:]:
        if term[0] == "neg":
            text += " - " + written(term[1], s, PRODUCT)
        else:
            text += " + " + written(term, s, SUM)
    return text


def _bare(one: Tree, s: Spelling) -> bool:
    """Whether a factor is a function written without brackets, after which nothing may follow."""
    return one[0] == "fun" or (one[0] == "pow" and one[1][0] == "fun")


def _product(factors: tuple[Tree, ...], s: Spelling) -> str:
    if s.form in ("plain", "code", "function", "sympy", "matlab"):
        return "*".join(written(x, s, PRODUCT) for x in factors)
    parts = sorted(factors, key=lambda x: (x[0] != "num", _bare(x, s) and x[0] != "num"))
    texts = [written(x, s, PRODUCT) for x in parts]
    joint = s.dot if s.form == "tex" else " "
    if [x[0] for x in parts].count("num") > 1:
        joint = r"\cdot " if s.tex else "·"
    return joint.join(texts)


def _quotient(one: Tree, s: Spelling, level: int) -> str:
    if s.tex:
        return rf"{s.frac}{{{written(one[1], s)}}}{{{written(one[2], s)}}}"
    return _bracket(f"{written(one[1], s, PRODUCT)}/{written(one[2], s, POWER)}", level >= POWER, s)


def _power(one: Tree, s: Spelling) -> str:
    base, exponent = one[1], one[2]
    if (
        base[0] == "fun"
        and base[1] in ("sin", "cos", "tan")
        and s.form in ("tex", "unicode", "sympytex")
    ):
        raised = f"^{exponent}" if s.form == "tex" else f"^{{{exponent}}}"
        raised = raised if s.tex else str(exponent).translate(POWERS)
        return _function(base, s, PRODUCT, raised)
    text = written(base, s, POWER)
    if base[0] not in ("sym", "fun") and not text.startswith(("(", r"\left(")):
        text = f"({text})"
    if s.form == "unicode":
        return text + str(exponent).translate(POWERS)
    if s.tex and (s.form == "sympytex" or len(str(exponent)) > 1):
        return f"{text}^{{{exponent}}}"
    return f"{text}{s.power}{exponent}"


def _matrix(one: Tree, s: Spelling) -> str:
    rows = [[written(x, s) for x in row] for row in one[1]]
    if s.tex:
        return r"\begin{bmatrix}" + r" \\ ".join(" & ".join(x) for x in rows) + r"\end{bmatrix}"
    if s.form in ("sympy", "code", "function"):
        return "Matrix([" + ", ".join("[" + ", ".join(x) + "]" for x in rows) + "])"
    return "[" + "; ".join(", ".join(x) for x in rows) + "]"


def _function(one: Tree, s: Spelling, level: int, raised: str = "") -> str:
    name, arguments = one[1], one[2]
    if name == "sqrt":
        inside = written(arguments[0], s)
        return (
            rf"\sqrt{{{inside}}}"
            if s.tex
            else f"sqrt({inside})"
            if s.form != "unicode"
            else f"√({inside})"
        )
    if name == "abs":
        inside = written(arguments[0], s)
        return rf"\left|{inside}\right|" if s.tex else f"abs({inside})"
    if s.short and name in ("sin", "cos"):
        index = _short(arguments[0])
        if index:
            brace = f"_{{{index}}}" if len(index) > 1 else f"_{index}"
            text = name[0] + (
                brace if s.tex else index.translate(SUBSCRIPTS) if s.form == "unicode" else index
            )
            return text + raised
    spelled = s.functions.get(name) or (rf"\{name}" if s.tex else name)
    inside = ", ".join(written(x, s) for x in arguments)
    if s.form == "sympytex":
        return rf"{spelled}{raised}{{\left({inside} \right)}}"
    simple = arguments[0][0] == "sym" and name in ("sin", "cos", "tan")
    if s.form == "tex" and simple and s.dot != r"\cdot ":
        return (
            f"{spelled}{raised} {inside}"
            if not inside.startswith("\\")
            else f"{spelled}{raised}{inside}"
        )
    if s.form == "unicode" and simple:
        return f"{spelled}{raised} {inside}"
    return f"{spelled}{raised}({inside})"


def _short(argument: Tree) -> str:
    """The index of c12, s1; empty where the angle is no sum of joint angles."""
    parts = argument[1] if argument[0] == "add" else (argument,)
    if not all(x[0] == "sym" and re.fullmatch(r"th\d", x[1]) for x in parts):
        return ""
    return "".join(x[1][2:] for x in parts)
