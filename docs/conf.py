"""The documentation as a site: ``sphinx-build docs docs/_build``."""

project = "cspcheck"
author = "the authors of cspcheck"
extensions = ["myst_parser"]
html_theme = "furo"
html_title = "cspcheck"
exclude_patterns = ["_build"]
myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
suppress_warnings = ["myst.xref_missing", "misc.highlighting_failure"]
highlight_language = "text"


def setup(app: object) -> None:
    """Let blocks marked ``csp`` be coloured by the lexer of the project."""
    from cspcheck.highlighting import CspmLexer

    app.add_lexer("csp", CspmLexer)  # type: ignore[attr-defined]
    app.add_lexer("cspm", CspmLexer)  # type: ignore[attr-defined]
