"""From a syntax tree with its names tied to values and process terms.

Expressions become Python closures once, and run lazily: arguments and definitions are thunks where their values are
not at hand. Where a process is needed, a named process becomes a reference that is not looked into; that is what
makes the evaluation of recursive processes end.
"""

from cspcheck.cspm.evaluator import calls, collections, dotting, lets, operators, prefixes, processes, variables
from cspcheck.cspm.evaluator.core import Evaluator

__all__ = ["Evaluator", "calls", "collections", "dotting", "lets", "operators", "prefixes", "processes", "variables"]
