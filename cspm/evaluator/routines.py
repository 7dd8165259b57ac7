"""Definitions as they are run: functions, named values and named processes, with what identifies their uses.

A use of a definition in a process is a ``Reference``: its key is the definition (one for each module instance), the
values of the variables around it that it uses, and its arguments. Its body is evaluated when it is asked for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from cspcheck.cspm.evaluator.core import PROCESS_TYPES
from cspcheck.cspm.evaluator.frames import Frame
from cspcheck.cspm.evaluator.free import mentioned
from cspcheck.cspm.evaluator.fusion import fused_body
from cspcheck.cspm.evaluator.keys import FailedArgument, Itself, key_of, native
from cspcheck.cspm.evaluator.patterns import Matcher, compile_pattern, is_variable
from cspcheck.cspm.evaluator.sorts import Sort
from cspcheck.cspm.interruption import Stopped
from cspcheck.cspm.naming.symbols import Symbol
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.hash_consing import Entry
from cspcheck.cspm.process.terms import Menu, Process, Reference
from cspcheck.cspm.source import Span
from cspcheck.cspm.syntax import tree as syntax
from cspcheck.cspm.values import messages as messages
from cspcheck.cspm.values.failure import Failure
from cspcheck.cspm.values.thunks import Code, Env, Thunk, force
from cspcheck.cspm.values.values import Function

if TYPE_CHECKING:
    from cspcheck.cspm.evaluator.core import Evaluator

HOT = 60
"""After so many calls the body of a function is worth a Python function of its own."""
LONGEST_UNFOLDING = 25_000
"""A process may stand for another that stands for another, so often."""

Clause = tuple[tuple[syntax.Pattern, ...], syntax.Expr]
"""The patterns of all parameters, and the body."""


class Routine:
    """A definition in its frame: ``groups`` are the sizes of its parameter lists, () for a plain name.

    ``enter`` and ``enter_process`` run it in an environment that ends in all its arguments; both compile the clauses
    when first called; they must be given values, not thunks, for the parameters that are ``strict``.
    ``known_process`` says that what it gives is a process.
    """

    __slots__ = (
        "_constant",
        "_plan",
        "clauses",
        "enter",
        "enter_menu",
        "enter_native",
        "enter_process",
        "entries",
        "evaluator",
        "frame",
        "groups",
        "known_process",
        "name",
        "sort",
        "span",
        "strict",
        "thunk",
        "width",
    )

    def __init__(
        self,
        evaluator: Evaluator,
        name: str,
        span: Span,
        frame: Frame,
        groups: tuple[int, ...],
        clauses: Sequence[Clause],
        sort: Sort,
        strict: tuple[bool, ...] | None = None,
    ) -> None:
        self.evaluator = evaluator
        self.name = name
        self.span = span
        self.frame = frame
        self.groups = groups
        self.width = sum(groups)
        self.clauses = clauses
        self.sort = sort
        self.strict = strict if strict is not None and any(strict) else None
        self.known_process = sort is Sort.PROCESS
        self.enter: Code = self._first_value
        self.enter_process: Callable[[Env], Process] = self._first_process
        self.enter_menu: Callable[[Env], Menu | None] | None = None
        """Gives the menu of the process, where it has one; None as long as the definition is not fused."""
        self.enter_native: Callable[[Any], Menu | None] | None = None
        """Gives it for the key of the arguments; ``NotImplemented`` for a key that has to be asked for otherwise."""
        self.thunk: Thunk | None = None
        self._plan: tuple[int, ...] | None = None
        self._constant: Reference | None = None
        self.entries: dict[Any, Entry] = {}
        """The references to the definition that anyone has, by the values around it and its arguments."""

    # --- running --------------------------------------------------------------------------------------------

    def _first_value(self, env: Env) -> Any:
        strict = self.strict or (False,) * self.width
        code = self._compile(self.evaluator.value, strict)
        self.enter = code
        if self.groups and self.sort is Sort.DATA and self.evaluator.sorts.types is not None:
            self.enter = self._until_hot(code, strict)
        return self.enter(env)

    def _until_hot(self, code: Code, strict: tuple[bool, ...]) -> Code:
        """*code* for the first calls, and then the same with its bodies fused."""
        calls = 0

        def fused(body: syntax.Expr, frame: Frame) -> Code:
            return fused_body(self.evaluator, body, frame, self.evaluator.value(body, frame))

        def counted(env: Env) -> Any:
            nonlocal calls
            calls += 1
            if calls > HOT:
                if self.enter is counted:
                    self.enter = self._compile(fused, strict)
                return self.enter(env)
            return code(env)

        return counted

    def _first_process(self, env: Env) -> Process:
        strict = self.strict or (False,) * self.width
        code: Callable[[Env], Process] = self._compile(self.evaluator.process, strict)
        self.enter_process = code
        fuses = self.evaluator.fuses_processes and self.evaluator.sorts.types is not None
        if fuses and self.groups and self.frame.timing is None:
            self.enter_process = self._until_hot_process(code)
        return code(env)

    def _until_hot_process(self, code: Callable[[Env], Process]) -> Callable[[Env], Process]:
        """*code* for the first unfoldings, and then the same with its bodies fused."""
        from cspcheck.cspm.evaluator.fused_processes import fused_menu, fused_process, with_menus, with_terms
        from cspcheck.cspm.evaluator.native_menus import native_menu

        calls = 0
        evaluator = self.evaluator

        def counted(env: Env) -> Process:
            nonlocal calls
            calls += 1
            if calls > HOT:
                if self.enter_process is counted:
                    # References have their arguments evaluated; where one cannot be, the closures are entered.
                    strict = (True,) * self.width
                    terms = self._compile(lambda body, frame: fused_process(evaluator, body, frame), strict)
                    self.enter_process = with_terms(self, terms, code)
                    menus = self._compile(lambda body, frame: fused_menu(evaluator, body, frame), strict)
                    self.enter_menu = with_menus(self, menus)
                    self.enter_native = native_menu(evaluator, self)
                return self.enter_process(env)
            return code(env)

        return counted

    def _compile(self, compile_body: Callable[[syntax.Expr, Frame], Code], strict: tuple[bool, ...]) -> Code:
        start = self.frame.size
        compiled: list[tuple[tuple[tuple[int, Matcher], ...], Code]] = []
        for patterns, body in self.clauses:
            named = [self._name(pattern) for pattern in patterns]
            frame = self.frame.with_variables(named, evaluated=False)
            frame = frame.knowing([symbol for symbol, known in zip(named, strict, strict=True) if symbol and known])
            steps: list[tuple[int, Matcher]] = []
            for i, (pattern, symbol) in enumerate(zip(patterns, named, strict=True)):
                if symbol is None:
                    matcher, frame = compile_pattern(self.evaluator, pattern, frame, evaluated=False)
                    if not isinstance(pattern, syntax.Wildcard):
                        steps.append((start + i, matcher))
            compiled.append((tuple(steps), compile_body(body, frame)))
            if not steps:
                break  # later clauses are never reached
        if not compiled[0][0]:
            return compiled[0][1]

        def run(env: Env) -> Any:
            for steps, body in compiled:
                found: Env | None = env
                for slot, matcher in steps:
                    found = matcher(found, env[slot])  # type: ignore[arg-type]
                    if found is None:
                        break
                else:
                    return body(found)  # type: ignore[arg-type]
            raise Failure(messages.no_clause(self.name, env[start:], None, self.span))

        return run

    def _name(self, pattern: syntax.Pattern) -> Symbol | None:
        """The variable that *pattern* is, if it is nothing more."""
        if not is_variable(self.evaluator, pattern):
            return None
        while isinstance(pattern, syntax.ParenPattern):
            pattern = pattern.inner
        return self.evaluator.names.symbol(pattern)

    def prepared(self, arguments: Env) -> Env:
        """The arguments with those evaluated that must not be thunks."""
        if self.strict is None:
            return arguments
        return tuple([force(value) if strict else value for value, strict in zip(arguments, self.strict, strict=True)])

    def shown(self, arguments: Sequence[Any]) -> str:
        """The definition's name with *arguments*, as a person would write it."""
        from cspcheck.cspm.values.text import show_short

        text = self.name
        start = 0
        for size in self.groups:
            text += f"({', '.join(map(show_short, arguments[start : start + size]))})"
            start += size
        return text

    # --- references -----------------------------------------------------------------------------------------

    def captured(self, env: Env, level: int = 0) -> tuple[Any, ...]:
        """The values, as parts of a key, of the variables around the definition that it uses."""
        plan = self._plan
        if plan is None:
            plan = self._plan = self._find_plan()
        return tuple([native(key_of(env[slot], level)) for slot in plan]) if plan else ()

    def _find_plan(self) -> tuple[int, ...]:
        """The positions of the variables that the definition depends on, through the local definitions it uses.

        A local definition counts by its value if that is surely plain data that needs none of the processes and
        functions around it; otherwise by the variables that it depends on itself.
        """
        slots: set[int] = set()
        seen: set[Symbol] = set()
        stack: list[Routine] = [self]
        while stack:
            routine = stack.pop()
            for symbol, slot, definition in routine.uses():
                if symbol in seen:
                    continue
                seen.add(symbol)
                if definition is None or definition.is_plain_data():
                    slots.add(slot)
                else:
                    stack.append(definition)
        return tuple(sorted(slots))

    def uses(self) -> list[tuple[Symbol, int, Routine | None]]:
        """The variables around the definition that it mentions, with positions and, of local definitions, routines."""
        evaluator = self.evaluator
        slots = self.frame.slots
        found: dict[Symbol, int] = {}
        inside = [mentioned(body, evaluator.names, evaluator.free_variables) for _, body in self.clauses]
        if self.frame.timing is not None:
            inside.append(self.frame.timing.mentions)
        for symbols in inside:
            found.update((symbol, slots[symbol]) for symbol in symbols if symbol in slots)
        unit = self.frame.unit
        return [(symbol, slot, evaluator.routines.get((symbol, unit))) for symbol, slot in found.items()]

    def is_plain_data(self) -> bool:
        """Whether the value is data whose evaluation involves no local process and not itself."""
        if self.sort is not Sort.DATA or self.groups:
            return False
        seen: set[Routine] = set()
        stack: list[Routine] = [self]
        while stack:
            for _, _, definition in stack.pop().uses():
                if definition is None or definition in seen:
                    continue
                if definition is self or definition.sort is not Sort.DATA:
                    return False
                seen.add(definition)
                stack.append(definition)
        return True

    def reference(self, base: Env, arguments: Sequence[Any], body: Process | None = None) -> Reference:
        """The process that the definition, in the environment *base*, is for *arguments*.

        *body* is its term if it has been evaluated already.
        """
        if not arguments and not self.frame.size:
            constant = self._constant
            if constant is None:
                constant = self._constant = self.refer((), base, (), body)
            return constant
        values: list[Any] = []
        keys: list[Any] = []
        for argument in arguments:
            if type(argument) is int:
                keys.append(argument)
                values.append(argument)
                continue
            key = key_of(argument)
            keys.append(native(key))
            values.append(argument if type(key) is FailedArgument or type(key) is Itself else key)
        return self.refer(tuple(keys), base, tuple(values), body)

    def refer(self, keys: Any, base: Env, arguments: Env, body: Process | None = None) -> Reference:
        """The reference for *arguments*, evaluated through and through, which these *keys* stand for (``native``)."""
        captured = self.captured(base) if self.frame.size else ()
        key = (captured, keys) if captured else keys
        entry = self.entries.get(key)
        if entry is not None:
            found: Reference | None = entry()
            if found is not None:
                return found
        told = arguments
        if Thunk in map(type, arguments):
            told = tuple([k if type(a) is Thunk else a for a, k in zip(arguments, keys, strict=True)])
        reference = Reference.fresh((self, captured, told), RoutineUse(self, key, base, arguments, body))
        entry = self.entries[key] = Entry(reference, self._forget)
        entry.key = key
        return reference

    def refer_later(self, key: Env, decode: Callable[[Env], Env]) -> Reference:
        """The reference with this key, of which there is none; *decode* makes its arguments when they are needed.

        The definition has nothing around it.
        """
        reference = Reference.fresh((self, key), LaterUse(self, key, decode))
        entry = self.entries[key] = Entry(reference, self._forget)
        entry.key = key
        return reference

    def _forget(self, entry: Entry) -> None:
        """Drop the entry of a reference that nobody has any more, unless another has taken its place."""
        if self.entries.get(entry.key) is entry:
            del self.entries[entry.key]

    def unfold(self, use: RoutineUse, text: Callable[[], str], env: Env) -> Process:
        """The term of a reference: its body, which the use keeps, and while that is a reference, that one's term."""
        key = (self, use.key)
        unfolding = self.evaluator.unfolding
        if key in unfolding:
            names = [name() for name in list(unfolding.values())[list(unfolding).index(key) :]]
            raise Failure(messages.process_is_itself([*names, names[0]], self.span))
        if len(unfolding) > LONGEST_UNFOLDING:
            raise Failure(messages.never_begins(next(iter(unfolding.values()))(), LONGEST_UNFOLDING, self.span))
        unfolding[key] = text
        try:
            if use.body is None:
                use.body = self.enter_process(env)
            term = use.body
            while type(term) is Reference:
                term = term.body()
        except Failure as failure:
            failure.__traceback__ = None
            failure.at(self.span).called(text, None)
            raise
        except Stopped as stopped:
            if stopped.outermost is None:
                stopped.called(text)
            raise
        except RecursionError as error:
            error.__traceback__ = None
            raise self.too_deep(text, None) from None
        finally:
            del unfolding[key]
        return term

    def too_deep(self, text: Callable[[], str], span: Span | None) -> Failure:
        """The failure that a recursion through this definition went too deep."""
        failure = Failure(messages.too_deep(self.span), is_limit=True)
        failure.called(text, span)
        return failure

    # --- plain names ----------------------------------------------------------------------------------------

    def delay(self, env: Env) -> Thunk:
        """The value of a plain name as a thunk."""
        return Thunk(self.named_value, env)

    def named_value(self, env: Env) -> Any:
        """The value of a plain name; if that is a process, the reference to it."""
        if self.known_process:
            return self.reference(env, ())
        value = self.enter(env)
        if self.sort is Sort.UNKNOWN and type(value) in PROCESS_TYPES and type(value) is not Reference:
            self.known_process = True
            return self.reference(env, (), value)
        return value


