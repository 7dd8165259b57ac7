"""All mistakes that can be told: the register of ``cspcheck.cspm.diagnostics``, filled from every module of
messages.
"""

from __future__ import annotations

import pkgutil
from importlib import import_module

from cspcheck.cspm.diagnostics import MISTAKES, Mistake
from cspcheck.cspm.spelling import suggestions

PHASES = {
    "0": "Files and characters",
    "1": "Syntax",
    "2": "Names",
    "3": "Types",
    "4": "Evaluation",
    "5": "Processes and machines",
    "6": "Classes (CSP-OZ)",
    "7": "Proof",
    "8": "Generated programs",
    "9": "The tool",
}
"""Titles of the hundreds of codes."""


def all_mistakes() -> list[Mistake]:
    """Every mistake, by code."""
    import cspcheck

    for module in pkgutil.walk_packages(cspcheck.__path__, "cspcheck."):
        if module.name.endswith("messages"):
            import_module(module.name)
    return [MISTAKES[code] for code in sorted(MISTAKES)]


def find(code: str) -> Mistake | None:
    """The mistake of a code, however it is written: ``CSP201``, ``csp201``, ``201``, ``error[CSP201]``."""
    digits = "".join(character for character in code if character.isdigit())
    return next((m for m in all_mistakes() if digits and m.code == f"CSP{digits.zfill(3)}"), None)


def close_codes(code: str) -> list[str]:
    """Codes that look like *code*."""
    return list(suggestions(code.upper(), [m.code for m in all_mistakes()]))
