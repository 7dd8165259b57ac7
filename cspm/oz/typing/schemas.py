"""Schemas as values: what a schema expression declares, and what it says of that.

Inclusion, decoration, ``Delta S`` and ``Xi S``, the logical operators, hiding, projection, quantifiers, composition,
piping, ``pre`` and renaming, as in Spivey, *The Z Notation* (1992), chapter 5. Names with a decoration are components
of their own (``x``, ``x'``, ``x?``). Whatever the expression, the result is components with their sets, and predicates
on them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, MutableMapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import BOOL, Apply, Declared, RecordType, SetType, Term, Variable
from cspcheck.cspm.oz.typing import type_messages as messages
from cspcheck.cspm.oz.typing.fitting import Misfit, fit
from cspcheck.cspm.oz.typing.scopes import PredicatePlace, SetEntry, TypingScope, VariableEntry
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.oz.values.terms import shape
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

if TYPE_CHECKING:
    from cspcheck.cspm.oz.typing.typing import Typing

WORDS: Final = ("Delta", "Xi", "pre")
"""What stands before a schema and makes another one of it."""

_TRUE: Final = core.Constant(type=BOOL, value=True)


@dataclass(frozen=True)
class TypedSchema:
    """Components by their decorated names, and predicates that speak of them as bound variables of those names."""

    fields: tuple[Declared, ...]
    predicates: tuple[Term, ...] = ()


class Schemas:
    """Makes schemas of expressions.

    Args:
        typing: of the specification.
        records: the schemas that are declared, by name; what is no declared schema is entered here when it is needed
            as a type.
    """

    def __init__(self, typing: Typing, records: MutableMapping[str, core.RecordDefinition]) -> None:
        self._typing = typing
        self._records = records
        self._fresh = 0

    # --- expressions ------------------------------------------------------------------------------------------

    def value(self, node: s.Term, scope: TypingScope) -> TypedSchema | None:
        """The schema that an expression stands for; None if it stands for something else.

        Raises:
            Wrong: it is a schema, but something in it is wrong.
        """
        match node:
            case s.Grouped():
                return self.value(node.inner, scope)
            case s.SchemaText():
                return self.text(node.declarations, node.predicates, scope)
            case s.Reference():
                return self._reference(node, scope)
            case s.Renamed():
                inner = self.value(node.term, scope)
                return None if inner is None else self._renamed(inner, node.renamings)
            case s.Application(function=s.Reference(name="Delta" | "Xi" | "pre" as word), argument=argument):
                inner = None if scope.find(word) is not None else self.value(argument, scope)
                return None if inner is None else self._prefixed(word, inner, node.span)
            case s.Quantified():
                inner = self._quantified_body(node, scope)
                return None if inner is None else self._quantified(node, inner, scope)
            case s.Operator(name="diff", operands=(left, hidden)):
                inner = self.value(left, scope)
                return None if inner is None else self._hidden(inner, hidden)
            case s.Operator(name="filter", operands=(left, right)):
                inner = self.value(left, scope)
                return None if inner is None else self._projected(inner, self.needed(right, scope), node.span)
            case s.Operator(name="not", operands=(operand,)):
                inner = self.value(operand, scope)
                return None if inner is None else _logical("not", [inner], node.span)
            case s.Operator(name="and" | "or" | "implies" | "iff" | "compose" | "pipe" as name, operands=(left, right)):
                return self._joined(name, left, right, node.span, scope)
        return None

    def text(self, declarations: Sequence[s.Declare], predicates: Sequence[s.Term], scope: TypingScope) -> TypedSchema:
        """The schema of declarations and predicates; a declaration without names includes a schema."""
        found = self.declared(declarations, scope)
        inner = self.inside(found, scope)
        own = tuple([self._typing.predicate(p, inner, "record") for p in predicates])
        return replace(found, predicates=(*found.predicates, *own))

    def declared(self, declarations: Sequence[s.Declare], scope: TypingScope) -> TypedSchema:
        """The schema of declarations alone."""
        found = TypedSchema(())
        for declaration in declarations:
            if not declaration.names:
                found = _merged(found, self.needed(declaration.carrier, scope), declaration.span)
                continue
            carrier = self._typing.carrier(declaration.carrier, scope)
            assert isinstance(carrier.type, SetType)
            fields = [
                Declared(name=n.name + n.decoration, type=carrier.type.element, carrier=carrier, span=n.span)
                for n in declaration.names
            ]
            for field in fields:
                found = _merged(found, TypedSchema((field,)), field.span)
        return found

    def needed(self, node: s.Term, scope: TypingScope) -> TypedSchema:
        """The schema that an expression stands for.

        Raises:
            Wrong: it is none.
        """
        found = self.value(node, scope)
        if found is None and isinstance(node, s.Renamed):
            return self.needed(node.term, scope)  # is none either
        if found is None and isinstance(node, s.Application) and _is_prefixed(node, scope):
            return self.needed(node.argument, scope)
        if found is None:
            raise Wrong(messages.no_schema(str(self._typing.expression(node, scope, "axiom").type), node.span))
        return found

    def inside(self, schema: TypedSchema, scope: TypingScope) -> TypingScope:
        """The scope in which the components of a schema have their names."""
        inner = TypingScope(scope)
        for field in schema.fields:
            inner.add(field.name, VariableEntry(_variable(field), field.span))
        return inner

    def _reference(self, node: s.Reference, scope: TypingScope) -> TypedSchema | None:
        plain = replace(node, decoration="")
        if node.arguments:
            term: Term | None = self._typing.instance(plain, scope)
        else:
            entry = scope.find(node.name)
            term = entry.term if isinstance(entry, SetEntry) else None
        if not isinstance(term, Apply) or term.operator != "Records" or not isinstance(term.type, SetType):
            return None
        assert isinstance(term.type.element, RecordType)
        record = self._records[term.type.element.name]
        found = TypedSchema(record.fields, record.predicates)
        return found if not node.decoration else _decorated(found, node.decoration)

    def _prefixed(self, word: str, inner: TypedSchema, span: Span) -> TypedSchema:
        if word == "pre":
            gone = [f for f in inner.fields if f.name.endswith(("'", "!"))]
            return self._exists(inner, gone, span)
        both = _merged(inner, _decorated(inner, "'"), span)
        if word == "Delta":
            return both
        after = {field.name: field for field in both.fields}
        same = [
            Apply(type=BOOL, operator="equal", operands=(_variable(after[f"{f.name}'"]), _variable(f)), span=span)
            for f in inner.fields
        ]
        return replace(both, predicates=(*both.predicates, *same))

    def _joined(self, name: str, left: s.Term, right: s.Term, span: Span, scope: TypingScope) -> TypedSchema | None:
        first = self.value(left, scope)
        if first is None:
            return None
        second = self.needed(right, scope)
        if name == "and":
            return _merged(first, second, span)
        if name in ("or", "implies", "iff"):
            return _logical(name, [first, second], span)
        return self._through(first, second, ("'", "") if name == "compose" else ("!", "?"), span)

    def _through(self, first: TypedSchema, second: TypedSchema, ends: tuple[str, str], span: Span) -> TypedSchema:
        """Two schemas, the ends of the first being the beginnings of the second: composition and piping."""
        there = {f.name for f in second.fields}
        joint = [
            f
            for f in first.fields
            if f.name.endswith(ends[0]) and _base(f.name) + ends[1] in there and not _base(f.name).endswith("'")
        ]
        between = {f.name: f"{_base(f.name)}%between" for f in joint}
        first = _renamed_fields(first, between)
        second = _renamed_fields(second, {_base(f.name) + ends[1]: between[f.name] for f in joint})
        both = _merged(first, second, span)
        return self._exists(both, [f for f in both.fields if f.name in between.values()], span)

    def _renamed(self, inner: TypedSchema, renamings: Iterable[tuple[s.Declared, s.Declared]]) -> TypedSchema:
        names = {old.name + old.decoration: new.name + new.decoration for new, old in renamings}
        known = {field.name for field in inner.fields}
        for _, old in renamings:
            written = old.name + old.decoration
            if written not in known:
                raise Wrong(messages.no_component(written, old.span, suggestions(written, known)))
        return _renamed_fields(inner, names)

    def _hidden(self, inner: TypedSchema, hidden: s.Term) -> TypedSchema:
        hidden = s.bare(hidden)
        items = hidden.items if isinstance(hidden, s.Display) else (hidden,)
        fields = {field.name: field for field in inner.fields}
        gone = []
        for item in items:
            written = item.name + item.decoration if isinstance(item, s.Reference) else ""
            if written not in fields:
                raise Wrong(messages.no_component(written or "this", item.span, suggestions(written, fields)))
            gone.append(fields[written])
        return self._exists(inner, gone, hidden.span)

    def _projected(self, inner: TypedSchema, onto: TypedSchema, span: Span) -> TypedSchema:
        """Both schemas, with the components hidden that the second one has not."""
        kept = {field.name for field in onto.fields}
        both = _merged(inner, onto, span)
        return self._exists(both, [field for field in both.fields if field.name not in kept], span)

    def _exists(self, inner: TypedSchema, gone: Sequence[Declared], span: Span) -> TypedSchema:
        if not gone:
            return inner
        binders, table = self._binders(gone)
        body = core.conjunction(inner.predicates, span)
        left = tuple([f for f in inner.fields if f not in gone])
        exists = core.Quantifier(
            type=BOOL, kind="exists", binders=binders, condition=_TRUE, body=substituted(body, table), span=span
        )
        return TypedSchema(left, (exists,))

    def _quantified_body(self, node: s.Quantified, scope: TypingScope) -> TypedSchema | None:
        return self.value(node.body, scope)

    def _quantified(self, node: s.Quantified, inner: TypedSchema, scope: TypingScope) -> TypedSchema:
        conditions = () if node.condition is None else (node.condition,)
        bound = self.text(node.declarations, conditions, scope)
        names = {field.name for field in bound.fields}
        members = [_member(f) for f in inner.fields if f.name in names]
        binders, table = self._binders(bound.fields)
        quantifier = core.Quantifier(
            type=BOOL,
            kind=node.kind,
            binders=binders,
            condition=substituted(core.conjunction(bound.predicates, node.span), table),
            body=substituted(core.conjunction((*members, *inner.predicates), node.span), table),
            span=node.span,
        )
        return TypedSchema(tuple([f for f in inner.fields if f.name not in names]), (quantifier,))

    def _binders(self, fields: Sequence[Declared]) -> tuple[tuple[core.Binder, ...], Callable[[Variable], Term | None]]:
        """Bound variables for components, and the replacement of these by those."""
        table: dict[str, Variable] = {}
        binders = []
        for field in fields:
            self._fresh += 1
            written = field.name.split("%")[0]
            binders.append(core.Binder(f"{written}%schema%{self._fresh}", field.type, field.carrier, written))
            table[field.name] = Variable(type=field.type, name=binders[-1].name, role="bound", span=field.span)
        return tuple(binders), _by_name(table)

    # --- what schemas are used for ----------------------------------------------------------------------------

    def binders(self, schema: TypedSchema, scope: TypingScope) -> tuple[tuple[core.Binder, ...], TypingScope, Term]:
        """A schema as the declaration of a quantifier: bound variables, the scope inside, and its predicate."""
        binders, table = self._binders(schema.fields)
        inner = TypingScope(scope)
        for field, binder in zip(schema.fields, binders, strict=True):
            variable = Variable(type=binder.type, name=binder.name, role="bound", span=field.span)
            inner.add(field.name, VariableEntry(variable, field.span))
        return binders, inner, substituted(core.conjunction(schema.predicates), table)

    def named(self, name: str, schema: TypedSchema, span: Span, initial: tuple[Term, ...] | None = None) -> Term:
        """The set of the bindings of a schema, which is known by a name from now on."""
        kind = RecordType(name, tuple([(field.name, field.type) for field in schema.fields]))
        known = self._records.get(name)
        if known is None or known.span == span:
            self._records[name] = core.RecordDefinition(
                name=name, fields=schema.fields, predicates=schema.predicates, initial=initial, span=span
            )
        return Apply(type=SetType(kind), operator="Records")

    def predicate(self, schema: TypedSchema, scope: TypingScope, place: PredicatePlace, span: Span) -> Term:
        """A schema as a predicate: it holds of the variables that have the names of its components.

        Raises:
            Wrong: there is no variable of a name, or one of another type.
        """
        values = self._values(schema, scope, place, span)
        members = [
            Apply(
                type=BOOL, operator="in", operands=(values[f.name], substituted(f.carrier, _by_name(values))), span=span
            )
            for f in schema.fields
        ]
        own = [substituted(p, _by_name(values)) for p in schema.predicates]
        return core.conjunction((*members, *own), span)

    def binding(self, node: s.Term, scope: TypingScope, place: PredicatePlace, span: Span) -> Term:
        """``theta S``: the record of the variables that are called as the components of S; of ``S'``, primed ones."""
        decoration = ""
        if isinstance(node, s.Reference) and node.decoration:
            decoration, node = node.decoration, replace(node, decoration="")
        schema = self.needed(node, scope)
        term = self._typing.expression(node, scope, "axiom")
        assert isinstance(term.type, SetType)
        values = self._values(_decorated(schema, decoration) if decoration else schema, scope, place, span)
        return core.Record(
            type=term.type.element, values=tuple([values[f.name + decoration] for f in schema.fields]), span=span
        )

    def _values(self, schema: TypedSchema, scope: TypingScope, place: PredicatePlace, span: Span) -> dict[str, Term]:
        values = {}
        for field in schema.fields:
            base = field.name.rstrip("'?!")
            decoration: s.Decoration = field.name[len(base) :][:1]  # type: ignore[assignment]
            reference = s.Reference(span=span, name=base, decoration=decoration)
            value = self._typing.expression(reference, scope, place)
            try:
                values[field.name] = fit(value, field.type)
            except Misfit:
                raise Wrong(messages.types_differ(str(field.type), str(value.type), span)) from None
        return values


