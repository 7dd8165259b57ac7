"""Declarations, assertions and written types as documents."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import pairwise
from typing import Final

from cspcheck.cspm.notation import extension
from cspcheck.cspm.printing.brackets import ANYWHERE, NodePlace, after_colon, bracketed, commas, enclosed
from cspcheck.cspm.printing.expressions import ExpressionPrinter
from cspcheck.cspm.printing.layout import HARD, LINE, SOFT, Doc, cat, group, join, nest
from cspcheck.cspm.printing.patterns import PRINTS, Printing
from cspcheck.cspm.syntax import tree as s

# How loosely a type may bind in a place.
_SIMPLE: Final = NodePlace(1)
_DOTTED: Final = NodePlace(2)
_DOTABLE: Final = NodePlace(3)

_COMMENT = re.compile(r"--[^\n]*|\{-.*?-\}", re.DOTALL)
_CONJUNCTION = re.compile(r"\band\b|∧|/\\")

_HANGING: Final = (s.SetExpr, s.SequenceExpr, s.TupleExpr, s.MapExpr, s.Apply, s.Paren, s.Productions)
"""Bodies that stay on the line of their `=` when they need several lines."""


class Printer(ExpressionPrinter):
    """Prints any node of a script."""

    def lines(self, declarations: Sequence[s.Declaration]) -> Printing:
        """Declarations on lines of their own, with a blank line around those that take several."""
        parts: list[Doc] = []
        previous: s.Declaration | None = None
        for declaration in declarations:
            doc = yield declaration, ANYWHERE
            if previous is not None:
                parts += [HARD, HARD] if self._apart(previous, declaration) else [HARD]
            parts.append(doc)
            previous = declaration
        return cat(*parts)

    def _apart(self, first: s.Declaration, second: s.Declaration) -> bool:
        """Whether a blank line stands between two declarations. The formatter keeps those of the source instead."""
        if self._breaks is not None:
            return False
        if isinstance(first, s.AnnotationDeclaration):
            return False
        large = (s.ModuleDeclaration, s.TimedDeclaration, s.FunctionDefinition, s.DatatypeDeclaration)
        if isinstance(first, large) or isinstance(second, large) or _is_block(first) or _is_block(second):
            return True
        return isinstance(second, s.AnnotationDeclaration) or type(first) is not type(second)

    # --- Object-Z --------------------------------------------------------------------------------------------

    def _paragraph(self, node: s.Paragraph) -> Printing:
        return (yield from extension().print_paragraph(node, self))

    def _claim(self, node: s.Assertion) -> Doc:
        return extension().print_claim(node)

    @property
    def from_source(self) -> bool:
        """Whether the layout follows that of a source."""
        return self._breaks is not None

    def separate(self, first: s.Node, second: s.Node) -> bool:
        """Whether two conjuncts of a branch stand on lines of their own in the source, with no `and` between."""
        if self._breaks is None:
            return False
        between = first.span.source.text[first.span.end : second.span.start]
        return not _CONJUNCTION.search(_COMMENT.sub("", between))

    # --- scripts and definitions -----------------------------------------------------------------------------

    @PRINTS(s.Script)
    def _print_script(self, node: s.Script, place: NodePlace) -> Printing:
        return (yield from self.lines(node.declarations))

    @PRINTS(s.FunctionDefinition)
    def _print_function_definition(self, node: s.FunctionDefinition, place: NodePlace) -> Printing:
        clauses: list[Doc] = []
        for clause in node.clauses:
            parts: list[Doc] = [node.name]
            for parameters in clause.groups:
                parts.append(enclosed("(", (yield from self._items(parameters, ANYWHERE)), ")", parameters))
            clauses.append((yield from self._definition(cat(*parts), clause, clause.body)))
        return join(HARD, clauses)

    @PRINTS(s.PatternDefinition)
    def _print_pattern_definition(self, node: s.PatternDefinition, place: NodePlace) -> Printing:
        head = yield node.pattern, ANYWHERE
        return (yield from self._definition(head, node.pattern, node.body))

    def _definition(self, head: Doc, before: s.Node, body: s.Expr) -> Printing:
        doc = yield body, ANYWHERE
        if isinstance(body, _HANGING):
            return cat(head, " = ", doc)
        return group(head, " =", nest(cat(LINE, doc)))

    @PRINTS(s.AnnotationDeclaration)
    def _print_annotation_declaration(self, node: s.AnnotationDeclaration, place: NodePlace) -> Printing:
        names = ", ".join(name.name for name in node.names)
        return group(names, " ::", nest(cat(LINE, (yield node.scheme, ANYWHERE))))

    @PRINTS(s.ChannelDeclaration)
    def _print_channel_declaration(self, node: s.ChannelDeclaration, place: NodePlace) -> Printing:
        names = commas_filled([name.name for name in node.names])
        if node.fields is None:
            return cat("channel ", nest(names, 4))
        fields = yield node.fields, ANYWHERE
        return group("channel ", nest(names, 4), " :", nest(cat(LINE, after_colon(fields)), 4))

    @PRINTS(s.DatatypeDeclaration)
    def _print_datatype_declaration(self, node: s.DatatypeDeclaration, place: NodePlace) -> Printing:
        constructors: list[Doc] = []
        for constructor in node.constructors:
            constructors.append((yield constructor, ANYWHERE))
        keyword = "subtype" if node.subtype else "datatype"
        broken = any(self.broken(*two) for two in pairwise(node.constructors))
        return group(f"{keyword} {node.name} =", nest(cat(LINE, join(cat(LINE, "| "), constructors))), broken=broken)

    @PRINTS(s.Constructor)
    def _print_constructor(self, node: s.Constructor, place: NodePlace) -> Doc | Printing:
        return node.name if node.fields is None else self._constructor(node.name, node.fields)

    def _constructor(self, name: str, fields: s.Expr) -> Printing:
        return cat(f"{name}.", (yield fields, NodePlace(tight=True)))

    @PRINTS(s.NametypeDeclaration)
    def _print_nametype_declaration(self, node: s.NametypeDeclaration, place: NodePlace) -> Printing:
        return group(f"nametype {node.name} =", nest(cat(LINE, (yield node.body, ANYWHERE))))

    @PRINTS(s.ImportDeclaration)
    def _print_import_declaration(self, node: s.ImportDeclaration, place: NodePlace) -> Doc:
        return cat(f"{node.kind} ", nest(commas_filled([name.name for name in node.names]), 4))

    @PRINTS(s.IncludeDeclaration)
    def _print_include_declaration(self, node: s.IncludeDeclaration, place: NodePlace) -> Doc:
        return f'include "{node.path}"'

    @PRINTS(s.PrintDeclaration)
    def _print_print_declaration(self, node: s.PrintDeclaration, place: NodePlace) -> Printing:
        return cat("print ", nest((yield node.expression, ANYWHERE)))

    # --- modules and sections --------------------------------------------------------------------------------

    @PRINTS(s.ModuleDeclaration)
    def _print_module_declaration(self, node: s.ModuleDeclaration, place: NodePlace) -> Printing:
        header: Doc = f"module {node.name}"
        if node.parameters:
            parameters = yield from self._items(node.parameters, ANYWHERE)
            header = cat(header, enclosed("(", parameters, ")", node.parameters))
        private = yield from self._block(node.private)
        exported = yield from self._block(node.exported)
        return cat(header, private, HARD, "exports", exported, HARD, "endmodule")

    def _block(self, declarations: Sequence[s.Declaration]) -> Printing:
        if not declarations:
            return ""
        return nest(cat(HARD, (yield from self.lines(declarations))))

    @PRINTS(s.InstanceDeclaration)
    def _print_instance_declaration(self, node: s.InstanceDeclaration, place: NodePlace) -> Printing:
        module = yield node.module, ANYWHERE
        if node.arguments:
            arguments = yield from self._items(node.arguments, ANYWHERE)
            module = cat(module, enclosed("(", arguments, ")", node.arguments))
        return cat(f"instance {node.name} = ", module)

    @PRINTS(s.TimedDeclaration)
    def _print_timed_declaration(self, node: s.TimedDeclaration, place: NodePlace) -> Printing:
        header: Doc = "Timed {"
        if node.duration is not None:
            header = cat("Timed", bracketed((yield node.duration, ANYWHERE)), " {")
        return cat(header, (yield from self._block(node.declarations)), HARD, "}")

    # --- assertions ------------------------------------------------------------------------------------------

    @PRINTS(s.AssertDeclaration)
    def _print_assert_declaration(self, node: s.AssertDeclaration, place: NodePlace) -> Printing:
        return cat("assert ", (yield node.assertion, ANYWHERE))

    @PRINTS(s.NotAssertion)
    def _print_not_assertion(self, node: s.NotAssertion, place: NodePlace) -> Printing:
        negations = 1
        inner: s.Assertion = node.inner
        while isinstance(inner, s.NotAssertion):
            negations += 1
            inner = inner.inner
        doc = yield inner, ANYWHERE
        # Before a Boolean, `not` is an operator of the expression.
        return cat("not " * negations, bracketed(doc) if isinstance(inner, s.BooleanAssertion) else doc)

    @PRINTS(s.Refinement)
    def _print_refinement(self, node: s.Refinement, place: NodePlace) -> Printing:
        specification = yield from self._claimed(node.specification)
        implementation = yield node.implementation, ANYWHERE
        options = yield from self._items(node.options, ANYWHERE)
        return group(
            specification, nest(cat(LINE, f"[{node.model}= ", nest(implementation), *(cat(LINE, o) for o in options)))
        )

    @PRINTS(s.Property)
    def _print_property(self, node: s.Property, place: NodePlace) -> Printing:
        process = yield from self._claimed(node.process)
        model = "" if node.model is None else f" [{node.model}]"
        parts: list[Doc] = [LINE, f":[{node.kind}{model}]"]
        if node.trace is not None:
            parts += [": ", after_colon((yield node.trace, ANYWHERE))]
        for option in node.options:
            parts += [LINE, (yield option, ANYWHERE)]
        return group(process, nest(cat(*parts)))

    def _claimed(self, process: s.Expr) -> Printing:
        """The process of an assertion; a `not` in front of it would negate the assertion."""
        doc = yield process, ANYWHERE
        return bracketed(doc) if _begins_with_not(process) else doc

    @PRINTS(s.BooleanAssertion)
    def _print_boolean_assertion(self, node: s.BooleanAssertion, place: NodePlace) -> Printing:
        return (yield node.condition, ANYWHERE)

    @PRINTS(s.AssertOption)
    def _print_assert_option(self, node: s.AssertOption, place: NodePlace) -> Doc | Printing:
        if node.events is not None:
            return self._priority(node.events)
        if node.kind == "symmetry reduce":
            return self._symmetry(node.types)
        return ":[partial order reduce]" if node.mode is None else f":[partial order reduce [{node.mode}]]"

    def _symmetry(self, types: Sequence[s.Expr]) -> Printing:
        docs = yield from self._items(types, ANYWHERE)
        return cat(":[symmetry reduce]: ", commas(docs)) if docs else ":[symmetry reduce]:"

    def _priority(self, events: s.Expr) -> Printing:
        return cat(":[tau priority]: ", after_colon((yield events, ANYWHERE)))

    # --- types -----------------------------------------------------------------------------------------------

    @PRINTS(s.TypeScheme)
    def _print_type_scheme(self, node: s.TypeScheme, place: NodePlace) -> Printing:
        body = yield node.type, ANYWHERE
        constraints = ", ".join(f"{c.constraint} {c.variable}" for c in node.constraints)
        if not constraints:
            return body
        return cat(f"({constraints})" if len(node.constraints) > 1 else constraints, " => ", body)

    @PRINTS(s.TypeName)
    def _print_type_name(self, node: s.TypeName, place: NodePlace) -> Doc:
        return "::".join(node.parts)

    @PRINTS(s.SetType)
    def _print_set_type(self, node: s.SetType, place: NodePlace) -> Printing:
        return cat("{", (yield node.element, ANYWHERE), "}")

    @PRINTS(s.SequenceType)
    def _print_sequence_type(self, node: s.SequenceType, place: NodePlace) -> Printing:
        return cat("<", (yield node.element, ANYWHERE), ">")

    @PRINTS(s.TupleType)
    def _print_tuple_type(self, node: s.TupleType, place: NodePlace) -> Printing:
        return group("(", nest(cat(SOFT, commas((yield from self._items(node.items, ANYWHERE))))), SOFT, ")")

    @PRINTS(s.MapType)
    def _print_map_type(self, node: s.MapType, place: NodePlace) -> Printing:
        key = yield node.key, _DOTTED
        value = yield node.value, ANYWHERE
        return cat("(| ", key, " => ", value, " |)")

    @PRINTS(s.FunctionType)
    def _print_function_type(self, node: s.FunctionType, place: NodePlace) -> Printing:
        # (a) -> (b) -> c is nested to the right.
        parts: list[Doc] = []
        result: s.TypeExpr = node
        while isinstance(result, s.FunctionType):
            parameters = yield from self._items(result.parameters, ANYWHERE)
            parts += [group("(", nest(cat(SOFT, commas(parameters))), SOFT, ")"), " ->", LINE]
            result = result.result
        doc = cat(*parts, (yield result, _DOTABLE))
        return bracketed(doc) if place.level <= _DOTABLE.level else doc

    @PRINTS(s.DotableType)
    def _print_dotable_type(self, node: s.DotableType, place: NodePlace) -> Printing:
        parts: list[Doc] = []
        result: s.TypeExpr = node
        while isinstance(result, s.DotableType):
            parts += [(yield result.argument, _DOTTED), " =>*" if result.extendable else " =>", LINE]
            result = result.result
        doc = cat(*parts, (yield result, _DOTABLE))
        return bracketed(doc) if place.level <= _DOTTED.level else doc

    @PRINTS(s.DotType)
    def _print_dot_type(self, node: s.DotType, place: NodePlace) -> Printing:
        parts: list[Doc] = []
        right: s.TypeExpr = node
        while isinstance(right, s.DotType):
            parts += [(yield right.left, _SIMPLE), "."]
            right = right.right
        doc = cat(*parts, (yield right, _DOTTED))
        return bracketed(doc) if place.level <= _SIMPLE.level else doc


def _is_block(declaration: s.Declaration) -> bool:
    return isinstance(declaration, s.Paragraph) and declaration.is_block


def commas_filled(names: Sequence[str]) -> Doc:
    """Names with commas, as many to a line as fit."""
    return cat(names[0], *(cat(",", group(LINE, name)) for name in names[1:]))


def _begins_with_not(node: s.Expr) -> bool:
    """Whether the text of an expression begins with ``not``."""
    while True:
        match node:
            case s.Unary(operator=operator):
                return operator == "not"
            case s.Hide(process=left) | s.Rename(process=left):
                node = left
            case s.Prefix(channel=left) | s.Guard(condition=left):
                node = left
            case (
                s.ClassParallel(left=left)
                | s.Binary(left=left)
                | s.Dot(left=left)
                | s.ProcessBinary(left=left)
                | s.Synchronised(left=left)
                | s.AlphabetisedParallel(left=left)
                | s.LinkedParallel(left=left)
            ):
                node = left
            case s.Apply(function=left):
                node = left
            case _:
                return False
