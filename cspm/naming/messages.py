"""Mistakes with names: what is not defined, defined twice, hidden in a module, or out of place."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity, mistake
from cspcheck.cspm.source import Span


def _quoted(names: Sequence[str]) -> str:
    quoted = [f"`{name}`" for name in names]
    if len(quoted) <= 1:
        return "".join(quoted)
    return f"{', '.join(quoted[:-1])} or {quoted[-1]}"


def _labels(spans: Sequence[Span], message: str) -> tuple[Label, ...]:
    return tuple(Label(span, message) for span in spans)


@mistake(
    "CSP201",
    "a name is not defined",
    explanation="Every name must be declared in the script, in an enclosing `let` or by a pattern, or be built in.",
    example="channel start\nP = strat -> STOP",
    repair="channel start\nP = start -> STOP",
)
def undefined_name(name: str, span: Span, suggested: Sequence[str] = (), help_line: str | None = None) -> Diagnostic:
    """A name that is nowhere in scope."""
    if help_line is None and suggested:
        help_line = f"did you mean {_quoted(suggested)}?"
    return Diagnostic("CSP201", f"`{name}` is not defined", span, annotation="not in scope", help=help_line)


@mistake(
    "CSP202",
    "a name is defined twice",
    explanation=(
        "A script, a module or a `let` can define each name once. The clauses of a function must stand "
        "together and in one file."
    ),
    example="N = 3\nchannel N",
    repair="N = 3\nchannel n",
)
def defined_twice(name: str, spans: Sequence[Span], *, clauses: bool = False) -> Diagnostic:
    """The same name declared several times in one scope; *spans* in order, the first is the original."""
    return Diagnostic(
        "CSP202",
        f"`{name}` is defined {'twice' if len(spans) == 2 else f'{len(spans)} times'}",
        spans[1],
        annotation="defined again here",
        labels=(Label(spans[0], "first defined here"), *_labels(spans[2:], "and here")),
        help="put the clauses of a function next to each other" if clauses else "rename one of them",
    )


@mistake(
    "CSP203",
    "a variable is bound twice",
    explanation="A pattern, a parameter list or a prefix can bind each variable once; to compare two parts, use `==`.",
    example="f(x, x) = x",
    repair="f(x, y) = if x == y then x else 0",
)
def bound_twice(name: str, first: Span, second: Span, where: str) -> Diagnostic:
    """The same variable twice in one pattern, parameter list or prefix (*where*)."""
    return Diagnostic(
        "CSP203",
        f"`{name}` is bound twice in one {where}",
        second,
        annotation="bound again here",
        labels=(Label(first, "first bound here"),),
        help="rename one of them and compare the two with `==`",
    )


@mistake(
    "CSP204",
    "a name is private to its module",
    explanation="Outside a module only what stands behind its `exports` can be used.",
    example="module M\nsecret = 1\nexports\nopen = 2\nendmodule\nx = M::secret",
    repair="module M\nexports\nsecret = 1\nopen = 2\nendmodule\nx = M::secret",
)
def private_name(name: str, module: str, span: Span, declared: Span | None) -> Diagnostic:
    """A member of a module that it does not export."""
    return Diagnostic(
        "CSP204",
        f"`{name}` is private to module `{module}`",
        span,
        annotation="not exported",
        labels=() if declared is None else (Label(declared, "declared privately here"),),
        help=f"declared privately in module `{module}`: move it behind `exports`",
    )


@mistake(
    "CSP205",
    "a module with parameters is used without an instance",
    explanation="What a module with parameters declares exists only in its instances.",
    example="module M(n)\nexports\nx = n\nendmodule\ny = M::x",
    repair="module M(n)\nexports\nx = n\nendmodule\ninstance I = M(3)\ny = I::x",
)
def needs_instance(name: str, module: str, span: Span) -> Diagnostic:
    """A member of a module with parameters reached through the module itself."""
    return Diagnostic(
        "CSP205",
        f"`{name}` is inside the parameterised module `{module}`",
        span,
        help=f"create an instance, `instance I = {module}(...)`, and use `I::{name}`",
    )


@mistake(
    "CSP206",
    "a module is used as a value",
    explanation="The name of a module or an instance can only stand in front of `::`.",
    example="module M\nexports\nx = 1\nendmodule\ny = M",
    repair="module M\nexports\nx = 1\nendmodule\ny = M::x",
)
def module_is_no_value(name: str, span: Span, members: Sequence[str], *, instance: bool) -> Diagnostic:
    """A module or an instance where an expression is needed."""
    some = sorted(members)[:3]
    return Diagnostic(
        "CSP206",
        f"`{name}` is {'an instance of a module' if instance else 'a module'}, not a value",
        span,
        help=f"name one of its members, such as {_quoted([f'{name}::{m}' for m in some])}" if some else None,
    )


@mistake(
    "CSP207",
    "an unknown function is imported",
    explanation="`transparent` and `external` import functions of the checker, whose names are fixed.",
    example="transparent sbisimm",
    repair="transparent sbisim",
)
def unknown_import(name: str, kind: str, span: Span, suggested: Sequence[str], other: str | None) -> Diagnostic:
    """An import that names no such function; *other* is the kind under which it does exist."""
    if other is not None:
        return Diagnostic(
            "CSP207",
            f"`{name}` is not a {kind} function" if kind == "transparent" else f"`{name}` is not an {kind} function",
            span,
            help=f"import it with `{other} {name}`",
        )
    return Diagnostic(
        "CSP207",
        f"there is no {kind} function `{name}`",
        span,
        help=f"did you mean {_quoted(suggested)}?" if suggested else None,
    )


@mistake(
    "CSP208",
    "a qualified name in a pattern is not a constructor or a channel",
    explanation="A pattern binds plain variables; `M::x` can stand in it only for a constructor or a channel.",
    example="module M\nexports\nx = 1\nendmodule\nf(M::x) = 0",
    repair="f(x) = 0",
)
def qualified_variable(name: str, span: Span) -> Diagnostic:
    """``M::x`` in a pattern where ``x`` is neither a constructor nor a channel."""
    return Diagnostic(
        "CSP208",
        f"`{name}` in a pattern is not a constructor or a channel",
        span,
        help="use a plain variable and compare it with `==`",
    )


@mistake(
    "CSP211",
    "an internal choice of fields behind an input or output",
    explanation="In a prefix every `$` must come before any `?` and `!`.",
    example="channel c : {0..1}.{0..1}\nP = c?x$y -> STOP",
    repair="channel c : {0..1}.{0..1}\nP = |~| y : {0..1} @ c?x!y -> STOP",
)
def dollar_after_input(span: Span, before: Span) -> Diagnostic:
    """A ``$`` field that follows a ``?`` or ``!`` field."""
    return Diagnostic(
        "CSP211",
        "`$` must come before every `?` and `!` of its prefix",
        span,
        labels=(Label(before, "this field comes first"),),
        help="choose the value in front: `|~| y : S @ c?x!y -> P`",
    )


@mistake(
    "CSP212",
    "an instance of something that is no module",
    explanation="`instance I = M(...)` needs the name of a module.",
    example="M = 3\ninstance I = M",
    repair="module M\nexports\nx = 3\nendmodule\ninstance I = M",
)
def not_a_module(name: str, span: Span) -> Diagnostic:
    """An instance declaration whose right side is not a module."""
    return Diagnostic("CSP212", f"`{name}` is not a module", span, help="only modules can be instantiated")


@mistake(
    "CSP213",
    "a module instantiates itself",
    explanation="Instances of a module inside itself, directly or by way of other modules, would never end.",
    example="module M\ninstance I = M\nexports\nx = 1\nendmodule",
    repair="module M\nexports\nx = 1\nendmodule\ninstance I = M",
)
def module_cycle(path: Sequence[str], span: Span) -> Diagnostic:
    """*path* are the modules on the cycle, the first one again at the end."""
    return Diagnostic(
        "CSP213",
        f"module `{path[0]}` contains an instance of itself",
        span,
        notes=(f"the cycle is {' -> '.join(path)}",) if len(path) > 2 else (),
        help="move the instance out of the module",
    )


@mistake(
    "CSP214",
    "a module is instantiated with the wrong number of arguments",
    explanation="An instance needs one argument for each parameter of its module.",
    example="module M(n)\nexports\nx = n\nendmodule\ninstance I = M(1, 2)",
    repair="module M(n)\nexports\nx = n\nendmodule\ninstance I = M(1)",
)
def module_argument_count(name: str, expected: int, given: int, span: Span, declared: Span | None) -> Diagnostic:
    """An instance with too many or too few arguments."""
    return Diagnostic(
        "CSP214",
        f"module `{name}` takes {expected} argument{'' if expected == 1 else 's'}, {given} given",
        span,
        labels=() if declared is None else (Label(declared, "declared here"),),
    )


@mistake(
    "CSP215",
    "a Timed section without `tock`",
    explanation="Timed sections measure time in `tock` events: a channel without data of that name must be in scope.",
    example="channel a\nTimed {\nP = a -> P\n}",
    repair="channel a, tock\nTimed {\nP = a -> P\n}",
)
def no_tock(span: Span, declared: Span | None) -> Diagnostic:
    """A Timed section where ``tock`` is not in scope, or (*declared*) is something else."""
    if declared is None:
        return Diagnostic("CSP215", "a Timed section needs the channel `tock`", span, help="declare `channel tock`")
    return Diagnostic(
        "CSP215",
        "`tock` must be a channel without data in a Timed section",
        span,
        labels=(Label(declared, "declared here"),),
        help="declare `channel tock`",
    )


@mistake(
    "CSP216",
    "a subtype names something that is no constructor",
    explanation="A subtype lists constructors of one datatype that is declared elsewhere.",
    example="datatype T = A | B\nsubtype S = A | C",
    repair="datatype T = A | B\nsubtype S = A",
)
def not_a_constructor(name: str, subtype: str, span: Span, suggested: Sequence[str]) -> Diagnostic:
    """A name in a subtype that is not a datatype's constructor."""
    return Diagnostic(
        "CSP216",
        f"`{name}` in subtype `{subtype}` is not a constructor of a datatype",
        span,
        help=f"did you mean {_quoted(suggested)}?" if suggested else "declare it in a datatype first",
    )