def _base(name: str) -> str:
    return name[:-1] if name.endswith(("'", "?", "!")) else name


def _is_prefixed(node: s.Application, scope: TypingScope) -> bool:
    """Whether this is ``Delta S``, ``Xi S`` or ``pre S``."""
    function = node.function
    function = s.bare(function)
    return isinstance(function, s.Reference) and function.name in WORDS and scope.find(function.name) is None


def _variable(field: Declared) -> Variable:
    return Variable(type=field.type, name=field.name, role="bound", span=field.span)


def _member(field: Declared) -> Term:
    return Apply(type=BOOL, operator="in", operands=(_variable(field), field.carrier), span=field.span)


def _by_name(table: Mapping[str, Term]) -> Callable[[Variable], Term | None]:
    return lambda v: table.get(v.name) if v.role == "bound" else None


def _merged(first: TypedSchema, second: TypedSchema, span: Span) -> TypedSchema:
    """Both schemas; what both declare lies in both sets."""
    fields = {field.name: field for field in first.fields}
    more: list[Term] = []
    for field in second.fields:
        known = fields.setdefault(field.name, field)
        if known.type != field.type:
            raise Wrong(messages.types_differ(str(known.type), str(field.type), span))
        if shape(known.carrier) != shape(field.carrier):
            more.append(_member(field))
    own = [p for p in second.predicates if p not in first.predicates]
    return TypedSchema(tuple(fields.values()), (*first.predicates, *more, *own))


