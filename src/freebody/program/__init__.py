"""Programs made from functions over scalars: straight-line arithmetic as data, that passes and
targets read.

trace -> Program -> passes -> segments.
"""

from freebody.program.program import Argument, Program, ProgramError, verify
from freebody.program.tracer import trace

__all__ = ["Argument", "Program", "ProgramError", "trace", "verify"]
