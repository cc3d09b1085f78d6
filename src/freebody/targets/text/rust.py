"""Programs as Rust: no allocation, no crate."""

from __future__ import annotations

from freebody.identifiers import word_set
from freebody.program.program import Argument
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    SourceUnit,
    comment_block,
    flat,
    helpers,
    largest_entries,
    number,
    number_lists,
    numbered,
    single,
)
from freebody.targets.text.statements import (
    ProgramWords,
    Spelling,
    body_in_parts,
    refusal,
    words_of,
)

LONGEST = 4000
"""Operations of one function: compilers take longer than in proportion."""

RESERVED = word_set(
    """as async await become box break const continue crate do dyn else enum extern false final fn
    for gen if impl in let loop macro match mod move mut override priv pub ref return self Self
    static struct super trait true try type typeof union unsafe unsized use virtual where while
    yield abstract bool char f32 f64 i32 str u8 usize main w bad std core alloc min_of max_of
    sign_of"""
) | numbered("found", "worst")
_ONE = ("sqrt", "sin", "cos", "exp", "tanh", "asin", "acos")
FUNCTIONS = {op: f"{{t}}::{op}({{a}})" for op in _ONE} | {
    "log": "{t}::ln({a})",
    "absolute": "{t}::abs({a})",
    "atan2": "{t}::atan2({a}, {b})",
    "sign": "sign_of({a})",
    "less": "(if {a} < {b} {{ 1.0 }} else {{ 0.0 }})",
    "less_equal": "(if {a} <= {b} {{ 1.0 }} else {{ 0.0 }})",
    "equal": "(if {a} == {b} {{ 1.0 }} else {{ 0.0 }})",
    "where": "(if {a} != 0.0 {{ {b} }} else {{ {c} }})",
    "minimum": "min_of({a}, {b})",
    "maximum": "max_of({a}, {b})",
    "epsilon": "{t}::EPSILON",
}
_CHOICE = (
    "fn NAME(a: {t}, b: {t}) -> {t} {{\n    if TEST || a.is_nan() {{\n        a\n    }} else {{\n  "
    "      b\n"
    "    }}\n}}\n"
)
_HELPERS = {
    "sign": "fn sign_of(x: {t}) -> {t} {{\n    if x > 0.0 {{\n        1.0\n"
    "    }} else if x < 0.0 {{\n        -1.0\n"
    "    }} else {{\n        0.0\n    }}\n}}\n",
    # NaN that arises on the way stays
    "minimum": _CHOICE.replace("NAME", "min_of").replace("TEST", "a <= b"),
    "maximum": _CHOICE.replace("NAME", "max_of").replace("TEST", "b <= a"),
}
_ALLOW = "#[allow(non_snake_case, unused_parens)]"


def _type(unit: SourceUnit) -> str:
    return "f32" if unit.dtype == "float32" else "f64"


def _spelling(unit: SourceUnit) -> Spelling:
    return Spelling(
        {op: text.replace("{t}", _type(unit)) for op, text in FUNCTIONS.items()},
        single if unit.dtype == "float32" else number,
        flat,
        lambda word, argument, k: flat(word, argument, k) if argument.shape else f"*{word}",
        "let {word} = {text};",
        "{word} = {text};",
        "// {text}",
    )


def _parameters(unit: SourceUnit, words: ProgramWords) -> dict[str, str]:
    """The Rust declaration of each argument, by its name in the text."""
    t = _type(unit)

    def declared(word: str, argument: Argument, writes: bool) -> str:
        array = f"[{t}; {argument.size}]" if argument.shape else t
        return f"{word}: {'&mut ' if writes else '&' if argument.shape else ''}{array}"

    ins = zip(words.inputs, unit.program.inputs, strict=True)
    outs = zip(words.outputs, unit.program.outputs, strict=True)
    return {w: declared(w, a, False) for w, a in ins} | {w: declared(w, a, True) for w, a in outs}


