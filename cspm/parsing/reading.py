"""Reading CSPm: from a file or a text to its syntax tree.

The stages are :mod:`cspcheck.cspm.parsing.lexer` (tokens), :mod:`cspcheck.cspm.parsing.table` (the grammar's table),
:mod:`cspcheck.cspm.parsing.driver` (the machine) and :mod:`cspcheck.cspm.parsing.builder` (the nodes). A notation
with declarations of its own inside scripts needs a keyword and a context in the lexer, rules in the grammar and
actions in the tree.
"""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.notation import extension
from cspcheck.cspm.parsing import lexing_messages as lexing, messages as messages, mistakes as parser_mistakes
from cspcheck.cspm.parsing.builder import MOST_MISTAKES, Tree
from cspcheck.cspm.parsing.driver import Unexpected, run
from cspcheck.cspm.parsing.lexer import tokenise
from cspcheck.cspm.parsing.table import table
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax import tree as s

DEEPEST_INCLUDE: Final = 100
"""Files between a script and what it includes, at most."""

_COMPARES = re.compile(r"[A-Za-z]\w*\s*(==)")

Reader = Callable[[str], Source]
"""Finds the text of an included file, given the path as written in the script."""


def read_source(path: str | os.PathLike[str]) -> Source:
    """The text of a file, under the name that was given.

    UTF-8 (with or without a byte order mark) is tried first, then Windows-1252. Line breaks become ``\\n``.

    Raises:
        ScriptError: the file cannot be read, is binary, or is Rich Text.
    """
    name = os.fspath(path)
    try:
        content = Path(path).read_bytes()
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ScriptError(lexing.file_cannot_be_read(name, reason.lower())) from None
    return decode(name, content)


def decode(name: str, content: bytes) -> Source:
    """The text that the bytes of a file stand for, see :func:`read_source`.

    Raises:
        ScriptError: the bytes are no text, or Rich Text.
    """
    if content.startswith(b"{\\rtf"):
        raise ScriptError(lexing.rich_text(name))
    if b"\0" in content:
        raise ScriptError(lexing.binary_file(name))
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Five bytes mean nothing in Windows-1252; they become marks that the lexer refuses outside comments.
        text = content.decode("cp1252", errors="replace")
    return Source(name, text.replace("\r\n", "\n").replace("\r", "\n"))


def parse(source: Source, *, include: Reader | None = None) -> s.Script:
    """The syntax tree of a script with all that it includes.

    *include* finds included files by their path as written; without it they are read relative to the folder of
    *source*'s name, whichever file includes them.

    Raises:
        ScriptError: with every mistake in the form of the script that could be told apart.
    """
    folder = os.path.dirname(source.name)
    read: Reader = include or (lambda path: read_source(os.path.join(folder, path)))
    return _Files(read).script(source)


def parse_alone(source: Source) -> s.Script:
    """The tree of one file alone: what it includes is not read.

    Raises:
        ScriptError: with the mistakes that can be told without the included files.
    """
    count = 0

    def empty(path: str) -> Source:
        nonlocal count
        count += 1
        return Source(f"<include {count}>", "")

    files = _Files(empty)
    script = files.tree(source)
    if script is not None and files.remarks:
        script = replace(script, remarks=tuple(files.remarks))
    errors = [error for error in files.errors if not messages.concerns_whole_script(error)]
    if script is None or errors:
        raise ScriptError(*errors)
    return script


def parse_expression(text: str | Source) -> s.Expr:
    """The tree of one expression; line breaks in it mean nothing.

    Raises:
        ScriptError: the text is no expression.
    """
    result = _alone(text, "expression")
    assert isinstance(result, s.Expr)
    return result


def parse_assertion(text: str | Source) -> s.Assertion:
    """The tree of an assertion, with or without the word ``assert`` before it.

    Raises:
        ScriptError: the text is no assertion.
    """
    result = _alone(text, "assertion")
    assert isinstance(result, s.Assertion)
    return result


def _alone(text: str | Source, form: Literal["expression", "assertion"]) -> s.Node:
    source = text if isinstance(text, Source) else Source("<text>", text)
    tokens = tokenise(source, form=form)
    if tokens.errors:
        raise ScriptError(*tokens.errors)
    start = f"lone_{form}"
    tree = Tree(tokens, _no_include)
    try:
        result = run(table(), start, tokens, tree)
    except Unexpected as error:
        finding = parser_mistakes.diagnose(table(), start, tokens, error.index)
        raise ScriptError(*tree.errors, finding.diagnostic) from None
    tree.finish()
    if tree.errors:
        raise ScriptError(*tree.errors)
    assert isinstance(result, s.Node)
    return result


