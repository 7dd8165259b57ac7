"""Data independence of a process: what all the definitions that it uses do with the values of a type.

The conditions are those of Lazić (*A Semantic Study of Data Independence with Applications to Model Checking*,
1999) and Roscoe (*The Theory and Practice of Concurrency*, 1997, 15.3): no value of the type is named; the whole type
occurs where a value is input, chosen, or in an event; nothing is asked from which the number of its values could be
told. Values are *tested* where they are compared, kept in sets, or where two parties would both have to output the
same one.
Whatever is not known here to be harmless is refused.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Final

from cspcheck.checker.independence.types import Touched
from cspcheck.checker.independence.uses import DataUse, Dependent, Use, total
from cspcheck.cspm.naming.symbols import Names, Symbol, SymbolKind
from cspcheck.cspm.oz.processes.nodes import CarrierSet, ClassProcess, ConstantValue
from cspcheck.cspm.syntax import tree as s
from cspcheck.cspm.syntax.children import children
from cspcheck.cspm.typing.inference import Types
from cspcheck.cspm.typing.types import Dot, resolve, spread

if TYPE_CHECKING:
    from cspcheck.checker.independence.classes import Carried

HARMLESS: Final = frozenset(
    {
        *("STOP", "SKIP", "DIV", "CHAOS", "RUN", "Events", "True", "False", "Int", "Bool", "Char"),
        *("length", "null", "head", "tail", "concat", "error"),
        *("normal", "normalise", "lazynorm", "sbisim", "dbisim", "wbisim", "diamond", "tau_loop_factor"),
        *("model_compress", "explicate", "lazyenumerate"),
    }
)
"""Built-in names that do the same whatever values there are."""
COMPRESSIONS: Final = frozenset(
    {
        *("normal", "normalise", "lazynorm", "sbisim", "dbisim", "wbisim", "diamond", "tau_loop_factor"),
        *("model_compress", "explicate", "lazyenumerate"),
    }
)
COMPARING: Final = frozenset(
    {
        *("union", "inter", "diff", "Union", "Inter", "set", "card", "empty", "member", "elem", "emptyMap"),
        *("mapFromList", "mapLookup", "mapMember", "mapUpdate", "mapUpdateMultiple", "mapDelete"),
    }
)
"""Built-in functions that compare values and do not ask for their order."""
COUNTING: Final = frozenset({"card", "empty"})
"""Those that tell how many events there are."""
_PLAIN: Final = (
    s.LiteralExpr, s.Paren, s.TupleExpr, s.MapExpr, s.Unary, s.Dot, s.Apply, s.Lambda, s.If, s.Guard,
    s.ProcessBinary, s.Hide, s.Qualifier,
)  # fmt: skip
"""Forms that are harmless where their parts are."""

Outputs = frozenset[Symbol]
ANY: Final = Symbol("any channel", SymbolKind.CHANNEL, None)
"""In a set of channels: one of which is not known which."""


class ScriptReader:
    """What is known of one script and one of its types.

    Args:
        names, types: of the script.
        symbol: the datatype, all of whose values are constants.
        given: what it is called in the Object-Z part.
    """

    def __init__(self, names: Names, types: Types, symbol: Symbol, given: str) -> None:
        self.names = names
        self.types = types
        self.symbol = symbol
        self.given = given
        self.touched = Touched(types.datatype(symbol))
        if names.clocks:
            raise Dependent("time passes")
        counts: list[int | None] = [0]
        for channel in names:
            if channel.kind is SymbolKind.CHANNEL and channel.instance is None:
                fields, _ = spread(types.scheme(channel).type)
                counts.append(total([self.touched.slots(field) for field in fields]))
        self.touched.event_slots = None if None in counts else max(c for c in counts if c is not None)
        self._data: dict[str, DataUse] = {}

    def touches(self, node: s.Expr | s.Pattern) -> bool:
        """Whether values of an expression or a pattern have some of the type inside."""
        while isinstance(node, s.Paren | s.ParenPattern):
            node = node.inner
        try:
            return self.touched.touches(self.types.type_of(node))
        except KeyError:
            if isinstance(node, s.Dot | s.DotPattern):
                return self.touches(node.left) or self.touches(node.right)
            raise Dependent("an expression has no type of its own") from None

    def has_events(self, node: s.Expr | s.Pattern) -> bool:
        """Whether values of an expression are events that may have values of the type inside, or have such inside."""
        try:
            return self.touched.has_events(self.types.type_of(node))
        except KeyError:
            return True

    def is_every(self, node: s.Expr, inside: tuple[Symbol, ...] = ()) -> bool:
        """Whether a set has all values of its type that consist of values of the type in question.

        *inside* are the names that it stands behind.
        """
        match node:
            case s.Paren():
                return self.is_every(node.inner, inside)
            case s.Dot():
                return self._is_fit(node.left, inside) and self._is_fit(node.right, inside)
            case CarrierSet():
                from cspcheck.checker.independence.classes import ClassReader  # most scripts have no classes
                from cspcheck.cspm.oz import core

                reader = ClassReader(self.carried(node), core.ClassModel(name="", span=node.span))
                for carrier in node.carriers:
                    reader.carrier(carrier)
                return True
            case s.Name():
                symbol = self.names.find(node)
                if symbol is None or symbol.instance is not None or symbol in inside:
                    return False
                inside = (*inside, symbol)
                declaration = symbol.declaration
                if symbol.kind is SymbolKind.DATATYPE and isinstance(declaration, s.DatatypeDeclaration):
                    fields = [c.fields for c in declaration.constructors if c.fields is not None]
                    return symbol is self.symbol or (bool(fields) and all(self._is_fit(f, inside) for f in fields))
                if isinstance(declaration, s.NametypeDeclaration | s.PatternDefinition):
                    return self.is_every(declaration.body, inside)
        return False

    def _is_fit(self, node: s.Expr, inside: tuple[Symbol, ...]) -> bool:
        return self.is_every(node, inside) or (not self.touches(node) and not isinstance(node, s.Dot))

    def carried(self, node: CarrierSet | ClassProcess) -> Carried:
        """Where values of the type are in the Object-Z part."""
        from cspcheck.checker.independence.classes import Carried

        return Carried(self.given, node.context)

    def data(self, node: ClassProcess) -> DataUse:
        """How the data part of a class treats the values.

        Raises:
            Dependent: it may depend on their number.
        """
        if node.context.control or node.context.angelic:
            raise Dependent("classes are not read as they are written")
        found = self._data.get(node.model.name)
        if found is None:
            from cspcheck.checker.independence.classes import ClassReader

            found = self._data[node.model.name] = ClassReader(self.carried(node), node.model).use()
        return found


class ProcessReader:
    """Looks at everything that some process uses; :attr:`use` says how it treats the values.

    Raises:
        Dependent: by its constructor, where the process may depend on the number of values.
    """

    def __init__(self, script: ScriptReader, process: s.Expr) -> None:
        self.script = script
        self.names = script.names
        self.use = Use()
        self._seen: set[Symbol] = set()
        self._outputs: dict[Symbol, Outputs] = {}
        self.visit(process)
        self._settle_outputs(process)

    @property
    def meets_values(self) -> bool:
        """Whether it has to do with values of the type at all: some channel carries them."""
        script = self.script
        channels = [symbol for symbol in self._seen if symbol.kind is SymbolKind.CHANNEL]
        return any(map(script.touched.touches, [f for c in channels for f in spread(script.types.scheme(c).type)[0]]))

    # --- what is there ---------------------------------------------------------------------------------------------

    def visit(self, node: s.Node) -> None:
        """Look at an expression and all definitions that it uses."""
        stack: list[s.Node] = [node]
        while stack:
            current = stack.pop()
            if isinstance(current, s.Expr) and not isinstance(current, s.Foreign):
                self._typed(current)
            stack.extend(self._inside(current))

    def _typed(self, node: s.Expr) -> None:
        try:
            type_ = self.script.types.type_of(node)
        except KeyError:
            return  # a dot inside a longer one, whose type tells
        if self.script.touched.compares(type_):
            self.use.tests = True

    def _inside(self, node: s.Node) -> Iterable[s.Node]:
        """What else has to be looked at for *node*.

        Raises:
            Dependent: nothing can be said of it.
        """
        script = self.script
        match node:
            case s.Name():
                return self._named(node)
            case s.Apply(function=s.Name() as function):
                symbol = self.names.find(function)
                is_counting = symbol is not None and symbol.kind is SymbolKind.BUILTIN and symbol.name in COUNTING
                if is_counting and any(map(script.has_events, node.arguments)):
                    raise Dependent("events are counted")
                return children(node)
            case s.Binary():
                if node.operator != "^" and script.touches(node.left):
                    empty = any(isinstance(side, s.SequenceExpr) and not side.items for side in (node.left, node.right))
                    self.use.tests |= not empty
                    if node.operator not in ("==", "!="):
                        self._ordered(node.left)
                if script.has_events(node.left):
                    self.use.tests = True
                    if not _is_event(script, node.left):
                        raise Dependent("sets of events are compared")
                return children(node)
            case s.SetExpr() | s.SequenceExpr() | s.Productions():
                return [*self._events(node), *self._statements(node.statements or (), every=script.has_events(node))]
            case s.SetRange() | s.SequenceRange():
                low = [node.low] if node.high is None else [node.low, node.high]
                return [*low, *self._statements(node.statements or (), every=False)]
            case s.Prefix():
                return self._prefix(node)
            case s.Replicated():
                return self._replicated(node)
            case s.Synchronised():
                return [node.left, node.right, node.events]
            case s.AlphabetisedParallel() | s.ClassParallel():
                return children(node)
            case s.LinkedParallel():
                ends = [end for link in node.links for end in link]
                return [node.left, node.right, *ends, *self._statements(node.statements or (), every=True)]
            case s.Rename():
                ends = [end for pair in node.pairs for end in pair]
                return [node.process, *ends, *self._statements(node.statements or (), every=True)]
            case s.Let():
                return [node.body]  # what is used of its declarations is met by name
            case s.FunctionDefinition() | s.Clause() | s.PatternDefinition() | s.NametypeDeclaration():
                return children(node)
            case ClassProcess():
                data = script.data(node)
                self._seen.update(map(self.names.symbol, node.channels))
                self.use.tests |= data.tests
                self.use.choose(data.chosen)
                return node.mains
            case CarrierSet():
                if script.carried(node).touches(node.element):
                    raise Dependent("all of its values are gone through")
                return ()
            case ConstantValue():
                if script.carried(node).touches(node.type):  # type: ignore[arg-type]
                    raise Dependent(f"the constant `{node.name}` has values of it")
                return ()
            case s.Pattern():
                return self._pattern(node)
            case _ if isinstance(node, _PLAIN):
                return children(node)
        raise Dependent(f"`{type(node).__name__}` is not looked into")

    def _ordered(self, node: s.Expr) -> None:
        """Refuse an order on the values themselves; sets and sequences are compared by what is in them."""
        head = resolve(self.script.types.type_of(node))
        if head is self.script.touched.datatype or type(head).__name__ not in ("SetOf", "SequenceOf"):
            raise Dependent("its values are ordered")

    def _named(self, node: s.Name) -> Iterable[s.Node]:
        symbol = self.names.find(node)
        if symbol is None or symbol.instance is not None:
            raise Dependent(f"`{node.text}` is of an instance of a module")
        declaration = symbol.declaration
        match symbol.kind:
            case SymbolKind.BUILTIN:
                type_ = self.script.types.type_of(node)
                touched = self.script.touched.touches(type_)
                if symbol.name in COMPARING:
                    self.use.tests |= touched
                elif symbol.name not in HARMLESS and (touched or symbol.name != "seq"):
                    raise Dependent(f"`{symbol.name}` may depend on it")
                return ()
            case SymbolKind.CONSTRUCTOR if declaration is self.script.symbol.declaration:
                raise Dependent(f"its value `{symbol.name}` is named")
            case SymbolKind.DATATYPE | SymbolKind.SUBTYPE if self.script.touched.touches(
                self.script.types.type_of(node)
            ):
                raise Dependent("all of its values are gone through")
            case SymbolKind.DATATYPE | SymbolKind.SUBTYPE | SymbolKind.CONSTRUCTOR | SymbolKind.VARIABLE:
                return ()
            case SymbolKind.CHANNEL:
                if symbol not in self._seen:
                    self._seen.add(symbol)
                    self._channel(symbol)
                return ()
        if symbol in self._seen or declaration is None:
            return ()
        if declaration is not None and self._is_set_of_all(declaration):
            raise Dependent("all of its values are gone through")
        self._seen.add(symbol)
        return [declaration]

    def _is_set_of_all(self, declaration: s.Node) -> bool:
        return isinstance(declaration, s.NametypeDeclaration | s.PatternDefinition) and self.script.is_every(
            declaration.body
        )

    def _channel(self, symbol: Symbol) -> None:
        """Look at what a channel carries."""
        declaration = symbol.declaration
        assert isinstance(declaration, s.ChannelDeclaration)
        waiting = [] if declaration.fields is None else [declaration.fields]
        while waiting:
            part = waiting.pop()
            part = s.bare(part)
            if isinstance(part, s.Dot):
                waiting += [part.left, part.right]
            elif isinstance(part, CarrierSet) or not self.script.is_every(part):
                if isinstance(part, CarrierSet):
                    self.script.is_every(part)
                elif isinstance(resolve(self.script.types.type_of(part)), Dot) or self.script.touches(part):
                    raise Dependent(f"`{symbol.name}` carries some of its values")
                # What else it carries has to do with the type only if it mentions it.
                else:
                    self.visit(part)

    def _pattern(self, node: s.Pattern) -> Iterable[s.Node]:
        symbol = self.names.find(node)
        if symbol is not None and symbol.kind is SymbolKind.CONSTRUCTOR:
            if symbol.declaration is self.script.symbol.declaration:
                raise Dependent(f"its value `{symbol.name}` is named")
        elif symbol is not None and symbol.kind is SymbolKind.CHANNEL:
            raise Dependent("events are taken apart")
        if isinstance(node, s.SetPattern) and node.items:
            self.use.tests = True
        return children(node)

    def _statements(self, statements: Sequence[s.Statement], *, every: bool) -> Iterable[s.Node]:
        """What to look at for statements; *every* allows generators over the whole type."""
        found: list[s.Node] = []
        for statement in statements:
            if isinstance(statement, s.Generator):
                found.append(statement.pattern)
                if not (every and self.script.is_every(statement.source)):
                    found.append(statement.source)
            else:
                found.append(statement)
        return found

    def _events(self, node: s.SetExpr | s.SequenceExpr | s.Productions) -> Iterable[s.Node]:
        """The items of a display; events with values that somebody holds are a comparison."""
        if self.script.has_events(node):
            statements = node.statements or ()
            every = all(isinstance(st, s.Generator) and self.script.is_every(st.source) for st in statements)
            for item in node.items:
                if _mentions_value(self.script, item) and not (every and statements):
                    self.use.tests = True
        return node.items

    # --- processes -------------------------------------------------------------------------------------------------

    def _prefix(self, node: s.Prefix) -> Iterable[s.Node]:
        found: list[s.Node] = [node.channel, node.body]
        for field in node.fields:
            if field.expression is not None:
                found.append(field.expression)
            if field.pattern is not None:
                found.append(field.pattern)
            if field.restriction is not None and not self.script.is_every(field.restriction):
                assert field.pattern is not None
                self.use.tests |= self.script.touches(field.pattern)
                found.append(field.restriction)
        return found

    def _replicated(self, node: s.Replicated) -> Iterable[s.Node]:
        script = self.script
        found: list[s.Node] = [node.body, *([] if node.events is None else [node.events])]
        found += [end for link in node.links for end in link]
        choice = node.operator in ("[]", "|~|")
        bound: list[int | None] = []
        for statement in node.statements:
            if isinstance(statement, s.Generator):
                touched = script.touches(statement.pattern) or script.has_events(statement.pattern)
                if touched and not choice:
                    raise Dependent("processes are composed, one for each of its values")
                if touched:
                    bound.append(script.touched.slots(script.types.type_of(statement.pattern)))
        if bound and node.operator == "[]" and not self.is_menu(node.body, ()):
            raise Dependent("a choice between all of its values may move on before it is made")
        if node.operator == "|~|":
            self.use.choose(total(bound))
        found += self._statements(node.statements, every=choice)
        return [*found, *self._statements(node.link_statements or (), every=True)]

    def is_menu(self, node: s.Expr, waiting: tuple[Symbol, ...]) -> bool:
        """Whether a process begins with visible events only, so that a choice is made before it moves."""
        match node:
            case s.Prefix():
                return all(field.kind != "$" for field in node.fields)
            case s.Paren():
                return self.is_menu(node.inner, waiting)
            case s.Guard() | s.Let():
                return self.is_menu(node.body, waiting)
            case s.If():
                return self.is_menu(node.then, waiting) and self.is_menu(node.otherwise, waiting)
            case s.ProcessBinary(operator="[]"):
                return self.is_menu(node.left, waiting) and self.is_menu(node.right, waiting)
            case s.Replicated(operator="[]"):
                return self.is_menu(node.body, waiting)
        symbol = self.called(node)
        if symbol is None:
            return False
        if symbol.kind is SymbolKind.BUILTIN:
            return symbol.name in ("STOP", "RUN")
        return symbol not in waiting and all(self.is_menu(body, (*waiting, symbol)) for body in bodies(symbol))

    def called(self, node: s.Expr) -> Symbol | None:
        """The definition, or the built-in process, that a process is an instance of."""
        node = s.bare(node)
        if isinstance(node, s.Apply):
            return self.called(node.function)
        symbol = self.names.find(node) if isinstance(node, s.Name) else None
        if symbol is None or symbol.kind not in (SymbolKind.BUILTIN, SymbolKind.VALUE, SymbolKind.FUNCTION):
            return None
        return symbol

    # --- who outputs what --------------------------------------------------------------------------------------------

    def _settle_outputs(self, process: s.Expr) -> None:
        """Find the channels on which each definition says what a value of the type is.

        Where two parties of one event do, that is a comparison. The least solution of the equations that the
        definitions are, by iteration.
        """
        symbols = [x for x in self._seen if x.kind in (SymbolKind.VALUE, SymbolKind.FUNCTION)]
        again = True
        while again:
            again = False
            for symbol in symbols:
                assert symbol.declaration is not None
                found = self.outputs(symbol.declaration)
                if found != self._outputs.get(symbol, frozenset()):
                    self._outputs[symbol] = found
                    again = True
        self.outputs(process)

    def outputs(self, node: s.Node) -> Outputs:
        """The channels on which a process says what a value of the type is, as far as that is known of its parts."""
        match node:
            case s.Name():
                symbol = self.names.find(node)
                return frozenset() if symbol is None else self._outputs.get(symbol, frozenset())
            case s.Prefix():
                return self._said(node) | self.outputs(node.body)
            case s.Rename():
                return self._renamed(node, self.outputs(node.process))
            case ClassProcess():
                data, mains = self._sides(node)
                self._meet(data, mains, None)
                return data | mains
            case s.Synchronised() | s.AlphabetisedParallel() | s.ClassParallel():
                left, right = self.outputs(node.left), self.outputs(node.right)
                shared = self.channels(node.events) if isinstance(node, s.Synchronised) else None
                if not (isinstance(node, s.Synchronised) and node.operator == "[|>"):
                    self._meet(left, right, shared)
                return left | right
            case s.LinkedParallel():
                left, right = self.outputs(node.left), self.outputs(node.right)
                self._link(left, right, node.links)
                return left | right
            case s.Replicated(operator="[]" | "|~|" | "|||" | ";"):
                pass
            case s.Replicated():
                inner = self.outputs(node.body)
                if node.operator == "<->":
                    self._link(inner, inner, node.links)
                else:
                    self._meet(inner, inner, None if node.events is None else self.channels(node.events))
                return inner
        return frozenset().union(*[self.outputs(child) for child in children(node)])

    def _sides(self, node: ClassProcess) -> tuple[Outputs, Outputs]:
        told = self.script.data(node).outputs
        data = frozenset([self.names.symbol(name) for name in node.channels if name.parts[0] in told])
        return data, frozenset().union(*[self.outputs(main) for main in node.mains])

    def _link(self, left: Outputs, right: Outputs, links: Sequence[tuple[s.Expr, s.Expr]]) -> None:
        """The left side performs the first channel of a link together with the second one of the right side."""
        for first, second in links:
            ends = self.heads(first) | {ANY}, self.heads(second) | {ANY}
            if left and right and (len(ends[0]) == 1 or left & ends[0]) and (len(ends[1]) == 1 or right & ends[1]):
                self.use.tests = True

    def _meet(self, left: Outputs, right: Outputs, shared: Outputs | None) -> None:
        """Two sides perform some channels together; None: perhaps all."""
        if shared is not None and ANY not in shared:
            left, right = left & (shared | {ANY}), right & (shared | {ANY})
        if left & right or (left and ANY in right) or (right and ANY in left):
            self.use.tests = True

    def _said(self, node: s.Prefix) -> Outputs:
        """The channel of a prefix where it says what a value is."""
        fields = [field.expression for field in node.fields if field.expression is not None]
        heads = self.heads(node.channel)
        if any(map(self.script.touches, fields)) or _mentions_value(self.script, node.channel):
            return heads or frozenset([ANY])
        if any(field.kind == "$" for field in node.fields):
            return heads or frozenset([ANY])  # what it chooses it says
        return frozenset() if heads else frozenset([ANY])

    def _renamed(self, node: s.Rename, inner: Outputs) -> Outputs:
        gone: set[Symbol] = set()
        come: set[Symbol] = set()
        for old, new in node.pairs:
            before, after = self.heads(old), self.heads(new)
            if not before or not after:
                return inner | {ANY} if inner else inner
            if before & inner:
                come |= after
            plain = old
            plain = s.bare(plain)
            if isinstance(plain, s.Name) and node.statements is None:
                gone |= before
        return frozenset((inner - gone) | come)

    def heads(self, node: s.Expr) -> Outputs:
        """The channel that an event or a part of one belongs to; none where it is not known."""
        match node:
            case s.Paren():
                return self.heads(node.inner)
            case s.Dot():
                return self.heads(node.left)
            case s.Name():
                symbol = self.names.find(node)
                return frozenset([symbol]) if symbol is not None and symbol.kind is SymbolKind.CHANNEL else frozenset()
        return frozenset()

    def channels(self, node: s.Expr) -> Outputs:
        """The channels of a set of events."""
        match node:
            case s.Paren():
                return self.channels(node.inner)
            case s.Productions() | s.SetExpr():
                found = [self.heads(item) or frozenset([ANY]) for item in node.items]
                return frozenset().union(*found)
        return frozenset([ANY])


def bodies(symbol: Symbol) -> list[s.Expr]:
    """What a definition says that its name is, for each of its clauses."""
    match symbol.declaration:
        case s.FunctionDefinition(clauses=clauses):
            return [clause.body for clause in clauses]
        case s.PatternDefinition(body=body):
            return [body]
    return []


def _is_event(script: ScriptReader, node: s.Expr) -> bool:
    return type(resolve(script.types.type_of(node))).__name__ in ("Atom", "Dotable", "Extendable")


def _mentions_value(script: ScriptReader, node: s.Expr) -> bool:
    """Whether an event or a part of one is given a value of the type, or is a variable, which may have one."""
    stack: list[s.Expr] = [node]
    while stack:
        part = stack.pop()
        part = s.bare(part)
        if isinstance(part, s.Dot):
            stack += [part.left, part.right]
            continue
        symbol = script.names.find(part) if isinstance(part, s.Name) else None
        if symbol is not None and symbol.kind is SymbolKind.CHANNEL:
            continue
        if script.has_events(part) or script.touches(part):
            return True
    return False
