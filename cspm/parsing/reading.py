"""Reading CSPm: from a file or a text to its syntax tree.

The stages are :mod:`cspcheck.cspm.parsing.lexer` (tokens), :mod:`cspcheck.cspm.parsing.table` (the grammar's table),
:mod:`cspcheck.cspm.parsing.driver` (the machine) and :mod:`cspcheck.cspm.parsing.builder` (the nodes). A notation
with declarations of its own inside scripts needs a keyword and a context in the lexer, rules in the grammar and
actions in the tree.
"""

from __future__ import annotations

import os
import re
import stat
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final, Literal

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.notation import extension
from cspcheck.cspm.parsing import habits, lexing_messages as lexing, messages as messages, mistakes as parser_mistakes
from cspcheck.cspm.parsing.builder import MOST_MISTAKES, TreeBuilder
from cspcheck.cspm.parsing.driver import Unexpected, run
from cspcheck.cspm.parsing.lexer import tokenise
from cspcheck.cspm.parsing.table import table
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.syntax import tree as s

_PRINT_LINE = re.compile(r"^print[ \t]+([^\r\n]*)", re.MULTILINE)
DEEPEST_INCLUDE: Final = 100
"""Files between a script and what it includes, at most."""

_COMPARES = re.compile(r"[A-Za-z]\w*\s*(==)")

Reader = Callable[[str], Source]
"""Finds the text of an included file, given the path as written in the script."""


MOST_BYTES: Final = 64 << 20
"""Scripts are no larger than this."""


def read_source(path: str | os.PathLike[str]) -> Source:
    """The text of a file, under the name that was given.

    UTF-8 (with or without a byte order mark) is tried first, then Windows-1252. Line breaks become ``\\n``. Only files
    are read: a pipe might never end, or never begin. The one exception is a pipe that the shell has opened for us.

    Raises:
        ScriptError: the file cannot be read, is no file, is too large, is binary, or is Rich Text.
    """
    name = os.fspath(path)
    try:
        content = _content(name)
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
        raise ScriptError(lexing.file_cannot_be_read(name, reason.lower())) from None
    return decode(name, content)


