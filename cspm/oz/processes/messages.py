"""Mistakes that show when a class is turned into a process: values, finite readings, states."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity, mistake
from cspcheck.cspm.source import Span


@mistake(
    "CSP680",
    "a term without a value",
    explanation="""
A partial operation was applied outside what it is defined for: the head of an empty sequence, a function outside
its domain, a division by zero, the least number of an empty set. A predicate in which such a term matters is neither
true nor false, so the search cannot go on. Guard the term with the condition under which it has a value.
""",
    example="""
class C
  chan get : [v! : 0..3]
  state items : seq (0..3)
  init items = <>
  op com_get v! : 0..3 where v! = head items
end
assert C :[deadlock free]
""",
    repair="""
class C
  chan get : [v! : 0..3]
  state items : seq (0..3)
  init items = <>
  op com_get v! : 0..3 where items /= <> and v! = head items
end
""",
)
def undefined(what: str, span: Span | None) -> Diagnostic:
    """A partial operation outside its domain; *what* says which."""
    return Diagnostic("CSP680", what, span)


@mistake(
    "CSP681",
    "a wide type without a finite reading",
    explanation="""
A search takes values one by one, so what it has to choose from must be finite. Nothing here bounds the variable: its
type is infinite, no equation gives its value, and no inequalities enclose it. Deadlock freedom and refinement are tried
to be proved for all values then; what is not decided so needs a `reading`, which says what values the search takes.
What is proved is about the real type all the same. Results say which readings were used.
""",
    example="""
class C
  chan put : [v? : nat]
  state n : nat
  init n = 0
  op com_put Delta(n) v? : nat where n' = v?
end
assert C :[deterministic]
""",
    repair="""
reading nat = 0..3
class C
  chan put : [v? : nat]
  state n : nat
  init n = 0
  op com_put Delta(n) v? : nat where n' = v?
end
assert C :[deterministic]
""",
)
def no_finite_reading(variable: str | None, carrier: str, suggestion: str, span: Span | None) -> Diagnostic:
    """A set that is infinite would have to be gone through."""
    who = "a value" if variable is None else f"`{variable}`"
    return Diagnostic(
        "CSP681",
        f"{who} can be anything in `{carrier}`, which is not finite",
        span,
        annotation="chosen from here",
        help=f"give it a finite reading: `{suggestion}`",
    )


@mistake(
    "CSP682",
    "a finite set that is too large to be gone through",
    explanation="""
The set is finite but has more elements than a search can take one by one. Function spaces and power sets grow
exponentially: a smaller reading of what they are made of helps, or an equation that gives the value.
""",
    example="""
class C
  chan put : [v? : power (0..40)]
  state s : power (0..40)
  init s = {}
  op com_put Delta(s) v? : power (0..40) where s' = v?
end
assert C :[deterministic]
""",
    repair="""
class C
  chan put : [v? : power (0..4)]
  state s : power (0..4)
  init s = {}
  op com_put Delta(s) v? : power (0..4) where s' = v?
end
""",
)
def set_too_large(what: str, most: int, span: Span | None) -> Diagnostic:
    """A finite set with more elements than are written out."""
    return Diagnostic("CSP682", f"`{what}` has more than {most:,} elements", span)


@mistake(
    "CSP683",
    "constants that no values satisfy",
    explanation="""
The axioms about the constants have no solution: either they contradict each other, or the finite readings of the
constants' types are too small for one. Nothing can be said of the classes of such a specification.
""",
    example="""
const max : nat where max < 0 end
class C
  chan tick
  state n : nat
  init n = 0
  op com_tick Delta(n) where n < max and n' = n + 1
end
assert C :[deadlock free]
""",
    repair="""
const max : nat where max = 3 end
class C
  chan tick
  state n : nat
  init n = 0
  op com_tick Delta(n) where n < max and n' = n + 1
end
""",
)
def no_constants(names: Sequence[str], span: Span | None) -> Diagnostic:
    """Axioms without a solution."""
    listed = ", ".join(f"`{name}`" for name in names)
    return Diagnostic("CSP683", f"no values of {listed} satisfy the axioms", span)


@mistake(
    "CSP684",
    "a class without an initial state",
    explanation="""
No state satisfies both INIT and the invariant, as far as the finite readings go. The process of such a class would be
an internal choice among nothing. `cspcheck prove` says whether there is an initial state at all.
""",
    example="""
