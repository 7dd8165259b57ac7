"""Loading a script: from a file to its assertions, ready to be turned into process terms.

The phases follow each other here: parse, tie names, infer types, declare channels, evaluate what is printed. Each
raises ``ScriptError`` with what is wrong; nothing else leaves this module for any text whatever.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.diagnostics import Diagnostic, ScriptError, Severity
from cspcheck.cspm.evaluator import Evaluator
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.recording import RecordingEvaluator
from cspcheck.cspm.evaluator.units import UnitDeclarations
from cspcheck.cspm.expectations import Expectations, Expected
from cspcheck.cspm.naming import messages as name_messages
from cspcheck.cspm.naming.resolve import Names, resolve, resolve_more
from cspcheck.cspm.notation import ClassReading, Paragraphs, extension
from cspcheck.cspm.parsing.lexing_messages import nested_too_deeply
from cspcheck.cspm.parsing.reading import parse, parse_assertion, parse_expression, read_source
from cspcheck.cspm.printing.printer import print_assertion
from cspcheck.cspm.process.events import EventSet, EventTable
from cspcheck.cspm.process.terms import Process
from cspcheck.cspm.process.text import describe
from cspcheck.cspm.source import Source, Span
from cspcheck.cspm.spelling import suggestions
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values.dots import Channels, DotList, Dotted, Event
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.order import order_key
from cspcheck.cspm.values.sets import Set
from cspcheck.cspm.values.text import show
from cspcheck.cspm.values.values import Boolean, Map, Real, Sequence, deep

if TYPE_CHECKING:
    from cspcheck.cspm.typing.inference import Types


@dataclass(frozen=True, slots=True)
class Assertion:
    """An assertion of a script.

    ``text`` is its canonical text without the word ``assert``; ``expected`` the verdict that a comment
    ``-- expect: fail`` on one of its lines, or alone on the line above, announces.
    """

    node: syntax.Assertion
    text: str
    span: Span
    expected: Expected | None = None


class Script:
    """A loaded script. Create with :func:`load`.

    Methods that take text read it as if it stood at the end of the script. All of them raise ``ScriptError``
    where the text or the script is wrong.

    Attributes:
        again: loads the same script anew: nothing of what was evaluated in this one is in that one.
    """

    again: Callable[[], Script]

    def __init__(
        self,
        source: Source,
        tree: syntax.Script,
        names: Names,
        types: Types | None,
        classes: Paragraphs | None = None,
        *,
        recording: bool = False,
    ) -> None:
        self.source = source
        self.tree = tree
        """The script as it is evaluated: what stands for classes in place of their paragraphs."""
        self.names = names
        self.types = types
        """What the type checker found; None if it was not asked."""
        self.classes = classes
        """The Object-Z part; None if there is none."""
        self.events = EventTable(show, order_key)
        """The events of all channels, numbered in the order of declaration, those of module instances last."""
        self.warnings: tuple[Diagnostic, ...] = () if types is None else types.warnings
        if classes is not None:
            self.warnings = (*classes.warnings, *self.warnings)
        self.warnings = (*tree.remarks, *names.warnings, *self.warnings)
        self._evaluator = (RecordingEvaluator if recording else Evaluator)(names, Channels(self.events), types)
        self._top, declared, broken = self._evaluator.run(lambda: self._declare(tree))
        self.warnings += tuple([_as_warning(d) for failure in broken for d in failure.finished().diagnostics])
        self._frames: dict[int, Frame] = {}
        if types is not None:
            from cspcheck.cspm.evaluator.unmatched import unmatched_inputs

            self.warnings += self._evaluator.run(
                lambda: tuple(unmatched_inputs(self._evaluator, types, tree.declarations, self._top))
            )
        self.assertions: tuple[Assertion, ...] = tuple(self._own_assertions(declared))
        """The assertions in the order of the text."""
        self.printed: tuple[str, ...] = tuple(self._printed(declared))
        """What the ``print`` declarations say, in order."""

    def readings(self, node: syntax.Assertion) -> tuple[str, ...]:
        """The finite readings that the classes behind an assertion follow, as the script writes them."""
        if self.classes is None:
            return ()
        return self.classes.readings(self.names, _operands(node))

    def _declare(self, tree: syntax.Script) -> tuple[Frame, UnitDeclarations, list[Failure]]:
        declarations = UnitDeclarations(self._evaluator)
        unit = declarations.script(tree)
        return Frame.outermost(unit), declarations, declarations.settle()

    def _own_assertions(self, declared: UnitDeclarations) -> Iterator[Assertion]:
        announced = Expectations(self.tree, self.source)
        self.warnings += tuple(announced.mistaken([declaration.span for declaration, _ in declared.assertions]))
        for declaration, frame in declared.assertions:
            node = declaration.assertion
            for part in _operands(node):
                self._frames[id(part)] = frame
            span = declaration.span
            yield Assertion(node, print_assertion(node), span, announced.expected(span))

    @property
    def evaluator(self) -> Evaluator:
        """What evaluates the script."""
        return self._evaluator

    @property
    def outermost(self) -> Frame:
        """The frame of the script's top level."""
        return self._top

    # --- what is written against the script -----------------------------------------------------------------

    def _tied(self, expression: syntax.Expr | str, *, written: bool = False) -> tuple[syntax.Expr, Frame]:
        """The tree of *expression* with its names tied and its types checked, and the frame that it stands in.

        A tree is of this script, unless it is *written* against it and has not been looked at yet.
        """
        if isinstance(expression, str):
            expression, written = parse_expression(expression), True
        if written:
            resolve_more(self.names, expression)
            if self.types is not None:
                from cspcheck.cspm.typing.inference import infer_expression

                infer_expression(expression, self.types)
        return expression, self._frames.get(id(expression), self._top)

    def assertion(self, text: str) -> Assertion:
        """An assertion written against the script."""
        node = parse_assertion(text)
        resolve_more(self.names, node)
        if self.types is not None:
            from cspcheck.cspm.typing.inference import infer_assertion

            infer_assertion(node, self.types)
        return Assertion(node, print_assertion(node), node.span)

    def process(self, expression: syntax.Expr | str) -> Process:
        """The process that *expression* is: a node of an assertion of this script, or a text."""
        node, frame = self._tied(expression)
        return self._evaluator.run(lambda: self._evaluator.process(node, frame)(()), node.span)

    @contextmanager
    def _written(self, expression: syntax.Expr | str) -> Iterator[tuple[syntax.Expr, Frame]]:
        """Like :meth:`_tied`, for a value that is complete at the end: what is known of a text is forgotten then.

        A session that evaluates for hours does not grow.
        """
        node = parse_expression(expression) if isinstance(expression, str) else expression
        try:
            yield self._tied(node, written=isinstance(expression, str))
        finally:
            if isinstance(expression, str):
                self._evaluator.forget(node, self._top)

    def event_set(self, expression: syntax.Expr | str) -> EventSet:
        """The events in the set that *expression* is."""
        with self._written(expression) as (node, frame):
            return self._evaluator.run(lambda: self._evaluator.events(node, frame)(()), node.span)

    def trace(self, expression: syntax.Expr | str) -> tuple[int, ...]:
        """The events, in order, of the sequence that *expression* is."""
        with self._written(expression) as (node, frame):
            return self._evaluator.run(lambda: self._evaluator.trace(node, frame)(()), node.span)

    def boolean(self, expression: syntax.Expr | str) -> bool:
        """The truth value that *expression* has."""
        with self._written(expression) as (node, frame):
            return self._evaluator.run(lambda: self._evaluator.condition(node, frame)(()), node.span)

    def evaluate(self, text: str) -> Any:
        """The value of an expression as a Python value.

        Integers, Booleans, reals and characters become ``int``, ``bool``, ``Fraction`` and ``str``, tuples ``tuple``,
        sets ``frozenset``, maps ``dict`` (a frozenset of pairs inside a set), sequences ``tuple``, except that a
        sequence of at least one character becomes ``str``. Events and datatype values, functions and processes become
        their text.

        Raises:
            ScriptError: also for infinite sets and sequences.
        """
        with self._written(text) as (node, frame):
            return self._evaluator.run(lambda: self._plain(deep(self._evaluator.value(node, frame)(()))), node.span)

    def value(self, text: str) -> Any:
        """The value of an expression as the evaluator has it (``cspcheck.cspm.values.values``), evaluated through and
        through.

        Raises:
            ScriptError: also for infinite sequences.
        """
        node, frame = self._tied(text)
        return self._evaluator.run(lambda: deep(self._evaluator.value(node, frame)(())), node.span)

    def plain(self, value: Any) -> Any:
        """A value of the evaluator as a Python value, as :meth:`evaluate` gives it."""
        return self._plain(deep(value))

    def show(self, text: str) -> str:
        """The value of an expression as the language writes it."""
        with self._written(text) as (node, frame):
            return self._print(node, frame)

    def _printed(self, declared: UnitDeclarations) -> Iterator[str]:
        for node, frame in declared.prints:
            if node.span in self.names.unprintable:
                continue
            try:
                yield self._print(node.expression, frame)
            except ScriptError as error:  # what is only printed stops nothing
                self.warnings += tuple(map(_as_warning, error.diagnostics))

    def _print(self, node: syntax.Expr, frame: Frame) -> str:
        def work() -> str:
            value = self._evaluator.value(node, frame)(())
            return describe(value, self.events) if isinstance(value, Process) else show(value)

        return self._evaluator.run(work, node.span)

    def _plain(self, value: Any, *, inside_set: bool = False) -> Any:
        match value:
            case int() | str():
                return value
            case Boolean():
                return bool(value)
            case Real():
                return value.value
            case tuple():
                return tuple([self._plain(item, inside_set=inside_set) for item in value])
            case Sequence():
                items = [self._plain(item, inside_set=inside_set) for item in value.values()]
                if items and all(type(item) is str for item in value.values()):
                    return "".join(items)
                return tuple(items)
            case Map():
                pairs = {
                    self._plain(key, inside_set=True): self._plain(kept, inside_set=inside_set)
                    for key, kept in value.entries.items()
                }
                return frozenset(pairs.items()) if inside_set else pairs
            case Set():
                return frozenset([self._plain(item, inside_set=True) for item in value.elements()])
            case Event() | Dotted() | DotList():
                return show(value)
            case Process():
                return describe(value, self.events)
        return show(value)


