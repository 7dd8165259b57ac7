"""The types of modules with parameters and of instances."""

from __future__ import annotations

from collections.abc import Sequence

from cspcheck.cspm.diagnostics import Diagnostic, Label
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.inference.context import Rejected, first_line
from cspcheck.cspm.typing.inference.declarations import DeclarationRules
from cspcheck.cspm.typing.inference.dependencies import DependencyUnit, path
from cspcheck.cspm.typing.types import Type, free_variables


class ModuleRules(DeclarationRules):
    """Infers the heads of modules and what their instances make of them."""

    def module_head(self, node: syntax.ModuleDeclaration, depth: int) -> None:
        """Give the parameters of a module types, which its declarations then make definite as far as they need."""
        self.level = depth + 1
        types = [self.infer(pattern) for pattern in node.parameters]
        self.views.parameters[self.names.symbol(node)] = tuple(types)
        self.views.depths[self.names.symbol(node)] = depth

    def instance(self, node: syntax.InstanceDeclaration, depth: int) -> None:
        """Open the view through an instance. Raises Rejected."""
        symbol, module = self.names.symbol(node), self.names.symbol(node.module)
        self.level = depth + 1
        view = self.views.view(symbol)
        for variable in free_variables(*self.views.parameters[module.base]):
            if variable.level > self.views.depths[module.base]:
                view.variables[variable] = self.fresh(variable.constraints)
        own = self.views.parameter_types(module)
        seen = [self.views.replace(view, type_) for type_ in own]
        given = [self.infer(argument) for argument in node.arguments]
        origin = None
        if module.span is not None:
            label = Label(first_line(module.span), f"`{module.name}` is declared here")
            origin = lambda: label  # noqa: E731
        for i, (argument, expected, actual) in enumerate(zip(node.arguments, seen, given, strict=True), 1):
            self.accept(expected, actual, argument, f"argument {i} of `{node.module.text}`", origin)
        self.level = depth
        opened = free_variables(*view.variables.values())
        view.open = tuple([variable for variable in opened if variable.level > depth])
        self.views.finish(view)
        self._check_members(view.open, symbol, module, node)
        self.unifier.forget()

    def _check_members(
        self, opened: Sequence[Type], instance: Symbol, module: Symbol, node: syntax.InstanceDeclaration
    ) -> None:
        """What an instance's arguments leave open must not be a field of its channels and constructors."""
        if not opened:
            return
        for member in self.views.members(module):
            if member.kind in (SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR):
                seen = self.names.project(instance, member)
                try:
                    self.check_definite(seen, self.views.scheme(seen), opened)
                except Rejected as rejected:
                    diagnostic = rejected.diagnostic
                    label = Label(node.span, f"in this instance of `{module.name}`")
                    raise Rejected(
                        Diagnostic(
                            diagnostic.code,
                            diagnostic.message,
                            diagnostic.span,
                            annotation=diagnostic.annotation,
                            labels=(label,),
                            help="give the instance an argument whose type is definite",
                        )
                    ) from None

    def cycle(self, group: Sequence[DependencyUnit]) -> Diagnostic | None:
        """What is wrong with a group that has an instance in it and more than that, or uses the instance itself."""
        for unit in group:
            node = unit.declaration
            if not isinstance(node, syntax.InstanceDeclaration) or (len(group) == 1 and unit not in unit.uses):
                continue
            module = self.names.symbol(node.module)
            inside = [u for u in unit.uses if u.module is not None and _within(u.module, module.base)]
            way = path(inside or unit.uses, unit)
            steps = [f"`{self._unit_name(step)}`" for step in way]
            first = way[0].declaration if way else node
            return messages.instance_cycle(
                module.name, node.name, node.span, steps, (Label(first_line(first.span), "it is used from here"),)
            )
        return None

    def _unit_name(self, unit: DependencyUnit) -> str:
        if unit.symbols:
            return self.views.qualified(unit.symbols[0])
        if isinstance(unit.declaration, syntax.ModuleDeclaration):
            return unit.declaration.name
        return "Timed"


def _within(module: Symbol, outer: Symbol) -> bool:
    inner: Symbol | None = module
    while inner is not None and inner is not outer:
        inner = inner.owner
    return inner is not None
