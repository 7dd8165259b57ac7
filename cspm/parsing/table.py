"""Parse tables: made by Lark from a grammar once, shipped with it or kept in the user's cache folder.

Lark needs some 0.3 s to be imported and to compute the LALR(1) table; a stored table is read in a few
milliseconds and needs no Lark. The file is named after what it was made from, so a new grammar never meets an
old table. A folder that cannot be written, or a damaged file, costs time and nothing else (``cspcheck.cspm.caches``).
"""

from __future__ import annotations

import json
import logging
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any, Final

from cspcheck.cspm.caches import cache_folder, seal, store, unsealed, usable

GRAMMAR: Final = Path(__file__).with_name("grammar") / "cspm.lark"
STARTS: Final = ("script", "lone_expression", "lone_assertion")
ACCEPT: Final = 0
_FORMAT: Final = 2


@dataclass(frozen=True, slots=True)
class Grammar:
    """A grammar of Lark with what it is made into a table by.

    Attributes:
        path: of the file.
        starts: symbols that a text can be parsed as.
        greedy: nonterminals that end only where what follows cannot belong to them, as ``if`` takes the next ``else``.
            A conflict between their end and the next token is settled so; any other is an error.
    """

    path: Path
    starts: tuple[str, ...]
    greedy: frozenset[str] = frozenset()


CSPM: Final = Grammar(GRAMMAR, STARTS)


@dataclass(frozen=True, slots=True)
class Production:
    """One alternative of the grammar.

    ``size`` symbols become the nonterminal ``target``. Of them the parts at the positions ``kept`` (all but quoted
    words and signs, and terminals with a leading underscore) go to the tree builder's method ``action``; without
    an action the only kept part stands for the whole.
    """

    target: str
    size: int
    kept: tuple[int, ...]
    action: str | None


@dataclass(frozen=True, slots=True)
class Table:
    """An LALR(1) table.

    ``actions[state][kind]`` is ``s + 1`` to shift and go to state ``s``, ``-(r + 1)`` to reduce by rule ``r``,
    and ``ACCEPT``; ``gotos[state][nonterminal]`` is the next state; ``starts`` has the first state of each start
    symbol.
    """

    rules: Sequence[Production]
    actions: Sequence[Mapping[str, int]]
    gotos: Sequence[Mapping[str, int]]
    starts: Mapping[str, int]


def compute(grammar: str, starts: Sequence[str] = STARTS, greedy: frozenset[str] = frozenset()) -> dict[str, Any]:
    """The table of *grammar* as a value that JSON can hold; see :class:`Grammar`.

    Raises:
        lark.exceptions.GrammarError: the grammar is malformed or has a conflict.
    """
    from lark import Lark
    from lark.exceptions import GrammarError
    from lark.lexer import Lexer
    from lark.parsers.lalr_analysis import Shift

    class NoLexer(Lexer):
        """The table is all that is wanted of Lark; the tokens are made by :mod:`cspcheck.cspm.parsing.lexer`."""

        def __init__(self, *_: object) -> None:
            pass

        def lex(self, *_: object) -> Any:
            raise NotImplementedError

    with _conflicts() as conflicts:
        lark = Lark(grammar, parser="lalr", lexer=NoLexer, start=list(starts), strict=not greedy)
    for terminal, origin in conflicts:
        if origin not in greedy:
            raise GrammarError(f"Shift/Reduce conflict for terminal {terminal} at the end of {origin}")
    computed = lark.parser.parser._parse_table
    # A quoted terminal goes by its text, a declared one by its name.
    quoted = {terminal.name: str(terminal.pattern.value) for terminal in lark.terminals}

    # Lark numbers states as it happens to find them; here the same grammar always gives the same table.
    order = [computed.start_states[start] for start in starts]
    places = {state: place for place, state in enumerate(order)}
    for state in order:  # grows
        for _, (kind, argument) in sorted(computed.states[state].items(), key=lambda item: str(item[0])):
            if kind is Shift and argument not in places:
                places[argument] = len(order)
                order.append(argument)
    reduced = {argument for state in order for kind, argument in computed.states[state].values() if kind is not Shift}
    ordered = sorted(reduced, key=lambda rule: (rule.origin.name, [symbol.name for symbol in rule.expansion]))
    numbers = {rule: number for number, rule in enumerate(ordered)}
    rules = []
    for rule in ordered:
        kept = [
            position
            for position, symbol in enumerate(rule.expansion)
            if not symbol.is_term
            or rule.options.keep_all_tokens
            or (symbol.name not in quoted and not symbol.name.startswith("_"))
        ]
        rules.append([str(rule.origin.name), len(rule.expansion), kept, rule.alias])

    # Most states share their rows with others.
    rows: list[dict[str, int]] = []
    row_numbers: dict[str, int] = {}

    def row(entries: dict[str, int]) -> int:
        entries = dict(sorted(entries.items()))
        key = json.dumps(entries)
        if key not in row_numbers:
            row_numbers[key] = len(rows)
            rows.append(entries)
        return row_numbers[key]

    ends = set(computed.end_states.values())
    states = []
    for state in order:
        actions: dict[str, int] = {}
        gotos: dict[str, int] = {}
        for name, (kind, argument) in computed.states[state].items():
            if kind is not Shift:
                actions[quoted.get(name, name)] = -(numbers[argument] + 1)
            elif name in quoted or name.isupper():
                actions[quoted.get(name, name)] = places[argument] + 1
            else:
                gotos[name] = places[argument]
        if state in ends:
            actions["$END"] = ACCEPT
        states.append([row(actions), row(gotos)])
    first = {start: places[computed.start_states[start]] for start in starts}
    return {"rules": rules, "rows": rows, "states": states, "starts": first}


