"""What is known of a script while it is being written: as much as its mistakes leave.

A text goes through the phases of loading one by one, and what the last good one found is kept. Nothing is evaluated:
an editor asks at every key, and a script may take any time to be evaluated.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.naming.resolve import resolve
from cspcheck.cspm.naming.symbols import Names, Symbol
from cspcheck.cspm.notation import extension
from cspcheck.cspm.parsing.reading import parse, read_source
from cspcheck.cspm.printing.printer import print_assertion
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children
from cspcheck.cspm.typing.inference import Types, infer
from cspcheck.editing.occurrences import Occurrence, occurrences

Open = Callable[[str], str | None]
"""The text of a file that is open in the editor, by its path; None if it is not."""


@dataclass(frozen=True, slots=True)
class ClaimedAssertion:
    """An assertion of the script: its text and where it stands."""

    text: str
    span: Span


@dataclass
class Analysis:
    """What is known of a text.

    Attributes:
        source: the text.
        diagnostics: what is wrong or odd, in included files too.
        tree: as written; None if it does not parse.
        names, types: None as far as the script is too wrong for them.
        core: the tree that *names* are about: classes are replaced by what they become.
    """

    source: Source
    diagnostics: list[Diagnostic] = field(default_factory=list)
    tree: syntax.Script | None = None
    core: syntax.Script | None = None
    names: Names | None = None
    types: Types | None = None

    @cached_property
    def occurrences(self) -> list[Occurrence]:
        """Where names stand, in the order of the text, included files too."""
        if self.names is None or self.core is None or self.tree is None:
            return []
        return sorted(
            occurrences(self.tree, self.core, self.names), key=lambda o: (o.span.source.name, o.span.start, o.span.end)
        )

    @cached_property
    def claims(self) -> list[ClaimedAssertion]:
        """The assertions of the file itself."""
        if self.tree is None:
            return []
        return [
            ClaimedAssertion(print_assertion(node.assertion), node.span)
            for node in _all(self.tree)
            if isinstance(node, syntax.AssertDeclaration) and node.span.source is self.source
        ]

    def at(self, offset: int) -> Occurrence | None:
        """The name at an offset of the file."""
        return next(
            (
                found
                for found in self.occurrences
                if found.span.source is self.source and found.span.start <= offset <= found.span.end
            ),
            None,
        )

    def of(self, key: object) -> list[Occurrence]:
        """Everywhere that the thing with this key is named."""
        return [found for found in self.occurrences if found.key == key]

    def type_of(self, symbol: Symbol) -> str | None:
        """The type of a symbol, as an annotation writes it."""
        if self.types is None:
            return None
        from cspcheck.cspm.typing.types import show_scheme

        try:
            return show_scheme(self.types.scheme(symbol))
        except KeyError:
            return None


def _all(node: syntax.Node) -> Iterator[syntax.Node]:
    todo = [node]
    while todo:
        current = todo.pop()
        yield current
        todo.extend(reversed(list(children(current))))


def analyse(path: str, text: str, opened: Open = lambda _: None) -> Analysis:
    """What is known of *text*, which is that of the file *path*; included files are those that are open, or on disk."""
    import cspcheck.cspm.oz  # noqa: F401  (classes are part of the language of scripts)

    found = Analysis(Source(path, text))

    def include(name: str) -> Source:
        place = os.path.join(os.path.dirname(path), name)
        shown = opened(place)
        return read_source(place) if shown is None else Source(place, shown)

    try:
        tree = parse(found.source, include=include)
        found.tree = tree
        found.diagnostics.extend(tree.remarks)
        if any(isinstance(node, syntax.Paragraph) for node in _declarations(tree.declarations)):
            classes, tree = extension().elaborated(tree, None)
            found.diagnostics.extend(classes.warnings)
        found.core = tree
        found.names = resolve(tree)
        found.types = infer(tree, found.names)
        found.diagnostics.extend(found.types.warnings)
    except ScriptError as error:
        found.diagnostics.extend(error.diagnostics)
    except RecursionError:
        pass  # a script nested so deeply is told when it is checked
    return found


def _declarations(declarations: tuple[syntax.Declaration, ...]) -> Iterator[syntax.Declaration]:
    for declaration in declarations:
        if isinstance(declaration, syntax.IncludeDeclaration):
            yield from _declarations(declaration.declarations)
        else:
            yield declaration
