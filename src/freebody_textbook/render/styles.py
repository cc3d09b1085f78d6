"""Styles of pages of derivations: everywhere, of marked terms, of the panel that can be tried, on
paper, in narrow windows and under fingers.

Paper is A4 or Letter; `freebody.outputs.pages.SHEETS` has the styles of all pages there.
"""

from freebody.outputs.pages import edged

PAGE = """
body{font:17px/1.6 system-ui,sans-serif;margin:0;color:#1b2430;
--paper:#fff;background:var(--paper)}
main{max-width:60rem;margin:0 auto;padding:2rem 1.2rem 4rem}
h1{font-size:1.9rem;line-height:1.25}
h2{font-size:1.2rem;margin:2.4rem 0 .3rem}h2 span{color:#8a94a3;margin-right:.4em}
summary{cursor:pointer}section>details>summary{margin:2.4rem 0 .3rem}summary h2{display:inline}
h2 .notes{font-weight:400;color:#5a6675;font-size:.85rem;margin-left:.4em}
p{max-width:44rem}.equations{overflow-x:auto;padding:.3rem 0}
.result{border:1.5px solid #8a94a3;border-radius:.4rem;padding:.8rem;margin-top:.8rem}
.symbols{border-collapse:collapse;font-size:.92rem;margin:1rem 0}
.symbols td{padding:.12rem 1.2rem .12rem 0;vertical-align:baseline}
.symbols td:last-child,.symbols span{white-space:nowrap}
math{font-size:1.2rem}p math,td math{font-size:1.1em}
figure{margin:1rem 0;text-align:center}figure svg{max-width:100%;height:auto}
.source{color:#5a6675;font-size:.9rem;margin-top:3rem}
@media screen and (prefers-color-scheme:dark){body{color:#e4e9f0;--paper:#14181e}
.source,h2 .notes{color:#9aa6b5}}
"""
"""The style of a page of a derivation, whatever it is shown on."""

TERMS = """
.term-time{color:#1d4fc4;border-bottom:.07em solid}
.term-kinetic{color:#b0480a;border-bottom:.09em dashed}
.term-potential{color:#1f7a36;border-bottom:.11em dotted}
.term-several{border-bottom:.2em double}
.sources{font-size:.92em;color:#5a6675}
@media screen and (prefers-color-scheme:dark){.term-time{color:#8ab4ff}
.term-kinetic{color:#ffa765}.term-potential{color:#74cf8a}.sources{color:#9aa6b5}}
"""
"""The style of terms by where they came from: each source has a colour and a kind of line, so that
print without colour shows it too."""

PANEL = """
.try{border:1px solid #c9d0d8;border-radius:.5rem;padding:.2rem 1rem;margin:1.5rem 0;
font-size:.9rem}
.try h2{margin:.6rem 0}.stage{position:relative;max-width:34rem}
.stage canvas{display:block;width:100%;touch-action:pan-y}.view canvas{aspect-ratio:6/5}
.stage svg{position:absolute;inset:0;width:100%;height:100%;pointer-events:none;background:none}
.try summary{padding:.3rem 0}
.slider{display:flex;gap:.6rem;align-items:center;margin:.15rem 0}
.slider label{min-width:2.4rem}.which label{min-width:6.2rem}
.slider input{flex:1;min-width:4rem}.slider span{min-width:7.5rem}
.values{color:#5a6675;font-size:.95rem;overflow-x:auto}.value{margin:.15rem 0;max-width:none}
.value math,.slider math{font-size:1.05rem}.value math{math-style:normal}
.value output{color:#b01e5c}
.hidden .equations,.hidden .sources,.hidden .values,details:not(.hidden)>.questions{display:none}
.answer{margin:.6rem 0}.answer p{margin:.2rem 0;overflow-wrap:anywhere}
.answer.right p{color:#2b7a3d}
.answer input{font:inherit;width:24rem;max-width:90%}
@media screen and (min-width:48rem){.living:has(>.try:not([hidden]))>figure{display:none}}
@media screen and (min-width:48rem) and (max-width:79.99rem){.try{max-height:45vh;overflow-y:auto}
.living .try{display:grid;
grid-template-columns:1fr 1fr;gap:0 2rem}.living .try h2{grid-column:1/3}
.living .drawn{position:sticky;top:0;align-self:start}}
@media screen and (min-width:80rem){.living{margin-right:25rem}
.drawn{display:contents}.view{position:sticky;top:0;background:var(--paper);z-index:1}
.try{position:fixed;top:1rem;right:1rem;width:21rem;margin:0;max-height:calc(100vh - 3rem);
overflow-y:auto}}
@media screen and (min-width:82rem){.living{margin-right:27rem}.try{width:23rem}}
@media screen and (prefers-color-scheme:dark){.try{border-color:#48525e}.values{color:#9aa6b5}
.value output{color:#ff86b3}.answer.right p{color:#74cf8a}}
.try[hidden],.try[hidden]~section .values{display:none}
"""
"""The style of the panel that can be tried and of the values; wide windows have the panel beside
the steps."""

ROWS = """
@media print{math[display=block]:has(>.aligned){display:block!important}
math:not(:has(>.aligned>mtr:nth-child(5))){break-inside:avoid}
.aligned{display:grid;grid-template-columns:max-content max-content;justify-content:safe center}
.aligned>mtr{display:grid;grid-column:1/-1;grid-template-columns:subgrid;align-items:baseline;
break-inside:avoid}
.aligned>mtr>mtd{display:block math}.aligned>mtr>mtd:first-child{justify-self:end}}
"""
"""The style of printed equations: sheets end between rows, which are those of a grid. They would
end between rows of a table too, but Chromium then forgets their baselines; and within a formula
they never do."""

