"""Coverage: what a script says and a check that passed never saw happen.

The text is walked from the process of the assertion along what happens. Where the way ends, a prefix that is never
performed or a branch that is never taken is told; what stands behind it is not, since it could not happen either.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from cspcheck.cspm.evaluator.recording import RecordingEvaluator
from cspcheck.cspm.naming.symbols import Symbol, SymbolKind
from cspcheck.cspm.process.terms import ExternalChoice, InternalChoice, Prefix, Process, Reference
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.syntax.children import children

if TYPE_CHECKING:
    from cspcheck.checker.check import Checker
    from cspcheck.checker.checks.coverage import Happened
    from cspcheck.cspm.script import Assertion, Script

Kind = Literal["prefix", "branch", "definition", "guard", "component", "event"]
_SHOWN = 60


@dataclass(frozen=True, slots=True)
class Never:
    """Something that never happens.

    Attributes:
        kind: what it is.
        text: as the script writes it; for events several in a row.
        why: what is known of the reason, as the end of a sentence.
        file, line, column: where it stands; 0 where that is nowhere.
    """

    kind: Kind
    text: str
    why: str
    file: str = ""
    line: int = 0
    column: int = 0


@dataclass(frozen=True, slots=True)
class Coverage:
    """How much of what an assertion's process says can happen.

    Attributes:
        prefixes: how many prefixes the definitions behind the process have.
        performed: how many of them are performed in some reachable state.
        never: what never happens, in the order of the script; components and events last.
    """

    prefixes: int
    performed: int
    never: tuple[Never, ...]


def coverage(script: Script, checker: Checker, assertion: Assertion) -> Coverage | None:
    """What never happens in the process that an assertion is about; None where that is not known.

    Args:
        script: loaded with ``recording``.
        checker: which has checked the assertion.
        assertion: a refinement or a property of a process.

    Raises:
        ScriptError: a definition cannot be evaluated.
    """
    evaluator = script.evaluator
    subjects = _subjects(assertion.node)
    if not subjects or not isinstance(evaluator, RecordingEvaluator):
        return None
    found = checker.happened(script.process(subjects[-1]))
    if found is None:
        return None
    walk = _Walk(script, evaluator, found)
    walk.follow(subjects[-1])
    never = sorted(walk.never, key=lambda item: (item.file, item.line, item.column))
    expected = _alphabet(script, checker, subjects[0]) if len(subjects) > 1 else set()
    never += _components(found)
    never += _events(script, found, expected)
    return Coverage(len(walk.prefixes), walk.performed, tuple(never))


def _subjects(node: syntax.Assertion) -> tuple[syntax.Expr, ...]:
    """The processes of an assertion, the one whose behaviour is looked at last."""
    match node:
        case syntax.NotAssertion():
            return _subjects(node.inner)
        case syntax.Refinement():
            return node.specification, node.implementation
        case syntax.Property():
            return (node.process,)
    return ()


def _alphabet(script: Script, checker: Checker, specification: syntax.Expr) -> set[int]:
    """What a specification allows at some time."""
    found = checker.happened(script.process(specification))
    return set() if found is None else found.visible


def _components(found: Happened) -> Iterator[Never]:
    if len(found.parts) > 1:
        for part in found.parts:
            if not part.moves:
                yield _never("component", part.name, "takes part in nothing", part.span)


def _events(script: Script, found: Happened, expected: set[int]) -> Iterator[Never]:
    able = found.able - found.events
    # An event that a component performs under another name has happened.
    able -= {event for _, event in found.performed}
    for events, why in (
        (sorted(able), "some component could perform it, and the others never let it"),
        (sorted(expected - found.events - able), "the specification allows it, and it never happens"),
    ):
        if events:
            yield Never("event", ", ".join(map(script.events.name, events)), why)


class _Walk:
    """Follows a script along what happens."""

    def __init__(self, script: Script, evaluator: RecordingEvaluator, found: Happened) -> None:
        self._script = script
        self._evaluator = evaluator
        self._found = found
        self._seen: set[int] = set()
        self.prefixes: set[int] = set()
        self.performed = 0
        self.never: list[Never] = []

    def follow(self, node: syntax.Node) -> None:
        """Go on from an expression."""
        self._count(node)
        todo = [node]
        while todo:
            current = todo.pop()
            if id(current) in self._seen:
                continue
            self._seen.add(id(current))
            todo.extend(self._beyond(current))

    def _beyond(self, node: syntax.Node) -> Iterable[syntax.Node]:
        """Where the way goes on from a node."""
        match node:
            case syntax.Prefix():
                if not self._happens(node):
                    return [node.channel]
                self.performed += 1
            case syntax.Guard():
                truths = self._evaluator.conditions.get(id(node.condition))
                if truths == {True}:
                    self._tell("guard", node.condition, "is always true")
                if truths == {False}:
                    self._tell("branch", node, "its guard is never true")
                    return ()
            case syntax.If():
                return [node.condition, *[part for part in (node.then, node.otherwise) if self._is_taken(part)]]
            case syntax.Name():
                return self._definition(node)
            case syntax.FunctionDefinition():
                return [clause.body for clause in node.clauses if self._is_taken(clause.body)]
            case syntax.PatternDefinition():
                return [node.body]
            case syntax.Let():
                return [node.body]  # what is defined is met where it is used
            case syntax.Foreign():
                return node.names
        return children(node)

    def _happens(self, node: syntax.Prefix) -> bool:
        if id(node) not in self._evaluator.compiled:
            self._tell("prefix", node, "is never reached")
            return False
        offers = {offer for term in self._evaluator.made.get(id(node), ()) for offer in _offers(term)}
        if offers & self._found.performed:
            return True
        why = "is offered, and never taken up" if offers & self._found.offered else "is never reached"
        self._tell("prefix", node, why)
        return False

    def _is_taken(self, node: syntax.Expr) -> bool:
        """Whether a branch is taken; one that is no process counts as taken."""
        node = syntax.bare(node)
        if id(node) in self._evaluator.processes and id(node) not in self._evaluator.evaluated:
            self._tell("branch", node, "is never taken")
            return False
        return True

    def _definition(self, node: syntax.Name) -> Iterable[syntax.Node]:
        declaration = _declaration(self._script.names.find(node))
        if declaration is None or id(declaration) in self._seen:
            return ()
        if isinstance(declaration, syntax.FunctionDefinition):
            bodies = [clause.body for clause in declaration.clauses]
        else:
            bodies = [declaration.body]
        if any(
            id(syntax.bare(body)) in self._evaluator.compiled or id(body) in self._evaluator.compiled for body in bodies
        ):
            return [declaration]
        if any(isinstance(inner, syntax.Prefix) for body in bodies for inner in _inside(body)):
            self._seen.add(id(declaration))
            self._tell("definition", node, "is never reached")
        return ()

    def _count(self, node: syntax.Node) -> None:
        """All prefixes that the process could have, by the text alone."""
        todo, seen = [node], set()
        while todo:
            current = todo.pop()
            if id(current) in seen:
                continue
            seen.add(id(current))
            if isinstance(current, syntax.Prefix):
                self.prefixes.add(id(current))
            if isinstance(current, syntax.Name):
                declaration = _declaration(self._script.names.find(current))
                todo.extend([] if declaration is None else [declaration])
            todo.extend(current.names if isinstance(current, syntax.Foreign) else children(current))

    def _tell(self, kind: Kind, node: syntax.Expr, why: str) -> None:
        span = node.span
        if kind == "prefix" and isinstance(node, syntax.Prefix):
            span = node.channel.span.to(node.fields[-1].span) if node.fields else node.channel.span
            text = f"{_one_line(span.text)} -> …"
        else:
            text = _one_line(span.text)
        self.never.append(_never(kind, text, why, span))


def _never(kind: Kind, text: str, why: str, span: Span | None) -> Never:
    if span is None:
        return Never(kind, text, why)
    return Never(kind, text, why, span.source.name, span.line, span.column)


def _one_line(text: str) -> str:
    line = " ".join(text.split())
    return line if len(line) <= _SHOWN else line[: _SHOWN - 1] + "…"


def _offers(term: Process) -> Iterator[tuple[Process, int]]:
    """The prefixes that a prefix of the script is, with the events that it says; of a timed one without tock."""
    match term:
        case Prefix():
            for event, _ in term.branches:
                yield term, event
        case InternalChoice():
            for operand in term.operands:
                yield from _offers(operand)
        case Reference(key=("timed prefix", _, Prefix() as offered)):
            body = term.body()
            parts = body.operands if isinstance(body, ExternalChoice) else (body,)
            events = {event for event, _ in offered.branches}
            for part in parts:
                if isinstance(part, Prefix) and (len(parts) == 1 or part is offered):
                    for event, _ in part.branches:
                        if event in events:
                            yield part, event


def _declaration(symbol: Symbol | None) -> syntax.FunctionDefinition | syntax.PatternDefinition | None:
    if symbol is None or symbol.base.kind not in (SymbolKind.FUNCTION, SymbolKind.VALUE):
        return None
    declaration = symbol.base.declaration
    return declaration if isinstance(declaration, syntax.FunctionDefinition | syntax.PatternDefinition) else None


def _inside(node: syntax.Node) -> Iterator[syntax.Node]:
    todo = [node]
    while todo:
        current = todo.pop()
        yield current
        todo.extend(children(current))