def load(
    script: str | os.PathLike[str] | Source | syntax.Script,
    *,
    overrides: Mapping[str, str] | None = None,
    typecheck: bool = True,
    semantics: ClassReading | None = None,
    include_roots: Iterable[str] = (),
    recording: bool = False,
) -> Script:
    """Load a script from a file, or from a text that has been read already.

    Args:
        script: a path, a source (includes are found relative to its folder), or a tree that has been parsed already.
        overrides: expressions that replace those of top-level definitions ``NAME = ...``, by name.
        typecheck: whether types are inferred and must be right.
        semantics: how classes are read; by default with their data, outputs chosen by the class.
        include_roots: folders, beside the script's own, from below which files may be included.
        recording: whether to remember what was evaluated (:class:`.RecordingEvaluator`), for coverage.

    Raises:
        ScriptError: the file cannot be read, or the script is wrong.
    """
    roots = tuple(include_roots)
    source = script.span.source if isinstance(script, syntax.Script) else script
    source = source if isinstance(source, Source) else read_source(source)
    try:
        tree = script if isinstance(script, syntax.Script) else parse(source, include_roots=roots)
        loaded = _loaded(source, tree, overrides, typecheck, semantics, recording)
    except RecursionError as deep:
        deep.__traceback__ = None
        raise ScriptError(nested_too_deeply(source.name)) from None
    loaded.again = partial(
        load,
        tree if isinstance(script, syntax.Script) else source,
        overrides=overrides,
        typecheck=typecheck,
        semantics=semantics,
        include_roots=roots,
        recording=recording,
    )
    return loaded


