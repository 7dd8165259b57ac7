"""Mistakes in the make-up of classes: operations, channels, Delta-lists, inheritance."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity, mistake
from cspcheck.cspm.source import Span


def meant(names: Sequence[str]) -> str | None:
    """The help that asks whether one of these names was meant; None if there are none."""
    if not names:
        return None
    quoted = [f"`{name}`" for name in names]
    return f"did you mean {', '.join(quoted[:-1]) + ' or ' if len(quoted) > 1 else ''}{quoted[-1]}?"


_COUNTER = (
    "class C\n  chan c\n  main = c -> main\n  state\n    x, y : nat\n{secondary}  op {schema}\n    Delta({delta})\n"
    "  where\n    {predicate}\nend"
)


def _counter(predicate: str, delta: str = "x", schema: str = "c", secondary: str = "") -> str:
    return _COUNTER.format(predicate=predicate, delta=delta, schema=schema, secondary=secondary)


def _two(here: str, there: str) -> str:
    return (
        f"class A\n  chan c : [{here}]\n  main = c -> main\n  op com_c\n    v! : nat\n  where\n    v! = 0\nend\n"
        f"class B\n  chan c : [{there}]\n  main = c -> main\n  op com_c\n    {there}\n  where\n    true\nend\n"
        "S = A || B"
    )


def _child(declaration: str) -> str:
    return (
        "class A\n  main = STOP\n  state\n    x : nat\nend\n"
        f"class B\n  inherit A\n  main = STOP\n  state\n    {declaration}\nend"
    )


@mistake(
    "CSP640",
    "a variable changes that the Delta-list does not name",
    explanation="Only variables in the Delta-list of an operation may change; the others keep their values.",
    example=_counter("x' = x + 1\n    y' = x"),
    repair=_counter("x' = x + 1\n    y' = x", delta="x, y"),
)
def not_in_delta(name: str, span: Span, delta: Span | None) -> Diagnostic:
    """A primed variable outside the Delta-list."""
    return Diagnostic(
        "CSP640",
        f"`{name}'` is used, but `{name}` is not in the Delta-list",
        span,
        annotation="does not change",
        labels=() if delta is None else (Label(delta, "of this operation"),),
        help=f"add `{name}` to the Delta-list",
    )


@mistake(
    "CSP641",
    "a variable in the Delta-list is never primed",
    explanation=(
        "Such a variable gets any value that its carrier and the invariant allow, which is seldom meant. Where the "
        "invariant says how it follows from other variables nothing is amiss, and nothing is said; such a variable may "
        "also be declared behind `Delta` in the state, and needs no mention in any operation then."
    ),
    example=_counter("x' = x + 1", delta="x, y"),
    repair=_counter("x' = x + 1"),
)
def never_primed(name: str, span: Span, *, bounded: bool) -> Diagnostic:
    """A variable of the Delta-list about whose new value nothing is said.

    *bounded*: the invariant speaks of it, but not of how it follows from other variables.
    """
    return Diagnostic(
        "CSP641",
        f"`{name}` is in the Delta-list, but nothing says what `{name}'` is",
        span,
        Severity.WARNING,
        annotation="gets any value that the invariant allows" if bounded else "gets any value",
        help=f"say what `{name}'` is, or take `{name}` out of the list",
    )


@mistake(
    "CSP642",
    "a Delta-list names what is no primary state variable",
    explanation=(
        "A Delta-list names primary state variables. Secondary variables follow from them in every operation, and "
        "parameters and constants do not change."
    ),
    example=_counter("x' = x + 1", delta="x, n", secondary="  Delta\n    n : nat\n  where\n    n = x + y\n"),
    repair=_counter("x' = x + 1", delta="x", secondary="  Delta\n    n : nat\n  where\n    n = x + y\n"),
)
def wrong_in_delta(name: str, span: Span, *, secondary: bool, suggested: Sequence[str] = ()) -> Diagnostic:
    """A name in a Delta-list that is no primary variable."""
    what = "a secondary variable: it changes by itself" if secondary else "no state variable"
    help_ = f"leave `{name}` out of the list" if secondary else meant(suggested)
    return Diagnostic("CSP642", f"`{name}` in the Delta-list is {what}", span, help=help_)


@mistake(
    "CSP643",
    "a prime may be missing",
    explanation=(
        "In an operation `x = e` compares the value before; it sets nothing. Where x is in the Delta-list and the "
        "branch does not mention `x'`, the operation is blocked unless x happens to have that value already, and x "
        "gets any value afterwards."
    ),
    example=_counter("x = 0 => x' = 1\n    x > 0 => x = x - 1"),
    repair=_counter("x = 0 => x' = 1\n    x > 0 => x' = x - 1"),
)
def forgotten_prime(name: str, span: Span) -> Diagnostic:
    """An equation for a variable of the Delta-list in a branch without its primed twin."""
    return Diagnostic(
        "CSP643",
        f"this compares `{name}` and does not set it",
        span,
        Severity.WARNING,
        annotation=f"`{name}'` does not occur in this branch",
        help=f"write `{name}' = ...`",
    )


@mistake(
    "CSP644",
    "an operation belongs to no channel",
    explanation=(
        "The schema of an event is called like its channel or method, or `com_c`, `enable_c`, `effect_c`. A schema "
        "whose channel is not declared would have no effect."
    ),
    example=_counter("x' = x + 1", schema="com_cc"),
    repair=_counter("x' = x + 1", schema="com_c"),
)
def schema_without_channel(name: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """An operation schema whose channel the class does not know."""
    return Diagnostic(
        "CSP644",
        f"the schema `{name}` belongs to no channel or method of the class",
        span,
        help=meant(suggested) or "declare it with `chan` or `method`",
    )


@mistake(
    "CSP645",
    "an event has schemas that do not go together",
    explanation=(
        "An event has one schema (`c` or `com_c`), or a guard `enable_c` with an effect `effect_c`. Inherited and "
        "own schemas of an event must be of the same form."
    ),
    example=_counter("x' = x + 1\n  op enable_c\n  where\n    x < 3"),
    repair=_counter("x' = x + 1\n  op enable_c\n  where\n    x < 3", schema="effect_c"),
)
def schemas_clash(event: str, first: str, second: str, span: Span, other: Span | None) -> Diagnostic:
    """Two schemas for one event that exclude each other."""
    return Diagnostic(
        "CSP645",
        f"`{second}` and `{first}` both say what `{event}` does",
        span,
        labels=() if other is None else (Label(other, "the other one"),),
        help=f"use one schema `com_{event}`, or `enable_{event}` with `effect_{event}`",
    )


@mistake(
    "CSP646",
    "parameters of a schema and of its channel differ",
    explanation="A schema may only declare parameters that the channel has, with the same type.",
    example=(
        "class C\n  chan c : [value : nat]\n  main = c -> main\n  state\n    x : nat\n  op com_c\n    Delta(x)\n"
        "    vallue? : nat\n  where\n    x' = vallue?\nend"
    ),
    repair=(
        "class C\n  chan c : [value : nat]\n  main = c -> main\n  state\n    x : nat\n  op com_c\n    Delta(x)\n"
        "    value? : nat\n  where\n    x' = value?\nend"
    ),
)
def parameter_not_of_channel(name: str, channel: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A parameter of a schema that its channel has not."""
    return Diagnostic("CSP646", f"the channel `{channel}` has no parameter `{name}`", span, help=meant(suggested))


