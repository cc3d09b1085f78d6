"""Colours of the figures, light and dark, and the style sheet that holds them."""

from __future__ import annotations

SERIES = 8
"""Number of distinct colours for curves."""

_MAP = ["440154", "46327e", "365c8d", "277f8e", "1fa187", "4ac16d", "a0da39", "fde725"]
"""Colours of maps, from low to high, on light and dark paper: viridis, whose lightness grows
evenly."""
MAP = len(_MAP)
"""Number of distinct colours of a map."""

FORCES = {
    "reaction": "reaction",
    "counter": "reaction",
    "weight": "weight",
    "external": "external",
    "moment": "moment",
}
"""The colour, one of those below, of what acts on a body, by its role (`body_loads.Load`)."""

_PALETTE = {
    "paper joint": "#ffffff #14181e", "ink position": "#1c2430 #e8ecf1",
    "soft dimension": "#66707d #9aa5b1", "faint": "#c9d0d8 #48525e", "hair": "#e6eaee #2a313a",
    "link": "#dfe6ee #2d3947", "link-edge": "#4a5a6e #9db0c6", "link-far": "#eff3f6 #20272f",
    "link-far-edge": "#9aa7b5 #5d6b7a", "joint-side": "#9fb2c8 #53677e",
    "ghost": "#c3cdd8 #3b4754", "shadow": "#e4e8ec #20262d", "path external": "#c2560a #f2a15f",
    "reaction z s0": "#1459b8 #7db0ff", "moment s3": "#b01e5c #ff86b3",
    "weight y": "#2b7a3d #74cf8a", "inertia": "#7d8792 #8b96a3", "velocity": "#0b7d8c #55d0e0",
    "acceleration s4": "#7048c6 #b79cff", "solid": "#edf1f5 #232b35", "x": "#c22f2f #ff8a80",
    "shell": "#b9c6d6 #71839a", "hub": "#3d6ea8 #6d9fdc",
    "limit": "#b3261e #ff8a80", "s1": "#d1600a #f2a15f", "s2": "#1b8a5a #5fd3a0",
    "s5": "#0f8ea6 #5ccfe6", "s6": "#8a6a00 #d9bd55", "s7": "#5b6672 #a7b2be",
}  # fmt: skip
"""Names, and their colour in the light and in the dark."""
_LIGHT, _DARK = (
    {name: pair.split()[k] for names, pair in _PALETTE.items() for name in names.split()}
    for k in (0, 1)
)

