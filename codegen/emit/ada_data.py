"""The data of classes in Ada 2012: a record with its invariant, a procedure an operation with its contract.

Ranges become subtypes, the invariant the predicate of the record, INIT and the operations ``Pre`` and ``Post`` in the
subset that SPARK proves about. The bodies are made of the equations of the predicates. A class in which something is
left open, or has no counterpart, is passed over with the reason: its task runs the states of its process all the same.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping
from dataclasses import dataclass

from cspcheck.codegen.design.predicates import Way, ways
from cspcheck.codegen.design.system import System, SystemTask, value_name
from cspcheck.codegen.emit.ada_methods import filled
from cspcheck.codegen.emit.ada_terms import AdaTerms, NoCounterpart, bare
from cspcheck.codegen.quoting import ada_name, c_comment
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.classes import context_of
from cspcheck.cspm.oz.processes.nodes import CarrierSet
from cspcheck.cspm.oz.values.evaluation import TermEvaluator
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.oz.values.terms import primed, shape, show_term
from cspcheck.cspm.script import Script
from cspcheck.cspm.values.failure import Failure

_QUIET = (
    "   --  A predicate may say what its types say, too, or nothing of a parameter.",
    '   pragma Warnings (Off, "condition can only be *");',
    '   pragma Warnings (Off, "condition is always *");',
    '   pragma Warnings (Off, "formal parameter * is not referenced");',
)
_MOST_INTEGER = 2**31 - 1


@dataclass(frozen=True)
class AdaOperation:
    """A procedure: the channel of the class, its name, and the modes and types of what it takes after the state."""

    channel: str
    name: str
    changes: bool
    parameters: tuple[tuple[str, str, str], ...]


@dataclass(frozen=True)
class AdaClass:
    """The package of a class: its name, its two files, and its operations by the channels of their events."""

    package: str
    spec: str
    body: str
    operations: Mapping[str, AdaOperation]


class AdaData:
    """The data of the classes of a script.

    Attributes:
        types: the declarations of types that the packages share, in order.
    """

    def __init__(self, script: Script, unique: Callable[[str], str]) -> None:
        self._unique = unique
        self._types: dict[object, str] = {}
        self.types: list[str] = []
        self._enumerations: dict[core.Type, str | None] = {}
        context = None if script.classes is None else context_of(script)
        self._context = None if context is None or context.control else context
        self._named: dict[object, str] = {}
        for name, symbol in script.names.top_level.items():
            body = getattr(symbol.declaration, "body", None)
            if isinstance(body, CarrierSet):
                self._named.update({shape(carrier): name for carrier in body.carriers})

    def model(self, definition: str) -> core.ClassModel | None:
        """The class of a task, if it is one that has data."""
        if self._context is None:
            return None
        model = self._context.specification.classes.get(definition)
        return model if model is not None and (model.primary or model.secondary) else None

    def design(self, model: core.ClassModel) -> AdaClass:
        """The package of a class.

        Raises:
            NoCounterpart: something in it is left open or has none.
        """
        assert self._context is not None
        if model.generics:
            raise NoCounterpart("a generic class")
        return _Package(self, model, self._context.evaluator(model.name)).made()

    # --- types -----------------------------------------------------------------------------------------------

    def enumeration(self, type_: core.Type) -> str | None:
        """The type of the constants of a given or free type; None if it has others."""
        if isinstance(type_, core.BoolType):
            return "Boolean"
        if not isinstance(type_, (core.GivenType, core.FreeType)) or self._context is None:
            return None
        if type_ not in self._enumerations:
            definition = self._context.specification.frees.get(type_.name)
            if definition is None or any(argument is not None for _, argument in definition.branches):
                self._enumerations[type_] = None
            else:
                name = self._enumerations[type_] = self._unique(ada_name(type_.name))
                literals = ", ".join(ada_name(branch) for branch, _ in definition.branches)
                self.types.append(f"   type {name} is ({literals});")
        return self._enumerations[type_]

    def subtype(self, carrier: core.Term, evaluator: TermEvaluator, called: str) -> str:
        """The subtype of a set of integers, truth values or constants.

        Raises:
            NoCounterpart: the set is none of these.
        """
        key = shape(carrier)
        if key not in self._types:
            self._types[key] = self._subtype(carrier, evaluator, self._named.get(key, called))
        return self._types[key]

    def _subtype(self, carrier: core.Term, evaluator: TermEvaluator, called: str) -> str:
        assert isinstance(carrier.type, core.SetType)
        element = carrier.type.element
        if isinstance(carrier, core.Apply) and carrier.operator in ("Int", "Nat", "Nat1"):
            return {"Int": "Integer", "Nat": "Natural", "Nat1": "Positive"}[carrier.operator]
        if not isinstance(element, core.IntType):
            kind = self.enumeration(element)
            if kind is None or not isinstance(carrier, core.Apply) or carrier.operator not in ("All", "Bool"):
                raise NoCounterpart(show_term(carrier))
            return kind
        try:
            values = sorted(evaluator.enumerate(carrier))
        except Failure:
            raise NoCounterpart(show_term(carrier)) from None
        if not values or abs(values[0]) > _MOST_INTEGER or abs(values[-1]) > _MOST_INTEGER:
            raise NoCounterpart(show_term(carrier))
        name = self._unique(ada_name(called))
        if values[-1] - values[0] + 1 == len(values):
            self.types.append(f"   subtype {name} is Integer range {values[0]} .. {values[-1]};")
        else:
            listed = " | ".join(map(str, values))
            self.types.append(f"   subtype {name} is Integer\n     with Static_Predicate => {name} in {listed};")
        self.types.append(f"   function Is_{name} (Value : Integer) return Boolean is (Value in {name});")
        return name


class _Package:
    def __init__(self, data: AdaData, model: core.ClassModel, evaluator: TermEvaluator) -> None:
        self.data = data
        self.model = model
        self.evaluator = evaluator
        self.name = f"{ada_name(model.name)}_Data"
        self.variables = (*model.primary, *model.secondary)
        taken: set[str] = set()
        self.names: dict[str, str] = {}
        for variable in self.variables:
            name, count = str(ada_name(variable.name)), 2
            while name.lower() in taken:
                name, count = f"{ada_name(variable.name)}_{count}", count + 1
            taken.add(name.lower())
            self.names[variable.name] = name
        self.types = {v.name: data.subtype(v.carrier, evaluator, f"{v.name}_of_{model.name}") for v in self.variables}
        self.parameters: dict[str, str] = {}
        self.types_of: dict[tuple[str, str], str] = {("before", name): kind for name, kind in self.types.items()}
        self.spec: list[str] = []
        self.body: list[str] = []

    def made(self) -> AdaClass:
        """Both files."""
        model = self.model
        if model.invariant:
            heads = "; ".join(f"{self.names[v.name]} : {self._base(v)}" for v in self.variables)
            shown = " and ".join(map(show_term, model.invariant))
            self.spec += [
                f"   --  {c_comment(' '.join(shown.split()))}",
                f"   function Invariant ({heads}) return Boolean is",
                f"     ({bare(self._terms('{}', '{}').all(model.invariant))});",
                "",
            ]
        self.spec += [
            "   type State is record",
            *[f"      {self.names[v.name]} : {self.types[v.name]};" for v in self.variables],
            "   end record",
        ]
        if model.invariant:
            fields = ", ".join(f"State.{self.names[v.name]}" for v in self.variables)
            self.spec.append(f"     with Dynamic_Predicate => Invariant ({fields})")
        self.spec[-1] += ";"
        self.spec.append("")
        self._initial()
        operations: dict[str, AdaOperation] = {}
        for channel in model.channels.values():
            found = self._operation(channel)
            if found is not None:
                operations[channel.name if channel.kind == "chan" else f"{model.name}::{channel.name}"] = found
        uses = "with Data_Types; use Data_Types;\n\n" if self.data.types else ""
        head = f"--  The data of the class {model.name}. Generated by cspcheck gen: do not edit.\n{uses}"
        quiet = ["", *_QUIET, ""]
        spec = [f"{head}package {self.name} with SPARK_Mode is", *quiet, *self.spec, f"end {self.name};", ""]
        body = [f"{head}package body {self.name} with SPARK_Mode is", *quiet, *self.body, f"end {self.name};", ""]
        return AdaClass(self.name, "\n".join(spec), "\n".join(body).replace(uses, ""), operations)

    def _base(self, variable: core.Declared) -> str:
        return "Integer" if isinstance(variable.type, core.IntType) else self.types[variable.name]

    def _terms(self, before: str, after: str) -> AdaTerms:
        """Terms in which the variables before and after are written by a pattern."""

        def variable(found: core.Variable) -> str:
            if found.role in ("before", "after"):
                return (before if found.role == "before" else after).format(self.names[found.name])
            if found.role == "constant":
                try:
                    value = self.evaluator.value(found)
                except Failure:
                    raise NoCounterpart(found.name) from None
                if isinstance(value, bool) or not isinstance(value, int):
                    raise NoCounterpart(found.name)
                return str(value) if value >= 0 else f"({value})"
            if found.name not in self.parameters:
                raise NoCounterpart(found.name)
            return self.parameters[found.name]

        return AdaTerms(variable, self.data.enumeration)

    # --- what happens ----------------------------------------------------------------------------------------

    def _ways(self, predicates: tuple[core.Term, ...], changed: list[str], outputs: list[str], what: str) -> list[Way]:
        wanted = frozenset([("after", name) for name in changed] + [("output", name) for name in outputs])
        found = ways(predicates, wanted)
        if not found:
            raise NoCounterpart(f"{what}, which leaves something open")
        return found

    def _taken(self, way: Way, terms: AdaTerms, changed: list[str]) -> tuple[str, dict[str, str], dict[str, str]]:
        """The condition of a way, and what it gives: after-values of all variables, and outputs."""

        def value_of(variable: core.Variable) -> core.Term | None:
            term = way.values.get((variable.role, variable.name))
            return None if term is None else substituted(term, value_of)

        tests = [terms.text(substituted(test, value_of)) for test in way.tests]
        values: dict[str, str] = {}
        for variable in self.variables:
            if variable.name in changed:
                value = substituted(way.values["after", variable.name], value_of)
                values[variable.name] = terms.text(value)
                test = self._fits(value, values[variable.name], self.types[variable.name])
                tests += [] if test is None else [test]
            else:
                values[variable.name] = f"Self.{self.names[variable.name]}"
        if self.model.invariant and changed:
            tests.append(f"Invariant ({', '.join(values[v.name] for v in self.variables)})")
        given = {
            name: terms.text(substituted(term, value_of))
            for (role, name), term in way.values.items()
            if role == "output"
        }
        return "\n         and then ".join(tests) or "True", values, given

    def _fits(self, term: core.Term, text: str, type_: str) -> str | None:
        """The test whether a value is one of a type; None if it is of it by itself."""
        if not isinstance(term.type, core.IntType) or type_ == "Integer":
            return None
        if isinstance(term, core.Variable) and self.types_of.get((term.role, term.name)) == type_:
            return None
        if type_ in ("Natural", "Positive"):
            return f"({text} >= {0 if type_ == 'Natural' else 1})"
        return f"Is_{type_} ({text})"

    def _aggregate(self, values: Mapping[str, str]) -> str:
        return ", ".join(f"{self.names[name]} => {value}" for name, value in values.items())

    def _initial(self) -> None:
        """INIT as a function."""
        model = self.model
        predicates = tuple(
            primed(term) for term in (*(model.initial or ()), *(model.invariant if model.secondary else ()))
        )
        changed = [variable.name for variable in self.variables]
        found = self._ways(predicates, changed, [], "INIT")
        if len(found) > 1:
            raise NoCounterpart("INIT, which leaves something open")
        _, values, _ = self._taken(found[0], self._terms("{}", "{}"), changed)
        post = bare(self._terms("Initial'Result.{}", "Initial'Result.{}").all(model.initial or ()))
        self.spec += ["   function Initial return State", f"     with Post => {post};", ""]
        self.body += [f"   function Initial return State is ({self._aggregate(values)});", ""]

    def _operation(self, channel: core.Channel) -> AdaOperation | None:
        """A procedure; None where the data has no part in the event."""
        model = self.model
        operation = model.operations.get(channel.name)
        if operation is None:
            return None
        self.parameters = {}
        rows: list[tuple[str, str, str]] = []
        for parameter in channel.parameters:
            name, taken = str(ada_name(parameter.name)), {"self", *[one.lower() for one in self.parameters.values()]}
            while name.lower() in taken:
                name += "_X"
            self.parameters[parameter.name] = name
            kind = self.data.subtype(parameter.carrier, self.evaluator, f"{parameter.name}_of_{model.name}")
            self.types_of[parameter.kind, parameter.name] = kind
            rows.append((name, "out" if parameter.kind == "output" else "in", kind))
        changed = list(operation.delta)
        predicates = operation.effect
        if model.secondary and changed:
            predicates = (*predicates, *[primed(term) for term in model.invariant])
            changed += [variable.name for variable in model.secondary]
        outputs = [parameter.name for parameter in channel.parameters if parameter.kind == "output"]
        if not changed and not outputs and not operation.guard and not operation.effect:
            return None
        name = str(ada_name(channel.name))
        if name.lower() in ("state", "initial", "invariant", "self"):
            name += "_X"
        # What does not change is the same afterwards.
        settled = [v for v in self.variables if v.name not in changed]
        terms = self._terms("Self.{}", "Self.{}")
        found = self._ways(predicates, changed, outputs, f"`{channel.name}`")
        taken_ways = [self._taken(way, terms, changed) for way in found]
        inputs = [(n, t) for n, mode, t in rows if mode == "in"]
        heads = "".join(f"; {n} : {t}" for n, t in inputs)
        guard = [terms.text(term) for term in operation.guard]
        possible = "\n      or else ".join(
            f"({condition})" if len(taken_ways) > 1 else condition for condition, _, _ in taken_ways
        )
        if operation.form != "com":
            allowed = bare("\n      and then ".join(guard) or "True")
        elif guard:
            allowed = "\n      and then ".join([*guard, f"({possible})"])
        else:
            allowed = bare(possible)
        shown = " and ".join(map(show_term, (*operation.guard, *operation.effect))) or "true"
        mode = "in out" if changed else "in"
        parameters = "".join(f"; {n} : {m} {t}" for n, m, t in rows)
        post = self._post(operation, settled if changed else [], bool(changed))
        self.spec += [
            f"   --  {c_comment(' '.join(shown.split()))}",
            f"   function Can_{name} (Self : State{heads}) return Boolean is",
            f"     ({allowed});",
            "",
            f"   procedure {name} (Self : {mode} State{parameters})",
            f"     with Pre  => Can_{name} (Self{''.join(f', {n}' for n, _ in inputs)}),",
            f"          Post => {post};",
            "",
        ]
        self.body += [f"   procedure {name} (Self : {mode} State{parameters}) is", "   begin"]
        for number, (condition, values, given) in enumerate(taken_ways):
            always = condition == "True" and len(taken_ways) == 1
            if not always:
                self.body.append(f"      {'els' if number else ''}if {bare(condition)} then")
            indent = "      " if always else "         "
            self.body += [f"{indent}{self.parameters[one]} := {value};" for one, value in given.items()]
            if changed:
                self.body.append(f"{indent}Self := ({self._aggregate(values)});")
            elif not given:
                self.body.append(f"{indent}null;")
            if not always and number == len(taken_ways) - 1:
                self.body += [
                    "      else",
                    "         raise Program_Error;  --  the precondition says that it is not so",
                    "      end if;",
                ]
        self.body += [f"   end {name};", ""]
        return AdaOperation(channel.name, name, bool(changed), tuple(rows))

    def _post(self, operation: core.Operation, settled: list[core.Declared], changes: bool) -> str:
        before = "Self'Old.{}" if changes else "Self.{}"
        kept = {variable.name for variable in settled}
        terms = self._terms(before, "Self.{}")
        text = terms.all(operation.effect)
        frame = [f"Self.{self.names[name]} = Self'Old.{self.names[name]}" for name in kept]
        return bare("\n         and then ".join(([text] if text != "True" or not frame else []) + frame))


# --- data beside the tasks -----------------------------------------------------------------------------------------


class AdaBeside:
    """The package that keeps the data of each task in step with its events, and holds the two against each other.

    Args:
        system: the program.
        classes: the packages of data by the definition of the task.
        shared: whether they share types.
    """

    def __init__(self, system: System, classes: Mapping[str, AdaClass], shared: bool) -> None:
        self.system = system
        self.classes = classes
        self.shared = shared

    def body(self) -> str:
        """Its body."""
        tasks = [(i, task, self.classes[task.definition]) for i, task in enumerate(self.system.tasks)
                 if task.definition in self.classes]  # fmt: skip
        lines = ["--  Generated by cspcheck gen: do not edit."]
        lines += [f"with {package};" for package in dict.fromkeys(one.package for _, _, one in tasks)]
        lines += ["with Data_Types; use Data_Types;"] if self.shared and tasks else []
        lines += ["", "package body Program_Data is", ""]
        if not tasks:
            lines.append('   pragma Warnings (Off, "formal parameter * is not referenced");')
        for number, task, one in tasks:
            lines += self._task(number, task, one)
        lines += ["   procedure Step (Task_Number : Natural; Event : Event_Index) is", "   begin"]
        if tasks:
            lines += ["      case Task_Number is"]
            lines += [f"         when {number} => Step_{number} (Event);" for number, _, _ in tasks]
            lines += ["         when others => null;", "      end case;"]
        else:
            lines.append("      null;")
        return "\n".join([*lines, "   end Step;", "", "end Program_Data;", ""])

    def _task(self, number: int, task: SystemTask, one: AdaClass) -> Iterable[str]:
        yield f"   --  {c_comment(task.name)}"
        yield f"   Data_{number} : {one.package}.State := {one.package}.Initial;"
        yield ""
        branches: list[str] = []
        states = self.system.machines[task.machine].states
        offered = {self.system.events[event].channel for state in states for event, _ in state.moves}
        for channel in sorted(offered):
            it = self.system.channels[channel]
            operation = one.operations.get(it.name)
            if operation is None or not it.count:
                continue
            last = it.first + it.count - 1
            branches.append(
                f"         when {it.first} .. {last} =>" if it.count > 1 else f"         when {it.first} =>"
            )
            events = self.system.events[it.first : last + 1]
            for field, (_, _, type_) in enumerate(operation.parameters):
                kind = "Integer" if isinstance(events[0].values[field], int) and type_ != "Boolean" else type_
                rows = [f"{it.first + i} => {_value(event.values[field], type_)}" for i, event in enumerate(events)]
                yield f"   Field_{number}_{channel}_{field + 1} : constant array ({it.first} .. {last}) of {kind} :="
                yield f"     ({filled([f'{row},' for row in rows[:-1]] + rows[-1:])});"
                yield ""
            branches += self._call(number, channel, one, operation)
        yield f"   procedure Step_{number} (Event : Event_Index) is"
        yield "   begin"
        yield "      case Event is"
        yield from branches
        yield "         when others => null;"
        yield "      end case;"
        yield f"   end Step_{number};"
        yield ""

    @staticmethod
    def _call(number: int, channel: int, one: AdaClass, operation: AdaOperation) -> Iterable[str]:
        outs = [(i, name, type_) for i, (name, mode, type_) in enumerate(operation.parameters, 1) if mode == "out"]
        arguments = [f"Data_{number}"]
        for i, (name, mode, _) in enumerate(operation.parameters, 1):
            arguments.append(name if mode == "out" else f"Field_{number}_{channel}_{i} (Event)")
        if not outs:
            yield f"            {one.package}.{operation.name} ({', '.join(arguments)});"
            return
        yield "            declare"
        for _, name, type_ in outs:
            yield f"               {name} : {type_};"
        yield "            begin"
        yield f"               {one.package}.{operation.name} ({', '.join(arguments)});"
        tests = " or else ".join(f"{name} /= Field_{number}_{channel}_{i} (Event)" for i, name, _ in outs)
        yield f"               if {tests} then"
        yield '                  raise Program_Error with "the data gives another value than the process";'
        yield "               end if;"
        yield "            end;"


def _value(value: Hashable, type_: str) -> str:
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, int):
        return str(value)
    return f"{type_}'({ada_name(value_name(value))})"


PROGRAM_DATA = """--  The data of the tasks, in step with their events. Generated by cspcheck gen: do not edit.
with Tables; use Tables;

package Program_Data is

   --  A task has performed an event: what its data says of it is held against it
   procedure Step (Task_Number : Natural; Event : Event_Index);

end Program_Data;
"""
