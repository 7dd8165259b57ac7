"""Operations by their parameters, where objects are references."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects import messages
from cspcheck.cspm.oz.objects.narrowing import facts, operation_facts
from cspcheck.cspm.oz.objects.scopes import Scope, Value
from cspcheck.cspm.oz.objects.terms import Terms
from cspcheck.cspm.oz.objects.types import Objects, ObjectZType, known, shown, substituted
from cspcheck.cspm.oz.typing import messages as class_messages, type_messages
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

if TYPE_CHECKING:
    from cspcheck.cspm.oz.objects.classes import Classes, ClassShape

Signature = dict[str, ObjectZType]
"""The types of parameters by their decorated names."""


class Operations:
    """Types the operations of classes.

    An operation that is defined by itself has, in itself, no parameters yet: those that it gets otherwise are all that
    it has.
    """

    def __init__(self, classes: Classes, terms: Terms, report: Callable[[Diagnostic], None]) -> None:
        self._classes = classes
        self._terms = terms
        self._report = report
        self._found: dict[tuple[str, str], Signature] = {}
        self._waiting: list[tuple[str, str]] = []
        self._cut = -1  # the outermost operation in waiting that was asked for in itself

    def check(self, shape: ClassShape) -> None:
        """Type all operations of a class itself."""
        seen: dict[str, Span] = {}
        for tree in shape.tree.operations:
            if tree.name in seen or tree.name in shape.features:
                first = seen.get(tree.name) or shape.features[tree.name].span
                self._report(type_messages.declared_twice(tree.name, first, tree.span))
            seen[tree.name] = tree.span
        for name in self._classes.operation_names(shape.tree.name):
            self.signature(shape, name)

    def signature(self, shape: ClassShape, name: str) -> Signature:
        """The parameters of an operation of a class, those of its parents' operation of that name among them."""
        place = (shape.tree.name, name)
        if place in self._found:
            return self._found[place]
        if place in self._waiting:
            at = self._waiting.index(place)
            self._cut = at if self._cut < 0 else min(self._cut, at)
            return {}
        depth = len(self._waiting)
        self._waiting.append(place)
        found: Signature = {}
        try:
            for parent in self._classes.parents(shape):
                for inherited in self._classes.operation_names(parent.name):
                    if dict(parent.renaming).get(inherited, inherited) == name:
                        above = self._classes.shape(parent.name)
                        actual = dict(zip(above.parameters, parent.arguments, strict=False))
                        signature = self.signature(above, inherited)
                        self._inherited(found, {p: substituted(t, actual) for p, t in signature.items()}, shape, name)
            for tree in shape.tree.operations:
                if tree.name == name:
                    self._own(found, tree, shape)
        finally:
            self._waiting.pop()
        if self._cut < 0 or self._cut >= depth:
            self._found[place] = found
            self._cut = -1 if self._cut == depth else self._cut
        return found

    def _inherited(self, found: Signature, more: Signature, shape: ClassShape, name: str) -> None:
        for parameter, type_ in more.items():
            first = found.setdefault(parameter, type_)
            if not self._terms.unification.same(first, type_):
                span = shape.tree.span
                types = shown(type_), shown(first)
                self._report(class_messages.inherited_differently(parameter, name, *types, span, span))

    def _own(self, found: Signature, tree: s.OperationSchema | s.OperationDefinition, shape: ClassShape) -> None:
        scope = self._inside(shape, found)
        try:
            if isinstance(tree, s.OperationSchema):
                text = s.OperationText(
                    span=tree.span, delta=tree.delta, declarations=tree.declarations, predicates=tree.predicates
                )
                own = self._text(text, scope, shape)
            else:
                own = self._operation(tree.body, scope, shape)
            self._join(found, own, tree.span)
        except Wrong as wrong:
            self._report(wrong.diagnostic)

    def _inside(self, shape: ClassShape, inherited: Signature) -> Scope:
        """The scope of an operation: variables before and after it, and parameters that it inherits."""
        scope = Scope(shape.scope)
        for name in (*shape.primary, *shape.secondary):
            value = shape.features[name]
            scope.names[f"{name}'"] = value
        scope.names.update({name: Value(type_) for name, type_ in inherited.items()})
        return scope

    def merged(self, left: Signature, right: Signature, span: Span) -> Signature:
        """The parameters of both.

        Raises:
            Wrong: one has different types.
        """
        found = dict(left)
        self._join(found, right, span)
        return found

    def _join(self, found: Signature, more: Mapping[str, ObjectZType], span: Span) -> None:
        for name, type_ in more.items():
            first = found.setdefault(name, type_)
            if not self._terms.unification.same(first, type_):
                raise Wrong(messages.parameter_differs(name, shown(first), shown(type_), span))

    # --- expressions ------------------------------------------------------------------------------------------

    def _operation(self, node: s.Term, scope: Scope, shape: ClassShape) -> Signature:
        match node:
            case s.Grouped():
                return self._operation(node.inner, scope, shape)
            case s.OperationText():
                return self._text(node, scope, shape)
            case s.Reference(decoration="", arguments=()):
                names = self._classes.operation_names(shape.tree.name)
                if node.name not in names:
                    raise Wrong(class_messages.unknown_operation(node.name, node.span, suggestions(node.name, names)))
                return dict(self.signature(shape, node.name))
            case s.Selection():
                record = known(self._terms.term(node.record, scope))
                if not isinstance(record, Objects):
                    raise Wrong(messages.operation_of_no_object(node.field, shown(record), node.span))
                return dict(self._classes.operation(record, node.field, node.span))
            case s.Renamed():
                return self._renamed(node, scope, shape)
            case s.Distributed():
                return self._distributed(node, scope, shape)
            case s.Operator(name="hide", operands=(left, hidden)):
                return self._hidden(self._operation(left, scope, shape), hidden)
            case s.Operator(name="enrich", operands=(left, right)):
                first = self._operation(left, scope, shape)
                inner = Scope(scope, {name: Value(type_) for name, type_ in first.items()})
                inner = self._terms.narrowed(inner, operation_facts(node))
                return self.merged(first, self._operation(right, inner, shape), node.span)
            case s.Operator(name="and", operands=(left, right)):
                inner = self._terms.narrowed(scope, operation_facts(node))
                return self.merged(self._operation(left, inner, shape), self._operation(right, inner, shape), node.span)
            case s.Operator(operands=(left, right)):
                first, second = self._operation(left, scope, shape), self._operation(right, scope, shape)
                return self._communicating(node.name, first, second, node.span)
        raise Wrong(class_messages.operation_expression(node.span))

    def _text(self, node: s.OperationText, scope: Scope, shape: ClassShape) -> Signature:
        for name in node.delta or ():
            if name.name not in shape.primary:
                secondary = name.name in shape.secondary
                near = suggestions(name.name, shape.primary)
                self._report(class_messages.wrong_in_delta(name.name, name.span, secondary=secondary, suggested=near))
        declared = self._terms.declared(node.declarations, scope)
        self._terms.predicates(node.predicates, Scope(scope, declared))
        return {name: value.type for name, value in declared.items()}

    def _renamed(self, node: s.Renamed, scope: Scope, shape: ClassShape) -> Signature:
        inner = self._operation(node.term, scope, shape)
        new: dict[str, str] = {}
        for fresh, old in node.renamings:
            name = old.name + old.decoration
            if name in new:
                raise Wrong(messages.duplicate_renaming(name, old.span))
            new[name] = fresh.name + fresh.decoration
        found: Signature = {}
        for name, type_ in inner.items():
            self._join(found, {new.get(name, name): type_}, node.span)
        return found

    def _hidden(self, inner: Signature, hidden: s.Term) -> Signature:
        items = hidden.items if isinstance(hidden, s.Display) else (hidden,)
        names = []
        for item in items:
            if isinstance(item, s.Reference):
                name = item.name + item.decoration
                if name not in inner:
                    raise Wrong(messages.nothing_to_hide(name, item.span, list(inner)))
                names.append(name)
        return {name: type_ for name, type_ in inner.items() if name not in names}

    def _communicating(self, operator: str, left: Signature, right: Signature, span: Span) -> Signature:
        """Both operands; what one tells and the other hears is passed on."""
        passed: set[str] = set()
        ways = {"compose": [(left, right)], "parallel": [(left, right), (right, left)]}
        for teller, listener in ways.get("parallel" if operator == "parallel_open" else operator, []):
            for name in teller:
                base = name[:-1]
                # What an operation both tells and hears it does not hear from another.
                if not name.endswith("!") or f"{base}?" not in listener:
                    continue
                if operator != "compose" and f"{base}?" in teller and name in listener:
                    continue
                if not self._terms.unification.same(teller[name], listener[f"{base}?"]):
                    types = shown(teller[name]), shown(listener[f"{base}?"])
                    raise Wrong(messages.communication_differs(base, types, span))
                passed.add(f"{base}?")
                if operator != "parallel_open":
                    passed.add(name)
        if operator == "compose":
            for name in [n for n in left if n.endswith("'") and n[:-1] in right]:
                if not self._terms.unification.same(left[name], right[name[:-1]]):
                    types = shown(left[name]), shown(right[name[:-1]])
                    raise Wrong(messages.value_handed_on(name, types, span))
                passed.add(name)
                left = {n: t for n, t in left.items() if n != name}
                right = {n: t for n, t in right.items() if n != name[:-1]}
            first = {name: type_ for name, type_ in left.items() if not (name in passed and name.endswith("!"))}
            second = {name: type_ for name, type_ in right.items() if not (name in passed and name.endswith("?"))}
            return self.merged(first, second, span)
        both = self.merged(left, right, span)
        return {name: type_ for name, type_ in both.items() if name not in passed}

    def _distributed(self, node: s.Distributed, scope: Scope, shape: ClassShape) -> Signature:
        inner, _ = self._terms.bound(node.declarations, scope)
        if node.condition is not None:
            inner = self._terms.narrowed(inner, facts(node.condition))
            self._terms.predicate(node.condition, inner)
        found = self._operation(node.body, inner, shape)
        strokes = "?!" if node.kind in ("compose", "parallel") else ""
        for declaration in node.declarations:
            for declared in declaration.names:
                if (declared.name + declared.decoration).rstrip(strokes or "\0") in found:
                    raise Wrong(messages.bound_is_parameter(declared.name, declared.span))
        return found
