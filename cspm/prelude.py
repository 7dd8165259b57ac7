"""The names that every script can use without defining them, and those that it must import first.

Only the names; what they mean is said in ``cspcheck.cspm.evaluator``'s ``builtins_data`` and ``builtins_processes``,
and their types in ``cspcheck.cspm.typing.builtins``.
"""

from __future__ import annotations

_BUILTINS = """
    Int Bool Char Events Proc True False STOP SKIP DIV CHAOS RUN BUFFER WEAK_BUFFER SIGNAL_BUFFER
    union inter diff Union Inter set Set Seq card empty member seq length null head tail concat elem
    emptyMap mapFromList mapToList mapLookup mapMember mapUpdate mapUpdateMultiple mapDelete Map
    extensions productions error show
    """
BUILTINS = frozenset(_BUILTINS.split())
"""In scope everywhere, unless a script defines the name itself."""

TIMED_BUILTINS = frozenset({"WAIT", "timed_priority"})
"""In scope inside ``Timed`` sections only."""

_TRANSPARENT = """
    normal normalise lazynorm sbisim dbisim wbisim diamond tau_loop_factor model_compress explicate lazyenumerate
    chase chase_nocache
    """
TRANSPARENT = frozenset(_TRANSPARENT.split())
"""What ``transparent`` can import: functions that keep a process's meaning (and, by tradition, ``chase``)."""

DEPRECATED_IMPORTS = {"normalise": "normal"}
"""Imports of old that FDR4 refuses, with what they are called now."""

_EXTERNAL = """
    chase chase_nocache prioritise prioritise_nocache prioritisepo deter loop failure_watchdog trace_watchdog
    mtransclose relational_image relational_inverse_image transpose
    """
EXTERNAL = frozenset(_EXTERNAL.split())
"""What ``external`` can import."""