def parameter_type(name: str, channel: str, found: str, declared: str, span: Span, other: Span) -> Diagnostic:
    """A parameter that schema and channel give different types, or two operands if there is no channel yet."""
    if not channel:
        told = f"`{name}` is of type `{declared}` in one operand and `{found}` in the other"
        return Diagnostic("CSP646", told, span, labels=(Label(other, "first declared here"),))
    return Diagnostic(
        "CSP646",
        f"`{name}` is of type `{found}` here and `{declared}` on the channel `{channel}`",
        span,
        labels=(Label(other, "the channel's declaration"),),
    )


def parameter_kind(name: str, channel: str, found: str, declared: str, span: Span, other: Span) -> Diagnostic:
    """A parameter with another decoration than on its channel."""
    return Diagnostic(
        "CSP646",
        f"`{name}{found}` is declared `{name}{declared}` on the channel `{channel}`",
        span,
        labels=(Label(other, "the channel's declaration"),),
    )


@mistake(
    "CSP650",
    "classes declare a channel differently",
    explanation=(
        "Classes that declare the same channel are joined on it, so its parameters must have the same types in the "
        "same order everywhere."
    ),
    example=_two("v! : nat", "v? : bool"),
    repair=_two("v! : nat", "v? : nat"),
)
def channel_types(channel: str, name: str, here: tuple[str, str, Span], there: tuple[str, str, Span]) -> Diagnostic:
    """A parameter with different types; *here* and *there* are class, type, place."""
    return Diagnostic(
        "CSP650",
        f"`{name}` of the channel `{channel}` is of type `{here[1]}` in `{here[0]}` and `{there[1]}` in `{there[0]}`",
        here[2],
        annotation=f"`{here[1]}`",
        labels=(Label(there[2], f"`{there[1]}` in `{there[0]}`"),),
    )


