"""The class of all commands: an option that tells one thing may stand once."""

from __future__ import annotations

from collections import Counter
from typing import Any

import typer
from typer.core import TyperCommand

from freebody.errors import FreebodyError


class OnceCommand(TyperCommand):
    """A command that refuses an option given twice, of which the parser would silently take the
    last; options that may be repeated collect what they are given."""

    def parse_args(self, ctx: typer.Context, args: list[str]) -> list[str]:
        """The arguments that are left; the parser tells the options in the order in which they
        came."""
        given = list(args)
        rest = super().parse_args(ctx, args)
        if not ctx.resilient_parsing:
            _, _, order = self.make_parser(ctx).parse_args(args=given)
            for option, count in Counter(map(_name, order)).items():
                if option and count > 1:
                    raise FreebodyError(f"{option} is given {count} times; give it once.")
        return rest


def _name(parameter: Any) -> str:
    """An option's name, empty for what may be repeated."""
    repeated = parameter.multiple or parameter.nargs != 1 or getattr(parameter, "is_flag", False)
    if parameter.param_type_name != "option" or repeated:
        return ""
    return max(parameter.opts, key=len)
