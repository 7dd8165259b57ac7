"""Classes, flattened: what a class declares, put on top of what it inherits.

A subclass conjoins its parents' state, INIT and schemas of the same event with its own, and runs its process
equations beside theirs (Fischer 2000; Olderog and Wehrheim 2005). Generic parameters are given sets in the class
itself and are replaced where it is inherited or used with arguments.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

from cspcheck.cspm.diagnostics import Diagnostic, DiagnosticSink
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.typing import messages as messages, type_messages as type_messages
from cspcheck.cspm.oz.typing.equations import check_equations
from cspcheck.cspm.oz.typing.identities import POOL, circle, valued
from cspcheck.cspm.oz.typing.lemmas import Lemmas, helpful
from cspcheck.cspm.oz.typing.objects import Flattened, ObjectClass, Objects
from cspcheck.cspm.oz.typing.operation_calculus import Box, Surroundings, joined_sets
from cspcheck.cspm.oz.typing.operations import PREFIXES, Boxes, inherited_operations
from cspcheck.cspm.oz.typing.paragraphs import DeclaredParagraphs, names_of
from cspcheck.cspm.oz.typing.renaming import renamed
from cspcheck.cspm.oz.typing.scopes import (
    ClassEntry,
    ConstructorEntry,
    Definition,
    GenericEntry,
    ObjectEntry,
    SetEntry,
    StateEntry,
    TypingScope,
    VariableEntry,
    place_of,
    same_definition,
    whole,
)
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.oz.values.terms import shape
from cspcheck.cspm.source import Span
from cspcheck.cspm.spelling import suggestions

D = TypeVar("D", bound=core.Declared)


@dataclass
class _Built:
    """A class with the scope that its children see."""

    model: core.ClassModel
    scope: TypingScope
    boxes: dict[str, Box]
    objects: dict[str, ObjectEntry]
    types: dict[str, tuple[Definition, str]]


class ClassTable:
    """The classes of a script, each made once for each choice of generic arguments."""

    def __init__(
        self,
        trees: Sequence[s.Class],
        typing: Typing,
        scope: TypingScope,
        paragraphs: DeclaredParagraphs,
        report: DiagnosticSink,
    ) -> None:
        self.trees = {tree.name: tree for tree in trees}
        self.typing = typing
        self.scope = scope
        self.paragraphs = paragraphs
        self.report = report
        self.lemmas = Lemmas(typing, report)
        self.parameters = TypingScope(scope)
        """The given sets that generic parameters stand for, beside all names of the script."""
        self._built: dict[tuple[str, tuple[core.Term, ...]], _Built] = {}
        self._open: list[str] = []
        self.unclear: set[str] = set()
        """Channels with a declaration that is wrong: nothing can be said of how classes share them."""

    def all(self) -> Mapping[str, core.ClassModel]:
        """Every class of the script as it stands, in the order of the text."""
        for tree in self.trees.values():
            for generic in tree.generics:
                given = self.parameter(tree, generic.name)
                self.paragraphs.givens.setdefault(given.name, generic.span)
                self.parameters.add(given.name, SetEntry(whole(given), generic.span))
        models = {}
        for name in self.trees:
            built = self.build(name, (), self.report)
            if built is not None:
                models[name] = built.model
        return models

    def parameter(self, tree: s.Class, name: str) -> core.GivenType:
        """The given set that a generic parameter stands for in a class that is not instantiated.

        Parameters of one name are one set in all classes, so that two generic classes can be compared; unless the
        script gives that name another meaning.
        """
        return core.GivenType(name if self.scope.find(name) is None else f"{tree.name}.{name}")

    def instance(self, name: str, arguments: tuple[s.Term, ...]) -> core.ClassModel:
        """A generic class with actual parameters.

        Raises:
            Wrong: there is no such class, or the arguments do not match.
        """
        span = arguments[0].span if arguments else None
        if name not in self.trees:
            assert span is not None
            raise Wrong(messages.unknown_class(name, span, suggestions(name, self.trees)))
        terms = tuple([replace(self.typing.carrier(argument, self.scope), span=None) for argument in arguments])
        wanted = len(self.trees[name].generics)
        if wanted != len(terms):
            raise Wrong(type_messages.generic_arguments(name, wanted, len(terms), span or self.trees[name].span))
        mistakes: list[Diagnostic] = []
        built = self.build(name, terms, mistakes.append)
        if built is None or mistakes:
            raise Wrong(mistakes[0])
        return built.model

    def is_open(self, name: str) -> bool:
        """Whether a class is being made just now."""
        return name in self._open

    def build(self, name: str, arguments: tuple[core.Term, ...], report: DiagnosticSink) -> _Built | None:
        """A class for given arguments (none: its parameters stay given sets); None where it inherits from itself."""
        key = (name, arguments)
        if key in self._built:
            return self._built[key]
        if name in self._open:
            cycle = [*self._open[self._open.index(name) :], name]
            self.report(circle(cycle, self.trees))
            return None
        self._open.append(name)
        try:
            built = _Builder(self, self.trees[name], arguments, report).build()
        finally:
            self._open.pop()
        self._built[key] = built
        return built


class _Builder:
    """Puts one class together."""

    def __init__(
        self, classes: ClassTable, tree: s.Class, arguments: tuple[core.Term, ...], report: DiagnosticSink
    ) -> None:
        self.classes = classes
        self.tree = tree
        self.report = report
        self.scope = TypingScope(classes.scope)
        self.types: dict[str, tuple[Definition, str]] = {}
        """What abbreviations and types of the class and its parents stand for, and in which class."""
        for i, generic in enumerate(tree.generics):
            term = arguments[i] if arguments else whole(classes.parameter(tree, generic.name))
            self.scope.add(generic.name, SetEntry(term, generic.span))
        self.channels: dict[str, core.Channel] = {}
        self.constants: dict[str, core.Declared] = {}
        self.primary: dict[str, core.Declared] = {}
        self.secondary: dict[str, core.Declared] = {}
        self.axioms: list[core.Term] = []
        self.invariant: list[core.Term] = []
        self.initial: list[core.Term] | None = None
        self.operations: dict[str, core.Operation] = {}
        self.processes: list[core.ProcessPart] = []
        self.parents: list[str] = []
        self.lemmas: dict[str, core.Lemma] = {}
        self.boxes: dict[str, Box] = {}
        """The schemas of parents, by the names of their operations."""
        self.objects: dict[str, ObjectEntry] = {}
        values = valued(tree, frozenset(classes.trees))
        self.flattening = Objects(classes.typing, self.scope, tree.name, self._object_class, values, report)

    def build(self) -> _Built:
        tree = self.tree
        for inherit in tree.inherits:
            self._inherit(inherit)
        self._paragraphs()
        for interface in tree.interface:
            self._interface(interface)
        self._state()
        states = self.primary | self.secondary
        self._plain_operations()
        around = Surroundings(tree.name, states, frozenset(self.secondary), self.invariant)
        boxes = Boxes(tree, self.channels, self.classes.typing, self.scope, around, self.boxes, self.report)
        own = boxes.operations(self.operations)
        # A method that was declared without parameters has those of its schema.
        self.channels.update(boxes.channels)
        joined = inherited_operations(self._aligned(self.operations), own, self.report)
        # The sets of the channel may have become narrower since a parent's operation was made.
        self.operations = {
            n: replace(o, parameters=self.channels[n].parameters, using=self._helpful(n)) for n, o in joined.items()
        }
        if tree.equations:
            self.processes.append(core.ProcessPart(owner=tree.name, equations=tree.equations))
        check_equations(tree, self.channels, self.processes, own, self.report)
        self._visibility()
        self._one_meaning()
        model = core.ClassModel(
            name=tree.name,
            span=tree.span,
            parents=tuple(self.parents),
            generics=tuple([generic.name for generic in tree.generics]),
            visibility=None if tree.visibility is None else tuple([name.name for name in tree.visibility]),
            channels=self.channels,
            constants=tuple(self.constants.values()),
            axioms=tuple(self.axioms),
            primary=tuple(self.primary.values()),
            secondary=tuple(self.secondary.values()),
            invariant=tuple(self.invariant),
            initial=None if self.initial is None else tuple(self.initial),
            operations=self.operations,
            processes=tuple(self.processes),
            lemmas=self.lemmas | self.classes.lemmas.declared(tree.paragraphs, self.scope, "invariant"),
        )
        return _Built(model, self.scope, boxes.boxes(), self.objects, self.types)

    def _helpful(self, event: str) -> tuple[core.LemmaUse, ...]:
        """The lemmas for proofs about an operation."""
        inherited, own = helpful(self.tree, event, self.operations.get(event))
        parameters = self.channels[event].parameters
        made = self.classes.lemmas.uses_of_operation(own, self.scope, parameters)
        return tuple(dict.fromkeys((*inherited, *made)))

    # --- inheritance ------------------------------------------------------------------------------------------

    def _inherit(self, inherit: s.Inherit) -> None:
        trees = self.classes.trees
        if inherit.name not in trees:
            self.report(messages.unknown_class(inherit.name, inherit.span, suggestions(inherit.name, trees)))
            return
        wanted = len(trees[inherit.name].generics)
        if wanted != len(inherit.arguments):
            self.report(type_messages.generic_arguments(inherit.name, wanted, len(inherit.arguments), inherit.span))
            return
        try:
            arguments = tuple(
                [replace(self.classes.typing.carrier(a, self.scope), span=None) for a in inherit.arguments]
            )
        except Wrong as wrong:
            self.report(wrong.diagnostic)
            return
        built = self.classes.build(inherit.name, arguments, self.report)
        if built is None:
            return
        parent, boxes = self._renamed(built, inherit) if inherit.renamings else (built.model, built.boxes)
        self.parents.append(parent.name)
        names = {old.name: new.name for new, old in inherit.renamings}
        for name, (entry, owner) in built.types.items():
            self._adopt(names.get(name, name), entry, owner)
        for channel in parent.channels.values():
            self._merge_channel(channel)
        self._merge(self.constants, parent.constants, parent.name, self.axioms, "constant")
        self._merge(self.primary, parent.primary, parent.name, self.invariant, "before")
        self._merge(self.secondary, parent.secondary, parent.name, self.invariant, "before")
        for constant in parent.constants:
            variable = core.Variable(type=constant.type, name=constant.name, role="constant", span=constant.span)
            self.scope.add(constant.name, VariableEntry(variable, constant.span))
        self._extend(self.axioms, parent.axioms)
        self._extend(self.invariant, parent.invariant)
        self.lemmas |= parent.lemmas
        if parent.initial is not None:
            self.initial = self.initial or []
            self._extend(self.initial, parent.initial)
        self.operations = inherited_operations(self.operations, self._aligned(parent.operations), self.report)
        self.objects.update(built.objects)
        self.boxes.update(boxes)
        for part in parent.processes:
            if part not in self.processes:
                self.processes.append(part)

    def _adopt(self, name: str, entry: Definition, owner: str) -> None:
        """Take over what a name stands for in a class; two classes must agree."""
        first, before = self.types.get(name, (entry, owner))
        if not same_definition(first, entry):
            spans = (place_of(entry) or self.tree.span, place_of(first) or self.tree.span)
            self.report(messages.inherited_with_another_meaning(name, *spans, (owner, before)))
        self.scope.add(name, entry)
        self.types[name] = entry, owner

    def _one_meaning(self) -> None:
        """DiagnosticSink names that are of two kinds, such as a constant that a parent has as a variable."""
        tables: list[dict[str, Span]] = [
            {name: place_of(entry) or self.tree.span for name, (entry, _) in self.types.items()}
        ]
        tables += [{d.name: d.span for d in t.values()} for t in (self.constants, self.primary, self.secondary)]
        tables.append({o.name: o.span for o in self.tree.operations} if self._is_plain else {})
        tables.append({self.tree.name: self.tree.span})
        seen: dict[str, Span] = {}
        for table in tables:
            for name, span in table.items():
                first = seen.setdefault(name, span)
                if first != span:
                    self.report(type_messages.declared_twice(name, first, span))

    @property
    def _is_plain(self) -> bool:
        return all(channel.kind == "operation" for channel in self.channels.values())

    def _aligned(self, operations: Mapping[str, core.Operation]) -> dict[str, core.Operation]:
        """Operations with their parameters called as the channels of this class call them."""
        return {name: _called(operation, self.channels[name].parameters) for name, operation in operations.items()}

    def _extend(self, terms: list[core.Term], more: Sequence[core.Term]) -> None:
        """Add conjuncts; one that came by another way already is not repeated."""
        terms.extend(term for term in more if term not in terms)

    def _merge(
        self, own: dict[str, D], inherited: Sequence[D], parent: str, known: list[core.Term], role: core.Role
    ) -> None:
        """Add what a parent declares; what two parents declare lies in both sets, which *known* is told."""
        for declared in inherited:
            first = own.setdefault(declared.name, declared)
            if first.type != declared.type:
                self.report(
                    messages.inherited_differently(
                        declared.name, parent, str(first.type), str(declared.type), first.span, declared.span
                    )
                )
            elif shape(first.carrier) != shape(declared.carrier):
                self._extend(known, [_member(declared, role)])

    def _merge_channel(self, channel: core.Channel) -> None:
        first = self.channels.setdefault(channel.name, channel)
        if _types(first) != _types(channel):
            shown = (_shown(first), _shown(channel))
            self.report(messages.inherited_differently(channel.name, channel.owner, *shown, first.span, channel.span))
        else:
            self.channels[channel.name] = _narrowed(first, channel)

    def _renamed(self, built: _Built, inherit: s.Inherit) -> tuple[core.ClassModel, dict[str, Box]]:
        """A parent, and its schemas, called as the child wishes."""
        parent = built.model
        known = {*parent.channels, *built.boxes, *built.types, *built.objects}
        known |= {d.name for d in (*parent.constants, *parent.primary, *parent.secondary)}
        for _, old in inherit.renamings:
            if old.name not in known:
                near = suggestions(old.name, sorted(known))
                self.report(messages.rename_unknown(old.name, parent.name, old.span, near))
            elif old.name in built.objects:
                self.report(messages.no_alternatives(f"the object `{old.name}` cannot be renamed", old.span))
        return renamed(parent, built.boxes, {old.name: new.name for new, old in inherit.renamings})

    # --- own declarations -------------------------------------------------------------------------------------

    def _paragraphs(self) -> None:
        inner = self.classes.paragraphs.inside(self.scope)
        inner.elaborate(self.tree.paragraphs)
        for paragraph in self.tree.paragraphs:
            for name, _ in names_of(paragraph):
                entry = self.scope.own(name)
                if isinstance(entry, SetEntry | GenericEntry | ConstructorEntry):
                    self._adopt(name, entry, self.tree.name)
        for constant in inner.constants:
            inherited = self.constants.get(constant.name)
            if inherited is not None and inherited.type != constant.type:
                self.report(
                    messages.inherited_differently(
                        constant.name,
                        self.parents[-1],
                        str(constant.type),
                        str(inherited.type),
                        constant.span,
                        inherited.span,
                    )
                )
            elif inherited is not None and shape(inherited.carrier) != shape(constant.carrier):
                self._extend(self.axioms, [_member(inherited, "constant")])
            self.constants[constant.name] = constant
        self._extend(self.axioms, inner.axioms)

    def _interface(self, interface: s.Interface) -> None:
        parameters = []
        seen: dict[str, Span] = {}
        for declaration in interface.parameters:
            try:
                carrier = self.classes.typing.carrier(declaration.carrier, self.scope)
            except Wrong as wrong:
                self.report(wrong.diagnostic)
                self.classes.unclear.update(declared.name for declared in interface.names)
                continue
            assert isinstance(carrier.type, core.SetType)
            for name in declaration.names:
                if name.name in seen:
                    self.report(type_messages.declared_twice(name.name, seen[name.name], name.span))
                    continue
                seen[name.name] = name.span
                kind: core.ParameterKind = "simple"
                if name.decoration in ("?", "!"):
                    kind = "input" if name.decoration == "?" else "output"
                parameters.append(
                    core.Parameter(
                        name=name.name, type=carrier.type.element, carrier=carrier, span=name.span, kind=kind
                    )
                )
        for declared in interface.names:
            channel = core.Channel(
                name=declared.name,
                kind=interface.kind,
                parameters=tuple(parameters),
                owner=self.tree.name,
                span=declared.span,
            )
            before = self.channels.get(declared.name)
            if before is not None and before.owner == self.tree.name:
                self.report(type_messages.declared_twice(declared.name, before.span, declared.span))
            elif before is not None and _types(before) != _types(channel):
                self.report(
                    messages.inherited_differently(
                        declared.name, before.owner, _shown(channel), _shown(before), declared.span, before.span
                    )
                )
            elif before is not None:
                channel = _narrowed(channel, before)
            self.channels[declared.name] = channel

    def _plain_operations(self) -> None:
        """The interface of a class of plain Object-Z, without channels: its visible operations."""
        if not self._is_plain:
            return
        visible = None if self.tree.visibility is None else {name.name for name in self.tree.visibility}
        own = {o.name: o.span for o in self.tree.operations if not o.name.startswith(PREFIXES)}
        for name, span in {**{name: box.span for name, box in self.boxes.items()}, **own}.items():
            if visible is None and name in self.boxes and name not in own:
                continue  # visible already, or else the parent's own business
            if (visible is None or name in visible) and name not in self.channels:
                self.channels[name] = core.Channel(
                    name=name, kind="operation", parameters=(), owner=self.tree.name, span=span
                )
        for name in set(self.channels) - (visible if visible is not None else set(self.channels)):
            del self.channels[name]
            self.operations.pop(name, None)

    def _state(self) -> None:
        tree, paragraphs = self.tree, self.classes.paragraphs
        state = tree.state or s.State(span=tree.span, primary=())
        values, declared_objects = self.flattening.split(state.primary)
        flattened = self.flattening.flattened(declared_objects)
        self.flattening.pools(state.span, self.objects, flattened)
        if tree.state is not None or flattened.objects:
            own = {d.name: d for d in paragraphs.declared(values, self.scope)}
            own |= {d.name: d for d in flattened.primary}
            self._take_objects(flattened)
            included = list(paragraphs.included((*values, *state.secondary), self.scope))
            derived = {d.name: d for d in paragraphs.declared(state.secondary, self.scope)}
            derived |= {d.name: d for d in flattened.secondary}
            for name, declared in derived.items():
                if name in own:
                    self.report(type_messages.declared_twice(name, own[name].span, declared.span))
            for mine, inherited in ((own, self.primary), (derived, self.secondary)):
                for name, declared in mine.items():
                    before = inherited.get(name)
                    if before is not None and before.type != declared.type:
                        self.report(
                            messages.inherited_differently(
                                name,
                                self.parents[-1],
                                str(declared.type),
                                str(before.type),
                                declared.span,
                                before.span,
                            )
                        )
                    elif before is not None and shape(before.carrier) != shape(declared.carrier):
                        # What is declared again must lie in both sets.
                        self._extend(self.invariant, [_member(before, "before")])
                    inherited[name] = declared
        for declared in (*self.primary.values(), *self.secondary.values()):
            secondary = declared.name in self.secondary
            entry = StateEntry(declared.name, declared.type, secondary, declared.span)
            self.scope.add(declared.name, entry)
        for name, object_ in self.objects.items():
            self.scope.add(POOL + name if object_.pool else name, object_)
        if tree.state is not None:
            states = self.primary | self.secondary
            self._extend(self.invariant, [_of_states(predicate, states) for predicate in included])
            self._extend(self.invariant, paragraphs.predicates(state.predicates, self.scope, "invariant"))
        if tree.initial is not None:
            self.initial = self.initial or []
            self._extend(self.initial, paragraphs.predicates(tree.initial.predicates, self.scope, "initial"))

    def _object_class(self, reference: s.Reference) -> ObjectClass:
        """The class of an attribute.

        Raises:
            Wrong: its objects cannot be attributes.
        """
        classes = self.classes
        if classes.is_open(reference.name):
            what = f"an object of `{reference.name}` within itself"
            raise Wrong(messages.objects_need_heap(what, reference.span))
        arguments = tuple([replace(classes.typing.carrier(a, self.scope), span=None) for a in reference.arguments])
        wanted = len(classes.trees[reference.name].generics)
        if wanted != len(arguments):
            raise Wrong(type_messages.generic_arguments(reference.name, wanted, len(arguments), reference.span))
        built = classes.build(reference.name, arguments, self.report)
        entry = self.scope.find(reference.name)
        assert isinstance(entry, ClassEntry)
        if (
            built is None
            or built.model.processes
            or any(channel.kind != "operation" for channel in built.model.channels.values())
        ):
            raise Wrong(type_messages.class_is_no_value(reference.name, reference.span, entry.span))
        return ObjectClass(built.model, built.boxes, built.objects, built.types)

    def _take_objects(self, flattened: Flattened) -> None:
        """Make the constants of objects those of the class, and what holds of them hold in it."""
        self.objects.update(flattened.objects)
        for constant in flattened.constants:
            self.constants[constant.name] = constant
            variable = core.Variable(type=constant.type, name=constant.name, role="constant", span=constant.span)
            self.scope.add(constant.name, VariableEntry(variable, constant.span))
        self._extend(self.axioms, flattened.axioms)
        self._extend(self.invariant, flattened.invariant)

    def _visibility(self) -> None:
        known = {
            *self.channels,
            *self.constants,
            *self.primary,
            *self.secondary,
            *self.objects,
            *self.operations,
            *self.types,
            *[operation.name for operation in self.tree.operations],
            "INIT",
            "init",
            "Init",
        }
        for name in self.tree.visibility or ():
            if name.name not in known:
                near = suggestions(name.name, sorted(known))
                self.report(messages.not_visible(name.name, self.tree.name, name.span, near))


def _of_states(predicate: core.Term, states: Mapping[str, core.Declared]) -> core.Term:
    """What an included schema says of its components, said of the state variables that they are."""

    def variable(v: core.Variable) -> core.Term | None:
        return replace(v, role="before") if v.role == "bound" and v.name in states else None

    return substituted(predicate, variable)


def _called(operation: core.Operation, parameters: tuple[core.Parameter, ...]) -> core.Operation:
    """An operation with other names for its parameters, by position."""
    table = {
        (old.name, old.kind): new
        for old, new in zip(operation.parameters, parameters, strict=False)
        if (old.name, old.kind) != (new.name, new.kind)
    }
    if not table:
        return operation

    def value(variable: core.Variable) -> core.Term | None:
        new = table.get((variable.name, variable.role))  # type: ignore[arg-type]
        return None if new is None else replace(variable, name=new.name, role=new.kind)

    return replace(
        operation,
        parameters=parameters,
        guard=tuple([substituted(term, value) for term in operation.guard]),
        effect=tuple([substituted(term, value) for term in operation.effect]),
        using=tuple(
            [replace(u, arguments=tuple([substituted(term, value) for term in u.arguments])) for u in operation.using]
        ),
    )


def _narrowed(channel: core.Channel, inherited: core.Channel) -> core.Channel:
    """A channel that is declared again: its values lie in both sets."""
    parameters = []
    for own, other in zip(channel.parameters, inherited.parameters, strict=True):
        same = shape(own.carrier) == shape(other.carrier)
        parameters.append(own if same else replace(own, carrier=joined_sets("inter", own.carrier, other.carrier)))
    return replace(channel, parameters=tuple(parameters))


def _member(declared: core.Declared, role: core.Role) -> core.Term:
    variable = core.Variable(type=declared.type, name=declared.name, role=role, span=declared.span)
    return core.Apply(type=core.BOOL, operator="in", operands=(variable, declared.carrier), span=declared.span)


def _types(channel: core.Channel) -> tuple[core.Type, ...]:
    return tuple([parameter.type for parameter in channel.parameters])


def _shown(channel: core.Channel) -> str:
    return f"[{'; '.join(f'{p.name} : {p.type}' for p in channel.parameters)}]"
