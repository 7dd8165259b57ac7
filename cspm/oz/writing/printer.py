"""From Object-Z paragraphs back to the text notation; terms are printed by
:mod:`cspcheck.cspm.oz.writing.printer_terms`.

What the parser makes of the text is the same tree. The sections of a class come in the order of the source, of a tree
that was made otherwise in the usual one. In ASCII each operator has the first of its spellings; with *symbols* the
mathematical one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial
from typing import TYPE_CHECKING, Final

from cspcheck.cspm.oz import syntax as z
from cspcheck.cspm.oz.writing.printer_terms import ANYWHERE, TermPlace, TermPrinter, bracketed, enclosed, names
from cspcheck.cspm.printing.brackets import ANYWHERE as EVERYWHERE
from cspcheck.cspm.printing.layout import HARD, LINE, WIDTH, Doc, cat, group, join, lay_out, nest, width
from cspcheck.cspm.recursion import deep_recursion
from cspcheck.cspm.syntax import tree as s

if TYPE_CHECKING:
    from cspcheck.cspm.printing.declarations import Printer
    from cspcheck.cspm.printing.patterns import Printing

_LOOSEST_FIRST: Final = ("parallel_open", "enrich", "parallel", "choice", "or", "and", "compose", "hide")
OPERATION_LEVELS: Final = {name: level for level, name in enumerate(_LOOSEST_FIRST, 1)}
_OPERATION_SIGNS: Final = {
    "parallel_open": ("||!", "||!"),
    "enrich": ("@", "•"),
    "parallel": ("||", "∥"),
    "choice": ("[]", "□"),
    "or": ("or", "∨"),
    "and": ("and", "∧"),
    "compose": (";", ";"),
    "hide": ("\\", "∖"),
}


def paragraph_document(node: s.Paragraph, printer: Printer) -> Printing:
    """A paragraph as a document, with the equations of a class as *printer* has them."""
    equations: list[Doc] = []
    if isinstance(node, z.Class):
        for equation in node.equations:
            equations.append((yield equation, EVERYWHERE))
    paragraphs = ParagraphPrinter(printer.symbols, printer.broken, printer.separate)
    paragraphs.from_source = printer.from_source
    with deep_recursion():
        return paragraphs.paragraph(node, equations)


def claim_text(node: s.Assertion) -> str:
    """A claim about classes, as an assertion has it."""
    match node:
        case z.Obligations():
            operation = "" if node.operation is None else f": {node.operation.name}"
            return f"{node.subject.name} :[{node.obligation or 'obligations'}]{operation}{_hints(node.hints)}"
        case z.DataRefinement():
            direction = " :[upward]" if node.upward else ""
            claim = f"{node.abstract.name} [OZ= {node.concrete.name} via {node.retrieve.name}{direction}"
            return claim + _hints(node.hints)
        case z.Subtype():
            return f"{node.parent.name} [OZ= {node.child.name}{_hints(node.hints)}"
    raise AssertionError(node)


def _uses(uses: Sequence[z.LemmaUse], symbols: bool = False) -> str:
    """Lemmas, with what they are used for."""
    shown = []
    for use in uses:
        arguments = [lay_out(TermPrinter(symbols).term(term), 10_000) for term in use.arguments]
        shown.append(use.name + (f"({', '.join(arguments)})" if arguments else ""))
    return ", ".join(shown)


def _hints(node: z.Hints | None, symbols: bool = False) -> str:
    """What helps a proof, with a blank before it; nothing where nothing does."""
    if node is None:
        return ""
    using = f" using {_uses(node.using, symbols)}" if node.using else ""
    return using + (f" by induction on {node.induction.name}" if node.induction is not None else "")


class ParagraphPrinter(TermPrinter):
    """Prints paragraphs and the sections of classes."""

    def paragraph(self, node: s.Paragraph, equations: Sequence[Doc] = ()) -> Doc:
        """The document of a paragraph; *equations* are those of the equations of a class, in their order."""
        match node:
            case z.GivenTypes():
                return f"given {names(node.names)}"
            case z.FreeType():
                branches = [self._branch(branch) for branch in node.branches]
                broken = any(self.broken(*two) for two in zip(node.branches, node.branches[1:], strict=False))
                return group(f"{node.name} ::=", nest(cat(LINE, join(cat(LINE, "| "), branches))), broken=broken)
            case z.Abbreviation():
                generics = f"[{names(node.generics)}]" if node.generics else ""
                return group(f"{node.name}{generics} == ", nest(self.term(node.body)))
            case z.Axiom():
                return self.axiom(node, closed=bool(node.predicates))
            case z.Schema():
                return self._schema(node)
            case z.Reading():
                subject = self.term(node.subject, TermPlace(7, "="))
                return cat("reading ", subject, " = ", self.term(node.carrier))
            case z.View():
                return f"view {node.kind}"
            case z.Retrieve():
                head = f"retrieve {node.name} between {node.abstract.name} and {node.concrete.name} where"
                return cat(head, self._lines(map(self.term, node.predicates)), HARD, "end")
            case z.Lemma():
                return self._lemma(node)
            case z.Class():
                return self._class(node, equations)
        raise AssertionError(node)

    def _lemma(self, node: z.Lemma) -> Doc:
        generics = f"[{names(node.generics)}]" if node.generics else ""
        hints = _hints(node.hints, self.symbols)
        head = cat(f"lemma {node.name}{generics} : ", nest(self.term(node.predicate)))
        if not hints:
            return head
        assert node.hints is not None
        separated = self.from_source and "\n" in _between(node.predicate, node.hints)
        return cat(head, nest(cat(HARD, hints.lstrip()))) if separated else cat(head, hints)

    def _branch(self, node: z.Branch) -> Doc:
        if node.argument is None:
            return node.name
        opening, closing = ("⟪", "⟫") if self.symbols else ("<<", ">>")
        return cat(node.name, opening, self.term(node.argument), closing)

    def _lines(self, docs: Iterable[Doc]) -> Doc:
        return nest(cat(*[part for doc in docs for part in (HARD, doc)]))

    def _where(self, predicates: Sequence[z.Term]) -> Doc:
        return cat(HARD, "where", self._lines(map(self.term, predicates))) if predicates else ""

    def axiom(self, node: z.Axiom, *, closed: bool) -> Doc:
        """Constants with their axioms; *closed* puts an ``end`` behind."""
        declarations = [self.declare(declaration) for declaration in node.declarations]
        end = " end" if closed else ""
        head = f"const [{names(node.generics)}]" if node.generics else "const"
        if len(declarations) == 1 and len(node.predicates) < 2 and not self._in_lines(node):
            line = cat(head, " ", declarations[0])
            for predicate in node.predicates:
                line = cat(line, " where ", self.term(predicate), end)
            if width(line) <= WIDTH - 12:
                return line
        lines = cat(head, " ", declarations[0]) if len(declarations) == 1 else cat(head, self._lines(declarations))
        return cat(lines, self._where(node.predicates), cat(HARD, "end") if closed else "")

    def _in_lines(self, node: z.Axiom | z.OperationSchema) -> bool:
        """Whether the source has the predicate of a short section on a line of its own."""
        if not self.from_source or not node.predicates:
            return False
        return "\n" in node.span.source.text[node.span.start : node.predicates[0].span.start]

    def _schema(self, node: z.Schema) -> Doc:
        initial: Doc = ""
        if node.initial is not None:
            initial = cat(HARD, "init", self._lines(map(self.term, node.initial)))
        declarations = self._lines(map(self.declare, node.declarations))
        generics = f"[{names(node.generics)}]" if node.generics else ""
        return cat(f"schema {node.name}{generics}", declarations, self._where(node.predicates), initial, HARD, "end")

    # --- classes ---------------------------------------------------------------------------------------------

    def _class(self, node: z.Class, equations: Sequence[Doc]) -> Doc:
        generics = f"[{names(node.generics)}]" if node.generics else ""
        sections = self._sections(node, equations)
        parts: list[Doc] = []
        for number, (section, doc) in enumerate(sections):
            large = isinstance(section, z.State | z.Initial | z.OperationSchema | z.OperationDefinition)
            if large and number and not self.from_source:
                parts.append(HARD)
            parts += [HARD, doc]
        return cat(f"class {node.name}{generics}", nest(cat(*parts)), HARD, "end")

    def _sections(self, node: z.Class, equations: Sequence[Doc]) -> list[tuple[s.Node | None, Doc]]:
        """The sections with their documents, in order."""
        found: list[tuple[s.Node, Callable[[], Doc]]] = []
        if node.visibility is not None:
            visible = node.visibility
            place: s.Node = visible[0] if visible else s.NameDeclaration(span=node.span, name="")
            found.append((place, lambda: f"visible {names(visible)}" if visible else "visible ()"))
        found += [(parents[0], partial(self._inherits, parents)) for parents in self._inherit_lines(node)]
        found += [(section, partial(self._interface, section)) for section in node.interface]
        found += [(equation, partial(cat, doc)) for equation, doc in zip(node.equations, equations, strict=True)]
        found += [(section, partial(self._local_paragraph, section)) for section in node.paragraphs]
        if node.state is not None:
            found.append((node.state, partial(self._state, node.state)))
        if node.initial is not None:
            found.append((node.initial, partial(self._initial, node.initial)))
        found += [(section, partial(self._operation, section)) for section in node.operations]
        source = node.span.source
        found.sort(key=lambda item: item[0].span.start if item[0].span.source is source else node.span.start)
        sections: list[tuple[s.Node | None, Doc]] = []
        for number, (section, make) in enumerate(found):
            doc = make()
            following = found[number + 1][0] if number + 1 < len(found) else None
            if following in node.equations and self._open_ended(section) and not _is_main(following):
                doc = cat(doc, HARD, "end")
            sections.append((section, doc))
        return sections

    def _inherit_lines(self, node: z.Class) -> list[list[z.Inherit]]:
        """The inherited classes, with those together that stand behind one ``inherit`` in the source."""
        lines: list[list[z.Inherit]] = []
        for parent in node.inherits:
            if self.from_source and lines and "inherit" not in _between(lines[-1][-1], parent):
                lines[-1].append(parent)
            else:
                lines.append([parent])
        return lines

    def _inherits(self, parents: Sequence[z.Inherit]) -> Doc:
        docs: list[Doc] = []
        for parent in parents:
            doc: Doc = parent.name
            if parent.arguments:
                doc = cat(doc, enclosed("[", [self.term(argument) for argument in parent.arguments], "]"))
            if parent.renamings:
                renamings = [f"{new.name}/{old.name}" for new, old in parent.renamings]
                doc = cat(doc, enclosed("[", renamings, "]"))
            docs.append(doc)
        return cat("inherit ", join(", ", docs))

    def _interface(self, node: z.Interface) -> Doc:
        head = f"{node.kind} {names(node.names)}"
        if not node.parameters:
            return head
        return group(head, " : [", nest(self.bound(node.parameters, ANYWHERE), 4), "]")

    def _local_paragraph(self, node: s.Paragraph) -> Doc:
        return self.axiom(node, closed=False) if isinstance(node, z.Axiom) else self.paragraph(node)

    def _state(self, node: z.State) -> Doc:
        parts: list[Doc] = ["state", self._lines(map(self.declare, node.primary))]
        if node.secondary:
            parts += [HARD, self.sign("Delta", "Δ"), self._lines(map(self.declare, node.secondary))]
        return cat(*parts, self._where(node.predicates))

    def _initial(self, node: z.Initial) -> Doc:
        return cat("init", self._lines(map(self.term, node.predicates)))

    # --- operations ------------------------------------------------------------------------------------------

    def _operation(self, node: z.OperationSchema | z.OperationDefinition) -> Doc:
        if isinstance(node, z.OperationDefinition):
            return cat(group(f"op {node.name} = ", nest(self.operations(node.body, 0))), self._using(node))
        if self._is_horizontal(node):
            return cat(group(f"op {node.name} = ", self._in_brackets(node)), self._using(node))
        delta = self._delta(node)
        using = self._using(node)
        if not (delta or node.declarations or using) and len(node.predicates) == 1 and not self._in_lines(node):
            line = cat(f"op {node.name} where ", self.term(node.predicates[0]))
            if width(line) <= WIDTH - 12:
                return line
        lines = self._lines([*delta, *map(self.declare, node.declarations)])
        return cat(f"op {node.name}", lines, self._where(node.predicates), using)

    def _using(self, node: z.OperationSchema | z.OperationDefinition) -> Doc:
        return cat(HARD, f"using {_uses(node.using, self.symbols)}") if node.using else ""

    def _delta(self, node: z.OperationSchema | z.OperationText) -> list[Doc]:
        return [] if node.delta is None else [cat(self.sign("Delta", "Δ"), "(", names(node.delta), ")")]

    def _open_ended(self, section: s.Node) -> bool:
        """Whether lines that follow a section would be read as part of it."""
        match section:
            case z.Axiom():
                return bool(section.predicates)
            case z.OperationSchema():
                return not self._is_horizontal(section) and not section.using
        return isinstance(section, z.State | z.Initial)

    def _is_horizontal(self, node: z.OperationSchema) -> bool:
        return self.from_source and node.span.text[len("op") :].lstrip()[len(node.name) :].lstrip().startswith("=")

    def _in_brackets(self, node: z.OperationSchema | z.OperationText) -> Doc:
        delta = self._delta(node)
        last = TermPlace(follow="|" if node.predicates else "")
        declarations = [
            self.declare(declaration, last if declaration is node.declarations[-1] else TermPlace(follow=";"))
            for declaration in node.declarations
        ]
        predicates = [
            self.term(predicate, ANYWHERE if predicate is node.predicates[-1] else TermPlace(follow=";"))
            for predicate in node.predicates
        ]
        parts: list[Doc] = [join(cat(";", LINE), [*delta, *declarations])]
        if predicates:
            # A single list without declarations needs no bar.
            if delta or declarations:
                parts.append(cat(" |", LINE))
            parts.append(join(cat(";", LINE), predicates))
        return group("[", nest(cat(*parts)), "]")

    def operations(self, node: z.Term, least: int = 0) -> Doc:
        """An expression over operations whose operators bind at least as tightly as *least*."""
        match node:
            case z.Grouped():
                return self._in_round_brackets(node.inner, self.operations(node.inner, 0))
            case z.Operator(name=name, operands=(left, right)) if name in OPERATION_LEVELS:
                level = OPERATION_LEVELS[name]
                sign = self.sign(*_OPERATION_SIGNS[name])
                if name == "compose" and self.from_source and ";" not in _between(left, right):
                    sign = "comp"
                first = self.operations(left, level)
                second = self._hidden(right) if name == "hide" else self.operations(right, level + 1)
                doc = cat(first, " ", sign, LINE, second)
                return bracketed(doc) if level < least else doc
            case z.OperationText():
                return self._in_brackets(node)
            case z.Renamed():
                renamings = [f"{new.name}{new.decoration}/{old.name}{old.decoration}" for new, old in node.renamings]
                return cat(self.operations(node.term, 9), enclosed("[", list(renamings), "]"))
            case z.Distributed():
                head = cat(self.sign(*_OPERATION_SIGNS[node.kind]), " ")
                last = TermPlace(follow="@" if node.condition is None else "|")
                parts: list[Doc] = [head, self.bound(node.declarations, last)]
                if node.condition is not None:
                    parts += [" | ", self.term(node.condition, TermPlace(follow="@"))]
                parts += [" ", self.sign("@", "•"), LINE, self.operations(node.body, 0)]
                return self._in_round_brackets(node, cat(*parts)) if least else cat(*parts)
        return self.term(node)

    def _in_round_brackets(self, node: z.Term, doc: Doc) -> Doc:
        # `(|` opens something else.
        begins = isinstance(node, z.Distributed) and node.kind == "parallel"
        return bracketed(cat(" ", doc) if begins else doc)

    def _hidden(self, node: z.Term) -> Doc:
        items = node.items if isinstance(node, z.Display) else (node,)
        braces = self.from_source and node.span.text.startswith("{")
        opening, closing = "{}" if braces else "()"
        return enclosed(opening, [self.term(item) for item in items], closing)


def _between(first: s.Node, second: s.Node) -> str:
    return first.span.source.text[first.span.end : second.span.start]


def _is_main(declaration: s.Node) -> bool:
    return (
        isinstance(declaration, s.PatternDefinition)
        and isinstance(declaration.pattern, s.NamePattern)
        and declaration.pattern.parts == ("main",)
    )


def print_term(node: z.Term, *, symbols: bool = False, width: int = WIDTH) -> str:
    """A term as text."""
    with deep_recursion():
        return lay_out(TermPrinter(symbols).term(node), width)


def print_paragraph(node: s.Paragraph, *, symbols: bool = False, width: int = WIDTH) -> str:
    """A paragraph as text."""
    from cspcheck.cspm.printing.declarations import Printer

    return lay_out(Printer(symbols=symbols).document(node), width)
