"""The process of a class is the one that its definition says: found by equations, held against brute force."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import Any

import pytest
from hypothesis import event, given, settings, strategies as st

from cspcheck.checker.check import Checker
from cspcheck.checker.proof.answer import specification_of
from cspcheck.checker.semantics.transitions import explore
from cspcheck.checker.verdict import Limits, Verdict
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.process import terms as process
from cspcheck.cspm.process.construction import external_choice, prefix
from cspcheck.cspm.process.definitions import Definition
from cspcheck.cspm.process.terms import Process, Reference
from cspcheck.cspm.script import Script
from tests.cspm.oz.asking import outcome, script
from tests.cspm.oz.naive import interpret
from tests.examples import examples


def states(loaded: Script, text: str) -> int:
    """How many states the machine of a process has."""
    return explore(loaded.process(text), Limits(states=10_000)).lts.states


# --- brute force -----------------------------------------------------------------------------------------------------

CONJUNCTS = [
    "n' = n + 1",
    "n' = x?",
    "n' + m' = n + m",
    "m' = n and n' = m",
    "x? < n",
    "n = 0 => n' = 2",
    "n' = 0 or n' = n",
    "y! = n",
    "y! <= x?",
    "y! + n' = 2",
    "m' /= m",
    "if n = x? then n' = 0 else n' = m",
    "exists k : 0..2 @ n' = k and m' < k",
    "forall k : 0..2 | k < n' @ k < x?",
    "m' in {n, x?}",
    "n > 0 <=> n' = 0",
    "not (n' = n and y! = m)",
    "s' = 2",
]
INVARIANTS = ["n + m <= 3", "s = n + m", "n /= 1 or m = 0"]
GUARDS = ["n > 0", "x? <= n", "m = x? or n = 2"]


@st.composite
def classes(draw: st.DrawFn) -> str:
    """A class with two operations over small sets."""
    invariant = draw(st.lists(st.sampled_from(INVARIANTS), max_size=2, unique=True))
    initial = draw(st.sampled_from(["n = 0", "n = m", "n + m = 2", "m = 0 and n > 0"]))
    lines = ["class C", "  chan a, b : [x? : 0..2; y! : 0..2]", "  chan c : [i : 0..1]", "  state n, m : 0..2"]
    lines += ["    Delta s : 1..2"]
    lines += [f"    where {' and '.join(invariant)}"] if invariant else []
    lines += [f"  init {initial}"]
    parameters = "x? : 0..2; y! : 0..2"
    for name in ("a", "b"):
        effect = " and ".join(draw(st.lists(st.sampled_from(CONJUNCTS), min_size=1, max_size=3, unique=True)))
        if draw(st.booleans()):
            lines += [f"  op com_{name} Delta(n, m) {parameters} where {effect}"]
        else:
            lines += [f"  op enable_{name} x? : 0..2 where {draw(st.sampled_from(GUARDS))}"]
            lines += [f"  op effect_{name} Delta(n, m) {parameters} where {effect}"]
    lines += ["  op com_c Delta(m) i : 0..1 where m' = n * i", "end"]
    return "\n".join(lines)


class BruteForce:
    """The process of a class by its definition: every combination of values is tried."""

    def __init__(self, loaded: Script, *, angelic: bool) -> None:
        self.specification = specification_of(loaded)
        self.model = self.specification.classes["C"]
        self.events = loaded.events
        self.angelic = angelic
        self.variables = (*self.model.primary, *self.model.secondary)
        self.names = [v.name for v in self.variables]
        self.space = [s for s in product(*[_range(v.carrier) for v in self.variables]) if self.valid(s)]

    def valid(self, state: tuple[int, ...]) -> bool:
        env = {(name, "before"): value for name, value in zip(self.names, state, strict=True)}
        return all(interpret(term, env) for term in self.model.invariant)

    def initial(self) -> list[tuple[int, ...]]:
        found = []
        for state in self.space:
            env = {(name, "before"): value for name, value in zip(self.names, state, strict=True)}
            if all(interpret(term, env) for term in self.model.initial or ()):
                found.append(state)
        return found

    def process(self) -> Process:
        return process.InternalChoice(tuple(map(self.reference, self.initial())))

    def reference(self, state: tuple[int, ...]) -> Process:
        return Reference(("brute force", id(self), state), Definition(str(state), None, lambda: self.body(state)))

    def body(self, state: tuple[int, ...]) -> Process:
        return external_choice(
            offer for operation in self.model.operations.values() for offer in self.offers(state, operation)
        )

    def offers(self, state: tuple[int, ...], operation: core.Operation) -> Iterator[Process]:
        parameters = self.model.channels[operation.name].parameters
        inputs = [p for p in parameters if p.kind != "output"]
        outputs = [p for p in parameters if p.kind == "output"]
        (channel,) = [c for c in self.events.channels if c.name == operation.name]
        for chosen in product(*[_range(p.carrier) for p in inputs]):
            env = {(name, "before"): value for name, value in zip(self.names, state, strict=True)}
            env |= {(p.name, p.kind): value for p, value in zip(inputs, chosen, strict=True)}
            if not all(interpret(term, env) for term in operation.guard):
                continue
            choices = {}
            for out in product(*[_range(p.carrier) for p in outputs]):
                full = env | {(p.name, p.kind): value for p, value in zip(outputs, out, strict=True)}
                after = [s for s in self.space if self.step(state, s, full, operation)]
                fields = [full[p.name, p.kind] for p in parameters]
                number = self.events.event(channel, fields)
                if after:
                    choices[number] = process.InternalChoice(tuple(map(self.reference, after)))
                elif operation.form in ("guarded", "effect"):
                    choices.setdefault(number, process.DIV)
            if operation.form in ("guarded", "effect"):
                choices = {n: p for n, p in choices.items() if p is not process.DIV} or choices
            offers = [prefix(number, after) for number, after in choices.items()]
            if offers:
                yield external_choice(offers) if self.angelic else process.InternalChoice(tuple(offers))

    def step(
        self, before: tuple[int, ...], after: tuple[int, ...], env: dict[Any, int], operation: core.Operation
    ) -> bool:
        for variable, old, new in zip(self.variables, before, after, strict=True):
            if old != new and variable in self.model.primary and variable.name not in operation.delta:
                return False
        full = env | {(name, "after"): value for name, value in zip(self.names, after, strict=True)}
        return all(interpret(term, full) for term in operation.effect)


def _range(carrier: core.Term) -> range:
    low, high = (interpret(operand, {}) for operand in carrier.operands)  # type: ignore[attr-defined]
    return range(low, high + 1)


@settings(max_examples=examples(4))
@given(classes(), st.booleans())
def test_the_process_of_a_class_is_that_of_its_definition(text: str, angelic: bool) -> None:
    loaded = script(text, outputs="angelic" if angelic else "demonic")
    expected = BruteForce(loaded, angelic=angelic)
    checker = Checker(loaded)
    if not expected.initial():
        event("no initial state")
        with pytest.raises(ScriptError, match="CSP684"):
            explore(loaded.process("C"))
        return
    found, reference = loaded.process("C"), expected.process()

    assert checker.check_refinement(reference, "FD", found).verdict is Verdict.PASS, text
    assert checker.check_refinement(found, "FD", reference).verdict is Verdict.PASS, text


# --- the parts of the semantics, one by one --------------------------------------------------------------------------

COUNTER = """
class Counter
  chan inc, dec
  chan get : [v! : nat]
  state n : nat
  init n = 0
  op com_inc Delta(n) where n < 4 and n' = n + 1
  op com_dec Delta(n) where n > 0 and n' = n - 1
  op com_get v! : nat where v! = n
