"""From annotations to types, and definitions held against them."""

from __future__ import annotations

from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.inference.context import Rejected
from cspcheck.cspm.typing.inference.processes import ProcessRules
from cspcheck.cspm.typing.types import (
    ATOMS,
    CONSTRAINT_NAMES,
    Constraints,
    Dot,
    Dotable,
    Extendable,
    Function,
    MapOf,
    Rigid,
    Scheme,
    SequenceOf,
    SetOf,
    TupleOf,
    Type,
    Variable,
    substitute,
)

CONSTRAINTS: dict[str, Constraints] = {name: single for single, name in CONSTRAINT_NAMES.items()}


class AnnotationRules(ProcessRules):
    """Reads annotations. A variable of an enclosing annotation means the same type inside the definition."""

    def annotated_scheme(self, annotation: syntax.AnnotationDeclaration) -> Scheme:
        """The scheme that an annotation gives to its names.

        Raises:
            Rejected: it makes no sense.
        """
        variables: dict[str, Variable] = {}
        type_ = self._read(annotation.scheme.type, variables)
        for constraint in annotation.scheme.constraints:
            variable = variables.get(constraint.variable)
            if variable is None:
                outer = constraint.variable in self.rigid
                raise Rejected(
                    messages.bad_annotation(
                        constraint.span,
                        f"`{constraint.variable}` belongs to an outer annotation"
                        if outer
                        else f"`{constraint.variable}` is not a variable of the annotated type",
                        "put the constraint into the outer annotation" if outer else None,
                    )
                )
            variable.constraints |= CONSTRAINTS[constraint.constraint]
        return Scheme(tuple(variables.values()), type_)

    def _variable(self, name: str, variables: dict[str, Variable]) -> Type:
        rigid = self.rigid.get(name)
        if rigid is not None:
            return rigid
        # Far deeper than any definition: the variables of a scheme belong to nobody.
        return variables.setdefault(name, Variable(1 << 30))

    def _read(self, node: syntax.TypeExpr, variables: dict[str, Variable]) -> Type:
        match node:
            case syntax.TypeName():
                return self._read_name(node, variables)
            case syntax.SetType():
                return SetOf(self._read(node.element, variables))
            case syntax.SequenceType():
                return SequenceOf(self._read(node.element, variables))
            case syntax.TupleType():
                return TupleOf([self._read(item, variables) for item in node.items])
            case syntax.MapType():
                return MapOf(self._read(node.key, variables), self._read(node.value, variables))
            case syntax.FunctionType():
                parameters = [self._read(parameter, variables) for parameter in node.parameters]
                return Function(parameters, self._read(node.result, variables))
            case syntax.DotType():
                return Dot(self._read(node.left, variables), self._read(node.right, variables))
            case syntax.DotableType(extendable=False):
                return Dotable(self._read(node.argument, variables), self._read(node.result, variables))
            case syntax.DotableType():
                argument = self._read(node.argument, variables)
                if type(argument) not in (Variable, Rigid):
                    raise Rejected(
                        messages.bad_annotation(
                            node.argument.span,
                            "left of `=>*` must stand a variable",
                            "use `=>` for fields whose types are known",
                        )
                    )
                return Extendable(argument, self._read(node.result, variables))
        raise AssertionError(node)

    def _read_name(self, node: syntax.TypeName, variables: dict[str, Variable]) -> Type:
        symbol = self.names.find(node)
        if symbol is not None:
            if symbol.kind is SymbolKind.DATATYPE:
                return self.views.datatype(symbol)
            raise Rejected(
                messages.bad_annotation(
                    node.span,
                    f"`{'::'.join(node.parts)}` is not a type",
                    "types are `Int`, `Bool`, `Char`, `Proc`, `Event`, and the names of datatypes",
                )
            )
        name = "::".join(node.parts)
        return ATOMS.get(name) or self._variable(name, variables)

    def inside(self, symbol: Symbol, scheme: Scheme) -> tuple[Type, dict[str, Rigid]]:
        """The type of an annotated symbol within its own definition, and the variables known there by name."""
        annotation = self.names.annotation(symbol)
        assert annotation is not None
        names = self._variable_names(annotation.scheme.type)
        rigid: dict[str, Rigid] = {}
        mapping: dict[Type, Type] = {}
        for name, variable in zip(names, scheme.variables, strict=True):
            rigid[name] = Rigid(name, self.level, variable.constraints, annotation.span)
            mapping[variable] = rigid[name]
        return substitute(scheme.type, mapping.get), rigid

    def _variable_names(self, node: syntax.TypeExpr) -> list[str]:
        """The variables that an annotation introduces, in the order in which :meth:`_read` meets them."""
        variables: dict[str, Variable] = {}
        self._read(node, variables)
        return list(variables)