def channel_sizes(channel: str, here: tuple[str, int, Span], there: tuple[str, int, Span]) -> Diagnostic:
    """Different numbers of parameters."""
    noun = "parameter" if here[1] == 1 else "parameters"
    return Diagnostic(
        "CSP650",
        f"the channel `{channel}` has {here[1]} {noun} in `{here[0]}` and {there[1]} in `{there[0]}`",
        here[2],
        labels=(Label(there[2], f"in `{there[0]}`"),),
    )


def channel_order(channel: str, here: tuple[str, Span], there: tuple[str, Span]) -> Diagnostic:
    """The same parameters in another order."""
    return Diagnostic(
        "CSP650",
        f"the parameters of the channel `{channel}` stand in another order in `{here[0]}` than in `{there[0]}`",
        here[1],
        labels=(Label(there[1], f"in `{there[0]}`"),),
    )


@mistake(
    "CSP651",
    "the ends of a channel do not match",
    explanation=(
        "On a channel that classes share, one of them outputs each `v!` and the others input it, `v?`. Two classes "
        "that output the same value agree only where their values happen to be equal; where none does, nobody says "
        "what the value is."
    ),
    example=_two("v! : nat", "v! : nat"),
    repair=_two("v! : nat", "v? : nat"),
)
def two_writers(channel: str, name: str, writers: Sequence[tuple[str, Span]]) -> Diagnostic:
    """Several classes output the same parameter."""
    (first, span), *others = writers
    return Diagnostic(
        "CSP651",
        f"`{name}` of the channel `{channel}` is an output of {' and '.join(f'`{w}`' for w, _ in writers)}",
        others[0][1],
        Severity.WARNING,
        labels=(Label(span, f"output of `{first}` too"),),
        help="one class writes, the others read it with `?`",
    )


def no_writer(channel: str, name: str, span: Span) -> Diagnostic:
    """No class outputs a parameter that several read."""
    return Diagnostic(
        "CSP651",
        f"no class outputs `{name}` of the channel `{channel}`",
        span,
        Severity.WARNING,
        annotation="read by all",
        help="declare it with `!` in the class that sends it, or without decoration if all agree on it",
    )


def parameter_names(channel: str, here: tuple[str, str, Span], there: tuple[str, str, Span]) -> Diagnostic:
    """A parameter that classes call differently."""
    return Diagnostic(
        "CSP651",
        f"the channel `{channel}` calls a parameter `{here[1]}` in `{here[0]}` and `{there[1]}` in `{there[0]}`",
        here[2],
        Severity.WARNING,
        labels=(Label(there[2], f"in `{there[0]}`"),),
        help="give it the same name: values are joined by position, people read names",
    )


