"""Manual pages (roff, the macros of ``man``) from the help of the command and of its verbs."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping

import click

_EXIT_CODES = {
    "0": "all assertions pass, or fail as the script expects",
    "1": "an assertion fails",
    "2": "nothing was done: wrong options, a file that cannot be read, an error in a script",
    "3": "none fails, but one is unknown",
    "4": "an internal error",
    "5": "nothing to check",
    "130": "interrupted",
}


def escaped(text: str) -> str:
    """Text that is set as it stands."""
    text = text.replace("\\", "\\e").replace("-", "\\-")
    text = "".join(sign if sign.isascii() else f"\\[u{ord(sign):04X}]" for sign in text)
    return "\n".join("\\&" + line if line[:1] in (".", "'") else line for line in text.split("\n"))


def flowing(text: str) -> str:
    """A paragraph of a docstring: blanks joined, what stands in backticks in bold."""
    words = escaped(" ".join(text.split()))
    return re.sub(r"`+([^`]+)`+", r"\\fB\1\\fR", words)


def _named(term: str) -> str:
    """The left side of an entry: names of options in bold, their values in italics."""
    found: list[str] = []
    for word in re.findall(r"[^\s,]+|,", term):
        if word == ",":
            found[-1] += ","
        elif word == "/":
            found.append(word)
        else:
            found.append(f"\\fB{escaped(word)}\\fR" if word.startswith("-") else f"\\fI{escaped(word)}\\fR")
    return " ".join(found)


def _entries(entries: Iterable[tuple[str, str]]) -> Iterator[str]:
    for term, words in entries:
        yield ".TP"
        yield term
        yield flowing(words)


def _exit_status() -> list[str]:
    return ['.SH "EXIT STATUS"', *_entries((f"\\fB{code}\\fR", words) for code, words in _EXIT_CODES.items())]


def _page(name: str, what: str, synopsis: str, body: list[str], version: str, others: Iterable[str]) -> str:
    lines = [
        f'.TH "{escaped(name.upper())}" 1 "" "cspcheck {version}" "cspcheck"',
        ".SH NAME",
        f"{escaped(name)} \\- {flowing(what)}",
        ".SH SYNOPSIS",
        synopsis,
        *body,
        '.SH "SEE ALSO"',
        ",\n".join(f"\\fB{escaped(other)}\\fR(1)" for other in others),
    ]
    return "\n".join(lines) + "\n"


def main_page(command: click.Group, verbs: Mapping[str, str], version: str) -> str:
    """The page of the command itself: its verbs."""
    body = [
        ".SH DESCRIPTION",
        flowing(command.help or ""),
        ".SH VERBS",
        *_entries((f"\\fB{verb}\\fR", what) for verb, what in verbs.items()),
        *_exit_status(),
    ]
    return _page(
        "cspcheck",
        "model checking, proof and code for CSPm and CSP-OZ",
        "\\fBcspcheck\\fR [\\fIverb\\fR] [\\fIoptions\\fR] \\fIfile\\fR...",
        body,
        version,
        (page_name(verb) for verb in verbs),
    )


def page_name(verb: str) -> str:
    """What the page of a verb is called."""
    return f"cspcheck-{verb}"


def verb_page(verb: str, what: str, command: click.Command, parent: click.Context, version: str) -> str:
    """The page of one verb; *parent* is the context of the command that it is a verb of."""
    with click.Context(command, info_name=verb, parent=parent) as context:
        pieces = " ".join(command.collect_usage_pieces(context))
        records = [record for option in command.get_params(context) if (record := option.get_help_record(context))]
    records = [record for record in records if record[1]]
    paragraphs = re.split(r"\n\s*\n", (command.help or "").strip())
    body = [".SH DESCRIPTION"]
    for position, paragraph in enumerate(paragraphs):
        body += [".PP"] * (position > 0) + [flowing(paragraph)]
    body += [".SH OPTIONS", *_entries((_named(term), words) for term, words in records)]
    if verb == "check":
        body += _exit_status()
    return _page(
        page_name(verb),
        what,
        f"\\fBcspcheck {verb}\\fR {escaped(pieces)}",
        body,
        version,
        ["cspcheck"],
    )