end
"""


def test_a_class_bounded_by_its_own_predicates_needs_no_reading() -> None:
    loaded = script(COUNTER)

    assert states(loaded, "Counter") == 5
    assert outcome(COUNTER, "Counter :[deadlock free [FD]]") == ("pass", None)
    assert loaded.readings(loaded.assertion("Counter :[deterministic]").node) == ()


def test_an_operation_is_refused_outside_its_precondition() -> None:
    assert outcome(COUNTER, "Counter :[has trace]: <inc, dec>")[0] == "pass"
    assert outcome(COUNTER, "Counter :[has trace]: <dec>")[0] == "fail"
    assert outcome(COUNTER, "Counter :[has trace]: <inc, get.1>")[0] == "pass"
    assert outcome(COUNTER, "Counter :[has trace]: <inc, get.0>")[0] == "fail"


OUTPUT = """
class Dice
  chan roll : [v! : 1..3]
  state n : 0..1
  init n = 0
  op com_roll v! : 1..3 where v! > n
end
Fair = roll?v -> Fair
"""


def test_outputs_are_chosen_by_the_class_unless_they_are_angelic() -> None:
    assert outcome(OUTPUT, "Fair [FD= Dice")[0] == "fail"
    assert outcome(OUTPUT, "Dice [FD= Fair")[0] == "pass"
    assert outcome(OUTPUT, "Fair [FD= Dice", outputs="angelic")[0] == "pass"


GUARDED = """
class G
  chan a
  chan b : [x? : 0..2]
  state n : 0..2
  init n = 2
  op enable_a where n > 0
  op effect_a Delta(n) where n > 1 and n' = n - 1
  op effect_b Delta(n) x? : 0..2 where x? > 0 and n' = x?
