"""JavaScript over Float64Array: an ES module, or a plain script for a page that is opened as a
file."""

from __future__ import annotations

from freebody.identifiers import word_set
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    comment_block,
    flat,
    largest_entries,
    number,
    number_lists,
)
from freebody.targets.text.pieces import Piece, cut
from freebody.targets.text.statements import ProgramWords, Spelling, lines, statements, words_of
from freebody.targets.text.unit import Unit

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


def _definitions(unit: Unit, export: str = "") -> list[str]:
    """The function, after what it calls."""
    words = words_of(unit, RESERVED)
    pieces, slots = cut(statements(unit, words, _SPELLING, RESERVED), LONGEST)
    made = [_CHECKS]
    body = _checks(unit, words)
    if len(pieces) == 1:
        body += lines(pieces[0].statements, _SPELLING, "  ")
    else:
        made.append(f"const w = new Float64Array({slots});\n")
        for k, piece in enumerate(pieces):
            called, used = (
                f"{words.function}_part{k + 1}",
                piece.arguments([*words.inputs, *words.outputs]),
            )
            made.append(_part(called, piece, used))
            body.append(f"  {called}({', '.join(used)});")
    outs = zip(words.outputs, unit.program.outputs, strict=True)
    given = [*words.inputs, *(f"{word} = new Float64Array({a.size})" for word, a in outs)]
    returned = words.outputs[0] if len(words.outputs) == 1 else f"[{', '.join(words.outputs)}]"
    head = f"{export}function {words.function}({', '.join(given)}) {{"
    made.append("\n".join([head, *body, f"  return {returned};", "}\n"]))
    return made


def _part(name: str, piece: Piece, used: list[str]) -> str:
    loads = [f"  const {word} = w[{slot}];" for word, slot in piece.loads]
    stores = [f"  w[{slot}] = {word};" for word, slot in piece.stores]
    head = f"function {name}({', '.join(used)}) {{"
    return "\n".join([head, *loads, *lines(piece.statements, _SPELLING, "  "), *stores, "}\n"])


def _checks(unit: Unit, words: ProgramWords) -> list[str]:
    """What answers a call with an input that is not finite."""
    tests = [
        f"all_finite({a.size}, {word})" if a.shape else f"Number.isFinite({word})"
        for word, a in zip(words.inputs, unit.program.inputs, strict=True)
    ]
    fills = [f"    {word}.fill(NaN);" for word in words.outputs]
    returned = words.outputs[0] if len(words.outputs) == 1 else f"[{', '.join(words.outputs)}]"
    if not tests:
        return []
    return [f"  if (!({' && '.join(tests)})) {{", *fills, f"    return {returned};", "  }"]


_USE = (
    "Inputs are arrays of numbers, best Float64Array; matrices are stored row by row. Outputs are "
    "Float64Array: given",
    "as further arguments they are written to, else made; the one output, or the list of them, is "
    "returned.",
    "An input that is NaN or infinite makes all outputs NaN.",
)


def _head(unit: Unit) -> list[str]:
    return comment_block(unit, _USE, "/*", " *", " */")


def _emit_module(unit: Unit) -> str:
    return "\n".join([*_head(unit), *_definitions(unit, "export ")])


def _emit_script(unit: Unit) -> str:
    word = words_of(unit, RESERVED).function
    inner = "\n".join(['"use strict";', "", *_definitions(unit), f"return {word};"])
    return "\n".join([*_head(unit), f"const {word} = (function () {{", inner, "})();\n"])


def _package_module(unit: Unit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    test = _self_test(unit, vectors, f'import {{ {word} }} from "./{word}.mjs";\n')
    return {f"{word}.mjs": _emit_module(unit), f"{word}_test.mjs": test}


def _package_script(unit: Unit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    # what a page does with <script src>
    beginning = (
        f'require("vm").runInThisContext(require("fs").readFileSync("{word}.js", "utf8"));\n'
    )
    return {
        f"{word}.js": _emit_script(unit),
        f"{word}_test.js": _self_test(unit, vectors, beginning),
    }


def _self_test(unit: Unit, vectors: SelfTestSamples, beginning: str) -> str:
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
