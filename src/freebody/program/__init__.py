"""Programs made from functions over scalars: straight-line arithmetic as data, read by passes and
targets.

trace -> Program -> passes -> segments.
"""

from freebody.program.program import Argument, Program, ProgramError, verify
from freebody.program.tracer import trace

__all__ = ["Argument", "Program", "ProgramError", "trace", "verify"]
