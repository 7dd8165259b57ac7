"""What inference says of a script: schemes on request, mistakes word for word, and no more than it has to."""

from __future__ import annotations

import time

import pytest

from cspcheck.cspm.diagnostics import MISTAKES, Diagnostic, ScriptError, Severity
from cspcheck.cspm.naming import resolve as names
from cspcheck.cspm.parsing import reading as parser
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.inference import Types, infer, infer_assertion, infer_expression
from cspcheck.cspm.typing.types import INT, PROC, resolve, show


def typed(text: str) -> Types:
    script = parser.parse(Source("s.csp", text))
    return infer(script, names.resolve(script))


def mistakes(text: str) -> tuple[Diagnostic, ...]:
    with pytest.raises(ScriptError) as raised:
        typed(text)
    return raised.value.diagnostics


def told(text: str) -> list[str]:
    """The one mistake of a script, line by line: place, message, caret, labels, notes, help."""
    (diagnostic,) = mistakes(text)
    assert diagnostic.span is not None
    lines = [f"{diagnostic.code} {diagnostic.span.line}:{diagnostic.span.column} {diagnostic.message}"]
    lines.append(f"{diagnostic.span.text}  {diagnostic.annotation}".rstrip())
    lines += [f"label {label.span.text.splitlines()[0]}: {label.message}" for label in diagnostic.labels]
    lines += [f"note {note}" for note in diagnostic.notes]
    if diagnostic.help:
        lines.append(f"help {diagnostic.help}")
    return lines


# --- what is told of a good script ------------------------------------------------------------------------------


def test_the_listing_has_the_top_level_in_the_order_of_the_script() -> None:
    types = typed(
        "P = Q\nchannel a, b : {0..1}\nQ = a?x -> b!x -> P\ndatatype T = A.{0} | B\nmap(f, s) = <f(x) | x <- s>"
    )
    assert list(types.listing()) == [
        ("P", "Proc"),
        ("a", "Int => Event"),
        ("b", "Int => Event"),
        ("Q", "Proc"),
        ("T", "{T}"),
        ("A", "Int => T"),
        ("B", "T"),
        ("map", "((a) -> b, <a>) -> <b>"),
    ]


def test_the_type_of_an_expression_can_be_asked_for() -> None:
    script = parser.parse(Source("s.csp", "channel c : {0..1}\nP(n) = if n > 0 then c!n -> P(n - 1) else STOP"))
    types = infer(script, names.resolve(script))
    definition = script.declarations[1]
    assert isinstance(definition, syntax.FunctionDefinition)
    body = definition.clauses[0].body
    assert isinstance(body, syntax.If)
    assert resolve(types.type_of(body)) is PROC
    assert isinstance(body.condition, syntax.Binary)
    assert resolve(types.type_of(body.condition.left)) is INT
    with pytest.raises(KeyError):
        types.type_of(syntax.Name(span=body.span, parts=("n",)))


def test_an_expression_behind_a_script_is_inferred_against_it() -> None:
    types = typed("channel c : {0..1}.Bool\nid(x) = x\ndatatype T = A.{0..1}")

    def scheme(text: str) -> str:
        node = parser.parse_expression(text)
        names.resolve_more(types.names, node)
        return str(infer_expression(node, types))

    assert scheme("id(c.0)") == "Bool => Event"
    assert scheme("\\ x, y @ id(x) == y") == "Eq a => (a, a) -> Bool"
    assert scheme("{A.x | c.x._ <- Events}") == "{T}"
    assert scheme("{}") == "Set a => {a}"
    for wrong in ("c.true", "id(1, 2)", "<1, true>", "#<c.0.1>", "A.1 == c.1.true"):
        with pytest.raises(ScriptError):
            scheme(wrong)


def test_an_assertion_behind_a_script_is_held_against_it() -> None:
    types = typed("channel a\nP = a -> P")

    def check(text: str) -> None:
        node = parser.parse_assertion(text)
        names.resolve_more(types.names, node)
        infer_assertion(node, types)

    check("P [T= STOP")
    check("P :[has trace]: <a>")
    for wrong in ("a [T= P", "P :[has trace]: {a}", "P [F= P :[tau priority]: <a>"):
        with pytest.raises(ScriptError):
            check(wrong)


