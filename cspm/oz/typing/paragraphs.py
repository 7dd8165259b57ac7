"""Types, schemas and constants, at the top of a script or inside a class, elaborated in order of need."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter

from cspcheck.cspm.diagnostics import DiagnosticSink
from cspcheck.cspm.oz import core, syntax as s
from cspcheck.cspm.oz.core import INT, Apply, Constant, Declared, SetType
from cspcheck.cspm.oz.reading import messages as reading_messages
from cspcheck.cspm.oz.typing import messages as messages, type_messages as type_messages
from cspcheck.cspm.oz.typing.schemas import TypedSchema as Components
from cspcheck.cspm.oz.typing.scopes import (
    ConstructorEntry,
    FailedEntry,
    GenericEntry,
    SetEntry,
    TypingScope,
    VariableEntry,
    mentioned,
    whole,
)
from cspcheck.cspm.oz.typing.typing import Typing
from cspcheck.cspm.oz.typing.typing_operators import Wrong
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax


class DeclaredParagraphs:
    """What paragraphs have declared so far.

    Attributes:
        givens, frees, constants, axioms: for the specification. Records go to the shared table of the typing.
    """

    def __init__(
        self, typing: Typing, scope: TypingScope, records: dict[str, core.RecordDefinition], report: DiagnosticSink
    ) -> None:
        self.typing = typing
        self.scope = scope
        self.records = records
        self.report = report
        self.givens: dict[str, Span] = {}
        self.frees: dict[str, core.FreeDefinition] = {}
        self.constants: list[Declared] = []
        self.axioms: list[core.Term] = []
        self._claimed: dict[str, Span] = {}

    def inside(self, scope: TypingScope) -> DeclaredParagraphs:
        """A collection for the paragraphs of a class; its types belong to the specification, its constants do not."""
        inner = DeclaredParagraphs(self.typing, scope, self.records, self.report)
        inner.givens, inner.frees = self.givens, self.frees
        return inner

    def claim(self, name: str, span: Span) -> None:
        """Take a name; one that is taken is reported."""
        first = self._claimed.setdefault(name, span)
        if first != span:
            self.report(type_messages.declared_twice(name, first, span))

    # --- what CSPm declares -----------------------------------------------------------------------------------

    def script_values(self, declarations: Sequence[syntax.Declaration]) -> None:
        """Make datatypes of constants, ranges and integer constants of the script's CSPm part known to classes."""
        for declaration in declarations:
            match declaration:
                case syntax.DatatypeDeclaration(subtype=False) if all(
                    c.fields is None for c in declaration.constructors
                ):
                    type_ = core.FreeType(declaration.name)
                    branches = tuple([(c.name, None) for c in declaration.constructors])
                    self.frees[declaration.name] = core.FreeDefinition(
                        name=declaration.name, branches=branches, span=declaration.span
                    )
                    self.scope.add(declaration.name, SetEntry(whole(type_), declaration.span))
                    for c in declaration.constructors:
                        self.scope.add(c.name, ConstructorEntry(c.name, type_, None, c.span))
        numbers: dict[str, int] = {}
        for declaration in declarations:
            match declaration:
                case syntax.PatternDefinition(pattern=syntax.NamePattern() as pattern):
                    value = _number(declaration.body, numbers)
                    if value is not None:
                        numbers[pattern.text] = value
                        entry = VariableEntry(Constant(type=INT, value=value), declaration.span)
                        self.scope.add(pattern.text, entry)
                case syntax.NametypeDeclaration(body=syntax.SetRange(statements=None) as body):
                    low = _number(body.low, numbers)
                    high = None if body.high is None else _number(body.high, numbers)
                    if low is not None and high is not None:
                        ends = (Constant(type=INT, value=low), Constant(type=INT, value=high))
                        range_ = Apply(type=SetType(INT), operator="range", operands=ends)
                        self.scope.add(declaration.name, SetEntry(range_, declaration.span))

    # --- paragraphs -------------------------------------------------------------------------------------------

    def elaborate(self, paragraphs: Iterable[s.Paragraph]) -> None:
        """Elaborate types, abbreviations, schemas and constants, each after those that it mentions."""
        own = [p for p in paragraphs if isinstance(p, s.GivenTypes | s.FreeType | s.Abbreviation | s.Schema | s.Axiom)]
        providers: dict[str, int] = {}
        for number, paragraph in enumerate(own):
            for name, span in names_of(paragraph):
                self.claim(name, span)
                providers.setdefault(name, number)
            match paragraph:
                case s.GivenTypes():
                    for given in paragraph.names:
                        self.givens[given.name] = given.span
                        self.scope.add(given.name, SetEntry(whole(core.GivenType(given.name)), given.span))
                case s.FreeType():
                    self.scope.add(paragraph.name, SetEntry(whole(core.FreeType(paragraph.name)), paragraph.span))
        sorter: TopologicalSorter[int] = TopologicalSorter()
        for number, paragraph in enumerate(own):
            needs = {providers[name] for name in _needs(paragraph) if name in providers}
            if isinstance(paragraph, s.FreeType):
                needs.discard(number)  # free types may be recursive, also by way of each other
                needs = {n for n in needs if not isinstance(own[n], s.FreeType)}
            sorter.add(number, *sorted(needs))
        try:
            order = list(sorter.static_order())
        except CycleError as cycle:
            first = own[cycle.args[1][0]]
            name = next(iter(names_of(first)), ("this", first.span))[0]
            self.report(messages.recursive_schema(name, first.span))
            return
        for number in order:
            try:
                self._one(own[number])
            except Wrong as wrong:
                self.report(wrong.diagnostic)
                for name, _ in names_of(own[number]):
                    self.scope.add(name, FailedEntry(wrong.diagnostic))

    def _one(self, paragraph: s.Paragraph) -> None:
        match paragraph:
            case s.FreeType():
                self._free(paragraph)
            case s.Abbreviation():
                if paragraph.generics:
                    self.scope.add(paragraph.name, GenericEntry(paragraph, self.scope))
                elif not isinstance(paragraph.body, s.Reference) and self._is_schema(paragraph.body):
                    self._once(paragraph.name, self.records.get(paragraph.name), paragraph.span)
                    value = self.typing.schemas.needed(paragraph.body, self.scope)
                    term = self.typing.schemas.named(paragraph.name, value, paragraph.span)
                    self.scope.add(paragraph.name, SetEntry(term, paragraph.span, schema=paragraph.name))
                else:
                    term = self.typing.expression(paragraph.body, self.scope, "axiom")
                    self.scope.add(paragraph.name, SetEntry(term, paragraph.span))
            case s.Schema() if paragraph.generics:
                body = s.SchemaText(
                    span=paragraph.span, declarations=paragraph.declarations, predicates=paragraph.predicates
                )
                named = s.Abbreviation(span=paragraph.span, name=paragraph.name, body=body, generics=paragraph.generics)
                self.scope.add(paragraph.name, GenericEntry(named, self.scope))
            case s.Schema():
                self._schema(paragraph)
            case s.Axiom() if paragraph.generics:
                for name, span in names_of(paragraph):
                    told = reading_messages.unsupported(span, "a constant for every choice of sets")
                    self.report(told)
                    self.scope.add(name, FailedEntry(told))
            case s.Axiom():
                self._axiom(paragraph)

    def _is_schema(self, body: s.Term) -> bool:
        """Whether an expression is one of the schema calculus."""
        return self.typing.schemas.value(body, self.scope) is not None

    def _free(self, paragraph: s.FreeType) -> None:
        type_ = core.FreeType(paragraph.name)
        branches: list[tuple[str, core.Term | None]] = []
        for branch in paragraph.branches:
            carrier = None if branch.argument is None else self.typing.carrier(branch.argument, self.scope)
            branches.append((branch.name, carrier))
            self.scope.add(branch.name, ConstructorEntry(branch.name, type_, carrier, branch.span))
        self._once(paragraph.name, self.frees.get(paragraph.name), paragraph.span)
        self.frees[paragraph.name] = core.FreeDefinition(
            name=paragraph.name, branches=tuple(branches), span=paragraph.span
        )

    def _once(self, name: str, known: core.FreeDefinition | core.RecordDefinition | None, span: Span) -> None:
        """Types are told apart by their names, wherever they are declared: two of one name are a mistake."""
        if known is not None and known.span != span:
            self.report(type_messages.declared_twice(name, known.span, span))

    def _schema(self, paragraph: s.Schema) -> None:
        fields = tuple(self.declared(paragraph.declarations, self.scope, decorated=True))
        included = tuple(self.included(paragraph.declarations, self.scope))
        inner = self.typing.schemas.inside(Components(fields), self.scope)
        predicates = (*included, *self.predicates(paragraph.predicates, inner, "record"))
        initial = None if paragraph.initial is None else self.predicates(paragraph.initial, inner, "initial")
        self._once(paragraph.name, self.records.get(paragraph.name), paragraph.span)
        schema = Components(fields, predicates)
        term = self.typing.schemas.named(paragraph.name, schema, paragraph.span, initial)
        self.scope.add(paragraph.name, SetEntry(term, paragraph.span, schema=paragraph.name))

    def _axiom(self, paragraph: s.Axiom) -> None:
        for constant in self.declared(paragraph.declarations, self.scope, decorated=True):
            self.constants.append(constant)
            variable = core.Variable(type=constant.type, name=constant.name, role="constant", span=constant.span)
            self.scope.add(constant.name, VariableEntry(variable, constant.span))
        table = {c.name: c for c in self.constants}
        self.axioms.extend(
            substituted(p, lambda v: _constant(table.get(v.name)) if v.role == "bound" else None)
            for p in self.included(paragraph.declarations, self.scope)
        )
        self.axioms.extend(self.predicates(paragraph.predicates, self.scope, "axiom"))

    # --- parts ------------------------------------------------------------------------------------------------

    def declared(
        self, declarations: Sequence[s.Declare], scope: TypingScope, *, decorated: bool = False
    ) -> Iterator[Declared]:
        """The names of declarations with types and carriers; wrong ones are reported and left out.

        With *decorated* names keep their decorations, as the components of a schema do. What an included schema
        declares is among them; what is declared twice that way is so in the same type.
        """
        seen: dict[str, Declared] = {}
        own: set[str] = set()
        for declaration in declarations:
            try:
                found = self.typing.schemas.declared([declaration], scope)
            except Wrong as wrong:
                self.report(wrong.diagnostic)
                for name in declaration.names:
                    scope.add(name.name + name.decoration, FailedEntry(wrong.diagnostic))
                continue
            for field in found.fields:
                name_ = field.name if decorated else field.name.rstrip("'?!")
                first = seen.get(name_)
                if first is None:
                    seen[name_] = replace(field, name=name_)
                    yield seen[name_]
                elif first.type != field.type or (declaration.names and name_ in own):
                    self.report(type_messages.declared_twice(name_, first.span, field.span))
                own |= {name_} if declaration.names else set()

    def included(self, declarations: Sequence[s.Declare], scope: TypingScope) -> Iterator[core.Term]:
        """What included schemas say, of bound variables with the names of their components."""
        if all(declaration.names for declaration in declarations):
            return
        try:
            yield from self.typing.schemas.declared(declarations, scope).predicates
        except Wrong as wrong:
            self.report(wrong.diagnostic)

    def predicates(self, trees: Sequence[s.Term], scope: TypingScope, place: str) -> tuple[core.Term, ...]:
        """The predicates that could be made sense of; mistakes in the others are reported."""
        found = []
        for tree in trees:
            try:
                found.append(self.typing.predicate(tree, scope, place))  # type: ignore[arg-type]
            except Wrong as wrong:
                self.report(wrong.diagnostic)
        return tuple(found)


