"""The steps of the build that ``pyproject.toml`` cannot say: the parse tables, and the description of a release.

A table is made once and shipped with its grammar; otherwise each user's first run would compute it, with Lark, and
keep it in a cache. The description is the README without its links to other files of the repository: where a release is
described, these lead nowhere.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent
_LINK_INSIDE = re.compile(r"(?<!!)\[([^]\n]+)\]\((?![a-z]+:)[^)\s]+\)")


class BuildWithTables(build_py):
    """Copies the package and puts the table beside each grammar in the copy; a checkout stays as it is."""

    def run(self) -> None:
        """Build."""
        super().run()
        if not self.editable_mode:
            sys.path.insert(0, str(ROOT))
            from cspcheck.cspm.oz.reading.reader import OZ
            from cspcheck.cspm.parsing.table import CSPM, ship

            for grammar in (CSPM, OZ):
                ship(grammar, Path(self.build_lib) / grammar.path.relative_to(ROOT))


def description() -> str:
    """The README with the text of a link in place of a link to a file."""
    return _LINK_INSIDE.sub(r"\1", (ROOT / "README.md").read_text(encoding="utf-8"))


setup(
    cmdclass={"build_py": BuildWithTables},
    long_description=description(),
    long_description_content_type="text/markdown",
)
