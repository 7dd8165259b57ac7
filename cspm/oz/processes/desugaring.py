"""Classes become declarations of CSPm, between the parser and the resolver of names.

============================ ======================================================================================
Object-Z                     CSPm
============================ ======================================================================================
given set with a reading     ``datatype T = T_1 | T_2``
free type                    ``datatype T = a | b.{...}``
schema, abbreviation         the set of that name
constant                     its value
``chan c``                   ``channel c``, once for all classes that share it
``class C``                  a module whose members are the methods, the constants, the process equations and
                             ``visible``, the process with the methods visible; and the process ``C``, in which they are
                             hidden
============================ ======================================================================================

The sets of fields are :class:`~cspcheck.cspm.oz.processes.nodes.CarrierSet`, evaluated with the finite readings when
they are needed.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.oz import core, syntax as oz
from cspcheck.cspm.oz.processes import messages as messages
from cspcheck.cspm.oz.processes.context import ClassContext
from cspcheck.cspm.oz.processes.nodes import OBJECTS, WIDE, CarrierSet, ClassModule, ClassProcess, ConstantValue
from cspcheck.cspm.oz.typing.elaboration import Elaborated, flat
from cspcheck.cspm.oz.typing.equations import names_in
from cspcheck.cspm.oz.typing.fields import Fields, kept_fields
from cspcheck.cspm.oz.typing.scopes import SetEntry, whole
from cspcheck.cspm.oz.values.terms import shape
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.tree import Declaration, Expr, Name

DONE = "(done)"
"""The private event by which the data part of a class agrees to terminate."""


def desugared(tree: syntax.Script, elaborated: Elaborated, context: ClassContext) -> syntax.Script:
    """The script with declarations in place of its paragraphs.

    Raises:
        ScriptError: a name that a class needs for itself is declared in CSPm as well.
    """
    return _Desugaring(tree, elaborated, context).run()


MOST_ELEMENTS = 20_000
"""So many names may a reading of a given set bring into a script: each is a constructor, with all that this takes."""


class _Desugaring:
    def __init__(self, tree: syntax.Script, elaborated: Elaborated, context: ClassContext) -> None:
        self.tree = tree
        self.elaborated = elaborated
        self.context = context
        self.specification = elaborated.specification
        self.declared = dict(_declared_names(tree.declarations))
        context.declared = frozenset(self.declared)
        self.models = dict(self.specification.classes)
        self.fields = kept_fields(tree, list(self.models.values()), control=context.control)
        self.mistakes: list[Diagnostic] = []
        self.sharing = self._sharing()
        context.unshared = frozenset(
            (model.name, channel.name)
            for model in self.models.values()
            for channel in model.channels.values()
            if channel.kind == "chan" and not self._is_shared(model, channel)
        )
        self.parameters = {name for model in self.models.values() for name in model.generics}
        """What generic parameters are called: given sets that no paragraph gives."""

    def run(self) -> syntax.Script:
        generated: dict[int, list[Declaration]] = {}
        first = next(d for d in flat(self.tree.declarations) if isinstance(d, syntax.Paragraph))
        generated[id(first)] = [*self._types(first.span), *self._channels()]
        for declaration in flat(self.tree.declarations):
            if isinstance(declaration, oz.Class) and declaration.name in self.models:
                model = self.models[declaration.name]
                generated.setdefault(id(declaration), []).extend(self.class_declarations(model))
        declarations = tuple(self._replaced(self.tree.declarations, generated))
        if self.mistakes:
            raise ScriptError(*self.mistakes)
        return replace(self.tree, declarations=declarations)

    def _replaced(
        self, declarations: Sequence[Declaration], generated: Mapping[int, list[Declaration]]
    ) -> Iterator[Declaration]:
        for declaration in declarations:
            if isinstance(declaration, syntax.IncludeDeclaration):
                inner = tuple(self._replaced(declaration.declarations, generated))
                yield replace(declaration, declarations=inner)
            elif isinstance(declaration, syntax.Paragraph):
                yield from generated.get(id(declaration), ())
            else:
                yield declaration

    def _claim(self, name: str, what: str, span: Span) -> bool:
        """Whether a name is free for the Object-Z part; a mistake otherwise."""
        other = self.declared.get(name)
        if other is not None:
            self.mistakes.append(messages.name_taken(name, what, span, other))
        return other is None

    # --- types and constants -------------------------------------------------------------------------------------

    def _types(self, span: Span) -> Iterator[Declaration]:
        specification = self.specification
        for name, given_span in specification.givens.items():
            yield from self._given(name, given_span)
        for name, definition in specification.frees.items():
            if name not in self.declared:
                yield self._free(definition)
            # A datatype of CSPm is there already.
        for name, record in specification.records.items():
            if name.isidentifier() and self._claim(name, "a schema", record.span):
                kind = core.RecordType(name, tuple([(f.name, f.type) for f in record.fields]))
                carrier = core.Apply(type=core.SetType(kind), operator="Records")
                yield _value(name, record.span, self._set([carrier], None, record.span))
        for paragraph in flat(self.tree.declarations):
            abbreviated = self._abbreviated(paragraph)
            if abbreviated is not None:
                name, term = abbreviated
                if self._claim(name, "an abbreviation", paragraph.span):
                    yield _value(name, paragraph.span, self._set([term], None, paragraph.span))
        for constant in specification.constants:
            if constant.name.isidentifier() and self._claim(constant.name, "a constant", constant.span):
                yield self._constant(constant, None)

    def _abbreviated(self, paragraph: Declaration) -> tuple[str, core.Term] | None:
        """The name and the set of an abbreviation of a set."""
        if not isinstance(paragraph, oz.Abbreviation) or paragraph.generics:
            return None
        if paragraph.name in self.specification.records:
            return None  # a schema, which is known already
        entry = self.elaborated.classes.scope.find(paragraph.name)
        if not isinstance(entry, SetEntry) or not isinstance(entry.term.type, core.SetType):
            return None
        return paragraph.name, entry.term

    def _given(self, name: str, span: Span) -> Iterator[Declaration]:
        carrier = whole(core.GivenType(name))
        readings = self.context.evaluator(None).readings
        reading = readings.of(carrier)
        shared = name in self.specification.classes  # the name of a process, too
        if "." in name or shared or (name in self.parameters and name in self.declared):
            public = False
        else:
            public = self._claim(name, "a given set", span)
        if reading is None or reading.bound is None:
            yield syntax.DatatypeDeclaration(span=span, name=name + (OBJECTS if shared else WIDE), constructors=())
            if public:
                yield _value(name, span, self._set([carrier], None, span))
            return
        if reading.bound > MOST_ELEMENTS:
            raise ScriptError(messages.set_too_large(f"reading {name} = {reading.bound}", MOST_ELEMENTS, reading.span))
        elements = [f"{name}_{number}" for number in range(1, reading.bound + 1)]
        for element in elements:
            self._claim(element, f"an element of the given set `{name}`", reading.span)
        constructors = tuple([syntax.Constructor(span=reading.span, name=element) for element in elements])
        yield syntax.DatatypeDeclaration(span=span, name=name + OBJECTS * shared, constructors=constructors)

    def _free(self, definition: core.FreeDefinition) -> Declaration:
        constructors = []
        for name, carrier in definition.branches:
            self._claim(name, f"a constructor of `{definition.name}`", definition.span)
            fields = None if carrier is None else self._set([carrier], None, definition.span)
            constructors.append(syntax.Constructor(span=definition.span, name=name, fields=fields))
        return syntax.DatatypeDeclaration(span=definition.span, name=definition.name, constructors=tuple(constructors))

    def _constant(self, constant: core.Declared, owner: str | None) -> Declaration:
        body = ConstantValue(
            span=constant.span,
            context=self.context,
            owner=owner,
            datatypes=self._datatypes([constant.type], constant.span),
            name=constant.name,
            type=constant.type,
        )
        return _value(constant.name, constant.span, body)

    def _set(self, carriers: Sequence[core.Term], owner: str | None, span: Span) -> CarrierSet:
        first = carriers[0].type
        assert isinstance(first, core.SetType)
        return CarrierSet(
            span=span,
            context=self.context,
            owner=owner,
            datatypes=self._datatypes([first.element], span),
            carriers=tuple(carriers),
            element=first.element,
        )

    def _datatypes(self, types: Sequence[core.Type], span: Span) -> tuple[Name, ...]:
        """Names of the datatypes that values of some types may be of."""
        found: dict[str, None] = {}
        for type_ in types:
            for name in _datatypes_in(type_):
                found[self.datatype_name(name)] = None
        return tuple([Name(span=span, parts=(name,)) for name in found])

    def datatype_name(self, name: str) -> str:
        """What the datatype of a given or free type is called."""
        if name in self.specification.frees:
            return name
        reading = self.context.evaluator(None).readings.of(whole(core.GivenType(name)))
        shared = name in self.specification.classes
        if shared:
            return name + OBJECTS
        return name + WIDE if reading is None or reading.bound is None else name

    # --- channels ------------------------------------------------------------------------------------------------

    def _channels(self) -> Iterator[Declaration]:
        """The channels that classes share with each other and with the script."""
        for name, users in self.sharing.items():
            if name not in self.declared:
                yield self._channel(users)

    def _sharing(self) -> dict[str, list[tuple[core.ClassModel, core.Channel]]]:
        """The users of each channel that is shared.

        A generic class whose parameter types are not known takes no part where others know theirs: its channel is
        then its own.
        """
        users: dict[str, list[tuple[core.ClassModel, core.Channel]]] = {}
        for model in self.models.values():
            for channel in model.channels.values():
                if channel.kind == "chan":
                    users.setdefault(channel.name, []).append((model, channel))
        for name, found in users.items():
            definite = [(m, c) for m, c in found if not _is_generic(c, m)]
            if definite and len({tuple([p.type for p in c.parameters]) for _, c in found}) > 1:
                users[name] = definite
        return users

    def _is_shared(self, model: core.ClassModel, channel: core.Channel) -> bool:
        return channel.kind == "chan" and any(m is model for m, _ in self.sharing[channel.name])

    def _wider(self, model: core.ClassModel) -> Iterator[str]:
        """The channels without schema that the script, or another class, gives more values than the class does."""
        for channel in model.channels.values():
            if channel.name in model.operations or not channel.parameters or not self._is_shared(model, channel):
                continue
            mine = [shape(p.carrier) for p in channel.parameters]
            users = [c for _, c in self.sharing[channel.name]]
            if channel.name in self.declared or any([shape(p.carrier) for p in c.parameters] != mine for c in users):
                yield channel.name

    def _channel(self, users: Sequence[tuple[core.ClassModel, core.Channel]]) -> Declaration:
        owner, first = users[0]
        fields: list[Expr] = []
        for position in self.fields.kept(first.name, len(first.parameters)):
            carriers: dict[Any, core.Term] = {}
            for _, channel in users:
                carrier = channel.parameters[position].carrier
                if carrier.type == first.parameters[position].carrier.type:
                    carriers.setdefault(shape(carrier), carrier)
            fields.append(self._set(list(carriers.values()), owner.name, first.parameters[position].span))
        name = syntax.NameDeclaration(span=first.span, name=first.name)
        return syntax.ChannelDeclaration(span=first.span, names=(name,), fields=_dotted(fields))

    # --- classes -------------------------------------------------------------------------------------------------

    def class_declarations(self, model: core.ClassModel) -> list[Declaration]:
        """The module of a class, and its process."""
        name, span = model.name, model.span
        self._claim(name, "a class", span)
        self.context.models[name] = model
        methods = [c for c in model.channels.values() if c.kind == "method"]
        local = [c for c in model.channels.values() if c.kind == "local_chan"]
        done = syntax.ChannelDeclaration(span=span, names=(syntax.NameDeclaration(span=span, name=DONE),))
        private: list[Declaration] = [done, *[self._channel([(model, channel)]) for channel in local]]
        open_ = [c for c in model.channels.values() if c.kind in ("chan", "operation")]
        own = [c for c in open_ if not self._is_shared(model, c)]
        exported: list[Declaration] = [self._channel([(model, channel)]) for channel in (*methods, *own)]
        exported += [self._constant(constant, name) for constant in model.constants]
        mains: list[Name] = []
        for part in model.processes:
            equations = [self.fields.rewritten(equation, model.channels) for equation in part.equations]
            if part.owner == name:
                exported += equations
                mains.append(Name(span=span, parts=("main",)))
            else:
                inner = f"{part.owner}%part"
                private.append(
                    syntax.ModuleDeclaration(
                        span=span, name=inner, parameters=(), private=(), exported=tuple(equations)
                    )
                )
                mains.append(Name(span=span, parts=(inner, "main")))
        mains = [main for main, part in zip(mains, model.processes, strict=True) if _has_main(part)]
        visible = ClassProcess(
            span=span,
            context=self.context,
            owner=name,
            model=model,
            channels=tuple([Name(span=c.span, parts=(c.name,)) for c in model.channels.values()]),
            mains=tuple(mains),
            done=Name(span=span, parts=(DONE,)),
            wider=tuple(self._wider(model)),
            kept={c.name: self.fields.kept(c.name, len(c.parameters)) for c in model.channels.values()},
            datatypes=self._datatypes([p.type for c in model.channels.values() for p in c.parameters], span),
        )
        hidden = [Name(span=span, parts=(c.name,)) for c in local]
        taken = {member for declaration in (*private, *exported) for member in _defined(declaration)}
        member = self.context.visible[name] = _unused("visible", taken)
        exported.append(_value(member, span, _hiding(visible, hidden, span), called=name))
        module = ClassModule(span=span, name=name, parameters=(), private=tuple(private), exported=tuple(exported))
        members = [Name(span=span, parts=(name, c.name)) for c in methods]
        process = _value(name, span, _hiding(Name(span=span, parts=(name, member)), members, span))
        return [module, process]


def _unused(name: str, taken: Container[str]) -> str:
    """A name that a class leaves free: with as many primes as that takes."""
    while name in taken:
        name += "'"
    return name


def _is_generic(channel: core.Channel, model: core.ClassModel) -> bool:
    """Whether events of a channel have values of the type of a generic parameter of its class."""
    generic = {*model.generics, *[f"{model.name}.{name}" for name in model.generics]}
    return any(name in generic for p in channel.parameters for name in _datatypes_in(p.type))


def _has_main(part: core.ProcessPart) -> bool:
    return any("main" in _defined(equation) for equation in part.equations)


def _hiding(process: Expr, channels: Sequence[Name], span: Span) -> Expr:
    if not channels:
        return process
    events = syntax.Productions(span=span, items=tuple(channels))
    return syntax.Hide(span=span, process=process, events=events)


def _value(name: str, span: Span, body: Expr, *, called: str | None = None) -> Declaration:
    pattern = syntax.NamePattern(span=span, parts=(name,))
    return syntax.PatternDefinition(span=span, pattern=pattern, body=body, called=called)


def _dotted(fields: Sequence[Expr]) -> Expr | None:
    if not fields:
        return None
    *before, result = fields
    for part in reversed(before):
        result = syntax.Dot(span=part.span, left=part, right=result)
    return result


def _datatypes_in(type_: core.Type) -> Iterator[str]:
    match type_:
        case core.GivenType(name) | core.FreeType(name):
            yield name
        case core.TupleType(items):
            for item in items:
                yield from _datatypes_in(item)
        case core.SetType(element) | core.SequenceType(element) | core.BagType(element):
            yield from _datatypes_in(element)
        case core.FunctionType(domain, range_):
            yield from _datatypes_in(domain)
            yield from _datatypes_in(range_)
        case core.RecordType(_, fields):
            for _, item in fields:
                yield from _datatypes_in(item)


def _defined(declaration: Declaration) -> list[str]:
    return [name for name, _ in _names_of(declaration)]


def _declared_names(declarations: Sequence[Declaration]) -> Iterator[tuple[str, Span]]:
    """What the CSPm part of the script declares, with the places."""
    for declaration in flat(tuple(declarations)):
        if isinstance(declaration, syntax.TimedDeclaration):
            yield from _declared_names(declaration.declarations)
        else:
            yield from _names_of(declaration)


def _names_of(declaration: Declaration) -> Iterator[tuple[str, Span]]:
    match declaration:
        case syntax.ChannelDeclaration():
            yield from ((name.name, name.span) for name in declaration.names)
        case syntax.DatatypeDeclaration():
            yield declaration.name, declaration.span
            if not declaration.subtype:
                yield from ((c.name, c.span) for c in declaration.constructors)
        case syntax.PatternDefinition(pattern=syntax.NamePattern() as pattern):
            yield pattern.text, pattern.span
        case (
            syntax.FunctionDefinition()
            | syntax.NametypeDeclaration()
            | syntax.ModuleDeclaration()
            | syntax.InstanceDeclaration()
        ):
            yield declaration.name, declaration.span


__all__ = ["Fields", "desugared", "names_in"]
