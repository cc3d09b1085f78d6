"""What makes a page of a derivation one that can be tried: pieces of HTML, and one script."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from freebody_textbook.derivation import Step


@dataclass(frozen=True)
class LivingParts:
    """HTML of the panel with the drawing and its sliders, of the values below each step's
    equations, and the text of the page's only script."""

    panel: str
    below: Mapping[Step, str]
    script: str


STYLE = """
.try{border:1px solid #c9d0d8;border-radius:.5rem;padding:.2rem 1rem;margin:1.5rem 0;
font-size:.9rem}
.try h2{margin:.6rem 0}.try svg{display:block;width:100%;max-width:34rem}
.try summary{padding:.3rem 0}
.slider{display:flex;gap:.6rem;align-items:center;margin:.15rem 0}
.slider label{min-width:2.4rem}.view label{min-width:6.2rem}
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
.drawn{display:contents}#arm{position:sticky;top:0}
.try{position:fixed;top:1rem;right:1rem;width:21rem;margin:0;max-height:calc(100vh - 3rem);
overflow-y:auto}}
@media screen and (min-width:82rem){.living{margin-right:27rem}.try{width:23rem}}
@media screen and (prefers-color-scheme:dark){.try{border-color:#48525e}.values{color:#9aa6b5}
.value output{color:#ff86b3}.answer.right p{color:#74cf8a}}
"""
"""Of the panel and the values; wide windows have the panel beside the steps."""
