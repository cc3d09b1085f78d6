"""Classes of lexemes and parts of patterns, by the names that patterns have for them."""

from freebody.expressions.grammar.tables import characters

_LATIN = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"

CLASSES = {
    # letters and figures
    "name": ("%letter", "%digit", "%low", "%frame", "%determinant"),
    "latin": tuple(_LATIN),
    "small_letter": tuple(_LATIN[:26]),
    "plain_letter": (*_LATIN, *characters.LETTERS),
    "greek_command": tuple(f"\\{name}" for name in characters.LETTER_COMMANDS),
    "counted": tuple("123456789"),
    "low_digit": tuple("₀₁₂₃₄₅₆₇₈₉"),
    "high_digit": tuple("⁰¹²³⁴⁵⁶⁷⁸⁹"),
    "figure": tuple("0123456789₀₁₂₃₄₅₆₇₈₉"),
    "two_or_three": ("2", "3"),
    "axis": ("x", "y", "z"),
    "prime": tuple(characters.PRIMES),
    "star": characters.STARS,
    # commands around letters
    "font": ("\\mathbf", "\\mathrm", "\\boldsymbol", "\\bm", "\\vec"),
    "around_letter": ("%font", "\\mathcal"),
    "upright": ("\\mathrm", "\\mathsf", "\\mathbf"),
    "accent": ("\\dot", "\\ddot", "\\hat", "%font"),
    "dotting": ("\\dot", "\\ddot", "\\boldsymbol", "\\mathbf"),
    "text_font": ("\\text", "\\mbox", "\\textrm"),
    "unit_font": ("%text_font", "\\mathrm", "\\mathsf", "\\si", "\\unit", "\\rm"),
    # operators and functions
    "minus": ("-", "−"),
    "sign": ("%minus", "–", "+"),
    "times": ("·", "*", "×", "⋅", "\\cdot", "\\times"),
    "times_of_units": ("%times", ".", "∙"),
    "times_or_over": ("%times", "/"),
    "joining": ("%times", "+", "/", "^"),
    "continuing": ("%times", "/", "^", "(", "+", "%minus", "%frac"),
    "joins": ("%minus", "+", "="),
    "frac": characters.FRACTIONS,
    "root": ("\\sqrt", "\\arccos", "\\arcsin", "\\arctan"),
    "wave": ("\\cos", "\\sin", "\\tan"),
    "operation": ("%wave", "%frac", "\\cdot", "\\times", "\\sqrt"),
    "within_sign": ("±", "\\pm"),
    "pose_sign": ("%minus", "±"),
    "equals": ("=",),
    "equality": (
        "=", "==", ":=", "≈", "≃", "≅", "≡", "≜", "≔", "\\approx", "\\simeq", "\\cong", "\\equiv",
        "\\triangleq", "\\coloneqq", "\\doteq",
    ),
    "over_equality": ("\\overset", "\\underset", "\\stackrel"),
    # brackets and stops
    "brace": ("{", "}"),
    "bracket": ("(", ")", "[", "]"),
    "list_end": (")", "]"),
    "entry_end": ("(", ")", "[", "]", ",", "="),
    "word_bracket": ("〖", "〗"),
    "bar": ("|", "‖", "\\|", "\\vert", "\\lvert", "\\rvert", "\\Vert", "\\lVert", "\\rVert"),
    "stop": (".", ":", ";"),
    "quote": (">",),
    "strong": ("**",),
    "hyphen": ("-", "'", "’"),
    # what may stand beside something, or not
    "binding": ("%command", "%latin", "_", "^", "}"),
    "opener": ("=", "(", ",", "&", "+", "-"),
    "begins_term": ("%joins", "(", "[", "{", ",", ";", "&"),
    "name_or_close": ("%name", ")", "]", "}", "'"),
    "name_end": ("%name", "}"),
    "term_end": ("%name", ")", "]", "}", "²", "³"),
    "number_end": tuple(".0123456789"),
    "no_end": ("%digit", "%latin", "_"),
    "goes_on": ("%latin", "_", "{", "^"),
    "in_name": ("%name", "%command", "_", "{", "}"),
    "name_or_power": ("%name", "%high"),
    "bar_or_equals": ("%bar", "%command", "="),
    "head_end": ("%bracket", "=", "&"),
    "beside_equality": ("&", "+", ":", "*", "/", "`", "-", "\\not"),
    "no_result_behind": ("%name_or_power", ".", "^", "_", ","),
    "no_word_before": ("%name_or_power", "^", "{", "/"),
    "no_word_behind": ("%name_or_power", "%mark", "(", "_"),
    "in_formulas": ("%command", *"+*/^·×=∂"),
    "operating": ("%digit", *"+*/·−-)", "\\tan", "\\cot"),
    # letters of quantities
    "state_letter": (
        *(letter + dots for letter in "qQΘθϑ" for dots in ("", "\u0307", "\u0308")),
        "\\theta", "\\vartheta", "\\Theta",
    ),
    "capital": (*"MHDBCVGJNKAYτΛ", "\\tau", "\\phi", "\\Gamma", "\\Lambda"),
    "quantity_letter": ("%latin", "τ", "Λ", "\\tau", "\\phi", "\\Gamma", "\\Lambda"),
    "differentiated": tuple("LTVKUJI"),
    "angle_letter": ("q", "θ", "ϑ", "φ", "\\theta", "\\vartheta", "\\varphi", "\\phi"),
    "turning": ("ω", "α", "\\omega", "\\alpha"),
    "matrix_letter": tuple("ABMHD"),
    "chain_letter": tuple("abxq"),
    # units
    "unit_letter": ("%latin", "µ", "μ"),
    "unit_goes_on": ("%name", "%mark", "%prime", "_"),
    "raised": ("²", "³", "¹"),
    "raised_word": ("\\squared", "\\cubed"),
}  # fmt: skip
"""Classes by their texts, and by kinds and other classes behind a %. %any is every lexeme but the
end of a line, %not_x one that is not x; %bare_letter has no marks, and %dotted_letter has dots."""

