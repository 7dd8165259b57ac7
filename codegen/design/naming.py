"""Names in Python for names in CSPm."""

from __future__ import annotations

import builtins
import keyword
import re

_FORBIDDEN = (
    frozenset(keyword.kwlist) | frozenset(keyword.softkwlist) | frozenset(dir(builtins)) | {"self", "l", "I", "O"}
)


def snake(name: str) -> str:
    """``produceData`` as ``produce_data``: functions, methods, modules, channels."""
    text = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    return safe(text.lower())


def camel(name: str) -> str:
    """``token_ring`` as ``TokenRing``: classes."""
    parts = [part for part in re.split(r"[_\W]+", name) if part]
    return safe("".join(part[0].upper() + part[1:] for part in parts) or "Process")


def upper(name: str) -> str:
    """``maxSize`` as ``MAX_SIZE``: constants."""
    return safe(snake(name).upper().strip("_") or "CONSTANT")


def safe(name: str) -> str:
    """A name that Python can use: no keyword, nothing that hides a built-in; primes are spelt out."""
    text = re.sub(r"\W", "_", name.replace("'", "_prime"))
    if not text or text[0].isdigit():
        text = f"n{text}"
    return f"{text}_" if text in _FORBIDDEN else text


def unique(name: str, taken: set[str] | frozenset[str]) -> str:
    """*name*, or with a number behind it if it is taken."""
    if name not in taken:
        return name
    count = 2
    while f"{name}_{count}" in taken:
        count += 1
    return f"{name}_{count}"
