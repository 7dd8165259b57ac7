"""Expressions and patterns as documents, with brackets where the tree needs them and has none.

Each node is printed in a context that says how loosely it may bind and what follows it. Brackets are added

* around what binds more loosely than its place allows;
* around what extends to the right (``if``, ``let``, lambda, replicated operators) where something follows;
* around a sign (``-``, ``not``, ``#``) before an operator that binds more tightly than the sign;
* around a hidden process that does not stand at the beginning of its row, because ``\\`` hides in all before it;
* around ``>`` directly inside a sequence.

A tree that the parser made has all these brackets as ``Paren`` nodes already, so nothing is added to it.

Trees may be deeper than Python's stack. Printing a node is a generator that yields the parts it wants printed and
is sent their documents; :func:`document` runs the generators on a stack of its own.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace
from typing import Final, Protocol

from cspcheck.cspm.parsing.precedence import PARALLEL, PROCESS_LEVELS, SIGN_LEVELS, VALUE_LEVELS
from cspcheck.cspm.printing.brackets import (
    ANYWHERE,
    BOTH,
    DOT,
    OPERAND,
    STEP,
    NodePlace,
    after_colon,
    bracketed,
    captures,
    commas,
    enclosed,
    literal,
    needs_end,
    part_of,
)
from cspcheck.cspm.printing.layout import HARD, LINE, SOFT, Doc, cat, first_text, group, nest, width
from cspcheck.cspm.printing.patterns import PRINTS, Patterns, Printing
from cspcheck.cspm.syntax import tree as s


class Hint(Protocol):
    """Whether the layout should break between two nodes because the source does; see the formatter."""

    def __call__(self, first: s.Node, second: s.Node, *, by_comment: bool = False) -> bool:
        """With *by_comment*, whether a comment makes it necessary."""


class ExpressionPrinter(Patterns):
    """Prints expressions and patterns; declarations are added by a subclass."""

    def __init__(self, breaks: Hint | None = None, *, symbols: bool = False) -> None:
        self._breaks = breaks
        self.symbols = symbols
        """Whether Object-Z paragraphs are written with mathematical symbols."""

    def document(self, node: s.Node, place: NodePlace = ANYWHERE) -> Doc:
        """The document of any node."""
        stack: list[Printing] = []
        wanted, where = node, place
        while True:
            printed = self._print(wanted, where)
            value: Doc | None = None
            if isinstance(printed, Generator):
                stack.append(printed)
            else:
                value = printed
            while stack:
                try:
                    # A generator is started by sending None.
                    wanted, where = stack[-1].send(value)  # type: ignore[arg-type]
                    break
                except StopIteration as finished:
                    stack.pop()
                    value = finished.value
            else:
                assert value is not None
                return value

    def _print(self, node: s.Node, place: NodePlace) -> Printing | Doc:
        if isinstance(node, s.Paragraph):
            return self._paragraph(node)
        rule = PRINTS.get(type(node))
        if rule is None and isinstance(node, s.Assertion):
            return self._claim(node)
        assert rule is not None
        printed: Printing | Doc = rule(self, node, place)
        return printed

    def _claim(self, node: s.Assertion) -> Doc:
        raise NotImplementedError  # about a declaration

    def _paragraph(self, node: s.Paragraph) -> Printing:
        raise NotImplementedError  # a declaration

    def broken(self, first: s.Node, second: s.Node, *, by_comment: bool = False) -> bool:
        """Whether a line is to end between two nodes because one does in the source."""
        return self._breaks is not None and self._breaks(first, second, by_comment=by_comment)

    # --- operands --------------------------------------------------------------------------------------------

    @PRINTS(s.Name)
    def _print_name(self, node: s.Name, place: NodePlace) -> Doc:
        return node.text

    @PRINTS(s.LiteralExpr)
    def _print_literal_expr(self, node: s.LiteralExpr, place: NodePlace) -> Doc:
        text = literal(node.kind, node.value)
        return bracketed(text) if captures("-", place) and text.startswith("-") else text

    @PRINTS(s.Paren)
    def _print_paren(self, node: s.Paren, place: NodePlace) -> Printing:
        inner = yield node.inner, ANYWHERE
        return bracketed(inner)

    @PRINTS(s.TupleExpr)
    def _print_tuple_expr(self, node: s.TupleExpr, place: NodePlace) -> Printing:
        items = yield from self._items(node.items, ANYWHERE)
        return enclosed("(", items, ")", node.items)

    @PRINTS(s.SetExpr)
    def _print_set_expr(self, node: s.SetExpr, place: NodePlace) -> Printing:
        return (yield from self._comprehension("{", "}", node.items, node.statements, ANYWHERE))

    @PRINTS(s.Productions)
    def _print_productions(self, node: s.Productions, place: NodePlace) -> Printing:
        return (yield from self._comprehension("{|", "|}", node.items, node.statements, ANYWHERE))

    @PRINTS(s.SequenceExpr)
    def _print_sequence_expr(self, node: s.SequenceExpr, place: NodePlace) -> Printing:
        return (yield from self._comprehension("<", ">", node.items, node.statements, NodePlace(in_sequence=True)))

    @PRINTS(s.SetRange)
    def _print_set_range(self, node: s.SetRange, place: NodePlace) -> Printing:
        return (yield from self._range("{", "}", node, ANYWHERE))

    @PRINTS(s.SequenceRange)
    def _print_sequence_range(self, node: s.SequenceRange, place: NodePlace) -> Printing:
        return (yield from self._range("<", ">", node, NodePlace(in_sequence=True)))

    def _comprehension(
        self,
        opening: str,
        closing: str,
        items: Sequence[s.Expr],
        statements: Sequence[s.Statement] | None,
        inside: NodePlace,
    ) -> Printing:
        docs = yield from self._items(items, inside)
        if statements is None:
            return enclosed(opening, docs, closing, items)
        conditions = yield from self._items(statements, inside)
        behind = cat("| ", nest(commas(conditions)))
        whole = cat(commas(docs), nest(cat(LINE, behind))) if docs else behind
        return enclosed(opening, [whole], closing, statements)

    def _range(self, opening: str, closing: str, node: s.SetRange | s.SequenceRange, inside: NodePlace) -> Printing:
        inside = replace(inside, tight=True)
        low = yield node.low, inside
        if opening == "<" and first_text(low).startswith("-"):
            low = cat(" ", low)  # `<-` is a word of its own, which not every tool tells from these two
        parts = [low, ".."]
        if node.high is not None:
            parts.append((yield node.high, inside))
        if node.statements is not None:
            conditions = yield from self._items(node.statements, inside)
            parts.append(nest(cat(LINE, "| ", commas(conditions))))
        return enclosed(opening, [cat(*parts)], closing, ())

    @PRINTS(s.MapExpr)
    def _print_map_expr(self, node: s.MapExpr, place: NodePlace) -> Printing:
        if not node.items:
            return "(| |)"
        items: list[Doc] = []
        for key, value in node.items:
            key_doc = yield key, ANYWHERE
            value_doc = yield value, ANYWHERE
            items.append(group(key_doc, " =>", nest(cat(LINE, value_doc))))
        return group("(| ", nest(commas(items), 3), " |)")

    @PRINTS(s.Apply)
    def _print_apply(self, node: s.Apply, place: NodePlace) -> Printing:
        # f(x)(y)(z) is nested to the left.
        calls = []
        function: s.Expr = node
        while isinstance(function, s.Apply):
            calls.append(function.arguments)
            function = function.function
        parts = [(yield function, NodePlace(OPERAND, begins_row=False))]
        for arguments in reversed(calls):
            items = yield from self._items(arguments, ANYWHERE)
            parts.append(enclosed("(", items, ")", arguments))
        return cat(*parts)

    @PRINTS(s.Rename)
    def _print_rename(self, node: s.Rename, place: NodePlace) -> Printing:
        renamings = []
        process: s.Expr = node
        while isinstance(process, s.Rename):
            renamings.append(process)
            process = process.process
        parts = [(yield process, NodePlace(OPERAND, begins_row=False))]
        for renaming in reversed(renamings):
            pairs = yield from self._pairs(renaming.pairs, " <- ")
            inner = commas(pairs)
            if renaming.statements is not None:
                statements = yield from self._items(renaming.statements, ANYWHERE)
                inner = cat(inner, LINE, "| ", commas(statements))
            parts.append(group("[[", nest(cat(LINE, inner)), LINE, "]]"))
        return cat(*parts)

    def _pairs(
        self, pairs: Sequence[tuple[s.Expr, s.Expr]], sign: str
    ) -> Generator[tuple[s.Node, NodePlace], Doc, list[Doc]]:
        docs = []
        for left, right in pairs:
            left_doc = yield left, ANYWHERE
            right_doc = yield right, ANYWHERE
            docs.append(cat(left_doc, sign, right_doc))
        return docs

    # --- operators on values ---------------------------------------------------------------------------------

    @PRINTS(s.Unary)
    def _print_unary(self, node: s.Unary, place: NodePlace) -> Printing:
        signs = []
        operand: s.Expr = node
        while isinstance(operand, s.Unary):
            signs.append(operand.operator)
            operand = operand.operand
        brackets = any(captures(sign, place) for sign in signs)
        level = SIGN_LEVELS[signs[-1]] - 1
        inner = yield operand, part_of(place, brackets, level=level, begins_row=False)
        parts: list[Doc] = []
        for position, sign in enumerate(signs):
            following = signs[position + 1] if position + 1 < len(signs) else first_text(inner)
            parts.append("not " if sign == "not" else "- " if sign == "-" and following.startswith("-") else sign)
        doc = cat(*parts, inner)
        return bracketed(doc) if brackets else doc

    @PRINTS(s.Binary)
    def _print_binary(self, node: s.Binary, place: NodePlace) -> Printing:
        level = VALUE_LEVELS[node.operator]
        # Operators of one level associate to the left, comparisons not at all.
        spine = [node]
        while level != 7 and isinstance(spine[-1].left, s.Binary) and VALUE_LEVELS[spine[-1].left.operator] == level:
            spine.append(spine[-1].left)
        spine.reverse()
        brackets = level > place.level or (place.in_sequence and any(binary.operator == ">" for binary in spine))
        inside = part_of(place, brackets, begins_row=False, tight=place.tight and not brackets)
        first = yield spine[0].left, replace(inside, level=level if level != 7 else level - 1, follow=level)
        parts: list[Doc] = []
        for binary in spine:
            follow = inside.follow if binary is node else level
            right = yield binary.right, replace(inside, level=level - 1, follow=follow)
            tight = binary.operator == "^" or (
                place.tight and binary.operator in "+-*/%" and not first_text(right).startswith(("-", "\\"))
            )
            if tight:
                parts += [binary.operator, SOFT, right]
            else:
                parts += [f" {binary.operator}", LINE, right]
        doc = group(first, nest(cat(*parts)))
        return bracketed(doc) if brackets else doc

    @PRINTS(s.Dot)
    def _print_dot(self, node: s.Dot, place: NodePlace) -> Printing:
        brackets = place.level < DOT
        inside = part_of(place, brackets, level=DOT - 1, begins_row=False, tight=True)
        return (yield from self._dotted(node, inside, brackets))

    # --- processes -------------------------------------------------------------------------------------------

    @PRINTS(s.Prefix)
    def _print_prefix(self, node: s.Prefix, place: NodePlace) -> Printing:
        return (yield from self._steps(node, place))

    @PRINTS(s.Guard)
    def _print_guard(self, node: s.Guard, place: NodePlace) -> Printing:
        return (yield from self._steps(node, place))

    def _steps(self, node: s.Prefix | s.Guard, place: NodePlace) -> Printing:
        """A chain of prefixes and guards: as many to a line as fit."""
        brackets = place.level < STEP
        inside = part_of(place, brackets, level=DOT, begins_row=False)
        before = replace(inside, follow=STEP)
        chunks: list[Doc] = []
        edges: list[tuple[s.Node, s.Node]] = []  # what stands before and behind each arrow
        step: s.Expr = node
        while isinstance(step, s.Prefix | s.Guard):
            if isinstance(step, s.Prefix):
                pieces = [(yield step.channel, before)]
                for field in step.fields:
                    pieces.append((yield field, before))
                chunks.append(cat(*pieces, " ->"))
                edges.append((step.fields[-1] if step.fields else step.channel, step.body))
            else:
                chunks.append(cat((yield step.condition, before), " &"))
                edges.append((step.condition, step.body))
            step = step.body
        last = yield step, replace(inside, level=STEP)
        # One step to a line if the source has it so, else as many as fit.
        column = len(edges) > 1 and all(self.broken(*edge) for edge in edges)
        parts: list[Doc] = []
        hanging: Doc = ""
        for chunk, edge in zip([*chunks[1:], last], edges, strict=True):
            broken = column or self.broken(*edge, by_comment=True)
            if chunk is last and isinstance(step, s.Paren) and not broken:
                hanging = cat(" ", chunk)
            else:
                parts.append(group(LINE, chunk, broken=broken))
        doc = cat(chunks[0], nest(cat(*parts)), hanging)
        return bracketed(doc) if brackets else doc

    @PRINTS(s.Field)
    def _print_field(self, node: s.Field, place: NodePlace) -> Printing:
        if node.kind == "!":
            assert node.expression is not None
            return cat("!", (yield node.expression, place))
        assert node.pattern is not None
        pattern = yield node.pattern, place
        if node.restriction is None:
            return cat(node.kind, pattern)
        return cat(node.kind, pattern, ":", (yield node.restriction, place))

    @PRINTS(s.ProcessBinary)
    def _print_process_binary(self, node: s.ProcessBinary, place: NodePlace) -> Printing:
        return (yield from self._row(node, place))

    @PRINTS(s.Synchronised)
    def _print_synchronised(self, node: s.Synchronised, place: NodePlace) -> Printing:
        return (yield from self._row(node, place))

    @PRINTS(s.AlphabetisedParallel)
    def _print_alphabetised_parallel(self, node: s.AlphabetisedParallel, place: NodePlace) -> Printing:
        return (yield from self._row(node, place))

    @PRINTS(s.ClassParallel)
    def _print_class_parallel(self, node: s.ClassParallel, place: NodePlace) -> Printing:
        return (yield from self._row(node, place))

    @PRINTS(s.LinkedParallel)
    def _print_linked_parallel(self, node: s.LinkedParallel, place: NodePlace) -> Printing:
        return (yield from self._row(node, place))

    @PRINTS(s.Hide)
    def _print_hide(self, node: s.Hide, place: NodePlace) -> Printing:
        return (yield from self._row(node, place))

    def _row(self, node: s.Expr, place: NodePlace) -> Printing:
        """A row of process operators of one level, one operand to a line if they do not fit on one."""
        level = _level(node)
        hiding = isinstance(node, s.Hide)
        brackets = not place.begins_row if hiding else level > place.level
        inside = part_of(place, brackets)
        # Left of hiding stands everything; else operators of one level associate to the left, parallel ones (but
        # for compositions of classes) do not.
        alone = level == PROCESS_LEVELS["[|"]
        spine = [node]
        while _level(left := _left(spine[-1])) == level and (
            not alone or (isinstance(left, s.ClassParallel) and isinstance(node, s.ClassParallel))
        ):
            spine.append(left)
        spine.reverse()
        first = _left(spine[0])
        parts = [(yield first, replace(inside, level=BOTH if hiding else level - 1, follow=level))]
        broken = False
        before: s.Node = first
        for operation in spine:
            operator = yield from self._operator(operation)
            right = _right(operation)
            follow = inside.follow if operation is node else level
            allowed = STEP if hiding else level - 1
            operand = yield right, replace(inside, level=allowed, follow=follow, begins_row=False)
            # What is in brackets hangs on them, else lines go on under the operand.
            hanging = 0 if isinstance(right, s.Paren) else min(width(operator) + 1, 4)
            parts += [LINE, operator, " ", nest(operand, hanging)]
            broken = broken or self.broken(before, right)
            before = right
        doc = group(*parts, broken=broken)
        return bracketed(doc) if brackets else doc

    def _operator(self, node: s.Expr) -> Printing:
        match node:
            case s.ProcessBinary(operator=operator):
                return operator
            case s.Hide(keep=keep):
                return "|\\" if keep else "\\"
            case s.Synchronised(operator=operator, events=events):
                opening, closing = _BRACKETS[operator]
                inner = yield events, ANYWHERE
                return cat(f"{opening} ", inner, f" {closing}")
            case s.AlphabetisedParallel(left_alphabet=left, right_alphabet=right):
                left_doc = yield left, ANYWHERE
                right_doc = yield right, ANYWHERE
                return cat("[ ", left_doc, " || ", right_doc, " ]")
            case s.ClassParallel():
                return "||"
            case s.LinkedParallel(links=links, statements=statements):
                return (yield from self._links(links, statements))
        raise AssertionError(node)

    def _links(self, links: Sequence[tuple[s.Expr, s.Expr]], statements: Sequence[s.Statement] | None) -> Printing:
        inner = commas((yield from self._pairs(links, " <-> ")))
        if statements is not None:
            conditions = yield from self._items(statements, ANYWHERE)
            inner = cat(inner, LINE, "| ", commas(conditions))
        return group("[ ", nest(inner), " ]")

    # --- what extends to the right ---------------------------------------------------------------------------

    @PRINTS(s.If)
    def _print_if(self, node: s.If, place: NodePlace) -> Printing:
        brackets = needs_end(place)
        inside = part_of(place, brackets, level=BOTH, follow=None, begins_row=True)
        parts: list[Doc] = []
        broken = False
        branch: s.Expr = node
        while isinstance(branch, s.If):
            condition = yield branch.condition, inside
            then = yield branch.then, inside
            parts += ["if ", nest(condition, 3), " then", nest(cat(LINE, then)), LINE, "else"]
            broken = broken or self.broken(branch.condition, branch.then) or self.broken(branch.then, branch.otherwise)
            branch = branch.otherwise
            if isinstance(branch, s.If):
                parts.append(" ")
        otherwise = yield branch, inside
        doc = group(*parts, nest(cat(LINE, otherwise)), broken=broken)
        return bracketed(doc) if brackets else doc

    @PRINTS(s.Let)
    def _print_let(self, node: s.Let, place: NodePlace) -> Printing:
        brackets = needs_end(place)
        inside = part_of(place, brackets, level=BOTH, follow=None, begins_row=True)
        lines: list[Doc] = []
        for declaration in node.declarations:
            if lines:
                lines.append(HARD)
            lines.append((yield declaration, ANYWHERE))
        body = yield node.body, inside
        broken = bool(node.declarations) and self.broken(node.declarations[-1], node.body)
        doc = group("let", nest(cat(LINE, *lines)), LINE, group("within", nest(cat(LINE, body))), broken=broken)
        return bracketed(doc) if brackets else doc

    @PRINTS(s.Lambda)
    def _print_lambda(self, node: s.Lambda, place: NodePlace) -> Printing:
        brackets = needs_end(place)
        inside = part_of(place, brackets, level=BOTH, follow=None, begins_row=True)
        parameters = yield from self._items(node.parameters, inside)
        body = yield node.body, inside
        doc = group("\\ ", commas(parameters), " @", nest(cat(LINE, body)))
        return bracketed(doc) if brackets else doc

    @PRINTS(s.Replicated)
    def _print_replicated(self, node: s.Replicated, place: NodePlace) -> Printing:
        if node.operator == "||":
            # It ends in a bracket, and takes in no more than the right operand of `[A || B]` would.
            brackets = place.level < STEP or (place.follow is not None and place.follow <= PARALLEL)
            behind = part_of(place, brackets, level=PARALLEL - 1, begins_row=False)
        else:
            brackets = needs_end(place)
            behind = part_of(place, brackets, level=BOTH, follow=None, begins_row=True)
        inside = part_of(place, brackets, level=BOTH, follow=None, begins_row=True)
        alphabet: Doc = ""
        operator: Doc
        if node.operator in ("[|", "[+"):
            assert node.events is not None
            opening, closing = _BRACKETS[node.operator]
            events = yield node.events, ANYWHERE
            operator = cat(f"{opening} ", events, f" {closing}")
        elif node.operator == "<->":
            operator = yield from self._links(node.links, node.link_statements)
        else:
            operator = node.operator
            if node.operator == "||":
                assert node.events is not None
                events = yield node.events, ANYWHERE
                # Not `[[` nor `[|`.
                blank = " " if first_text(events).startswith(("[", "|")) else ""
                alphabet = cat(f" [{blank}", events, "]")
        statements = yield from self._items(node.statements, inside)
        body = yield node.body, behind
        doc = group(operator, " ", nest(commas(statements)), " @", alphabet, nest(cat(LINE, body)))
        return bracketed(doc) if brackets else doc

    # --- statements ------------------------------------------------------------------------------------------

    @PRINTS(s.Generator)
    def _print_generator(self, node: s.Generator, place: NodePlace) -> Printing:
        pattern = yield node.pattern, place
        source = yield node.source, place
        return cat(pattern, " : ", after_colon(source)) if node.colon else cat(pattern, " <- ", source)

    @PRINTS(s.Qualifier)
    def _print_qualifier(self, node: s.Qualifier, place: NodePlace) -> Printing:
        return (yield node.condition, place)


_BRACKETS: Final = {"[|": ("[|", "|]"), "[+": ("[+", "+]"), "/+": ("/+", "+\\"), "[|>": ("[|", "|>")}


def _level(node: s.Expr) -> int:
    match node:
        case s.ProcessBinary(operator=operator) | s.Synchronised(operator=operator):
            return PROCESS_LEVELS[operator]
        case s.AlphabetisedParallel():
            return PROCESS_LEVELS["||"]
        case s.LinkedParallel():
            return PROCESS_LEVELS["<->"]
        case s.ClassParallel():
            return PROCESS_LEVELS["COMPOSES"]
        case s.Hide():
            return PROCESS_LEVELS["\\"]
        case _:
            return 0


_ROWS: Final = (*(s.ProcessBinary, s.Synchronised, s.AlphabetisedParallel, s.LinkedParallel, s.ClassParallel, s.Hide),)


def _left(node: s.Expr) -> s.Expr:
    assert isinstance(node, _ROWS)
    return node.process if isinstance(node, s.Hide) else node.left


def _right(node: s.Expr) -> s.Expr:
    assert isinstance(node, _ROWS)
    return node.events if isinstance(node, s.Hide) else node.right
