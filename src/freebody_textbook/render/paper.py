"""Styles of pages on paper, A4 or Letter; `outputs.page.SHEETS` has those of all pages."""

ROWS = """
@media print{math[display=block]:has(>.aligned){display:block!important}
math:not(:has(>.aligned>mtr:nth-child(5))){break-inside:avoid}
.aligned{display:grid;grid-template-columns:max-content max-content;justify-content:safe center}
.aligned>mtr{display:grid;grid-column:1/-1;grid-template-columns:subgrid;align-items:baseline;
break-inside:avoid}
.aligned>mtr>mtd{display:block math}.aligned>mtr>mtd:first-child{justify-self:end}}
"""
"""Of equations: sheets end between rows, which are those of a grid. They would end between rows of
a table too, but Chromium then forgets their baselines; and within a formula they never do."""

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
summary,section p:not(.sources){break-after:avoid}
section p:has(+.equations){padding-bottom:3.5em;margin-bottom:-3.3em}
.result+*{break-before:avoid}
.equations>math:last-child>.aligned>mtr:last-child{padding-bottom:var(--kept,1.6em)}
.equations{margin-bottom:calc(.1em - var(--kept,1.6em))}.equations:has(+.sources){--kept:4.2em}
.equations.result{--kept:.1em}
.source{font-size:.92em;margin-top:.8rem;break-before:avoid}}
"""
"""Of a page of a derivation. A text keeps room below it, in which two rows stand, the last row room
for its legend and values: told to stay together, Chromium moved whole steps to the next sheet."""

STATE = """
@media print{.try{border:0;padding:0;margin:.6rem 0;font-size:.92em}
.try h2,.try .drawn,.try p:not(.slider),.try input{display:none}
.try::before{content:"The values below equations are in SI units, at: "}
.try div,.try details,.try summary,.slider,.value{display:inline}
.try details::details-content{display:inline;content-visibility:visible}
.try summary::after{content:": "}.slider label::after{content:" = "}
.slider:not(:last-child)::after{content:", "}.try details:last-of-type::after{content:"."}
details:not(:last-of-type) .slider:last-child::after,.value:not(:last-child)::after{content:"; "}
.try[hidden],.try[hidden]~section .values{display:none}
.values{font-size:.92em;overflow:visible}
.value math,.slider math{font-size:1.05em}.value output{color:inherit}}
"""
"""Of the panel, which is printed as the state that its sliders are in, and of the values."""