def test_the_type_of_a_datatype_is_its_name() -> None:
    script = parser.parse(Source("s.csp", "module M\nexports\ndatatype T = A\nendmodule\nx = M::A"))
    tied = names.resolve(script)
    types = infer(script, tied)
    assert dict(types.listing()) == {"x": "M::T"}
    member = tied.top_level["M"].members["T"]
    assert show(types.datatype(member)) == ("M::T",)
    assert types.datatype(member).comparable is True


def test_the_members_of_an_instance_are_seen_with_its_types() -> None:
    types = typed(
        "module M(S)\nexports\ndatatype T = A.S | B\nf(A.x) = x\nendmodule\n"
        "instance I = M({0..1})\ninstance J = M(Bool)\nx = I::f\ny = J::f\nz = (I::B, J::A)"
    )
    assert dict(types.listing()) == {"x": "(I::T) -> Int", "y": "(J::T) -> Bool", "z": "(I::T, Bool => J::T)"}


def test_deprecated_names_are_warned_of() -> None:
    types = typed("b = True or False")
    assert [(w.severity, w.code, w.message, w.help) for w in types.warnings] == [
        (Severity.WARNING, "CSP317", "`True` is deprecated", "write `true`"),
        (Severity.WARNING, "CSP317", "`False` is deprecated", "write `false`"),
    ]
    assert typed("True = 3\nx = True").warnings == ()


# --- mistakes, word for word ------------------------------------------------------------------------------------


def test_a_mismatch() -> None:
    assert told("channel a\nP = a -> STOP\nQ = P [] a") == [
        "CSP301 3:10 expected type `Proc`, found `Event`",
        "a  the right operand of `[]` has type `Event`",
        "help an event is not a process: write `e -> P`",
    ]


def test_a_mismatch_inside_larger_types_names_the_parts() -> None:
    assert told("f(x) = <(x + 1, true)> == <(2, 'c')>") == [
        "CSP301 1:27 expected type `<(Int, Bool)>`, found `<(Int, Char)>`",
        "<(2, 'c')>  the right operand of `==` has type `<(Int, Char)>`",
        "label <(x + 1, true)>: the left operand has type `<(Int, Bool)>`",
        "note `Char` is not `Bool`",
        "note while matching `(Int, Char)` with `(Int, Bool)`",
        "note while matching `<(Int, Char)>` with `<(Int, Bool)>`",
    ]


def test_a_mismatch_of_an_argument_points_to_the_function() -> None:
    assert told("f(x, s) = x + #s\ny = f(1, {2})") == [
        "CSP301 2:10 expected type `<a>`, found `{Int}`",
        "{2}  the second argument of `f` has type `{Int}`",
        "label f(x, s) = x + #s: `f` is defined here",
        "help convert the set with `seq(...)`",
    ]


def test_a_local_function_used_at_two_types() -> None:
    assert told("f = let id(x) = x within (id(0), id(true))") == [
        "CSP301 1:37 expected type `Int`, found `Bool`",
        "true  the argument of `id` has type `Bool`",
        "label id(x) = x: `id` is defined here",
        "help without an annotation the local `id` has one type in all its uses",
    ]
    assert told("f = let inc(x) = x + 1 within inc(true)")[-1] == "label inc(x) = x + 1: `inc` is defined here"


def test_a_mismatch_of_branches_points_to_the_first() -> None:
    assert told("f(b) = if b then 1 else 'c'") == [
        "CSP301 1:25 expected type `Int`, found `Char`",
        "'c'  the `else` branch has type `Char`",
        "label 1: the `then` branch has type `Int`",
    ]


def test_an_infinite_type() -> None:
    assert told("g(x) = if x == <x> then 1 else 2") == [
        "CSP302 1:16 this needs an infinite type: `a` would be `<a>`",
        "<x>  in the right operand of `==`",
        "label x: the left operand has type `a`",
    ]


def test_processes_have_no_equality() -> None:
    assert told("s = {<STOP>} == {}") == [
        "CSP303 1:5 `{<Proc>}` has no equality (Eq)",
        "{<STOP>} == {}  needed for `==`",
        "note `Proc` has no equality (Eq)",
        "note `<Proc>` needs it of `Proc`",
        "note `{<Proc>}` needs it of `<Proc>`",
        "help processes cannot be compared; compare them in an assertion, with `[T=`, `[F=` or `[FD=`",
    ]


def test_a_datatype_without_equality_says_which_constructor_is_to_blame() -> None:
    assert told("datatype T = A.Proc | B\nx = B == B") == [
        "CSP303 2:5 `T` has no equality (Eq)",
        "B == B  needed for `==`",
        "help the constructor `A` carries a `Proc`, which has none",
    ]


