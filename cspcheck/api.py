"""The public interface for Python: load a script, check it, evaluate in it, look at its processes."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, Literal, TypeVar, overload

from cspcheck import checking
from cspcheck.checker.verdict import Termination
from cspcheck.cspm.diagnostics import Diagnostic, ScriptError
from cspcheck.cspm.source import Source
from cspcheck.interactive import Shown, in_notebook, show_diagnostics
from cspcheck.quantities import parse_duration, parse_size
from cspcheck.result import Result

N = TypeVar("N", int, float)
ScriptError.shown = show_diagnostics

if TYPE_CHECKING:
    import networkx

    from cspcheck.checker.lts import Lts
    from cspcheck.checker.proof.finding import Finding
    from cspcheck.cspm import script
    from cspcheck.cspm.process import terms as process
    from cspcheck.cspm.process.events import EventTable
    from cspcheck.probing import Probe


def load(
    path: str | os.PathLike[str],
    *,
    definitions: Mapping[str, object] | None = None,
    typecheck: bool = True,
    view: Literal["data", "control"] | None = None,
    outputs: Literal["demonic", "angelic"] = "demonic",
    include_roots: Iterable[str | os.PathLike[str]] = (),
) -> Script:
    """Load a script from a file.

    Args:
        path: the file.
        definitions: top-level constants of the script to override, by name: CSPm text, or a number or truth value.
        typecheck: whether types are checked.
        view: classes with their ``data``, or in the ``control`` view without; as the script says if not given.
        outputs: who chooses the outputs of classes: ``demonic`` (the class) or ``angelic`` (its environment).
        include_roots: folders, beside the script's own, from below which files may be included.

    Raises:
        ScriptError: the file cannot be read, or there is an error in the script; ``diagnostics`` says what and where.
    """
    roots = tuple([os.fspath(root) for root in include_roots])
    settings = checking.Settings(typecheck=typecheck, view=view, outputs=outputs, include_roots=roots)
    return load_with(os.fspath(path), settings, definitions or {})


def loads(
    text: str,
    *,
    name: str = "<text>",
    definitions: Mapping[str, object] | None = None,
    typecheck: bool = True,
    view: Literal["data", "control"] | None = None,
    outputs: Literal["demonic", "angelic"] = "demonic",
) -> Script:
    """Load a script from its text; *name* is what diagnostics call it. See :func:`load`.

    Raises:
        ScriptError: there is an error in the script.
    """
    from cspcheck.cspm import script
    from cspcheck.cspm.notation import ClassReading

    overrides = {constant: _as_text(value) for constant, value in (definitions or {}).items()}
    semantics = ClassReading(view, outputs)
    loaded = script.load(
        Source(name, _text("script", text)), overrides=overrides, typecheck=typecheck, semantics=semantics
    )
    settings = checking.Settings(definitions=overrides, typecheck=typecheck, view=view, outputs=outputs)
    return Script(loaded, settings)


def load_with(path: str, settings: checking.Settings, definitions: Mapping[str, object]) -> Script:
    """Load a script whose checks start from *settings*; *definitions* come on top of those in the settings.

    Raises:
        ScriptError: the file cannot be read, or there is an error in the script.
    """
    texts = {**settings.definitions, **{name: _as_text(value) for name, value in definitions.items()}}
    settings = replace(settings, definitions=texts)
    return Script(checking.load(path, settings), settings)


def _as_text(value: object) -> str:
    """A value as CSPm writes it; text is taken to be CSPm already."""
    if isinstance(value, bool):
        return "true" if value else "false"
    return str(value)


class Script:
    """A loaded script. Create with :func:`cspcheck.load`."""

    def __init__(self, loaded: script.Script, settings: checking.Settings) -> None:
        self._script = loaded
        self._settings = settings
        self._checkers: list[tuple[checking.Settings, checking.GuardedChecker]] = []
        self._shown = Shown()

    def __repr__(self) -> str:
        return f"<cspcheck.Script {self.name!r}, {len(self.assertions)} assertions>"

    @property
    def name(self) -> str:
        """The file, as given to :func:`cspcheck.load`."""
        return self._script.source.name

    @property
    def assertions(self) -> tuple[str, ...]:
        """The texts of the script's assertions, in order."""
        return tuple(assertion.text for assertion in self._script.assertions)

    @property
    def printed(self) -> tuple[str, ...]:
        """What the script's ``print`` lines say."""
        return self._script.printed

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What is odd about the script without stopping it from being used."""
        return self._script.warnings

    @overload
    def check(
        self,
        assertion: None = None,
        *,
        timeout: float | str | None = None,
        max_states: int | None = None,
        max_memory: int | str | None = None,
        workers: int | None = None,
        full: bool | None = None,
        as_written: bool | None = None,
        termination: Termination | None = None,
        progress: bool | None = None,
    ) -> list[Result]: ...

    @overload
    def check(
        self,
        assertion: str,
        *,
        timeout: float | str | None = None,
        max_states: int | None = None,
        max_memory: int | str | None = None,
        workers: int | None = None,
        full: bool | None = None,
        as_written: bool | None = None,
        termination: Termination | None = None,
        progress: bool | None = None,
    ) -> Result: ...

    def check(
        self,
        assertion: str | None = None,
        *,
        timeout: float | str | None = None,
        max_states: int | None = None,
        max_memory: int | str | None = None,
        workers: int | None = None,
        full: bool | None = None,
        as_written: bool | None = None,
        termination: Termination | None = None,
        progress: bool | None = None,
    ) -> Result | list[Result]:
        """Check the script's assertions, or one that is given as text.

        Args:
            assertion: text of an assertion about the script's processes, without the word ``assert``. Without it, all
                assertions of the script are checked, in order.
            timeout: seconds for each assertion, or text like ``"5m"``.
            max_states: states for each assertion.
            max_memory: bytes for the process, or ``"8GiB"``; four fifths of the machine's memory if not given.
            workers: search threads; the machine's cores if not given.
            full: explore the whole state space, without reductions; not if not given.
            as_written: only the reductions that the script itself asks for; not if not given.
            termination: what a process that has terminated is to ``deadlock free``: a ``success``, which it is if
                not given, or a ``deadlock``.
            progress: whether standard error, or a line of the notebook, shows how far the check is; in notebooks alone
                if not given.

        Returns:
            One Result, or one for each assertion. Where a limit is reached, its verdict is ``unknown``. An error met
            while checking is the verdict ``error``, with its ``diagnostics``.

        Raises:
            ScriptError: *assertion* is not a well-formed assertion about this script.
            ValueError: a limit is not one.
            TypeError: an argument is something else.
        """
        given = self._settings.limits
        limits = checking.limits(
            _positive("max_states", max_states) or given.states,
            _positive("timeout", parse_duration(timeout) if isinstance(timeout, str) else timeout) or given.seconds,
            _positive("max_memory", parse_size(max_memory) if isinstance(max_memory, str) else max_memory)
            or given.memory_bytes,
        )
        own = self._settings
        checker = self._checker(
            replace(
                own,
                limits=limits,
                workers=_positive("workers", workers) or own.workers,
                full=own.full if full is None else full,
                as_written=own.as_written if as_written is None else as_written,
                termination=own.termination if termination is None else termination,
            )
        )

        def answered(one: script.Assertion) -> Result:
            self._shown.begin(one.text)
            try:
                return checking.check(checker, one)
            finally:
                self._shown.done()

        with self._shown.during(in_notebook() if progress is None else progress):
            if assertion is not None:
                return answered(self._assertion(assertion))
            return [answered(one) for one in self._script.assertions]

    def _assertion(self, text: str) -> script.Assertion:
        """The assertion of the file with this text, so that it has its line and what is expected; or another one."""
        words = _text("assertion", text).split()
        for one in self._script.assertions:
            if one.text.split() == words:
                return one
        return self._script.assertion(text)

    def evaluate(self, text: str) -> Any:
        """The value of a CSPm expression in the script, as a Python value.

        Integers, truth values and strings are themselves, sets are frozensets, sequences and tuples are tuples.

        Raises:
            ScriptError: the text is not an expression of this script, or evaluating it goes wrong.
        """
        return self._script.evaluate(_text("expression", text))

    def show(self, text: str) -> str:
        """The value of a CSPm expression in the script, as a ``print`` line writes it.

        Raises:
            ScriptError: the text is not an expression of this script, or evaluating it goes wrong.
        """
        return self._script.show(_text("expression", text))

    def sweep(self, assertion: str | None = None, **values: Iterable[object]) -> list[tuple[dict[str, str], Result]]:
        """Check the script for every combination of values of its constants.

        ``script.sweep(N=range(2, 6))`` checks all assertions for each N; *assertion* leaves those with that text.

        Returns:
            The values with each result, in the order of the combinations and of the script.

        Raises:
            ScriptError: there is no such constant, or the script is wrong with one of the values.
        """
        from itertools import product

        found: list[tuple[dict[str, str], Result]] = []
        for chosen in product(*values.values()):
            texts = {name: _as_text(value) for name, value in zip(values, chosen, strict=True)}
            for result in self._with(texts).check():
                if assertion is None or result.assertion == assertion:
                    found.append((texts, result))
        return found

    def _with(self, definitions: Mapping[str, str]) -> Script:
        """The same script with other values for some constants."""
        from cspcheck.cspm import notation, script

        settings = replace(self._settings, definitions={**self._settings.definitions, **definitions})
        loaded = script.load(
            self._script.source,
            overrides=settings.definitions,
            typecheck=settings.typecheck,
            semantics=notation.ClassReading(settings.view, settings.outputs),
            include_roots=settings.include_roots,
        )
        return Script(loaded, settings)

    def prove(self, *, seconds: float = 10.0, reasons: bool = False) -> list[Finding]:
        """The answers to the proof obligations of every class of the script.

        Args:
            seconds: of the solver's work for one question.
            reasons: tell which lines each proof needed, as ``used`` of a finding; that takes as long again.

        Raises:
            ScriptError: the script has no classes.
        """
        from cspcheck.checker.proof.answer import obligation_names, specification_of
        from cspcheck.checker.proof.obligations import discharge
        from cspcheck.checker.proof.prover import Prover
        from cspcheck.checker.proof.question import SolverSettings

        specification = specification_of(self._script)
        settings = SolverSettings(seconds=seconds, reasons=reasons)
        return [
            finding
            for model in specification.classes.values()
            for finding in discharge(Prover(specification, model, settings), obligation_names(None, None), None)
        ]

    def process(self, text: str) -> Process:
        """The process that a CSPm expression stands for.

        Raises:
            ScriptError: the text is not a process of this script.
        """
        return Process(self, text, self._script.process(_text("process", text)))

    def _checker(self, settings: checking.Settings) -> checking.GuardedChecker:
        """The checker for these settings; one keeps its machines for all assertions."""
        known = next((checker for used, checker in self._checkers if used == settings), None)
        if known is None:
            known = checking.checker_for(self._script, settings, self._shown)
            self._checkers.append((settings, known))
        return known


class Process:
    """A process of a script. Create with :meth:`Script.process`."""

    def __init__(self, owner: Script, text: str, term: process.Process) -> None:
        self._owner = owner
        self._text = text
        self._term = term

    def __repr__(self) -> str:
        return f"<cspcheck.Process {self._text!r}>"

    def svg(self, *, max_states: int = 300) -> str:
        """A picture of the machine, as an SVG document.

        Raises:
            ScriptError: it has more than *max_states* states, or cannot be evaluated.
        """
        from cspcheck.drawing import parts, svg

        return svg.render(parts.machine(self._text, self._term, self._owner._script.events, max_states))

    def architecture(self) -> Picture:
        """A picture of the components and the channels between them.

        Raises:
            ScriptError: a component is too large to be explored.
        """
        from cspcheck.drawing import parts, svg

        return Picture(svg.render(parts.architecture(self._text, self._term, self._owner._script.events)))

    def probe(self, *, seed: int = 0) -> Probe:
        """The process, to be stepped through: its ``steps()``, ``take(step)``, ``perform(event)``, ``undo()``.

        Raises:
            ScriptError: the process cannot be evaluated.
        """
        from cspcheck.probing import Probe

        return Probe(self._term, self._owner._script.events, seed=seed)

    def _repr_svg_(self) -> str | None:
        """What a notebook shows: the machine, or nothing more than the name where it is large."""
        try:
            return self.svg()
        except ScriptError:
            return None

    def lts(self, *, max_states: int | None = None) -> Machine:
        """The explicit machine of the process: all of its reachable states, without any reduction.

        Raises:
            Incomplete: it has more than *max_states* states, or needs more memory than the machine can give.
            ScriptError: the process cannot be evaluated.
            ValueError: *max_states* is not above zero.
        """
        limits = checking.limits(_positive("max_states", max_states))
        checker = self._owner._checker(replace(self._owner._settings, limits=limits, workers=None, full=True))
        return Machine(checker.lts(self._term), self._owner._script.events, self._repr_svg_)


class Picture:
    """A picture that a notebook shows; ``svg`` is the document."""

    def __init__(self, svg: str) -> None:
        self.svg = svg

    def __repr__(self) -> str:
        return f"<cspcheck.Picture, {len(self.svg):,} bytes of SVG>"

    def _repr_svg_(self) -> str:
        return self.svg


class Machine:
    """An explicit labelled transition system. States are numbered from 0 in the order of discovery.

    Attributes:
        states: how many states there are.
        transitions: how many transitions there are.
        alphabet: the events that occur, in the order of declaration; ``tau`` and ``tick`` first.
        initial: the number of the initial state.
    """

    def __init__(self, machine: Lts, events: EventTable, drawn: Callable[[], str | None] = lambda: None) -> None:
        self._machine = machine
        self._drawn = drawn
        self._names = {label: events.name(label) for label in machine.alphabet()}
        self.states = machine.states
        self.transitions = machine.transitions
        self.alphabet = tuple(self._names.values())
        self.initial = machine.root

    def __repr__(self) -> str:
        return f"<cspcheck.Machine with {self.states} states and {self.transitions} transitions>"

    def _repr_svg_(self) -> str | None:
        return self._drawn()

    def successors(self, state: int) -> list[tuple[str, int]]:
        """The (event, state) pairs that a state can go on with, in order of event and state.

        Raises:
            IndexError: there is no state with this number.
        """
        if not 0 <= state < self.states:
            raise IndexError(f"there is no state {state}, only 0 to {self.states - 1}")
        return [(self._names[label], target) for label, target in self._machine.successors(state)]

    def edges(self) -> Iterator[tuple[int, str, int]]:
        """All transitions as (state, event, state), in order."""
        for state in range(self.states):
            for event, target in self.successors(state):
                yield state, event, target

    def to_networkx(self) -> networkx.MultiDiGraph[int]:
        """The machine as a graph: nodes are state numbers, edges have the attribute ``event``.

        The graph has the attribute ``initial``.
        """
        import networkx

        graph: networkx.MultiDiGraph[int] = networkx.MultiDiGraph(initial=self.initial)
        graph.add_nodes_from(range(self.states))
        graph.add_edges_from((source, target, {"event": event}) for source, event, target in self.edges())
        return graph


def _positive(name: str, value: N | None) -> N | None:
    if value is None:
        return None
    # Numbers of numpy are numbers, too.
    kind: type = Real if name == "timeout" else Integral
    if not isinstance(value, kind) or isinstance(value, bool):
        raise TypeError(f"{name} must be a number, not {value!r}")
    if not value > 0:
        raise ValueError(f"{name} must be above zero, not {value}")
    return value


def _text(name: str, text: str) -> str:
    if not isinstance(text, str):
        raise TypeError(f"the {name} must be text, not {text!r}")
    return text


__all__ = ["Machine", "Process", "Result", "Script", "ScriptError", "load", "loads"]