PATTERNS = {
    "group": "{ %not_brace{0,30} }",
    "nested": "{ < @group | %not_brace >{0,40} }",
    "content": "< @nested | %not_brace >",
    "d": "< d | \\mathrm { d } | \\mathrm d >",
    "squared": "< ^ { 2 } | ^ 2 | ² >",
    "roman_T": "< T | %upright < T | { T } > >",
    "subscript": "_ < @group | %name >",
    "symbol": "< %font { < %command | %latin{1,8} > } | %greek_command | %plain_letter >"
    " < @subscript | < ~%digit | ~%low_digit >{1,2} >?",
    "typed": "%letter < ~%name | ~_ >{0,12} < ~@group >?",
    "differentiable": "< @symbol | @typed >",
    "within": "< ( %not_bracket{0,60} ) | %not_bracket >{1,120}",
    "aligning": "< \\notag | \\label | \\tag | eq >",
    "name_of_sympy": "%letter < ~%name | ~_ >{0,24}",
    "of_time": "( t )",
    "below": "< ~_ ~{? >? ~%digit{1,2} ~}?",
    "by_time": "{ @d t @squared? }",
    "asterisk": "^ < { %star } | %star >",
    "number": "mantissa:< %digit ~%digit{0,60} < ~. decimals:~%digit{0,60} >?"
    " | . decimals:~%digit{1,60} >"
    " < < ~e | ~E > exponent:< < ~+ | ~- >? ~%digit{1,60} > >?",
    "word": "%bare_letter ~%bare_letter{1,40}",
    "words": "!-%no_word_before !-_ @word < ~%hyphen ~%bare_letter{1,40} >{0,9} !~%no_word_behind",
    "decimal": "< %digit ~%digit{0,30} < ~. ~%digit{1,30} >? | . ~%digit{1,30} >"
    " < < ~e | ~E > < ~+ | ~- >? ~%digit{1,3} >?",
    "result_number": "< %digit ~%digit{0,30} < ~. ~%digit{0,30} | ~, ~%digit{1,30} >?"
    " | . ~%digit{1,30} > < < ~e | ~E > < ~+ | ~- >? ~%digit{1,3} >?",
    "pi": "< \\pi | pi | π >",
    "value": "%sign? < @decimal | @pi | %frac { %not_brace{1,12} } { %not_brace{1,12} } >"
    " < %times_or_over < @decimal | @pi > | @pi >{0,9}",
    "unit_letters": "< %command | %unit_letter ~%unit_letter{0,30} >",
    "tolerance": "< %within_sign | +/- | +- >"
    " within:< %digit ~%digit{0,30} < ~. ~%digit{0,30} >? >?",
    "keyword": "< at | for | when | where | with | if >",
    "still": "< in < static | equilibrium > | held >",
    "at_rest": "still:< < In | in >? static? equilibrium | < Held | held > < still | at rest > >"
    " | at? rest",
    "unconditioned": "< In | in > < general | motion > | Generally | Otherwise"
    " | < For | for > < all | any | every | arbitrary >",
    "condition": "--%term_end %line? %apart < @keyword %apart | @still >",
    "angle": "name:< < \\theta | theta | θ | q | d > ~_? {? < %digit | %low_digit > }? >",
    "other_angle": "< \\theta | theta | θ | q | d > ~_? {? < %digit | %low_digit > }?",
    "and_of_poses": "< , | or | and | \\text { < or | and > } >{1,4}",
    "degrees": "< ° | deg | degree | degrees | { \\circ } >",
    "pose_value": "sign:%pose_sign? < %frac { above:%digit{0,2} @pi } { below:%digit{1,2} }"
    " | < number:@decimal pi:@pi? | pi:@pi > < / parts:%digit{1,2} >? degrees:@degrees? >",
    "pose_values": "values:< @pose_value < @and_of_poses @pose_value >{0,9} >",
    "number_ends": "!< ~ < %name | . > >",
    "inverse": "< ⁻ ¹ | ^ %minus 1 | ^ { %minus 1 } >",
    "state": "< < %dotting {? >{0,3} %state_letter < ~_? ~d ~d? < ~o ~t >? >? }{0,2}"
    " | d ~d? ~%state_letter >",
    "states": "( < t | @state > < , @state >{0,9} )",
    "several_states": "( < t | @state > < , @state >{1,9} )",
    "marked": "< _ < { %not_brace{1,6} } | %name > | ~%counted{1,2} >? @inverse? ᵀ?",
    "capital": "< %around_letter { %capital } | %capital >",
    "lettered": "< %around_letter { %latin } | < tau | phi | Gamma | Lambda > | %quantity_letter >",
    "two_valued": "< < \\operatorname | \\mathrm > { >? < %root | sqrt"
    " | acos | asin | atan | arccos | arcsin | arctan | < %wave | cos | sin | tan > ^ >",
    "before_frame": "< %first | --%opener | < !-%name_or_close | -R > { } >",
    "frame": "< ^ < { frame:%digit } | frame:%digit > | frame:%high_digit >",
    "framed": "!%operation < %accent < { %not_brace{1,30} } | %command | %letter > | %command"
    " | %letter >",
    "frame_index": "< _ < @nested | %name > | %low_digit{1,4} >",
    "sum_sign": "< \\sum | ∑ | Σ | %fresh < sum | Sum > &< ( | _ > | \\operatorname { sum } >"
    " \\limits?",
    "sum_index": "index:< i | j | k >",
    "sum_index_low": "index:< ᵢ | ⱼ >",
    "sum_below": "< _ { @sum_index < = %digit{1,2} >? } | _ ~@sum_index | @sum_index_low >",
    "sum_above": "^ < { < %digit{1,2} | n | N > } | %digit | n | N >",
    "sum_arguments": ", < @sum_index = first:%digit{1,2} . . < last:%digit{1,2} | n | N >"
    " | (? @sum_index , first:%digit{1,2} , < last:%digit{1,2} | n | N > )? >",
    "round": "( %not_entry_end{0,60} )",
    "entry": "< ( < @round | %not_entry_end >{0,60} ) | %not_entry_end >{1,200}",
    "listed": "@entry < , @entry >{1,9}",
    "force_number": "F _? < { %counted } | %counted | %low_digit >",
}
"""Parts of patterns that have names."""
