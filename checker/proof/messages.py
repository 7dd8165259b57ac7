"""Mistakes in what is asked of a proof (CSP7xx): one builder each."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, mistake
from cspcheck.cspm.source import Span

_COUNTER = """
class Counter
  chan up : []
  main = up -> main
  state
    n : nat
  where
    n <= 9
  init
    n = 0
  op up
    Delta(n)
  where
    n < 9
    n' = n + 1
end
"""

_MODULO = """
class Wheel
  chan up : []
  main = up -> main
  state
    k : 0..9
  init
    k = 0
  op up
    Delta(k)
  where
    k < 9
    k' = k + 1
end
retrieve Same between Counter and Wheel where
  n = k
end
"""


def _one_of(names: Sequence[str]) -> str:
    quoted = [f"`{name}`" for name in names]
    return quoted[0] if len(quoted) == 1 else f"{', '.join(quoted[:-1])} or {quoted[-1]}"


@mistake(
    "CSP701",
    "unknown obligation",
    explanation="""
An assertion `C :[...]` names a proof obligation that there is not. `C :[obligations]` stands for all of them; the names
of single ones are listed on the page about proof.
""",
    example=_COUNTER + "assert Counter :[invariant kept]\n",
    repair=_COUNTER + "assert Counter :[invariant preserved]\n",
)
def unknown_obligation(name: str, span: Span | None, similar: Sequence[str], known: Sequence[str]) -> Diagnostic:
    """*similar*: names of obligations that look like it; *known*: all of them."""
    return Diagnostic(
        "CSP701",
        f"there is no obligation `{name}`",
        span,
        annotation="not the name of an obligation",
        help=f"did you mean {_one_of(similar)}?" if similar else f"the obligations are {_one_of(known)}",
    )


@mistake(
    "CSP702",
    "obligation of an operation that the class does not have",
    explanation="""
An assertion `C :[...]: op`, or `--precondition op`, names an operation for which the class has no schema. Only
operations with a schema have obligations.
""",
    example=_COUNTER + "assert Counter :[feasible]: upp\n",
    repair=_COUNTER + "assert Counter :[feasible]: up\n",
)
def no_such_operation(owner: str, name: str, span: Span | None, similar: Sequence[str]) -> Diagnostic:
    """*similar*: operations of the class that look like it."""
    return Diagnostic(
        "CSP702",
        f"the class `{owner}` has no operation `{name}`",
        span,
        annotation="no schema has this name",
        help=f"did you mean {_one_of(similar)}?" if similar else None,
    )


@mistake(
    "CSP703",
    "unknown retrieve relation",
    explanation="""
A data refinement `A [OZ= C via R` names a retrieve relation that the script does not define. A retrieve relation is
written `retrieve R between A and C where ... end`.
""",
    example=_COUNTER + _MODULO + "assert Counter [OZ= Wheel via Sam\n",
    repair=_COUNTER + _MODULO + "assert Counter [OZ= Wheel via Same\n",
)
def unknown_retrieve_relation(name: str, span: Span | None, similar: Sequence[str]) -> Diagnostic:
    """*similar*: relations of the script that look like it."""
    return Diagnostic(
        "CSP703",
        f"there is no retrieve relation `{name}`",
        span,
        annotation="not defined",
        help=f"did you mean {_one_of(similar)}?"
        if similar
        else "write `retrieve NAME between ABSTRACT and CONCRETE where ... end`",
    )


@mistake(
    "CSP704",
    "retrieve relation between other classes",
    explanation="""
A data refinement `A [OZ= C via R` needs a retrieve relation between the abstract class A and the concrete class C, in
this order.
""",
    example=_COUNTER + _MODULO + "assert Wheel [OZ= Counter via Same\n",
    repair=_COUNTER + _MODULO + "assert Counter [OZ= Wheel via Same\n",
)
def other_classes(
    name: str, wanted: tuple[str, str], found: tuple[str, str], span: Span | None, definition: Span | None
) -> Diagnostic:
    """*wanted*, *found*: abstract and concrete class of the assertion and of the relation."""
    labels = () if definition is None else (Label(definition, f"between `{found[0]}` and `{found[1]}`"),)
    return Diagnostic(
        "CSP704",
        f"`{name}` relates `{found[0]}` and `{found[1]}`, not `{wanted[0]}` and `{wanted[1]}`",
        span,
        annotation="relates other classes",
        labels=labels,
    )


@mistake(
    "CSP705",
    "no projection to the parent",
    explanation="""
`Parent [OZ= Child` compares the two classes by the variables that they share. A variable of the parent is not there
under its name in the child, so there is nothing to compare it with. Give a retrieve relation.
""",
    example=_COUNTER
    + """
class Other
  chan up : []
  main = up -> main
  state
    m : nat
  op up
    Delta(m)
  where
    m' = m + 1
end
assert Counter [OZ= Other
""",
    repair=_COUNTER
    + """
class Other
  inherit Counter
  main = up -> main
end
assert Counter [OZ= Other
""",
)
def no_projection(parent: str, child: str, variable: str, span: Span | None) -> Diagnostic:
    """*variable* of *parent* has no counterpart in *child*."""
    return Diagnostic(
        "CSP705",
        f"`{child}` has no variable `{variable}` as `{parent}` has it",
        span,
        annotation="cannot be compared by its variables",
        help=f"write `{parent} [OZ= {child} via R` with a retrieve relation",
    )
