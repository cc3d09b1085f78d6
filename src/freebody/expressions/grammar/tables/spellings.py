"""The table of spellings: patterns of formulas, each with the standard spelling that replaces it,
in the order of application.

In what is put, $name is what the pattern kept by that name, plain($name) its figures on the line,
frame($name) the frame that they tell, #determinant the mark of a determinant, and ␣ a blank.
"""

from freebody.expressions.grammar.tables.characters import TOTAL

LABEL = "label"
"""Said of a spelling where what is left out belongs to no label."""

SPELLINGS: tuple[tuple[str, ...], ...] = (
    # \\boxed{…} around an equation, and an equals sign with something over it.
    ("\\boxed { of:< @content{1,60} > }", "$of", LABEL),
    ("%over_equality { %not_brace{1,12} } { = }", "="),
    # np.cos, sp.diff, and th1.diff(t), th1.diff(t, 2), L.diff(th1) of SymPy.
    ("%fresh < np | numpy | sp | sympy | sm | math > ~. &~%latin", ""),
    ("%fresh name:@name_of_sympy @of_time? ~. ~diff ~(", "d i f f ( $name ,"),
    # ± in front of a function of two values: each is looked at.
    ("< ± | \\pm > &< %digit{0,2} %times? < @two_valued | √ > >", "+"),
    ("√", "\\sqrt"),
    # dL/dθ1, as one types ∂L/∂θ1, and \\frac{dJ}{d\\theta_1}.
    ("%fresh d of:~%differentiated / d !< t %ends > &~%letter", f"{TOTAL} $of / {TOTAL}"),
    ("%frac { @d of:< @content{1,30} > } { @d by:< %angle_letter @subscript? > }",
     f"{TOTAL} $of / {TOTAL} $by"),
    # |v_c2|².
    ("%bar of:< %not_bar_or_equals{1,12} > %bar &< ² | ^ {? 2 >", "$of"),
    # ω2 x r2, as one types it.
    ("--) %apart x %apart &(", "×"),
    ("of:< < omega | alpha | %turning > _? {? %figure? }? > %apart x %apart &< %latin | ( >",
     "$of ×"),
    # J^{-T}, J^T.
    ("^ { %minus < T | \\top | 1 < \\top | T > > }", "⁻ ¹ ᵀ"),
    ("^ < T %ends | \\top | \\intercal | { < @roman_T | \\top | \\intercal > } >", "ᵀ"),
    # J.T @ F of NumPy, transpose(J).
    ("--%term_end ~. ~T %ends", "ᵀ"),
    ("%fresh transpose ( of:%name{1,4} )", "( $of ) ᵀ"),
    # \\arctan2 and SymPy's \\operatorname{atan_{2}}.
    ("\\arctan ~2 &(", "a t a n 2"),
    ("\\operatorname { < a t a n | atan > _ { 2 } } { of:< %not_brace{1,300} | @nested >{1,9} }",
     "a t a n 2 $of"),
    # θ ̈_1 and (θ_1 ) ̈, as Word writes θ̈_1 on one line.
    ("( letter:%letter rest:< _? %digit? > ) %apart dots:%mark below:@below?",
     "$letter $dots $rest $below"),
    ("%fresh letter:%letter %apart dots:%mark below:@below?", "$letter $dots $below"),
    # Word's brackets; around a function they say nothing.
    ("〖 of:< sin | cos | tan > 〗", "$of"),
    ("〖 of:< %not_word_bracket{1,200} > 〗", "( $of )"),
    ("^ < { \\circ } | \\circ > | \\degree", "°"),
    # Numbers of siunitx.
    ("< \\SI | \\qty > { number:< %not_brace{1,30} > } { unit:< %not_brace{1,60} > }",
     "$number ␣ $unit"),
    ("< \\SI | \\qty > { number:< %not_brace{1,30} > }?", "$number"),
    ("\\ang { number:< %not_brace{1,30} > }", "$number °"),
    # 2.5·10⁻³ is 2.5e-3.
    ("--%number_end %times 1 ~0 ^ { sign:%minus? digits:%digit{1,2} } @number_ends",
     "e plain($sign) $digits"),
    ("--%number_end %times 1 ~0 ^ sign:%minus? digits:%digit{1,2} @number_ends",
     "e plain($sign) $digits"),
    ("--%number_end %times 1 ~0 digits:< ⁻? %high_digit{1,2} > @number_ends", "e plain($digits)"),
    # {}^1v_2 and {}^2_1R, Craig's letters with a frame.
    ("@before_frame @frame _ < { low:%digit } | low:%digit > R !@frame_index",
     "R _ { plain($frame) $low }"),
    ("@before_frame @frame name:@framed index:@frame_index?", "$name $index frame($frame)"),
    ("{ }", ""),
    # H[1,2], tau[1], M(1,2), M_1,2, counted from 1.
    ("%fresh !-} name:< %command | %plain_letter ~%latin{0,20} > ~[ i:%counted < , j:%counted >? ]",
     "$name $i $j"),
    ("%fresh !-} name:< %command | %plain_letter ~%latin{0,20} > ~( i:%counted , j:%counted )",
     "$name $i $j"),
    ("%fresh !-} name:< %command | %plain_letter ~%latin{0,20} > ~_ i:~%counted ~, j:~%counted &=",
     "$name $i $j"),
    # The argument of a function of time, as SymPy sets it in LaTeX.
    ("--%name_end { ( t ) }", ""),
    # {\\theta}_2, {\\dot{\\theta}}_{2}.
    ("!-%binding { of:< %command < @group | %command >? | %plain_letter > } index:@subscript",
     "$of $index"),
    # \\frac{d^2 \\theta_1}{dt^2}, \\frac{d}{dt} \\theta_1, d²θ1/dt².
    ("%frac { @d @squared name:@differentiable } @by_time", "\\ddot { $name }"),
    ("%frac { @d name:@differentiable } @by_time", "\\dot { $name }"),
    ("%frac { @d ( of:@within ) } @by_time", "∂ / ∂ t ( $of )"),
    ("%frac { @d @squared } @by_time name:@symbol !< ~ %goes_on >", "\\ddot { $name }"),
    ("%frac { @d } @by_time name:@symbol !< ~ %goes_on >", "\\dot { $name }"),
    ("%fresh d < ^ 2 | ² | 2 ~ &%letter | ~d > name:@differentiable / dt < ^? 2 | ² > %ends",
     "\\ddot { $name }"),
    ("%fresh d ~d name:@typed / dt %ends !< ^ | ² >", "\\ddot { $name }"),
    ("%fresh d name:@differentiable / dt %ends !< ^ | ² >", "\\dot { $name }"),
    ("%fresh d ( of:@within ) / dt %ends !< ^ | ² >", "∂ / ∂ t ( $of )"),
    # Derivative(theta1(t), (t, 2)) = …, as SymPy prints it.
    ("%fresh < Derivative | diff > ( name:@name_of_sympy @of_time? ,"
     " < t , < 2 | t > | ( t , 2 ) > ) &< &? = >", "\\ddot { $name }"),
    ("%fresh < Derivative | diff > ( name:@name_of_sympy @of_time? , < t | ( t , 1 ) > ) &< &? = >",
     "\\dot { $name }"),
    # \\frac{\\partial L}{\\partial \\dot{\\theta}_1}.
    ("%frac { \\partial of:< @content{0,30} > } { \\partial by:< @content{1,40} > }",
     "∂ $of / ∂ $by"),
    # \\frac{d^2}{dt^2}, \\frac{d}{dt} and d/dt of what follows.
    ("%frac { @d @squared } @by_time", "∂ / ∂ t ∂ / ∂ t"),
    ("%frac { @d } { @d t }", "∂ / ∂ t"),
    ("%fresh d / dt %ends", "∂ / ∂ t"),
    # M(q), C(q, q̇). A small letter behind another factor, as in m g(q), may be a factor too.
    ("%fresh name:< @capital @marked > @states", "$name", LABEL),
    ("%fresh name:< @lettered @marked > @several_states", "$name", LABEL),
    ("< %first | --%begins_term > name:< @lettered @marked > @states", "$name", LABEL),
    ("%fresh name:< @lettered @marked > @states &< &? < = | %last > >", "$name", LABEL),
    # |J|, det J, det(J_P) in front of an equals sign.
    ("%fresh %bar J %bar &< &? < = | %last > >", "J #determinant"),
    ("%fresh < \\det | det > (? J _ {? P }? )? &< &? < = | %last > >", "d e t J"),
    ("%fresh < \\det | det > (? J < ~_? {? letter:%chain_letter }? >? )? &< &? < = | %last > >",
     "d e t J $letter"),
    ("%fresh < \\det | det > (? letter:%matrix_letter )? &< &? < = | %last > >", "d e t $letter"),
    # |x|.
    ("%bar of:< %not_bar{1,60} > %bar", "a b s ( $of )"),
    # Kane's F_1*, F₁*, F^*_1: a number follows where * multiplies.
    ("%fresh name:@force_number < @asterisk | ~* &< = | + | %last | %minus < %apart | %last > > >",
     "$name '"),
    ("%fresh F @asterisk _ {? number:%digit }?", "F $number '"),
    # A vector as (x, y)ᵀ, or as (x, y) where it is a whole side.
    ("!-%name_or_close ( of:@listed ) ᵀ", "[ $of ]"),
    ("< --= | %first > ( of:@listed ) &< < . | , >? %last >", "[ $of ]"),
)  # fmt: skip