def test_booleans_have_no_order() -> None:
    assert told("x = true < false") == [
        "CSP303 1:5 `Bool` has no order (Ord)",
        "true < false  needed for `<`",
        "help integers, characters, sequences, sets, and tuples and maps of these can be ordered",
    ]


def test_an_argument_too_few() -> None:
    assert told("f(x, y) = x + y\nn = f(1)") == [
        "CSP304 2:5 `f` takes 2 arguments, 1 given",
        "f(1)",
        "label f(x, y) = x + y: `f` is defined here",
        "note `f` has type `(Int, Int) -> Int`",
    ]


def test_a_channel_is_no_function() -> None:
    assert told("channel c : {0..1}\nP = c(1) -> STOP") == [
        "CSP305 2:5 `c` is not a function",
        "c  type `Int => Event`",
        "help write the fields of a channel or constructor behind dots, as in `c.x`",
    ]


def test_a_field_too_many() -> None:
    assert told("channel c : {0..1}\nP = c?x!x -> STOP") == [
        "CSP306 2:5 `c` takes 1 field, 2 given",
        "c?x!x",
        "note the fields are `Int`",
    ]


def test_a_field_too_few() -> None:
    assert told("channel c : {0..1}.Bool\nP = c.1 -> STOP") == [
        "CSP307 2:5 1 field missing: this needs `.Bool` to become `Event`",
        "c.1  in the event of the prefix",
        "help give it its fields, as in `c.x`, `c!x` or `c?x`",
    ]


def test_a_dot_behind_an_operator() -> None:
    assert told("datatype T = A.{0..1} | B\nx = B == A.1") == [
        "CSP307 2:10 1 field missing: this needs `.Int` to become `T`",
        "A  in the right operand of `==`",
        "label B: the left operand has type `T`",
        "help `.` binds more loosely than any operator on values: put brackets around the dotted value",
    ]


def test_channels_in_plain_braces() -> None:
    assert told("channel c : {0..1}.Bool\nP = STOP \\ {c}") == [
        "CSP307 2:12 2 fields missing: this needs `.Int.Bool` to become `Event`",
        "{c}  in the set of `\\`",
        "help write `{| ... |}` for all events of a channel",
    ]


def test_an_ambiguous_channel() -> None:
    assert told("channel c : {0..1}.{}.Bool") == [
        "CSP308 1:9 the type of channel `c` is ambiguous: field 2 could be of any type",
        "c  type `Int => a => Bool => Event`",
        "help constrain field 2 with an annotation, such as `c :: ... => Int => ... => Event`",
    ]


def test_an_ambiguous_channel_of_an_instance() -> None:
    assert told("module M(X)\nexports\nchannel c : X\nendmodule\ninstance I = M({})") == [
        "CSP308 3:9 the type of channel `I::c` is ambiguous: its field could be of any type",
        "c  type `a => Event`",
        "label instance I = M({}): in this instance of `M`",
        "help give the instance an argument whose type is definite",
    ]


def test_a_subtype_with_too_many_fields() -> None:
    assert told("datatype T = A.{0..3}\nsubtype S = A.{0}.{1}") == [
        "CSP309 2:13 `A` has 1 field, the subtype gives it 2",
        "A.{0}.{1}",
        "label A.{0..3}: declared here",
    ]


def test_a_subtype_of_two_datatypes() -> None:
    assert told("datatype T = A\ndatatype U = B\nsubtype S = A | B") == [
        "CSP310 3:17 `B` is a constructor of `U`, the subtype is one of `T`",
        "B",
        "label B: declared here",
    ]


def test_an_annotation_that_is_too_general() -> None:
    assert told("f :: (a) -> a\nf(x) = x + 1") == [
        "CSP311 2:8 the annotation allows any type for `a`, but here it must be `Int`",
        "x  in the left operand of `+`",
        "label f :: (a) -> a: `a` is a variable of this annotation",
        "help write `Int` in place of `a` in the annotation",
    ]


def test_a_set_used_as_a_type() -> None:
    assert told("nametype Small = {0..3}\nf :: (Small) -> Int\nf(x) = x + 1") == [
        "CSP311 3:8 the annotation allows any type for `Small`, but here it must be `Int`",
        "x  in the left operand of `+`",
        "label f :: (Small) -> Int: `Small` is a variable of this annotation",
        "help `Small` names no type, so it stands for any; write the type of the elements of a set",
    ]


