"""Names are tied to the one thing that each means."""

from __future__ import annotations

import pytest

from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.evaluator.free import children
from cspcheck.cspm.naming.resolve import Names, Symbol, SymbolKind, resolve, resolve_more
from cspcheck.cspm.parsing.reading import parse, parse_expression
from cspcheck.cspm.source import Source
from cspcheck.cspm.syntax import tree as syntax


def tied(text: str) -> Names:
    return resolve(parse(Source("test.csp", text)))


def uses(names: Names, text: str) -> list[Symbol]:
    """The symbols of all uses of the name *text* in expressions, in the order of the script."""
    found: list[tuple[int, Symbol]] = []
    stack: list[syntax.Node] = [names.script]
    while stack:
        node = stack.pop()
        if isinstance(node, syntax.Name) and node.text == text:
            found.append((node.span.start, names.symbol(node)))
        stack.extend(children(node))
    return [symbol for _, symbol in sorted(found, key=lambda pair: pair[0])]


def test_a_name_is_what_the_innermost_scope_says() -> None:
    names = tied("x = 1\nf(x) = let y = x within {x | x <- {y}}\ng = x")
    result, value, top = uses(names, "x")
    assert value.kind is SymbolKind.VARIABLE
    assert value.is_local
    assert result.kind is SymbolKind.VARIABLE
    assert result is not value
    assert top is names.top_level["x"]
    assert not top.is_local


def test_definitions_of_a_let_see_each_other_and_later_definitions_of_the_script_are_seen() -> None:
    names = tied("p = let a = b\n        b = q\n    within a\nq = 1")
    assert uses(names, "b")[0].kind is SymbolKind.VALUE
    assert uses(names, "b")[0].is_local
    assert uses(names, "q")[0] is names.top_level["q"]


def test_generators_are_seen_behind_them_only() -> None:
    names = tied("x = {1}\ny = {z | x <- x, z <- {x}}")
    source, later = uses(names, "x")
    assert source is names.top_level["x"]
    assert later.kind is SymbolKind.VARIABLE


def test_fields_of_a_prefix_are_seen_in_later_fields_and_behind() -> None:
    names = tied("channel c : {0..1}.{0..1}\nP = c?x?y:{x} -> c.x.y -> STOP")
    in_field, behind = uses(names, "x")
    assert in_field is behind


def test_kinds_of_declarations() -> None:
    text = """
channel c
datatype T = A | B.{0..1}
subtype S = A
nametype N = {0..1}
f(x) = x
v = 1
(p, q) = (1, 2)
module M
exports
  w = 1
endmodule
instance I = M
"""
    names = tied(text)
    kinds = {name: symbol.kind.name for name, symbol in names.top_level.items()}
    assert kinds == {
        "c": "CHANNEL",
        "T": "DATATYPE",
        "A": "CONSTRUCTOR",
        "B": "CONSTRUCTOR",
        "S": "SUBTYPE",
        "N": "NAMETYPE",
        "f": "FUNCTION",
        "v": "VALUE",
        "p": "VALUE",
        "q": "VALUE",
        "M": "MODULE",
        "I": "INSTANCE",
    }


def test_names_in_patterns_that_are_constructors_or_channels_stand_for_themselves() -> None:
    names = tied("channel c\ndatatype T = A\nf(A, c, x) = x\n(A, y) = (A, 1)")
    assert names.top_level["y"].kind is SymbolKind.VALUE
    assert names.top_level["A"].kind is SymbolKind.CONSTRUCTOR
    definition = next(d for d in names.script.declarations if isinstance(d, syntax.FunctionDefinition))
    constructor, channel, variable = definition.clauses[0].groups[0]
    assert names.symbol(constructor) is names.top_level["A"]
    assert names.symbol(channel) is names.top_level["c"]
    assert names.symbol(variable).kind is SymbolKind.VARIABLE


def test_a_member_seen_through_an_instance_is_a_symbol_of_its_own() -> None:
    text = """
module M(n)
  hidden = n
exports
  x = hidden
endmodule
instance I = M(1)
instance J = M(2)
a = I::x
b = I::x
c = J::x
"""
    names = tied(text)
    module = names.top_level["M"]
    (first, second), (other,) = uses(names, "I::x"), uses(names, "J::x")
    assert first is second
    assert first is not other
    assert first.member is other.member is module.members["x"]
    assert first.instance is names.top_level["I"]
    assert first.instance.module is module
    assert first is names.project(names.top_level["I"], module.members["x"])
    assert module.exported == {"x"}
    assert [parameter.name for parameter in module.parameters] == ["n"]


def test_a_module_without_parameters_is_an_instance_of_itself() -> None:
    names = tied("module M\nexports\nx = 1\nendmodule\na = M::x\ninstance I = M\nb = I::x")
    assert uses(names, "M::x")[0] is names.top_level["M"].members["x"]
    assert uses(names, "I::x")[0].member is names.top_level["M"].members["x"]


def test_instances_inside_modules_are_seen_through_both() -> None:
    text = """
module Outer
exports
  module Inner(n)
  exports
    x = n
  endmodule
  instance K = Inner(1)
endmodule
instance O = Outer
instance L = O::Inner(2)
a = O::K::x
b = L::x
"""
    names = tied(text)
    outer = names.top_level["Outer"]
    inner = outer.members["Inner"]
    (deep,) = uses(names, "O::K::x")
    assert deep.member is inner.members["x"]
    assert deep.instance is names.project(names.top_level["O"], outer.members["K"])
    (later,) = uses(names, "L::x")
    assert later.instance is names.top_level["L"]
    assert names.top_level["L"].module is names.project(names.top_level["O"], inner)


def test_annotations_belong_to_their_symbols() -> None:
    names = tied("x, f :: Int\nx = 1\nf(y) = y\nz = 2")
    assert names.annotation(names.top_level["x"]) is names.annotation(names.top_level["f"])
    assert names.annotation(names.top_level["z"]) is None


def test_expressions_written_later_see_the_script() -> None:
    names = tied("x = 1")
    expression = parse_expression("let y = x within y + x")
    resolve_more(names, expression)
    assert isinstance(expression, syntax.Let)
    with pytest.raises(ScriptError) as raised:
        resolve_more(names, parse_expression("x + z"))
    assert raised.value.diagnostics[0].message == "`z` is not defined"


def test_mistakes_are_told_all_at_once_but_not_without_end() -> None:
    with pytest.raises(ScriptError) as raised:
        tied("\n".join(f"x{i} = undefined{i}" for i in range(100)))
    assert len(raised.value.diagnostics) == 20


def test_names_of_the_language_mean_the_same_everywhere() -> None:
    one, two = tied("x = union"), tied("transparent normal\ny = union\nz = normal")
    assert uses(one, "union")[0] is uses(two, "union")[0]
    assert uses(two, "normal")[0].kind is SymbolKind.BUILTIN


def test_modules_nested_deeply_are_followed_once() -> None:
    depth = 200
    text = "".join(f"module M{i}\nexports\n" for i in range(depth)) + "x = 1\n" + "endmodule\n" * depth
    assert tied(text).top_level["M0"].exported == {"M1"}
