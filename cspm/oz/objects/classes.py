"""Classes by their features: attributes, variables and operations, of any depth of reference.

The features of a class are those of its parents, under the names that it gives them, and its own. A class is a type
before its features are known, so classes may refer to each other.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from cspcheck.cspm.diagnostics import Diagnostic
from cspcheck.cspm.oz import syntax as s
from cspcheck.cspm.oz.objects import messages
from cspcheck.cspm.oz.objects.operations import Operations, Signature
from cspcheck.cspm.oz.objects.paragraphs import Paragraphs
from cspcheck.cspm.oz.objects.scopes import Deferred, Scope, Value
from cspcheck.cspm.oz.objects.terms import Terms
from cspcheck.cspm.oz.objects.types import (
    ClassReference,
    Given,
    Objects,
    ObjectZType,
    Open,
    Power,
    known,
    shown,
    substituted,
)
from cspcheck.cspm.oz.typing import messages as class_messages, type_messages
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions


@dataclass
class ClassShape:
    """A class with what it inherits.

    Attributes:
        parameters: what its generic parameters are called in types.
        features: constants, types and variables by name.
        primary, secondary: which of them are variables.
        scope: inside the class.
    """

    tree: s.Class
    parameters: tuple[str, ...]
    scope: Scope
    features: dict[str, Value] = field(default_factory=dict)
    primary: dict[str, None] = field(default_factory=dict)
    secondary: dict[str, None] = field(default_factory=dict)

    def reference(self) -> ClassReference:
        """The class of `self`."""
        return ClassReference(self.tree.name, tuple([Given(name) for name in self.parameters]))


class Classes:
    """The classes of a document.

    Args:
        trees: by name.
        around: what is declared outside the classes.
    """

    def __init__(
        self, trees: Mapping[str, s.Class], around: Scope, terms: Terms, report: Callable[[Diagnostic], None]
    ) -> None:
        self.trees = trees
        self.terms = terms
        self.report = report
        self.operations = Operations(self, terms, report)
        self._around = around
        self._shapes: dict[str, ClassShape] = {}
        self._paragraphs: dict[str, Paragraphs] = {}
        self._declaring = True
        self._pending: list[Callable[[], None]] = []

    # --- all of them ------------------------------------------------------------------------------------------

    def declare(self) -> None:
        """Find the features of all classes."""
        for name in self.trees:
            self.shape(name)

    def declared(self) -> None:
        """All features are known: look at the unions and polymorphic sets that were declared."""
        self._declaring = False
        while self._pending:
            self._pending.pop(0)()

    def check(self, name: str) -> None:
        """Type the predicates and operations of a class; mistakes are reported."""
        tree, shape = self.trees[name], self.shape(name)
        for paragraph in tree.paragraphs:
            self._paragraphs[name].check(paragraph)
        if tree.state is not None:
            self.terms.predicates(tree.state.predicates, shape.scope)
        if tree.initial is not None:
            self.terms.predicates(tree.initial.predicates, shape.scope)
        self.operations.check(shape)
        known_names = {**shape.features, **dict.fromkeys(self.operation_names(name)), "INIT": None, "Init": None}
        for visible in tree.visibility or ():
            if visible.name not in known_names:
                near = suggestions(visible.name, known_names)
                self.report(class_messages.not_visible(visible.name, name, visible.span, near))

    def parameters(self, name: str) -> list[str]:
        """The generic parameters of a class."""
        return [generic.name for generic in self.trees[name].generics]

    # --- shapes -----------------------------------------------------------------------------------------------

    def shape(self, name: str) -> ClassShape:
        """A class with its features; as far as they are known, where they are being found."""
        if name in self._shapes:
            return self._shapes[name]
        tree = self.trees[name]
        parameters = tuple([f"{name}.{generic.name}" for generic in tree.generics])
        shape = ClassShape(tree, parameters, Scope(self._around))
        self._shapes[name] = shape
        for generic, parameter in zip(tree.generics, parameters, strict=True):
            shape.scope.names[generic.name] = Value(Power(Given(parameter)), generic.span)
        myself = {name: shape.reference()}
        shape.scope.names["self"] = Value(Objects(myself, myself), tree.span)
        for inherit in tree.inherits:
            self._inherit(shape, inherit)
        own: dict[str, Span] = {}
        paragraphs = self._paragraphs[name] = Paragraphs(self.terms, shape.scope, name)
        entries = [(n, e) for paragraph in tree.paragraphs for n, e in paragraphs.declare(paragraph).items()]
        inherited = dict(shape.features)
        for declared, entry in entries:
            shape.scope.names[declared] = entry
        for declared, entry in entries:
            value = entry.make() if isinstance(entry, Deferred) else entry
            if isinstance(value, Value):
                self._own(shape, own, inherited, declared, value)
        if tree.state is not None:
            for table, declarations in ((shape.primary, tree.state.primary), (shape.secondary, tree.state.secondary)):
                for declared, value in self.terms.declared(declarations, shape.scope).items():
                    self._own(shape, own, inherited, declared, value)
                    table[declared] = None
        return shape

    def _own(
        self, shape: ClassShape, own: dict[str, Span], inherited: Mapping[str, Value], name: str, value: Value
    ) -> None:
        """A feature that the class declares itself."""
        span = value.span or shape.tree.span
        if name in own or name == shape.tree.name:
            self.report(type_messages.declared_twice(name, own.get(name, shape.tree.span), span))
        own[name] = span
        first = inherited.get(name)
        if first is not None and not self.terms.unification.same(first.type, value.type):
            found = shown(value.type), shown(first.type)
            parents = " and ".join(parent.name for parent in shape.tree.inherits)
            self.report(class_messages.inherited_differently(name, parents, *found, span, first.span or span))
        shape.features[name] = value
        shape.scope.names[name] = value

    def _inherit(self, shape: ClassShape, inherit: s.Inherit) -> None:
        reference = self._parent(shape, inherit)
        if reference is None:
            return
        parent = self.shape(inherit.name)
        for name in parent.features:
            new = dict(reference.renaming).get(name, name)
            value = self._value(reference, name)
            first = shape.features.get(new)
            if first is not None and not self.terms.unification.same(first.type, value.type):
                types = shown(value.type), shown(first.type)
                self.report(
                    class_messages.inherited_differently(new, shape.tree.name, *types, inherit.span, inherit.span)
                )
                continue
            shape.features[new] = shape.scope.names[new] = value
            if name in parent.primary:
                shape.primary[new] = None
            if name in parent.secondary:
                shape.secondary[new] = None

    def _parent(self, shape: ClassShape, inherit: s.Inherit) -> ClassReference | None:
        if inherit.name not in self.trees:
            near = suggestions(inherit.name, self.trees)
            self.report(class_messages.unknown_class(inherit.name, inherit.span, near))
            return None
        wanted = len(self.trees[inherit.name].generics)
        if wanted != len(inherit.arguments):
            given = len(inherit.arguments)
            self.report(type_messages.generic_arguments(inherit.name, wanted, given, inherit.span))
            return None
        try:
            arguments = tuple([self.terms.element(argument, shape.scope) for argument in inherit.arguments])
        except Wrong as wrong:
            self.report(wrong.diagnostic)
            return None
        renaming = tuple([(old.name, new.name) for new, old in inherit.renamings])
        return ClassReference(inherit.name, arguments, renaming)

    def parents(self, shape: ClassShape) -> Iterator[ClassReference]:
        """The classes that a class inherits from, with actual parameters and new names."""
        for inherit in shape.tree.inherits:
            reference = self._parent(shape, inherit)
            if reference is not None:
                yield reference

    def _value(self, reference: ClassReference, name: str) -> Value:
        """A feature of a class by its own name, with actual parameters."""
        shape = self.shape(reference.name)
        value = shape.features[name]
        actual = dict(zip(shape.parameters, reference.arguments, strict=False))
        return Value(substituted(value.type, actual), value.span, value.generics)

    def operation_names(self, name: str, seen: frozenset[str] = frozenset()) -> dict[str, None]:
        """The operations of a class, inherited ones first."""
        tree = self.trees[name]
        found: dict[str, None] = {}
        for inherit in tree.inherits:
            if inherit.name in self.trees and inherit.name not in seen:
                new = {old.name: new.name for new, old in inherit.renamings}
                inherited = self.operation_names(inherit.name, seen | {name})
                found |= {new.get(operation, operation): None for operation in inherited}
        return found | {operation.name: None for operation in tree.operations}

    # --- features of objects ----------------------------------------------------------------------------------

    def _original(self, reference: ClassReference, name: str) -> str | None:
        """What a class itself calls a feature of a reference; None for a name that is renamed away."""
        for old, new in reference.renaming:
            if new == name:
                return old
        return None if name in dict(reference.renaming) else name

    def is_visible(self, name: str, feature: str) -> bool:
        """Whether a class shows a feature."""
        visible = self.trees[name].visibility
        return visible is None or any(v.name == feature for v in visible)

    def selected(self, objects: Objects, name: str, span: Span) -> ObjectZType:
        """The type of ``a.x``.

        Raises:
            Wrong: some object that *a* may be has no visible feature of that name.
        """
        if name == "self":
            return objects
        types = []
        for reference in objects.common.values():
            original = self._original(reference, name)
            shape = self.shape(reference.name)
            if original is None or original not in shape.features:
                visible = [n for n in shape.features if self.is_visible(reference.name, n)]
                raise Wrong(type_messages.no_such_field(name, shown(objects), span, suggestions(name, visible)))
            if not self.is_visible(reference.name, original):
                raise Wrong(messages.not_shown(name, reference.name, span))
            value = self._value(reference, original)
            opened: dict[str, ObjectZType] = {}
            for generic in value.generics:
                variable = Open(what=name)
                self.terms.uses.append((variable, name, span))
                opened[generic] = variable
            types.append(substituted(value.type, opened))
        if not types:
            raise Wrong(type_messages.field_of_no_record(name, shown(objects), span))
        for type_ in types[1:]:
            self.terms.must(type_, types[0], span)
        return types[0]

    def operation(self, objects: Objects, name: str, span: Span) -> Signature:
        """The parameters of ``a.Op``.

        Raises:
            Wrong: some object that *a* may be has no such visible operation.
        """
        found: Signature | None = None
        for reference in objects.common.values():
            original = self._original(reference, name)
            names = [n for n in self.operation_names(reference.name) if self.is_visible(reference.name, n)]
            if original is None or original not in names:
                near = suggestions(name, names)
                raise Wrong(class_messages.no_operation_of_object(name, shown(objects), span, near))
            signature = self._signature(reference, original)
            found = signature if found is None else self.operations.merged(found, signature, span)
        if found is None:
            raise Wrong(messages.operation_of_no_object(name, shown(objects), span))
        return found

    def _signature(self, reference: ClassReference, name: str) -> Signature:
        shape = self.shape(reference.name)
        actual = dict(zip(shape.parameters, reference.arguments, strict=False))
        found = self.operations.signature(shape, name)
        return {parameter: substituted(type_, actual) for parameter, type_ in found.items()}

    # --- sets of objects --------------------------------------------------------------------------------------

    def renamed(self, objects: Objects, renamings: Sequence[tuple[str, str]]) -> Objects:
        """The objects of a class under other names of features: (new, old)."""
        later = {old: new for new, old in renamings}

        def changed(reference: ClassReference) -> ClassReference:
            done = [new for _, new in reference.renaming]
            both = [(old, later.get(new, new)) for old, new in reference.renaming]
            both += [(old, new) for old, new in later.items() if old not in done]
            return ClassReference(reference.name, reference.arguments, tuple(both))

        tables = [{name: changed(r) for name, r in table.items()} for table in (objects.classes, objects.common)]
        return Objects(tables[0], tables[1], objects.every, objects.grows, objects.written)

    def poly(self, objects: Objects, span: Span) -> Objects:
        """The objects of a class and of those that inherit from it."""
        classes = dict(objects.classes)
        for base in objects.common.values():
            for name in self.trees:
                if base.name in self._ancestors(name):
                    classes[name] = ClassReference(name, base.arguments)
        found = Objects(classes, dict(objects.common), written=f"poly {shown(objects)}")
        self._when_declared(lambda: self._check_poly(objects, span))
        return found

    def _when_declared(self, check: Callable[[], None]) -> None:
        if self._declaring:
            self._pending.append(check)
        else:
            check()

    def _ancestors(self, name: str) -> set[str]:
        found: set[str] = set()
        waiting = [i.name for i in self.trees[name].inherits]
        while waiting:
            parent = waiting.pop()
            if parent in self.trees and parent not in found:
                found.add(parent)
                waiting += [i.name for i in self.trees[parent].inherits]
        return found

    def _check_poly(self, objects: Objects, span: Span) -> None:
        for base in objects.common.values():
            for name in self.trees:
                if base.name in self._ancestors(name):
                    found = self._poly_mistake(base, name, span)
                    if found is not None:
                        self.report(found)
                        return

    def _poly_mistake(self, base: ClassReference, name: str, span: Span) -> Diagnostic | None:
        counts = len(self.trees[base.name].generics), len(self.trees[name].generics)
        if counts[0] != counts[1]:
            return messages.parameters_of_subclass(base.name, name, counts, span)
        child = ClassReference(name, base.arguments)
        shown_names = self._shown_names(base.name)
        for feature in shown_names:
            if not self.is_visible(name, feature):
                return messages.hidden_in_subclass(feature, base.name, name, span)
        return self._mismatch(base, child, span, shown_names)

    def _shown_names(self, name: str) -> list[str]:
        names = [*self.shape(name).features, *self.operation_names(name)]
        return [n for n in names if self.is_visible(name, n)]

    def admits(self, left: Objects, right: Objects) -> bool:
        """Whether classes may be in one set of objects; while they are declared that is not known yet."""
        return self._declaring or self.difference(left, right, self._anywhere()) is None

    def _anywhere(self) -> Span:
        return next(iter(self.trees.values())).span

    def check_union(self, left: Objects, right: Objects, span: Span) -> None:
        """Report, now or when all classes are declared, that classes have no union."""

        def check() -> None:
            found = self.difference(left, right, span)
            if found is not None:
                self.report(found)

        if self._declaring:
            self._pending.append(check)

    def difference(self, left: ObjectZType, right: ObjectZType, span: Span) -> Diagnostic | None:
        """Why two types of references do not go together; None for other types."""
        left, right = known(left), known(right)
        if not (isinstance(left, Objects) and isinstance(right, Objects)):
            return None
        both = (*left.common.values(), *right.common.values())
        common = set.intersection(*[set(self._shown_names(r.name)) for r in both]) if both else set()
        for one in left.common.values():
            for other in right.common.values():
                found = self._mismatch(one, other, span, common)
                if found is not None:
                    return found
        return None

    def _mismatch(
        self, one: ClassReference, other: ClassReference, span: Span, names: Collection[str]
    ) -> Diagnostic | None:
        """What two classes have in different types of the features that are looked at."""
        same = self.terms.unification.same
        if one.name == other.name:
            alike = all(map(same, one.arguments, other.arguments))
            return None if alike else messages.no_union((_written(one), _written(other)), span)
        shapes = [self.shape(r.name) for r in (one, other)]
        for name in self._shown_names(one.name):
            if name not in names or name in dict(one.renaming) or name in dict(other.renaming):
                continue
            types: list[ObjectZType | Signature] = []
            for reference, shape in zip((one, other), shapes, strict=True):
                if name in shape.features:
                    value = self._value(reference, name)
                    types.append(Open() if value.generics else value.type)
                else:
                    types.append(self._signature(reference, name))
            left, right = types
            if isinstance(left, dict) and isinstance(right, dict):
                alike = left.keys() == right.keys() and all(same(left[p], right[p]) for p in left)
            else:
                alike = not isinstance(left, dict) and not isinstance(right, dict) and same(left, right)
            if not alike:
                told = tuple([_signature_text(t) if isinstance(t, dict) else shown(t) for t in types])
                return messages.feature_differs(name, (one.name, other.name), (told[0], told[1]), span)
        return None


def _written(reference: ClassReference) -> str:
    arguments = f"[{', '.join(map(shown, reference.arguments))}]" if reference.arguments else ""
    return reference.name + arguments


def _signature_text(signature: Signature) -> str:
    return f"[{'; '.join(f'{name} : {shown(type_)}' for name, type_ in signature.items())}]"