class RoutineUse(Definition):
    """What a reference to a routine needs: made for every mention of a process, so no heavier than it must be."""

    __slots__ = ("arguments", "base", "body", "key", "routine")

    def __init__(self, routine: Routine, key: Any, base: Env, arguments: Env, body: Process | None) -> None:
        self.routine = routine
        self.key = key
        self.base = base
        self.arguments = arguments
        self.body = body
        self.span = routine.span

    @property
    def text(self) -> str:
        """The name with its arguments."""
        return self.routine.shown(self.arguments)

    @property
    def variables(self) -> Mapping[str, str]:
        """Those of the state that the body is: a class has a name of the script before it has one of its state."""
        return self.routine.evaluator.run(self._variables)

    def _variables(self) -> Mapping[str, str]:
        term = self.body
        if term is None:
            term = self.routine.enter_process(self.base + self.routine.prepared(self.arguments))
        return term.variables if type(term) is Reference else {}

    def menu(self) -> Menu | None:
        """What the process offers, as long as its term has not been made."""
        routine = self.routine
        if self.body is not None:
            return None
        if routine.enter_native is not None:
            found = routine.enter_native(self.key)
            if found is not NotImplemented:
                return found
        return None if routine.enter_menu is None else routine.evaluator.run(self._menu)

    def _menu(self) -> Menu | None:
        enter = self.routine.enter_menu
        return None if enter is None else enter(self.base + self.arguments)

    def evaluate(self) -> Process:
        """The term of the body."""
        return self.routine.evaluator.run(self._unfold)

    def _unfold(self) -> Process:
        arguments = self.routine.prepared(self.arguments)
        return self.routine.unfold(self, lambda: self.text, self.base + arguments)