def _renamed_fields(inner: TypedSchema, names: Mapping[str, str]) -> TypedSchema:
    """A schema with other names for its components; components that get the same name are the same."""
    fields = [replace(field, name=names.get(field.name, field.name)) for field in inner.fields]
    table = {old.name: _variable(new) for old, new in zip(inner.fields, fields, strict=True) if old.name != new.name}
    predicates = tuple([substituted(p, _by_name(table)) for p in inner.predicates])
    found = TypedSchema(())
    for field in fields:
        found = _merged(found, TypedSchema((field,)), field.span)
    return replace(found, predicates=(*found.predicates, *predicates))


def _decorated(inner: TypedSchema, decoration: str) -> TypedSchema:
    return _renamed_fields(inner, {field.name: field.name + decoration for field in inner.fields})


def _logical(name: str, operands: Sequence[TypedSchema], span: Span) -> TypedSchema:
    """A connective between schemas: their components range over whole types, what they say is joined."""
    fields: dict[str, Declared] = {}
    for operand in operands:
        for field in operand.fields:
            known = fields.setdefault(field.name, field)
            if known.type != field.type:
                raise Wrong(messages.types_differ(str(known.type), str(field.type), span))
    shared = {
        f.name
        for f in fields.values()
        if name == "or"
        and all(any(f.name == g.name and shape(f.carrier) == shape(g.carrier) for g in o.fields) for o in operands)
    }
    said = tuple(
        [
            core.conjunction((*[_member(f) for f in o.fields if f.name not in shared], *o.predicates), span)
            for o in operands
        ]
    )
    wide = [f if f.name in shared else replace(f, carrier=maximal(f.type)) for f in fields.values()]
    return TypedSchema(tuple(wide), (Apply(type=BOOL, operator=name, operands=said, span=span),))


def maximal(type_: core.Type) -> Term:
    """The set of all values of a type."""
    made = SetType(type_)
    match type_:
        case core.BoolType():
            return Apply(type=made, operator="Bool")
        case core.IntType():
            return Apply(type=made, operator="Int")
        case core.RealType():
            return Apply(type=made, operator="Real")
        case core.SetType(element):
            return Apply(type=made, operator="power", operands=(maximal(element),))
        case core.SequenceType(element):
            return Apply(type=made, operator="seq", operands=(maximal(element),))
        case core.BagType(element):
            return Apply(type=made, operator="bag", operands=(maximal(element),))
        case core.TupleType(items):
            return Apply(type=made, operator="cross", operands=tuple([maximal(item) for item in items]))
        case core.FunctionType(domain, range_):
            return Apply(type=made, operator="pfun", operands=(maximal(domain), maximal(range_)))
        case core.RecordType():
            return Apply(type=made, operator="Records")
    return Apply(type=made, operator="All")