def _loaded(
    source: Source,
    tree: syntax.Script,
    overrides: Mapping[str, str] | None,
    typecheck: bool,
    semantics: ClassReading | None,
    recording: bool,
) -> Script:
    if overrides:
        tree = _overridden(tree, overrides)
    classes: Paragraphs | None = None
    if any(isinstance(declaration, syntax.Paragraph) for declaration in _all(tree.declarations)):
        classes, tree = extension().elaborated(tree, semantics)
    names = resolve(tree)
    types: Types | None = None
    if typecheck:
        from cspcheck.cspm.typing.inference import infer

        types = infer(tree, names)
    return Script(source, tree, names, types, classes, recording=recording)


def outline(source: Source) -> tuple[Assertion, ...]:
    """The assertions of a script as they stand in its text and in what it includes: nothing is evaluated.

    Raises:
        ScriptError: with every mistake in the form of the script.
    """
    found: list[Assertion] = []
    tree = parse(source)
    announced = Expectations(tree, source)

    def collect(declarations: tuple[syntax.Declaration, ...]) -> None:
        for declaration in declarations:
            if isinstance(declaration, syntax.IncludeDeclaration | syntax.TimedDeclaration):
                collect(declaration.declarations)
            elif isinstance(declaration, syntax.AssertDeclaration):
                node, span = declaration.assertion, declaration.span
                found.append(Assertion(node, print_assertion(node), span, announced.expected(span)))

    collect(tree.declarations)
    return tuple(found)