end
"""


def test_a_guard_with_an_impossible_effect_diverges_when_performed() -> None:
    assert outcome(GUARDED, "G :[has trace]: <a, a>")[0] == "pass"
    assert outcome(GUARDED, "G :[divergence free]")[0] == "fail"
    assert outcome(GUARDED, "G [| {| a, b |} |] (a -> STOP) :[divergence free]")[0] == "pass"
    assert outcome(GUARDED, "G [| {| a, b |} |] (a -> a -> STOP) :[divergence free]")[0] == "fail"


def test_an_effect_without_a_guard_is_always_enabled() -> None:
    assert outcome(GUARDED, "G [| {| a, b |} |] (b!1 -> STOP) :[divergence free]")[0] == "pass"
    assert outcome(GUARDED, "G [| {| a, b |} |] (b!0 -> STOP) :[divergence free]")[0] == "fail"


def test_a_class_without_an_initial_state_has_no_process() -> None:
    with pytest.raises(ScriptError) as error:
        explore(
            script(
                "class C\n  chan a\n  state n : 0..3 where n < 2\n  init n = 3\n  op com_a where n > 0\nend"
            ).process("C")
        )

    assert error.value.diagnostics[0].message == "class `C` has no initial state"


# --- leaving the finite readings -------------------------------------------------------------------------------------

UNBOUNDED = "reading nat = 0..3\n" + COUNTER.replace("n < 4 and ", "")
LEAVES = "`inc` of class `Counter` leads to n' = 4, outside the reading `nat = 0..3`"


def test_leaving_a_reading_is_reported_and_decides_nothing() -> None:
    for claim in ("Counter :[divergence free]", "Counter :[deterministic]"):
        assert outcome(UNBOUNDED, claim) == ("unknown", LEAVES)
    assert outcome(UNBOUNDED, "Counter :[deadlock free]") == ("pass", None)  # it is proved for all values
    assert outcome(UNBOUNDED, "RUN({| inc, dec, get |}) [T= Counter") == ("unknown", LEAVES)
    assert outcome(UNBOUNDED, "Counter :[has trace]: <inc, inc, inc, inc, inc>") == ("unknown", LEAVES)


def test_what_a_class_did_before_it_left_its_reading_it_can_do() -> None:
    assert outcome(UNBOUNDED, "Counter :[has trace]: <inc, inc, dec>")[0] == "pass"
    assert outcome(UNBOUNDED, "RUN({| inc |}) [T= Counter")[0] == "fail"
    assert outcome(UNBOUNDED, "Counter [T= STOP")[0] == "pass"
    assert outcome(UNBOUNDED, "Counter [FD= inc -> STOP") == ("unknown", LEAVES)


def test_what_a_composition_prevents_from_leaving_does_not_leave() -> None:
    held = UNBOUNDED + "Twice = inc -> inc -> dec -> dec -> Twice\n"

    assert outcome(held, "Counter [| {| inc, dec |} |] Twice :[deadlock free]") == ("pass", None)
    assert outcome(held, "(Counter [| {| inc, dec |} |] STOP) \\ {| get |} :[deadlock free [F]]")[0] == "pass"


def test_a_real_deadlock_is_one_though_the_class_could_leave_its_reading_elsewhere() -> None:
    assert outcome(UNBOUNDED, "Counter [| {| inc, dec, get |} |] (inc -> STOP) :[deadlock free]")[0] == "fail"


def test_an_output_outside_the_reading_is_reported() -> None:
    text = """
reading nat = 0..3
class Doubler
  chan twice : [v! : nat]
  state n : 0..2
  init n = 2
  op com_twice v! : nat where v! = n + n
end
"""
    assert outcome(text, "Doubler :[divergence free]") == (
        "unknown",
        "`twice` of class `Doubler` has v! = 4, outside the reading of its channel",
    )


def test_nothing_is_refused_because_a_reading_was_too_small_for_a_choice() -> None:
    text = """
reading nat = 0..3
class Grow
  chan more
  state n : nat
  init n = 0
  op com_more Delta(n) where n' > n
end
"""
    verdict, reason = outcome(text, "Grow :[divergence free]")

    assert verdict == "unknown"
    assert reason is not None
    assert "has no `n'` within the reading" in reason


def test_what_bounds_a_choice_by_itself_is_no_reading() -> None:
    """`n' < n` has finitely many solutions among the naturals: at 0 there is none, whatever the reading."""
    text = """