@mistake(
    "CSP217",
    "the clauses of a function differ in their parameters",
    explanation="All clauses of a function take the same number of arguments.",
    example="f(0) = 1\nf(x, y) = x",
    repair="f(0, y) = 1\nf(x, y) = x",
)
def clauses_differ(name: str, span: Span, first: Span, expected: str, given: str) -> Diagnostic:
    """A clause whose parameter lists differ in number from those of the first one."""
    return Diagnostic(
        "CSP217",
        f"this clause of `{name}` takes {given}, the first one {expected}",
        span,
        labels=(Label(first, "the first clause"),),
    )


@mistake(
    "CSP218",
    "a form that a Timed section cannot contain",
    explanation="Linked parallel and `$` fields have no timed meaning.",
    example="channel a, tock\nTimed {\nP = STOP [a <-> a] STOP\n}",
    repair="channel a, tock\nP = STOP [a <-> a] STOP",
)
def not_in_timed_section(what: str, span: Span) -> Diagnostic:
    """A linked parallel or ``$`` inside a Timed section."""
    return Diagnostic("CSP218", f"{what} cannot be used in a Timed section", span, help="move it out of the section")


@mistake(
    "CSP219",
    "a double pattern in the field of a prefix",
    explanation="`p @@ q` cannot stand in the fields of a prefix.",
    example="channel c : {0..1}.{0..1}\nP = c?(x @@ 1)?y -> STOP",
    repair="channel c : {0..1}.{0..1}\nP = c?x:{1}?y -> STOP",
)
def double_pattern_in_prefix(span: Span) -> Diagnostic:
    """``@@`` in a field of a prefix."""
    return Diagnostic(
        "CSP219",
        "`@@` cannot be used in the fields of a prefix",
        span,
        help="bind the whole field, and restrict it by a set: `?x:S`",
    )


