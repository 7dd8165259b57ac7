"""Answers to what an editor asks about a text, from its analysis."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from difflib import SequenceMatcher
from typing import Any

from lsprotocol import types

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.oz import syntax as oz
from cspcheck.cspm.parsing.reading import parse_expression
from cspcheck.cspm.prelude import BUILTINS, EXTERNAL, TRANSPARENT
from cspcheck.cspm.printing.formatter import format_source
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.editing.analysis import Analysis, Open, analyse
from cspcheck.editing.occurrences import Occurrence
from cspcheck.editing.places import location, offset, position, range_of, uri_of

_WORDS = """
    and assert channel datatype else endmodule exports external if include instance let module nametype not or print
    subtype then Timed transparent within
    """
KEYWORDS = tuple(_WORDS.split())
PROPERTIES = ("deadlock free", "divergence free", "livelock free", "deterministic", "has trace", "obligations")
_NO_CLASSES = "CSP626"
_ORIGIN = "cspcheck"


def diagnostics(found: Analysis) -> dict[str, list[types.Diagnostic]]:
    """What is wrong, by the address of the file that it is in; the file itself always has an entry.

    An editor serves every LaTeX document here: that one has no classes is nothing to be told.
    """
    result: dict[str, list[types.Diagnostic]] = {uri_of(found.source.name): []}
    for diagnostic in found.diagnostics:
        if diagnostic.code == _NO_CLASSES:
            continue
        uri, converted = convert(diagnostic, found.source)
        result.setdefault(uri, []).append(converted)
    return result


def convert(diagnostic: Diagnostic, source: Source) -> tuple[str, types.Diagnostic]:
    """A diagnostic, and the address of its file; one without a place stands at the beginning of *source*."""
    span = diagnostic.span or source.span(0, 0)
    parts = [diagnostic.message, *diagnostic.notes]
    if diagnostic.help:
        parts.append(f"help: {diagnostic.help}")
    return uri_of(span.source.name), types.Diagnostic(
        range_of(span),
        "\n".join(parts),
        severity=types.DiagnosticSeverity.Error
        if diagnostic.severity is Severity.ERROR
        else types.DiagnosticSeverity.Warning,
        code=diagnostic.code,
        source=_ORIGIN,
        related_information=[
            types.DiagnosticRelatedInformation(location(label.span), label.message) for label in diagnostic.labels
        ],
    )


_KINDS = {
    SymbolKind.VARIABLE: "variable",
    SymbolKind.VALUE: "definition",
    SymbolKind.FUNCTION: "function",
    SymbolKind.CHANNEL: "channel",
    SymbolKind.CONSTRUCTOR: "constructor",
    SymbolKind.DATATYPE: "datatype",
    SymbolKind.SUBTYPE: "subtype",
    SymbolKind.NAMETYPE: "nametype",
    SymbolKind.MODULE: "module",
    SymbolKind.INSTANCE: "instance",
    SymbolKind.BUILTIN: "built in",
}


def hover(found: Analysis, place: types.Position, verdicts: Mapping[str, str]) -> types.Hover | None:
    """What stands at a place: a name with its type and what is written above its definition, or an assertion."""
    here = offset(found.source, place)
    name = found.at(here)
    if name is not None:
        return types.Hover(types.MarkupContent(types.MarkupKind.Markdown, _described(found, name)), range_of(name.span))
    for claim in found.claims:
        if claim.span.start <= here <= claim.span.end:
            said = verdicts.get(claim.text, "not checked yet")
            return types.Hover(
                types.MarkupContent(types.MarkupKind.Markdown, f"```cspm\nassert {claim.text}\n```\n{said}"),
                range_of(claim.span),
            )
    return None


def _described(found: Analysis, name: Occurrence) -> str:
    symbol = name.symbol
    if symbol is None:
        assert isinstance(name.key, tuple)
        _, owner, _ = name.key
        declared = next((other for other in found.of(name.key) if other.declares), None)
        line = "" if declared is None else declared.span.source.line_text(declared.span.line).strip()
        return f"```cspm\n{line or name.name}\n```\nvariable of the class `{owner}`"
    type_ = _builtin_type(symbol) if symbol.kind is SymbolKind.BUILTIN else found.type_of(symbol)
    head = f"{symbol.name.rstrip('%')} :: {type_}" if type_ else symbol.name.rstrip("%")
    kind = "class" if symbol.name.endswith("%") else _KINDS[symbol.kind]
    parts = [f"```cspm\n{head}\n```", kind]
    comment = _comment_above(found, symbol)
    if comment:
        parts.append(comment)
    return "\n\n".join(parts)


def _builtin_type(symbol: Symbol) -> str | None:
    from cspcheck.cspm.typing.builtins import builtin_scheme
    from cspcheck.cspm.typing.types import show_scheme

    try:
        return show_scheme(builtin_scheme(symbol.name))
    except (KeyError, ValueError, AttributeError):
        return None


def _comment_above(found: Analysis, symbol: Symbol) -> str:
    """The comment in the lines directly above a definition."""
    if symbol.span is None:
        return ""
    lines: list[str] = []
    number = symbol.span.line - 1
    while number > 0:
        line = symbol.span.source.line_text(number).strip()
        if not line.startswith("--"):
            break
        lines.insert(0, line.lstrip("-").strip())
        number -= 1
    return "\n".join(lines)


def definitions(found: Analysis, place: types.Position) -> list[types.Location]:
    """Where the name at a place is introduced."""
    name = found.at(offset(found.source, place))
    if name is None:
        return []
    return [location(other.span) for other in found.of(name.key) if other.declares]


def references(found: Analysis, place: types.Position, *, declarations: bool = True) -> list[types.Location]:
    """Where what is at a place is named."""
    name = found.at(offset(found.source, place))
    if name is None or (name.symbol is not None and name.symbol.kind is SymbolKind.BUILTIN):
        return [] if name is None else [location(o.span) for o in found.of(name.key)]
    return [location(o.span) for o in found.of(name.key) if declarations or not o.declares]


class CannotRename(Exception):
    """A name cannot be changed; the message says why."""


def renameable(found: Analysis, place: types.Position) -> types.Range:
    """The name at a place that could be another one.

    Raises:
        CannotRename: there is none.
    """
    name = found.at(offset(found.source, place))
    if name is None:
        raise CannotRename("there is no name here whose meaning is known")
    if not any(other.declares for other in found.of(name.key)):
        raise CannotRename(f"`{name.name}` is not introduced in the script")
    return range_of(name.span)


def renamed(found: Analysis, place: types.Position, new: str, opened: Open) -> dict[str, list[types.TextEdit]]:
    """The edits that give what is at a place another name, by file.

    What comes of them is read again: every name must mean what it meant before.

    Raises:
        CannotRename: it would mean something else, or be no script any more.
    """
    renameable(found, place)
    name = found.at(offset(found.source, place))
    assert name is not None
    if not re.fullmatch(r"[^\W\d]\w*'*", new) or new in KEYWORDS:
        raise CannotRename(f"`{new}` is no name")
    try:
        parse_expression(new)
    except ScriptError:
        raise CannotRename(f"`{new}` is no name") from None
    edits: dict[Source, list[Occurrence]] = {}
    for other in found.of(name.key):
        edits.setdefault(other.span.source, []).append(other)
    texts = {source.name: _edited(source, places, new) for source, places in edits.items()}
    after = analyse(
        found.source.name,
        texts.get(found.source.name, found.source.text),
        lambda path: texts.get(path, opened(path)),
    )
    if _shape(after) != _shape(found):
        raise CannotRename(f"with `{new}` instead of `{name.name}` some name would mean something else")
    return {
        uri_of(source.name): [types.TextEdit(range_of(other.span), new) for other in places]
        for source, places in edits.items()
    }


def _edited(source: Source, places: list[Occurrence], new: str) -> str:
    parts, last = [], 0
    for other in sorted(places, key=lambda o: o.span.start):
        parts += [source.text[last : other.span.start], new]
        last = other.span.end
    return "".join([*parts, source.text[last:]])


def _shape(found: Analysis) -> list[Any]:
    """Which names mean the same as which, whatever they are called; and what is wrong."""
    numbers: dict[object, int] = {}
    shape: list[Any] = [
        (numbers.setdefault(_known(o), len(numbers)), o.declares, o.span.source.name, o.span.line)
        for o in found.occurrences
    ]
    return [*shape, sorted(d.code for d in found.diagnostics)]


def _known(occurrence: Occurrence) -> object:
    """What is the same in two analyses for a name of the language; else the key."""
    symbol = occurrence.symbol
    return symbol.name if symbol is not None and symbol.kind is SymbolKind.BUILTIN else occurrence.key


def symbols(found: Analysis) -> list[types.DocumentSymbol]:
    """The outline of the file."""
    return [] if found.tree is None else list(_symbols(found, found.tree.declarations))


def _symbols(found: Analysis, declarations: tuple[syntax.Declaration, ...]) -> Iterator[types.DocumentSymbol]:
    kinds = types.SymbolKind
    for node in declarations:
        if node.span.source is not found.source:
            continue
        match node:
            case syntax.FunctionDefinition():
                yield _symbol(node, node.name, kinds.Function)
            case syntax.PatternDefinition(pattern=syntax.NamePattern() as pattern):
                yield _symbol(node, pattern.text, kinds.Variable)
            case syntax.ChannelDeclaration():
                for name in node.names:
                    yield _symbol(name, name.name, kinds.Event)
            case syntax.DatatypeDeclaration():
                yield _symbol(
                    node, node.name, kinds.Enum, [_symbol(c, c.name, kinds.EnumMember) for c in node.constructors]
                )
            case syntax.NametypeDeclaration():
                yield _symbol(node, node.name, kinds.TypeParameter)
            case syntax.ModuleDeclaration():
                yield _symbol(node, node.name, kinds.Module, list(_symbols(found, (*node.private, *node.exported))))
            case syntax.InstanceDeclaration():
                yield _symbol(node, node.name, kinds.Object)
            case syntax.TimedDeclaration():
                yield from _symbols(found, node.declarations)
            case oz.Class():
                inner = list(_symbols(found, node.equations))
                inner += [_symbol(o, o.name, kinds.Method) for o in node.operations]
                if node.state is not None:
                    declared = [d for part in (*node.state.primary, *node.state.secondary) for d in part.names]
                    inner += [_symbol(d, d.name, kinds.Field) for d in declared]
                yield _symbol(node, node.name, kinds.Class, inner)
            case oz.FreeType() | oz.Abbreviation() | oz.Schema():
                yield _symbol(node, node.name, kinds.Struct)
            case syntax.AssertDeclaration():
                text = " ".join(node.span.text.split())
                yield _symbol(node, text, kinds.Boolean)


def _symbol(
    node: syntax.Node, name: str, kind: types.SymbolKind, children: list[types.DocumentSymbol] | None = None
) -> types.DocumentSymbol:
    span = node.span
    first = span.source.span(span.start, min(span.end, span.start + len(span.text.split("\n", 1)[0])))
    return types.DocumentSymbol(name or "?", kind, range_of(span), range_of(first), children=children or [])


def completions(found: Analysis, text: str, place: types.Position, last: Analysis | None) -> list[types.CompletionItem]:
    """What could stand at a place of *text*: members behind `M::`, properties behind `:[`, else names.

    *last* is the newest analysis in which names were known, for a text that is half written.
    """
    source = Source(found.source.name, text)
    before = source.line_text(place.line + 1)[: offset(source, place) - offset(source, types.Position(place.line, 0))]
    if re.search(r":\[[\w ]*$", before):
        return [types.CompletionItem(name, kind=types.CompletionItemKind.Property) for name in PROPERTIES]
    known = found if found.names is not None else last
    items: dict[str, types.CompletionItem] = {}
    if known is not None and known.names is not None:
        module = re.search(r"([\w']+)::\w*$", before)
        if module is not None:
            return [_item(known, s) for s in _members(known, module[1])]
        for symbol in known.names.top_level.values():
            if not symbol.name.endswith("%"):
                items[symbol.name] = _item(known, symbol)
        line = place.line + 1
        for name in known.occurrences:
            # Variables that are introduced in the same definition are likely in scope.
            if name.symbol is None and name.declares:
                items.setdefault(name.name, types.CompletionItem(name.name, kind=types.CompletionItemKind.Field))
            elif (
                name.declares
                and name.symbol is not None
                and name.symbol.is_local
                and name.span.line <= line <= name.span.line + 30
            ):
                items.setdefault(name.name, _item(known, name.symbol))
    for word in KEYWORDS:
        items.setdefault(word, types.CompletionItem(word, kind=types.CompletionItemKind.Keyword))
    importing = re.search(r"\b(transparent|external)\b[^\n]*$", before)
    for word in sorted((TRANSPARENT if importing[1] == "transparent" else EXTERNAL) if importing else BUILTINS):
        items.setdefault(word, types.CompletionItem(word, kind=types.CompletionItemKind.Function, detail="built in"))
    return list(items.values())


_ITEM_KINDS = {
    SymbolKind.FUNCTION: types.CompletionItemKind.Function,
    SymbolKind.CHANNEL: types.CompletionItemKind.Event,
    SymbolKind.CONSTRUCTOR: types.CompletionItemKind.EnumMember,
    SymbolKind.DATATYPE: types.CompletionItemKind.Enum,
    SymbolKind.MODULE: types.CompletionItemKind.Module,
}


def _item(found: Analysis, symbol: Symbol) -> types.CompletionItem:
    kind = _ITEM_KINDS.get(symbol.kind, types.CompletionItemKind.Variable)
    return types.CompletionItem(symbol.name, kind=kind, detail=found.type_of(symbol))


def _members(found: Analysis, name: str) -> list[Symbol]:
    assert found.names is not None
    symbol = found.names.top_level.get(f"{name}%") or found.names.top_level.get(name)
    module = symbol if symbol is None or symbol.kind is not SymbolKind.INSTANCE else symbol.module
    if module is None or module.kind is not SymbolKind.MODULE:
        return []
    return [member for text, member in module.base.members.items() if text in module.base.exported]


def formatted(source: Source) -> list[types.TextEdit]:
    """The edits that give a text the standard layout; none where it does not parse or has it already."""
    try:
        text = format_source(source)
    except ScriptError:
        return []
    old, new = source.text.splitlines(keepends=True), text.splitlines(keepends=True)
    edits = []
    starts = [0]
    for line in old:
        starts.append(starts[-1] + len(line))
    for tag, a, b, c, d in SequenceMatcher(None, old, new, autojunk=False).get_opcodes():
        if tag != "equal":
            where = types.Range(position(source, starts[a]), position(source, starts[b]))
            edits.append(types.TextEdit(where, "".join(new[c:d])))
    return edits


def lenses(found: Analysis) -> list[types.CodeLens]:
    """*Check* and *Probe* above each assertion."""
    result = []
    for claim in found.claims:
        where = range_of(claim.span)
        arguments: list[Any] = [uri_of(found.source.name), claim.span.line]
        result.append(types.CodeLens(where, types.Command("Check", "cspcheck.check", arguments=arguments)))
        result.append(types.CodeLens(where, types.Command("Probe", "cspcheck.probe", arguments=arguments)))
    return result