def _constant(constant: Declared | None) -> core.Term | None:
    if constant is None:
        return None
    return core.Variable(type=constant.type, name=constant.name, role="constant", span=constant.span)


def names_of(paragraph: s.Paragraph) -> Iterator[tuple[str, Span]]:
    """What a paragraph declares, with the places."""
    match paragraph:
        case s.GivenTypes():
            for name in paragraph.names:
                yield name.name, name.span
        case s.FreeType():
            yield paragraph.name, paragraph.span
            for branch in paragraph.branches:
                yield branch.name, branch.span
        case s.Abbreviation() | s.Schema():
            yield paragraph.name, paragraph.span
        case s.Axiom():
            for declaration in paragraph.declarations:
                for declared in declaration.names:
                    yield declared.name, declared.span


def _needs(paragraph: s.Paragraph) -> Iterator[str]:
    terms: list[s.Term | None] = []
    own: set[str] = set()
    match paragraph:
        case s.FreeType():
            terms = [branch.argument for branch in paragraph.branches]
        case s.Abbreviation():
            terms = [paragraph.body]
            own = {name.name for name in paragraph.generics}
        case s.Schema():
            terms = [d.carrier for d in paragraph.declarations]
            own = {name.name for name in paragraph.generics}
            yield from (name for name in _names(terms) if name not in own)
            own |= {name.name for d in paragraph.declarations for name in d.names}
            terms = [*paragraph.predicates, *(paragraph.initial or ())]
        case s.Axiom():
            own = {name.name for d in paragraph.declarations for name in d.names}
            terms = [*[d.carrier for d in paragraph.declarations], *paragraph.predicates]
    yield from (name for name in _names(terms) if name not in own)


def _names(terms: Iterable[s.Term | None]) -> Iterator[str]:
    return (reference.name for reference in mentioned(terms))


def _number(node: syntax.Expr, known: dict[str, int]) -> int | None:
    """The value of an integer expression over literals and names of such; None for anything else."""
    match node:
        case syntax.LiteralExpr(kind="int", value=int() as value):
            return value
        case syntax.Paren():
            return _number(node.inner, known)
        case syntax.Name() if len(node.parts) == 1:
            return known.get(node.parts[0])
        case syntax.Unary(operator="-"):
            operand = _number(node.operand, known)
            return None if operand is None else -operand
        case syntax.Binary(operator="+" | "-" | "*"):
            left, right = _number(node.left, known), _number(node.right, known)
            if left is None or right is None:
                return None
            return {"+": left + right, "-": left - right, "*": left * right}[node.operator]
    return None
