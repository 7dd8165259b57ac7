"""Classes as tasks with data: types of variables, INIT and operations as code, ``main`` as what the task does.

An operation whose predicate gives every after-value and output by equations becomes code that says so, an alternative
at a time. What a predicate leaves open is found by trying all values, or given by a method that a person writes; the
predicate is then what the method's values are held against.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from cspcheck.codegen import messages
from cspcheck.codegen.design.data import DataDesigner
from cspcheck.codegen.design.expressions import AND, TERNARY
from cspcheck.codegen.design.naming import safe, snake, unique
from cspcheck.codegen.design.pieces import RESERVED as TASK_RESERVED, TextLines
from cspcheck.codegen.design.predicates import Key, TermTranslator, keys_in, ways
from cspcheck.codegen.quoting import literal, phrase
from cspcheck.cspm.diagnostics import ScriptError
from cspcheck.cspm.oz import core
from cspcheck.cspm.oz.processes.classes import context_of
from cspcheck.cspm.oz.processes.nodes import CarrierSet
from cspcheck.cspm.oz.values.evaluation import TermEvaluator
from cspcheck.cspm.oz.values.substitution import substituted
from cspcheck.cspm.oz.values.terms import primed, shape, show_term
from cspcheck.cspm.script import Script
from cspcheck.cspm.values.failure import Failure

RESERVED = frozenset(
    {"initial", "invariant", "allows", "assignments", "anything", "snapshot", "restore", "after", "self"}
)
"""Names that the data of a class uses for itself."""
_KINDS = {"input": "?", "output": "!", "simple": "."}


@dataclass(frozen=True)
class OperationDesign:
    """An operation.

    Attributes:
        channel: by the name that its events have.
        method: the name of its outcomes among the methods of the data; None where the data does not restrict it.
        attribute: the name of the operation among those of the task.
        kinds: of its fields.
        guard: the name of its guard among the methods of the data, if it has one.
        gives: the variables that a method written by hand gives; () if the predicate gives all.
        post: the name of its postcondition among the methods of the data.
        parameters: what it gets and gives, with annotations: the fields of its events.
        own: whether it is a method of the class.
        text: the predicate.
    """

    channel: str
    method: str | None
    attribute: str
    kinds: str
    guard: str | None
    gives: tuple[tuple[str, str], ...]
    post: str | None
    parameters: tuple[tuple[str, str], ...]
    own: bool
    text: str


@dataclass(frozen=True)
class ClassDesign:
    """The data of a class: variables with types and annotations, and the lines of its methods."""

    name: str
    variables: tuple[tuple[str, str, str], ...]
    lines: tuple[str, ...]
    operations: tuple[OperationDesign, ...]


class ClassDesigner:
    """Designs the classes of a script."""

    def __init__(self, script: Script, data: DataDesigner) -> None:
        context = context_of(script)
        assert context is not None
        specification = context.specification
        self.script = script
        self.context = context
        self.data = data
        self.specification = specification
        self._named = dict(self._abbreviations())

    def find(self, text: str) -> core.ClassModel | None:
        """The class whose process is called so, with its methods visible or not."""
        return self.context.class_of(text)

    def _abbreviations(self) -> Iterator[tuple[object, str]]:
        """The names of sets, by their shape."""
        for name, symbol in self.script.names.top_level.items():
            body = getattr(symbol.declaration, "body", None)
            if isinstance(body, CarrierSet):
                for carrier in body.carriers:
                    yield shape(carrier), name

    def name_of(self, carrier: core.Term) -> str | None:
        """How the script calls a set."""
        named = self._named.get(shape(carrier))
        if named is None and isinstance(carrier, core.Apply) and carrier.operator == "All":
            element = carrier.type.element if isinstance(carrier.type, core.SetType) else None
            return element.name if isinstance(element, (core.GivenType, core.FreeType)) else None
        return named

    # --- types -----------------------------------------------------------------------------------------------

    def carrier(self, term: core.Term, owner: str) -> str:
        """The type of a variable or field, from the set that its values are taken from.

        Raises:
            ScriptError: the set has no counterpart.
        """
        called = self._named.get(shape(term))
        if called is not None:
            return self.data.named_type(called, self._carrier(term, owner, called))
        return self._carrier(term, owner, None)

    def _carrier(self, term: core.Term, owner: str, name: str | None) -> str:
        suffix = "" if name is None else f", {literal(name)}"
        called = "" if name is None else f", name={literal(name)}"
        if isinstance(term, core.Apply):
            match term.operator:
                case "range":
                    low, high = (self._number(operand, owner) for operand in term.operands)
                    self.data.runtime.add("Integers")
                    return f"Integers({low}, {high}{suffix})"
                case "Int" | "Nat" | "Nat1":
                    least = {"Int": "", "Nat": "0", "Nat1": "1"}[term.operator]
                    self.data.runtime.add("Integers")
                    return f"Integers({least}{called if least else called.removeprefix(', ')})"
                case "Real":
                    self.data.runtime.add("Reals")
                    return f"Reals({called.removeprefix(', ')})"
                case "Bool":
                    self.data.runtime.add("BOOLEANS")
                    return "BOOLEANS"
                case "seq":
                    self.data.runtime.add("Sequences")
                    return f"Sequences({self.carrier(term.operands[0], owner)}{called})"
                case "power" | "finset":
                    self.data.runtime.add("Sets")
                    return f"Sets({self.carrier(term.operands[0], owner)}{called})"
                case "cross":
                    self.data.runtime.add("Tuples")
                    return f"Tuples(({', '.join(self.carrier(o, owner) for o in term.operands)}){suffix})"
                case "All":
                    assert isinstance(term.type, core.SetType)
                    element = term.type.element
                    if isinstance(element, (core.GivenType, core.FreeType)):
                        return self.data.datatype(element.name, term.span)
        if isinstance(term.type, core.SetType) and isinstance(term.type.element, core.RealType):
            bounds = self._real_bounds(term)
            if bounds is not None:
                self.data.runtime.add("Reals")
                return f"Reals({bounds[0]}, {bounds[1]}{suffix})"
        listed = self._listed(term, owner)
        if listed is not None:
            return self.data.set_type(listed, name, f"`{show_term(term)}`")
        raise ScriptError(messages.not_generated(f"the type `{show_term(term)}`", term.span))

    def _number(self, term: core.Term, owner: str) -> int:
        value = self._evaluator(owner).value(term)
        assert isinstance(value, int)
        return value

    def _evaluator(self, owner: str) -> TermEvaluator:
        return self.context.evaluator(owner)

    def _listed(self, term: core.Term, owner: str) -> tuple[int, ...] | None:
        """The values of a finite set of integers."""
        if not isinstance(term.type, core.SetType) or not isinstance(term.type.element, core.IntType):
            return None
        try:
            values = self._evaluator(owner).enumerate(term)
        except Failure:
            return None  # not finite, or not to be listed: no range to hold values against
        return tuple(sorted(values))

    def _real_bounds(self, term: core.Term) -> tuple[float, float] | None:
        """The bounds of ``{x : real | a <= x <= b}``."""
        if not isinstance(term, core.Comprehension) or len(term.binders) != 1:
            return None
        low, high = float("-inf"), float("inf")
        name = term.binders[0].name
        todo = [term.condition]
        while todo:
            one = todo.pop()
            if not isinstance(one, core.Apply):
                return None
            if one.operator == "and":
                todo += one.operands
                continue
            if one.operator != "at_most":
                return None
            left, right = (_real(operand) for operand in one.operands)
            if right is not None and isinstance(one.operands[0], core.Variable) and one.operands[0].name == name:
                high = right
            elif left is not None and isinstance(one.operands[1], core.Variable) and one.operands[1].name == name:
                low = left
            else:
                return None
        return low, high

    def annotation(self, type_: core.Type) -> str:
        """What a Python annotation says of a type."""
        match type_:
            case core.BoolType():
                return "bool"
            case core.IntType():
                return "int"
            case core.RealType():
                return "float"
            case core.GivenType() | core.FreeType():
                return self.data.datatype_annotation(type_.name)
            case core.TupleType():
                return f"tuple[{', '.join(map(self.annotation, type_.items))}]"
            case core.SetType():
                return f"frozenset[{self.annotation(type_.element)}]"
            case core.SequenceType():
                return f"tuple[{self.annotation(type_.element)}, ...]"
        return "Any"

    # --- classes ---------------------------------------------------------------------------------------------

    def design(self, model: core.ClassModel) -> ClassDesign:
        """The data of a class.

        Raises:
            ScriptError: something in it has no counterpart.
        """
        if model.generics:
            raise ScriptError(messages.not_generated(f"the generic class `{model.name}`", model.span))
        return _ClassDesigner(self, model).design()


class _ClassDesigner:
    def __init__(self, classes: ClassDesigner, model: core.ClassModel) -> None:
        self.classes = classes
        self.model = model
        taken: set[str] = set(RESERVED)
        self.names: dict[str, str] = {}
        for variable in (*model.primary, *model.secondary):
            name = unique(snake(variable.name), taken)
            taken.add(name)
            self.names[variable.name] = name
        self.taken = taken
        self.attributes = set(TASK_RESERVED) | {"act", "begin_data", "change", "data", "do"}
        self.out = TextLines()
        self.parameters: dict[str, str] = {}
        self.changed: frozenset[str] = frozenset()
        """The variables that have another value afterwards."""

    def terms(self, *, after: str = "after.") -> TermTranslator:
        """The translation of terms inside a method of the data."""

        def variable(found: core.Variable) -> str:
            if found.role == "before":
                return f"self.{self.names[found.name]}"
            if found.role == "after" and found.name not in self.changed:
                return f"self.{self.names[found.name]}"
            if found.role == "after":
                return f"{after}{self.names[found.name]}"
            if found.role == "constant":
                return self.classes.data.oz_constant(self.model.name, found.name, found.span)
            return self.parameters.get(found.name, safe(found.name))

        data = self.classes.data
        return TermTranslator(variable, data.construct, data.everything)

    def design(self) -> ClassDesign:
        model, classes = self.model, self.classes
        variables = tuple(
            (self.names[v.name], classes.carrier(v.carrier, model.name), classes.annotation(v.type))
            for v in (*model.primary, *model.secondary)
        )
        if model.invariant:
            text = self._all(model.invariant)
            self.out.add("")
            with self.out.block("def invariant(self) -> bool:"):
                self.out.add(_doc(model.invariant), f"return {text}")
        self._initial()
        operations = tuple([self._operation(channel) for channel in model.channels.values()])
        return ClassDesign(model.name, variables, tuple(self.out.lines), operations)

    def _all(self, predicates: tuple[core.Term, ...]) -> str:
        """That all of some predicates hold."""
        if len(predicates) == 1:
            return self.terms().text(predicates[0])
        return " and ".join(self.terms().text(term, AND) for term in predicates) or "True"

    def _initial(self) -> None:
        """INIT: like an operation that gives all variables their values."""
        model = self.model
        if not self.names:
            return
        predicates = tuple(primed(term) for term in model.initial or ())
        if model.secondary:
            predicates += tuple(primed(term) for term in model.invariant)
        self.changed = frozenset(self.names)
        wanted = frozenset(("after", name) for name in self.names)
        self.out.add("")
        with self.out.block("def initial(self) -> Outcomes:"):
            self.out.add(_doc(model.initial or ()))
            self._outcomes(predicates, wanted, ())

    def _operation(self, channel: core.Channel) -> OperationDesign:
        model, classes = self.model, self.classes
        operation = model.operations.get(channel.name)
        name = f"{model.name}::{channel.name}" if channel.kind != "chan" else channel.name
        notes = [(snake(p.name), classes.annotation(p.type)) for p in channel.parameters]
        kinds = "".join(_KINDS[p.kind] for p in channel.parameters)
        attribute = unique(snake(channel.name), self.attributes)
        self.attributes.add(attribute)
        own = channel.kind == "method"
        if operation is None:
            return OperationDesign(name, None, attribute, kinds, None, (), None, tuple(notes), own, "")
        self.parameters = {}
        used: set[str] = set(RESERVED)
        for parameter in channel.parameters:
            self.parameters[parameter.name] = unique(snake(parameter.name), used)
            used.add(self.parameters[parameter.name])
        notes = [(self.parameters[p.name], note) for p, (_, note) in zip(channel.parameters, notes, strict=True)]
        inputs = [(n, note) for (n, note), kind in zip(notes, kinds, strict=True) if kind != "!"]
        outputs = tuple(p.name for p in channel.parameters if p.kind == "output")
        method = unique(f"com_{snake(channel.name)}", self.taken)
        self.taken.add(method)
        head = "".join(f", {n}: {note}" for n, note in inputs)
        guard = None
        if operation.form != "com":
            guard = unique(f"enable_{snake(channel.name)}", self.taken)
            self.taken.add(guard)
            text = self._all(operation.guard)
            self.out.add("")
            with self.out.block(f"def {guard}(self{head}) -> bool:"):
                self.out.add(_doc(operation.guard), f"return {text}")
        predicates = operation.effect
        changed = [*operation.delta]
        if model.secondary and changed:
            predicates = (*predicates, *[primed(term) for term in model.invariant])
            changed += [variable.name for variable in model.secondary]
        self.changed = frozenset(changed)
        wanted = frozenset([("after", v) for v in changed] + [("output", o) for o in outputs])
        self.out.add("")
        with self.out.block(f"def {method}(self{head}) -> Outcomes:"):
            self.out.add(_doc(operation.effect))
            determined = self._outcomes(predicates, wanted, outputs)
        gives: tuple[tuple[str, str], ...] = ()
        post = None
        if not determined and changed:
            types = {v.name: classes.annotation(v.type) for v in (*model.primary, *model.secondary)}
            gives = tuple((self.names[name], types[name]) for name in changed)
            post = unique(f"post_{snake(channel.name)}", self.taken)
            self.taken.add(post)
            order = [*inputs, *[(n, note) for (n, note), kind in zip(notes, kinds, strict=True) if kind == "!"]]
            whole = "".join(f", {n}: {note}" for n, note in order)
            text = self._all(operation.effect)
            self.out.add("")
            with self.out.block(f"def {post}(self{whole}, after: Any) -> bool:"):
                self.out.add(_doc(operation.effect), f"return {_truth(text)}")
        text = _shown((*operation.guard, *operation.effect))
        return OperationDesign(name, method, attribute, kinds, guard, gives, post, tuple(notes), own, text)

    def _outcomes(self, predicates: tuple[core.Term, ...], wanted: frozenset[Key], outputs: tuple[str, ...]) -> bool:
        """The body of a generator of outcomes; whether equations give them all."""
        out = self.out
        found = ways(predicates, wanted)
        if found is not None:
            for way in found:

                def value_of(variable: core.Variable, way=way) -> core.Term | None:  # type: ignore[no-untyped-def]
                    term: core.Term | None = way.values.get((variable.role, variable.name))
                    return None if term is None else substituted(term, value_of)

                terms = self.terms()
                strength = AND if len(way.tests) > 1 else TERNARY
                tests = [terms.text(substituted(test, value_of), strength) for test in way.tests]
                given = [terms.text(substituted(way.values["output", name], value_of)) for name in outputs]
                after = [
                    f"{literal(self.names[name])}: {terms.text(substituted(term, value_of))}"
                    for (role, name), term in way.values.items()
                    if role == "after"
                ]
                parts = []
                if given:
                    parts.append(f"({', '.join(given)}{',' if len(given) == 1 else ''})")
                if after:
                    parts.append(f"{'' if given else 'after='}{{{', '.join(after)}}}")
                line = f"yield Outcome({', '.join(parts)})"
                if tests:
                    with out.block(f"if {' and '.join(tests)}:"):
                        out.add(line)
                else:
                    out.add(line)
            if not found:
                out.add("yield from ()")
            return True
        self._search(predicates, wanted, outputs)
        return False

    def _search(self, predicates: tuple[core.Term, ...], wanted: frozenset[Key], outputs: tuple[str, ...]) -> None:
        """Outcomes by trying all values of what a predicate leaves open."""
        variables = [self.names[name] for name in self.names if ("after", name) in wanted]
        unknown = [k for p in predicates for k in keys_in(p) if k[0] == "output" and k[1] not in outputs]
        assert not unknown
        text = self._all(predicates) if predicates else None
        heads = []
        for name in outputs:
            parameter = next(
                p for o in self.model.channels.values() for p in o.parameters if p.name == name and p.kind == "output"
            )
            type_ = self.classes.carrier(parameter.carrier, self.model.name)
            heads.append(f"for {self.parameters[name]} in sorted({type_}.all(), key=repr):")
        heads.append(f"for after in self.assignments({', '.join(map(literal, variables))}):")
        given = [self.parameters[name] for name in outputs]
        shown = f"({', '.join(given)}{',' if len(given) == 1 else ''}), " if given else "after="
        line = f"yield Outcome({shown}vars(after))"
        self._nested(heads, None if text is None else f"if {text}:", line)

    def _nested(self, heads: list[str], test: str | None, line: str) -> None:
        if heads:
            with self.out.block(heads[0]):
                self._nested(heads[1:], test, line)
        elif test is not None:
            with self.out.block(test):
                self.out.add(line)
        else:
            self.out.add(line)


def _shown(terms: tuple[core.Term, ...]) -> str:
    text = " and ".join(show_term(term) for term in terms) or "true"
    text = " ".join(text.split())
    return text if len(text) <= 90 else f"{text[:87].rstrip()}..."


def _truth(text: str) -> str:
    """A condition as a truth value; what speaks of after-values has no type of its own."""
    return text if text in ("True", "False") else f"bool({text})"


def _doc(terms: tuple[core.Term, ...]) -> str:
    """A docstring that shows predicates."""
    return f'"""`{phrase(_shown(terms))}`."""'


def _real(term: core.Term) -> float | None:
    if isinstance(term, core.Apply) and term.operator in ("int_to_real", "negate"):
        value = _real(term.operands[0])
        return None if value is None else -value if term.operator == "negate" else value
    return float(term.value) if isinstance(term, core.Constant) else None
