"""Diagnostics as people read them."""

from __future__ import annotations

from collections.abc import Iterable

from cspcheck.cspm.diagnostics import Diagnostic, Severity
from cspcheck.report.excerpt import Mark, excerpt
from cspcheck.report.style import Style, harmless, harmless_lines


def render_diagnostic(diagnostic: Diagnostic, style: Style) -> str:
    """A diagnostic with excerpt, notes and help, without a line break at the end."""
    color = "red" if diagnostic.severity is Severity.ERROR else "yellow"
    head = style.paint(f"{diagnostic.severity}[{diagnostic.code}]", "bold", color)
    rows = [head + style.paint(f": {harmless(diagnostic.message)}", "bold")]
    marks = [Mark(label.span, label.message, primary=False) for label in diagnostic.labels]
    gutter = 1
    if diagnostic.span is not None:
        marks.insert(0, Mark(diagnostic.span, diagnostic.annotation, primary=True))
    if marks:
        gutter = len(str(max(mark.span.end_line for mark in marks)))
        rows.extend(excerpt(marks, style))
    further = [("note", note) for note in diagnostic.notes]
    if diagnostic.help:
        further.append(("help", diagnostic.help))
    if further and marks:
        rows.append(" " * gutter + " " + style.paint("|", "bold", "blue"))
    for word, text in further:
        first, *more = harmless_lines(text)
        edge = " " * gutter + " " + style.paint("=", "bold", "blue") + " "
        rows.append(edge + style.paint(word, "bold") + f": {first}")
        rows.extend(" " * (gutter + 9) + line for line in more)
    return "\n".join(rows)


def render_diagnostics(diagnostics: Iterable[Diagnostic], style: Style) -> str:
    """Several diagnostics with an empty line behind each; empty text for none."""
    return "".join(render_diagnostic(diagnostic, style) + "\n\n" for diagnostic in diagnostics)


def concise_diagnostic(diagnostic: Diagnostic) -> str:
    """A diagnostic in one line: ``file:line:column: error[CSP201]: message``."""
    place = ""
    if diagnostic.span is not None:
        span = diagnostic.span
        place = f"{span.source.name}:{span.line}:{span.column}: "
    return " ".join(harmless(f"{place}{diagnostic.severity}[{diagnostic.code}]: {diagnostic.message}").split())
