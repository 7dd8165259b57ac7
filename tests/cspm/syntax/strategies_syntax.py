"""Hypothesis strategies for syntax trees and scripts, and comparisons that look through brackets.

The trees obey what the concrete syntax can say (see :mod:`cspcheck.cspm.printing.printer`) and nothing more: they
have no meaning, and brackets stand at random where they are not needed and are missing where they are.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import fields, is_dataclass, replace
from functools import cache, partial
from typing import Any

from hypothesis import HealthCheck, settings, strategies as st

from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as s

EXAMPLES = int(os.environ.get("CSPCHECK_FUZZ", "20000"))
"""How many random inputs the fuzzing tests try together."""


def fuzz(share: float) -> settings:
    """The settings of a test that tries a share of them, none for more than five seconds."""
    return settings(
        max_examples=max(1, int(EXAMPLES * share)),
        deadline=5000,
        suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large, HealthCheck.filter_too_much],
    )


NOWHERE = Source("<made>", "").span(0, 0)

NAMES = ["a", "b", "c", "P", "Q", "f", "g", "x", "y'", "x_1''", "Union", "in2", "STOP", "free", "T"]
names = st.sampled_from(NAMES)
qualified = st.one_of(names.map(lambda n: (n,)), st.lists(names, min_size=2, max_size=3).map(tuple))


def deferred(make: Callable[..., st.SearchStrategy[Any]]) -> Callable[..., st.SearchStrategy[Any]]:
    """One strategy for each choice of arguments, made when it is first used (and short in what Hypothesis prints)."""
    strategies = cache(make)

    @st.composite
    def drawn(draw: st.DrawFn, *arguments: Any) -> Any:
        return draw(strategies(*arguments))

    return cache(drawn)


def node(form: type[Any], /, **parts: Any) -> st.SearchStrategy[Any]:
    """Nodes of one form; a part is a strategy or the value that it always has."""
    drawn = {name: part for name, part in parts.items() if isinstance(part, st.SearchStrategy)}
    fixed = {name: part for name, part in parts.items() if name not in drawn}
    return st.builds(partial(form, span=NOWHERE, **fixed), **drawn)


def some(items: st.SearchStrategy[Any], least: int = 0, most: int = 3) -> st.SearchStrategy[tuple[Any, ...]]:
    return st.lists(items, min_size=least, max_size=most).map(tuple)


def pairs(items: st.SearchStrategy[Any]) -> st.SearchStrategy[tuple[Any, ...]]:
    return some(st.tuples(items, items), 1, 2)


characters = st.characters(exclude_categories=["Cs"], exclude_characters="\0")
literals = [
    ("int", st.integers(0, 10**12)),
    ("bool", st.booleans()),
    ("char", characters),
    ("string", st.text(characters, max_size=5)),
]
names_as_expressions = node(s.Name, parts=qualified)
literal_expressions = st.one_of(*(node(s.LiteralExpr, kind=k, value=v) for k, v in literals))


@deferred
def patterns(depth: int) -> st.SearchStrategy[s.Pattern]:
    base = [
        node(s.NamePattern, parts=names.map(lambda n: (n,))),
        node(s.Wildcard),
        node(s.LiteralPattern, kind="int", value=st.integers(-9, 9)),
        *(node(s.LiteralPattern, kind=k, value=v) for k, v in literals[1:]),
    ]
    if depth == 0:
        return st.one_of(*base)
    inner = patterns(depth - 1)
    fixed = node(s.SequencePattern, items=some(inner))
    return st.one_of(
        *base,
        node(s.ParenPattern, inner=inner),
        node(s.TuplePattern, items=some(inner, 2)),
        fixed,
        node(s.SetPattern, items=some(inner, 0, 1)),
        node(s.DotPattern, left=inner, right=inner),
        node(s.BothPattern, left=inner, right=inner),
        node(s.ConcatPattern, left=fixed, right=inner.filter(lambda p: not isinstance(p, s.ConcatPattern))),
        node(s.ConcatPattern, left=node(s.ConcatPattern, left=base[0], right=fixed), right=fixed),
    )


@deferred
def statements(depth: int) -> st.SearchStrategy[tuple[s.Statement, ...]]:
    return some(
        st.one_of(
            node(s.Generator, pattern=patterns(min(depth, 1)), source=expressions(depth), colon=st.booleans()),
            node(s.Qualifier, condition=expressions(depth)),
        ),
        1,
        2,
    )


@deferred
def expressions(depth: int) -> st.SearchStrategy[s.Expr]:
    """Any expressions, processes included."""
    base = st.one_of(names_as_expressions, literal_expressions)
    if depth == 0:
        return base
    e = expressions(depth - 1)
    optional_statements = st.one_of(st.none(), statements(depth - 1))
    parameters = some(patterns(min(depth - 1, 1)), 1, 2)
    field = st.one_of(
        node(s.Field, kind="!", expression=e),
        node(
            s.Field,
            kind=st.sampled_from("?$"),
            pattern=patterns(min(depth - 1, 1)),
            restriction=st.one_of(st.none(), e),
        ),
    )
    replicated = [
        node(
            s.Replicated, operator=st.sampled_from(["[]", "|~|", "|||", ";"]), statements=statements(depth - 1), body=e
        ),
        node(
            s.Replicated,
            operator=st.sampled_from(["||", "[|", "[+"]),
            statements=statements(depth - 1),
            body=e,
            events=e,
        ),
        node(
            s.Replicated,
            operator="<->",
            statements=statements(depth - 1),
            body=e,
            links=pairs(e),
            link_statements=optional_statements,
        ),
    ]
    return st.one_of(
        base,
        node(s.Paren, inner=e),
        node(s.TupleExpr, items=some(e, 2)),
        node(s.SetExpr, items=some(e)),
        node(s.SetExpr, items=some(e, 1, 2), statements=statements(depth - 1)),
        node(s.SetRange, low=e, high=st.one_of(st.none(), e), statements=optional_statements),
        node(s.Productions, items=some(e)),
        node(s.Productions, items=some(e, 1, 2), statements=statements(depth - 1)),
        node(s.SequenceExpr, items=some(e)),
        node(s.SequenceExpr, items=some(e, 1, 2), statements=statements(depth - 1)),
        node(s.SequenceRange, low=e, high=st.one_of(st.none(), e), statements=optional_statements),
        node(s.MapExpr, items=some(st.tuples(e, e), 0, 2)),
        node(
            s.Binary,
            operator=st.sampled_from(["+", "-", "*", "/", "%", "==", "!=", "<", "<=", ">", ">=", "and", "or", "^"]),
            left=e,
            right=e,
        ),
        node(s.Unary, operator=st.sampled_from(["-", "not", "#"]), operand=e),
        node(s.Dot, left=e, right=e),
        node(s.Apply, function=e, arguments=some(e)),
        node(s.Lambda, parameters=parameters, body=e),
        node(s.If, condition=e, then=e, otherwise=e),
        node(s.Let, declarations=declarations(depth - 1, "let"), body=e),
        node(s.Prefix, channel=e, fields=some(field, 0, 2), body=e),
        node(s.Guard, condition=e, body=e),
        node(s.ProcessBinary, operator=st.sampled_from([";", "[]", "|~|", "[>", "/\\", "|||"]), left=e, right=e),
        node(s.Synchronised, operator=st.sampled_from(["[|", "[+", "/+", "[|>"]), left=e, events=e, right=e),
        node(s.AlphabetisedParallel, left=e, left_alphabet=e, right_alphabet=e, right=e),
        node(s.LinkedParallel, left=e, links=pairs(e), right=e, statements=optional_statements),
        node(s.Hide, process=e, events=e, keep=st.booleans()),
        node(s.Rename, process=e, pairs=pairs(e), statements=optional_statements),
        *replicated,
    )


@deferred
def types(depth: int) -> st.SearchStrategy[s.TypeExpr]:
    base = node(s.TypeName, parts=qualified)
    if depth == 0:
        return base
    t = types(depth - 1)
    return st.one_of(
        base,
        node(s.SetType, element=t),
        node(s.SequenceType, element=t),
        node(s.TupleType, items=some(t, 2)),
        node(s.MapType, key=t, value=t),
        node(s.FunctionType, parameters=some(t), result=t),
        node(s.DotType, left=t, right=t),
        node(s.DotableType, argument=t, result=t, extendable=st.booleans()),
    )


constraints = some(
    node(s.TypeConstraint, constraint=st.sampled_from(["Eq", "Ord", "Set", "Complete", "Yieldable"]), variable=names)
)
schemes = node(s.TypeScheme, constraints=constraints, type=types(3))


@deferred
def assertions(depth: int) -> st.SearchStrategy[s.Assertion]:
    e = expressions(depth)
    options = st.tuples(
        st.lists(node(s.AssertOption, kind="tau priority", events=e), max_size=1),
        st.lists(
            node(
                s.AssertOption,
                kind="partial order reduce",
                mode=st.sampled_from([None, "precise", "hybrid", "fast"]),
            ),
            max_size=1,
        ),
    ).map(lambda both: (*both[0], *both[1]))
    models = st.sampled_from(["T", "F", "FD", "V", "VD", "R", "RD"])
    claims = st.one_of(
        node(s.Refinement, specification=e, model=models, implementation=e, options=options),
        node(
            s.Property,
            process=e,
            kind=st.sampled_from(["deadlock free", "divergence free", "deterministic"]),
            model=st.one_of(st.none(), models),
            options=options,
        ),
        node(
            s.Property,
            process=e,
            kind="has trace",
            model=st.one_of(st.none(), models),
            trace=e,
            options=options,
        ),
    )
    negated = node(s.NotAssertion, inner=st.one_of(claims, node(s.NotAssertion, inner=claims)))
    return st.one_of(claims, node(s.BooleanAssertion, condition=e), negated)


@deferred
def declarations(depth: int, place: str) -> st.SearchStrategy[tuple[s.Declaration, ...]]:
    """Declarations that may stand in a place: ``script``, ``module``, ``let``, ``Timed`` (at the top)."""
    e = expressions(depth)
    p = patterns(min(depth + 1, 2))
    clause = node(s.Clause, groups=some(some(p), 1, 2), body=e)
    function = node(s.FunctionDefinition, name=names, clauses=some(clause, 1, 2))
    annotated = st.tuples(node(s.AnnotationDeclaration, names=(), scheme=schemes), st.one_of(function))
    declared = some(node(s.NameDeclaration, name=names), 1)
    kinds: list[st.SearchStrategy[Any]] = [
        function,
        function,
        node(s.PatternDefinition, pattern=p, body=e),
        annotated,
        node(s.ImportDeclaration, kind=st.sampled_from(["transparent", "external"]), names=declared),
    ]
    duration = st.one_of(st.none(), e)
    if depth and place != "script":
        inside = declarations(depth - 1, place)
        kinds.append(node(s.TimedDeclaration, duration=duration, declarations=inside))
    if place != "let":
        constructor = node(s.Constructor, name=names, fields=st.one_of(st.none(), e))
        kinds += [
            node(s.ChannelDeclaration, names=declared, fields=duration),
            node(s.DatatypeDeclaration, name=names, constructors=some(constructor, 1), subtype=st.booleans()),
            node(s.NametypeDeclaration, name=names, body=e),
            node(
                s.InstanceDeclaration,
                name=names,
                module=node(s.Name, parts=qualified),
                arguments=some(e, 0, 2),
            ),
        ]
        if depth:
            inside = st.one_of(st.just(()), declarations(depth - 1, "module"))
            kinds.append(
                node(s.ModuleDeclaration, name=names, parameters=some(p, 0, 2), private=inside, exported=inside)
            )
    if place in ("script", "Timed"):
        kinds.append(node(s.AssertDeclaration, assertion=assertions(depth)))
    if place == "script":
        if depth:
            inside = declarations(depth - 1, "Timed")
            kinds.append(node(s.TimedDeclaration, duration=duration, declarations=inside))
        kinds.append(node(s.PrintDeclaration, expression=e))
    return st.lists(st.one_of(*kinds), min_size=1, max_size=4 if place == "script" else 2).map(_told_apart)


def _told_apart(made: list[Any]) -> tuple[s.Declaration, ...]:
    """The declarations with function names that are all different, so that no two are one definition."""
    told: list[s.Declaration] = []
    for number, item in enumerate(made):
        if isinstance(item, tuple):
            annotation, function = item
            name = f"{function.name.rstrip(chr(39))}_{number}"
            told.append(replace(annotation, names=(s.NameDeclaration(span=NOWHERE, name=name),)))
            told.append(replace(function, name=name))
        elif isinstance(item, s.FunctionDefinition):
            told.append(replace(item, name=f"{item.name.rstrip(chr(39))}_{number}"))
        else:
            told.append(item)
    return tuple(told)


def scripts(depth: int = 2) -> st.SearchStrategy[s.Script]:
    return node(s.Script, declarations=declarations(depth, "script"))


def without_brackets(tree: Any) -> Any:
    """The tree without ``Paren`` and ``ParenPattern``, and with negative literals as the parser reads them."""
    if isinstance(tree, s.Paren | s.ParenPattern):
        return without_brackets(tree.inner)
    if isinstance(tree, tuple):
        return tuple(without_brackets(item) for item in tree)
    if is_dataclass(tree) and not isinstance(tree, type) and isinstance(tree, s.Node):
        changed = {f.name: without_brackets(getattr(tree, f.name)) for f in fields(tree) if f.name != "span"}
        return replace(tree, **changed)
    return tree
