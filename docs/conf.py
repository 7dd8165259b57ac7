"""The documentation as a site: ``sphinx-build docs docs/_build``."""

import re

project = "cspcheck"
author = "the authors of cspcheck"
extensions = ["myst_parser"]
html_theme = "furo"
html_title = "cspcheck"
exclude_patterns = ["_build"]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["misc.highlighting_failure"]
highlight_language = "text"

_BEYOND = re.compile(r"\.(csp|tex|oz)(#L\d+)?$|/specs/.*README(\.md)?$")
"""Links to files of the repository that are no part of the site."""


_LISTS = {"codes": "codes/*", "decisions/README": "*"}
"""Pages that list others, which the navigation has below them."""


def with_pages_below(app: object, page: str, source: list[str]) -> None:
    """Give the pages that list others the list that the navigation reads; in the repository they need none."""
    if page in _LISTS:
        source[0] += f"\n```{{toctree}}\n:hidden:\n:glob:\n\n{_LISTS[page]}\n```\n"


def without_links_beyond(app: object, doctree: object) -> None:
    """Leave the text of links to scripts and to their folders: pages of case studies are those of the repository."""
    from docutils import nodes
    from sphinx import addnodes

    for link in list(doctree.findall(addnodes.pending_xref)):  # type: ignore[attr-defined]
        if link["reftype"] == "myst" and _BEYOND.search(link["reftarget"]):
            text = nodes.inline()
            text += link.children
            link.replace_self(text)


def setup(app: object) -> None:
    """Let blocks marked ``csp`` be coloured by the lexer of the project, and laws of processes too."""
    from cspcheck.highlighting import CspmLexer

    for name in ("csp", "cspm", "law"):
        app.add_lexer(name, CspmLexer)  # type: ignore[attr-defined]
    app.connect("source-read", with_pages_below)  # type: ignore[attr-defined]
    app.connect("doctree-read", without_links_beyond)  # type: ignore[attr-defined]
