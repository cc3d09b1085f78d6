"""Styles of pages in narrow windows and under fingers."""

_SHADE = "linear-gradient({},#5a7fb8b0,#5a7fb800) {} 0 top 0/.9rem 100%"
_COVER = "linear-gradient({},var(--paper) 40%,#0000) {} -1px top 0/2.6rem 100% local"
_EDGES = (("90deg", "left"), ("270deg", "right"))
_LAYERS = ",".join(form.format(*edge) for form in (_COVER, _SHADE) for edge in _EDGES)
SCROLLED = f"""
@media screen{{.equations,.formula,.values,
.card pre,.card figure,.solution>math{{background:{_LAYERS} var(--paper);
background-repeat:no-repeat}}}}
"""
"""Of what can be wider than the window: a shaded edge as long as something is hidden behind it. The
shades stand still, the covers above them, of the colour of the page, scroll with the content."""

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
@media screen and (max-width:40rem) and (min-height:36rem){.try #arm{position:sticky;top:0;
z-index:1;background:var(--paper)}}
"""
"""Of the parts that all pages with steps share: targets as large as a finger, values side by side,
the table of symbols as lines, the drawing in sight while sliders are moved."""

NARROW = """
@media screen and (max-width:40rem){main{padding:1rem .9rem 3rem}h1{font-size:1.55rem}
.result{padding:.6rem .4rem}figure{margin:1rem -.9rem}.try{padding:.2rem .7rem}
h2,section>details>summary{margin-top:1.8rem}}
"""
"""Of a page of a derivation alone."""