def _definitions(unit: SourceUnit) -> list[str]:
    """Rust text of the function, after those that it calls."""
    words, spelling, t = words_of(unit, RESERVED), _spelling(unit), _type(unit)
    parameters = _parameters(unit, words)

    def part(name: str, used: list[str], inner: list[str], slots: int) -> str:
        given = [*(parameters[x] for x in used), f"w: &mut [{t}; {slots}]"]
        return "\n".join([f"{_ALLOW}\nfn {name}({', '.join(given)}) {{", *inner, "}\n"])

    call, workspace = "{}({});", ("let mut w = [0.0; {}];", "&mut w")
    made, body = body_in_parts(
        unit, words, spelling, RESERVED, LONGEST, list(parameters), part, call, workspace
    )
    head = f"{_ALLOW}\npub fn {words.function}({', '.join(parameters.values())}) -> bool {{"
    checks = refusal(
        unit, words,
        ("{word}.iter().all(|x| x.is_finite())", "{word}.is_finite()"),
        (f"{{word}}.fill({t}::NAN);", f"*{{word}} = {t}::NAN;"),
        ("if !({}) {{", "return false;", "}"),
    )  # fmt: skip
    before = [text.format(t=t) for text in helpers(unit.program, _HELPERS)]
    return [*before, *made, "\n".join([head, *checks, *body, "    true", "}\n"])]


_USE = (
    "Matrices are stored row by row. Returns true; or false if an input is NaN or infinite: all "
    "outputs are then NaN.",
)


def _emit(unit: SourceUnit) -> str:
    return "\n".join([*comment_block(unit, _USE, "", "//", ""), "", *_definitions(unit)])


def _package(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    return {f"{word}.rs": _emit(unit), f"{word}_test.rs": _self_test(unit, vectors)}


def _self_test(unit: SourceUnit, vectors: SelfTestSamples) -> str:
    words, spell, t = words_of(unit, RESERVED), _spelling(unit).number, _type(unit)
    program, count = unit.program, vectors.count
    tables, body = [], []
    for prefix, values in (("GIVEN", vectors.inputs), ("EXPECTED", vectors.outputs)):
        for k, rows in enumerate(values):
            listed = ",\n".join(
                f"    [{row if rows.shape[1] else ''}]" for row in number_lists(rows, spell)
            )
            tables.append(
                f"const {prefix}{k}: [[{t}; {rows.shape[1]}]; {count}] = [\n{listed},\n];\n"
            )
    given = [
        f"&GIVEN{k}[i]" if a.shape else f"GIVEN{k}[i][0]" for k, a in enumerate(program.inputs)
    ]
    found = [
        f"&mut found{k}" if a.shape else f"&mut found{k}[0]" for k, a in enumerate(program.outputs)
    ]
    for k, argument in enumerate(program.outputs):
        body += [
            f"    let mut found{k} = [0.0; {argument.size}];",
            f"    let mut worst{k}: {t} = 0.0;",
        ]
    body += ["    let mut bad = false;", f"    for i in 0..{count} {{"]
    body += [f"        bad |= !{words.function}({', '.join([*given, *found])});"]
    for k, largest in enumerate(largest_entries(vectors)):
        body += [
            f"        for (x, y) in found{k}.iter().zip(EXPECTED{k}[i].iter()) {{",
            f"            let d = (x - y).abs() / {spell(largest)};",
            f"            worst{k} = if d <= worst{k} {{ worst{k} }} else {{ d }}; // NaN counts",
            "        }",
        ]
    body.append("    }")
    for k, (word, tolerance) in enumerate(zip(words.outputs, vectors.tolerances, strict=True)):
        body += [
            f'    println!("{word}: off by at most {{:.2e}} of its largest entry; '
            f'allowed {tolerance:.2g}", worst{k});',
            f"    bad |= !(worst{k} <= {spell(tolerance)});",
        ]
    body += ['    println!("{}", if bad { "FAILED" } else { "passed" });']
    body += ["    std::process::exit(i32::from(bad));"]
    head = f"mod {words.function};\nuse {words.function}::{words.function};\n"
    return "\n".join([head, *tables, "#[allow(clippy::all)]\nfn main() {", *body, "}\n"])


RUST = Language(
    _emit,
    _package,
    "rustc -O {name}_test.rs -o {name}_test && ./{name}_test",
    ("float64", "float32"),
)
