"""From trees to typed terms: names are tied, types inferred, coercions made explicit.

Types flow from the inside out; where a collection without elements leaves something open, the term beside it says
what it is (:mod:`cspcheck.cspm.oz.typing.fitting`). Every mistake is a :class:`Wrong` with its diagnostic; whoever
asks for a predicate or a set decides how to go on.
"""

from __future__ import annotations

from collections.abc import MutableMapping, Sequence
from dataclasses import replace
from itertools import count
from typing import Final

from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import (
    BOOL,
    INT,
    REAL,
    Apply,
    BagType,
    Binder,
    Constant,
    FunctionType,
    SequenceType,
    SetType,
    Term,
    TupleType,
    Type,
    Variable,
)
from cspcheck.cspm.oz.reading.operators import FUNCTIONS, INREL
from cspcheck.cspm.oz.typing import type_messages as messages
from cspcheck.cspm.oz.typing.everyday import (
    by_pairs,
    constructed_from,
    constructor_function,
    is_by_pairs,
    is_iteration,
    iterated,
    pair,
)
from cspcheck.cspm.oz.typing.fitting import UNKNOWN, Misfit, fit, join, unknown_in
from cspcheck.cspm.oz.typing.forms import constructor, dotted, interval, is_schema, row, settled
from cspcheck.cspm.oz.typing.schemas import WORDS as SCHEMA_WORDS, Schemas
from cspcheck.cspm.oz.typing.scopes import (
    AmbiguousEntry,
    ClassEntry,
    ConstructorEntry,
    FailedEntry,
    GenericEntry,
    ObjectEntry,
    ParameterEntry,
    PredicatePlace,
    SetEntry,
    StateEntry,
    TypingScope,
    VariableEntry,
    named,
)
from cspcheck.cspm.oz.typing.selecting import (
    attribute,
    has_objects,
    made_record,
    names_apart,
    of_object_after,
    pool_in,
    qualified,
    selected,
)
from cspcheck.cspm.oz.typing.typing_operators import (
    RULES,
    Wrong,
    alike,
    as_function,
    as_set,
    coerced,
    element_of,
    must_be,
    numbers,
    partition,
    toolkit_function,
)
from cspcheck.cspm.oz.writing.printer import print_term
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

TRUE: Final = Constant(type=BOOL, value=True)