class C
  chan tick
  state n : nat where n < 3
  init n = 5
  op com_tick Delta(n) where n' = n + 1
end
assert C :[deadlock free]
""",
    repair="""
class C
  chan tick
  state n : nat where n < 3
  init n = 0
  op com_tick Delta(n) where n' = n + 1
end
""",
)
def no_initial_state(name: str, outside: str | None, span: Span | None) -> Diagnostic:
    """INIT and the invariant exclude each other; *outside* tells of an initial state outside the finite reading."""
    notes = () if outside is None else (f"there is one outside the finite readings: {outside}",)
    return Diagnostic("CSP684", f"class `{name}` has no initial state", span, notes=notes)


@mistake(
    "CSP685",
    "a name that a class needs for itself",
    explanation="""
Classes share their names with the script around them: a class is a process of its name, a given set with a finite
reading is a datatype whose elements are called `NAME_1`, `NAME_2` and so on, a free type is a datatype, a channel of a
class is a channel. Each of these names may be declared once.
""",
    example="""
channel C
class C
  chan tick
end
""",
    repair="""
channel c
class C
  chan tick
end
""",
)
def name_taken(name: str, what: str, span: Span | None, other: Span | None) -> Diagnostic:
    """A name of the Object-Z part that CSPm declares too."""
    labels = () if other is None else (Label(other, "declared here too"),)
    return Diagnostic("CSP685", f"`{name}` is {what} and something else as well", span, labels=labels)


@mistake(
    "CSP686",
    "a class that leaves its finite readings cannot be written as plain CSPm",
    explanation="""
`cspcheck cspm` writes the data of each class as a process. A state outside the finite readings has no such process,
and leaving it out would make a script that lacks behaviour which the class has. Give a larger reading, or a class whose
predicates keep it inside.
""",
    example="""
reading nat = 0..3
class C
  chan tick
  state n : nat
  init n = 0
  op com_tick Delta(n) where n' = n + 1
end
""",
    repair="""
reading nat = 0..3
class C
  chan tick
  state n : nat
  init n = 0
  op com_tick Delta(n) where n < 3 and n' = n + 1
end
""",
)
def export_leaves(name: str, report: str, span: Span | None) -> Diagnostic:
    """A class that is to be written as plain CSPm has states outside its readings."""
    return Diagnostic("CSP686", f"class `{name}` cannot be written: {report}", span, help="give it a larger reading")


@mistake(
    "CSP687",
    "too many values that would have to be tried",
    explanation="""
Where no equation gives the value of a variable, its values are tried one by one, and for several such variables in all
combinations. For one operation in one state that came to more than the search is willing to do. Equations such as
`x' = e`, inequalities that enclose a variable, or smaller sets help.
""",
    example="""
class C
  chan pick : [a?, b?, c?, d? : 0..99]
  state n : 0..99
  init n = 0
  op com_pick Delta(n) a?, b?, c?, d? : 0..99 where a? * b? - c? * d? = 9999 and n' = a?
end
assert C :[deadlock free]
""",
    repair="""
class C
  chan pick : [a?, b? : 0..99]
  state n : 0..99
  init n = 0
  op com_pick Delta(n) a?, b? : 0..99 where a? * b? = 81 and n' = a?
end
""",
)
def too_many_tried(most: int) -> Diagnostic:
    """No end of values to be tried."""
    return Diagnostic(
        "CSP687",
        f"more than {most:,} combinations of values would have to be tried",
        help="let equations or inequalities say more of the variables, or take smaller sets",
    )


@mistake(
    "CSP688",
    "an assertion about the data of classes is no assertion of CSPm",
    explanation="""
`cspcheck cspm` writes a script for tools that know nothing of Object-Z. What they cannot be asked (proof obligations,
data refinement, subclasses) is left out of the script that is written, and stands there in a comment.
""",
    example="""
class C
  chan tick
  state n : 0..3
  init n = 0
  op com_tick Delta(n) where n' = (n + 1) mod 4
end
assert C :[obligations]
""",
    repair="""
class C
  chan tick
  state n : 0..3
  init n = 0
  op com_tick Delta(n) where n' = (n + 1) mod 4
end
assert C :[deadlock free]
""",
)
def assertion_left_out(text: str, span: Span | None) -> Diagnostic:
    """An assertion that is not written."""
    return Diagnostic("CSP688", f"`assert {text}` is left out: CSPm cannot say it", span, Severity.WARNING)
