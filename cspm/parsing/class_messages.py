"""What can be wrong where a script of CSPm meets classes or documents, as far as no class need be read to see it."""

from __future__ import annotations

from cspcheck.cspm.diagnostics import Diagnostic, mistake
from cspcheck.cspm.source import Span


@mistake(
    "CSP613",
    "an assertion about a class does not name one",
    explanation="Obligations, data refinement and subtyping are claimed of classes by their names.",
    example="class C\n  state n : nat\nend\nassert (C ; C) :[obligations]",
    repair="class C\n  state n : nat\nend\nassert C :[obligations]",
)
def no_class_name(span: Span) -> Diagnostic:
    """The subject of an assertion about a class is no plain name."""
    return Diagnostic("CSP613", "this claim is made of a class by its name", span)


@mistake(
    "CSP614",
    "a data refinement of an unknown direction",
    explanation="`assert A [OZ= C via R` claims a downward simulation; the upward form is written `:[upward]` behind "
    "it.",
    example="class A\n  state n : nat\nend\nretrieve R between A and A where true end\n"
    "assert A [OZ= A via R :[backward]",
    repair="class A\n  state n : nat\nend\nretrieve R between A and A where true end\nassert A [OZ= A via R :[upward]",
)
def unknown_direction(span: Span, words: str) -> Diagnostic:
    """The words behind a data refinement are none of its directions."""
    return Diagnostic(
        "CSP614", f"`{words}` is no direction of a simulation", span, help="it can be `upward` or `downward`"
    )


@mistake(
    "CSP615",
    "an `end` too many",
    explanation="`end` closes a class, a schema, a retrieve relation or a section of a class.",
    example="schema S\n  x : nat\nend\nend\n",
    repair="schema S\n  x : nat\nend",
)
def end_too_many(span: Span) -> Diagnostic:
    """An ``end`` that closes nothing."""
    return Diagnostic("CSP615", "this `end` closes nothing", span, help="remove it")


@mistake(
    "CSP617",
    "`||` without classes",
    explanation="`P || Q` joins classes on the channels that both declare. Processes of CSPm are joined on a set of "
    "events that is written out.",
    example="given ITEM\nP = STOP || STOP",
    repair="given ITEM\nP = STOP [| {} |] STOP",
)
def composition_without_classes(span: Span) -> Diagnostic:
    """``P || Q`` in a script that has no class."""
    return Diagnostic(
        "CSP617",
        "`||` joins classes, and this script has none",
        span,
        help="write `P [| A |] Q` or `P [ A || B ] Q`, or `P ||| Q` if they share no events",
    )


@mistake(
    "CSP627",
    "a LaTeX document is to be formatted",
    explanation="`fmt` tidies scripts. The classes of a LaTeX document are tidied by `latex`, which writes a document "
    "of its own, or with `--text` a script.",
    example="cspcheck fmt paper.tex",
    repair="cspcheck latex paper.tex",
)
def document_to_format(name: str) -> Diagnostic:
    """The file *name* is a LaTeX document."""
    return Diagnostic("CSP627", f"`{name}` is a LaTeX document", help="use `cspcheck latex`, perhaps with `--text`")