@mistake(
    "CSP220",
    "an override names no constant of the script",
    explanation="`-D NAME=EXPR` replaces the expression of a top-level definition `NAME = ...` of the script.",
    example="N = 3",
    repair="Give `-D N=5`, not `-D M=5`.",
)
def unknown_override(name: str, suggested: Sequence[str], *, defined: Span | None) -> Diagnostic:
    """An override of a name that the script does not define, or (*defined*) not as a constant."""
    if defined is not None:
        return Diagnostic(
            "CSP220",
            f"`{name}` cannot be overridden: it is not a constant",
            defined,
            help="only definitions of the form `NAME = ...` at the top of a script can be overridden",
        )
    return Diagnostic(
        "CSP220",
        f"`{name}` cannot be overridden: the script does not define it",
        help=f"did you mean {_quoted(suggested)}?" if suggested else None,
    )


@mistake(
    "CSP221",
    "an input that can match no event of its channel",
    explanation="The pattern of the input is for no value that the channel declares for the field, so the prefix "
    "never offers anything. It is allowed, as a process that does nothing; mostly the channel's set or the pattern is "
    "wrong.",
    example="channel c : {0..3}\nP = c?5 -> STOP",
    repair="channel c : {0..3}\nP = c?3 -> STOP",
)
def input_matches_nothing(span: Span, pattern: str, channel: str, expected: object) -> Diagnostic:
    """An input whose *pattern* is for none of the values in *expected*, the set of the channel's field."""
    return Diagnostic(
        "CSP221",
        f"this input of `{channel}` offers nothing: no value of its field is like `{pattern}`",
        span,
        Severity.WARNING,
        annotation=f"matches nothing in {expected!r}",
    )