STEPS = """
@media print{body{font-size:10pt;line-height:1.4}main{max-width:none;padding:0}
h1{font-size:17pt;margin:0}h2{font-size:11.5pt}section>details>summary{margin:1.1rem 0 .1rem}
details::details-content{content-visibility:visible}
main>details>summary{display:none}
p{max-width:none;margin:.3rem 0;break-inside:avoid}math{font-size:1.1em}
.equations{overflow:visible;padding:0}.equations math{font-size:13.8px}
.result{padding:.2rem .6rem;margin-top:.4rem;box-decoration-break:clone}
.result:not(:has(>math>mtable>mtr:nth-child(16))){break-inside:avoid}
figure{margin:.3rem 0;break-inside:avoid}figure svg{max-height:7cm}
.symbols{font-size:.92em;margin:.4rem 0}.symbols td{padding:0 1rem 0 0}tr{break-inside:avoid}
.symbols tbody{display:grid;grid-template-columns:fit-content(50%) auto auto;justify-content:start}
.symbols tr{display:grid;grid-column:1/-1;grid-template-columns:subgrid;align-items:baseline}
summary,section p:not(.sources){break-after:avoid}section figure{break-before:avoid}
section:has(figure):not(:has(:not(.short)>math>.aligned>mtr:nth-child(6))){break-inside:avoid}
section p:has(+.equations){padding-bottom:3.5em;margin-bottom:-3.3em}
.result+*{break-before:avoid}
.equations>math:last-child>.aligned>mtr:last-child{padding-bottom:var(--kept,1.6em)}
.equations{margin-bottom:calc(.1em - var(--kept,1.6em))}.equations:has(+.sources){--kept:4.2em}
.equations.result{--kept:.1em}
.source{font-size:.92em;margin-top:.8rem;break-before:avoid}}
"""
"""The style of a printed page of a derivation. A text keeps room below it, in which two rows stand,
the last row room for its legend and values: told to stay together, Chromium moved whole steps to
the next sheet. Only a short step with a figure stays together: its lines are read beside it."""

STATE = """
@media print{.try{border:0;padding:0;margin:.6rem 0;font-size:.92em}
.try h2,.try .drawn,.try p:not(.slider),.try input{display:none}
.try::before{content:"The values below equations are in SI units, at: "}
.try div,.try details,.try summary,.slider,.value{display:inline}
.try details::details-content{display:inline;content-visibility:visible}
.try summary::after{content:": "}.slider label::after{content:" = "}
.slider label[title]::after{content:" (" attr(title) ") = "}
.slider:not(:last-child)::after{content:", "}.try details:last-of-type::after{content:"."}
details:not(:last-of-type) .slider:last-child::after,.value:not(:last-child)::after{content:"; "}
.values{font-size:.92em;overflow:visible}
.value math,.slider math{font-size:1.05em}.value output{color:inherit}}
"""
"""The style of the panel, which is printed as the state that its sliders are in, and of the
values."""

SCROLLED = edged(".equations,.formula,.values,.card pre,.card figure,.solution>math")
"""The style of formulas, drawings and code that can be wider than the window."""

TOUCHED = """
.short{display:none}
@media screen and (max-width:40rem),screen and (pointer:coarse){
.try summary,.card summary{padding:.45rem 0}.slider{min-height:2.2rem}.slider input{height:2rem}
.try button,.answer button,.questions button{font:inherit;min-height:2.6rem;padding:.3rem .8rem}
.try [type=checkbox]{width:1.4rem;height:1.4rem;vertical-align:-.3rem}.try label{padding:.3rem 0}
.answer input{min-height:2.6rem;font-size:1rem}}
@media screen and (max-width:40rem){summary,h1,h4{text-wrap:balance}.notes{display:inline-block}
p,li,h1,.source{overflow-wrap:break-word}.equations math{font-size:1rem}
.short{display:block}.short+div{display:none}
.values{display:flex;flex-wrap:wrap;gap:0 1.4rem}
.answer label{display:flex;align-items:center;gap:.3rem}
.answer input{flex:1;min-width:0;box-sizing:border-box}
.symbols,.symbols tbody,.symbols tr{display:block}.symbols tr{padding:.15rem 0 .15rem 3.6rem;
text-indent:-3.6rem}.symbols tr td{display:inline;padding:0}
.symbols tr td:first-child{display:inline-block;min-width:3.6rem;padding-right:.5rem;text-indent:0;
box-sizing:border-box}
.symbols tr td:first-child:has(>span:nth-of-type(8)){display:inline}
.symbols td:last-child:not(:empty)::before{content:" ["}
.symbols td:last-child:not(:empty)::after{content:"]"}
.try .slider span{min-width:6.6rem}.try .slider label{min-width:2rem}}
@media screen and (max-width:40rem) and (min-height:36rem){.try .view{position:sticky;top:0;
z-index:1;background:var(--paper)}}
"""
"""The style of the parts that all pages with steps share, in narrow windows and under fingers:
targets as large as a finger, values side by side, the table of symbols as lines, the drawing in
sight while sliders are moved."""

NARROW = """
@media screen and (max-width:40rem){main{padding:1rem .9rem 3rem}h1{font-size:1.55rem}
.result{padding:.6rem .4rem}figure{margin:1rem -.9rem}.try{padding:.2rem .7rem}
h2,section>details>summary{margin-top:1.8rem}}
"""
"""The style of a page of a derivation in narrow windows."""