reading nat = 0..3
class Shrink
  chan less
  state n : nat
  init n = 3
  op com_less Delta(n) where n' < n
end
"""
    assert outcome(text, "Shrink :[deadlock free]")[0] == "fail"
    assert outcome(text, "Shrink :[has trace]: <less, less, less>")[0] == "pass"


def test_readings_are_those_of_the_classes_behind_the_assertion() -> None:
    loaded = script(
        "given M, N\nreading M = 2\nreading N = 3\n"
        "class A\n  chan a : [x? : M]\n  op com_a x? : M\nend\n"
        "class B\n  chan b : [x? : N]\n  op com_b x? : N\nend\n"
        "Both = A ||| B\n"
    )

    def readings(assertion: str) -> tuple[str, ...]:
        return loaded.readings(loaded.assertion(assertion).node)

    assert readings("A :[deadlock free]") == ("M = 2",)
    assert readings("B :[deadlock free]") == ("N = 3",)
    assert readings("Both :[deadlock free]") == ("M = 2", "N = 3")
    assert readings("STOP :[deadlock free]") == ()


def test_a_wide_input_without_a_reading_is_refused_with_the_reading_that_would_help() -> None:
    loaded = script(
        "class C\n  chan put : [v? : nat]\n  state n : nat\n  init n = 0\n"
        "  op com_put Delta(n) v? : nat where n' = v?\nend"
    )

    with pytest.raises(ScriptError) as error:
        explore(loaded.process("C"))

    (diagnostic,) = error.value.diagnostics
    assert diagnostic.code == "CSP681"
    assert diagnostic.message == "`v?` can be anything in `nat`, which is not finite"
    assert diagnostic.help == "give it a finite reading: `reading nat = 0..3`"


# --- the CSP part ----------------------------------------------------------------------------------------------------

BUFFER = """
given MESSAGE
reading MESSAGE = 2
class Producer
  chan item : [m! : MESSAGE]
  method make : [m? : MESSAGE]
  main = make -> item -> main
  state buffer : seq MESSAGE
  init buffer = <>
  op com_make Delta(buffer) m? : MESSAGE where buffer' = buffer ^ <m?>
  op com_item Delta(buffer) m! : MESSAGE where buffer = <m!> ^ buffer'
end
class Consumer
  chan item : [m? : MESSAGE]
  main = item -> main
  state last : seq MESSAGE
  init last = <>
  op com_item Delta(last) m? : MESSAGE where last' = <m?>
end
System = Producer || Consumer
"""


def test_main_and_the_data_meet_on_the_events_of_both() -> None:
    """The bare names in `main` mean any values, and the data says which."""
    loaded = script(BUFFER)

    assert states(loaded, "Producer::visible") == 3
    assert outcome(BUFFER, "Producer::visible :[has trace]: <Producer::make.MESSAGE_2, item.MESSAGE_2>")[0] == "pass"
    assert outcome(BUFFER, "Producer::visible :[has trace]: <Producer::make.MESSAGE_2, item.MESSAGE_1>")[0] == "fail"


def test_methods_are_hidden_in_the_class_and_visible_where_asked_for() -> None:
    assert outcome(BUFFER, "Producer :[has trace]: <item.MESSAGE_1, item.MESSAGE_2>")[0] == "pass"
    assert outcome(BUFFER, "item?m -> STOP [T= Producer")[0] == "fail"
    assert outcome(BUFFER, "Producer::visible \\ {| Producer::make |} [FD= Producer")[0] == "pass"


def test_classes_are_joined_on_the_channels_that_they_share() -> None:
    assert outcome(BUFFER, "System :[deadlock free]") == ("pass", None)
    assert outcome(BUFFER, "System [FD= Producer [| {| item |} |] Consumer")[0] == "pass"
    assert outcome(BUFFER + "Third = System || (item?m -> STOP)\n", "Third :[deadlock free]")[0] == "fail"


def test_the_control_view_drops_the_data() -> None:
    control = "view control\n" + BUFFER
    loaded = script(control)

    assert loaded.events.name(loaded.trace("<item>")[0]) == "item", "the event has no fields any more"
    assert states(loaded, "System") == states(loaded, "Producer") == 2
    assert outcome(BUFFER, "Producer :[has trace]: <item>", view="control") == ("pass", None)
    assert outcome(control, "STOP :[deadlock free]", view="data") == ("fail", None)


def test_the_control_view_keeps_what_the_equations_use() -> None:
    text = """
