"""The list of all codes for the documentation, from the register of mistakes.

``python -m cspcheck.report.codes > docs/codes.md`` writes it; a test holds the file to the register.
"""

from __future__ import annotations

from itertools import groupby

from cspcheck.cspm.diagnostics import Mistake
from cspcheck.register import PHASES, all_mistakes

_HEAD = """\
# Codes

Everything that cspcheck says of a script has a code. `cspcheck explain CODE` prints what stands here.

<!-- Written by `python -m cspcheck.report.codes > docs/codes.md`; do not edit. -->
"""


def codes_document() -> str:
    """The document, in Markdown."""
    parts = [_HEAD]
    for phase, mistakes in groupby(all_mistakes(), key=lambda mistake: mistake.code[3]):
        group = list(mistakes)
        parts.append(f"## {PHASES[phase]}\n")
        parts.append("".join(f"- [{m.code}](#{m.code.lower()}) {m.title}\n" for m in group))
        parts.extend(_entry(mistake) for mistake in group)
    return "\n".join(parts)


def _entry(mistake: Mistake) -> str:
    return (
        f"### {mistake.code}\n\n**{mistake.title}**\n\n{_paragraphs(mistake.explanation)}\n\n"
        f"Example:\n\n{_fenced(mistake.example)}\n\nRepair:\n\n{_fenced(mistake.repair)}\n"
    )


def _paragraphs(text: str) -> str:
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.strip().split("\n\n"))


def _fenced(text: str) -> str:
    """A code block, with a fence longer than any in the text."""
    longest = max((len(line) - len(line.lstrip("`")) for line in text.splitlines()), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}\n{text.strip(chr(10))}\n{fence}"


if __name__ == "__main__":
    import sys

    sys.stdout.write(codes_document())
