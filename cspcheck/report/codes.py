"""The pages about codes in the documentation, from the register of mistakes: a list, and a page for each hundred.

``python -m cspcheck.report.codes docs`` writes them; a test holds the files to the register.
"""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from cspcheck.cspm.diagnostics import Mistake
from cspcheck.register import PHASES, all_mistakes

_WRITTEN = "<!-- Written by `python -m cspcheck.report.codes docs`; do not edit. -->\n"
_HEAD = f"""\
# Codes

Everything that cspcheck says of a script has a code. `cspcheck explain CODE` prints what stands on these pages.

{_WRITTEN}"""


def code_pages() -> dict[str, str]:
    """The pages in Markdown, by their paths below the folder of the documentation."""
    listed = [_HEAD]
    pages: dict[str, str] = {}
    for phase, mistakes in groupby(all_mistakes(), key=lambda mistake: mistake.code[3]):
        group = list(mistakes)
        page = f"codes/{phase}00.md"
        listed.append(f"## [{PHASES[phase]}]({page})\n")
        listed.append("".join(f"- [{m.code}]({page}#{m.code.lower()}) {m.title}\n" for m in group))
        pages[page] = "\n".join([f"# {PHASES[phase]}\n\n{_WRITTEN}", *map(_entry, group)])
    return {"codes.md": "\n".join(listed), **pages}


def _entry(mistake: Mistake) -> str:
    return (
        f"## {mistake.code}\n\n**{mistake.title}**\n\n{_paragraphs(mistake.explanation)}\n\n"
        f"Example:\n\n{_fenced(mistake.example)}\n\nRepair:\n\n{_fenced(mistake.repair)}\n"
    )


def _paragraphs(text: str) -> str:
    return "\n\n".join(" ".join(paragraph.split()) for paragraph in text.strip().split("\n\n"))


def _fenced(text: str) -> str:
    """A code block, with a fence longer than any in the text."""
    longest = max((len(line) - len(line.lstrip("`")) for line in text.splitlines()), default=0)
    fence = "`" * max(3, longest + 1)
    return f"{fence}\n{text.strip(chr(10))}\n{fence}"


def write(folder: Path) -> None:
    """Write the pages into the folder of the documentation."""
    for path, text in code_pages().items():
        (folder / path).parent.mkdir(exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    import sys

    write(Path(sys.argv[1]))
