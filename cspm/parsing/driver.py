"""The LALR machine: runs a parse table over tokens and builds the tree while it reduces.

Everything is on explicit stacks, so the depth of a script is bounded by memory alone. Lark's own machine would do
the same; this one reads the stored table without importing Lark, and on a mistake it can say precisely what would
have been possible instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

from cspcheck.cspm.parsing.lexer import Tokens
from cspcheck.cspm.parsing.table import ACCEPT, Table
from cspcheck.cspm.source import Span


class Builder(Protocol):
    """What builds a tree: a method for each action of the grammar, called with a span and the kept parts.

    A part is a token's index where the grammar keeps a token, else what its own action returned.
    """


class Unexpected(Exception):
    """The token at ``index`` cannot continue what stands before it."""

    def __init__(self, index: int) -> None:
        self.index = index
        super().__init__(index)


class Open(NamedTuple):
    """What stands on the stack before a token: the states, and behind the first the symbols they were reached by.

    A symbol is a nonterminal's name or a token's index.
    """

    states: list[int]
    symbols: list[str | int]


def run(table: Table, start: str, tokens: Tokens, builder: Builder) -> Any:
    """Parse *tokens* as *start* and return what *builder* makes of it.

    Raises:
        Unexpected: the tokens are no *start*.
    """
    source = tokens.source
    actions, gotos = table.actions, table.gotos
    rules, chains = _rules_for(table, type(builder))
    states = [table.starts[start]]
    values: list[Any] = []
    begins: list[int] = []
    ends = [0]
    for index, kind in enumerate(tokens.kinds):
        while True:
            action = actions[states[-1]].get(kind)
            if action is None:
                raise Unexpected(index)
            if action > 0:
                states.append(action - 1)
                values.append(index)
                begins.append(tokens.starts[index])
                ends.append(tokens.ends[index])
                break
            if action == ACCEPT:
                return values[-1]
            target, size, kept, method = rules[-action - 1]
            if method is None and size == 1:
                here = states[-2], states[-1], kind
                after = chains.get(here)
                if after is None:
                    after = chains[here] = _after_units(table, *here)
                states[-1] = after
                continue
            if size:
                begin, end = begins[-size], ends[-1]
                base = len(values) - size
                if method is None:
                    value = values[base + kept[0]]
                elif method == "nothing":
                    value = []
                elif method == "first":
                    value = [values[base + kept[0]]]
                elif method == "more":
                    value = values[base + kept[0]]
                    value.append(values[base + kept[1]])
                else:
                    value = method(builder, Span(source, begin, end), *[values[base + position] for position in kept])
                del states[-size:], values[-size:], begins[-size:], ends[-size:]
            else:
                begin = end = ends[-1]
                value = []
            states.append(gotos[states[-1]][target])
            values.append(value)
            begins.append(begin)
            ends.append(end)
    raise AssertionError("the last token is accepted or unexpected")


Ready = tuple[str, int, tuple[int, ...], Any]
"""A rule's target, size and kept parts, and what makes a value of these: a method or the name of an action on lists."""

Chains = dict[tuple[int, int, str], int]
"""The state below the top, the state on top and the next kind: what is on top after rules that change nothing else.

A number in brackets goes through all levels of precedence, one rule after the other.
"""

_ready: dict[tuple[int, type], tuple[Table, list[Ready], Chains]] = {}
"""By the identity of the table, which is kept, so that no other can have it, and by the builder's class."""


def _after_units(table: Table, below: int, top: int, kind: str) -> int:
    """The state on top after all reductions, one behind the other, of one symbol that stands for itself."""
    while (action := table.actions[top].get(kind)) is not None and action < 0:
        rule = table.rules[-action - 1]
        if rule.action is not None or rule.size != 1:
            break
        top = table.gotos[below][rule.target]
    return top


def _rules_for(table: Table, builder: type) -> tuple[list[Ready], Chains]:
    """The rules of a table for builders of a class, found once: small texts are parsed faster than they are made."""
    known = _ready.get((id(table), builder))
    if known is None:
        rules = [(rule.target, rule.size, rule.kept, _method(builder, rule.action)) for rule in table.rules]
        known = _ready[id(table), builder] = (table, rules, {})
    return known[1:]


def _method(builder: type, action: str | None) -> Any:
    # The three actions that make lists are done by the driver itself; they are the most frequent ones.
    return action if action in (None, "nothing", "first", "more") else getattr(builder, action)


def stack_before(table: Table, start: str, kinds: Sequence[str], index: int) -> Open:
    """The stack before the token at *index*, with no reduction made on its account."""
    states = [table.starts[start]]
    symbols: list[str | int] = []
    for position in range(index):
        kind = kinds[position]
        while (action := table.actions[states[-1]][kind]) < 0:
            _reduce(table, states, symbols, -action - 1)
        states.append(action - 1)
        symbols.append(position)
    return Open(states, symbols)


def _reduce(table: Table, states: list[int], symbols: list[str | int], number: int) -> None:
    rule = table.rules[number]
    if rule.size:
        del states[-rule.size :], symbols[-rule.size :]
    states.append(table.gotos[states[-1]][rule.target])
    symbols.append(rule.target)


def expected(table: Table, stack: Open) -> set[str]:
    """The kinds of token that could come next."""
    return {kind for kind in table.actions[stack.states[-1]] if accepts(table, stack, kind)}


def accepts(table: Table, stack: Open, kind: str) -> bool:
    """Whether a token of this kind could come next."""
    # Only the part of the stack that reductions reach is copied.
    depth = len(stack.states)
    top: list[int] = []
    while True:
        state = top[-1] if top else stack.states[depth - 1]
        action = table.actions[state].get(kind)
        if action is None:
            return False
        if action >= 0:
            return True
        rule = table.rules[-action - 1]
        taken = min(rule.size, len(top))
        if taken:
            del top[-taken:]
        depth -= rule.size - taken
        below = top[-1] if top else stack.states[depth - 1]
        top.append(table.gotos[below][rule.target])