def _no_include(path: str, span: Span) -> tuple[s.Declaration, ...]:
    raise AssertionError("an include stands in a script only")


class _Files:
    """The files of one script while they are read."""

    def __init__(self, read: Reader) -> None:
        self.read = read
        self.open: list[Source] = []  # the files that are being parsed, each included by the one before
        self.errors: list[Diagnostic] = []
        self.remarks: list[Diagnostic] = []

    def script(self, source: Source) -> s.Script:
        """The tree of the root file.

        Raises:
            ScriptError: there is a mistake in it or in a file that it includes.
        """
        script = self.tree(source)
        if script is not None and not is_markup(source):
            self.errors += _lone_abbreviations(script)
        if self.errors:
            raise ScriptError(*self.errors)
        assert script is not None
        return replace(script, remarks=tuple(self.remarks)) if self.remarks else script

    def tree(self, source: Source) -> s.Script | None:
        """The tree of one file; None, and the mistakes in ``errors``, if it has none."""
        self.open.append(source)
        try:
            if is_markup(source):
                return self._document(source)
            tokens = tokenise(source)
            self.remarks += tokens.remarks
            if tokens.errors:
                self.errors.extend(tokens.errors[:MOST_MISTAKES])
                return None
            tree = Tree(tokens, self._include)
            try:
                script = run(table(), "script", tokens, tree)
            except Unexpected as error:
                # The mistakes that the tree has collected so far stand before this one.
                found = [*tree.errors[: MOST_MISTAKES - 1], *parser_mistakes.all_of(table(), tokens, error.index)]
                self.errors.extend(found[:MOST_MISTAKES])
                return None
            tree.finish()
            self.errors.extend(sorted(tree.errors, key=_position)[:MOST_MISTAKES])
            assert isinstance(script, s.Script)
            return script
        finally:
            self.open.pop()

    def _document(self, source: Source) -> s.Script | None:
        document = extension().document(source, self._include)
        self.errors += sorted(document.errors, key=_position)[:MOST_MISTAKES]
        self.remarks += document.remarks
        return document.script()

    def _include(self, path: str, span: Span) -> tuple[s.Declaration, ...]:
        if len(self.open) > DEEPEST_INCLUDE:
            self.errors.append(lexing.includes_too_deep(span, DEEPEST_INCLUDE))
            return ()
        try:
            source = self.read(path)
        except ScriptError as error:
            reason = "; ".join(re.sub(r"^cannot read `.*`: ", "", d.message) for d in error.diagnostics)
            self.errors.append(lexing.include_cannot_be_read(span, path, reason))
            return ()
        names = [_identity(file) for file in self.open]
        if _identity(source) in names:
            chain = [file.name for file in self.open[names.index(_identity(source)) :]]
            self.errors.append(lexing.include_cycle(span, path, [*chain, source.name]))
            return ()
        script = self.tree(source)
        return script.declarations if script is not None else ()


def _lone_abbreviations(script: s.Script) -> Iterator[Diagnostic]:
    """``x == e`` in a script that has no other paragraph of Object-Z, where it can only be meant as a comparison."""
    paragraphs: list[s.Paragraph] = []
    waiting = list(script.declarations)
    while waiting:
        declaration = waiting.pop()
        if isinstance(declaration, s.IncludeDeclaration):
            waiting += declaration.declarations
        elif isinstance(declaration, s.Paragraph):
            paragraphs.append(declaration)
    signs = [_COMPARES.match(paragraph.span.text) for paragraph in paragraphs]
    if all(signs):
        for paragraph, sign in zip(paragraphs, signs, strict=True):
            assert sign is not None
            start = paragraph.span.start + sign.start(1)
            yield messages.comparison_for_definition(paragraph.span.source.span(start, start + 2))


def is_markup(source: Source) -> bool:
    """Whether a text is a LaTeX document, to be read for its classes."""
    return source.name.lower().endswith(".tex")


def _identity(source: Source) -> str:
    return os.path.normcase(os.path.realpath(source.name))


def _position(error: Diagnostic) -> int:
    return error.span.start if error.span is not None else -1
