# ruff: noqa: D102 - an action is documented by the alternative of the grammar that it is named in
"""From the parts of each grammar rule to the node of the syntax tree: the actions of ``grammar/cspm.lark``.

A part that the grammar keeps as a token arrives as the token's index. Mistakes that a grammar cannot express (what
is no pattern, what may not stand in a ``let``) are collected in ``errors``; the tree around them is still built.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any, Final, cast

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.notation import extension
from cspcheck.cspm.parsing import class_messages, messages as messages
from cspcheck.cspm.parsing.declarations import Clauses, group
from cspcheck.cspm.parsing.lexer import Tokens, property_words
from cspcheck.cspm.parsing.patterns import BothExpr, WildcardExpr, to_pattern
from cspcheck.cspm.parsing.precedence import (
    PARALLEL,
    STEP,
    Headed,
    OperandRow,
    ProcessHead,
    RowOperator,
    Signed,
    processes,
    values,
)
from cspcheck.cspm.parsing.types import TypeActions
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as s

MOST_MISTAKES: Final = 20
"""Mistakes of one file that are reported, at most."""

LONGEST_INTEGER: Final = 4000
"""Digits beyond which a number is refused (Python converts no more than 4300)."""

_ESCAPE = re.compile(r"\\(.)", re.DOTALL)
_STRING_ESCAPES: Final = {"n": "\n", "r": "\r", "t": "\t", "\\": "\\"}
_CHARACTER_ESCAPES: Final = {"n": "\n", "r": "\r", "t": "\t"}

Include = Callable[[str, Span], tuple[s.Declaration, ...]]
"""What is declared in a file, given its path as written and where that stands."""


class TreeBuilder(TypeActions):
    """Builds the tree of one text."""

    def __init__(self, tokens: Tokens, include: Include) -> None:
        self.tokens = tokens
        self.include_file = include
        self.errors: list[Diagnostic] = []
        self._only_patterns: dict[int, s.Expr] = {}  # `_` and `@@` that no pattern has claimed yet

    def finish(self) -> None:
        """Add the mistakes that only the whole shows: what is left of ``_`` and ``@@`` stands in no pattern."""
        claimed = [error.span for error in self.errors[:MOST_MISTAKES] if error.span is not None]
        for node in self._only_patterns.values():
            if not any(span.start <= node.span.start and node.span.end <= span.end for span in claimed):
                self.errors.append(
                    messages.both_outside_pattern(node.span)
                    if isinstance(node, BothExpr)
                    else messages.wildcard_outside_pattern(node.span)
                )

    def _refuse(self, error: Diagnostic) -> None:
        self.errors.append(error)

    def _only_pattern(self, node: s.Expr) -> None:
        self._only_patterns[id(node)] = node

    def _converted(self, node: s.Expr) -> None:
        self._only_patterns.pop(id(node), None)

    def _pattern(self, expression: s.Expr) -> s.Pattern:
        return to_pattern(expression, converted=self._converted, refuse=self._refuse)

    def _patterns(self, expressions: list[s.Expr]) -> tuple[s.Pattern, ...]:
        return tuple(self._pattern(e) for e in expressions)

    # --- scripts and declarations ----------------------------------------------------------------------------

    def script(self, span: Span, declarations: list[Any]) -> s.Script:
        text = self.tokens.source.text
        source = self.tokens.source
        return s.Script(
            span=source.span(0, len(text)),
            declarations=group(declarations, "script", self._refuse),
            comments=tuple(
                s.Comment(span=source.span(start, end), text=text[start:end]) for start, end in self.tokens.comments
            ),
        )

    def definition(self, span: Span, left: s.Expr, body: s.Expr) -> s.Declaration | Clauses:
        function = left
        groups: list[tuple[s.Pattern, ...]] = []
        while isinstance(function, s.Apply):
            groups.append(self._patterns(list(function.arguments)))
            function = function.function
        if not groups:
            return s.PatternDefinition(span=span, pattern=self._pattern(left), body=body)
        if not isinstance(function, s.Name) or len(function.parts) > 1:
            self._refuse(messages.invalid_function_head(function.span))
            return s.PatternDefinition(span=span, pattern=s.Wildcard(span=left.span), body=body)
        groups.reverse()
        return Clauses(function.parts[0], [s.Clause(span=span, groups=tuple(groups), body=body)])

    def declared_name(self, span: Span, name: int) -> s.NameDeclaration:
        return s.NameDeclaration(span=span, name=self.tokens.text(name))

    def channel(self, span: Span, names: list[s.NameDeclaration], fields: s.Expr | None = None) -> s.ChannelDeclaration:
        return s.ChannelDeclaration(span=span, names=tuple(names), fields=fields)

    def datatype(self, span: Span, name: int, constructors: list[s.Constructor]) -> s.DatatypeDeclaration:
        return s.DatatypeDeclaration(span=span, name=self.tokens.text(name), constructors=tuple(constructors))

    def subtype(self, span: Span, name: int, constructors: list[s.Constructor]) -> s.DatatypeDeclaration:
        return s.DatatypeDeclaration(
            span=span, name=self.tokens.text(name), constructors=tuple(constructors), subtype=True
        )

    def constructor(self, span: Span, name: int, fields: s.Expr | None = None) -> s.Constructor:
        return s.Constructor(span=span, name=self.tokens.text(name), fields=fields)

    def nametype(self, span: Span, name: int, body: s.Expr) -> s.NametypeDeclaration:
        return s.NametypeDeclaration(span=span, name=self.tokens.text(name), body=body)

    def transparent(self, span: Span, names: list[s.NameDeclaration]) -> s.ImportDeclaration:
        return s.ImportDeclaration(span=span, kind="transparent", names=tuple(names))

    def external(self, span: Span, names: list[s.NameDeclaration]) -> s.ImportDeclaration:
        return s.ImportDeclaration(span=span, kind="external", names=tuple(names))

    def include(self, span: Span, path: int) -> s.IncludeDeclaration:
        text = self.tokens.text(path)[1:-1]
        return s.IncludeDeclaration(span=span, path=text, declarations=self.include_file(text, self.tokens.span(path)))

    def print_(self, span: Span, expression: s.Expr) -> s.PrintDeclaration:
        return s.PrintDeclaration(span=span, expression=expression)

    def assertion_declaration(self, span: Span, assertion: s.Assertion) -> s.AssertDeclaration:
        return s.AssertDeclaration(span=span, assertion=assertion)

    def module(self, span: Span, name: int, private: list[Any], exported: list[Any]) -> s.ModuleDeclaration:
        return self._module(span, name, (), private, exported)

    def module_with_parameters(
        self, span: Span, name: int, parameters: list[s.Expr], private: list[Any], exported: list[Any]
    ) -> s.ModuleDeclaration:
        return self._module(span, name, self._patterns(parameters), private, exported)

    def _module(
        self, span: Span, name: int, parameters: tuple[s.Pattern, ...], private: list[Any], exported: list[Any]
    ) -> s.ModuleDeclaration:
        return s.ModuleDeclaration(
            span=span,
            name=self.tokens.text(name),
            parameters=parameters,
            private=group(private, "module", self._refuse),
            exported=group(exported, "module", self._refuse),
        )

    def instance(
        self, span: Span, name: int, module: s.Name, arguments: list[s.Expr] | None = None
    ) -> s.InstanceDeclaration:
        return s.InstanceDeclaration(
            span=span, name=self.tokens.text(name), module=module, arguments=tuple(arguments or ())
        )

    def timed(self, span: Span, declarations: list[Any]) -> s.TimedDeclaration:
        return s.TimedDeclaration(span=span, duration=None, declarations=group(declarations, "Timed", self._refuse))

    def timed_with_duration(self, span: Span, duration: s.Expr, declarations: list[Any]) -> s.TimedDeclaration:
        return s.TimedDeclaration(span=span, duration=duration, declarations=group(declarations, "Timed", self._refuse))

    def annotation(self, span: Span, names: list[s.NameDeclaration], scheme: s.TypeScheme) -> s.AnnotationDeclaration:
        return s.AnnotationDeclaration(span=span, names=tuple(names), scheme=scheme)

    def paragraph(self, span: Span, token: int) -> s.Declaration:
        found, errors = extension().paragraph(span.source, span.start, span.end)
        self.errors += errors
        return found

    # --- assertions ------------------------------------------------------------------------------------------

    def negation(self, span: Span, word: int, inner: s.Assertion) -> s.NotAssertion:
        return s.NotAssertion(span=span, inner=inner)

    def refinement(
        self, span: Span, specification: s.Expr, sign: int, implementation: s.Expr, options: list[s.AssertOption]
    ) -> s.Refinement:
        return s.Refinement(
            span=span,
            specification=specification,
            model=cast(s.Model, self.tokens.text(sign)[1:-1]),
            implementation=implementation,
            options=self._options(options),
        )

    def property_(self, span: Span, process: s.Expr, sign: int, options: list[s.AssertOption]) -> s.Property:
        words, model = property_words(self.tokens.text(sign))
        if words == "livelock free":
            words = "divergence free"
        return s.Property(
            span=span,
            process=process,
            kind=cast(s.PropertyKind, words),
            model=cast("s.Model | None", model),
            options=self._options(options),
        )

    def trace_property(
        self, span: Span, process: s.Expr, sign: int, trace: s.Expr, options: list[s.AssertOption]
    ) -> s.Property:
        _, model = property_words(self.tokens.text(sign))
        return s.Property(
            span=span,
            process=process,
            kind="has trace",
            model=cast("s.Model | None", model),
            trace=trace,
            options=self._options(options),
        )

    def obligations(
        self, span: Span, subject: s.Expr, sign: int, hints: s.Node | None, operation: int | None = None
    ) -> s.Assertion:
        words, _ = property_words(self.tokens.text(sign))
        return extension().obligations(
            span=span,
            subject=self._class_name(subject),
            obligation=None if words == "obligations" else words,
            operation=None if operation is None else self.declared_name(self.tokens.span(operation), operation),
            hints=hints or None,
        )

    def obligations_of_operation(
        self, span: Span, subject: s.Expr, sign: int, operation: int, hints: s.Node | None
    ) -> s.Assertion:
        return self.obligations(span, subject, sign, hints, operation)

    def subtype_claim(
        self, span: Span, parent: s.Expr, sign: int, child: int, hints: s.Node | None = None
    ) -> s.Assertion:
        return extension().subtype(
            span=span,
            parent=self._class_name(parent),
            child=self.declared_name(self.tokens.span(child), child),
            hints=hints or None,
        )

    def using(
        self, span: Span, sign: int, names: list[s.NameDeclaration], by: int = 0, on: s.NameDeclaration | None = None
    ) -> s.Node:
        return extension().hints(span=span, names=tuple(names), induction=on)

    def induction(self, span: Span, sign: int, on: s.NameDeclaration) -> s.Node:
        return extension().hints(span=span, names=(), induction=on)

    def data_refinement(
        self,
        span: Span,
        abstract: s.Expr,
        sign: int,
        concrete: int,
        via: int,
        retrieve: int,
        hints: s.Node | None,
        direction: int | None = None,
    ) -> s.Assertion:
        words = "downward" if direction is None else property_words(self.tokens.text(direction))[0]
        if direction is not None and words not in ("upward", "downward"):
            self._refuse(class_messages.unknown_direction(self.tokens.span(direction), words))
        return extension().data_refinement(
            span=span,
            abstract=self._class_name(abstract),
            concrete=self.declared_name(self.tokens.span(concrete), concrete),
            retrieve=self.declared_name(self.tokens.span(retrieve), retrieve),
            upward=words == "upward",
            hints=hints or None,
        )

    def directed_refinement(
        self,
        span: Span,
        abstract: s.Expr,
        sign: int,
        concrete: int,
        via: int,
        retrieve: int,
        direction: int,
        hints: s.Node | None,
    ) -> s.Assertion:
        return self.data_refinement(span, abstract, sign, concrete, via, retrieve, hints, direction)

    def _class_name(self, subject: s.Expr) -> s.NameDeclaration:
        if isinstance(subject, s.Name) and len(subject.parts) == 1:
            return s.NameDeclaration(span=subject.span, name=subject.parts[0])
        self._refuse(class_messages.no_class_name(subject.span))
        return s.NameDeclaration(span=subject.span, name="_")

    def boolean(self, span: Span, condition: s.Expr) -> s.BooleanAssertion:
        return s.BooleanAssertion(span=span, condition=condition)

    def priority_option(self, span: Span, sign: int, events: s.Expr) -> s.AssertOption:
        return s.AssertOption(span=span, kind="tau priority", events=events)

    def reduce_option(self, span: Span, sign: int) -> s.AssertOption:
        _, mode = property_words(self.tokens.text(sign))
        return s.AssertOption(span=span, kind="partial order reduce", mode=mode)

    def symmetry_option(self, span: Span, sign: int, types: list[s.Expr] | None = None) -> s.AssertOption:
        return s.AssertOption(span=span, kind="symmetry reduce", types=tuple(types or ()))

    def _options(self, options: list[s.AssertOption]) -> tuple[s.AssertOption, ...]:
        seen: dict[str, Span] = {}
        for option in options:
            if option.kind in seen:
                self._refuse(messages.option_given_twice(option.span, option.kind, seen[option.kind]))
            seen.setdefault(option.kind, option.span)
        return tuple(options)

    # --- rows ------------------------------------------------------------------------------------------------

    def row(self, span: Span, left: Any, operator: int | RowOperator, right: Any) -> OperandRow:
        row = left if isinstance(left, OperandRow) else OperandRow([left])
        row.append(operator if isinstance(operator, RowOperator) else self._operator(operator))
        row.append(right)
        return row

    def _operator(self, token: int) -> RowOperator:
        kind = self.tokens.kinds[token]
        return RowOperator("<" if kind == "LESS" else kind, self.tokens.span(token))

    def process_row(self, span: Span, row: OperandRow | Headed | s.Expr) -> s.Expr:
        return row if isinstance(row, s.Expr) else processes(row, self._refuse, self._only_pattern)

    def value_row(self, span: Span, row: OperandRow | Signed | s.Expr) -> s.Expr:
        return row if isinstance(row, s.Expr) else values(row, self._refuse)

    def signed(self, span: Span, signs: list[int], operand: s.Expr) -> Signed:
        return Signed([self._operator(sign) for sign in signs], operand)

    def bracketed_operator(self, span: Span, opening: int, events: s.Expr, closing: int) -> RowOperator:
        symbol = "[|>" if self.tokens.kinds[closing] == "|>" else self.tokens.kinds[opening]
        return RowOperator(symbol, span, events)

    def alphabetised_operator(
        self, span: Span, opening: int, left: s.Expr, bar: int, right: s.Expr, closing: int
    ) -> RowOperator:
        return RowOperator("||", span, left, right)

    def linked_operator(self, span: Span, opening: int, links: list[Any], *rest: Any) -> RowOperator:
        statements = tuple(rest[1]) if len(rest) == 3 else None
        return RowOperator("<->", span, links=tuple(links), statements=statements)

    # --- prefixes and guards ---------------------------------------------------------------------------------

    def prefix(self, span: Span, channel: s.Expr, body: s.Expr | Headed) -> s.Expr | Headed:
        return self.prefix_with_fields(span, channel, [], body)

    def prefix_with_fields(
        self, span: Span, channel: s.Expr, fields: list[s.Field], body: s.Expr | Headed
    ) -> s.Expr | Headed:
        def prefix(body: s.Expr) -> s.Prefix:
            return s.Prefix(span=span.to(body.span), channel=channel, fields=tuple(fields), body=body)

        return _behind(ProcessHead("->", STEP, channel.span, prefix), body)

    def guard(self, span: Span, condition: s.Expr, body: s.Expr | Headed) -> s.Expr | Headed:
        def guard(body: s.Expr) -> s.Guard:
            return s.Guard(span=span.to(body.span), condition=condition, body=body)

        return _behind(ProcessHead("&", STEP, condition.span, guard), body)

    def replicated_alphabetised_parallel(
        self, span: Span, statements: list[s.Statement], alphabet: s.Expr, body: s.Expr | Headed
    ) -> Headed:
        def replicated(body: s.Expr) -> s.Replicated:
            whole = span.to(body.span)
            return s.Replicated(span=whole, operator="||", statements=tuple(statements), body=body, events=alphabet)

        headed = body if isinstance(body, Headed) else Headed([], body)
        sign = Span(span.source, span.start, span.start + len("||"))
        headed.heads.append(ProcessHead("|| x : S @ [A]", PARALLEL, sign, replicated))
        return headed

    def output(self, span: Span, expression: s.Expr) -> s.Field:
        return s.Field(span=span, kind="!", expression=expression)

    def input_(self, span: Span, pattern: s.Expr, restriction: s.Expr | None = None) -> s.Field:
        return s.Field(span=span, kind="?", pattern=self._pattern(pattern), restriction=restriction)

    def choice(self, span: Span, pattern: s.Expr, restriction: s.Expr | None = None) -> s.Field:
        return s.Field(span=span, kind="$", pattern=self._pattern(pattern), restriction=restriction)

    # --- what extends to the right ---------------------------------------------------------------------------

    def if_(self, span: Span, condition: s.Expr, then: s.Expr, otherwise: s.Expr) -> s.If:
        return s.If(span=span, condition=condition, then=then, otherwise=otherwise)

    def let(self, span: Span, declarations: list[Any], body: s.Expr) -> s.Let:
        if not declarations:
            self._refuse(messages.empty_let(Span(span.source, span.start, span.start + len("let"))))
        return s.Let(span=span, declarations=group(declarations, "let", self._refuse), body=body)

    def lambda_(self, span: Span, parameters: list[s.Expr], body: s.Expr) -> s.Lambda:
        return s.Lambda(span=span, parameters=self._patterns(parameters), body=body)

    def replicated_external_choice(self, span: Span, statements: list[s.Statement], body: s.Expr) -> s.Replicated:
        return s.Replicated(span=span, operator="[]", statements=tuple(statements), body=body)

    def replicated_internal_choice(self, span: Span, statements: list[s.Statement], body: s.Expr) -> s.Replicated:
        return s.Replicated(span=span, operator="|~|", statements=tuple(statements), body=body)

    def replicated_interleaving(self, span: Span, statements: list[s.Statement], body: s.Expr) -> s.Replicated:
        return s.Replicated(span=span, operator="|||", statements=tuple(statements), body=body)

    def replicated_sequence(self, span: Span, statements: list[s.Statement], body: s.Expr) -> s.Replicated:
        return s.Replicated(span=span, operator=";", statements=tuple(statements), body=body)

    def replicated_interface_parallel(
        self, span: Span, events: s.Expr, statements: list[s.Statement], body: s.Expr
    ) -> s.Replicated:
        return s.Replicated(span=span, operator="[|", statements=tuple(statements), body=body, events=events)

    def replicated_synchronised_choice(
        self, span: Span, events: s.Expr, statements: list[s.Statement], body: s.Expr
    ) -> s.Replicated:
        return s.Replicated(span=span, operator="[+", statements=tuple(statements), body=body, events=events)

    def replicated_linked_parallel(
        self, span: Span, links: list[Any], statements: list[s.Statement], body: s.Expr
    ) -> s.Replicated:
        return s.Replicated(span=span, operator="<->", statements=tuple(statements), body=body, links=tuple(links))

    def replicated_linked_parallel_with_statements(
        self,
        span: Span,
        links: list[Any],
        link_statements: list[s.Statement],
        statements: list[s.Statement],
        body: s.Expr,
    ) -> s.Replicated:
        return s.Replicated(
            span=span,
            operator="<->",
            statements=tuple(statements),
            body=body,
            links=tuple(links),
            link_statements=tuple(link_statements),
        )

    # --- operands --------------------------------------------------------------------------------------------

    def name(self, span: Span, token: int) -> s.Name:
        return s.Name(span=span, parts=tuple(self.tokens.text(token).split("::")))

    def integer(self, span: Span, token: int) -> s.LiteralExpr:
        digits = self.tokens.text(token)
        if len(digits) > LONGEST_INTEGER:
            self._refuse(messages.number_too_long(span, LONGEST_INTEGER))
            digits = "0"
        return s.LiteralExpr(span=span, kind="int", value=int(digits))

    def character(self, span: Span, token: int) -> s.LiteralExpr:
        inner = self.tokens.text(token)[1:-1]
        value = _ESCAPE.sub(lambda match: _CHARACTER_ESCAPES.get(match[1], match[1]), inner)
        return s.LiteralExpr(span=span, kind="char", value=value)

    def string(self, span: Span, token: int) -> s.LiteralExpr:
        inner = self.tokens.text(token)[1:-1]
        # FDR reads every escape that it does not know as a quote; a backslash, which it cannot write, is the exception.
        value = _ESCAPE.sub(lambda match: _STRING_ESCAPES.get(match[1], '"'), inner)
        return s.LiteralExpr(span=span, kind="string", value=value)

    def true(self, span: Span) -> s.LiteralExpr:
        return s.LiteralExpr(span=span, kind="bool", value=True)

    def false(self, span: Span) -> s.LiteralExpr:
        return s.LiteralExpr(span=span, kind="bool", value=False)

    def wildcard(self, span: Span) -> WildcardExpr:
        node = WildcardExpr(span=span)
        self._only_pattern(node)
        return node

    def paren(self, span: Span, inner: s.Expr) -> s.Paren:
        return s.Paren(span=span, inner=inner)

    def tuple_(self, span: Span, first: s.Expr, others: list[s.Expr]) -> s.TupleExpr:
        return s.TupleExpr(span=span, items=(first, *others))

    def set_(self, span: Span, items: list[s.Expr], statements: list[s.Statement] | None = None) -> s.SetExpr:
        return s.SetExpr(span=span, items=tuple(items), statements=_optional(statements))

    def set_from(self, span: Span, low: s.Expr, statements: list[s.Statement] | None = None) -> s.SetRange:
        return s.SetRange(span=span, low=low, high=None, statements=_optional(statements))

    def set_range(
        self, span: Span, low: s.Expr, high: s.Expr, statements: list[s.Statement] | None = None
    ) -> s.SetRange:
        return s.SetRange(span=span, low=low, high=high, statements=_optional(statements))

    def productions(
        self, span: Span, items: list[s.Expr], statements: list[s.Statement] | None = None
    ) -> s.Productions:
        return s.Productions(span=span, items=tuple(items), statements=_optional(statements))

    def sequence(self, span: Span, opening: int, items: list[s.Expr], *rest: Any) -> s.SequenceExpr:
        statements = rest[0] if len(rest) == 2 else None
        return s.SequenceExpr(span=span, items=tuple(items), statements=_optional(statements))

    def sequence_from(self, span: Span, opening: int, low: s.Expr, *rest: Any) -> s.SequenceRange:
        statements = rest[0] if len(rest) == 2 else None
        return s.SequenceRange(span=span, low=low, high=None, statements=_optional(statements))

    def sequence_range(self, span: Span, opening: int, low: s.Expr, high: s.Expr, *rest: Any) -> s.SequenceRange:
        statements = rest[0] if len(rest) == 2 else None
        return s.SequenceRange(span=span, low=low, high=high, statements=_optional(statements))

    def empty_map(self, span: Span) -> s.MapExpr:
        return s.MapExpr(span=span, items=())

    def map_(self, span: Span, items: list[tuple[s.Expr, s.Expr]]) -> s.MapExpr:
        return s.MapExpr(span=span, items=tuple(items))

    def apply(self, span: Span, function: s.Expr, arguments: list[s.Expr]) -> s.Apply:
        return s.Apply(span=span, function=function, arguments=tuple(arguments))

    def rename(
        self,
        span: Span,
        process: s.Expr,
        pairs: list[tuple[s.Expr, s.Expr]],
        statements: list[s.Statement] | None = None,
    ) -> s.Rename:
        return s.Rename(span=span, process=process, pairs=tuple(pairs), statements=_optional(statements))

    def pair(self, span: Span, left: s.Expr, right: s.Expr) -> tuple[s.Expr, s.Expr]:
        return (left, right)

    # --- statements ------------------------------------------------------------------------------------------

    def generator(self, span: Span, pattern: s.Expr, source: s.Expr) -> s.Generator:
        return s.Generator(span=span, pattern=self._pattern(pattern), source=source)

    def generator_with_colon(self, span: Span, pattern: s.Expr, source: s.Expr) -> s.Generator:
        return s.Generator(span=span, pattern=self._pattern(pattern), source=source, colon=True)

    def qualifier(self, span: Span, condition: s.Expr) -> s.Qualifier:
        return s.Qualifier(span=span, condition=condition)


def _optional(statements: list[s.Statement] | None) -> tuple[s.Statement, ...] | None:
    return None if statements is None else tuple(statements)


def _behind(head: ProcessHead, body: s.Expr | Headed) -> s.Expr | Headed:
    """*body* behind one more head: a node, unless something to the right may belong to it."""
    if isinstance(body, Headed):
        body.heads.append(head)
        return body
    return head.around(body)