def test_a_dot_pattern_against_an_event() -> None:
    assert told("channel c : {0..1}\nsecond(x.y) = y\nn = second(c.1)") == [
        "CSP312 3:12 a value of type `Event` cannot be split by a pattern of type `a.b`",
        "c.1  the argument of `second` has type `Event`",
        "label second(x.y) = y: `second` is defined here",
        "help name the channel or constructor in the pattern, as in `c.x`",
    ]


def test_a_generator_over_the_wrong_collection() -> None:
    assert told("s = {x | x <- <1, 2>}") == [
        "CSP313 1:15 a set comprehension ranges over sets, this is a sequence",
        "<1, 2>  type `<Int>`",
        "help convert it with `set(...)`",
    ]
    assert told("P = ; x : {1, 2} @ SKIP") == [
        "CSP313 1:11 the replicated `;` ranges over sequences, this is a set",
        "{1, 2}  type `{Int}`",
        "help convert it with `seq(...)`",
    ]


def test_a_module_that_uses_its_own_instance() -> None:
    text = "module M(n)\nexports\nx = helper(n)\nendmodule\nhelper(n) = I::x + n\ninstance I = M(1)"
    assert told(text) == [
        "CSP314 6:1 module `M` uses its own instance `I`",
        "instance I = M(1)",
        "label x = helper(n): it is used from here",
        "note the path is `M::x` -> `helper` -> `I`",
    ]


def test_a_constraint_on_nothing() -> None:
    assert told("f :: Eq b => (a) -> Bool\nf(x) = true") == [
        "CSP315 1:6 `b` is not a variable of the annotated type",
        "Eq b",
    ]


def test_an_annotation_without_a_constraint_that_is_needed() -> None:
    assert told("same :: (a, a) -> Bool\nsame(x, y) = x == y") == [
        "CSP316 2:14 the annotation does not give `a` the constraint `Eq`",
        "x == y  needed for `==`",
        "label same :: (a, a) -> Bool: `a` is a variable of this annotation",
        "help put `Eq a =>` in front of the annotated type",
    ]


def test_a_field_of_the_wrong_type() -> None:
    assert told("datatype T = K.{0..1} | L\nchannel c : T.Bool\nP = c!K.true!false -> STOP") == [
        "CSP318 3:9 field 1 of `K` has type `Int`, found `Bool`",
        "true  this has type `Bool`",
    ]


def test_a_type_too_large_to_be_written() -> None:
    lines = [f"f{i}(x) = f{i + 1}((x, x))" for i in range(20)]
    assert told("\n".join([*lines, "f20(x) = x"])) == [
        "CSP319 7:1 the type of `f6` is too large",
        "f6(x) = f7((x, x))",
        "help use sequences or datatypes in place of tuples",
    ]


def test_open_fields_that_must_be_definite() -> None:
    assert told("start :: (a =>* Event) -> Proc\nstart(x) = x -> STOP") == [
        "CSP320 2:12 the annotation allows any fields for `a`, but here there must be none",
        "x  in the event of the prefix",
        "label start :: (a =>* Event) -> Proc: `a` is a variable of this annotation",
        "help write the fields with `=>`, or leave them out",
    ]
    assert told("one :: (a =>* Event) -> Proc\none(x) = x!1 -> STOP")[0] == (
        "CSP320 2:10 the annotation allows any fields for `a`, but here these must be `Int`"
    )


def test_a_local_type_too_large_to_be_looked_through() -> None:
    local = "\n".join(["f(x) = let", *(f"  a{i + 1} = (a{i}, a{i})" for i in range(30)), "  a0 = (1, 2)"])
    assert told(f"{local}\n  within a30 == a30") == [
        "CSP319 33:10 the type of this is too large",
        "a30 == a30",
        "help use sequences or datatypes in place of tuples",
    ]


# --- how much is told -------------------------------------------------------------------------------------------


def test_every_group_has_its_own_mistake_and_what_depends_on_it_is_left_alone() -> None:
    found = mistakes("x = 1 + true\ny = x and x\nz = #y\nassert y [T= z\nf(0) = not 1\ng = f(f)\nh = -'c'")
    assert [d.span.line for d in found if d.span is not None] == [1, 5, 7]


def test_mistakes_come_in_the_order_of_the_script_and_end_at_twenty() -> None:
    found = mistakes("\n".join(f"x{i} = not {i}" for i in range(50)))
    assert [d.span.line for d in found if d.span is not None] == list(range(1, 21))


