"""Where names stand in a script, and what each of them means."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.oz import syntax as oz
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children


@dataclass(frozen=True, slots=True)
class Occurrence:
    """A name in the text.

    Attributes:
        span: the name alone, without what qualifies it.
        name: as it is called there.
        key: equal for what means the same.
        declares: whether it is introduced here.
        symbol: what it stands for; None for a variable of a class.
    """

    span: Span
    name: str
    key: object
    declares: bool
    symbol: Symbol | None = None


def occurrences(tree: syntax.Script, core: syntax.Script, names: Names) -> Iterator[Occurrence]:
    """The names of a script: those of CSPm as they were tied, those inside classes by class and name.

    Args:
        tree: as written.
        core: the tree whose names were tied.
        names: what they were tied to.
    """
    tied: dict[tuple[str, int, int], Occurrence] = {}
    for found in _of_cspm(core, names):
        tied.setdefault(_place(found.span), found)
    yield from tied.values()
    for found in _of_classes(tree, names, tied):
        if _place(found.span) not in tied:
            tied[_place(found.span)] = found
            yield found


def _place(span: Span) -> tuple[str, int, int]:
    return span.source.name, span.start, span.end


def _of_cspm(core: syntax.Script, names: Names) -> Iterator[Occurrence]:
    todo: list[syntax.Node] = [core]
    while todo:
        node = todo.pop()
        todo.extend(children(node))
        symbol = names.find(node)
        if symbol is None:
            continue
        meant = symbol.base
        declares = symbol.kind is not SymbolKind.BUILTIN and not isinstance(node, syntax.Name | syntax.TypeName)
        if isinstance(node, syntax.NamePattern) and meant.kind in (SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR):
            declares = False
        for span in _places(node, meant.name.rstrip("%")):
            yield Occurrence(span, meant.name.rstrip("%"), meant, declares, symbol)


_INTRODUCING = "class|module|instance|datatype|subtype|nametype|schema|const"


def _places(node: syntax.Node, name: str) -> list[Span]:
    """Where in the text of a node its name stands: nowhere in what was made of a class."""
    if isinstance(node, syntax.FunctionDefinition):
        starts = [clause.span for clause in node.clauses if clause.span.text.startswith(name)]
        return [span.source.span(span.start, span.start + len(name)) for span in starts]
    text = node.span.text
    if isinstance(node, syntax.Name | syntax.TypeName | syntax.NamePattern) and text.split("::")[-1].strip() == name:
        return [node.span.source.span(node.span.end - len(name), node.span.end)]
    if isinstance(node, syntax.NameDeclaration | syntax.Constructor) and text.startswith(name):
        return [node.span.source.span(node.span.start, node.span.start + len(name))]
    head = re.match(
        rf"(?:(?:class|module|instance|datatype|subtype|nametype|schema|const)\s+)?({re.escape(name)})\b", text
    )
    if head is None or isinstance(node, syntax.Name):
        return []
    return [node.span.source.span(node.span.start + head.start(1), node.span.start + head.end(1))]


def _of_classes(
    tree: syntax.Script, names: Names, tied: dict[tuple[str, int, int], Occurrence]
) -> Iterator[Occurrence]:
    """The names in the Object-Z part: what a class declares by class and name, the rest by what the script calls so.

    What is declared where a name of CSPm was tied (a constant of a class) is that.
    """
    found = list(_named(tree))
    own: dict[tuple[str, str], Occurrence] = {}
    for span, name, owner, declares in found:
        if declares and owner is not None:
            made = tied.get(_place(span)) or Occurrence(span, name, ("class", owner, name), True)
            own.setdefault((owner, name), made)
    for span, name, owner, declares in found:
        meant = own.get((owner, name)) if owner is not None else None
        symbol = names.top_level.get(name)
        if meant is not None:
            yield Occurrence(span, name, meant.key, declares, meant.symbol)
        elif symbol is not None:
            yield Occurrence(span, name, symbol.base, False, symbol)


def _named(tree: syntax.Script) -> Iterator[tuple[Span, str, str | None, bool]]:
    """Places of names in the Object-Z part, each with the class that it is in, and whether it is declared there."""
    todo: list[tuple[syntax.Node, str | None]] = [(tree, None)]
    while todo:
        node, owner = todo.pop()
        if isinstance(node, oz.Class):
            owner = node.name
        todo.extend((child, owner) for child in children(node))
        match node:
            case oz.Declared(name=name) | oz.Reference(name=name) | oz.Inherit(name=name):
                span = _plain(node.span, name)
            case syntax.NameDeclaration(name=name) if owner is not None:
                span = _plain(node.span, name)
            case _:
                continue
        if span is not None:
            yield span, name, owner, isinstance(node, oz.Declared)


def _plain(span: Span, name: str) -> Span | None:
    """The part of a span that is the bare name."""
    head = re.search(rf"(?<![\w]){re.escape(name)}(?!\w)", span.text)
    return None if head is None else span.source.span(span.start + head.start(), span.start + head.end())
