"""Programs as JavaScript over Float64Array: an ES module, or a plain script for a page that is
opened as a file."""

from __future__ import annotations

from freebody.identifiers import word_set
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    SourceUnit,
    comment_block,
    flat,
    largest_entries,
    number,
    number_lists,
)
from freebody.targets.text.statements import Spelling, body_in_parts, refusal, words_of

LONGEST = 800
"""Operations of one function. V8 does not optimise one of more than 60 kB of bytecode, and is
slower before: a Panda's forward dynamics takes 0.5 us in pieces of 800 or less, 1.2 to 1.9 as one
function of 2000."""

RESERVED = word_set(
    """require console given expected names sizes largest allowed worst bad abstract arguments async
    await boolean break byte case catch char class const continue debugger default delete do double
    else enum eval export extends false final finally float for function get goto if implements
    import in instanceof int interface let long native new null of package private protected public
    return set short static super switch synchronized this throw throws transient true try typeof
    undefined var void volatile while with yield NaN Infinity Math Number Object Array Float64Array
    globalThis window document self w all_finite"""
)
_ONE = ("sqrt", "sin", "cos", "exp", "log", "tanh", "asin", "acos", "sign")
FUNCTIONS = {op: f"Math.{op}({{a}})" for op in _ONE} | {
    "absolute": "Math.abs({a})",
    "atan2": "Math.atan2({a}, {b})",
    "less": "({a} < {b} ? 1.0 : 0.0)",
    "less_equal": "({a} <= {b} ? 1.0 : 0.0)",
    "equal": "({a} === {b} ? 1.0 : 0.0)",
    "where": "({a} !== 0.0 ? {b} : {c})",
    "minimum": "Math.min({a}, {b})",
    "maximum": "Math.max({a}, {b})",
    "epsilon": "Number.EPSILON",
}
_CHECKS = """function all_finite(n, x) {
  for (let i = 0; i < n; i++) {
    if (!Number.isFinite(x[i])) return false;
  }
  return true;
}
"""
_SPELLING = Spelling(
    FUNCTIONS,
    number,
    flat,
    lambda word, argument, k: f"{word}[{k}]",
    "const {word} = {text};",
    "{word} = {text};",
    "// {text}",
)


def _definitions(unit: SourceUnit, export: str = "") -> list[str]:
    """JavaScript text of the function, after those that it calls."""
    words, room = words_of(unit, RESERVED), 0

    def part(name: str, used: list[str], inner: list[str], slots: int) -> str:
        nonlocal room
        room = slots
        return "\n".join([f"function {name}({', '.join(used)}) {{", *inner, "}\n"])

    order = [*words.inputs, *words.outputs]
    made, body = body_in_parts(
        unit, words, _SPELLING, RESERVED, LONGEST, order, part, "{}({});", indent="  "
    )
    outs = zip(words.outputs, unit.program.outputs, strict=True)
    given = [*words.inputs, *(f"{word} = new Float64Array({a.size})" for word, a in outs)]
    head = f"{export}function {words.function}({', '.join(given)}) {{"
    returned = words.outputs[0] if len(words.outputs) == 1 else f"[{', '.join(words.outputs)}]"
    finite, blank = ("all_finite({size}, {word})", "Number.isFinite({word})"), "{word}.fill(NaN);"
    around = "if (!({})) {{", f"return {returned};", "}"
    checks = refusal(unit, words, finite, (blank, blank), around, "  ")
    before = [_CHECKS, f"const w = new Float64Array({room});\n"] if room else [_CHECKS]
    whole = "\n".join([head, *checks, *body, f"  return {returned};", "}\n"])
    return [*before, *made, whole]


_USE = (
    "Inputs are arrays of numbers, best Float64Array; matrices are stored row by row. Outputs are "
    "Float64Array: given",
    "as further arguments they are written to, else made; the one output, or the list of them, is "
    "returned.",
    "An input that is NaN or infinite makes all outputs NaN.",
)


def _head(unit: SourceUnit) -> list[str]:
    return comment_block(unit, _USE, "/*", " *", " */")


def _emit_module(unit: SourceUnit) -> str:
    return "\n".join([*_head(unit), *_definitions(unit, "export ")])


def _emit_script(unit: SourceUnit) -> str:
    word = words_of(unit, RESERVED).function
    inner = "\n".join(['"use strict";', "", *_definitions(unit), f"return {word};"])
    return "\n".join([*_head(unit), f"const {word} = (function () {{", inner, "})();\n"])


def _package_module(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    test = _self_test(unit, vectors, f'import {{ {word} }} from "./{word}.mjs";\n')
    return {f"{word}.mjs": _emit_module(unit), f"{word}_test.mjs": test}


def _package_script(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    # what a page does with <script src>
    beginning = (
        f'require("vm").runInThisContext(require("fs").readFileSync("{word}.js", "utf8"));\n'
    )
    return {
        f"{word}.js": _emit_script(unit),
        f"{word}_test.js": _self_test(unit, vectors, beginning),
    }


def _self_test(unit: SourceUnit, vectors: SelfTestSamples, beginning: str) -> str:
    words = words_of(unit, RESERVED)
    columns = [
        "[\n" + ",\n".join(f"    [{row}]" for row in number_lists(rows, number)) + ",\n  ]"
        for rows in (*vectors.inputs, *vectors.outputs)
    ]
    given, expected = columns[: len(vectors.inputs)], columns[len(vectors.inputs) :]
    taken = [
        f"given[{k}][i]" if a.shape else f"given[{k}][i][0]"
        for k, a in enumerate(unit.program.inputs)
    ]
    names = ", ".join(f'"{word}"' for word in words.outputs)
    sizes = ", ".join(str(a.size) for a in unit.program.outputs)
    call = f"{words.function}({', '.join(taken)})"
    found = call if len(words.outputs) > 1 else f"[{call}]"
    return f"""{beginning}
const given = [{", ".join(given)}];
const expected = [{", ".join(expected)}];
const names = [{names}], sizes = [{sizes}];
const largest = [{", ".join(map(number, largest_entries(vectors)))}];
const allowed = [{", ".join(map(number, vectors.tolerances))}];
const worst = names.map(() => 0);
for (let i = 0; i < {vectors.count}; i++) {{
  const found = {found};
  for (let k = 0; k < names.length; k++) {{
    for (let j = 0; j < sizes[k]; j++) {{
      const d = Math.abs(found[k][j] - expected[k][i][j]) / largest[k];
      worst[k] = d <= worst[k] ? worst[k] : d; // NaN counts
    }}
  }}
}}
let bad = false;
for (let k = 0; k < names.length; k++) {{
  const off = `off by at most ${{worst[k]}} of its largest entry`;
  console.log(`${{names[k]}}: ${{off}}; allowed ${{allowed[k]}}`);
  bad = bad || !(worst[k] <= allowed[k]);
}}
console.log(bad ? "FAILED" : "passed");
if (bad) throw new Error("the self-test failed");
"""


MODULE = Language(_emit_module, _package_module, "node {name}_test.mjs")
SCRIPT = Language(_emit_script, _package_script, "node {name}_test.js")