def test_a_mistake_in_an_annotated_definition_leaves_its_users_alone() -> None:
    (only,) = mistakes("f :: (Int) -> Bool\nf(x) = x\ny = f(1) and f(2)")
    assert only.span is not None
    assert only.span.line == 2


def test_a_use_of_an_annotated_definition_is_checked_though_its_body_is_wrong() -> None:
    found = mistakes("f :: (Int) -> Bool\nf(x) = x\ny = f(true)")
    assert [d.span.line for d in found if d.span is not None] == [2, 3]


@pytest.mark.parametrize("code", sorted(code for code in MISTAKES if code.startswith("CSP3")))
def test_what_the_documentation_says_of_a_mistake_is_true(code: str) -> None:
    mistake = MISTAKES[code]
    try:
        found = [warning.code for warning in typed(mistake.example).warnings]
    except ScriptError as error:
        found = [diagnostic.code for diagnostic in error.diagnostics]
    assert code in found
    assert typed(mistake.repair).warnings == ()


def test_all_builders_of_this_phase_are_registered() -> None:
    assert messages.__doc__
    codes = [code for code in MISTAKES if code.startswith("CSP3")]
    assert codes == [f"CSP{number}" for number in range(301, 301 + len(codes))]


# --- size and depth ---------------------------------------------------------------------------------------------

DEEP = 10_000


@pytest.mark.parametrize(
    "text",
    [
        "x = " + "(" * DEEP + "1" + ")" * DEEP,
        "x = " + "+".join(["1"] * DEEP),
        "channel a\nP = " + "a -> " * DEEP + "STOP",
        "P = " + " [] ".join(["STOP"] * DEEP),
        "x = " + "if true then 1 else " * DEEP + "2",
        "f(x) = x\ny = " + "f(" * DEEP + "1" + ")" * DEEP,
        "x = " + "<" * 5_000 + ">" * 5_000,
        "x = " + ".".join(["1"] * 5_000),
        "x = " + "let y = 1 within " * 5_000 + "y",
        "\n".join([*(f"f{i}(x) = f{i + 1}(x)" for i in range(2_000)), "f2000(x) = x + 1"]),
    ],
    ids=["brackets", "sum", "prefixes", "choices", "conditionals", "calls", "sequences", "dots", "lets", "definitions"],
)
def test_deep_scripts_are_inferred(text: str) -> None:
    typed(text)


def test_a_deep_mistake_is_told() -> None:
    (diagnostic,) = mistakes("f(x) = x + 1\ny = " + "f(" * 2_000 + "true" + ")" * 2_000)
    assert diagnostic.code == "CSP301"


UNIT = """
channel left{i}, right{i} : {{0..3}}.Bool
datatype Msg{i} = Data{i}.{{0..3}}.Bool | Ack{i}.{{0..1}} | Nak{i}
channel med{i}, dem{i} : Msg{i}
BUF{i}(s) = #s < 4 & left{i}?x?b -> BUF{i}(s^<(x, b)>)
  [] #s > 0 & (let (x, b) = head(s) within right{i}!x!b -> BUF{i}(tail(s)))
SND{i}(b, x, y) = med{i}!Data{i}.x.y -> (dem{i}?Ack{i}.c -> (if c == b then SND{i}(1 - b, x, y) else SND{i}(b, x, y))
  [] dem{i}.Nak{i} -> SND{i}(b, x, y))
REC{i} = med{i}?Data{i}.x.y -> right{i}.x.y -> dem{i}!Ack{i}.(x % 2) -> REC{i}
has{i}(x, <>) = false
has{i}(x, <y>^ys) = if x == y then true else has{i}(x, ys)
SYS{i} = (SND{i}(0, 1, true) [| {{| med{i}, dem{i} |}} |] REC{i}) \\ {{| med{i}, dem{i} |}}
PAR{i} = || j : {{0..3}} @ [{{| left{i}.j, right{i}.j |}}] (left{i}.j?b -> right{i}.j!b -> STOP)
REN{i} = SYS{i}[[left{i}.x <- right{i}.x | x <- {{0..3}}]]
assert SYS{i} :[deadlock free [FD]]
"""


def test_a_large_script_takes_about_a_second_at_most() -> None:
    text = "".join(UNIT.format(i=i) for i in range(95))
    assert len(text) > 75_000
    script = parser.parse(Source("large.csp", text))
    tied = names.resolve(script)
    started = time.process_time()
    infer(script, tied)
    assert time.process_time() - started < 3  # 0.4 s where nothing else runs