class Relay
  chan take : [n? : 0..2; w? : 0..9]
  chan give : [n! : 0..2]
  main = take?n?w -> give!n -> main
  state last : 0..9
  init last = 0
  op com_take Delta(last) n? : 0..2; w? : 0..9 where last' = w?
end
"""
    loaded = script(text, view="control")

    assert loaded.evaluate("card({| take |})") == 3
    assert loaded.evaluate("card({| give |})") == 1
    assert outcome(text, "Relay :[deadlock free]", view="control")[0] == "pass"


def test_the_control_view_keeps_to_the_declared_sets_of_the_fields_that_are_left() -> None:
    text = """
class Lift
  chan call : [floor : 0..5; load! : 0..9]
  chan open : [floor : 0..5]
  chan stop : [floor : 0..5]
  main = call?f -> main
  state n : 0..5
  init n = 0
  op com_call Delta(n) floor : 1..4; load! : 0..9 where n' = floor
  op enable_open floor : {2, n + 1, 5}
  op effect_open floor : 2..3 where true
  op enable_stop floor : 2..3
  op effect_stop floor : {3} where true
end
class Guest
  chan stop : [floor : 0..2]
  main = stop?f -> main
end
"""

    def possible(process: str, *events: str) -> list[str]:
        return [e for e in events if outcome(text, f"{process} :[has trace]: <{e}>", view="control")[0] == "pass"]

    floors = range(6)
    assert possible("Lift", *[f"call.{n}" for n in floors]) == ["call.1", "call.2", "call.3", "call.4"]
    assert possible("Lift", *[f"stop.{n}" for n in floors]) == ["stop.2", "stop.3"], "outside its effect it diverges"
    assert len(possible("Lift", *[f"open.{n}" for n in floors])) == 6, "what depends on data is open"
    assert possible("Guest", *[f"stop.{n}" for n in floors]) == ["stop.0", "stop.1", "stop.2"]
    assert possible("Lift || Guest", *[f"stop.{n}" for n in floors]) == ["stop.2"]


def test_an_operation_that_main_does_not_mention_can_happen_at_any_time() -> None:
    text = COUNTER.replace("state n", "main = inc -> dec -> main\n  state n")

    assert outcome(text, "Counter :[has trace]: <get.0, inc, get.1, dec>")[0] == "pass"
    assert outcome(text, "Counter :[has trace]: <inc, inc>")[0] == "fail"


def test_a_class_terminates_when_its_main_does() -> None:
    text = COUNTER.replace("state n", "main = inc -> SKIP\n  state n") + "channel end_\n"

    for view in ("data", "control"):
        get = "get.1" if view == "data" else "get"
        assert outcome(text, f"Counter ; end_ -> STOP :[has trace]: <inc, {get}, end_>", view=view)[0] == "pass"
        assert outcome(text, "Counter ; end_ -> STOP :[has trace]: <end_>", view=view)[0] == "fail"
        assert outcome(text, "Counter :[deadlock free]", view=view)[0] == "pass"


# --- inheritance -----------------------------------------------------------------------------------------------------

INHERITED = """
class Periodic
  chan tick
  chan work : [x? : 0..2]
  main = tick -> work -> main
end
class Task
  inherit Periodic
  chan report : [x! : 0..2]
  main = work -> report -> main
  state n : 0..2
  init n = 0
  op com_work Delta(n) x? : 0..2 where n' = x?
  op com_report x! : 0..2 where x! = n
end
class Twice
  inherit Task[run/work]
end
"""


def test_inherited_process_equations_run_beside_the_own_ones() -> None:
    assert outcome(INHERITED, "Task :[has trace]: <tick, work.2, tick, report.2, work.1>")[0] == "pass"
    assert outcome(INHERITED, "Task :[has trace]: <tick, work.2, tick, work.1>")[0] == "fail"
    assert outcome(INHERITED, "Task :[has trace]: <work.1>")[0] == "fail"


def test_a_renamed_method_of_a_parent_is_called_so_in_the_child() -> None:
    assert outcome(INHERITED, "Twice :[has trace]: <tick, run.2, report.2>")[0] == "pass"


def test_whether_a_subclass_refines_its_parent_is_asked_like_any_refinement() -> None:
    assert outcome(INHERITED, "Periodic [T= Task \\ {| report |}")[0] == "pass"
    assert outcome(INHERITED, "Periodic [FD= Task \\ {| report |}")[0] == "pass"
    assert outcome(INHERITED, "Task [FD= Periodic")[0] == "fail"