_RULES = """
.fig{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif}
.fig text{fill:@ink;font-size:13px}
.fig{background:@paper}
.fig .halo{stroke:@paper;stroke-width:4px;stroke-linejoin:round;paint-order:stroke}
.fig .v{font-style:italic}.fig .n{fill:@soft;font-size:12px}.fig .num{font-size:12px}
.fig .guide{fill:none;stroke:@soft;stroke-width:1;stroke-dasharray:5 4}
.fig .grid{fill:none;stroke:@hair;stroke-width:1}
.fig .shadow{fill:none;stroke:@shadow;stroke-width:7;stroke-linecap:round;stroke-linejoin:round}
.fig .ghost{fill:none;stroke:@ghost;stroke-width:2.5;stroke-linecap:round;stroke-linejoin:round}
.fig .locus-first{fill:none;stroke:@z;stroke-width:1.6}
.fig .locus-second{fill:none;stroke:@x;stroke-width:1.6}
.fig .tippath{fill:none;stroke:@path;stroke-width:1.6}.fig .tipdot{fill:@path}
.fig .edge{fill:none;stroke:@link-edge;stroke-linecap:round;stroke-linejoin:round}
.fig .bar{fill:none;stroke:@link;stroke-linecap:round;stroke-linejoin:round}
.fig .far .edge{stroke:@link-far-edge}.fig .far .bar{stroke:@link-far}
.fig .side{fill:@joint-side;stroke:@link-edge;stroke-width:1.2;stroke-linejoin:round}
.fig .cap{fill:@joint;stroke:@link-edge;stroke-width:1.2;stroke-linejoin:round}
.fig .spot{fill:@joint}
.fig .far .side{fill:@link;stroke:@link-far-edge}.fig .far .cap{stroke:@link-far-edge}
.fig .pin{fill:@joint;stroke:@link-edge;stroke-width:2}
.fig .rail{fill:none;stroke:@link-edge;stroke-width:2}
.fig .hatch{fill:none;stroke:@soft;stroke-width:1.3}
.fig .com{fill:@paper;stroke:@ink;stroke-width:1.2}.fig .comq{fill:@ink}
.fig .leader{fill:none;stroke:@faint;stroke-width:1}
.fig .angle{fill:none;stroke:@soft;stroke-width:1.3}.fig .angle-head{fill:@soft}
.fig .frame{fill:none;stroke:@faint;stroke-width:1}.fig .axis{fill:none;stroke:@soft;stroke-width:1}
.fig .tick{fill:@soft;font-size:11px}.fig .unit{fill:@soft;font-size:11px}
.fig .curve{fill:none;stroke-width:1.7;stroke-linejoin:round}
.fig .faint{stroke-width:1;stroke-opacity:.5}
.fig .peak{stroke:@paper;stroke-width:1.2}
.fig .limit{fill:none;stroke:@limit;stroke-width:1.2;stroke-dasharray:6 3}
.fig .now{fill:none;stroke:@soft;stroke-width:1;stroke-dasharray:2 3}
.fig .name{font-size:13px;font-weight:600}
.fig .f{font-family:"STIX Two Text","Cambria Math",Cambria,"Times New Roman","Liberation Serif",
serif;font-size:15px}
.fig .f .num{font-family:system-ui,-apple-system,"Segoe UI",Roboto,Arial,sans-serif}
.fig .l{font-size:70%}
.fig .f .r{font-style:normal}.fig .f .b{font-weight:700}
.fig .solid{fill:@solid;stroke:@link-edge;stroke-width:1.6;stroke-linejoin:round}
.fig .curveline{fill:none;stroke:@link-edge;stroke-width:2}
.fig .contour{fill:none;stroke:@paper;stroke-width:1}
.fig .contour-text{fill:@ink;font-size:11px;font-weight:600;stroke:@paper;stroke-width:3.5px;
stroke-linejoin:round;paint-order:stroke}
.fig .stick{fill:none;stroke:@link-edge;stroke-width:5;stroke-linecap:round}
.fig .joint{fill:@paper;stroke:@link-edge;stroke-width:1.5}
.fig .axisline{fill:none;stroke:@soft;stroke-width:1;stroke-dasharray:9 3 2 3}
"""
_ARROWS = (
    "reaction", "moment", "weight", "external", "inertia", "velocity", "acceleration", "position",
    "x", "y", "z", "soft", "dimension",
)  # fmt: skip
_WIDTHS = {"x": "1.6", "y": "1.6", "z": "1.6", "position": "1.8", "dimension": "1", "soft": "1.4"}


def style(dark: str = "@media (prefers-color-scheme:dark)") -> str:
    """The style sheet: light colours, and dark ones under the given media rule."""
    return _sheet(_LIGHT) + f"{dark}{{{_colours_only(_DARK)}}}\n"


def page_colours(dark: bool) -> dict[str, str]:
    """The palette, light or dark, for the page around the figures."""
    return dict(_DARK if dark else _LIGHT)


def variables(dark: str = "@media screen and (prefers-color-scheme:dark)") -> str:
    """The palette as variables of a page, for what its script draws: light, and dark under the
    given media rule."""
    light, black = (
        "".join(f"--{name}:{colour};" for name, colour in page_colours(is_dark).items())
        for is_dark in (False, True)
    )
    return f":root{{{light}}}{dark}{{:root{{{black}}}}}\n"


def _sheet(colours: dict[str, str]) -> str:
    text = _RULES.strip() + "\n"
    for role in _ARROWS:
        width = _WIDTHS.get(role, "2.2")
        text += f".fig .{role}{{fill:none;stroke:@{role};stroke-width:{width}}}"
        text += f".fig .{role}-head{{fill:@{role}}}.fig text.{role}-text{{fill:@{role}}}\n"
    text += ".fig .inertia{stroke-dasharray:5 4}\n"
    for k, colour in enumerate(_MAP):
        text += f".fig .m{k}{{fill:#{colour};stroke:#{colour};stroke-width:.4}}"
    for k in range(SERIES):
        text += f".fig .s{k}{{stroke:@s{k}}}.fig .f{k}{{fill:@s{k}}}"
    return _filled(text, colours)


def _colours_only(colours: dict[str, str]) -> str:
    """The style sheet's rules that hold colours, reduced to their colours."""
    rules = []
    for rule in _sheet({name: f"@{name}" for name in colours}).replace("\n", "").split("}"):
        selector, _, body = rule.partition("{")
        kept = ";".join(item for item in body.split(";") if "@" in item)
        if kept:
            rules.append(f"{selector}{{{kept}}}")
    return _filled("".join(rules), colours)


def _filled(text: str, colours: dict[str, str]) -> str:
    for name in sorted(colours, key=len, reverse=True):
        text = text.replace(f"@{name}", colours[name])
    return text
