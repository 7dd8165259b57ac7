"""Mistakes in asking for pictures (CSP91x): one builder each."""

from __future__ import annotations

from cspm.diagnostics import Diagnostic, mistake


@mistake(
    "CSP910",
    "machine too large to draw",
    explanation="""
A picture of more than a few hundred states shows nothing. The limit keeps cspcheck from working for minutes on one.
""",
    example="cspcheck graph rov.csp ROV_Control_Module -o rov.svg",
    repair="""
cspcheck graph rov.csp Compass -o compass.svg
cspcheck graph rov.csp ROV_Control_Module --architecture -o rov.svg
""",
)
def too_large_to_draw(process: str, most: int) -> Diagnostic:
    """*process* has more than *most* states."""
    return Diagnostic(
        "CSP910",
        f"`{process}` has more than {most:,} states, too many for a picture",
        help="draw a component of it, draw the `--architecture`, or raise the limit with `--max-states`",
    )


@mistake(
    "CSP911",
    "unknown picture format",
    explanation="The ending of the file after `-o` tells the format of the picture: `.svg`, `.html` or `.dot`.",
    example="cspcheck graph rov.csp Compass -o compass.png",
    repair="cspcheck graph rov.csp Compass -o compass.svg",
)
def unknown_picture_format(path: str) -> Diagnostic:
    """The ending of *path* is none that can be drawn."""
    return Diagnostic(
        "CSP911", f"no picture format for `{path}`", help="the file must end in `.svg`, `.html` or `.dot`"
    )


@mistake(
    "CSP912",
    "no counterexample to draw",
    explanation="`--trace` draws the counterexample of an assertion. One that passes, or has no verdict, has none.",
    example="""
channel a
P = a -> P
assert P :[deadlock free]
""",
    repair="draw the machine itself, or name an assertion that fails",
)
def no_counterexample(assertion: str, verdict: str) -> Diagnostic:
    """The verdict of *assertion* came without a counterexample."""
    return Diagnostic("CSP912", f"`{assertion}` has no counterexample to draw: its verdict is {verdict}")