def _as_warning(diagnostic: Diagnostic) -> Diagnostic:
    """What is wrong with something that nobody may need."""
    return replace(diagnostic, severity=Severity.WARNING)


def _all(declarations: tuple[syntax.Declaration, ...]) -> Iterator[syntax.Declaration]:
    """Declarations with those of included files."""
    for declaration in declarations:
        if isinstance(declaration, syntax.IncludeDeclaration):
            yield from _all(declaration.declarations)
        else:
            yield declaration


def _overridden(tree: syntax.Script, overrides: Mapping[str, str]) -> syntax.Script:
    """The script with other bodies for some of its top-level names."""
    found: set[str] = set()
    others: dict[str, Span] = {}

    def rewrite(declarations: tuple[syntax.Declaration, ...]) -> tuple[syntax.Declaration, ...]:
        return tuple([one(declaration) for declaration in declarations])

    def one(declaration: syntax.Declaration) -> syntax.Declaration:
        match declaration:
            case syntax.IncludeDeclaration() | syntax.TimedDeclaration():
                return replace(declaration, declarations=rewrite(declaration.declarations))
            case syntax.PatternDefinition(pattern=syntax.NamePattern() as pattern) if pattern.text in overrides:
                found.add(pattern.text)
                text = Source(f"-D {pattern.text}", overrides[pattern.text])
                return replace(declaration, body=parse_expression(text))
            case _:
                for name, span in _declared(declaration):
                    others[name] = span
                return declaration

    result = replace(tree, declarations=rewrite(tree.declarations))
    missing = [name for name in overrides if name not in found]
    if missing:
        constants = [d.pattern.text for d in _flat(tree.declarations) if isinstance(d.pattern, syntax.NamePattern)]
        raise ScriptError(
            *[
                name_messages.unknown_override(name, suggestions(name, constants), defined=others.get(name))
                for name in missing
            ]
        )
    return result


def _flat(declarations: tuple[syntax.Declaration, ...]) -> Iterator[syntax.PatternDefinition]:
    for declaration in declarations:
        if isinstance(declaration, syntax.IncludeDeclaration | syntax.TimedDeclaration):
            yield from _flat(declaration.declarations)
        elif isinstance(declaration, syntax.PatternDefinition):
            yield declaration


def _declared(declaration: syntax.Declaration) -> list[tuple[str, Span]]:
    match declaration:
        case syntax.ChannelDeclaration():
            return [(name.name, name.span) for name in declaration.names]
        case syntax.DatatypeDeclaration():
            constructors = [] if declaration.subtype else [(c.name, c.span) for c in declaration.constructors]
            return [(declaration.name, declaration.span), *constructors]
        case (
            syntax.FunctionDefinition()
            | syntax.NametypeDeclaration()
            | syntax.ModuleDeclaration()
            | syntax.InstanceDeclaration()
        ):
            return [(declaration.name, declaration.span)]
    return []


def _operands(node: syntax.Assertion) -> list[syntax.Expr]:
    """The expressions that an assertion speaks of."""
    match node:
        case syntax.NotAssertion():
            return _operands(node.inner)
        case syntax.Refinement():
            found = [node.specification, node.implementation]
        case syntax.Property():
            found = [node.process] if node.trace is None else [node.process, node.trace]
        case syntax.BooleanAssertion():
            return [node.condition]
        case _:
            return []
    return [*found, *[option.events for option in node.options if option.events is not None]]