def _content(name: str) -> bytes:
    """The bytes of a file.

    Raises:
        OSError, ValueError: it cannot be read.
    """
    # Without waiting: to open a pipe that nobody writes to would take for ever.
    number = os.open(name, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(number, "rb") as file:
        mode = os.fstat(number).st_mode
        if stat.S_ISDIR(mode):
            raise IsADirectoryError(21, "is a directory")
        if stat.S_ISFIFO(mode) and name.startswith(("/dev/fd/", "/dev/stdin", "/proc/self/fd/")):
            os.set_blocking(number, True)
        elif not stat.S_ISREG(mode):
            raise ValueError("it is a device or a pipe, not a file")
        content = file.read(MOST_BYTES + 1)
    if len(content) > MOST_BYTES:
        raise ValueError(f"it is larger than {MOST_BYTES:,} bytes")
    return content


def decode(name: str, content: bytes) -> Source:
    """The text that the bytes of a file stand for, see :func:`read_source`.

    Raises:
        ScriptError: the bytes are no text, or Rich Text.
    """
    if content.startswith(b"{\\rtf"):
        raise ScriptError(lexing.rich_text(name))
    if _is_utf_16(content):
        raise ScriptError(lexing.utf_16(name))
    if b"\0" in content:
        raise ScriptError(lexing.binary_file(name))
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError:
        # Five bytes mean nothing in Windows-1252; they become marks that the lexer refuses outside comments.
        text = content.decode("cp1252", errors="replace")
    return Source(name, text.replace("\r\n", "\n").replace("\r", "\n"))


def _is_utf_16(content: bytes) -> bool:
    """Whether bytes begin with the mark of UTF-16, or are text with a NUL byte beside each ASCII character."""
    beginning = content[:200]
    if beginning.startswith((b"\xff\xfe", b"\xfe\xff")):
        return True
    even, odd = beginning[::2], beginning[1::2]
    return len(odd) > 1 and ((not any(odd) and all(even)) or (not any(even) and all(odd)))


def parse(source: Source, *, include: Reader | None = None, include_roots: Sequence[str] = ()) -> s.Script:
    """The syntax tree of a script with all that it includes.

    Args:
        source: the script.
        include: finds included files by their path as written; without it they are read relative to the folder of
            *source*'s name, whichever file includes them, and only from below that folder.
        include_roots: further folders from below which files may be included.

    Raises:
        ScriptError: with every mistake in the form of the script that could be told apart.
    """
    return _Files(include or Included(source.name, include_roots)).script(source)


class Included:
    """Reads the files that a script includes: those below its folder and a few others, and no others.

    A script comes from anybody; what it includes is shown in messages. So it must not name the files of whoever checks
    it. Links count as what they lead to.
    """

    def __init__(self, script: str, roots: Sequence[str]) -> None:
        self._folder = os.path.dirname(script)
        self._roots = [os.path.realpath(root) for root in (self._folder or ".", *roots)]

    def __call__(self, path: str) -> Source:
        """The file with a path as the script writes it.

        Raises:
            ScriptError: it cannot be read, or is none of those that may be.
        """
        name = os.path.join(self._folder, path)
        try:
            real = os.path.realpath(name)
            inside = any(os.path.commonpath([root, real]) == root for root in self._roots)
        except (OSError, ValueError):
            inside = True  # which is no path at all, as reading it will say
        if not inside:
            raise ScriptError(lexing.file_cannot_be_read(name, lexing.OUTSIDE))
        return read_source(name)


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
    tree = TreeBuilder(tokens, _no_include)
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
    raise ScriptError(lexing.include_cannot_be_read(span, path, "only scripts include files"))


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
        """The tree of one file; None, and the mistakes in ``errors``, if it has none.

        A line ``print`` with a mistake in it shows nothing, and stops nothing else.
        """
        before = len(self.errors), len(self.remarks)
        script = self._tree(source)
        if script is not None or len(self.errors) == before[0] or is_markup(source):
            return script
        rest, left_out = _without_wrong_prints(source)
        if not left_out:
            return None
        found = self.errors[before[0] :]
        del self.errors[before[0] :]
        del self.remarks[before[1] :]
        script = self._tree(rest)
        if script is None:
            self.errors[before[0] :] = found
        else:
            self.remarks += left_out
        return script

    def _tree(self, source: Source) -> s.Script | None:
        self.open.append(source)
        try:
            if is_markup(source):
                return self._document(source)
            tokens = tokenise(source)
            self.remarks += tokens.remarks
            if tokens.errors:
                self.errors.extend(_of_another_language(source) or tokens.errors[:MOST_MISTAKES])
                return None
            tree = TreeBuilder(tokens, self._include)
            try:
                script = run(table(), "script", tokens, tree)
            except Unexpected as error:
                if other := _of_another_language(source):
                    self.errors.extend(other)
                    return None
                # The mistakes that the tree has collected so far stand before this one.
                found = [*tree.errors[: MOST_MISTAKES - 1], *parser_mistakes.all_of(table(), tokens, error.index)]
                self.errors.extend(habits.once(found)[:MOST_MISTAKES])
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


def _without_wrong_prints(source: Source) -> tuple[Source, list[Diagnostic]]:
    """A script with blanks for each line ``print`` whose rest is no expression, and what is wrong with those."""
    left_out: list[Diagnostic] = []
    text = source.text
    for found in _PRINT_LINE.finditer(source.text):
        blank = re.sub(r"[^\n]", " ", source.text[: found.start(1)])
        try:
            parse_expression(Source(source.name, blank + found[1]))  # every character in its place
        except ScriptError as error:
            first = error.diagnostics[0]
            span = source.span(*found.span(1)) if first.span is None else source.span(first.span.start, first.span.end)
            left_out.append(lexing.print_left_out(first.message, span))
            text = text[: found.start()] + " " * len(found[0]) + text[found.end() :]
    return Source(source.name, text), left_out


def _of_another_language(source: Source) -> list[Diagnostic]:
    """What to say of a text that is no script if another language is recognised; nothing otherwise."""
    found = habits.pat_script(source)
    return [] if found is None else [found]


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
