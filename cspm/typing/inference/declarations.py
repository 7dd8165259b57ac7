"""The types of declarations: functions and values, channels, datatypes, subtypes and nametypes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from cspcheck.cspm.diagnostics import Label
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.typing import messages as messages
from cspcheck.cspm.typing.inference.annotations import AnnotationRules
from cspcheck.cspm.typing.inference.context import INFERS, Rejected
from cspcheck.cspm.typing.inference.dependencies import DependencyUnit, components, declared, units_of
from cspcheck.cspm.typing.inference.views import decide_equality
from cspcheck.cspm.typing.types import (
    COMPLETE,
    EQ,
    EVENT,
    INT,
    Constraints,
    Datatype,
    Dot,
    Function,
    Rigid,
    Scheme,
    SetOf,
    TupleOf,
    Type,
    dotable,
    dotted,
    free_variables,
    parts,
    resolve,
    show,
    spread,
)


class DeclarationRules(AnnotationRules):
    """Infers groups of declarations that depend on each other."""

    # --- groups ----------------------------------------------------------------------------------------------

    def local_declarations(self, declarations: Iterable[syntax.Declaration]) -> None:
        """Infer the declarations of a ``let``. Only those with an annotation can be polymorphic."""
        units = units_of(declarations, self.names)
        for unit in units:
            self.annotate(unit.symbols)
        for group in components(units):
            self.level += 1
            self._begin(group)
            for unit in group:
                self.declaration(unit.declaration)
            self._end(group)
            self.level -= 1
            for symbol in (symbol for unit in group for symbol in unit.symbols):
                self._keep_monomorphic(symbol)

    def _keep_monomorphic(self, symbol: Symbol) -> None:
        """Hand the variables of a local definition over to the definition around it, but remember them."""
        if self.names.annotation(symbol) is not None:
            return
        for variable in free_variables(self.views.schemes[symbol].type):
            if variable.level > self.level:
                self.unifier.save(variable)
                variable.level = self.level
                self.shared.add(symbol)

    def annotate(self, symbols: Iterable[Symbol]) -> None:
        """Give the annotated ones of *symbols* their schemes. Raises Rejected."""
        for symbol in symbols:
            annotation = self.names.annotation(symbol)
            if annotation is not None:
                self.views.schemes[symbol] = self.annotated_scheme(annotation)

    def group(self, group: Sequence[DependencyUnit], depth: int) -> None:
        """Infer declarations that depend on each other and generalise them; *depth* is that of their modules.

        Raises:
            Rejected: one of them has no type; then none of them has.
        """
        self.level = depth + 1
        # Datatypes first: what other declarations of the group do with values depends on their fields.
        ordered = sorted(group, key=lambda unit: not isinstance(unit.declaration, syntax.DatatypeDeclaration))
        self._begin(ordered)
        for unit in ordered:
            self.declaration(unit.declaration)
        self._end(ordered)
        self.check_dots()
        self.level = depth
        for unit in ordered:
            for symbol in unit.symbols:
                if self.names.annotation(symbol) is None:
                    self.views.schemes[symbol] = self.generalise(
                        self.views.schemes[symbol].type, unit.declaration, symbol.name
                    )
            self._check_definite(unit.declaration)
        self.unifier.forget()

    def _begin(self, group: Sequence[DependencyUnit]) -> None:
        """Give every symbol of the group without an annotation a type to be found out.

        Of a function it is known how many arguments it takes, so that a wrong call among the definitions of the group
        is seen at the call, and not where the definition is held against what the call has made of it.
        """
        for unit in group:
            for symbol in unit.symbols:
                if self.names.annotation(symbol) is None:
                    unknown: Type = self.fresh()
                    if isinstance(unit.declaration, syntax.FunctionDefinition):
                        for parameters in reversed(unit.declaration.clauses[0].groups):
                            unknown = Function([self.fresh() for _ in parameters], unknown)
                    self.defining[symbol] = unknown
                    self.views.schemes[symbol] = Scheme((), unknown)

    def _end(self, group: Sequence[DependencyUnit]) -> None:
        """Decide which datatypes of the group have equality."""
        decide_equality(
            [
                self.views.datatype(self.names.symbol(unit.declaration))
                for unit in group
                if isinstance(unit.declaration, syntax.DatatypeDeclaration) and not unit.declaration.subtype
            ]
        )

    def declaration(self, declaration: syntax.Declaration) -> None:
        """Infer one declaration, whose symbols have variables or schemes already. Raises Rejected."""
        match declaration:
            case syntax.FunctionDefinition():
                self._function(declaration)
            case syntax.PatternDefinition():
                self._pattern_definition(declaration)
            case syntax.ChannelDeclaration():
                self._channel(declaration)
            case syntax.DatatypeDeclaration(subtype=True):
                self._subtype(declaration)
            case syntax.DatatypeDeclaration():
                self._datatype(declaration)
            case syntax.NametypeDeclaration():
                self._nametype(declaration)
            case syntax.TimedDeclaration():
                self._timed(declaration)

    # --- functions and values --------------------------------------------------------------------------------

    def _function(self, node: syntax.FunctionDefinition) -> None:
        symbol = self.names.symbol(node)
        if self.names.annotation(symbol) is None:
            type_ = self.defining[symbol]
            clauses = [self._clause(clause, None) for clause in node.clauses]
            for clause, clause_type in zip(node.clauses, clauses, strict=True):
                self._same_clauses(node, clause, clauses[0], clause_type)
            first = node.clauses[0]
            self.agree(type_, clauses[0], first, f"this definition of `{node.name}`")
            return
        outer, level = self.rigid, self.level
        scheme = self.views.schemes[symbol]
        self.level += 1
        type_, rigid = self.inside(symbol, scheme)
        self.rigid = outer | rigid
        for clause in node.clauses:
            self._clause(clause, type_)
        self.rigid, self.level = outer, level

    @INFERS(syntax.Clause)
    def _clause(self, clause: syntax.Clause, expected: Type | None) -> Type:
        """The type of one clause; *expected* is the annotated one."""
        groups = [[self.infer(pattern) for pattern in group] for group in clause.groups]
        role = "the result"
        for group, patterns in zip(clause.groups, groups, strict=True):
            # A variable behind a constructor in a pattern takes all that the constructor wants.
            patterns[:] = [self.settle(t, node, "the pattern") for t, node in zip(patterns, group, strict=True)]
            if expected is not None:
                expected = self._annotated_parameters(clause, group, patterns, expected)
                role = "the annotated result"
        result = self.infer(clause.body)
        if expected is not None:
            self.agree(expected, result, clause.body, role)
        result = self.settle(result, clause.body, role)
        for group, patterns in zip(reversed(clause.groups), reversed(groups), strict=True):
            settled = [self.settle(t, node, "the pattern") for t, node in zip(patterns, group, strict=True)]
            result = Function(settled, result)
        return result

    def _annotated_parameters(
        self, clause: syntax.Clause, group: Sequence[syntax.Pattern], patterns: Sequence[Type], expected: Type
    ) -> Type:
        """Hold a group of parameters against the annotated type; what is left of that behind them."""
        function = resolve(expected)
        if type(function) is not Function or len(function.parameters) != len(group):
            actual = Function(patterns, self.fresh())
            self.agree(expected, actual, clause, "this definition")
            raise AssertionError(expected)
        for parameter, pattern, node in zip(function.parameters, patterns, group, strict=True):
            self.accept(pattern, parameter, node, "the annotated parameter")
        return function.result

    def _same_clauses(self, node: syntax.FunctionDefinition, clause: syntax.Clause, first: Type, other: Type) -> None:
        """All clauses of a function have one type."""
        if first is other:
            return
        one = node.clauses[0]
        for group, first_group in zip(clause.groups, one.groups, strict=True):
            assert type(first) is Function
            assert type(other) is Function
            for i, pattern in enumerate(group):
                expected, actual = first.parameters[i], other.parameters[i]
                origin = self._elsewhere(first_group[i], expected, "in the first clause it")
                self.agree(expected, actual, pattern, f"this parameter of `{node.name}`", origin)
            first, other = first.result, other.result
        origin = self._elsewhere(one.body, first, "the first clause")
        self.agree(first, other, clause.body, f"this clause of `{node.name}`", origin)

    def _pattern_definition(self, node: syntax.PatternDefinition) -> None:
        symbols = declared(node, self.names)
        annotated = [symbol for symbol in symbols if self.names.annotation(symbol) is not None]
        outer, level = self.rigid, self.level
        self.level += bool(annotated)
        rigid: dict[str, Rigid] = {}
        for symbol in annotated:
            self.defining[symbol], variables = self.inside(symbol, self.views.schemes[symbol])
            rigid |= variables
        self.rigid = outer | rigid
        pattern = self.infer(node.pattern)
        body = self.infer(node.body)
        if isinstance(node.pattern, syntax.NamePattern) and len(symbols) == 1:
            role = f"the annotated value of `{node.pattern.text}`" if annotated else "the value"
        else:
            role = "the value that the pattern takes apart"
        self.accept(pattern, body, node.body, role)
        self.rigid, self.level = outer, level

    def _timed(self, node: syntax.TimedDeclaration) -> None:
        if node.duration is not None:
            self.check(node.duration, Function([EVENT], INT), "the duration function of the Timed section")

    # --- channels and types ----------------------------------------------------------------------------------

    def _elements(self, node: syntax.Expr, type_: Type, place: str) -> Type:
        """The type of the values in the set that *node*, of *type_*, denotes where fields are declared.

        There a dot or a tuple of sets is the set of the dots or tuples of their elements.
        """
        head = resolve(type_)
        if type(head) is TupleOf:
            return TupleOf([self._elements(node, item, place) for item in head.items])
        if type(head) is Dot:
            return dotted([self._elements(node, part, place) for part in parts(head)])
        element = self.fresh()
        self.agree(SetOf(element), head, node, place)
        return element

    def _fields(self, node: syntax.Expr | None, place: str, constraints: Constraints = 0) -> list[Type]:
        """The types of the fields that a declaration gives to a channel or constructor.

        They are complete, and satisfy *constraints*: events must be comparable, datatype values need not.
        """
        if node is None:
            return []
        whole = self.settle(self._elements(node, self.infer(node), place), node, place)
        fields = parts(whole)
        for field in fields:
            self.require(COMPLETE | constraints, field, node, place)
        return fields

    def _declare(self, symbol: Symbol, type_: Type, node: syntax.Node) -> None:
        """Give a channel, constructor or set the type that its declaration makes."""
        annotation = self.names.annotation(symbol)
        if annotation is None:
            self.agree(self.defining[symbol], type_, node, f"`{symbol.name}`")
            return
        scheme = self.views.schemes[symbol]
        if scheme.variables:
            # Nothing that a declaration makes is polymorphic, so a variable is one that it has to fix.
            annotated, _ = self.inside(symbol, scheme)
        else:
            annotated = scheme.type
        self.agree(annotated, type_, node, f"`{symbol.name}`, as annotated,")

    def _channel(self, node: syntax.ChannelDeclaration) -> None:
        fields = self._fields(node.fields, "a channel's field", EQ)
        for name in node.names:
            self._declare(self.names.symbol(name), dotable(fields, EVENT), name)

    def _datatype(self, node: syntax.DatatypeDeclaration) -> None:
        symbol = self.names.symbol(node)
        datatype = self.views.datatype(symbol)
        self._declare(symbol, SetOf(datatype), node)
        for constructor in node.constructors:
            fields = self._fields(constructor.fields, "a constructor's field")
            datatype.fields[constructor.name] = tuple(fields)
            self._declare(self.names.symbol(constructor), dotable(fields, datatype), constructor)

    def _subtype(self, node: syntax.DatatypeDeclaration) -> None:
        parent: Type | None = None
        for constructor in node.constructors:
            symbol = self.names.symbol(constructor)
            declared_fields, datatype = spread(self.symbol_type(symbol))
            where = () if symbol.constructor is None else (Label(symbol.constructor.span, "declared here"),)
            if parent is None:
                parent = datatype
                self._declare(self.names.symbol(node), SetOf(parent), node)
            elif datatype is not parent:
                old, new = show(parent, datatype)
                raise Rejected(messages.subtype_mixes(symbol.name, constructor.span, old, new, where))
            given = self._fields(constructor.fields, "a constructor's field")
            if len(given) > len(declared_fields):
                raise Rejected(
                    messages.subtype_fields(symbol.name, constructor.span, len(declared_fields), len(given), where)
                )
            for declared_field, field in zip(declared_fields, given, strict=False):
                assert constructor.fields is not None
                self.agree(declared_field, field, constructor.fields, f"a field of `{symbol.name}`")

    def _nametype(self, node: syntax.NametypeDeclaration) -> None:
        fields = self._fields(node.body, "the nametype")
        self._declare(self.names.symbol(node), SetOf(dotted(fields)), node)

    # --- definite types --------------------------------------------------------------------------------------

    def _check_definite(self, declaration: syntax.Declaration) -> None:
        """The fields of channels and constructors must have definite types, unless a module's parameter gives them."""
        if not isinstance(declaration, syntax.ChannelDeclaration | syntax.DatatypeDeclaration):
            return
        for symbol in declared(declaration, self.names):
            if symbol.kind in (SymbolKind.CHANNEL, SymbolKind.CONSTRUCTOR):
                scheme = self.views.schemes[symbol]
                self.check_definite(symbol, scheme, [v for v in scheme.variables if type(v) is not Rigid])

    def check_definite(self, symbol: Symbol, scheme: Scheme, variables: Sequence[Type]) -> None:
        """Reject a channel or constructor with a field whose type has one of *variables*."""
        fields, result = spread(scheme.type)
        for number, field in enumerate(fields, 1):
            if any(variable in variables for variable in free_variables(field)):
                kind = "constructor" if type(result) is Datatype else "channel"
                shown, made = show(scheme.type, result)
                assert symbol.span is not None
                raise Rejected(
                    messages.ambiguous_field(symbol.name, kind, symbol.span, shown, number, len(fields), made)
                )
