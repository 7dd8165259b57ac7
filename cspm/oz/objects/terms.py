"""Types of expressions and predicates, where objects are references.

Types flow by unification (:mod:`cspcheck.cspm.oz.objects.types`). A membership ``a in B`` tells of which class *a* is
for all that is said together with it: for the other conjuncts, behind ``=>``, on both sides of ``<=>`` (see
:mod:`cspcheck.cspm.oz.objects.narrowing`).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects import messages
from cspcheck.cspm.oz.objects.narrowing import facts, is_logical, key
from cspcheck.cspm.oz.objects.schemas import SchemaCalculus
from cspcheck.cspm.oz.objects.scopes import ClassName, Deferred, Entry, Scope, Value
from cspcheck.cspm.oz.objects.toolkit import is_toolkit_name, name_type, operator_type
from cspcheck.cspm.oz.objects.types import (
    NUMBER,
    TRUTH,
    Bindings,
    ClassReference,
    Given,
    Objects,
    ObjectZType,
    Open,
    Power,
    Product,
    Unification,
    bindings,
    is_open,
    known,
    pairs,
    sequence,
    shown,
    shown_apart,
    substituted,
)
from cspcheck.cspm.oz.reading.operators import INREL
from cspcheck.cspm.oz.typing import type_messages
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.writing.printer import print_term
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

if TYPE_CHECKING:
    from cspcheck.cspm.oz.objects.classes import Classes


class Terms:
    """Types the terms of one document.

    Args:
        report: told what is wrong.

    Attributes:
        classes: of the document; set by it.
    """

    classes: Classes

    def __init__(self, report: Callable[[Diagnostic], None]) -> None:
        self.report = report
        self.unification = Unification(lambda left, right: self.classes.admits(left, right))
        self.schemas = SchemaCalculus(self)
        self.uses: list[tuple[Open, str, Span]] = []
        """Parameters of generic names that the document leaves out."""

    # --- what is asked for ------------------------------------------------------------------------------------

    def predicates(self, nodes: Iterable[s.Term], scope: Scope) -> None:
        """Type predicates that hold together; mistakes are reported."""
        nodes = list(nodes)
        inner = self.narrowed(scope, [fact for node in nodes for fact in facts(node)])
        for node in nodes:
            try:
                self.predicate(node, inner)
            except Wrong as wrong:
                self.report(wrong.diagnostic)

    def predicate(self, node: s.Term, scope: Scope) -> None:
        """Type a predicate.

        Raises:
            Wrong: it is none.
        """
        type_ = self.term(node, scope)
        found = known(type_)
        if isinstance(found, Power) and isinstance(known(found.element), Bindings):
            self.schemas.said(found, scope, node.span)
        elif not self.unification.same(type_, TRUTH):
            raise Wrong(type_messages.no_predicate(shown(type_), node.span))

    def element(self, carrier: s.Term, scope: Scope) -> ObjectZType:
        """What the values of a declaration are of.

        Raises:
            Wrong: the carrier is no set.
        """
        type_ = self.term(carrier, scope)
        element = Open()
        if not self.unification.same(type_, Power(element)):
            raise Wrong(type_messages.no_set(shown(type_), carrier.span))
        return known(element)

    def declared(self, declarations: Sequence[s.Declare], scope: Scope) -> dict[str, Value]:
        """The names that declarations introduce, with their strokes; what includes a schema adds its components.

        Mistakes are reported; a name whose carrier is wrong may be of any type.
        """
        found: dict[str, Value] = {}
        own: set[str] = set()
        for declaration in declarations:
            try:
                if not declaration.names:
                    schema = self.schemas.of(declaration.carrier, scope)
                    for name, type_ in schema.items():
                        self._add(found, name, Value(type_, declaration.span), declaration.span)
                    continue
                type_ = self.element(declaration.carrier, scope)
            except Wrong as wrong:
                self.report(wrong.diagnostic)
                type_ = Open()
            for declared in declaration.names:
                name = declared.name + declared.decoration
                if name in own:
                    self.report(type_messages.declared_twice(name, found[name].span, declared.span))
                own.add(name)
                self._add(found, name, Value(type_, declared.span), declared.span)
        return found

    def _add(self, found: dict[str, Value], name: str, value: Value, span: Span) -> None:
        first = found.setdefault(name, value)
        if not self.unification.same(first.type, value.type):
            self.report(type_messages.types_differ(shown(value.type), shown(first.type), span))

    def narrowed(self, scope: Scope, found: Iterable[tuple[s.Term, s.Term]]) -> Scope:
        """The scope in which references are of the classes that memberships (reference, set) tell."""
        inner = scope
        for reference, carrier in found:
            try:
                left, right = known(self.term(reference, inner)), self.term(carrier, scope)
            except Wrong:
                continue  # told where it stands
            element = Open()
            if not self.unification.same(right, Power(element)):
                continue
            narrow = known(element)
            if isinstance(left, Open) or (isinstance(left, Objects) and left.grows and not left.classes):
                self.unification.same(left, narrow)
            elif isinstance(left, Objects) and isinstance(narrow, Objects) and not left.grows and not narrow.grows:
                both = {n: r for n, r in narrow.classes.items() if left.every or n in left.classes}
                if both and not narrow.every and (left.every or len(both) < len(left.classes)):
                    inner = Scope(inner) if inner is scope else inner
                    inner.names[key(reference) or ""] = Value(Objects(both, narrow.common, written=narrow.written))
        return inner

    # --- all terms --------------------------------------------------------------------------------------------

    def term(self, node: s.Term, scope: Scope) -> ObjectZType:
        """The type of a term; a predicate has that of truth values.

        Raises:
            Wrong: something in it is wrong.
        """
        match node:
            case s.Grouped():
                return self.term(node.inner, scope)
            case s.Reference():
                return self._reference(node, scope)
            case s.Number():
                return NUMBER
            case s.Truth():
                return TRUTH
            case s.Chain():
                return self._chain(node, scope)
            case s.Operator():
                return self._operator(node, scope)
            case s.Application():
                return self._application(node, scope)
            case s.Selection():
                return self._selection(node, scope)
            case s.Display():
                return self._display(node, scope)
            case s.BindingDisplay():
                return bindings({name.name: self.term(value, scope) for name, value in node.fields})
            case s.Binding():
                return self._binding(node, scope)
            case s.SchemaText():
                return Power(bindings(self.schemas.text(node, scope)))
            case s.Renamed():
                return self._renamed(node, scope)
            case s.Quantified():
                return self._quantified(node, scope)
            case s.Conditional():
                self.predicate(node.test, scope)
                then = self.term(node.then, self.narrowed(scope, facts(node.test)))
                otherwise = self.term(node.otherwise, scope)
                return self._joined(then, otherwise, node.span)
            case s.Local():
                inner = Scope(scope)
                for name, value in node.definitions:
                    inner.names[name.name] = Value(self.term(value, scope), name.span)
                return self.term(node.body, inner)
        raise TypeError(f"not a term: {node!r}")

    def must(self, found: ObjectZType, wanted: ObjectZType, span: Span) -> None:
        """Make two types the same.

        Raises:
            Wrong: they differ.
        """
        if not self.unification.same(found, wanted):
            raise Wrong(type_messages.types_differ(*shown_apart(found, wanted), span))

    def _joined(self, left: ObjectZType, right: ObjectZType, span: Span) -> ObjectZType:
        found = self.unification.joined(left, right)
        if found is None:
            raise Wrong(type_messages.types_differ(shown(left), shown(right), span))
        return found

    # --- names ------------------------------------------------------------------------------------------------

    def _reference(self, node: s.Reference, scope: Scope) -> ObjectZType:
        name = node.name + node.decoration
        entry = scope.find(name)
        if entry is None and node.decoration:
            schema = scope.find(node.name)
            value = None if schema is None else self.entry_type(schema, node, scope)
            if isinstance(found := None if value is None else known(value), Power):
                element = known(found.element)
                if isinstance(element, Bindings):  # S'
                    return Power(bindings({n + node.decoration: t for n, t in element.fields}))
        if entry is None:
            found_type = self._toolkit_name(node)
            if found_type is not None:
                return found_type
            raise Wrong(type_messages.unknown_name(name, node.span, suggestions(name, scope.known())))
        return self.entry_type(entry, node, scope)

    def _toolkit_name(self, node: s.Reference) -> ObjectZType | None:
        if node.decoration:
            return None
        if node.name == "oid":
            return Power(Objects(every=True))
        return name_type(node.name)

    def entry_type(self, entry: Entry, node: s.Reference, scope: Scope) -> ObjectZType:
        """The type of a name where it is used.

        Raises:
            Wrong: its parameters do not match.
        """
        if isinstance(entry, Deferred):
            made = entry.make()
            entry = Value(Open()) if made is None else made
        if isinstance(entry, ClassName):
            names = self.classes.parameters(entry.name)
            arguments = self._arguments(node, [f"{entry.name}.{n}" for n in names], scope)
            reference = ClassReference(entry.name, tuple(arguments.values()))
            return Power(Objects({entry.name: reference}, {entry.name: reference}))
        if entry.generics or node.arguments:
            return substituted(entry.type, self._arguments(node, entry.generics, scope))
        return entry.type

    def _arguments(self, node: s.Reference, names: Sequence[str], scope: Scope) -> dict[str, ObjectZType]:
        """What stands for the parameters of a generic name; what is left out is open."""
        if node.arguments:
            if len(node.arguments) != len(names):
                raise Wrong(type_messages.generic_arguments(node.name, len(names), len(node.arguments), node.span))
            return {name: self.element(a, scope) for name, a in zip(names, node.arguments, strict=True)}
        found: dict[str, ObjectZType] = {}
        for name in names:
            variable = Open(what=node.name)
            self.uses.append((variable, node.name, node.span))
            found[name] = variable
        return found

    # --- operators --------------------------------------------------------------------------------------------

    def _chain(self, node: s.Chain, scope: Scope) -> ObjectZType:
        types = [self.term(operand, scope) for operand in node.operands]
        for i, relation in enumerate(node.relations):
            span = node.operands[i].span.to(node.operands[i + 1].span)
            left, right = types[i], types[i + 1]
            if relation.startswith(INREL):
                written = relation.removeprefix(INREL)
                plain = written.rstrip("'?!")
                stroke: s.Decoration = written[len(plain) :]  # type: ignore[assignment]
                relation_type = self._reference(s.Reference(span=span, name=plain, decoration=stroke), scope)
                self.must(relation_type, pairs(left, right), span)
                continue
            if relation in ("equal", "not_equal"):
                self._equal(left, right, span)
                continue
            operands, _ = operator_type(relation) or ([Open(), Open()], TRUTH)
            for found, wanted in zip((left, right), operands, strict=True):
                if not self.unification.same(found, wanted):
                    raise Wrong(self._unrelated(relation, left, right, span))
        return TRUTH

    def _equal(self, left: ObjectZType, right: ObjectZType, span: Span) -> None:
        if not self.unification.same(left, right):
            differs = self.classes.difference(left, right, span)
            raise Wrong(differs or type_messages.types_differ(*shown_apart(left, right), span))

    def _unrelated(self, relation: str, left: ObjectZType, right: ObjectZType, span: Span) -> Diagnostic:
        if relation in ("in", "notin"):
            found = known(right)
            if not isinstance(found, Power):
                return type_messages.no_set(shown(right), span)
            differs = self.classes.difference(left, found.element, span)
            return differs or type_messages.types_differ(*shown_apart(left, found.element), span, member=True)
        return type_messages.types_differ(*shown_apart(left, right), span)

    def _operator(self, node: s.Operator, scope: Scope) -> ObjectZType:
        if is_logical(node):
            return self._logical(node, scope)
        match node.name, node.operands:
            case "cross", operands:
                return Power(Product(tuple([self.element(operand, scope) for operand in operands])))
            case "poly", (operand,):
                return Power(self.classes.poly(self._class(operand, "`poly`", scope), node.span))
            case "contained", (operand,):
                return Power(self._class(operand, "an object that is contained", scope))
            case "union", (left, right):
                one, other = self.term(left, scope), self.term(right, scope)
                sets = [known(type_) for type_ in (one, other)]
                elements = [known(type_.element) if isinstance(type_, Power) else None for type_ in sets]
                if any(isinstance(element, Objects) for element in elements):
                    return self._union(node, (one, other))
                return self._applied("union", node, [one, other])
            case "concat", (left, right):
                types = [self.term(left, scope), self.term(right, scope)]
                if known(types[1]) != NUMBER:
                    return self._applied("concat", node, types)
                field = Open()  # the iterate of a relation
                self.must(types[0], pairs(field, field), left.span)
                return types[0]
            case "diff" | "filter" | "compose" | "pipe", (left, right):
                first = self.term(left, scope)
                schema = self.schemas.components(first)
                if schema is not None:
                    return Power(bindings(self.schemas.combined(node.name, schema, right, scope, node.span)))
                return self._applied(node.name, node, [first, self.term(right, scope)])
        return self._applied(node.name, node, [self.term(operand, scope) for operand in node.operands])

    def _applied(self, name: str, node: s.Operator, types: list[ObjectZType]) -> ObjectZType:
        signature = operator_type(name)
        if signature is None:
            raise Wrong(type_messages.no_operator_here(name, node.span))
        operands, value = signature
        for found, wanted, operand in zip(types, operands, node.operands, strict=True):
            if not self.unification.same(found, wanted):
                if len(types) == 2 and types[0] is not found and operands[0] == operands[1]:
                    raise Wrong(type_messages.types_differ(shown(types[0]), shown(found), node.span))
                raise Wrong(type_messages.wrong_operand(_needed(wanted), shown(found), operand.span))
        return value

    def _class(self, operand: s.Term, what: str, scope: Scope) -> Objects:
        """The objects of a class that an operator needs."""
        operand = s.bare(operand)
        element = self.element(operand, scope)
        if isinstance(element, Open):
            objects = Objects(grows=True)
            self.unification.same(element, objects)
            return objects
        poly = isinstance(operand, s.Operator) and operand.name == "poly"
        if not isinstance(element, Objects) or (poly and what == "`poly`"):
            raise Wrong(messages.no_class(what, print_term(operand), operand.span))
        return element

    def _union(self, node: s.Operator, types: tuple[ObjectZType, ObjectZType]) -> ObjectZType:
        elements = []
        for type_, operand in zip(types, node.operands, strict=True):
            element: ObjectZType = Open()
            if not self.unification.same(type_, Power(element)):
                raise Wrong(type_messages.no_set(shown(type_), operand.span))
            if not isinstance(known(element), Objects | Open):
                raise Wrong(messages.no_class("a union of classes", print_term(operand), operand.span))
            elements.append(known(element))
        left, right = elements
        if not (isinstance(left, Objects) and isinstance(right, Objects)):
            self.must(left, right, node.span)
            return types[0]
        joined = self.unification.joined(left, right)
        self.classes.check_union(left, right, node.span)
        if joined is None:
            differs = self.classes.difference(left, right, node.span)
            raise Wrong(differs or type_messages.types_differ(shown(left), shown(right), node.span))
        return Power(joined)

    def _logical(self, node: s.Operator, scope: Scope) -> ObjectZType:
        """``and``, ``or``, ``=>``, ``<=>``, ``not``, of predicates or of schemas."""
        inner = [scope] * len(node.operands)
        if node.name == "and":
            inner = [self.narrowed(scope, facts(node))] * 2
        elif node.name == "implies":
            inner[1] = self.narrowed(scope, facts(node.operands[0]))
        elif node.name == "iff":
            inner = [self.narrowed(scope, [f for operand in node.operands for f in facts(operand)])] * 2
        types = [self.term(operand, place) for operand, place in zip(node.operands, inner, strict=True)]
        schemas = [self.schemas.components(type_) for type_ in types]
        if all(schema is not None for schema in schemas):
            merged: dict[str, ObjectZType] = {}
            for schema in schemas:
                self.schemas.merge(merged, schema or {}, node.span)
            return Power(bindings(merged))
        for type_, operand, place in zip(types, node.operands, inner, strict=True):
            found = known(type_)
            if isinstance(found, Power) and isinstance(known(found.element), Bindings):
                self.schemas.said(found, place, operand.span)
            elif not self.unification.same(type_, TRUTH):
                raise Wrong(type_messages.no_predicate(shown(type_), operand.span))
        return TRUTH

    # --- applications and selections --------------------------------------------------------------------------

    def _application(self, node: s.Application, scope: Scope) -> ObjectZType:
        function = node.function
        if isinstance(function, s.Reference) and not function.decoration and scope.find(function.name) is None:
            if function.name in ("Delta", "Xi", "pre", "theta"):
                return self.schemas.prefixed(function.name, node.argument, scope)
            if not is_toolkit_name(function.name):
                raise Wrong(
                    type_messages.unknown_name(function.name, function.span, suggestions(function.name, scope.known()))
                )
        found = self.term(function, scope)
        argument = self.term(node.argument, scope)
        domain, value = Open(), Open()
        if not self.unification.same(found, pairs(domain, value)):
            raise Wrong(type_messages.not_applicable(shown(found), function.span))
        if not self.unification.same(domain, argument):
            raise Wrong(type_messages.types_differ(shown(argument), shown(domain), node.argument.span))
        return known(value)

    def _selection(self, node: s.Selection, scope: Scope) -> ObjectZType:
        path = key(node)
        narrowed = None if path is None else scope.find(path)
        if isinstance(narrowed, Value):
            return narrowed.type
        record = known(self.term(node.record, scope))
        name = node.field + node.decoration
        match record:
            case Objects():
                return TRUTH if name == "INIT" else self.classes.selected(record, name, node.span)
            case Bindings(fields):
                found = dict(fields).get(name)
                if name == "INIT" and found is None:
                    return TRUTH
                if found is None:
                    raise Wrong(
                        type_messages.no_such_field(name, shown(record), node.span, suggestions(name, dict(fields)))
                    )
                return found
            case Product(items) if name.isdigit() and 1 <= int(name) <= len(items):
                return items[int(name) - 1]
        raise Wrong(type_messages.field_of_no_record(name, shown(record), node.span))

    def _renamed(self, node: s.Renamed, scope: Scope) -> ObjectZType:
        found = known(self.term(node.term, scope))
        element = known(found.element) if isinstance(found, Power) else None
        pairs_ = [(new.name + new.decoration, old.name + old.decoration) for new, old in node.renamings]
        for number, (_, old) in enumerate(pairs_):
            if old in [name for _, name in pairs_[:number]]:
                raise Wrong(messages.duplicate_renaming(old, node.renamings[number][1].span))
        if isinstance(element, Bindings):
            merged: dict[str, ObjectZType] = {}
            new = {old: fresh for fresh, old in pairs_}
            for name, type_ in element.fields:
                self.schemas.merge(merged, {new.get(name, name): type_}, node.span)
            return Power(bindings(merged))
        if isinstance(element, Objects):
            return Power(self.classes.renamed(element, pairs_))
        raise Wrong(type_messages.no_schema(shown(found), node.span))

    # --- displays and binders ---------------------------------------------------------------------------------

    def _display(self, node: s.Display, scope: Scope) -> ObjectZType:
        types = [self.term(item, scope) for item in node.items]
        if node.kind == "tuple":
            return Product(tuple(types))
        element: ObjectZType = types[0] if types else Open()
        for type_, item in zip(types[1:], node.items[1:], strict=True):
            element = self._joined(element, type_, item.span)
        if node.kind == "set":
            return Power(element)
        return sequence(element) if node.kind == "sequence" else pairs(element, NUMBER)

    def bound(self, declarations: Sequence[s.Declare], scope: Scope) -> tuple[Scope, list[ObjectZType]]:
        """The scope inside a binder, and what the parts of its characteristic tuple are of.

        Raises:
            Wrong: a carrier is no set, or a name is declared twice.
        """
        inner = Scope(scope)
        parts: list[ObjectZType] = []
        for declaration in declarations:
            if not declaration.names:
                schema = self.schemas.of(declaration.carrier, scope)
                parts.append(bindings(schema))
                inner.names.update({name: Value(type_, declaration.span) for name, type_ in schema.items()})
                continue
            type_ = self.element(declaration.carrier, scope)
            for declared in declaration.names:
                name = declared.name + declared.decoration
                if name in inner.names:
                    raise Wrong(type_messages.bound_twice(name, declared.span))
                inner.names[name] = Value(type_, declared.span)
                parts.append(type_)
        return inner, parts

    def _binding(self, node: s.Binding, scope: Scope) -> ObjectZType:
        inner, parts = self.bound(node.declarations, scope)
        characteristic = parts[0] if len(parts) == 1 else Product(tuple(parts))
        if node.condition is not None:
            inner = self.narrowed(inner, facts(node.condition))
            self.predicate(node.condition, inner)
        body = characteristic if node.body is None else self.term(node.body, inner)
        if node.kind == "set":
            return Power(body)
        if node.kind == "mu":
            return body
        if node.body is None:
            raise Wrong(type_messages.lambda_without_body(node.span))
        return pairs(characteristic, body)

    def _quantified(self, node: s.Quantified, scope: Scope) -> ObjectZType:
        inner, _ = self.bound(node.declarations, scope)
        if node.condition is not None:
            inner = self.narrowed(inner, facts(node.condition))
            self.predicate(node.condition, inner)
        type_ = self.term(node.body, inner)
        schema = self.schemas.components(type_)
        if schema is not None:
            hidden = [d.name + d.decoration for declaration in node.declarations for d in declaration.names]
            if any(name in schema for name in hidden):
                return Power(bindings({name: part for name, part in schema.items() if name not in hidden}))
            self.schemas.said(Power(bindings(schema)), inner, node.body.span)
        elif not self.unification.same(type_, TRUTH):
            raise Wrong(type_messages.no_predicate(shown(type_), node.body.span))
        return TRUTH

    # --- the end ----------------------------------------------------------------------------------------------

    def determined(self) -> None:
        """Report generic names whose parameters nothing has told."""
        for variable, name, span in self.uses:
            if is_open(variable):
                self.report(messages.parameters_open(name, span))
        self.uses.clear()


def _needed(type_: ObjectZType) -> str:
    """What an operand must be, in words."""
    type_ = known(type_)
    if type_ == NUMBER:
        return "a number"
    if isinstance(type_, Power):
        element = known(type_.element)
        if isinstance(element, Product):
            return "a sequence" if known(element.items[0]) == NUMBER else "a relation"
        return "a set"
    return "a value of another type"


def given(name: str) -> Power:
    """A given set of the document."""
    return Power(Given(name))
