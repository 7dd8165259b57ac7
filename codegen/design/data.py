"""Data: values and types of the script as Python writes them, and what ``data_types.py`` has to define for that."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from fractions import Fraction
from typing import Any

from cspcheck.codegen import messages, runtime
from cspcheck.codegen.design.naming import camel, safe, unique, upper
from cspcheck.codegen.quoting import literal, phrase
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.classes import context_of
from cspcheck.cspm.process.events import FieldDomain
from cspcheck.cspm.script import Script
from cspcheck.cspm.source import Span
from cspcheck.cspm.typing import types
from cspcheck.cspm.values.dots import Constructor, Dotted, Event
from cspcheck.cspm.values.sets import Set
from cspcheck.cspm.values.text import show
from cspcheck.cspm.values.values import Boolean, Map, Real, Sequence as CspSequence

INTEGERS_LISTED = 8
"""So many integers that are no range are listed in a type without a name."""


class DataDesigner:
    """Collects the definitions of ``data_types.py`` while values and types are asked for."""

    def __init__(self, script: Script) -> None:
        self.script = script
        self.taken: set[str] = {"Any", "ClassVar", "Enum", "Final", *runtime.__all__}
        self.definitions: list[str] = []
        """Statements, in the order in which they must stand."""
        self.runtime: set[str] = set()
        """Names of the runtime that the definitions use."""
        self.enums: set[str] = set()
        self._types: dict[Hashable, str] = {}
        self._defined: dict[tuple[str, str], str] = {}
        self._oz_constants: dict[tuple[str, str], str] = {}
        self._constants: dict[Symbol, str] = {}
        self._classes: dict[str, tuple[str, bool]] = {}

    # --- values ----------------------------------------------------------------------------------------------

    def literal(self, value: Any, where: str, span: Span | None = None) -> str:
        """A value as an expression.

        Raises:
            ScriptError: it has no counterpart (a function, a process, an event).
        """
        match value:
            case Boolean():
                return "True" if value else "False"
            case bool() | int():
                return repr(value)
            case str():
                return literal(value)
            case Real():
                return repr(float(value.value))
            case Map():
                entries = sorted(value.entries.items(), key=lambda entry: show(entry[0]))
                rows = [f"({self.literal(k, where, span)}, {self.literal(v, where, span)})" for k, v in entries]
                return f"({', '.join(rows)}{',' if len(rows) == 1 else ''})"
            case tuple():
                items = [self.literal(item, where, span) for item in value]
                return f"({', '.join(items)})"
            case CspSequence():
                items = [self.literal(item, where, span) for item in value.values()]
                return f"({', '.join(items)}{',' if len(items) == 1 else ''})"
            case Set() if value.is_finite():
                elements = [self.literal(item, where, span) for item in value.elements()]
                return f"frozenset({{{', '.join(elements)}}})" if elements else "frozenset()"
            case Dotted() if isinstance(value.head, Constructor) and value.complete:
                return self._constructed(value, where, span)
            case Event():
                pass
        raise ScriptError(messages.no_value(show(value), where, span))

    def _constructed(self, value: Dotted, where: str, span: Span | None) -> str:
        name, is_enum = self._class(value.head.name)
        if is_enum:
            return f"{name}.{safe(value.head.name)}"
        fields = [self.literal(field, where, span) for field in value.fields]
        self.runtime.add("Tagged")
        if not fields:
            return f"Tagged({literal(value.head.name)})"
        return f"Tagged({literal(value.head.name)}, ({', '.join(fields)}{',' if len(fields) == 1 else ''}))"

    def constructor(self, symbol: Symbol, arguments: Sequence[str], span: Span) -> str:
        """A constructor of a datatype with its fields, which are expressions already."""
        name, is_enum = self._class(symbol.name)
        if is_enum:
            return f"{name}.{safe(symbol.name)}"
        if not arguments:
            return f"Tagged({literal(symbol.name)})"
        return f"Tagged({literal(symbol.name)}, ({', '.join(arguments)}{',' if len(arguments) == 1 else ''}))"

    def _class(self, constructor: str) -> tuple[str, bool]:
        """What the datatype of a constructor is in Python: its name, and whether it is an enumeration."""
        symbol = self.script.names.top_level.get(constructor)
        declaration = symbol.declaration if symbol is not None else None
        name: str = getattr(declaration, "name", constructor)
        known = self._classes.get(name)
        if known is None:
            constructors: Any = getattr(declaration, "constructors", ())
            is_enum = bool(constructors) and all(one.fields is None for one in constructors)
            known = self._classes[name] = (unique(camel(name), self.taken), is_enum)
            self.taken.add(known[0])
            if is_enum:
                members = [f"    {safe(one.name)} = {literal(one.name)}" for one in constructors]
                text = [f"class {known[0]}(Enum):", f'    """The values of `{phrase(name)}`."""', "", *members]
                self.definitions.append("\n".join(text))
                self.enums.add(known[0])
        return known

    # --- types -----------------------------------------------------------------------------------------------

    def field_type(self, domain: FieldDomain | None, name: str | None, where: str) -> str:
        """The type of a channel's field as an expression; defined by *name* if it has one."""
        if domain is None:
            self.runtime.add("Integers")
            return "Integers()"
        return self.set_type(tuple(domain.values), name, where)

    def set_type(self, values: Sequence[Any], name: str | None, where: str) -> str:
        """The type that has exactly these values."""
        key = (name, tuple(values))
        known = self._types.get(key)
        if known is not None:
            return known
        if name is not None:
            constant = self._types[key] = self._define(name, self._type(values, name, where))
            return constant
        return self._type(values, None, where)

    def _define(self, name: str, text: str) -> str:
        """The constant for a type of this name; one for the same name and text."""
        known = self._defined.get((name, text))
        if known is None:
            constant = upper(name)
            known = unique(f"{constant}_TYPE" if constant in self.enums else constant, self.taken)
            self._defined[name, text] = known
            self.taken.add(known)
            self.definitions.append(f"{known}: Final = {text}")
        return known

    # --- what classes need -----------------------------------------------------------------------------------

    def named_type(self, name: str, text: str) -> str:
        """The constant for a type that the script gives a name."""
        return self._define(name, text)

    def datatype(self, name: str, span: Span | None) -> str:
        """The type of all values of a given or free type.

        Raises:
            ScriptError: they cannot be listed: a given type without a finite reading, or the objects of a class.
        """
        context = context_of(self.script)
        if context is not None and name in context.specification.classes:
            what = f"a class that has objects of `{name}` as values"
            raise ScriptError(
                messages.not_generated(what, span, f"let it be `x : {name}`, or a family `f : X -> {name}`")
            )
        if name not in self.script.names.top_level or not self.value_of(name).is_finite():
            what = f"the given type `{name}` without a finite reading"
            raise ScriptError(messages.not_generated(what, span, f"say how many there are: `reading {name} = 3`"))
        return self.set_type(tuple(self.value_of(name).elements()), name, f"`{name}`")

    def datatype_annotation(self, name: str) -> str:
        """What an annotation says of a given or free type."""
        symbol = self.script.names.top_level.get(name)
        constructors: Any = getattr(symbol.declaration if symbol else None, "constructors", ())
        if not constructors:
            return "Any"
        class_name, is_enum = self._class(constructors[0].name)
        return class_name if is_enum else "Tagged"

    def construct(self, constructor: str, argument: str | None, span: Span | None) -> str:
        """A constructor of a free type with its argument, which is an expression already."""
        symbol = self.script.names.top_level.get(constructor)
        if symbol is None or span is None:
            raise ScriptError(messages.no_value(constructor, "a predicate", span))
        return self.constructor(symbol, [] if argument is None else [argument], span)

    def everything(self, type_: core.Type) -> str | None:
        """The set of all values of a type, as an expression."""
        if isinstance(type_, core.BoolType):
            return "frozenset({False, True})"
        if isinstance(type_, (core.GivenType, core.FreeType)):
            return f"{self.datatype(type_.name, None)}.all()"
        return None

    def oz_constant(self, owner: str, name: str, span: Span | None) -> str:
        """The constant for a constant of a class, or of the specification."""
        key = (owner, name)
        known = self._oz_constants.get(key)
        if known is None:
            context = context_of(self.script)
            assert context is not None
            value = context.evaluator(owner).constants[name]
            if not isinstance(value, (bool, int, Fraction)):
                raise ScriptError(messages.no_value(str(value), f"the constant `{name}`", span))
            text = repr(float(value)) if isinstance(value, Fraction) else repr(value)
            known = self._oz_constants[key] = self._define(name, text)
        return known

    def _type(self, values: Sequence[Any], name: str | None, where: str) -> str:
        called = "" if name is None else f", {literal(name)}"
        if values and all(type(value) is int for value in values):
            low, high = min(values), max(values)
            if high - low + 1 == len(values):
                self.runtime.add("Integers")
                return f"Integers({low}, {high}{called})"
        if values and len(values) == 2 and all(isinstance(value, Boolean) for value in values):
            self.runtime.add("BOOLEANS")
            return "BOOLEANS"
        self.runtime.add("Members")
        items = [self.literal(value, where) for value in values]
        if any(_has_sequence(value) for value in values):
            comma = "," if len(values) == 1 else ""
            texts = ", ".join(literal(show(value)) for value in values)
            given = "None" if name is None else literal(name)
            return f"Members(({', '.join(items)}{comma}), {given}, ({texts}{comma}))"
        enum = items[0].partition(".")[0] if items else ""
        if enum in self.enums and len(items) == self._size(enum) and all(i.startswith(f"{enum}.") for i in items):
            return f"Members(tuple({enum}){called})"
        return f"Members(({', '.join(items)}{',' if len(items) == 1 else ''}){called})"

    def _size(self, enum: str) -> int:
        text = next(text for text in self.definitions if text.startswith(f"class {enum}("))
        return sum(" = " in line for line in text.splitlines())

    # --- constants -------------------------------------------------------------------------------------------

    def constant(self, symbol: Symbol, span: Span) -> tuple[str, bool]:
        """The constant for a top-level value of the script, and whether it is a type (a set).

        Raises:
            ScriptError: its value cannot be written in Python, or evaluating it goes wrong.
        """
        value = self.value_of(symbol.name)
        is_set = isinstance(value, Set)
        known = self._constants.get(symbol)
        if known is None:
            if is_set:
                if not value.is_finite():
                    raise ScriptError(messages.no_value(symbol.name, "an expression", span))
                known = self.set_type(tuple(value.elements()), symbol.name, f"`{symbol.name}`")
            else:
                text = self.literal(value, f"`{symbol.name}`", span)
                known = unique(upper(symbol.name), self.taken)
                self.taken.add(known)
                self.definitions.append(f"{known}: Final = {text}")
            self._constants[symbol] = known
        return known, is_set

    def value_of(self, text: str) -> Any:
        """The value of an expression of the script, as the evaluator has it."""
        return self.script.value(text)

    # --- annotations -----------------------------------------------------------------------------------------

    def annotation(self, type_: types.Type) -> str:
        """What a Python annotation says of a CSPm type."""
        found = types.resolve(type_)
        match found:
            case types.Atom():
                return {"Int": "int", "Bool": "bool", "Char": "str"}.get(found.name, "Any")
            case types.SetOf():
                return f"frozenset[{self.annotation(found.element)}]"
            case types.SequenceOf():
                return f"tuple[{self.annotation(found.element)}, ...]"
            case types.TupleOf():
                return f"tuple[{', '.join(map(self.annotation, found.items))}]"
            case types.Datatype():
                constructor = next(iter(found.fields), None)
                symbol = None if constructor is None else self.script.names.top_level.get(constructor)
                if symbol is None or symbol.kind is not SymbolKind.CONSTRUCTOR:
                    return "Any"
                name, is_enum = self._class(symbol.name)
                return name if is_enum else "Tagged"
        return "Any"


def _has_sequence(value: Any) -> bool:
    """Whether a value has something in it that in Python looks like something else: sequences, maps, reals."""
    match value:
        case CspSequence() | Map() | Real():
            return True
        case tuple():
            return any(map(_has_sequence, value))
        case Dotted():
            return any(map(_has_sequence, value.fields))
        case Set() if value.is_finite():
            return any(map(_has_sequence, value.elements()))
    return False
