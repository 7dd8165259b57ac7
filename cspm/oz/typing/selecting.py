"""What stands in front of a dot: records, tuples, objects, classes of a retrieve relation."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import BOOL, Apply, RecordType, Term, TupleType, Type
from cspcheck.cspm.oz.typing import type_messages as messages
from cspcheck.cspm.oz.typing.everyday import component
from cspcheck.cspm.oz.typing.fitting import Misfit, fit
from cspcheck.cspm.oz.typing.identities import POOL, pool_of
from cspcheck.cspm.oz.typing.scopes import ClassEntry, ObjectEntry, SetEntry, TypingScope, VariableEntry
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions


def selected(node: s.Selection, record: Term, records: Mapping[str, core.RecordDefinition]) -> Term:
    """``r.x`` of a record, ``r.INIT``, ``t.1`` of a tuple.

    Raises:
        Wrong: there is no such component.
    """
    own = isinstance(record.type, RecordType) and node.field in dict(record.type.fields)
    if node.field in ("INIT", "init") and not own:
        if not isinstance(record.type, RecordType):
            raise Wrong(messages.init_of_no_record(str(record.type), node.span))
        if records[record.type.name].initial is None:
            raise Wrong(messages.record_without_init(record.type.name, node.span))
        return Apply(type=BOOL, operator="init", operands=(record,), span=node.span)
    if isinstance(record.type, TupleType) and node.field.isdigit():
        item = component(record, int(node.field), node.span)
        if item is not None:
            return item
    if not isinstance(record.type, RecordType):
        raise Wrong(messages.field_of_no_record(node.field, str(record.type), node.span))
    for name, type_ in record.type.fields:
        if name == node.field:
            return core.Field(type=type_, record=record, name=name, span=node.span)
    names = [name for name, _ in record.type.fields]
    raise Wrong(messages.no_such_field(node.field, record.type.name, node.span, suggestions(node.field, names)))


def attribute(
    node: s.Selection,
    entry: ObjectEntry,
    index: Term | None,
    scope: TypingScope,
    reference: Callable[[s.Reference], Term],
) -> Term:
    """``a.x``, ``a.INIT``, where a is an object; *reference* types the name that its variable has.

    Raises:
        Wrong: the object has no such feature.
    """
    if node.field in ("INIT", "Init", "init"):
        said = core.conjunction(entry.initial, node.span)
        if index is None or entry.binder is None:
            return said
        name = entry.binder.name
        return substituted(said, lambda v: index if v.name == name else None)
    written = f"{entry.name}.{node.field}"
    if scope.find(written) is None:
        start = f"{entry.name}."
        names = [n.removeprefix(start) for n in scope.names() if n.startswith(start)]
        raise Wrong(messages.no_such_field(node.field, entry.owner, node.span, suggestions(node.field, names)))
    value = reference(s.Reference(span=node.span, name=written, decoration=node.decoration))
    if index is None or node.field in entry.shared or isinstance(scope.find(written), SetEntry):
        return value
    assert isinstance(value.type, core.FunctionType)
    return Apply(type=value.type.range, operator="apply", operands=(value, index), span=node.span)


def of_object_after(node: s.Selection, scope: TypingScope) -> s.Selection:
    """``a'.x`` of an object that *a* names for ever is ``a.x'``."""
    match node:
        case s.Selection(record=s.Reference(decoration="'", name=name) as record, decoration=""):
            if isinstance(scope.find(name), ObjectEntry):
                return replace(node, record=replace(record, decoration=""), decoration="'")
    return node


def made_record(given: Mapping[str, Term], records: Mapping[str, core.RecordDefinition], span: Span) -> Term:
    """The record of a schema that has just the components that are given.

    Raises:
        Wrong: there is no such schema.
    """
    fitting = [r for r in records.values() if {f.name for f in r.fields} == set(given)]
    for definition in fitting:
        try:
            values = tuple([fit(given[f.name], f.type) for f in definition.fields])
        except Misfit:
            continue
        type_ = RecordType(definition.name, tuple([(f.name, f.type) for f in definition.fields]))
        return core.Record(type=type_, values=values, span=span)
    raise Wrong(messages.no_such_record(list(given), [r.name for r in records.values()], span))


def qualified(node: s.Selection, scope: TypingScope) -> Term | None:
    """``A.items`` in a retrieve relation: a state variable of the class A."""
    record = node.record
    if not isinstance(record, s.Reference) or not isinstance(scope.find(record.name), ClassEntry):
        return None
    entry = scope.find(f"{record.name}.{node.field}")
    return replace(entry.term, span=node.span) if isinstance(entry, VariableEntry) else None


def pool_in(scope: TypingScope, type_: Type) -> ObjectEntry | None:
    """The objects that values of a type are identities of, if the class has them."""
    name = pool_of(type_)
    entry = None if name is None else scope.find(name)
    return entry if isinstance(entry, ObjectEntry) else None


def has_objects(scope: TypingScope, field: str) -> bool:
    """Whether objects that are values have objects called *field* themselves."""
    pools = [name[len(POOL) :] for name in scope.names() if name.startswith(POOL)]
    return any(isinstance(scope.find(f"{pool}.{field}"), ObjectEntry) for pool in pools)


def names_apart(node: s.Chain, scope: TypingScope) -> Term | None:
    """``a = b``, ``a != b`` for attributes that are objects for ever: two names are two objects.

    None for other chains.
    """
    names = [o.name for o in node.operands if isinstance(o, s.Reference) and not o.decoration]
    entries = [scope.find(name) for name in names]
    if len(names) != len(node.operands) or not all(isinstance(e, ObjectEntry) and e.binder is None for e in entries):
        return None
    if not all(relation in ("equal", "not_equal") for relation in node.relations):
        return None
    pairs = zip(node.relations, names, names[1:], strict=False)
    holds = all((first == second) == (relation == "equal") for relation, first, second in pairs)
    return core.Constant(type=BOOL, value=holds, span=node.span)
