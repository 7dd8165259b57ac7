"""The one step of the build that ``pyproject.toml`` cannot say: the parse table is made, and shipped with the grammar.

Otherwise each user's first run would compute it, with Lark, and keep it in a cache.
"""

from __future__ import annotations

import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.build_py import build_py

ROOT = Path(__file__).resolve().parent


class BuildWithTable(build_py):
    """Copies the package and puts the table beside the grammar in the copy; a checkout stays as it is."""

    def run(self) -> None:
        """Build."""
        super().run()
        if not self.editable_mode:
            sys.path.insert(0, str(ROOT))
            from cspcheck.cspm.parsing.table import GRAMMAR, ship

            ship(Path(self.build_lib) / GRAMMAR.relative_to(ROOT))


setup(cmdclass={"build_py": BuildWithTable})
