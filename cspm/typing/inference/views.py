"""The types of symbols, and how they look through the instances of modules.

A module is inferred once, with its parameters' types as general as its declarations allow. An instance has copies of
its own: the variables of the parameters are replaced by what the arguments are, each datatype of the module by a
datatype of the instance. What ``I::x`` is, is the type of ``x`` after that replacement; for ``I::J::x`` and for
instances of modules inside instances the replacements are composed.
"""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.naming.symbols import Names, Symbol
from cspcheck.cspm.typing.constraints import lacks_equality
from cspcheck.cspm.typing.types import Datatype, Scheme, Type, Variable, free_variables, resolve, substitute


class InstanceView:
    """What an instance replaces in the types of its module.

    Annotations can name a datatype of an instance before the instance itself is inferred; until the view is ``ready``
    the fields of its datatypes are not known.
    """

    def __init__(self, instance: Symbol, module: Symbol) -> None:
        self.instance = instance
        self.module = module
        self.variables: dict[Type, Type] = {}
        self.datatypes: dict[Datatype, Datatype] = {}
        self.ready = False
        self.open: tuple[Variable, ...] = ()
        """Variables that the arguments leave open: the members are as general in them as the arguments are."""


class Views:
    """All schemes known so far. Outlives the inference, to answer for expressions that come later."""

    def __init__(self, names: Names) -> None:
        self.names = names
        self.schemes: dict[Symbol, Scheme] = {}
        self.parameters: dict[Symbol, tuple[Type, ...]] = {}
        """Of each module inferred so far, the types of its parameters (one for each pattern)."""
        self.depths: dict[Symbol, int] = {}
        """Of each module inferred so far, how many modules with parameters stand around it."""
        self._views: dict[Symbol, InstanceView] = {}
        self._seen: dict[Symbol, Scheme] = {}
        self._datatypes: dict[Symbol, Datatype] = {}
        self._homes: dict[Datatype, Symbol | None] = {}
        self._copies: dict[Datatype, tuple[InstanceView, Datatype]] = {}
        self._fresh_copies: list[Datatype] = []

    # --- schemes ---------------------------------------------------------------------------------------------

    def scheme(self, symbol: Symbol) -> Scheme:
        """The scheme of a symbol, seen through whatever instances.

        Raises:
            KeyError: it is not known (yet).
        """
        scheme = self.schemes.get(symbol)
        if scheme is not None:
            return scheme
        if symbol.instance is None:
            raise KeyError(symbol)
        scheme = self._seen.get(symbol)
        if scheme is None:
            instance, inner = self._peel(symbol)
            scheme = self._seen[symbol] = self._through(self.view(instance), self.scheme(inner))
        return scheme

    def _through(self, view: InstanceView, scheme: Scheme) -> Scheme:
        type_ = self.replace(view, scheme.type)
        opened = [variable for variable in free_variables(type_) if variable in view.open]
        return Scheme((*scheme.variables, *opened), type_)

    def _peel(self, symbol: Symbol) -> tuple[Symbol, Symbol]:
        """A declared instance and the symbol that *symbol* is in its module, before the view through that instance."""
        instance = symbol.instance
        assert instance is not None
        assert symbol.member is not None
        if instance.instance is not None:
            outer, inner = self._peel(instance)
            return outer, self.names.project(inner, symbol.member)
        module = instance.module
        if module is not None and module.instance is not None:
            return instance, self.names.project(module.instance, symbol.member)
        return instance, symbol.member

    # --- instances -------------------------------------------------------------------------------------------

    def parameter_types(self, module: Symbol) -> tuple[Type, ...]:
        """The types of the parameters of a module, which may itself be seen through an instance."""
        if module.instance is None:
            return self.parameters[module]
        instance, inner = self._peel(module)
        view = self.view(instance)
        return tuple([self.replace(view, type_) for type_ in self.parameter_types(inner)])

    def view(self, instance: Symbol) -> InstanceView:
        """The view through a declared instance; whoever infers that fills it in."""
        view = self._views.get(instance)
        if view is None:
            assert instance.module is not None
            view = self._views[instance] = InstanceView(instance, instance.module)
        return view

    def finish(self, view: InstanceView) -> None:
        """Take note that the view is filled in."""
        view.ready = True
        self._fill_copies()

    def replace(self, view: InstanceView, type_: Type) -> Type:
        """*type_*, of the view's module, as it is seen through the instance."""
        replaced = self._replace(view, type_)
        if self._fresh_copies:
            self._fill_copies()
        return replaced

    def _replace(self, view: InstanceView, type_: Type) -> Type:
        """Like :meth:`replace`, leaving new copies of datatypes without fields for now."""

        def replacement(head: Type) -> Type | None:
            if type(head) is Datatype:
                return self._copy(view, head) if self._belongs(head, view.module) else None
            return view.variables.get(head)

        return substitute(type_, replacement)

    def members(self, module: Symbol) -> list[Symbol]:
        """Everything declared in a module, in modules inside it too."""
        found: list[Symbol] = []
        for member in module.base.members.values():
            found.append(member)
            if member.members and not member.parameters_declared:
                found.extend(self.members(member))
        return found

    # --- datatypes -------------------------------------------------------------------------------------------

    def datatype(self, symbol: Symbol) -> Datatype:
        """The type that a datatype's symbol names."""
        datatype = self._datatypes.get(symbol)
        if datatype is None:
            if symbol.instance is None:
                datatype = Datatype(self.qualified(symbol), symbol.span)
                self._homes[datatype] = symbol.owner
            else:
                instance, inner = self._peel(symbol)
                datatype = self._copy(self.view(instance), self.datatype(inner))
                self._fill_copies()
            self._datatypes[symbol] = datatype
        return datatype

    def _belongs(self, datatype: Datatype, module: Symbol) -> bool:
        """Whether each instance of *module* has its own copy of *datatype*."""
        copied = self._copies.get(datatype)
        if module.instance is not None:
            instance, inner = self._peel(module)
            return copied is not None and copied[0].instance is instance and self._belongs(copied[1], inner)
        home = self._homes[datatype] if copied is None else copied[0].instance.owner
        while home is not None and home is not module:
            home = home.owner
        return home is not None

    def _copy(self, view: InstanceView, datatype: Datatype) -> Datatype:
        copy = view.datatypes.get(datatype)
        if copy is None:
            inside = f"{self.qualified(view.module)}::"
            name = f"{self.qualified(view.instance)}::{datatype.name.removeprefix(inside)}"
            copy = view.datatypes[datatype] = Datatype(name, datatype.span)
            self._copies[copy] = (view, datatype)
            self._fresh_copies.append(copy)
        return copy

    def _fill_copies(self) -> None:
        """Give new copies their fields, which may need further copies, and decide their equality."""
        filled: list[Datatype] = []
        waiting: list[Datatype] = []
        while self._fresh_copies:
            copy = self._fresh_copies.pop()
            view, original = self._copies[copy]
            if not view.ready:
                waiting.append(copy)
                continue
            copy.fields = {
                name: tuple([self._replace(view, type_) for type_ in types]) for name, types in original.fields.items()
            }
            filled.append(copy)
        self._fresh_copies = waiting
        decide_equality(filled)

    # --- names -----------------------------------------------------------------------------------------------

    def qualified(self, symbol: Symbol) -> str:
        """The name of a symbol with the modules and instances around it, from outside all of them."""
        if symbol.instance is not None and symbol.member is not None:
            module = symbol.instance.base.module
            around, stop = self.qualified(symbol.instance), None if module is None else module.base
            symbol = symbol.member
        else:
            around, stop = "", None
        path = [symbol.name]
        owner = symbol.owner
        while owner is not None and owner is not stop:
            path.append(owner.name)
            owner = owner.owner
        return "::".join([*([around] if around else []), *reversed(path)])


def decide_equality(datatypes: Sequence[Datatype]) -> None:
    """Say of each datatype whether it is comparable: all its fields must be. The greatest solution."""
    for datatype in datatypes:
        datatype.comparable = True
    changed = True
    while changed:
        changed = False
        for datatype in datatypes:
            if not datatype.comparable:
                continue
            if any(lacks_equality(resolve(t)) is not None for types in datatype.fields.values() for t in types):
                datatype.comparable = False
                changed = True
