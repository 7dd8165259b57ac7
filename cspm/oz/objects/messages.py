"""Mistakes in documents that use objects as references."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from cspcheck.cspm.diagnostics import Diagnostic, Severity, mistake
from cspcheck.cspm.source import Span

_A = "class A\n  state n : nat\n  op step = [Delta(n) | n' = n + 1]\nend\n"


@mistake(
    "CSP670",
    "what is no class is used as one",
    explanation=(
        "`poly C`, a union of classes and `C%own` (an object that belongs to the attribute) are sets of objects, "
        "made of classes."
    ),
    example=_A + "const x : poly nat",
    repair=_A + "const x : poly A",
)
def no_class(what: str, found: str, span: Span) -> Diagnostic:
    """A set of values where a class is needed; *what* is what needs it."""
    return Diagnostic("CSP670", f"{what} needs a class, this is `{found}`", span)


def operation_of_no_object(name: str, found: str, span: Span) -> Diagnostic:
    """``n.Op`` for a number *n*."""
    return Diagnostic("CSP670", f"only an object has operations, `{name}` is asked of a value of type `{found}`", span)


@mistake(
    "CSP671",
    "classes do not go together in one set of objects",
    explanation=(
        "An object of a union of classes has the features that all of them have, so each of these must be of one type "
        "in all of them. An object of `poly C` is used as one of `C`, so each class that inherits from C must have "
        "the parameters of C, its visible features, and its operations with the same parameters."
    ),
    example=_A + "class B\n  state n : power nat\n  op step = [Delta(n) | n' = {}]\nend\nconst x : A union B",
    repair=_A + "class B\n  state n : nat\n  op step = [Delta(n) | n' = 0]\nend\nconst x : A union B",
)
def feature_differs(name: str, classes: tuple[str, str], types: tuple[str, str], span: Span) -> Diagnostic:
    """A feature that two classes of one set of objects have in different types."""
    (first, second), (one, other) = classes, types
    told = f"`{name}` is of type `{one}` in `{first}` and `{other}` in `{second}`"
    return Diagnostic("CSP671", f"{told}, so there is no object that may be of either", span)


def no_union(classes: tuple[str, str], span: Span) -> Diagnostic:
    """One generic class with different parameters in a union."""
    return Diagnostic("CSP671", f"`{classes[0]}` and `{classes[1]}` are one class with different parameters", span)


def hidden_in_subclass(name: str, parent: str, child: str, span: Span) -> Diagnostic:
    """``poly C`` where a class that inherits from C hides a feature of it."""
    told = f"`{child}` inherits from `{parent}` and does not show `{name}`"
    return Diagnostic("CSP671", f"{told}, so `poly {parent}` has no common interface", span)


def parameters_of_subclass(parent: str, child: str, counts: tuple[int, int], span: Span) -> Diagnostic:
    """``poly C`` where a class that inherits from C has other parameters."""
    told = f"`{parent}` has {counts[0]} generic parameters and `{child}`, which inherits from it, {counts[1]}"
    return Diagnostic("CSP671", f"{told}, so it is not known which `{child}` are meant", span)


@mistake(
    "CSP672",
    "the parameters of a generic name are not determined",
    explanation="Where a generic constant or class is used without parameters, its use must say what they are.",
    example="class A[X]\n  state n : nat\n  op step = [n = 0]\nend\nconst a : A where a.n = 0 end",
    repair="class A\n  state n : nat\n  op step = [n = 0]\nend\nclass B\n  state a : A\n  op step = a.step\nend",
)
def parameters_open(name: str, span: Span) -> Diagnostic:
    """A generic name whose parameters nothing tells."""
    return Diagnostic("CSP672", f"nothing says what the parameters of `{name}` are", span, help=f"write `{name}[...]`")


NOT_RUN: Final = "CSP673"
"""The code of what is said of a paragraph that is typed alone."""


@mistake(
    NOT_RUN,
    "a paragraph is typed, but cannot be run",
    explanation=(
        "Documents of Object-Z are read and typed with objects as references. What is run as a process or proved is "
        "the part whose objects are fixed or belong to an attribute; the rest would need a heap."
    ),
    example="class A\n  state b : B\nend\nclass B\n  state a : A\nend\nassert A :[deadlock free]",
    repair="class A\n  state n : nat\n  op step = [Delta(n) | n' = n]\nend\nassert A :[deadlock free]",
)
def not_run(name: str, reason: str, span: Span) -> Diagnostic:
    """A class or another paragraph that is typed, and why it cannot be run."""
    return Diagnostic(NOT_RUN, f"`{name}` is typed, but cannot be run: {reason}", span, Severity.WARNING)


def asked_of_not_run(name: str, reason: str, span: Span) -> Diagnostic:
    """A claim about a class that cannot be run."""
    return Diagnostic(NOT_RUN, f"nothing can be claimed of `{name}`: {reason}", span)


def duplicate_renaming(name: str, span: Span) -> Diagnostic:
    """``[a/x, b/x]``."""
    return Diagnostic("CSP638", f"`{name}` is renamed twice", span)


def bound_is_parameter(name: str, span: Span) -> Diagnostic:
    """A distributed operation over a name that its operands have as a parameter."""
    told = f"`{name}` is declared twice: the operation has a parameter of that name"
    return Diagnostic("CSP638", told, span, annotation="declared again here")


def nothing_to_hide(name: str, span: Span, known: Sequence[str]) -> Diagnostic:
    """A hidden name that the operation does not have."""
    has = f"it has {', '.join(f'`{k}`' for k in known)}" if known else "it has none"
    return Diagnostic("CSP630", f"`{name}` is no parameter of this operation", span, help=has)


def not_shown(name: str, owner: str, span: Span) -> Diagnostic:
    """A feature that the visibility list of a class leaves out."""
    told = f"`{owner}` does not show `{name}`"
    return Diagnostic("CSP635", told, span, help=f"add `{name}` to the visibility list of `{owner}`")


def parameter_differs(name: str, first: str, second: str, span: Span) -> Diagnostic:
    """A parameter that two operands have in different types."""
    return Diagnostic("CSP646", f"`{name}` is of type `{first}` in one operand and `{second}` in the other", span)


def communication_differs(name: str, types: tuple[str, str], span: Span) -> Diagnostic:
    """An output that goes to an input of another type."""
    return Diagnostic("CSP646", f"`{name}!` is of type `{types[0]}` and `{name}?`, where it goes, `{types[1]}`", span)


def value_handed_on(name: str, types: tuple[str, str], span: Span) -> Diagnostic:
    """What an operation leaves behind, and the next one of a sequence takes as another type."""
    told = f"`{name}` is of type `{types[0]}`, and `{name[:-1]}` in the next operation `{types[1]}`"
    return Diagnostic("CSP646", told, span)