class LaterUse(RoutineUse):
    """The use of a definition whose arguments are made from their key when somebody asks for them."""

    __slots__ = ("_decode", "_made")

    def __init__(self, routine: Routine, key: Env, decode: Callable[[Env], Env]) -> None:
        self.routine = routine
        self.key = key
        self.base = ()
        self.body = None
        self.span = routine.span
        self._decode = decode
        self._made: Env | None = None

    @property
    def arguments(self) -> Env:  # type: ignore[override]
        """The values of the arguments."""
        if self._made is None:
            self._made = self._decode(self.key)
        return self._made


def passed(
    error: Failure | RecursionError | Stopped, routine: Routine, arguments: Env, span: Span
) -> Failure | Stopped:
    """What leaves a call written at *span* when *error* happens in it."""
    error.__traceback__ = None
    error.__context__ = None
    if isinstance(error, Stopped):
        error.called(lambda: routine.shown(arguments))
        return error
    if isinstance(error, Failure):
        error.called(lambda: routine.shown(arguments), span)
        return error
    return routine.too_deep(lambda: routine.shown(arguments), span)


def apply(function: Any, arguments: Env, span: Span) -> Any:
    """The value of ``function(arguments)``.

    Raises:
        Failure: it is no function, takes other arguments, or its evaluation fails.
    """
    if type(function) is not Function:
        call = getattr(function, "apply", None)
        if call is None:
            raise Failure(messages.wrong_kind("a function", function, span))
        return call(arguments, span)
    routine: Routine = function.routine
    collected = function.collected + arguments
    applied = function.applied + 1
    size = routine.groups[applied - 1]
    if size != len(arguments):
        raise Failure(messages.argument_count(routine.name, size, len(arguments), span, routine.span))
    if applied < len(routine.groups):
        return Function(routine, function.env, collected, applied)
    return call_routine(routine, function.env, collected, span)


def call_routine(routine: Routine, base: Env, arguments: Env, span: Span) -> Any:
    """The value that a definition gives for all its arguments; if that is a process, the reference to it."""
    if routine.known_process:
        return routine.reference(base, arguments)
    arguments = routine.prepared(arguments)
    try:
        value = routine.enter(base + arguments)
    except (Failure, RecursionError, Stopped) as error:
        raise passed(error, routine, arguments, span) from None
    if routine.sort is Sort.UNKNOWN and type(value) in PROCESS_TYPES and type(value) is not Reference:
        return routine.reference(base, arguments, value)
    return value


def apply_process(function: Any, arguments: Env, span: Span) -> Any:
    """``function(arguments)`` where a process is needed: not evaluated if the function is of the script."""
    if type(function) is Function:
        routine: Routine = function.routine
        last = function.applied + 1 == len(routine.groups)
        if last and routine.groups[-1] == len(arguments):
            return routine.reference(function.env, function.collected + arguments)
    return apply(function, arguments, span)
