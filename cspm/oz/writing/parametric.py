r"""The data part of a class as one process with the state variables for parameters (Fischer and Wehrheim 1999).

An operation whose inputs i are chosen by the environment, outputs o and after-values a by the class becomes::

    [] i : {i | operation} @ |~| o : {o | operation} @ op.i.o -> |~| a : {a | operation} @ Data(a)

Where equations say what outputs and after-values are, they are written in their places, and where nothing is left to
choose, what remains of the predicate is a guard: ``n < 3 & inc -> Data(n + 1)``.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeGuard

from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.core import Apply, Term, Variable
from cspcheck.cspm.oz.processes.meaning import DataPart, OperationPlan
from cspcheck.cspm.oz.values.solving import SoughtVariable
from cspcheck.cspm.oz.values.terms import conjuncts, free_variables
from cspcheck.cspm.oz.writing.expressions import ExpressionWriter, Key, Unwritable
from cspcheck.cspm.oz.writing.operators_cspm import ATOM
from cspcheck.cspm.values.failure import Failure

_AND = 31
"""How tightly a condition among others has to bind."""


@dataclass
class _Statements:
    """Generators and conditions in order; ``generated`` are the variables that generators give."""

    items: list[str]
    generated: list[Key]

    @property
    def conditions(self) -> bool:
        """Whether there are no generators."""
        return not self.generated


def data_process(
    name: str,
    part: DataPart,
    channel: Callable[[str], str],
    done: str | None,
    expressions: ExpressionWriter,
    state_text: Callable[[Sequence[Any]], list[str]],
) -> tuple[list[str], str]:
    """The definitions of a data part, and the expression for it at its start.

    Args:
        name: what the process is to be called.
        part: the data part.
        channel: how the channel of an operation is called.
        done: the event by which it agrees to terminate.
        expressions: writes the terms of the class.
        state_text: the values of a state.

    Raises:
        Untranslatable: CSPm has no short form for something in it.
    """
    return _Writer(name, part, channel, done, expressions).whole(state_text)


class _Writer:
    def __init__(
        self, name: str, part: DataPart, channel: Callable[[str], str], done: str | None, expressions: ExpressionWriter
    ) -> None:
        self.name = name
        self.part = part
        self.channel = channel
        self.done = done
        self.expressions = expressions

    def whole(self, state_text: Callable[[Sequence[Any]], list[str]]) -> tuple[list[str], str]:
        names = [self.expressions.variable(v.name, "before") for v in self.part.variables]
        for variable in self.part.variables:
            self.expressions.ranging((variable.name, "before"), variable.carrier)
        branches = [self._operation(plan) for plan in self.part.operations]
        if self.done is not None:
            branches.append(f"{self.done} -> SKIP")
        body = (
            "\n  [] ".join(f"({branch})" for branch in branches) if len(branches) > 1 else "".join(branches) or "STOP"
        )
        head = f"{self.name}({', '.join(names)})" if names else self.name
        start = self._start(names, state_text)
        return [*self.expressions.definitions, f"{head} =\n  {body}"], start

    def _start(self, names: Sequence[str], state_text: Callable[[Sequence[Any]], list[str]]) -> str:
        """The choice of the first state."""
        if not names:
            return self.name
        states = self.part.initial_states()[0]
        if len(states) == 1:
            return f"{self.name}({', '.join(state_text(states[0]))})"
        expressions = self.expressions
        expressions.known.clear()
        model = self.part.model
        unknowns = [SoughtVariable(v.name, "before", v.carrier, v.span) for v in self.part.variables]
        found = self._statements(None, unknowns, (*(model.initial or ()), *model.invariant))
        values = [self._known(v.name, "before", 0) for v in self.part.variables]
        pattern = self._pattern(found.generated)
        return f"(|~| {pattern} : {{{pattern} | {', '.join(found.items)}}} @ {self.name}({', '.join(values)}))"

    def _operation(self, plan: OperationPlan) -> str:
        """What an operation offers."""
        outside = dict(self.expressions.known)
        try:
            return self._guarded(plan) if plan.total else self._blocking(plan)
        finally:
            self.expressions.known = outside

    def _blocking(self, plan: OperationPlan) -> str:
        unknowns = [*plan.inputs, *plan.outputs, *plan.ends]
        whole = self._statements(plan, unknowns, plan.predicates)
        inputs = [unknown.key for unknown in plan.inputs]
        if set(whole.generated) <= set(inputs):
            return self._each(whole, f"{self._event(plan)} -> {self._next(plan)}")
        if self.part.angelic:
            inputs += [unknown.key for unknown in plan.outputs]
        chosen = [key for key in whole.generated if key in inputs]
        if chosen:
            generator = f"[] {self._pattern(chosen)} : {{{self._pattern(chosen)} | {', '.join(whole.items)}}} @ "
        else:
            generator = f"not empty({{0 | {', '.join(whole.items)}}}) & "
        self._forget([key for key in (u.key for u in unknowns) if key not in inputs])
        return generator + self._chosen(plan)

    def _guarded(self, plan: OperationPlan) -> str:
        guard = self._statements(plan, plan.inputs, plan.guards)
        before = dict(self.expressions.known)
        effect = self._statements(plan, [*plan.outputs, *plan.ends], plan.predicates)
        self.expressions.known = before
        body = self._chosen(plan)
        if effect.items:
            test = " and ".join(effect.items) if effect.conditions else f"not empty({{0 | {', '.join(effect.items)}}})"
            body = f"if {test} then {body} else {self._diverging(plan)}"
        return self._each(guard, f"({body})" if effect.items else body)

    def _diverging(self, plan: OperationPlan) -> str:
        """The operation is performed and diverges; its outputs are chosen as ever."""
        known = dict(self.expressions.known)
        generators = [(self.expressions.variable(*o.key), self.expressions.values(o.carrier)) for o in plan.outputs]
        sign = "[]" if self.part.angelic else "|~|"
        event = f"{self._event(plan)} -> DIV"
        self.expressions.known = known
        for variable, values in reversed(generators):
            event = f"{sign} {variable} : {values} @ {event}"
        return event

    def _chosen(self, plan: OperationPlan) -> str:
        """Outputs, the event and after-values, inputs being known, where there is an outcome."""
        known = dict(self.expressions.known)
        found = self._statements(plan, [*plan.outputs, *plan.ends], plan.predicates)
        outputs = [unknown.key for unknown in plan.outputs if unknown.key in found.generated]
        choice = ""
        if outputs and not self.part.angelic:
            choice = f"|~| {self._pattern(outputs)} : {{{self._pattern(outputs)} | {', '.join(found.items)}}} @ "
        elif outputs:
            choice = f"[] {self._pattern(outputs)} : {{{self._pattern(outputs)} | {', '.join(found.items)}}} @ "
        kept = {key: self.expressions.known[key] for key in (u.key for u in plan.outputs)}
        event = self._event(plan)
        self.expressions.known = known | kept
        rest = self._statements(plan, plan.ends, plan.predicates)
        ends = [unknown.key for unknown in plan.ends if unknown.key in rest.generated]
        following = self._next(plan)
        if ends:
            values = f"{{{self._pattern(ends)} | {', '.join(rest.items)}}}"
            following = f"(|~| {self._pattern(ends)} : {values} @ {following})"
        return f"{choice}{event} -> {following}"

    def _each(self, statements: _Statements, body: str) -> str:
        """The external choice over what some statements about inputs generate."""
        if statements.conditions:
            return f"{' and '.join(statements.items)} & {body}" if statements.items else body
        pattern = self._pattern(statements.generated)
        if len(statements.items) == 1:
            return f"[] {statements.items[0].replace(' <- ', ' : ', 1)} @ {body}"
        return f"[] {pattern} : {{{pattern} | {', '.join(statements.items)}}} @ {body}"

    def _pattern(self, keys: Sequence[Key]) -> str:
        names = [self.expressions.known[key][0] for key in keys]
        return names[0] if len(names) == 1 else f"({', '.join(names)})"

    def _forget(self, keys: Sequence[Key]) -> None:
        for key in keys:
            self.expressions.known.pop(key, None)

    def _event(self, plan: OperationPlan) -> str:
        fields = [self._known(p.name, p.kind, ATOM) for p in plan.parameters]
        return ".".join([self.channel(plan.operation.name), *fields])

    def _next(self, plan: OperationPlan) -> str:
        changed = {unknown.name for unknown in plan.ends}
        values = [self._known(v.name, "after" if v.name in changed else "before", 0) for v in self.part.variables]
        return f"{self.name}({', '.join(values)})" if values else self.name

    def _known(self, name: str, role: core.Role, at_least: int) -> str:
        text, tight = self.expressions.known[name, role]
        return text if tight >= at_least else f"({text})"

    # --- statements ----------------------------------------------------------------------------------------------

    def _statements(
        self, plan: OperationPlan | None, unknowns: Sequence[SoughtVariable], predicates: Sequence[Term]
    ) -> _Statements:
        """Statements that give the unknowns all values that satisfy the predicates.

        Conditions stand in the order in which they are written, each as soon as what it speaks of is known, equations
        and the ends of sequences are solved, and what nothing gives goes through its carrier.
        """
        expressions = self.expressions
        pending = list(conjuncts(predicates))
        left = {unknown.key: unknown for unknown in unknowns}
        found = _Statements([], [])
        while True:
            progress = False
            for term in list(pending):
                if expressions.is_known(term):
                    said = expressions.text(term, _AND)
                    found.items += [said] if said != "true" else []
                elif not self._solved(plan, term, left, found):
                    continue
                pending.remove(term)
                progress = True
                break
            if progress:
                continue
            unknown = next((u for u in left.values() if expressions.is_known(u.carrier)), None)
            if unknown is None:
                break
            values = self._values(plan, unknown)
            name = expressions.variable(*unknown.key)
            expressions.ranging(unknown.key, unknown.carrier)
            found.items.append(f"{name} <- {values}")
            found.generated.append(unknown.key)
            del left[unknown.key]
        if left or pending:
            raise Unwritable("carriers that depend on each other")
        return found

    def _solved(
        self, plan: OperationPlan | None, term: Term, left: dict[Key, SoughtVariable], found: _Statements
    ) -> bool:
        """Whether an equation gives unknowns their values."""
        if not (isinstance(term, Apply) and term.operator in ("equal", "iff")):
            return False
        for side, other in (term.operands, reversed(term.operands)):
            if not self.expressions.is_known(other):
                continue
            if isinstance(side, Variable) and (side.name, side.role) in left:
                if not self.expressions.is_known(left[side.name, side.role].carrier):
                    continue
                self._define(plan, left.pop((side.name, side.role)), other, found)
                return True
            if self._ends(plan, side, other, left, found):
                return True
        return False

    def _ends(
        self, plan: OperationPlan | None, term: Term, whole: Term, left: dict[Key, SoughtVariable], found: _Statements
    ) -> bool:
        """Whether ``<a, b> ^ s`` or ``s ^ <a, b>``, being *whole*, gives unknowns their values: ends and rest."""
        if not isinstance(whole.type, core.SequenceType):
            return False
        pieces = term.operands if isinstance(term, Apply) and term.operator == "concat" else (term,)
        rests = [place for place, piece in enumerate(pieces) if not _is_display(piece)]
        if len(pieces) > 2 or len(rests) > len(pieces) - 1:
            return False
        display = next(piece for piece in pieces if _is_display(piece))
        elements: list[Term] = [*display.operands, *[pieces[place] for place in rests]]
        keys = [(e.name, e.role) for e in elements if isinstance(e, Variable) and (e.name, e.role) in left]
        known = sum(self.expressions.is_known(element) for element in elements)
        if len(set(keys)) + known < len(elements) or not keys:
            return False
        if not all(self.expressions.is_known(left[key].carrier) for key in keys):
            return False
        backwards = rests == [0]
        end, other = ("last", "front") if backwards else ("head", "tail")
        length = f"#{self.expressions.text(whole, ATOM)}"
        found.items.append(f"{len(display.operands)} {'<=' if rests else '=='} {length}")
        values: list[tuple[Term, Term]] = []
        rest = whole
        element_type = whole.type.element
        for element in reversed(display.operands) if backwards else display.operands:
            values.append((element, Apply(type=element_type, operator=end, operands=(rest,))))
            rest = Apply(type=whole.type, operator=other, operands=(rest,))
        values += [(pieces[place], rest) for place in rests]
        for element, value in values:
            if isinstance(element, Variable) and (element.name, element.role) in left:
                self._define(plan, left.pop((element.name, element.role)), value, found)
            else:
                same = Apply(type=core.BOOL, operator="equal", operands=(element, value))
                found.items.append(self.expressions.text(same, _AND))
        return True

    def _define(self, plan: OperationPlan | None, unknown: SoughtVariable, value: Term, found: _Statements) -> None:
        """An unknown is what a term says, as far as that lies where it has to."""
        expressions = self.expressions
        expressions.known[unknown.key] = expressions.written(value)
        expressions.terms[unknown.key] = value
        inside = Apply(type=core.BOOL, operator="in", operands=(value, unknown.carrier))
        domain = self._domain(plan, unknown)
        if domain is not None or not (expressions.inside(value, unknown.carrier) or expressions.is_true(inside)):
            found.items += expressions.members(expressions.known[unknown.key], unknown.carrier)
        if domain is not None:
            found.items.append(f"member({self._known(*unknown.key, 0)}, {domain})")

    def _values(self, plan: OperationPlan | None, unknown: SoughtVariable) -> str:
        values = self.expressions.values(unknown.carrier)
        domain = self._domain(plan, unknown)
        return values if domain is None else f"inter({values}, {domain})"

    def _domain(self, plan: OperationPlan | None, unknown: SoughtVariable) -> str | None:
        """What the channel carries in a field, where that may be less than what the operation declares."""
        if plan is None:
            return None
        place = next((i for i, p in enumerate(plan.parameters) if (p.name, p.kind) == unknown.key), None)
        domains = self.part.alphabet.values(plan.operation.name)
        if place is None:
            return None
        if domains is None:
            raise Unwritable("a field with infinitely many values")
        carrier = unknown.carrier
        if not free_variables(carrier):
            try:
                inside = set(self.part.evaluator.enumerate(carrier)) <= set(domains[place])
            except Failure as error:
                raise Unwritable("a carrier without a listing") from error
            if inside:
                return None
        set_type = core.SetType(plan.parameters[place].type)
        return self.expressions.value(frozenset(domains[place]), set_type)


def _is_display(term: Term) -> TypeGuard[Apply]:
    return isinstance(term, Apply) and term.operator == "sequence"
