"""Mistakes in lemmas: what they use, and by what they are to be proved."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, mistake
from cspcheck.cspm.oz.typing.messages import meant
from cspcheck.cspm.source import Span

_LEMMA = "lemma two : forall s, t : seq nat @ #(s ^ t) = #s + #t by induction on {0}\nlemma one : 1 < 2{1}"


@mistake(
    "CSP661",
    "unknown lemma",
    explanation=(
        "What stands behind `using` are lemmas of the class or of the script, and laws of the toolkit by the names "
        "that the page about proof lists."
    ),
    example=_LEMMA.format("s", " using too"),
    repair=_LEMMA.format("s", " using two"),
)
def unknown_lemma(name: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A name behind ``using`` that no lemma has."""
    return Diagnostic("CSP661", f"there is no lemma `{name}`", span, help=meant(suggested))


_SUM = "lemma sum : forall m, n : nat @ m + n >= m\nlemma one : forall k : nat @ k + 1 >= k using sum({0})"


@mistake(
    "CSP664",
    "a lemma is used for what it says nothing of",
    explanation=(
        "In brackets behind a lemma stand the values that it is used for: one for each variable that its outermost "
        "`forall` binds, in that order and of that type. Without brackets it is used for whatever fits."
    ),
    example=_SUM.format("k"),
    repair=_SUM.format("k, 1"),
)
def lemma_arguments(name: str, variables: Sequence[str], given: int, span: Span) -> Diagnostic:
    """Too many values for a lemma, or too few. *variables*: that it is about."""
    if not variables:
        told = f"`{name}` begins with no `forall`: it is used without values"
        return Diagnostic("CSP664", told, span, annotation="no value is needed")
    shown = ", ".join(f"`{variable}`" for variable in variables)
    many = f"{len(variables)} values" if len(variables) > 1 else "one value"
    told = (
        f"`{name}` is used for {many}, here are {given}" if given > 1 else f"`{name}` is used for {many}, here is one"
    )
    return Diagnostic("CSP664", told, span, annotation=f"it says something of all {shown}")


def lemma_argument(name: str, variable: str, wanted: str, found: str, span: Span) -> Diagnostic:
    """A value for a variable of a lemma that is of another type."""
    told = f"`{variable}` of the lemma `{name}` is of type {wanted}, and this is of type {found}"
    return Diagnostic("CSP664", told, span, annotation=f"{wanted} is needed")


@mistake(
    "CSP662",
    "lemmas that use each other",
    explanation="A lemma may be proved with the help of others only where those are proved without it.",
    example="lemma one : 1 < 2 using two\nlemma two : 2 < 3 using one",
    repair="lemma one : 1 < 2 using two\nlemma two : 2 < 3",
)
def circular_lemmas(names: Sequence[str], span: Span) -> Diagnostic:
    """*names*: the lemmas of the circle."""
    if len(set(names)) == 1:
        return Diagnostic("CSP662", f"`{names[0]}` is to be proved with itself", span)
    shown = ", ".join(f"`{name}`" for name in dict.fromkeys(names))
    return Diagnostic("CSP662", f"these lemmas are to be proved with each other: {shown}", span)


@mistake(
    "CSP663",
    "induction on what is no variable",
    explanation=(
        "A lemma is proved by induction on a variable of its outermost `forall`: a number from some number on, a "
        "sequence, a finite set or function, or a value of a free type."
    ),
    example=_LEMMA.format("u", ""),
    repair=_LEMMA.format("s", ""),
)
def induction_on_nothing(name: str, span: Span) -> Diagnostic:
    """A name behind ``by induction on`` that the outermost quantifier does not bind."""
    return Diagnostic("CSP663", f"the lemma says nothing of all `{name}`", span, annotation="not bound by its `forall`")
