"""CSP-OZ: classes that join a CSP process with an Object-Z part, beside ordinary CSPm in one script.

A floor above the rest of ``cspm``: importing it registers the notation (:mod:`cspcheck.cspm.notation`), and nothing
more; the rooms are entered when a script has a paragraph.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.notation import ClassReading, Document, Extension, Paragraphs, register

if TYPE_CHECKING:
    from cspcheck.cspm.diagnostics import Diagnostic
    from cspcheck.cspm.parsing.lexer import Tokens
    from cspcheck.cspm.printing.declarations import Printer
    from cspcheck.cspm.printing.patterns import Printing
    from cspcheck.cspm.source import Source, Span
    from cspcheck.cspm.syntax import tree as s
    from cspcheck.cspm.typing.inference.context import InferenceContext
    from cspcheck.cspm.typing.types import Type


class ObjectZ(Extension):
    """Object-Z paragraphs: classes, types, constants, schemas, readings, retrieve relations, and claims about them."""

    def paragraph_end(self, tokens: Tokens, begin: int, *, free: bool) -> int | None:  # noqa: D102
        from cspcheck.cspm.oz.reading.lexer import ABBREVIATION, PARAGRAPH, extent

        text = tokens.source.text
        if not PARAGRAPH.match(text, begin) and not (free and ABBREVIATION.match(text, begin)):
            return None
        found = extent(tokens.source, begin)
        tokens.comments.extend(found.comments)
        return found.end

    def paragraph(self, source: Source, start: int, end: int) -> tuple[s.Declaration, list[Diagnostic]]:  # noqa: D102
        from cspcheck.cspm.oz.reading.reader import parse_paragraph

        return parse_paragraph(source, start, end)

    def document(  # noqa: D102
        self, source: Source, include: Callable[[str, Span], tuple[s.Declaration, ...]]
    ) -> Document:
        from cspcheck.cspm.oz.reading import latex_reader

        return latex_reader.LatexDocument(source, include)

    def obligations(self, **fields: Any) -> s.Assertion:  # noqa: D102
        from cspcheck.cspm.oz.syntax import Obligations

        return Obligations(**fields)

    def hints(self, *, names: tuple[s.NameDeclaration, ...], **fields: Any) -> s.Node:  # noqa: D102
        from cspcheck.cspm.oz.syntax import Hints, LemmaUse

        return Hints(using=tuple([LemmaUse(span=name.span, name=name.name) for name in names]), **fields)

    def subtype(self, **fields: Any) -> s.Assertion:  # noqa: D102
        from cspcheck.cspm.oz.syntax import Subtype

        return Subtype(**fields)

    def data_refinement(self, **fields: Any) -> s.Assertion:  # noqa: D102
        from cspcheck.cspm.oz.syntax import DataRefinement

        return DataRefinement(**fields)

    def print_paragraph(self, node: s.Paragraph, printer: Printer) -> Printing:  # noqa: D102
        from cspcheck.cspm.oz.writing.printer import paragraph_document

        return paragraph_document(node, printer)

    def print_claim(self, node: s.Assertion) -> str:  # noqa: D102
        from cspcheck.cspm.oz.writing.printer import claim_text

        return claim_text(node)

    def expanded(self, tokens: Tokens, script: s.Script) -> tuple[Tokens, frozenset[int]]:  # noqa: D102
        from cspcheck.cspm.oz.reading.expansion import expanded

        return expanded(tokens, script)

    def elaborated(self, tree: s.Script, semantics: ClassReading | None) -> tuple[Paragraphs, s.Script]:  # noqa: D102
        from cspcheck.cspm.oz.processes.classes import classes_of_tree

        return classes_of_tree(tree, semantics)

    def foreign_type(self, context: InferenceContext, node: s.Foreign) -> Type:  # noqa: D102
        from cspcheck.cspm.oz.processes.inferring import foreign_type

        return foreign_type(context, node)


register(ObjectZ())
