"""What ``cspcheck prove`` tells: every obligation of every class, and preconditions."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Protocol

from cspcheck.checker.verdict import BrokenObligation
from cspcheck.quantities import count, show_seconds
from cspcheck.report.obligation import hypothesis_lines, obligation_lines, value_lines
from cspcheck.report.sentences import as_sentence
from cspcheck.report.style import PLAIN, Style, columns, harmless, pad, unobeyed, wrapped
from cspcheck.result import Exit

if TYPE_CHECKING:
    from cspcheck.checker.proof.finding import Finding, Hypothesis
    from cspcheck.checker.proof.precondition import Precondition

SCHEMA = "cspcheck/proof/1"
_OBLIGATION_WIDTH = 24
_SLOW = 1.0
"""Seconds from which on the time is told."""


class ProofListing(Protocol):
    """Takes findings as they come."""

    def script(self, name: str) -> None:
        """The findings of a script follow."""

    def finding(self, finding: Finding) -> None:
        """The answer to one obligation."""

    def precondition(self, owner: str, operation: str, found: Precondition) -> None:
        """When an operation is possible."""

    def end(self, *, named: bool) -> Exit:
        """All is told; what it means for the exit code. *named*: one obligation was asked for by its name."""


class _Tally:
    """Counts what counts."""

    def __init__(self) -> None:
        self.findings: list[Finding] = []
        self.preconditions = 0

    def exit(self, *, named: bool) -> Exit:
        """What all the findings mean."""
        counting = [f for f in self.findings if named or f.severity == "error"]
        if any(f.status == "refuted" for f in counting):
            return Exit.FAILED
        if any(f.status in ("bounded", "unknown") for f in counting):
            return Exit.UNKNOWN
        return Exit.OK if self.findings or self.preconditions else Exit.NOTHING


class FullListing:
    """For people: a line for each obligation, what is wrong below it, a summary at the end.

    *verbosity* below 0 leaves out what is proved; above 0 witnesses and values are shown whole.
    """

    def __init__(self, write: Callable[[str], object], style: Style = PLAIN, verbosity: int = 0) -> None:
        self._write = write
        self._style = style
        self._verbosity = verbosity
        self._tally = _Tally()
        self._subject: str | None = None
        self._held: list[Finding] = []
        self._begun = False

    def script(self, name: str) -> None:
        """The findings of a script follow."""
        self._flush()
        self._subject = None
        self._line(("\n" if self._begun else "") + self._style.paint(harmless(name), "bold"))

    def finding(self, finding: Finding) -> None:
        """One finding; those of one obligation and operation that are proved share a line."""
        self._tally.findings.append(finding)
        if self._held and (finding.used is not None or not _alike(self._held[0], finding)):
            self._flush()
        if finding.status == "proved" and not finding.vacuous:
            self._held.append(finding)
            return
        self._flush()
        self._told(finding)

    def precondition(self, owner: str, operation: str, found: Precondition) -> None:
        """When an operation is possible."""
        from cspcheck.cspm.oz.writing.core_text import text

        self._tally.preconditions += 1
        name = f"`{owner}.{operation}`"
        gap = "\n" if self._begun else ""
        if found.guard is not None:
            self._line(f"{gap}{name} is offered " + ("always" if not found.guard else "where"))
            for term in found.guard:
                self._line(f"  {text(term)}")
            gap = ""
            name = "its effect"
        self._line(f"{gap}{name} is possible " + ("always" if not found.conjuncts else "where"))
        for term in found.conjuncts:
            self._line(f"  {text(term)}")
        if not found.exact:
            self._line(self._style.paint("  (a quantifier is left that could not be eliminated)", "dim"))

    def end(self, *, named: bool) -> Exit:
        """The summary."""
        self._flush()
        if self._tally.findings and self._verbosity >= 0:
            self._line("\n" + self._summary())
        return self._tally.exit(named=named)

    def _flush(self) -> None:
        held, self._held = self._held, []
        if not held or self._verbosity < 0:
            return
        details = [f.detail for f in held if f.detail]
        shown = ", ".join(details)
        if len(details) > 2 and columns(shown) > 34:
            shown = f"{details[0]} and {len(details) - 1} more"
        self._head(held[0])
        self._row("proved", held[0], shown, sum(f.seconds for f in held))
        self._helped(held)
        if self._verbosity > 0:
            for finding in held:
                if finding.values:
                    self._indented(value_lines(finding.values, self._style, True))
                if finding.used is not None:
                    self._indented(hypothesis_lines(_lines(finding.used), self._style))

    def _helped(self, findings: Sequence[Finding]) -> None:
        """What proofs used of lemmas, and what they could not use."""
        for names, said in (
            ([name for f in findings for name in f.hypotheses], "Using {}."),
            ([name for f in findings for name in f.missing], "Without {}, as it is not proved."),
        ):
            quoted = [f"`{name}`" for name in dict.fromkeys(names)]
            if len(quoted) > 1:
                said = said.replace("it is", "they are")
                quoted = [", ".join(quoted[:-1]) + f" and {quoted[-1]}"]
            if quoted:
                self._indented(wrapped(said.format(quoted[0]), self._style.width - 6))

    def _told(self, finding: Finding) -> None:
        """A finding with what is wrong."""
        if finding.status == "refuted" and finding.severity == "info" and self._verbosity < 0:
            return
        self._head(finding)
        looks = f"{finding.status} {finding.severity}" if finding.status == "refuted" else finding.status
        self._row("vacuous" if finding.vacuous else looks, finding, finding.detail, finding.seconds)
        if finding.message:
            self._indented(wrapped(as_sentence(finding.message), self._style.width - 6))
        self._helped([finding])
        if finding.values:
            self._indented(value_lines(finding.values, self._style, self._verbosity > 0))
        broken = _broken(finding)
        self._indented(obligation_lines(broken, self._style, self._verbosity > 0, ""))
        for text in finding.vouched:
            said = f"Only the solver says of these values that `{text}` holds: there is no end to what it ranges over."
            self._indented(wrapped(said, self._style.width - 6))

    def _head(self, finding: Finding) -> None:
        if finding.subject != self._subject:
            self._subject = finding.subject
            self._line(("\n" if self._begun else "") + self._style.paint(harmless(finding.subject), "bold"))

    def _row(self, looks: str, finding: Finding, detail: str, seconds: float) -> None:
        unicode_, ascii_, color = _LOOKS[looks]
        mark = self._style.paint(unicode_ if self._style.unicode else ascii_, "bold", color)
        place = " ".join(part for part in (harmless(finding.operation or ""), harmless(detail)) if part)
        told = seconds >= _SLOW or self._verbosity > 0
        took = self._style.paint(show_seconds(seconds), "dim") if told else ""
        row = f"  {mark} {pad(finding.obligation, _OBLIGATION_WIDTH)} {place}"
        self._line(f"{row}  {took}".rstrip())

    def _indented(self, lines: list[str]) -> None:
        for line in lines:
            self._line(f"      {line}".rstrip())

    def _line(self, text: str) -> None:
        self._write(unobeyed(text) + "\n")
        self._begun = True

    def _summary(self) -> str:
        found = self._tally.findings
        parts = [
            self._style.paint(f"{number:,} {status}", color)
            for status, color in _STATUS_COLORS.items()
            if (number := sum(f.status == status for f in found))
        ]
        lints = sum(f.status == "refuted" and f.severity != "error" for f in found)
        told = f" ({lints:,} of them no errors)" if lints else ""
        return f"{count(len(found), 'obligation')}: " + ", ".join(parts) + told


_LOOKS = {
    "proved": ("✓", "+", "green"),
    "vacuous": ("○", "o", "yellow"),
    "refuted error": ("✗", "x", "red"),
    "refuted warning": ("!", "!", "yellow"),
    "refuted info": ("i", "i", "cyan"),
    "bounded": ("~", "~", "yellow"),
    "unknown": ("?", "?", "yellow"),
}
_STATUS_COLORS = {"proved": "green", "refuted": "red", "bounded": "yellow", "unknown": "yellow"}


def _alike(one: Finding, other: Finding) -> bool:
    return (one.subject, one.obligation, one.operation) == (other.subject, other.obligation, other.operation)


def _broken(finding: Finding) -> BrokenObligation:
    """What a finding says beside its values."""
    return BrokenObligation(
        name=finding.obligation,
        subject=finding.subject,
        operation=finding.operation,
        message=finding.message,
        line=None if finding.span is None else finding.span.line,
        failing=finding.failing,
        lines=tuple((span.line, " ".join(span.text.split())) for span in finding.lines),
        others=(),
    )


def _lines(hypotheses: Sequence[Hypothesis]) -> list[tuple[int | None, str, str]]:
    """The lines that a proof needed: number, text, what each is."""
    return [(None if h.span is None else h.span.line, h.text, h.what) for h in hypotheses]


class ProofDocument:
    """For programs: one JSON document."""

    def __init__(self, write: Callable[[str], object]) -> None:
        self._write = write
        self._tally = _Tally()
        self._file = ""
        self._findings: list[dict[str, Any]] = []
        self._preconditions: list[dict[str, Any]] = []

    def script(self, name: str) -> None:
        """The findings of a script follow."""
        self._file = name

    def finding(self, finding: Finding) -> None:
        """One finding."""
        self._tally.findings.append(finding)
        self._findings.append(
            {
                "file": self._file,
                "line": None if finding.span is None else finding.span.line,
                "subject": finding.subject,
                "obligation": finding.obligation,
                "operation": finding.operation,
                "detail": finding.detail,
                "severity": finding.severity,
                "status": finding.status,
                "message": finding.message,
                "values": dict(finding.values),
                "failing": finding.failing,
                "lines": [{"line": span.line, "text": " ".join(span.text.split())} for span in finding.lines],
                "vacuous": finding.vacuous,
                "vouched": list(finding.vouched),
                "hypotheses": list(finding.hypotheses),
                "used": None
                if finding.used is None
                else [{"what": what, "line": line, "text": text} for line, text, what in _lines(finding.used)],
                "missing": list(finding.missing),
                "scope": finding.scope,
                "seconds": round(finding.seconds, 6),
            }
        )

    def precondition(self, owner: str, operation: str, found: Precondition) -> None:
        """When an operation is possible."""
        from cspcheck.cspm.oz.writing.core_text import text

        self._tally.preconditions += 1
        self._preconditions.append(
            {
                "class": owner,
                "operation": operation,
                "guard": None if found.guard is None else [text(term) for term in found.guard],
                "precondition": [text(term) for term in found.conjuncts],
                "exact": found.exact,
            }
        )

    def end(self, *, named: bool) -> Exit:
        """Write the document."""
        document = {"schema": SCHEMA, "obligations": self._findings, "preconditions": self._preconditions}
        self._write(json.dumps(document, indent=2) + "\n")
        return self._tally.exit(named=named)