@mistake(
    "CSP222",
    "a function imported twice",
    explanation="`transparent` and `external` declare the names that they import, and a scope declares a name once. "
    "What is imported at the top of a script can be used everywhere in it.",
    example="transparent normal, normal",
    repair="transparent normal",
)
def imported_twice(name: str, first: Span, second: Span) -> Diagnostic:
    """The same function imported again in one scope."""
    return Diagnostic(
        "CSP222",
        f"`{name}` is imported twice",
        second,
        annotation="imported again here",
        labels=(Label(first, "first imported here"),),
        help="leave one of the two out",
    )


@mistake(
    "CSP223",
    "a parameter of a module is defined again in it",
    explanation="The definition would hide the argument of every instance.",
    example="module M(n)\nn = 0\nexports\nP = STOP\nendmodule\ninstance I = M(1)",
    repair="module M(n)\nm = 0\nexports\nP = STOP\nendmodule\ninstance I = M(1)",
)
def parameter_redefined(name: str, module: str, parameter: Span, again: Span) -> Diagnostic:
    """A declaration inside a module that has the name of a parameter."""
    return Diagnostic(
        "CSP223",
        f"`{name}` is a parameter of `{module}` and is defined in it again",
        again,
        labels=(Label(parameter, "the parameter"),),
        help="rename one of them",
    )


@mistake(
    "CSP224",
    "an import that has another name today",
    explanation="`normalise` is what FDR2 called `normal`. It works here; FDR4 refuses it.",
    example="transparent normalise\nP = normalise(STOP)",
    repair="transparent normal\nP = normal(STOP)",
)
def deprecated_import(name: str, instead: str, span: Span) -> Diagnostic:
    """An import by a name that FDR4 no longer has."""
    return Diagnostic(
        "CSP224",
        f"`{name}` is called `{instead}` today",
        span,
        Severity.WARNING,
        help=f"import and use `{instead}`: FDR4 refuses `{name}`",
    )


@mistake(
    "CSP225",
    "symmetry is not used",
    explanation="`:[symmetry reduce]:` asks for a smaller search where processes and values of a type play the same "
    "part. The verdict does not depend on it: the whole state space is searched, with the reductions that are sound "
    "for every process.",
    example="channel a\nP = a -> P\nassert P :[deadlock free] :[symmetry reduce]:",
    repair="channel a\nP = a -> P\nassert P :[deadlock free]",
)
def symmetry_not_used(span: Span) -> Diagnostic:
    """The option of an assertion that asks for a reduction by symmetry."""
    return Diagnostic("CSP225", "symmetry is not used in this check", span, Severity.WARNING, annotation="ignored")
