"""What can be wrong with the form of classes and other Object-Z paragraphs: codes 601-629."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label, Severity, mistake
from cspcheck.cspm.parsing.lexing_messages import listed, quoted
from cspcheck.cspm.source import Span


@mistake(
    "CSP601",
    "something else was expected here, in a class or another paragraph",
    explanation="The text up to here begins something that this word or sign cannot continue. Each line of a "
    "predicate is a conjunct of its own; a line goes on where it ends with an operator, where the next one begins with "
    "one, and inside brackets.",
    example="class C\n  state\n    n : nat\n  where\n    n < = 3\nend",
    repair="class C\n  state\n    n : nat\n  where\n    n < 3\nend",
)
def unexpected(
    span: Span, found: str, wanted: Sequence[str], *, labels: tuple[Label, ...] = (), help: str | None = None
) -> Diagnostic:
    """The words *found* stand where one of *wanted* was due."""
    return Diagnostic(
        "CSP601",
        f"unexpected {found.removeprefix('the ')}",
        span,
        annotation=f"expected {listed(wanted)}" if wanted else "",
        labels=labels,
        help=help,
    )


@mistake(
    "CSP602",
    "a class, schema or retrieve relation is not closed",
    explanation="Classes, schemas, retrieve relations and global constants with axioms end with the word `end`, which "
    "stands no further to the right than the word that began them; an `end` that is indented further closes the "
    "section above it.",
    example="class C\n  chan a\n  main = a -> main\n\nassert C :[deadlock free]",
    repair="class C\n  chan a\n  main = a -> main\nend\n\nassert C :[deadlock free]",
)
def unclosed_block(span: Span, word: str, last_end: Span | None) -> Diagnostic:
    """The block that *word* begins has no ``end``; *last_end* is one that closed a section instead."""
    labels = () if last_end is None else (Label(last_end, "this one closes the section above it"),)
    return Diagnostic("CSP602", f"this `{word}` is never closed", span, labels=labels, help="close it with `end`")


@mistake(
    "CSP603",
    "a bracket in a predicate or declaration is not closed",
    explanation="Each bracket needs its counterpart: `(`...`)`, `{`...`}`, `<`...`>`, `(|`...`|)`, `[[`...`]]`, "
    "`[`...`]`.",
    example="class C\n  state\n    n : nat\n  where\n    (n < 3\nend",
    repair="class C\n  state\n    n : nat\n  where\n    (n < 3)\nend",
)
def unclosed_bracket(span: Span, closer: str, found: Span, found_words: str, *, compares: bool = False) -> Diagnostic:
    """The bracket at *span* is still open where *found* shows that it should be closed.

    *compares*: it is a `<` at the beginning of a line.
    """
    return Diagnostic(
        "CSP603",
        f"this `{span.text}` is never closed",
        span,
        labels=(Label(found, f"expected `{closer}` before {found_words}"),),
        help="at the beginning of a line `<` opens a sequence; to compare, put it at the end of the line before"
        if compares
        else f"close it with `{closer}`",
    )


@mistake(
    "CSP604",
    "a declaration was expected",
    explanation="A state, a schema and an operation begin with their declarations `x, y : T`, each on its own line or "
    "separated by `;`. Predicates stand behind the word `where`.",
    example="class C\n  state\n    n : nat\n    n < 3\nend",
    repair="class C\n  state\n    n : nat\n  where\n    n < 3\nend",
)
def no_declaration(span: Span, where_given: bool) -> Diagnostic:
    """A line among declarations that is none; *where_given*: the section has a ``where`` further on."""
    return Diagnostic(
        "CSP604",
        "this is no declaration",
        span,
        annotation="expected `name : type`",
        help="predicates stand behind `where`" if where_given else "write `where` before the predicates",
    )


@mistake(
    "CSP605",
    "a section of a class is given twice",
    explanation="A class has at most one state, one INIT, one visibility list. What a class inherits is joined with "
    "its own.",
    example="class C\n  state n : nat\n  state m : nat\nend",
    repair="class C\n  state\n    n : nat\n    m : nat\nend",
)
def section_twice(span: Span, name: str, first: Span) -> Diagnostic:
    """A second state, initial state or visibility list in one class."""
    return Diagnostic("CSP605", f"a second `{name}` in this class", span, labels=(Label(first, "the first one"),))


@mistake(
    "CSP606",
    "a word of the notation is used as a name",
    explanation="Operators that are words, such as `in`, `union` or `dom`, and the words `if`, `let`, `forall`, "
    "`where`, `end` and so on cannot be names of variables.",
    example="class C\n  state\n    union : nat\nend",
    repair="class C\n  state\n    sum : nat\nend",
)
def reserved_word(span: Span, word: str) -> Diagnostic:
    """A name was due, and a word of the notation stands there."""
    return Diagnostic("CSP606", f"`{word}` is a word of the notation", span, help="choose another name")


@mistake(
    "CSP607",
    "a name has more than one prime",
    explanation="`x` is the value of a state variable before an operation and `x'` its value behind it.",
    example="class C\n  state n : nat\n  method m\n  op m\n    Delta(n)\n  where\n    n'' = 1\nend",
    repair="class C\n  state n : nat\n  method m\n  op m\n    Delta(n)\n  where\n    n' = 1\nend",
)
def several_primes(span: Span) -> Diagnostic:
    """A name with several primes."""
    return Diagnostic("CSP607", "more than one prime", span, help="one prime means the value after the operation")


@mistake(
    "CSP608",
    "a section of a class is unknown",
    explanation="The sections of a class are `visible`, `inherit`, `chan`, `method`, `local_chan`, process equations, "
    "`given`, `const`, `schema`, free types, abbreviations, `state`, `init` and `op`.",
    example="class C\n  chann a\n  main = a -> main\nend",
    repair="class C\n  chan a\n  main = a -> main\nend",
)
def unknown_section(span: Span, word: str, suggestions: Sequence[str]) -> Diagnostic:
    """A line in a class begins with a word that begins nothing."""
    return Diagnostic(
        "CSP608",
        f"`{word}` begins no section of a class",
        span,
        help=f"did you mean {quoted(suggestions)}?" if suggestions else None,
    )


def schema_in_two_words(span: Span, word: str, name: str) -> Diagnostic:
    """``enable up`` or ``op enable up``, where one name was meant."""
    return Diagnostic("CSP608", f"`{word} {name}` is no schema of `{name}`", span, help=f"write `op {word}_{name}`")


@mistake(
    "CSP609",
    "parameters of a channel without brackets",
    explanation="A channel of a class lists its parameters with their names, because operations speak of them by name: "
    "`chan c : [x? : nat]`.",
    example="class C\n  chan a : nat\nend",
    repair="class C\n  chan a : [n : nat]\nend",
)
def parameters_without_brackets(span: Span, names: str) -> Diagnostic:
    """The type of a channel that does not begin with ``[``."""
    return Diagnostic(
        "CSP609", "the parameters of a channel stand in brackets", span, help=f"write `chan {names} : [x : T]`"
    )


@mistake(
    "CSP610",
    "a declaration that cannot stand in a class",
    explanation="Among the process equations of a class stand definitions only. Channels of a class are declared with "
    "`chan`, `method` or `local_chan`; everything else stands at the top of the script.",
    example="class C\n  channel a\n  main = a -> main\nend",
    repair="class C\n  chan a\n  main = a -> main\nend",
)
def not_in_class(span: Span, word: str) -> Diagnostic:
    """A declaration of CSPm, beginning with *word*, inside a class."""
    return Diagnostic(
        "CSP610",
        f"`{word}` cannot stand in a class",
        span,
        help="channels of a class are declared with `chan`" if word == "channel" else "move it out of the class",
    )


@mistake(
    "CSP611",
    "a Delta-list without brackets",
    explanation="The Delta-list of an operation names the state variables that it may change: `Delta(x, y)`. In a "
    "state the word `Delta` alone stands before the secondary variables.",
    example="class C\n  state n : nat\n  method m\n  op m\n    Delta n\n  where\n    n' = 1\nend",
    repair="class C\n  state n : nat\n  method m\n  op m\n    Delta(n)\n  where\n    n' = 1\nend",
)
def delta_without_brackets(span: Span) -> Diagnostic:
    """``Delta x`` in an operation."""
    return Diagnostic("CSP611", "the Delta-list stands in brackets", span, help="write `Delta(x, y)`")


@mistake(
    "CSP612",
    "text or a character in a predicate",
    explanation="Object-Z has no strings and characters; values without structure are elements of a given set or of a "
    "free type.",
    example="const x : nat where x = 'a' end",
    repair="LETTER ::= a | b\nconst x : LETTER where x = a end",
)
def literal(span: Span) -> Diagnostic:
    """A string or a character."""
    return Diagnostic(
        "CSP612", f"`{span.text}` has no meaning here", span, help="use a free type: `LETTER ::= a | b | c`"
    )


# --- LaTeX -------------------------------------------------------------------------------------------------------


@mistake(
    "CSP620",
    "markup that has a tidier form",
    explanation="The markup is read in all its dialects. What is warned of is no command of `oz.sty`, or has a form "
    "that says better what is meant.",
    example="In LaTeX: `f : \\mathbb{N} \\times \\nat`",
    repair="`f : \\nat \\cross \\nat`",
)
def untidy_markup(span: Span, written: str, tidy: str) -> Diagnostic:
    """The command or word *written* is read as *tidy*."""
    return Diagnostic(
        "CSP620",
        f"`{written}` is read as `{tidy}`",
        span,
        severity=Severity.WARNING,
        help=f"write `{tidy}`",
    )


@mistake(
    "CSP621",
    "Xi on an operation",
    explanation="Object-Z has no Xi on operations: what the Delta-list does not name does not change, and without a "
    "Delta-list nothing does.",
    example="In LaTeX: `\\begin{op}{read} \\Xi (n) \\\\ v! : \\nat \\where v! = n \\end{op}`",
    repair="`\\begin{op}{read} v! : \\nat \\where v! = n \\end{op}`",
)
def xi_list(span: Span) -> Diagnostic:
    """``\\Xi (x)`` in an operation; it is ignored."""
    return Diagnostic(
        "CSP621",
        "there is no `\\Xi` on operations",
        span,
        severity=Severity.WARNING,
        help="remove it: without a Delta-list nothing changes",
    )


@mistake(
    "CSP622",
    "an unknown command in the markup of a class",
    explanation="Between `\\begin{class}` and `\\end{class}` every command has a meaning; layout commands are skipped.",
    example="In LaTeX: `n \\lec 3`",
    repair="`n \\leq 3`",
)
def unknown_command(span: Span, suggestions: Sequence[str]) -> Diagnostic:
    """A command that stands for nothing."""
    return Diagnostic(
        "CSP622",
        f"unknown command `{span.text}`",
        span,
        help=f"did you mean {quoted(suggestions)}?" if suggestions else None,
    )


@mistake(
    "CSP623",
    "an environment in the markup is not closed, or closed by another",
    explanation="Each `\\begin{...}` needs its `\\end{...}`, innermost first.",
    example="In LaTeX: `\\begin{class}{C} \\begin{state} n : \\nat \\end{class}`",
    repair="`\\begin{class}{C} \\begin{state} n : \\nat \\end{state} \\end{class}`",
)
def environment_not_closed(span: Span, name: str, found: Span | None) -> Diagnostic:
    """The environment that begins at *span* is open where another one ends at *found*, or the text does."""
    labels = () if found is None else (Label(found, f"expected `\\end{{{name}}}` before this"),)
    return Diagnostic(
        "CSP623", f"`\\begin{{{name}}}` is never closed", span, labels=labels, help=f"add `\\end{{{name}}}`"
    )


@mistake(
    "CSP624",
    "an unknown environment in the markup of a class",
    explanation="The boxes of a class are `state`, `init`, `op`, `axdef`, `schema` and `zed`.",
    example="In LaTeX: `\\begin{class}{C} \\begin{stat} n : \\nat \\end{stat} \\end{class}`",
    repair="`\\begin{class}{C} \\begin{state} n : \\nat \\end{state} \\end{class}`",
)
def unknown_environment(span: Span, name: str, suggestions: Sequence[str]) -> Diagnostic:
    """An environment inside a class that is no box of it."""
    return Diagnostic(
        "CSP624",
        f"unknown environment `{name}`",
        span,
        help=f"did you mean {quoted(suggestions)}?" if suggestions else None,
    )


@mistake(
    "CSP625",
    "a part of Object-Z that is not read",
    explanation="References to objects as such have no meaning here: what an object is called is known where its class "
    "is used, not inside it.",
    example="In LaTeX: `\\begin{op}{show} s! : Shape \\where s! = \\self \\end{op}`",
    repair="Give each class its own channels and join them with `||`.",
)
def unsupported(span: Span, what: str) -> Diagnostic:
    """A command of the part of Object-Z *what* in words."""
    return Diagnostic("CSP625", f"{what} cannot be read: `{span.text}`", span)


@mistake(
    "CSP626",
    "a document without classes",
    explanation="A `.tex` file is read for its classes, schemas and other paragraphs, and for CSPm in `cspm` "
    "environments; the text around them is ignored.",
    example="A LaTeX file without `\\begin{class}`.",
    repair="Put the specification into the environments of `oz.sty`: `class`, `schema`, `axdef`, `zed`.",
)
def nothing_to_read(span: Span) -> Diagnostic:
    """A document that has no environment with something to read."""
    return Diagnostic("CSP626", "this document has no classes", span, severity=Severity.WARNING)