@contextmanager
def _conflicts() -> Iterator[list[tuple[str, str]]]:
    """The terminals and nonterminals in whose conflict Lark shifts while a grammar is read; it only logs them."""
    found: list[tuple[str, str]] = []

    class Listener(logging.Handler):
        def emit(self, record: logging.LogRecord) -> None:
            argument: Any = record.args[0] if isinstance(record.args, tuple) and record.args else None
            if record.msg.startswith("Shift/Reduce"):
                found.append((str(argument), ""))
            elif found and record.msg.startswith(" * "):
                found[-1] = (found[-1][0], str(argument.origin.name))

    log, listener = logging.getLogger("lark"), Listener()
    before = log.handlers, log.level, log.propagate
    log.handlers = [listener]  # Lark's own prints
    log.setLevel(logging.DEBUG)
    log.propagate = False
    try:
        yield found
    finally:
        log.handlers, log.level, log.propagate = before


def from_json(value: Mapping[str, Any]) -> Table:
    """The table that :func:`compute` described.

    Raises:
        KeyError, TypeError, ValueError, IndexError: the value is no such description.
    """
    rows = value["rows"]
    return Table(
        rules=[Production(target, size, tuple(kept), action) for target, size, kept, action in value["rules"]],
        actions=[rows[actions] for actions, _ in value["states"]],
        gotos=[rows[gotos] for _, gotos in value["states"]],
        starts=value["starts"],
    )


def _key(grammar: str) -> str:
    return sha256(f"{_FORMAT}\n{grammar}".encode()).hexdigest()[:20]


def ship(grammar: Grammar, to: Path) -> None:
    """Put the table of a grammar beside a copy of it; it is used as long as the grammar is the same."""
    text = to.read_text(encoding="utf-8")
    value = {"key": _key(text), **compute(text, grammar.starts, grammar.greedy)}
    to.with_suffix(".json").write_text(json.dumps(value, separators=(",", ":")), encoding="utf-8")


def _shipped(grammar: Grammar, key: str) -> Table | None:
    """The table that came with the grammar; a checkout has none."""
    try:
        value = json.loads(grammar.path.with_suffix(".json").read_text(encoding="utf-8"))
        return from_json(value) if value["key"] == key else None
    except (OSError, ValueError, KeyError, TypeError, IndexError):
        return None


@cache
def table(grammar: Grammar = CSPM) -> Table:
    """The table of a grammar: shipped with it, else from the cache, else computed and stored there."""
    text = grammar.path.read_text(encoding="utf-8")
    key = _key(text)
    shipped = _shipped(grammar, key)
    if shipped is not None:
        return shipped
    folder = cache_folder()
    path = None if folder is None or not usable(folder) else folder / f"grammar-{key}"
    kept = None if path is None else unsealed(path)
    if kept is not None:
        return from_json(json.loads(kept))
    value = compute(text, grammar.starts, grammar.greedy)
    if path is not None:
        store(path, seal(json.dumps(value, separators=(",", ":")).encode()))
    return from_json(value)