@mistake(
    "CSP652",
    "only one class knows a channel",
    explanation="A channel (`chan`) joins classes. If no other class declares it, nothing inside waits for it.",
    example="class A\n  chan c\n  main = c -> main\nend\nclass B\n  chan d\n  main = d -> main\nend\nS = A || B",
    repair="class A\n  chan c\n  main = c -> main\nend\nclass B\n  chan c\n  main = c -> main\nend\nS = A || B",
)
def lonely_channel(channel: str, owner: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A channel of one class in a script that has several."""
    return Diagnostic(
        "CSP652",
        f"only `{owner}` declares the channel `{channel}`",
        span,
        Severity.WARNING,
        help=meant(suggested) or "make it a `method` if it is the class's own, or leave it if the environment uses it",
    )


@mistake(
    "CSP653",
    "an event of `main` and the schemas do not match",
    explanation=(
        "An event with outputs needs a schema that says what they are; a schema whose event does not occur in the "
        "process equations can happen at any time."
    ),
    example="class A\n  chan c : [v! : nat]\n  main = c -> main\nend",
    repair="class A\n  chan c : [v! : nat]\n  main = c -> main\n  op com_c\n    v! : nat\n  where\n    v! = 0\nend",
)
def output_without_schema(channel: str, names: Sequence[str], owner: str, span: Span) -> Diagnostic:
    """An event with outputs that no schema speaks of."""
    return Diagnostic(
        "CSP653",
        f"`{channel}` outputs {', '.join(f'`{n}!`' for n in names)}, but `{owner}` has no schema that says what",
        span,
        Severity.WARNING,
        annotation="any value",
        help=f"add `op com_{channel}`",
    )


def schema_not_in_main(schema: str, channel: str, owner: str, span: Span) -> Diagnostic:
    """A schema for an event that the process equations do not mention."""
    return Diagnostic(
        "CSP653",
        f"`{channel}` does not occur in the process equations of `{owner}`",
        span,
        Severity.WARNING,
        annotation="can happen at any time",
        help=f"use `{channel}` in `main`, or remove `{schema}`",
    )


def unused_channel(channel: str, owner: str, span: Span) -> Diagnostic:
    """A channel of a class that occurs in no equation and has no schema."""
    return Diagnostic(
        "CSP653",
        f"`{owner}` declares `{channel}`, but never performs it",
        span,
        Severity.WARNING,
        annotation="blocks it for every partner",
        help=f"use `{channel}` in `main`, or remove its declaration",
    )


@mistake(
    "CSP654",
    "a process equation cannot be reached",
    explanation="A class starts with `main`; an equation that `main` does not lead to is never used.",
    example="class A\n  chan c\n  main = c -> main\n  other = c -> other\nend",
    repair="class A\n  chan c\n  main = c -> other\n  other = c -> other\nend",
)
def unreachable_equation(name: str, owner: str, span: Span) -> Diagnostic:
    """An equation that is never used."""
    return Diagnostic(
        "CSP654", f"`main` of `{owner}` never leads to `{name}`", span, Severity.WARNING, annotation="not used"
    )


def no_main(owner: str, names: Sequence[str], span: Span) -> Diagnostic:
    """Process equations without a start."""
    return Diagnostic(
        "CSP654",
        f"the class `{owner}` has process equations, but no `main`",
        span,
        help=meant(names) or "name the first equation `main`",
    )


@mistake(
    "CSP655",
    "inheritance runs in a circle",
    explanation="A class cannot inherit from itself, directly or by way of others.",
    example="class A\n  inherit B\n  main = STOP\nend\nclass B\n  inherit A\n  main = STOP\nend",
    repair="class A\n  main = STOP\nend\nclass B\n  inherit A\n  main = STOP\nend",
)
def cyclic_inheritance(names: Sequence[str], span: Span) -> Diagnostic:
    """Classes that inherit from each other."""
    return Diagnostic("CSP655", f"the inheritance runs in a circle: {' -> '.join(f'`{n}`' for n in names)}", span)


@mistake(
    "CSP656",
    "a class is not known",
    explanation="Inheritance, retrieve relations and obligations name classes of the script.",
    example="class A\n  inherit Bsae\n  main = STOP\nend\nclass Base\n  main = STOP\nend",
    repair="class A\n  inherit Base\n  main = STOP\nend\nclass Base\n  main = STOP\nend",
)
def unknown_class(name: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A name that is no class."""
    return Diagnostic("CSP656", f"`{name}` is no class of this script", span, help=meant(suggested))


@mistake(
    "CSP657",
    "an inherited declaration is declared differently",
    explanation="A subclass adds to what it inherits; what it declares again must have the same type.",
    example=_child("x : bool"),
    repair=_child("y : bool"),
)
def inherited_differently(name: str, parent: str, found: str, inherited: str, span: Span, other: Span) -> Diagnostic:
    """A variable, constant or channel with another type than in a parent."""
    return Diagnostic(
        "CSP657",
        f"`{name}` is of type `{found}` here and `{inherited}` in `{parent}`",
        span,
        labels=(Label(other, f"in `{parent}`"),),
    )


def inherited_with_another_meaning(name: str, span: Span, other: Span, where: tuple[str, str]) -> Diagnostic:
    """A name that stands for one thing in one class and for another in the other; *where*: the classes."""
    return Diagnostic(
        "CSP657",
        f"`{name}` of `{where[0]}` is something else in `{where[1]}`",
        span,
        annotation=f"here in `{where[0]}`",
        labels=(Label(other, f"here in `{where[1]}`"),),
        help="a class has one meaning for each name: rename one of them",
    )


@mistake(
    "CSP658",
    "a visibility list names what the class does not have",
    explanation="A visibility list names channels, methods, constants and state variables of the class.",
    example="class A\n  visible pushh\n  chan push\n  main = push -> main\nend",
    repair="class A\n  visible push\n  chan push\n  main = push -> main\nend",
)
def not_visible(name: str, owner: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A name in a visibility list that the class does not declare."""
    return Diagnostic("CSP658", f"the class `{owner}` has nothing called `{name}`", span, help=meant(suggested))


def rename_unknown(name: str, parent: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A renaming of something that the parent does not have."""
    return Diagnostic("CSP658", f"the class `{parent}` has nothing called `{name}`", span, help=meant(suggested))


@mistake(
    "CSP659",
    "an operation expression has no meaning",
    explanation=(
        "Operations are made of operations by `and`, `[]`, `;`, `||`, `\\ (k)`, `@` and their distributed forms. "
        "Each is unfolded to one schema, so an operation cannot be defined by itself, and a sequence cannot be "
        "distributed over a set that nobody knows."
    ),
    example=(
        "class C\n  chan c\n  main = c -> main\n  state\n    x : nat\n  op a\n    Delta(x)\n  where\n    x' = 1\n"
        "  op c = a ; c\nend"
    ),
    repair=(
        "class C\n  chan c\n  main = c -> main\n  state\n    x : nat\n  op a\n    Delta(x)\n  where\n    x' = 1\n"
        "  op c = a ; a\nend"
    ),
)
def operation_expression(span: Span) -> Diagnostic:
    """Something that is no expression over operations."""
    return Diagnostic("CSP659", "this is no operation", span)


def no_operation_of_object(name: str, owner: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """An operation that the class of an object does not offer."""
    return Diagnostic("CSP644", f"`{owner}` has no visible operation `{name}`", span, help=meant(suggested))


def objects_need_heap(what: str, span: Span) -> Diagnostic:
    """Objects that cannot be told apart by name for ever."""
    return Diagnostic("CSP659", f"{what} would need a heap, which is not supported", span)


def no_alternatives(what: str, span: Span) -> Diagnostic:
    """What polymorphic objects cannot be of."""
    return Diagnostic("CSP659", what, span)


def promotion(span: Span) -> Diagnostic:
    """The operation of something that is no object."""
    return Diagnostic("CSP659", "only an object has operations", span)


def distribution_not_known(span: Span) -> Diagnostic:
    """A sequence, or operands in parallel, over a set that the text does not show."""
    return Diagnostic(
        "CSP659",
        "how many operations these are is not known",
        span,
        help="`;` and `||` distribute over elements that are written out, as in `; x : <a, b> @ ...`",
    )


def changed_twice(name: str, span: Span) -> Diagnostic:
    """Objects of one family that two operations change, one of which says already what stays."""
    help_ = "let the choice or the sequence be the outermost operator: `(A and C) [] (B and C)` for `(A [] B) and C`"
    return Diagnostic("CSP659", f"both operands change `{name}`, one of them in a choice or sequence", span, help=help_)


def unknown_operation(name: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A name in an operation expression that is no operation of the class."""
    return Diagnostic("CSP644", f"`{name}` is no operation of the class", span, help=meant(suggested))


def operation_cycle(names: Sequence[str], span: Span) -> Diagnostic:
    """Operations that are defined by each other."""
    if len(set(names)) == 1:
        told = f"`{names[0]}` is defined by itself"
    else:
        told = f"operations are defined by each other: {', '.join(f'`{n}`' for n in names)}"
    help_ = "recursion has no finite unfolding; let `main` repeat the operation"
    return Diagnostic("CSP659", told, span, help=help_)


@mistake(
    "CSP660",
    "a finite reading is not one",
    explanation=(
        "`reading T = S` gives the finite set S of values that a search takes for T; for a given set or for "
        "collections a number of elements is enough."
    ),
    example="reading nat = {true}",
    repair="reading nat = 0..3",
)
def wrong_reading(text: str, expected: str, span: Span) -> Diagnostic:
    """A reading whose values are not of the type that is read."""
    return Diagnostic("CSP660", f"this is no reading of `{text}`", span, annotation=f"{expected} is needed")


def recursive_schema(name: str, span: Span) -> Diagnostic:
    """A schema or abbreviation that is declared by itself."""
    return Diagnostic("CSP655", f"`{name}` is declared by itself", span, help="use a free type for recursive data")