class Typing:
    """Elaborates the terms of one specification.

    Args:
        records: what schemas have been declared, by name; grows while the specification is elaborated.
    """

    def __init__(self, records: MutableMapping[str, core.RecordDefinition]) -> None:
        self._records = records
        self._fresh = count(1)
        self._instances: dict[tuple[int, tuple[Term, ...]], Term] = {}
        self.identified: dict[str, Span] = {}
        """The classes whose objects are values somewhere."""
        self.schemas = Schemas(self, records)

    # --- what is asked for ------------------------------------------------------------------------------------

    def predicate(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        """A predicate, with nothing about its types left open.

        Raises:
            Wrong: it is no predicate, or something in it is wrong.
        """
        return settled(self._predicate(node, scope, place))

    def expression(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        """An expression, whatever its type.

        Raises:
            Wrong: something in it is wrong, or its type stays open.
        """
        return settled(self._term(node, scope, place))

    def open_expression(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        """An expression whose type may stay open, to be fitted to one.

        Raises:
            Wrong: something in it is wrong.
        """
        return self._term(node, scope, place)

    def carrier(self, node: s.Term, scope: TypingScope) -> Term:
        """A set of values that a declaration names.

        Raises:
            Wrong: it is no set.
        """
        return settled(self._set(node, scope, "axiom"))

    def binders(
        self, declarations: Sequence[s.Declare], scope: TypingScope, place: PredicatePlace
    ) -> tuple[tuple[Binder, ...], TypingScope]:
        """The bound variables that declarations introduce, and the scope inside.

        Raises:
            Wrong: a carrier is no set, or a name is declared twice.
        """
        inner = TypingScope(scope)
        found: list[Binder] = []
        for declaration in declarations:
            if not declaration.names:
                raise Wrong(messages.no_schema_here(declaration.span))
            carrier = settled(self._set(declaration.carrier, scope, place))
            assert isinstance(carrier.type, SetType)
            for name in declaration.names:
                if inner.own(name.name) is not None:
                    raise Wrong(messages.bound_twice(name.name, name.span))
                unique = f"{name.name}%{next(self._fresh)}"
                found.append(Binder(unique, carrier.type.element, carrier, name.name))
                variable = Variable(type=carrier.type.element, name=unique, role="bound", span=name.span)
                inner.add(name.name, VariableEntry(variable, name.span))
        return tuple(found), inner

    def local(self, scope: TypingScope, name: s.Declared, value: s.Term, place: PredicatePlace) -> TypingScope:
        """The scope in which a name stands for a value.

        Raises:
            Wrong: something in the value is wrong.
        """
        inner = TypingScope(scope)
        inner.add(name.name, VariableEntry(self._term(value, scope, place), name.span))
        return inner

    def _binder(self, name: str, type_: Type, carrier: Term) -> Binder:
        return Binder(f"{name}%{next(self._fresh)}", type_, carrier, name)

    # --- predicates -------------------------------------------------------------------------------------------

    def _predicate(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        term = self._term(node, scope, place)
        if is_schema(term):
            return self.schemas.predicate(self.schemas.needed(node, scope), scope, place, node.span)
        if term.type != BOOL:
            raise Wrong(messages.no_predicate(str(term.type), node.span))
        return term

    def _chain(self, node: s.Chain, scope: TypingScope, place: PredicatePlace) -> Term:
        apart = names_apart(node, scope)
        if apart is not None:
            return apart
        operands = [self._term(operand, scope, place) for operand in node.operands]
        links = []
        for i, relation in enumerate(node.relations):
            span = node.operands[i].span.to(node.operands[i + 1].span)
            left, right = operands[i : i + 2]
            if relation.startswith(INREL):
                relation, left, right = "in", pair(left, right, span), self._term(named(relation, span), scope, place)
            links.append(self._related(relation, left, right, span))
        return core.conjunction(tuple(links), node.span)

    def _related(self, relation: str, left: Term, right: Term, span: Span) -> Term:
        if relation in ("notin", "not_equal"):
            positive = self._related("in" if relation == "notin" else "equal", left, right, span)
            return Apply(type=BOOL, operator="not", operands=(positive,), span=span)
        if relation in ("greater", "at_least"):
            return self._related("less" if relation == "greater" else "at_most", right, left, span)
        if relation in ("less", "at_most"):
            left, right = numbers(left, right, span)
        elif relation == "in":
            if is_by_pairs(left.type, right):
                return by_pairs(left, right, self._binder, span)
            left, right = self._member(left, right, span)
        elif relation in ("prefix", "suffix", "infix"):
            left, right = alike(left, right, span)
            must_be(left, SequenceType, "a sequence", span)
        elif relation == "in_bag":
            bag = must_be(right, BagType, "a bag", span)
            assert isinstance(bag.type, BagType)
            left = coerced(left, bag.type.element, span)
        elif relation == "partition":
            return partition(left, right, span)
        else:
            left, right = alike(left, right, span)
            if relation in ("subset", "proper_subset"):
                left, right = as_set(left, span), as_set(right, span)
        return Apply(type=BOOL, operator=relation, operands=(left, right), span=span)

    def _member(self, left: Term, right: Term, span: Span) -> tuple[Term, Term]:
        right = as_set(right, span)
        assert isinstance(right.type, SetType)
        element = join(left.type, right.type.element)
        if element is None:
            raise Wrong(messages.types_differ(str(left.type), str(right.type.element), span, member=True))
        try:
            if isinstance(right.type.element, core.IntType) and element == REAL:
                return fit(left, REAL), fit(right, SetType(REAL))
            # A sequence in a set of functions, or a function in a set of relations: the element is coerced.
            return fit(left, right.type.element if not unknown_in(right.type) else element), (
                fit(right, SetType(element)) if unknown_in(right.type) else right
            )
        except Misfit as misfit:
            raise Wrong(messages.types_differ(str(left.type), str(misfit.wanted), span, member=True)) from None

    # --- all terms --------------------------------------------------------------------------------------------

    def _term(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        match node:
            case s.Grouped():
                return self._term(node.inner, scope, place)
            case s.Reference():
                return self._reference(node, scope, place)
            case s.Number():
                return Constant(type=INT if isinstance(node.value, int) else REAL, value=node.value, span=node.span)
            case s.Truth():
                return Constant(type=BOOL, value=node.value, span=node.span)
            case s.Chain():
                return self._chain(node, scope, place)
            case s.Operator():
                return self._operator(node, scope, place)
            case s.Application():
                return self._application(node, scope, place)
            case s.Selection():
                return self._selection(node, scope, place)
            case s.Display():
                return self._display(node, scope, place)
            case s.BindingDisplay():
                return self._record(node, scope, place)
            case s.Binding():
                return self._comprehension(node, scope, place)
            case s.SchemaText():
                return self.schema(node, scope)
            case s.Renamed():
                return self.schema(node, scope)
            case s.Quantified():
                binders, inner, included = self._bound(node.declarations, scope, place)
                condition = TRUE if node.condition is None else self._predicate(node.condition, inner, place)
                condition = condition if included is None else core.conjunction((included, condition), node.span)
                body = self._predicate(node.body, inner, place)
                return core.Quantifier(
                    type=BOOL, kind=node.kind, binders=binders, condition=condition, body=body, span=node.span
                )
            case s.Conditional():
                test = self._predicate(node.test, scope, place)
                then = self._term(node.then, scope, place)
                otherwise = self._term(node.otherwise, scope, place)
                then, otherwise = alike(then, otherwise, node.span)
                return core.If(type=then.type, test=test, then=then, otherwise=otherwise, span=node.span)
            case s.Local():
                inner = TypingScope(scope)
                for name, value in node.definitions:
                    inner.add(name.name, VariableEntry(self._term(value, scope, place), name.span))
                return self._term(node.body, inner, place)
        raise TypeError(f"not a term: {node!r}")

    def _set(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        return as_set(self._term(node, scope, place), node.span)

    def _bound(
        self, declarations: Sequence[s.Declare], scope: TypingScope, place: PredicatePlace
    ) -> tuple[tuple[Binder, ...], TypingScope, Term | None]:
        """The variables of a quantifier or comprehension, the scope inside, and what schemas among them say."""
        if all(declaration.names for declaration in declarations):
            return *self.binders(declarations, scope, place), None
        return self.schemas.binders(self.schemas.declared(declarations, scope), scope)

    def schema(self, node: s.Term, scope: TypingScope, name: str | None = None) -> Term:
        """A schema expression as the set of its bindings; without a *name* it is known by what it says.

        Raises:
            Wrong: it is no schema, or something in it is wrong.
        """
        return self.schemas.named(name or print_term(node), self.schemas.needed(node, scope), node.span)

    def instance(self, node: s.Reference, scope: TypingScope) -> Term | None:
        """A generic abbreviation or schema with its actual parameters; None if the name is none."""
        entry = scope.find(node.name)
        return self._instance(node, entry, scope) if isinstance(entry, GenericEntry) else None

    def _reference(self, node: s.Reference, scope: TypingScope, place: PredicatePlace) -> Term:
        if node.decoration:
            # A component of a schema has its decoration in its name.
            component = scope.find(node.name + node.decoration)
            if isinstance(component, VariableEntry):
                return replace(component.term, span=node.span)
            if isinstance(component, ParameterEntry) and node.decoration == "'":
                return Variable(type=component.type, name=component.name, role="simple", span=node.span)
            if place != "effect" and isinstance(scope.find(node.name), SetEntry):
                schema = self.schemas.value(node, scope)
                if schema is not None:
                    return self.schemas.named(node.name + node.decoration, schema, node.span)
        if node.decoration in ("?", "!"):
            return self._parameter(node, scope, place)
        entry = scope.find(node.name)
        if node.decoration == "'":
            return self._primed(node, entry, scope, place)
        match entry:
            case StateEntry():
                return Variable(type=entry.type, name=entry.name, role="before", span=node.span)
            case ParameterEntry():
                return Variable(type=entry.type, name=entry.name, role="simple", span=node.span)
            case VariableEntry():
                return replace(entry.term, span=node.span)
            case SetEntry():
                return replace(entry.term, span=node.span) if entry.term.span is None else entry.term
            case ConstructorEntry(carrier=None):
                return core.Construct(type=entry.type, constructor=entry.name, span=node.span)
            case ConstructorEntry():
                raise Wrong(messages.constructor_without_argument(entry.name, node.span))
            case GenericEntry():
                return self._instance(node, entry, scope)
            case ObjectEntry():
                raise Wrong(messages.object_is_no_value(node.name, node.span, entry.span))
            case ClassEntry(identities=set_) if set_ is not None and not node.arguments:
                self.identified.setdefault(node.name, entry.span)
                return replace(set_, span=node.span)
            case ClassEntry():
                raise Wrong(messages.class_is_no_value(node.name, node.span, entry.span))
            case AmbiguousEntry():
                raise Wrong(messages.ambiguous_variable(node.name, entry.choices, node.span))
            case FailedEntry():
                raise Wrong(entry.diagnostic)
        parameter = scope.parameter(node.name)
        if parameter is not None:
            decorated = node.name + ("?" if parameter.kind == "input" else "!")
            raise Wrong(messages.parameter_without_decoration(node.name, decorated, node.span))
        if node.name in FUNCTIONS:
            raise Wrong(messages.function_without_argument(node.name, node.span))
        raise Wrong(messages.unknown_name(node.name, node.span, suggestions(node.name, [*scope.names(), *FUNCTIONS])))

    def _parameter(self, node: s.Reference, scope: TypingScope, place: PredicatePlace) -> Term:
        written = node.name + node.decoration
        if place in ("initial", "invariant", "axiom", "record", "retrieve"):
            raise Wrong(messages.parameter_out_of_place(written, place, node.span))
        failed = scope.find(written)
        if isinstance(failed, FailedEntry):
            raise Wrong(failed.diagnostic)
        kind: core.ParameterKind = "input" if node.decoration == "?" else "output"
        found = scope.parameter(node.name, kind)
        entry = found or scope.parameter(node.name)
        if entry is None or found is None:
            other = None if entry is None else node.name + ("?" if entry.kind == "input" else "!")
            near = suggestions(written, scope.parameters()) if other is None else (other,)
            if not near and scope.find(node.name) is not None:
                near = (node.name,)
            raise Wrong(messages.unknown_parameter(written, node.span, near))
        if place == "guard" and kind == "output":
            raise Wrong(messages.output_in_guard(written, node.span))
        return Variable(type=entry.type, name=entry.name, role=kind, span=node.span)

    def _primed(self, node: s.Reference, entry: object, scope: TypingScope, place: PredicatePlace) -> Term:
        written = node.name + "'"
        if isinstance(entry, FailedEntry):
            raise Wrong(entry.diagnostic)
        if isinstance(entry, StateEntry):
            if place != "effect":
                raise Wrong(messages.prime_out_of_place(written, place, node.span))
            return Variable(type=entry.type, name=entry.name, role="after", span=node.span)
        if entry is None:
            states = [name for name in scope.names() if isinstance(scope.find(name), StateEntry)]
            raise Wrong(messages.unknown_name(written, node.span, [n + "'" for n in suggestions(node.name, states)]))
        raise Wrong(messages.prime_on_no_state(written, node.span))

    def _instance(self, node: s.Reference, entry: GenericEntry, scope: TypingScope) -> Term:
        wanted = entry.abbreviation.generics
        if len(wanted) != len(node.arguments):
            raise Wrong(messages.generic_arguments(node.name, len(wanted), len(node.arguments), node.span))
        arguments = tuple([self.carrier(argument, scope) for argument in node.arguments])
        key = (id(entry.abbreviation), arguments)
        if key not in self._instances:
            inner = TypingScope(entry.scope)
            for name, argument in zip(wanted, arguments, strict=True):
                inner.add(name.name, SetEntry(argument, name.span))
            body = entry.abbreviation.body
            if self.schemas.value(body, inner) is not None:
                self._instances[key] = self.schema(body, inner, print_term(node))
            else:
                self._instances[key] = self.expression(body, inner, "axiom")
        return self._instances[key]

    # --- operators --------------------------------------------------------------------------------------------

    def _operator(self, node: s.Operator, scope: TypingScope, place: PredicatePlace) -> Term:
        name, span = node.name, node.span
        if name in ("and", "or"):
            operands = [self._predicate(operand, scope, place) for operand in row(node, name)]
            return Apply(type=BOOL, operator=name, operands=tuple(operands), span=span)
        if name in ("not", "implies", "iff"):
            predicates = tuple([self._predicate(operand, scope, place) for operand in node.operands])
            return Apply(type=BOOL, operator=name, operands=predicates, span=span)
        if name == "cross":
            sets = tuple([self._set(operand, scope, place) for operand in row(node, name)])
            items = tuple([element_of(operand) for operand in sets])
            return Apply(type=SetType(TupleType(items)), operator="cross", operands=sets, span=span)
        operands = [self._operand(operand, scope, place) for operand in node.operands]
        if name == "concat" and is_iteration(operands):
            return iterated(operands, span)
        rule = RULES.get(name)
        if rule is None:
            raise Wrong(messages.no_operator_here(name, span))
        return rule(name, operands, span)

    def _operand(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> Term:
        """An operand of an operator of the toolkit, where a constructor is a function."""
        entry = constructor(node, scope)
        if entry is None or entry.carrier is None:
            return self._term(node, scope, place)
        return constructor_function(entry.name, entry.type, entry.carrier, self._binder, node.span)

    # --- application ------------------------------------------------------------------------------------------

    def _application(self, node: s.Application, scope: TypingScope, place: PredicatePlace) -> Term:
        function = node.function
        function = s.bare(function)
        if isinstance(function, s.Reference) and function.decoration == "":
            entry = scope.find(function.name)
            if entry is None and function.name == "theta":
                return self.schemas.binding(node.argument, scope, place, node.span)
            if entry is None and function.name in SCHEMA_WORDS:
                return self.schema(node, scope)
            if isinstance(entry, ConstructorEntry):
                if entry.carrier is None:
                    raise Wrong(messages.constructor_with_argument(entry.name, node.span))
                argument = coerced(self._term(node.argument, scope, place), element_of(entry.carrier), node.span)
                return core.Construct(type=entry.type, constructor=entry.name, argument=argument, span=node.span)
            if entry is None and function.name in FUNCTIONS:
                return toolkit_function(function.name, self._term(node.argument, scope, place), node.span)
        if isinstance(function, s.Operator) and function.name == "inverse":
            made = constructor(function.operands[0], scope)
            if made is not None and made.carrier is not None:
                value = coerced(self._term(node.argument, scope, place), made.type, node.span)
                return constructed_from(made.name, made.type, made.carrier, value, self._binder, node.span)
        applied = self._term(function, scope, place)
        argument = self._term(node.argument, scope, place)
        match applied.type:
            case FunctionType(domain, range_):
                argument = coerced(argument, domain, node.span)
            case SequenceType(range_):
                argument = coerced(argument, INT, node.span)
            case BagType(element):
                range_ = INT
                argument = coerced(argument, element, node.span)
            case SetType(TupleType((domain, range_))):
                # A relation may be applied where it relates its argument to exactly one value.
                argument = coerced(argument, domain, node.span)
                applied = as_function(applied, node.span)
            case _:
                raise Wrong(messages.not_applicable(str(applied.type), node.function.span))
        return Apply(type=range_, operator="apply", operands=(applied, argument), span=node.span)

    def _selection(self, node: s.Selection, scope: TypingScope, place: PredicatePlace) -> Term:
        node = of_object_after(node, scope)
        of_class = qualified(node, scope)
        if of_class is not None:
            return of_class
        found = self.object(node.record, scope, place)
        if found is not None:
            return attribute(node, *found, scope, lambda r: self._reference(r, scope, place))
        record = self._term(node.record, scope, place)
        pool = pool_in(scope, record.type)
        if pool is not None:
            return attribute(node, pool, record, scope, lambda r: self._reference(r, scope, place))
        return selected(node, record, self._records)

    def object_value(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> tuple[ObjectEntry, Term] | None:
        """The objects of which a value is an identity, and that identity; None for other values.

        Raises:
            Wrong: something in the term is wrong.
        """
        identity = self._term(node, scope, place)
        pool = pool_in(scope, identity.type)
        return None if pool is None else (pool, identity)

    def object(self, node: s.Term, scope: TypingScope, place: PredicatePlace) -> tuple[ObjectEntry, Term | None] | None:
        """The object that a term names, with its identity if it is one of a family; None if it names none.

        Raises:
            Wrong: something in the term of the identity is wrong, or there is none where one is needed.
        """
        found = dotted(node)
        if found is None or not isinstance(scope.find(found[0].split(".")[0]), ObjectEntry):
            return self._within(node, scope, place)
        path, index = found
        entry = scope.find(path)
        if not isinstance(entry, ObjectEntry):
            return self._within(node, scope, place)  # perhaps an attribute whose value is an object
        if (index is None) != (entry.binder is None):
            raise Wrong(messages.no_such_object(print_term(node), node.span))
        if index is None or entry.binder is None:
            return entry, None
        return entry, coerced(self._term(index, scope, place), entry.binder.type, node.span)

    def _within(
        self, node: s.Term, scope: TypingScope, place: PredicatePlace
    ) -> tuple[ObjectEntry, Term | None] | None:
        """The object that an object has which is a value: ``d.lock`` for ``d : Door``."""
        if not isinstance(node, s.Selection) or not has_objects(scope, node.field):
            return None
        found = self.object_value(node.record, scope, place)
        entry = None if found is None else scope.find(f"{found[0].name}.{node.field}")
        return (entry, found[1]) if found is not None and isinstance(entry, ObjectEntry) else None

    # --- displays and comprehensions --------------------------------------------------------------------------

    def _display(self, node: s.Display, scope: TypingScope, place: PredicatePlace) -> Term:
        items = [self._term(item, scope, place) for item in node.items]
        if node.kind == "tuple":
            made: Type = TupleType(tuple([item.type for item in items]))
            return Apply(type=made, operator="tuple", operands=tuple(items), span=node.span)
        element = UNKNOWN
        for i, item in enumerate(items):
            joined = join(element, item.type)
            if joined is None:
                raise Wrong(messages.types_differ(str(element), str(item.type), node.items[i].span))
            element = joined
        fitted = tuple([coerced(item, element, node.span) for item in items])
        forms: dict[str, tuple[str, type[SetType] | type[SequenceType] | type[BagType]]] = {
            "set": ("set", SetType),
            "sequence": ("sequence", SequenceType),
            "bag": ("bag_display", BagType),
        }
        operator, form = forms[node.kind]
        made = form(element)
        return Apply(type=made, operator=operator, operands=fitted, span=node.span)

    def _record(self, node: s.BindingDisplay, scope: TypingScope, place: PredicatePlace) -> Term:
        given = {name.name: self._term(value, scope, place) for name, value in node.fields}
        return made_record(given, self._records, node.span)

    def _comprehension(self, node: s.Binding, scope: TypingScope, place: PredicatePlace) -> Term:
        binders, inner, included = self._bound(node.declarations, scope, place)
        condition = TRUE if node.condition is None else self._predicate(node.condition, inner, place)
        condition = condition if included is None else core.conjunction((included, condition), node.span)
        variables = tuple([Variable(type=b.type, name=b.name, role="bound", span=node.span) for b in binders])
        tuple_ = TupleType(tuple([b.type for b in binders])) if len(binders) > 1 else None
        characteristic: Term = (
            variables[0] if tuple_ is None else Apply(type=tuple_, operator="tuple", operands=variables, span=node.span)
        )
        body = characteristic if node.body is None else self._term(node.body, inner, place)
        made: Type
        if node.kind == "set":
            found = interval(binders, condition, body)
            if found is not None:
                return replace(found, span=node.span)
            made = SetType(body.type)
        elif node.kind == "lambda":
            if node.body is None:
                raise Wrong(messages.lambda_without_body(node.span))
            made = FunctionType(characteristic.type, body.type)
        else:
            made = body.type
        return core.Comprehension(
            type=made, kind=node.kind, binders=binders, condition=condition, body=body, span=node.span
        )
